"""Feet, plates and insoles that report a vertical force and a CoP."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.motion import body_entries, walks
from footcal_cli.sniff.names import words_of
from footcal_cli.sniff.plan import IN_NEWTON, MASS, NOT_SAID, Blank, Entry, LogPlan, of, times
from footcal_cli.sniff.still_feet import on_still_feet
from footcal_cli.sniff.units import LENGTHS, metres_per, split_unit

_OPENSIM = re.compile(r"^(?P<before>.*?)ground_force(?P<after>.*?)_(?P<kind>[vp])(?P<axis>[xyz])$")
_NUMBERED = re.compile(r"[xyXY]\d{1,2}")
"""A place that has a plate's number alone: X1 next to FZ1."""
_ROOM = 0.25
"""How far around the CoP the cells stand that stand in for a plate, as a share of its range."""
_LEAST_M = 0.05
_LOADED = 0.1
"""Share of the largest force from which a foot is on the ground."""
_MOST_M = 1.0
"""A CoP on one foot or plate moves by less."""
_ONE_LEVER = 0.3
"""How well moments agree with force times CoP; the units are a factor of ten apart."""
_COP_UNIT = Blank(
    ('# in [columns]: unit = "?" of the CoPs becomes mm, cm or m',),
    "nothing says the unit of the CoP",
)


@dataclass(frozen=True)
class _Foot:
    """Columns of a foot's vertical force and CoP; `y_sign` −1 where the log's z points right."""

    force: ColumnGuess
    x: ColumnGuess
    y: ColumnGuess
    y_sign: float = 1.0


def force_and_cop(file: FileGuess) -> LogPlan | None:
    """The plan for a log of forces and CoPs, one of each per foot; None where it is none."""
    feet = _of_opensim(file) or _by_names(file)
    if not feet:
        return None
    time, rate, blanks = times(file, needed=True)
    entries: dict[str, Entry] = dict(time)
    unit = _unit_of_cops(file, feet)
    blanks = [*blanks, *([_COP_UNIT] if unit == NOT_SAID else [])]
    tables = []
    for name, foot in feet.items():
        force = of(foot.force, foot.force.unit or "N")
        down = _points_down(foot.force)
        entries[f"{name}_fz_n"] = replace(
            force, why="a vertical force" + ", of the foot on the plate: it points down" * down,
            factor=-(force.factor or 1.0) if down else force.factor,
        )  # fmt: skip
        for axis, column, sign in (("x", foot.x, 1.0), ("y", foot.y, foot.y_sign)):
            entry = replace(of(column, column.unit or unit), why="its CoP")
            entries[f"{name}_cop_{axis}_m"] = replace(
                entry, factor=-(entry.factor or 1.0) if sign < 0 else entry.factor
            )
        corners = enumerate(_around(foot, unit), 1)
        cells = "\n".join(f"p{i} = {{ x_m = {x:.3f}, y_m = {y:.3f} }}" for i, (x, y) in corners)
        tables.append(
            f"[robot.feet.{name}]    # reports force and CoP; three cells stand in for it\n"
            f"force_and_cop = true\n[robot.feet.{name}.cells]\n{cells}"
        )
    tables.append(IN_NEWTON)
    body = on_still_feet(body_entries(file), tuple(feet), entries)
    moves = not body.blanks and "com_x_m" in body.entries and not walks(body.entries)
    warnings: tuple[str, ...] = ()
    if any(foot.y_sign < 0 for foot in feet.values()):
        warnings = ("y is taken to point up and z to the right, as OpenSim has them",)
    return LogPlan(
        file, f"vertical force and CoP, {len(feet)} of each"
        + ", with the body's motion" * moves,
        "a force and a CoP each", "likely", "static-init", "cells",
        {**body.entries, **entries} if moves else entries, (), rate_hz=rate,
        robot=tuple(tables), blanks=(MASS, *blanks), warnings=warnings,
    )  # fmt: skip


def _points_down(force: ColumnGuess) -> bool:
    """Whether a vertical force is what stands on a plate, not what the plate bears it with."""
    values = numbers_of(force)
    return bool(np.nanmedian(values[np.abs(values) > _LOADED * np.nanmax(np.abs(values))]) < 0)


def _number_of(file: FileGuess) -> str:
    """Number of a plate by its file's name: 4 of ``plate_4.parquet``; 1 where none is said."""
    found = re.search(r"(?i)(?:plate|platform|fp|platte)[ _-]?(\d+)(?!\d)", file.path.name)
    return found[1] if found else "1"


