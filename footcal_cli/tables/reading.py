"""How a file is to be read: its layout, its columns, what is joined to it. Said by a recipe."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from footcal_cli.tables.plates import Plate
from footcal_cli.tables.world import WorldUp

BLANKS = " "
"""As a separator: any run of spaces and tabs."""


@dataclass(frozen=True)
class ForeignColumn:
    """Where a canonical column is found: ``[columns]`` of a recipe.

    `footcal_cli.recipe.filespecs.Place` says what each field means, and refuses what makes no
    sense. `column` is empty where the column does not stand in the file, `unit` None where the
    file's numbers are in the canonical one.
    """

    column: str = ""
    unit: str | None = None
    value: str | float | None = None
    file_name: str | None = None
    pattern: str | None = None
    format: str | None = None
    factor: float | None = None
    nanoseconds: str = ""
    high_word: str = ""
    over: str = ""
    followed_by: str = ""
    plus: Mapping[str, str] = field(default_factory=dict)
    minus: str = ""
    add: float = 0.0
    wraps_at: float | None = None
    summed: bool = False
    names: Mapping[str, str] = field(default_factory=dict)
    held: bool = False
    only_where: Mapping[str, str] = field(default_factory=dict)
    missing: tuple[str, ...] = ()

    @property
    def in_file(self) -> bool:
        """Whether it is a column of the file."""
        return bool(self.column)


@dataclass(frozen=True)
class Pivot:
    """A row for each foot or cell becomes columns ``<label>.<column>`` of one row per sample.

    `footcal_cli.recipe.filespecs.PivotSpec` says what each field means.
    """

    by: tuple[str, ...]
    labels: tuple[str, ...]
    at: str = ""
    held: tuple[str, ...] = ()

    def parts_of(self, name: str) -> tuple[str, str]:
        """The label of a column of the turned table, empty without one, and the file's column."""
        label = next((x for x in self.labels if name.startswith(f"{x}.")), "")
        return label, name.removeprefix(f"{label}.")


@dataclass(frozen=True)
class Layout:
    """How the text of a log is laid out: ``[[files]]`` of a recipe.

    `footcal_cli.recipe.filespecs.FileSpec` says what each field means. A `separator` is one
    character, or `BLANKS`; without a `header` columns are called ``column_1`` ….
    """

    separator: str = ","
    decimal: Literal[".", ","] = "."
    encoding: str = "utf-8"
    comment: str = ""
    skip_rows: int = 0
    header: bool = True
    names: tuple[str, ...] = ()
    skip_below: int = 0
    line: str = ""
    carried: str = ""
    thousands: str = ""
    until: str = ""
    turned: bool = False
    row_lasts: int = 1
    pivot: Pivot | None = None

    @property
    def plain(self) -> bool:
        """Whether it is a CSV file as footcal reads without further information."""
        return self == Layout()


@dataclass(frozen=True)
class Join:
    """Another file whose columns stand beside a log's own as ``<stem>.<column>``.

    Parameters
    ----------
    path, reading
        The other file and how it is read.
    by, offset_s, how, tolerance_s, apart_s, only_where
        How their rows meet: `footcal_cli.recipe.filespecs.JoinSpec`.
    """

    path: Path
    reading: Reading
    by: Literal["time", "row"] = "time"
    offset_s: float = 0.0
    how: Literal["interpolate", "nearest", "previous"] = "interpolate"
    tolerance_s: float = 0.1
    apart_s: float = 0.0
    only_where: Mapping[str, str] = field(default_factory=dict)


READ_AGAIN = "reading"
"""What the entries of `wide` go into that are readings of one cell under one load."""


@dataclass(frozen=True)
class Reading:
    """Everything a recipe says of one file.

    Parameters
    ----------
    columns
        Canonical name -> where it is found.
    layout
        Of a text file.
    rate_hz
        Rows per second of a file without time stamps.
    wide_into
        The text column that tells the entries of `wide` apart; `READ_AGAIN` where they are readings
        of one cell in one row, which stay next to each other.
    wide
        One row of the file becomes one row per entry: entry -> its own columns.
    joins
        Files beside it.
    rows_of
        A column of the topic whose rows count, where several take turns; empty for all rows.
    plates
        Feet that report force and CoP.
    world_up
        Axis of the log's world that points up.
    zeros_where
        Column -> text, or one of several, of the rows in which the cells carry nothing, and which
        are zeros alone.
    """

    columns: Mapping[str, ForeignColumn] = field(default_factory=dict)
    layout: Layout = Layout()
    rate_hz: float | None = None
    wide_into: str = "channel"
    wide: Mapping[str, Mapping[str, ForeignColumn]] = field(default_factory=dict)
    joins: tuple[Join, ...] = ()
    rows_of: str = ""
    plates: tuple[Plate, ...] = ()
    world_up: WorldUp = "+z"
    zeros_where: Mapping[str, str | tuple[str, ...]] = field(default_factory=dict)
