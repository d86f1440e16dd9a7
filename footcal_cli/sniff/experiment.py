"""Which experiment a log is of: decided by which quantities stand beside each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.cells import cells_in_time, toml_key
from footcal_cli.sniff.groups import channel_names, could_be_read, readings, wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, codes_of, numbers_of
from footcal_cli.sniff.holds import blank_loads, typed_loads
from footcal_cli.sniff.motion import without_motion
from footcal_cli.sniff.names import ADDED, COMMANDED, GROSS, NET, STATISTICS, words_of
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.plan import (
    FORCES,
    Blank,
    Entry,
    Plan,
    extras,
    of,
    reading_entry,
    times,
)
from footcal_cli.sniff.plates import force_and_cop
from footcal_cli.sniff.six_axis import transducers
from footcal_cli.sniff.units import GRAVITY_MPS2
from footcal_cli.sniff.weights import (
    added_up,
    follow,
    in_two_units,
    known_wrench,
    load_entry,
    loads_across,
    runs_across,
    weights,
)
from footcal_cli.tables.units import conversion

_AS_ASKED = 0.95
"""How much of a measured load the one that was asked for explains."""
_TURNS = 0.5
"""In a table of one row per cell the next row is mostly of another."""
_OF_ALL = 0.2
"""How far the sum of readings may be from the load that all cells carry together."""
_HALF = 0.5
LOADS = (*FORCES, "oz", "mg", "t", "stone", "daN", "ozf")
_AGAIN = 0.05
"""How far two columns of one load may be apart: nominal and actual masses."""
_EXPLAINED = 0.999
"""How much of a reading's variance a load explains that is the whole load."""
_BARE = {"g": "g", "st": "stone", "stone": "stone"}
"""Names that are a unit of a load only beside one in another unit."""


def plan_of(file: FileGuess) -> Plan | None:
    """The plan for one log, None where its columns fit no experiment."""
    file = without_motion(numbered(file))
    six = wrenches(file)
    loads, cells = _loads_and_cells(file)
    holes = {c.name.axis: c for c in file.of("hole")}
    cops = {c.name.axis: c for c in file.of("cop")}
    if {"x", "y"} <= set(holes) and {"x", "y"} <= set(cops):
        return _cop_points(file, holes, cops)
    if {"x", "y"} <= set(holes) and loads and len(cells) >= 3 and not six:
        return _placements(file, holes, loads[0], cells)
    plates = None if holes or (loads and cells) else force_and_cop(file)
    if plates is not None:
        return plates
    rig = known_wrench(file, six)
    if rig is not None:
        return rig
    if six:
        return transducers(file, six)
    if why_not(file) is not None:
        return None
    runs = runs_across(file, loads)
    if runs is not None and all(STATISTICS & {*words_of(c.column)} for c in cells):
        return runs
    if loads and cells:
        return _once(weights(file, loads, cells), loads)
    across = loads_across(file)
    if across is not None:
        return across
    if len(cells) == 1:
        return _unloaded(file, cells[0])
    if cells:
        return cells_in_time(file, cells)
    return None


def _once(plan: Plan, loads: list[ColumnGuess]) -> Plan:
    """A plan that says which columns are its load again."""
    entries = [*plan.entries.values(), *(e for own in plan.wide.values() for e in own.values())]
    used = {e.column.column for e in entries if e.column is not None}
    spare = [c.column for c in loads[1:] if c.column not in used]
    if not spare or len(spare) == len(loads):
        return plan
    said = f"{', '.join(spare)}: taken for {loads[0].column} once more, not added to it"
    return replace(plan, warnings=(*plan.warnings, said))


