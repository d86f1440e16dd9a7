"""Which experiment a log is of: decided by which quantities stand beside each other."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from footcal_cli.core.bench.matrix import directions
from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.cells import cells_in_time, toml_key
from footcal_cli.sniff.groups import channel_names, could_be_read, readings, wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.holds import blank_loads
from footcal_cli.sniff.motion import without_motion
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
from footcal_cli.sniff.tokens import with_unit
from footcal_cli.sniff.units import GRAVITY_MPS2, known_unit
from footcal_cli.tables.units import conversion

_ROWS_OF_A_STREAM = 60
_OF_ALL = 0.2
"""How far the sum of readings may be from the load that all cells carry together."""
UNIT_TO_FILL_IN = "?"
UNIT_ASKED = Blank(
    ('# in [columns]: unit = "?" of load_n becomes N, kg, g, lb …',),
    "nothing says the unit of the load",
)


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
    if six:
        return transducers(file, six)
    if why_not(file) is not None:
        return None
    if loads and cells:
        return _weights(file, loads, cells)
    runs = _runs_across(file, loads)
    if runs is not None:
        return runs
    across = _loads_across(file)
    if across is not None:
        return across
    if len(cells) == 1:
        return _unloaded(file, cells[0])
    if cells:
        return cells_in_time(file, cells)
    return None


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
    loads, cells = _loads_and_cells(file)
    if loads and len(cells) > 1 and _share_the_load(loads, cells):
        first = toml_key(next(iter(channel_names(cells))))
        return (
            f"{len(cells)} cells whose readings add up to the known load: they share it, and no "
            "column says how much each carried",
            f"give each its own load ({first}_load_n, …), load them one by one, or put the weight "
            "on known points (hole_x_m, hole_y_m)",
        )
    return None


def _share_the_load(loads: list[ColumnGuess], cells: list[ColumnGuess]) -> bool:
    """Whether cells that read forces carry the load together: each less, all of them as much."""
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
    return bool(abs(whole - 1) < _OF_ALL and max(each) < 1 - _OF_ALL)


def _in_newton(column: ColumnGuess) -> FloatArray:
    assert column.values is not None, "readings have numbers"
    change = conversion(column.unit or "N", "N", GRAVITY_MPS2)
    return np.asarray(change(column.values))


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
            why = "a force beside readings that are none"
            return [forces[0].as_quantity("load", "likely", why)], others
    pressures = [c for c in file.of("pressure") if c.values is not None]
    if not loads and len(pressures) == 1:
        why = "a pressure that all readings are under: its unit times an area is the load"
        return ([pressures[0].as_quantity("load", "guess", why)], cells) if cells else ([], [])
    if loads and not cells:
        cells = [c for c in file.of("unknown", "force") if could_be_read(c)]
        if not cells and len(loads) == 2:
            # two weights: the one with fewer values was put on, the other was read
            loads = sorted(loads, key=lambda c: np.unique(c.values).size)  # type: ignore[arg-type]
            cells, loads = (
                [loads[1].as_quantity("reading", "guess", "a weight that was read")],
                loads[:1],
            )
    return loads, cells


def _weights(file: FileGuess, loads: list[ColumnGuess], cells: list[ColumnGuess]) -> Plan:
    """Known loads beside readings."""
    load = loads[0]
    entry, asked = _load_entry(load)
    labels = [c for c in file.of("label") if len(c.words) > 0]
    time, _, _ = times(file, needed=False)
    entries = {"load_n": entry, **time, **extras(file)}
    named = channel_names(cells)
    if len(loads) == len(cells) > 1:
        pairs = dict(zip(named, loads, strict=True))
        if _one_proportion(loads):
            return _each_its_load(file, named, pairs, time)
        entries = {f"{n}_load_n": of(c, c.unit or "N") for n, c in pairs.items()}
        entries |= {f"{n}_counts": reading_entry(c) for n, c in named.items()}
        return Plan(
            file, "several cells loaded at once, each with its own known load",
            "as many loads as readings", "likely", "offline-fit", "weights_together",
            entries, tuple(named),
        )  # fmt: skip
    if len(cells) == 1 or labels:
        cell = cells[0]
        channel = of(labels[0]) if labels else Entry(value="cell", why="one cell alone")
        dense = bool(time) and file.rows >= _ROWS_OF_A_STREAM and not labels
        if dense:
            return _stream(file, {"cell": cell}, entries, asked)
        direction = file.of("direction")
        if direction and direction[0].values is not None:
            entries["direction"] = of(direction[0])
        entries |= {"channel": channel, "counts": reading_entry(cell)}
        return Plan(
            file, "known weights, one row per reading", "a load beside each reading",
            "likely", "offline-fit", "weights", entries,
            tuple(labels[0].words) if labels else ("cell",), blanks=asked,
        )  # fmt: skip
    if time and file.rows >= _ROWS_OF_A_STREAM:
        return _stream(file, named, entries, asked)
    wide = {name: {"counts": reading_entry(column)} for name, column in named.items()}
    return Plan(
        file, f"known weights, the readings of {len(cells)} cells beside each other",
        "one load and several readings in a row", "guess", "offline-fit", "weights",
        entries, tuple(named), wide, blanks=asked,
        warnings=(
            "taken that every cell carried the whole load by itself; if the load stood on all "
            "of them, give each its share",
        ),
    )  # fmt: skip


def _one_proportion(loads: list[ColumnGuess]) -> bool:
    """Whether known loads rise and fall together: no crosstalk can be seen."""
    table = np.column_stack([c.values for c in loads])  # type: ignore[misc]
    return directions(table[np.isfinite(table).all(axis=1)]) < len(loads)


def _each_its_load(
    file: FileGuess, named: dict[str, ColumnGuess], loads: dict[str, ColumnGuess],
    time: dict[str, Entry],
) -> Plan:  # fmt: skip
    """Cells that were loaded side by side, each with a load of its own in every row."""
    asked = tuple({blank for c in loads.values() for blank in _load_entry(c)[1]})
    wide = {
        name: {"load_n": _load_entry(loads[name])[0], "counts": reading_entry(column)}
        for name, column in named.items()
    }
    return Plan(
        file, f"known weights on {len(named)} cells, each with its own load in every row",
        "as many loads as readings, all in one proportion", "likely", "offline-fit", "weights",
        {**time, **extras(file)}, tuple(named), wide, blanks=asked,
    )  # fmt: skip


def _loads_across(file: FileGuess) -> Plan | None:
    """A sheet of cells by weights, the weights in the header: ``cell; 0 kg; 0.5 kg; 1 kg``."""
    loads: dict[str, tuple[float, str]] = {}
    for column in file.columns:
        found = with_unit(column.column.strip())
        unit = known_unit(found[1]) if found else None
        if found and unit in FORCES and column.values is not None:
            loads[column.column] = (float(found[0].replace(",", ".")), unit)
    others = [c for c in file.columns if c.column not in loads]
    labels = [c for c in others if c.words]
    if len(loads) < 2 or len(labels) != 1 or any(c.values is not None for c in others):
        return None
    columns = {c.column: c for c in file.columns}
    wide = {
        name: {
            "load_n": Entry(value=f"{value:g}", unit=unit, why="the header"),
            "counts": reading_entry(replace(columns[name], unit=None)),
        }
        for name, (value, unit) in loads.items()
    }
    return Plan(
        file, "known weights, a column of readings for each", "loads in the header", "likely",
        "offline-fit", "weights", {"channel": of(labels[0])}, tuple(labels[0].words), wide,
        "load_n",
    )  # fmt: skip


def _runs_across(file: FileGuess, loads: list[ColumnGuess]) -> Plan | None:
    """One cell, a column of readings for each run: ``load; run 1; run 2``."""
    runs = {
        found[1]: c for c in file.of("repeat")
        if c.values is not None and (found := re.search(r"(\d+)\W*$", c.column))
        and np.unique(c.values).size > 2
    }  # fmt: skip
    if len(loads) != 1 or len(runs) < 2:
        return None
    entry, asked = _load_entry(loads[0])
    wide = {number: {"counts": reading_entry(column)} for number, column in runs.items()}
    channel = Entry(value="cell", why="one cell, a column for each run")
    return Plan(
        file, f"known weights on one cell, {len(runs)} runs beside each other",
        "a load and numbered runs in a row", "likely", "offline-fit", "weights",
        {"load_n": entry, "channel": channel}, ("cell",), wide, "repeat", blanks=asked,
    )  # fmt: skip


def _load_entry(load: ColumnGuess) -> tuple[Entry, tuple[Blank, ...]]:
    """The entry of known loads; their unit is asked for where nothing says it."""
    if load.unit is not None and load.unit != "count":
        return of(load), ()
    return replace(of(load, UNIT_TO_FILL_IN), sure="guess"), (UNIT_ASKED,)


def _stream(
    file: FileGuess, named: dict[str, ColumnGuess], entries: dict[str, Entry],
    asked: tuple[Blank, ...],
) -> Plan:  # fmt: skip
    """A recording of one or more cells under a load that is read too."""
    entries = {k: v for k, v in entries.items() if k in ("time_s", "load_n", "temperature_degc")}
    entries |= {f"{name}_counts": reading_entry(column) for name, column in named.items()}
    return Plan(
        file, "a running recording while the load changes", "time, load and readings", "likely",
        "offline-fit", "weights_stream", entries, tuple(named), blanks=asked,
    )  # fmt: skip


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
    assert cell.values is not None, "a reading has numbers"
    return Plan(
        file, "one cell alone, no load beside it", "one column of readings", "likely",
        "offline-fit", "weights_stream", entries, (name,), rate_hz=rate,
        blanks=(blank_loads(seconds, cell.values), *blanks),
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
        "positions of points beside a CoP", "likely", "offline-fit", "cop_points", entries,
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
        "load_n": _load_entry(load)[0],
        **{f"{n}_counts": reading_entry(c) for n, c in named.items()},
    }
    foot = labels[0].words[0] if labels else "foot"
    lines = (f"# [robot.feet.{foot}.cells]    # x forward, y left, from the foot's origin",
             *(f"# {name} = {{ x_m = , y_m =  }}" for name in named))  # fmt: skip
    return Plan(
        file, "a known weight over known holes of a foot", "holes, a load and readings", "likely",
        "offline-fit", "placements", entries,
        blanks=(
            *_load_entry(load)[1],
            Blank(lines, "no log says where the cells sit"),
            Blank(("# weights = […]    # in [data]: each cell under known weights",),
                  "placements need calibrated cells: their weights too, or --parameters"),
        ),
    )  # fmt: skip
