"""``[columns]`` and ``[[files]]`` of a recipe: where columns stand and how files are written."""

from __future__ import annotations

import codecs
import re
from collections.abc import Mapping
from dataclasses import fields
from typing import Literal, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from footcal_cli.records.models import WRITTEN, Frozen
from footcal_cli.tables.reading import BLANKS, ForeignColumn, Layout, Pivot


@dataclass(frozen=True, config=WRITTEN)
class Place(ForeignColumn):
    """An entry of ``[columns]``: where one of footcal's columns is found.

    Just the name of the file's column, or a table: `column` is its name, `unit` that of its
    numbers, `factor` what they are multiplied by (−1 turns a sign), `format` that of dates as
    strptime has it (``%d.%m.%Y %H:%M:%S.%f``), `pattern` a regular expression whose first group is
    the value in a cell (``Reading: 8347750``) and whose group ``unit``, if any, is that value's own
    unit, `nanoseconds` the column next to whole seconds, `high_word` the high one of two registers
    of 16 bits (Modbus) whose low one is `column`, `over` the column that its numbers are divided by
    (a plate's CoP: ``{ column = "My", over = "Fz", unit = "m", factor = -1.0 }``), `plus`
    other columns that come on top and their units
    (``{ column = "lb", unit = "lb", plus = { oz = "oz" } }``), `minus` the column that is
    taken from it, in the same unit (a zero that was read before each weight), `add` a number in
    `unit` on top of every row (a pan that hangs under all weights), `followed_by` a column whose
    texts stand behind those of `column` (``{ column = "foot", followed_by = "cell" }`` makes
    ``left_1`` of ``left`` and ``1``), `names` translates texts, the joined ones where there are two
    columns,
    `wraps_at` is the number at which a counter begins again from zero (2³² = 4294967296); of a
    cell's counts, the number of codes of a converter whose sign was lost.
    `summed`: each number is what came on top of those above (weights added one by one). `held`: an
    empty cell means what stands above it. `only_where` is for a weight that lies on one cell at a
    time, ``{ loaded_cell = "FL" }``: where that column says something else the number is 0. With
    two columns, ``{ foot = "left", cell = "1" }``, rows that say something else are left out.
    `missing` says what a cell holds where there was no reading (``["-9999"]``; ``[""]`` for an
    empty one or NaN): such rows of a bench log are left out and counted. Instead of `column`, a
    `value` holds for every row, and `file_name` is a regular expression whose first group in the
    file's name does; with a slash in it, in ``folder/file``.
    """

    wraps_at: float | None = Field(default=None, gt=0)

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        sources = (bool(self.column), self.value is not None, self.file_name is not None)
        if sum(sources) != 1:
            raise ValueError("give one of column, value and file_name")
        for text in (self.pattern, self.file_name):
            if text is None:
                continue
            found = _expression(text)
            with_unit = text is self.pattern and found.groupindex.get("unit") == 2
            if found.groups != 1 + with_unit:
                raise ValueError(f"'{text}' needs exactly one group in round brackets")
            if with_unit and self.unit is None:
                raise ValueError("a pattern that finds units needs the unit they become: unit")
        if (self.held or self.only_where or self.missing or self.summed) and not self.column:
            raise ValueError("summed, held, only_where and missing are for a column")
        if self.held and self.missing:
            raise ValueError("an empty cell means what stands above it, or nothing: held, missing")
        if self.high_word and not self.column:
            raise ValueError("high_word stands next to the column of low words")
        if self.followed_by and not self.column:
            raise ValueError("followed_by stands next to the column of what comes first")
        if self.over and not self.column:
            raise ValueError("over stands next to the column that is divided by it")
        if self.nanoseconds and not self.column:
            raise ValueError("nanoseconds stand next to a column of whole seconds")
        if self.minus and not self.column:
            raise ValueError("minus stands next to the column that it is taken from")
        if self.plus and (not self.column or self.unit is None):
            raise ValueError("plus stands next to a column and its unit")
        return self


def _expression(text: str) -> re.Pattern[str]:
    try:
        return re.compile(text)
    except re.error as error:
        raise ValueError(f"'{text}' is no regular expression: {error}") from None


class JoinSpec(Frozen):
    """A file joined to a log: its columns are called ``<file name without suffix>.<column>``.

    `file` lies in the log's folder; its own ``[[files]]`` entry says how it is read. `by` time or
    row; `offset_s` is added to its stamps; `how` fills in between them, no farther than
    `tolerance_s` away and no closer to a stamp than `apart_s` (a load that is still being put on).
    `only_where` leaves out all other rows of the joined file (``{ cell = "A" }``), where it is a
    sheet of several cells and the log is of one.
    """

    file: str
    by: Literal["time", "row"] = "time"
    offset_s: float = 0.0
    how: Literal["interpolate", "nearest", "previous"] = "interpolate"
    tolerance_s: float = Field(default=0.1, gt=0)
    apart_s: float = Field(default=0.0, ge=0)
    only_where: Mapping[str, str] = Field(default_factory=dict)