def why_not(file: FileGuess) -> tuple[str, str] | None:
    """Why a log that is understood cannot be used as it is, and what to do; None otherwise."""
    axes = {c.name.axis for c in file.of("force")}
    feet = next((c.words for c in file.of("label") if len(c.words) > 1), ())
    if feet and {"fx", "fy", "fz"} <= axes and not {"tx", "ty", "tz"} & axes:
        columns = ", ".join(f"{foot}_fz" for foot in feet[:2])
        return (
            f"forces along three axes of {len(feet)} feet, one row per foot",
            f"write one row per stamp, a column of vertical force for each foot ({columns}, …)",
        )
    attitude = {c.quantity for c in file.columns} & {"quaternion", "angle", "matrix", "gravity"}
    if not feet and attitude and {"fx", "fy", "fz"} <= axes and not {"tx", "ty", "tz"} & axes:
        return (
            "the three forces of a sensor that is turned, without its torques",
            "log the torques too (tx, ty, tz): hang-calib fits offsets, weight and CoM from all "
            "six axes together",
        )
    loads, cells = _loads_and_cells(file)
    added = next((c for c in loads if ADDED & set(words_of(c.column)) and not c.summed), None)
    if added is not None:
        return (
            f"{added.column}: by its name what was added at each step, not what lay on the sensor",
            "give the total load in each row (load_kg), or call the column so if it is the total",
        )
    apart = _one_row_per_cell(file, cells)
    if not loads and apart:
        return (
            f"readings of {len(apart)} cells below each other, one row per cell and stamp",
            "write one row per stamp, a column for each cell "
            f"({', '.join(f'{name}_counts' for name in apart[:3])}, …), or known loads in a column",
        )
    apart_from = [] if len(loads) == len(cells) > 1 else _unlike(loads, cells)
    if apart_from:
        one, other = loads[0].column, apart_from[0].column
        return (
            f"two columns of loads, {one} and {other}, that do not agree",
            f"say in [columns] which one is meant, or that one comes on top: load_n = {{ column = "
            f'"{one}", unit = "…", plus = {{ {toml_key(other)} = "…" }} }}',
        )
    if loads and len(cells) > 1 and _share_the_load(loads, cells):
        first = toml_key(next(iter(channel_names(cells))))
        return (
            f"{len(cells)} cells whose readings add up to the known load: they share it, and no "
            "column says how much each carried",
            f"give each its own load ({first}_load_n, …), load them one by one, or put the weight "
            "on known points (hole_x_m, hole_y_m)",
        )
    return None


def _measured(file: FileGuess, asked: ColumnGuess, cells: list[ColumnGuess]) -> ColumnGuess | None:
    """The load that was measured, next to one that was only asked for; None without both.

    Another column in a unit of force must follow it, and a reading must remain.
    """
    if not COMMANDED & set(words_of(asked.column)):
        return None
    for column in file.of("force", "reading", "load", "unknown"):
        others = [c for c in cells if c is not column]
        if column is asked or column.unit not in FORCES or column.name.axis not in ("", "fz"):
            continue
        if column.values is not None and others and not follow(asked, [column], _AS_ASKED)[1]:
            why = f"measured, where {asked.column} was asked for"
            return column.as_quantity("load", "likely", why)
    return None


def _one_row_per_cell(file: FileGuess, cells: list[ColumnGuess]) -> list[str]:
    """Names of cells whose readings take turns in one column; empty where they do not."""
    labels = [c for c in file.of("label", "placement") if c.codes is not None and len(c.words) > 1]
    if len(cells) != 1 or not labels:
        return []
    codes = np.column_stack([codes_of(c) for c in labels])
    changes = np.any(np.diff(codes, axis=0) != 0, axis=1)
    different = np.unique(codes, axis=0)
    if changes.mean() < _TURNS or len(different) < 2 or codes.min() < 0:
        return []
    return ["_".join(c.words[i] for c, i in zip(labels, row, strict=True)) for row in different]


