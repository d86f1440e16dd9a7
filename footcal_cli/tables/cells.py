"""Cells of a column of text as numbers and names: patterns, units beside them, what means nothing.

Room: tables; asked by sources for each column of a file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from footcal_cli.errors import DataError, UsageError, nearest
from footcal_cli.tables.pivot import labels_of
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.reading import ForeignColumn, Layout, Reading
from footcal_cli.tables.units import conversion


def held(raw: RawColumn) -> RawColumn:
    """A column whose empty cells mean what stands above them."""
    above = np.maximum.accumulate(np.where(raw.empty, -1, np.arange(len(raw.values))))
    values = raw.values[np.maximum(above, 0)]
    return replace(raw, values=values, empty=above < 0)


def joined_texts(
    raw: Mapping[str, RawColumn], place: ForeignColumn, path: Path
) -> RawColumn:  # fmt: skip
    """A column, its texts joined by ``_`` to those of the column that `followed_by` names.

    Raises
    ------
    DataError
        The file has no such column.
    """
    first = raw[place.column]
    if not place.followed_by:
        return first
    if place.followed_by not in raw:
        raise DataError(
            f"missing column '{place.followed_by}' that followed_by names"
            f"{nearest(place.followed_by, sorted(raw))}", file=path,
            remedy="correct followed_by in [columns]", foreign=True,
        )  # fmt: skip
    both = [held(c) if place.held else c for c in (first, raw[place.followed_by])]
    empty = both[0].empty | both[1].empty
    return replace(first, kind="text", values=labels_of(both), empty=empty, said=True)


def _without_reading(raw: RawColumn, place: ForeignColumn, layout: Layout) -> RawColumn:
    """A column whose cells are empty where they say that there was no reading."""
    if raw.kind == "number":
        words = [_number_of(word) for word in place.missing]
        nothing = raw.empty | np.isin(raw.values, [word for word in words if word is not None])
        values = np.where(nothing, np.nan, raw.values) if nothing.any() else raw.values
        return replace(raw, values=values, empty=nothing)
    said = [str(word).strip() for word in raw.values.tolist()]
    plain = [_plain_number(word, layout) for word in said]
    silent = [bool({*pair} & {*place.missing}) for pair in zip(said, plain, strict=True)]
    nothing = raw.empty | np.array(silent)
    plain = said if place.names else plain
    return replace(raw, values=np.array(plain, dtype=object), empty=nothing)


def _number_of(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None


def cell_of(raw: RawColumn, place: ForeignColumn, reading: Reading, path: Path) -> RawColumn:
    """A column of the file, what its pattern finds in each cell, its texts by footcal's names."""
    raw = held(raw) if place.held else raw
    raw = _without_reading(raw, place, reading.layout) if place.missing else raw
    spelled = {number: name for name in place.names if (number := _number_of(name)) is not None}
    if raw.kind == "number" and (spelled or "" in place.names):
        raw = _as_text(raw, spelled)
    if raw.kind != "text" or not (place.pattern or place.names):
        return raw
    words: list[object] = []
    looked_for = re.compile(place.pattern) if place.pattern else None
    for at, word in enumerate(raw.values.tolist()):
        if raw.empty[at]:
            words.append(place.names.get("", np.nan))
            continue
        said = str(word).strip()
        if looked_for is not None:
            found = looked_for.search(said)
            if found is None:
                raise DataError(
                    f"does not match the pattern '{place.pattern}'", file=path,
                    column=place.column, row=raw.row(at), value=said,
                    remedy="correct `pattern` in [columns]",
                )  # fmt: skip
            said = found.group(1)
            if place.unit and "unit" in looked_for.groupindex:
                said = _plain_number(said, reading.layout)
                words.append(_in_unit(said, found["unit"] or "", place, raw.row(at), path))
                continue
        if said not in place.names and re.fullmatch(r"[-+]?[\d.,' ]+", said):
            said = _plain_number(said, reading.layout)
            number = _number_of(said)
            said = said if number is None else spelled.get(number, said)
        words.append(place.names.get(said, said))
    empty = np.zeros_like(raw.empty) if "" in place.names else raw.empty
    return replace(raw, values=np.array(words, dtype=object), empty=empty, said=True)


def _as_text(raw: RawColumn, spelled: Mapping[float, str]) -> RawColumn:
    """A column of numbers as texts, each number as one of the names spells it: 0.0 is ``0``."""
    words = [spelled.get(number, f"{number:.17g}") for number in raw.values.tolist()]
    empty = raw.empty | np.isnan(np.asarray(raw.values, dtype=np.float64))
    return replace(raw, kind="text", values=np.array(words, dtype=object), empty=empty)


def _plain_number(said: str, layout: Layout) -> str:
    """A number as it is written in a file, with a decimal point and nothing between thousands."""
    if layout.thousands:
        said = said.replace(layout.thousands, "")
    return said.replace(layout.decimal, ".")


def _in_unit(said: str, unit: str, place: ForeignColumn, row: str, path: Path) -> object:
    """A number with its own unit, in the unit of its column."""
    try:
        value = float(said)
        if unit == "":
            if value != 0.0:
                raise UsageError("a number without a unit", remedy=f"write it in {place.unit}")
            return value
        change = conversion(unit, place.unit or "", 1.0)
        if change.weighed:
            raise UsageError("a mass among forces", remedy="write all of them in one unit")
        return change.slope * value
    except (ValueError, UsageError) as error:
        problem = error.problem if isinstance(error, UsageError) else "not a number"
        raise DataError(
            problem, file=path, column=place.column, row=row, value=f"{said} {unit}".strip(),
            remedy="correct the cell, or `pattern` in [columns]",
        ) from None  # fmt: skip