@dataclass(frozen=True, config=WRITTEN)
class PivotSpec(Pivot):
    """`pivot` of ``[[files]]``: a table with a row for each foot or cell, made one row per sample.

    ``{ by = ["foot"], labels = ["left", "right"], at = "time_ms" }``: the columns `by` name what a
    row is of (their texts joined by ``_``), each of `labels` gets its own columns
    ``<label>.<column>``. Rows belong together by equal stamps in the column `at`, or are
    interpolated between neighbouring rows of their label; without `at` they are numbered in order.
    Labels in `held` were noted when they changed (``["input_number.load"]``): what they say holds
    until their next row.
    """

    by: tuple[str, ...] = Field(min_length=1)
    labels: tuple[str, ...] = Field(min_length=2)


@dataclass(frozen=True, config=WRITTEN)
class FileSpec(Layout):
    """An entry of ``[[files]]``: how the files of one kind are written.

    `match` is a pattern of file names (``press_*.csv``), with a slash in it of ``folder/file``; the
    first entry that matches a log counts.
    `separator` is one character, ``tab`` or ``space`` (any run of blanks); `decimal` a point or a
    comma, `thousands` the sign between groups of three digits; `encoding` that of the text. Lines
    that begin with `comment` are left out, then `skip_rows` lines; a line of names follows unless
    `header` is false; `names` replaces it;
    `skip_below` lines of units and the like stand below it; the table ends above a line that begins
    with `until`. `turned`: the sheet lies on its side, each line begins with its name. `line` is a
    regular expression with named groups for texts without fields: each line it is found in is a
    row; `carried` is one for lines between the rows (``# load 2 kg``) whose groups are columns of
    the rows below; groups called ``added_load`` and ``removed_load`` count a column ``load`` up and
    down, ``zero_load`` makes it 0. `rate_hz` counts rows where there are no stamps. `rows_of` is
    for topics that take turns in one table: rows without a value in this column are left out, and
    the other columns are filled in from their own rows, no farther than 0.1 s away.
    `row_lasts`: each row is the mean of a stance, and stands for so many rows.
    `pivot` turns a table with a row for each foot or cell into one with a row per sample.
    `columns` are the files' own, before ``[columns]``. `wide` makes one row of the file into one
    row per entry, distinguished by the column `wide_into`; with ``wide_into = "reading"`` they are
    readings of one cell, taken one after another in each row. `zeros_where` names rows in which
    the cells carry nothing (``{ stance = "0" }``, or any of ``["air_1", "air_2"]``): the file as
    ``zeros`` of ``[data]`` is these rows, and all others else. `join` brings in columns of other
    files.
    """

    match: str = "*"
    thousands: Literal["", ".", ",", "'", " ", "_", "\u00a0", "\u202f"] = ""
    skip_rows: int = Field(default=0, ge=0)
    skip_below: int = Field(default=0, ge=0)
    row_lasts: int = Field(default=1, ge=1)
    rate_hz: float | None = Field(default=None, gt=0)
    columns: dict[str, Place] = Field(default_factory=dict)
    rows_of: str = ""
    pivot: PivotSpec | None = None
    wide_into: str = "channel"
    wide: dict[str, dict[str, Place]] = Field(default_factory=dict)
    zeros_where: dict[str, str | tuple[str, ...]] = Field(default_factory=dict)
    join: tuple[JoinSpec, ...] = ()

    @model_validator(mode="after")
    def _readable(self) -> Self:
        if len(self.separator) != 1 and self.separator not in _SEPARATORS:
            raise ValueError("separator is one character, 'tab' or 'space'")
        if self.thousands == self.decimal:
            raise ValueError("thousands and decimal are the same character")
        if self.decimal == self.separator:
            raise ValueError("separator and decimal are the same character")
        try:
            codecs.lookup(self.encoding)
        except LookupError:
            raise ValueError(f"no encoding is called '{self.encoding}'") from None
        for text in (self.line, self.carried):
            if text and not _expression(text).groupindex:
                raise ValueError(f"'{text}' has no named group such as (?P<counts>…)")
        return self

    def layout(self) -> Layout:
        """How the text is laid out."""
        own = {field.name: getattr(self, field.name) for field in fields(Layout)}
        return Layout(**own | {"separator": _SEPARATORS.get(self.separator, self.separator)})


_SEPARATORS = {"tab": "\t", "space": BLANKS}


def as_place(value: object) -> object:
    """A bare name written out."""
    return {"column": value} if isinstance(value, str) else value


def as_places(table: object) -> object:
    """A table of places with its bare names written out."""
    return {k: as_place(v) for k, v in table.items()} if isinstance(table, dict) else table


def as_file(entry: object) -> object:
    """Short forms of an entry of ``[[files]]`` written out."""
    if not isinstance(entry, dict):
        return entry
    full = dict(entry)
    if "columns" in full:
        full["columns"] = as_places(full["columns"])
    if isinstance(full.get("wide"), dict):
        full["wide"] = {name: as_places(own) for name, own in full["wide"].items()}
    return full