def _unlike(loads: list[ColumnGuess], cells: list[ColumnGuess]) -> list[ColumnGuess]:
    """Loads that are not the first one again: in newtons, or where a unit is not said by course.

    Without units they matter where the first load alone does not explain the readings.
    """
    if len(loads) < 2 or not cells:
        return []
    first, unlike = loads[0], []
    for other in loads[1:]:
        if first.unit in LOADS and other.unit in LOADS:
            one, two = _in_newton(first), _in_newton(other)
            if np.nanmax(np.abs(one - two)) > _AGAIN * np.nanmax(np.abs(one)):
                unlike.append(other)
        elif follow(first, [other], _AS_ASKED)[1] and follow(first, cells, _EXPLAINED)[1]:
            unlike.append(other)
    return unlike


def _share_the_load(loads: list[ColumnGuess], cells: list[ColumnGuess]) -> bool:
    """Whether cells that read forces carry the load together: each less, all of them as much.

    A calibrated force is not off by half: where every cell reads less than that, others carry, too.
    """
    load = loads[0]
    if len(loads) > 1 or not all(c.unit in FORCES for c in (load, *cells)):
        return False
    values = [_in_newton(c) for c in (load, *cells)]
    known, read = values[0], np.sum(values[1:], axis=0)
    good = np.isfinite(known) & np.isfinite(read)
    if good.sum() < 3 or np.ptp(known[good]) == 0:
        return False
    whole = np.polyfit(known[good], read[good], 1)[0]
    each = [np.polyfit(known[good], v[good], 1)[0] for v in values[1:]]
    return bool((abs(whole - 1) < _OF_ALL and max(each) < 1 - _OF_ALL) or max(each) < _HALF)


def _in_newton(column: ColumnGuess) -> FloatArray:
    change = conversion(column.unit or "N", "N", GRAVITY_MPS2)
    return np.asarray(change(numbers_of(column)))


def _loads_and_cells(file: FileGuess) -> tuple[list[ColumnGuess], list[ColumnGuess]]:
    """Columns of known loads and of readings; one force beside counts is the reference."""
    loads = [c for c in file.of("load") if c.values is not None and np.ptp(c.values[
        np.isfinite(c.values)]) > 0]  # fmt: skip
    cells = [c for c in readings(file) if c not in loads]
    if not loads:
        forces = [
            c for c in file.of("force", "reading", "unknown")
            if c.unit in FORCES and c.name.axis in ("", "fz") and c.values is not None
        ]  # fmt: skip
        others = [c for c in readings(file) if c not in forces]
        others = others or [
            c for c in file.of("unknown", "reading") if c not in forces and could_be_read(c)
        ]
        plain = [c for c in file.of("force") if c.name.axis in ("", "fz")]
        if not forces and len(plain) == 1 and others and plain[0] not in others:
            forces = plain
        if len(forces) == 1 and others:
            why = "a force next to readings that are none"
            return [forces[0].as_quantity("load", "likely", why)], others
    pressures = [c for c in file.of("pressure") if c.values is not None]
    if not loads and len(pressures) == 1:
        why = "a pressure that all readings are under: its unit times an area is the load"
        return ([pressures[0].as_quantity("load", "guess", why)], cells) if cells else ([], [])
    added = [c for c in loads if ADDED & set(words_of(c.column))]
    if len(loads) > len(added):
        loads = [c for c in loads if c not in added]
    elif len(added) == 1 and cells:
        loads = [added_up(added[0], cells)]
    net = [c for c in loads if NET & set(words_of(c.column))]
    if any(GROSS & set(words_of(c.column)) for c in loads):
        loads = [c for c in loads if c not in net]
    if loads:
        named = [(c, c.column.strip().lower()) for c in file.of("unknown") if c.values is not None]
        bare = [replace(c, unit=_BARE[name]) for c, name in named if name in _BARE]
        loads = [c for c in in_two_units([*loads, *bare]) if c not in bare]
    asked = [c for c in loads if COMMANDED & set(words_of(c.column))]
    if len(asked) == 1 and len(loads) == 2 and cells:
        loads = [c for c in loads if c not in asked]
    if len(loads) == 1 and (put := _measured(file, loads[0], cells)) is not None:
        return [put], [c for c in cells if c.column != put.column]
    if loads and not cells:
        cells = [c for c in file.of("unknown", "force") if could_be_read(c)]
        if not cells and len(loads) == 2:
            # two weights: the one with fewer values was put on, the other was read
            loads = sorted(loads, key=lambda c: np.unique(numbers_of(c)).size)
            cells, loads = (
                [loads[1].as_quantity("reading", "guess", "a weight that was read")],
                loads[:1],
            )
    return loads, cells