def _of_opensim(file: FileGuess) -> dict[str, _Foot]:
    """``ground_force_vy`` and ``ground_force_px, pz``, y up."""
    found: dict[tuple[str, str], dict[str, ColumnGuess]] = {}
    for column in file.columns:
        name = _OPENSIM.match(column.column.lower())
        if name and column.values is not None:
            key = (name["before"].strip("_"), name["after"].strip("_"))
            found.setdefault(key, {})[name["kind"] + name["axis"]] = column
    whole = [(key, c) for key, c in found.items() if {"vy", "px", "pz"} <= set(c)]
    sides = {"l": "left", "left": "left", "r": "right", "right": "right"}
    named = []
    for i, (key, _) in enumerate(whole, 1):
        word = "".join(key).lower()
        number = re.search(r"\d+", word)
        named.append(sides.get(word, f"plate_{number[0] if number else i}"))
    if len(set(named)) < len(named):
        named = [f"plate_{i}" for i in range(1, len(whole) + 1)]
    return {
        name: _Foot(c["vy"], c["px"], c["pz"], -1.0)
        for name, (_, c) in zip(named, whole, strict=True)
    }


def _by_names(file: FileGuess) -> dict[str, _Foot]:
    """A force and a CoP along x and y of each side, or of each number."""
    forces: dict[str, list[ColumnGuess]] = {}
    places: dict[tuple[str, str], list[ColumnGuess]] = {}
    for column in file.columns:
        moving = column.quantity in ("other", "motion")  # the body's own places
        if moving or column.values is None or not np.isfinite(column.values).any():
            continue
        key = key_of(column)
        words = words_of(column.column)
        last = next((w for w in reversed(words) if not w.isdigit() and w not in _LAST), "")
        if column.quantity in ("force", "load") and column.name.axis in ("", "fz"):
            forces.setdefault(key, []).append(column)
        elif column.quantity == "cop" and column.name.axis in "xy":
            places.setdefault((key, column.name.axis), []).append(column)
        elif last in ("x", "y") and (column.unit in LENGTHS or _NUMBERED.fullmatch(column.column)):
            places.setdefault((key, last), []).append(column)
    feet = {}
    for key, own in forces.items():
        x, y = places.get((key, "x"), []), places.get((key, "y"), [])
        if len(own) > 1 and len(x) == 1:  # of two forces of a foot the one that stands by its CoP
            at = {id(c): i for i, c in enumerate(file.columns)}
            own = sorted(own, key=lambda c: abs(at[id(c)] - at[id(x[0])]))[:1]
        if len(own) == len(x) == len(y) == 1:
            named = key in ("left", "right") or key.startswith("plate_")
            feet[key if named else f"plate_{key or _number_of(file)}"] = _Foot(own[0], x[0], y[0])
    return feet


_LAST = ("left", "right", "l", "r", "mm", "cm", "m")


def key_of(column: ColumnGuess) -> str:
    """Side of a column, or the number that its name ends with, or the only one in it."""
    stem = split_unit(column.column)[0]
    number = re.search(r"(\d+)\s*(?:[\[(].*)?$", column.column)
    numbers = [number[1]] if number else re.findall(r"\d+", stem)
    return column.name.side or (numbers[0] if len(numbers) == 1 else "")


def _unit_of_cops(file: FileGuess, feet: Mapping[str, _Foot]) -> str:
    """The unit of CoPs whose names say none.

    With the moments of the plate beside them ``|M| = F |CoP|`` says it; without, a CoP that moves
    by more than a metre is not in metres, and its unit is asked for.
    """
    spans, moments = [0.0], []
    for foot in feet.values():
        if foot.x.unit is not None and foot.y.unit is not None:
            continue
        force = np.abs(numbers_of(foot.force))
        loaded = force > _LOADED * np.nanmax(force)  # in the air a CoP is noise
        force, x, y = (v[loaded] for v in (force, numbers_of(foot.x), numbers_of(foot.y)))
        spans += [float(np.ptp(np.nanquantile(v, [0.02, 0.98]))) for v in (x, y)]
        beside = {c.name.axis: numbers_of(c) for c in file.of("force")
                  if c.name.side == foot.force.name.side}  # fmt: skip
        if {"tx", "ty"} <= set(beside) and foot.force.unit in (None, "N"):
            lever = np.hypot(beside["tx"], beside["ty"])[loaded] / force
            moments.append(float(np.nanmedian(lever / np.hypot(x, y))))
    named = [c.unit for c in file.of("force") if c.name.axis in ("tx", "ty")]
    for unit in ("m", "cm", "mm"):
        if (
            moments
            and all(u in (None, "N*m") for u in named)
            and np.allclose(moments, LENGTHS[unit], rtol=_ONE_LEVER)
        ):
            return unit
    return "m" if max(spans) < _MOST_M else NOT_SAID


def _around(foot: _Foot, unit: str) -> FloatArray:
    """Corners of a triangle around the CoP, shape (3, 2), m."""
    low, high = [], []
    for column, sign in ((foot.x, 1.0), (foot.y, foot.y_sign)):
        values = sign * numbers_of(column) * metres_per(column.unit or unit)
        a, b = np.nanquantile(values, [0.02, 0.98])
        room = max(_ROOM * (b - a), _LEAST_M)
        low.append(a - room)
        high.append(b + room)
    return np.array([[low[0], low[1]], [low[0], high[1]], [high[0], 0.5 * (low[1] + high[1])]])
