"""A column of a file with all that its place in ``[columns]`` adds to it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from footcal_cli.errors import DataError, UsageError
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.reading import ForeignColumn, Layout, Reading
from footcal_cli.tables.registers import with_high_word
from footcal_cli.tables.units import conversion


def read_place(
    raw: Mapping[str, RawColumn], place: ForeignColumn, reading: Reading, path: Path
) -> RawColumn:
    """A column of the file, with all that its place adds."""
    found = _cell(raw[place.column], place, reading, path)
    if place.only_where:
        found = _only_where(found, raw, place)
    for other, unit in place.plus.items():
        more = _cell(raw[other], place, reading, path)
        found = _plus(found, more, place, (other, unit), path)
    if place.high_word:
        both = (place.column, place.high_word)
        found = with_high_word(found, raw[place.high_word], both, path)
    if place.nanoseconds:
        found = _with_nanoseconds(found, raw[place.nanoseconds], place, path)
    return found


def _held(raw: RawColumn) -> RawColumn:
    """A column whose empty cells mean what stands above them."""
    above = np.maximum.accumulate(np.where(raw.empty, -1, np.arange(len(raw.values))))
    values = raw.values[np.maximum(above, 0)]
    return replace(raw, values=values, empty=above < 0)


def _without_reading(raw: RawColumn, place: ForeignColumn, layout: Layout) -> RawColumn:
    """A column whose cells are empty where they say that there was no reading."""
    if raw.kind == "number":
        words = [_number_of(word) for word in place.missing]
        nothing = raw.empty | np.isin(raw.values, [word for word in words if word is not None])
        values = np.where(nothing, np.nan, raw.values) if nothing.any() else raw.values
        return replace(raw, values=values, empty=nothing)
    said = [str(word).strip() for word in raw.values.tolist()]
    nothing = raw.empty | np.array([word in place.missing for word in said])
    plain = [_plain_number(word, layout) for word in said]
    return replace(raw, values=np.array(plain, dtype=object), empty=nothing)


def _number_of(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None


def _cell(raw: RawColumn, place: ForeignColumn, reading: Reading, path: Path) -> RawColumn:
    """A column of the file, what its pattern finds in each cell, its texts by footcal's names."""
    raw = _held(raw) if place.held else raw
    raw = _without_reading(raw, place, reading.layout) if place.missing else raw
    if raw.kind != "text" or not (place.pattern or place.names):
        return raw
    words: list[object] = []
    looked_for = re.compile(place.pattern) if place.pattern else None
    for at, word in enumerate(raw.values.tolist()):
        if raw.empty[at]:
            words.append(np.nan)
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
            if re.fullmatch(r"[-+]?[\d.,' ]+", said):
                said = _plain_number(said, reading.layout)
        words.append(place.names.get(said, said))
    return replace(raw, values=np.array(words, dtype=object))


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


def _with_nanoseconds(
    whole: RawColumn, rest: RawColumn, place: ForeignColumn, path: Path
) -> RawColumn:
    """Whole seconds and the nanoseconds beside them as one stamp in integer nanoseconds."""
    for raw, column in ((whole, place.column), (rest, place.nanoseconds)):
        if raw.kind != "number" or raw.values.dtype.kind not in "iu":
            raise DataError(
                "holds no whole numbers of seconds or nanoseconds", file=path, column=column,
                remedy="take `nanoseconds` out of [columns]",
            )  # fmt: skip
    stamps = whole.values.astype(np.int64) * 10**9 + rest.values.astype(np.int64)
    return replace(whole, kind="stamp", values=stamps, empty=whole.empty | rest.empty)


def _plus(
    raw: RawColumn, more: RawColumn, place: ForeignColumn, other: tuple[str, str], path: Path
) -> RawColumn:
    """A column with another one, in a unit of its own, on top; an empty cell adds nothing."""
    column, unit = other
    for one, name in ((raw, place.column), (more, column)):
        if one.kind != "number":
            raise DataError("holds no numbers", file=path, column=name,
                            remedy="correct `plus` in [columns]")  # fmt: skip
    change = conversion(unit, place.unit or unit, 1.0)
    added = np.where(more.empty, 0.0, change(more.values.astype(np.float64)))
    values = np.where(raw.empty, 0.0, raw.values.astype(np.float64)) + added
    return replace(raw, values=values, empty=raw.empty & more.empty)


def _only_where(
    raw: RawColumn, columns: Mapping[str, RawColumn], place: ForeignColumn
) -> RawColumn:
    """Numbers that are 0 where another column does not say a certain text."""
    elsewhere = np.zeros(len(raw.values), dtype=bool)
    for name, said in place.only_where.items():
        words = columns[name].values.tolist()
        elsewhere |= np.array([str(word).strip() != said for word in words])
    values = raw.values.copy()
    values[elsewhere] = "0" if raw.kind == "text" else 0
    return replace(raw, values=values, empty=raw.empty & ~elsewhere)