def _unloaded(file: FileGuess, cell: ColumnGuess) -> Plan:
    """One cell alone, with no load beside it."""
    time, rate, blanks = times(file, needed=True)
    name = next(iter(channel_names([cell])))
    name = name if name not in ("counts", "reading", "value", "cell_1") else "cell"
    entries = {**time, f"{name}_counts": reading_entry(cell), **extras(file)}
    entries.pop("repeat", None)
    seconds = np.arange(file.rows) / (rate or 100.0)
    if time and (stamped := file.of("time")[0]).values is not None:
        scale = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}.get(stamped.unit or "s", 1.0)
        seconds = (stamped.values - stamped.values[0]) * scale
    for column in file.of("other", "label"):
        if column.codes is None or not 0 < np.sum(column.codes >= 0) < file.rows:
            continue
        typed = [
            (float(seconds[i]), column.words[column.codes[i]])
            for i in np.flatnonzero(column.codes >= 0)
        ]
        if loads := typed_loads(seconds, numbers_of(cell), typed):
            return Plan(
                file, "one cell alone, weights put on it one after another",
                f"what was typed in {column.column} at each hold", "likely",
                "offline-fit", "weights_stream", entries, (name,), rate_hz=rate,
                options=loads,
                blanks=tuple(blanks),
            )  # fmt: skip
    return Plan(
        file, "one cell alone, without a load", "one column of readings", "likely",
        "offline-fit", "weights_stream", entries, (name,), rate_hz=rate,
        blanks=(blank_loads(seconds, numbers_of(cell)), *blanks),
    )  # fmt: skip


def _cop_points(
    file: FileGuess, holes: dict[str, ColumnGuess], cops: dict[str, ColumnGuess]
) -> Plan:
    names = file.of("placement", "label", "orientation", "sequence")
    entries = {
        "placement": of(names[0]) if names else Entry(value="point", why="no name of the points"),
        **{f"hole_{a}_m": of(holes[a], holes[a].unit or "m") for a in "xy"},
        **{f"cop_{a}_m": of(cops[a], cops[a].unit or "m") for a in "xy"},
    }
    return Plan(
        file, "known points and the CoP that an instrument reported",
        "positions of points and a CoP", "likely", "offline-fit", "cop_points", entries,
    )  # fmt: skip


def _placements(
    file: FileGuess, holes: dict[str, ColumnGuess], load: ColumnGuess, cells: list[ColumnGuess]
) -> Plan:
    named = channel_names(cells)
    labels = [c for c in file.of("label") if c.words]
    points = file.of("placement")
    entries = {
        "foot": of(labels[0]) if labels else Entry(value="foot", why="one foot"),
        "placement": of(points[0]) if points else Entry(value="point", why="no name of the points"),
        **{f"hole_{a}_m": of(holes[a], holes[a].unit or "m") for a in "xy"},
        "load_n": load_entry(load)[0],
        **{f"{n}_counts": reading_entry(c) for n, c in named.items()},
    }
    foot = labels[0].words[0] if labels else "foot"
    lines = (f"# [robot.feet.{foot}.cells]    # x forward, y left, from the foot's origin",
             *(f"# {name} = {{ x_m = , y_m =  }}" for name in named))  # fmt: skip
    return Plan(
        file, "a known weight over known holes of a foot", "holes, a load and readings", "likely",
        "offline-fit", "placements", entries,
        blanks=(
            *load_entry(load)[1],
            Blank(lines, "no log says where the cells sit"),
            Blank(("# weights = […]    # in [data]: each cell under known weights",),
                  "placements need calibrated cells: their weights too, or --parameters"),
        ),
    )  # fmt: skip
