"""The CoP of a plate that reports a vertical force and moments: ``(-My / Fz, Mx / Fz)``.

Room: sniff; asked by experiment. The moments are about the origin of the CoP, and horizontal forces
at the depth of the surface are none, as under a rod or a person who stands.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.readings import straightness
from footcal_cli.errors import UsageError
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.plates import key_of
from footcal_cli.sniff.units import LENGTHS
from footcal_cli.tables.units import conversion

_LOADED = 0.1
"""Share of the largest force from which something stands on a plate."""
_AS_MARKED = 0.9
"""How much of the marks on a plate its CoP explains, if it is one."""
_TURNED = ("quaternion", "angle", "matrix", "gravity", "orientation", "acceleration", "load")
_WRITTEN = ("m", "cm", "mm")
_NEARLY = 0.2
"""How far the CoP's span may be from that of the marks, where its unit is chosen by them."""


def with_levers(file: FileGuess) -> FileGuess:
    """A log with the CoP of its plates beside force and moments, where it has no other.

    Next to known marks it must follow them; without any, plates of a vertical force and two
    moments alone are read so, as six axes may hang.
    """
    if file.of("cop") or file.of(*_TURNED):
        return file
    plates: dict[str, dict[str, ColumnGuess]] = {}
    for column in file.of("force"):
        if column.name.axis and column.values is not None:
            plates.setdefault(key_of(column), {}).setdefault(column.name.axis, column)
    holes = {c.name.axis: c for c in file.of("hole") if c.values is not None}
    whole = {key: own for key, own in plates.items() if {"fz", "tx", "ty"} <= set(own)}
    if {"x", "y"} <= set(holes):
        if len(whole) != 1:
            return file
        made = [_lever(own, axis, holes[axis]) for own in whole.values() for axis in "xy"]
        good = all(
            straightness(numbers_of(holes[c.name.axis]), numbers_of(c)) > _AS_MARKED
            and _rises(holes[c.name.axis], c) for c in made
        )  # fmt: skip
        return replace(file, columns=(*file.columns, *made)) if good else file
    bare = {key: own for key, own in whole.items() if set(own) <= {"fz", "tx", "ty", "tz"}}
    if len(bare) < len(plates):
        return file
    made = [_lever(own, axis) for own in bare.values() for axis in "xy"]
    return replace(file, columns=(*file.columns, *made))


def _rises(hole: ColumnGuess, cop: ColumnGuess) -> bool:
    """Whether a CoP goes the way the marks go."""
    x, y = numbers_of(hole), numbers_of(cop)
    good = np.isfinite(x) & np.isfinite(y)
    return bool(np.polyfit(x[good], y[good], 1)[0] > 0)


def _lever(
    plate: dict[str, ColumnGuess], axis: str, hole: ColumnGuess | None = None
) -> ColumnGuess:
    """The CoP along x or y: a moment by the vertical force."""
    moment, sign = (plate["ty"], -1.0) if axis == "x" else (plate["tx"], 1.0)
    force = numbers_of(plate["fz"])
    there = np.abs(force) > _LOADED * np.nanmax(np.abs(force))
    values = sign * numbers_of(moment) / np.where(there, force, np.nan)
    unit, factor = _unit(moment.unit, plate["fz"].unit)
    if unit is None and hole is not None:
        unit = _as_marked(values, hole)
    name = replace(
        moment.name, quantity="cop", axis=axis, unit=unit, factor=sign * factor
    )  # fmt: skip
    why = f"{moment.column} by {plate['fz'].column}: the plate's CoP"
    return replace(
        moment, name=name, unit=unit, values=values, over=plate["fz"].column, why=why, missing=()
    )


def _unit(moment: str | None, force: str | None) -> tuple[str | None, float]:
    """The unit of a moment by a force, and how many of it one of the numbers is."""
    if moment is None:
        return None, 1.0
    try:
        size = conversion(moment, "N*m", 1.0).slope / conversion(force or "N", "N", 1.0).slope
    except UsageError:
        return None, 1.0
    for unit in _WRITTEN:
        if np.isclose(size, LENGTHS[unit]):
            return unit, 1.0
    return "m", size


def _as_marked(values: FloatArray, hole: ColumnGuess) -> str | None:
    """The unit in which a CoP spans what the marks do; None where none fits."""
    if hole.unit not in _WRITTEN:
        return None
    ratio = np.nanstd(numbers_of(hole)) * LENGTHS[hole.unit] / np.nanstd(values)
    return next((unit for unit in _WRITTEN if abs(ratio / LENGTHS[unit] - 1) < _NEARLY), None)
