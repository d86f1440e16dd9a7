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

    Parameters
    ----------
    column
        Name in the file; empty where the column does not stand in it.
    unit
        Of the file's numbers, the canonical one where absent.
    value
        The same for every row.
    file_name
        Regular expression; what its first group finds in the file's name, for every row. With a
        slash in it: in the name behind that of the file's folder.
    pattern
        Regular expression; what its first group finds in a cell (``Reading: 8347750 g``). A group
        called ``unit`` finds the unit of each number, which is converted to `unit`.
    format
        Of dates and times, as ``strptime`` has it.
    factor
        Numbers are multiplied by it (−1 where a sign is the other way round).
    nanoseconds
        Another column of the file: nanoseconds beside the whole seconds of `column`.
    high_word
        Another column of the file: the high one of two registers of 16 bits, `column` the low one.
    over
        Another column of the file that its numbers are divided by: a moment by a force is a lever.
    plus
        Other columns of the file -> their units: what comes on top (ounces beside pounds).
    wraps_at
        A counter that reaches this number begins again from zero; of a cell's counts, the number
        of codes of a converter whose sign was lost.
    summed
        Each number is what came on top of all above it: their sum is meant.
    names
        Texts of the file -> footcal's.
    held
        An empty cell means what stands above it.
    only_where
        Another column -> its text: in all other rows the number is 0.
    missing
        What a cell holds where there is no value (``-9999``); an empty cell counts as one then.
        Rows of a bench log without it are left out.
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
    plus: Mapping[str, str] = field(default_factory=dict)
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

    Parameters
    ----------
    by
        Columns that name what a row is of, joined by ``_``.
    labels
        The names, in the order of the columns; rows of others are left out.
    at
        The column of stamps; empty where the k-th rows of all labels belong together.
    held
        Labels whose value holds until their next row.
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
    """How the text of a log is laid out.

    Parameters
    ----------
    separator
        One character between fields, or `BLANKS`.
    decimal
        Decimal point or comma.
    thousands
        Sign between groups of three digits; empty for none.
    until
        The table ends above a line that begins so; empty where it ends with the file.
    turned
        Names stand in the first field of each line, a row is a column: the sheet lies on its side.
    encoding
        Of the text.
    comment
        Lines that begin so are left out; empty for none.
    skip_rows
        Lines before the header, comments not counted.
    header
        Whether a line of names follows; without one columns are ``column_1`` ….
    names
        Names in place of the header's.
    skip_below
        Lines between the header and the first row (units).
    line
        Regular expression with named groups: every line that it finds itself in is a row, its
        groups are the columns. For texts without fields; empty for fields.
    carried
        Regular expression with named groups: a line that it finds itself in sets columns that hold
        for the rows below, as a weight typed between the readings does. Groups ``added_load`` and
        ``removed_load`` count the column ``load`` up and down, ``zero_load`` makes it 0.
    pivot
        A row for each foot or cell, turned into one row per sample; None where it is one already.
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
    by
        Row by row, or by time stamps.
    offset_s
        Added to the other file's stamps.
    how
        Between the other file's stamps: straight lines, the nearest or the previous row.
    tolerance_s
        Longest distance to a stamp of the other file; rows farther away have no value.
    apart_s
        Least distance to any of its stamps; rows closer to one have no value.
    """

    path: Path
    reading: Reading
    by: Literal["time", "row"] = "time"
    offset_s: float = 0.0
    how: Literal["interpolate", "nearest", "previous"] = "interpolate"
    tolerance_s: float = 0.1
    apart_s: float = 0.0


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
        The text column that tells the entries of `wide` apart.
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
