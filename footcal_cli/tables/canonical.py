"""One raw column as canonical values: its unit, its sign, its stamps, and what was done to it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.readings import signed
from footcal_cli.errors import UsageError
from footcal_cli.tables.columns import Column
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.reading import ForeignColumn
from footcal_cli.tables.units import NOT_SAID as NOT_SAID
from footcal_cli.tables.units import Conversion, conversion, parse_unit
from footcal_cli.tables.values import durations, numbers, seconds, stamps, texts

READING_UNITS = ("V", "mV", "uV", "mV/V")
"""Units of a cell's reading that is neither counts nor a force; kept as they are."""
_EXAMPLES = {"N": "N, kg, g, lb …", "m": "m, cm, mm …", "N*m": "N*m, N*mm …", "s": "s, ms, us, ns"}


@dataclass(frozen=True)
class ReadColumn:
    """How one column of a file was read.

    Parameters
    ----------
    name, source
        Canonical name, and the file's own.
    unit
        What the file's numbers were taken for, in full; empty for texts and bare numbers.
    canonical_unit
        Unit of the canonical column.
    factor
        Canonical units in one of the file's; None where nothing was multiplied.
    as_written, as_read
        Smallest and largest value before and after; None for texts.
    """

    name: str
    source: str
    unit: str
    canonical_unit: str
    factor: float | None
    as_written: tuple[float, float] | None
    as_read: tuple[float, float] | None


def is_reading(spec: Column) -> bool:
    """Whether a column is the raw reading of a cell."""
    return spec.unit == "count" or spec.name == "counts"


def reading_unit(unit: str | None) -> str | None:
    """Unit of a cell's reading that is not counts: a voltage, or N of a calibrated force."""
    if unit is None or unit in READING_UNITS:
        return unit
    try:
        conversion(unit, "N", 1.0)
    except UsageError:
        return None
    return "N"


def canonical(
    raw: RawColumn, spec: Column, place: ForeignColumn, gravity_mps2: float, path: Path
) -> tuple[NDArray[Any], ReadColumn | None]:
    """Values in the canonical unit (n,), and what was done to them where anything was.

    Raises
    ------
    UsageError
        A unit nobody knows, or one of another quantity.
    DataError
        The first cell that is not what the column holds.
    """
    source = place.column or spec.name
    made = not place.in_file
    renamed = source != spec.name or made
    kept = replace(spec, missing="keep") if place.missing else spec
    if spec.kind == "text":
        words = texts(raw, kept, source, path)
        read = ReadColumn(spec.name, source, "text", "", None, None, None)
        return words, read if renamed else None
    nanoseconds = stamps(raw, spec, source, place.unit, path, place.format)
    spans = durations(raw, spec, source, path) if nanoseconds is None else seconds(nanoseconds)
    if spans is not None:
        said = {"duration": "duration", "number": "nanosecond"}.get(raw.kind)
        said = said or "date, as seconds since 1970 UTC"
        return spans, ReadColumn(spec.name, source, said, "s", None, None, _range(spans))
    values = numbers(raw, kept, source, place.unit, path)
    if place.wraps_at is not None:
        again = signed if is_reading(spec) else unwrapped
        values = again(values, place.wraps_at)
    if place.summed:
        values = np.cumsum(values.astype(np.float64))
    if place.add:
        values = values.astype(np.float64) + place.add
    change = conversion_of(spec, place, gravity_mps2, path)
    read_values = values if change is None else change(values.astype(np.float64))
    if place.factor is not None:
        read_values = read_values * place.factor
    if change is None and place.factor is None and not place.add and not renamed:
        return values, None
    return read_values, _read_as(spec, place, change, values, read_values)


def unwrapped(values: NDArray[Any], at: float) -> NDArray[Any]:
    """A counter (n,) that begins again from zero, as if it had gone on counting."""
    turns = np.cumsum(np.diff(values.astype(np.float64), prepend=values[:1]) < -at / 2)
    return np.asarray(values + turns.astype(values.dtype) * values.dtype.type(at))


def conversion_of(
    spec: Column, place: ForeignColumn, gravity_mps2: float, path: Path
) -> Conversion | None:
    """How a column's numbers become canonical ones; None where they are already.

    Raises
    ------
    UsageError
        A unit nobody knows, or one of another quantity.
    """
    target = "count" if is_reading(spec) else spec.unit
    if place.unit is None or place.unit == target:
        return None
    if place.unit.endswith(NOT_SAID):
        examples = _EXAMPLES.get(target or "", target or "a unit")
        if word := place.unit.removesuffix(NOT_SAID):
            raise UsageError(
                f"'{word}' may be the unit of {spec.name}, and is not clear", file=path,
                column=place.column,
                remedy=f'write {spec.name} = {{ column = "{place.column}", unit = "…" }} in '
                f"[columns]: {examples}",
            )  # fmt: skip
        raise UsageError(
            f"nothing says the unit of {spec.name}", file=path, column=place.column or None,
            remedy=f'write it in place of "{NOT_SAID}" in [columns]: '
            + examples,
        )  # fmt: skip
    if target is None:
        raise UsageError(
            f"{spec.name} has no unit, but [columns] gives it '{place.unit}'", file=path,
            column=place.column, remedy="take the unit out",
        )  # fmt: skip
    if is_reading(spec):
        other = reading_unit(place.unit)
        if other in READING_UNITS:
            return None
        target = other or target
    try:
        change = conversion(place.unit, target, gravity_mps2)
    except UsageError as error:
        raise UsageError(
            error.problem, file=path, column=place.column, remedy=error.remedy
        ) from None
    same = change.slope == 1.0 and change.offset == 0.0 and not change.weighed
    return None if same else change


def _read_as(
    spec: Column,
    place: ForeignColumn,
    change: Conversion | None,
    written: NDArray[Any],
    read: NDArray[Any],
) -> ReadColumn:
    unit = place.unit or ""
    if change is not None:
        unit = change.source.name + (" (its weight)" if change.weighed else "")
    factor = None if change is None else change.slope
    if place.factor is not None:
        factor = place.factor * (factor or 1.0)
    other = reading_unit(place.unit) if is_reading(spec) else None
    if place.plus:
        unit += "".join(f" and {parse_unit(more).name}" for more in place.plus.values())
    on_top = [f"{place.add:g}"] if place.add else []
    source = " + ".join((place.column or spec.name, *place.plus, *on_top))
    source += f" − {place.minus}" * bool(place.minus)
    return ReadColumn(
        spec.name, source, unit, other or spec.unit or "", factor, _range(written), _range(read),
    )  # fmt: skip


def _range(values: NDArray[Any]) -> tuple[float, float] | None:
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else None
