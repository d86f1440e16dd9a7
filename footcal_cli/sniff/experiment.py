"""Which experiment a log is of: decided by which quantities stand beside each other."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.columns import ColumnGuess, FileGuess
from footcal_cli.sniff.groups import (
    attitude,
    channel_names,
    indexed_wrenches,
    matrix,
    readings,
    wrenches,
)
from footcal_cli.sniff.holds import blank_loads
from footcal_cli.sniff.plan import Blank, Entry, Plan, of

_ROWS_OF_A_STREAM = 60
_FORCES = ("N", "kN", "mN", "kgf", "lbf", "gf", "kg", "g", "lb")
_AXIS_COLUMNS = {"fx": "fx_n", "fy": "fy_n", "fz": "fz_n", "tx": "tx_nm", "ty": "ty_nm",
                 "tz": "tz_nm"}  # fmt: skip
_MASS = Blank(
    ("# [robot]", "# mass_kg =    # the whole robot, batteries and cables included"),
    "no log says what the robot weighs",
)
UNIT_TO_FILL_IN = "?"
UNIT_ASKED = Blank(
    ('# in [columns]: unit = "?" of load_n becomes N, kg, g, lb …',),
    "nothing says the unit of the load",
)
_RATE = Blank(
    ("# rate_hz = 100.0    # rows per second",),
    "the log has no time stamps; 100 Hz is assumed, which moves no static calibration", False,
)  # fmt: skip


def plan_of(file: FileGuess) -> Plan | None:
    """The plan for one log, None where its columns fit no experiment."""
    file = indexed_wrenches(file)
    six = wrenches(file)
    loads, cells = _loads_and_cells(file)
    holes = {c.name.axis: c for c in file.of("hole")}
    cops = {c.name.axis: c for c in file.of("cop")}
    if {"x", "y"} <= set(holes) and {"x", "y"} <= set(cops):
        return _cop_points(file, holes, cops)
    if {"x", "y"} <= set(holes) and loads and len(cells) >= 3:
        return _placements(file, holes, loads[0], cells)
    if six:
        return _transducers(file, six)
    if loads and cells:
        return _weights(file, loads, cells)
    if len(cells) == 1:
        return _unloaded(file, cells[0])
    if cells:
        return _cells(file, cells)
    return None


def _loads_and_cells(file: FileGuess) -> tuple[list[ColumnGuess], list[ColumnGuess]]:
    """Columns of known loads and of readings; one force beside counts is the reference."""
    loads = [c for c in file.of("load") if c.values is not None and np.ptp(c.values[
        np.isfinite(c.values)]) > 0]  # fmt: skip
    cells = [c for c in readings(file) if c not in loads]
    if not loads:
        forces = [
            c for c in file.of("force", "reading", "unknown")
            if c.unit in _FORCES and c.name.axis in ("", "fz") and c.values is not None
        ]  # fmt: skip
        others = [c for c in readings(file) if c not in forces]
        others = others or [
            c for c in file.of("unknown", "reading") if c not in forces and c.values is not None
        ]
        plain = [c for c in file.of("force") if c.name.axis in ("", "fz")]
        if not forces and len(plain) == 1 and others and plain[0] not in others:
            forces = plain
        if len(forces) == 1 and others:
            why = "a force beside readings that are none"
            return [forces[0].as_quantity("load", "likely", why)], others
    if not loads and not cells and len(file.of("pressure")) == 1:
        return [], []
    if loads and not cells:
        cells = [c for c in file.of("unknown", "force") if c.values is not None]
        if not cells and len(loads) == 2:
            # two weights: the one with fewer values was put on, the other was read
            loads = sorted(loads, key=lambda c: np.unique(c.values).size)  # type: ignore[arg-type]
            cells, loads = (
                [loads[1].as_quantity("reading", "guess", "a weight that was read")],
                loads[:1],
            )
    return loads, cells


def _times(file: FileGuess, *, needed: bool) -> tuple[dict[str, Entry], float | None, list[Blank]]:
    """The entry of time stamps, or a rate to count with."""
    for column in file.of("time"):
        return {"time_s": of(column)}, None, []
    return ({}, 100.0, [_RATE]) if needed else ({}, None, [])


def _extras(file: FileGuess) -> dict[str, Entry]:
    """Columns that help wherever they stand."""
    found = {}
    for quantity, name in (
        ("temperature", "temperature_degc"), ("repeat", "repeat"), ("session", "session"),
    ):  # fmt: skip
        for column in file.of(quantity)[:1]:
            found[name] = of(column)
    return found


def _reading(column: ColumnGuess) -> Entry:
    """A cell's reading: counts, a voltage or a force."""
    if column.counts and column.unit not in _FORCES:
        return Entry(column, None, sure=column.sure, why="whole numbers: counts")
    if column.unit in ("V", "mV", "mV/V"):
        return Entry(column, column.unit, sure="likely", why="a voltage: the scale is N per volt")
    if column.unit in _FORCES:
        return Entry(column, column.unit, sure="likely", why="a force that was calibrated before")
    return Entry(column, None, sure="likely", why="its unit is not said: taken as it is")


def _weights(file: FileGuess, loads: list[ColumnGuess], cells: list[ColumnGuess]) -> Plan:
    """Known loads beside readings."""
    load = loads[0]
    entry, asked = _load_entry(load)
    labels = [c for c in file.of("label") if len(c.words) > 0]
    time, _, _ = _times(file, needed=False)
    entries = {"load_n": entry, **time, **_extras(file)}
    named = channel_names(cells)
    if len(loads) == len(cells) > 1:
        pairs = dict(zip(named, loads, strict=True))
        entries = {f"{n}_load_n": of(c, c.unit or "N") for n, c in pairs.items()}
        entries |= {f"{n}_counts": _reading(c) for n, c in named.items()}
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
        entries |= {"channel": channel, "counts": _reading(cell)}
        return Plan(
            file, "known weights, one row per reading", "a load beside each reading",
            "likely", "offline-fit", "weights", entries,
            tuple(labels[0].words) if labels else ("cell",), blanks=asked,
        )  # fmt: skip
    if time and file.rows >= _ROWS_OF_A_STREAM:
        return _stream(file, named, entries, asked)
    wide = {name: {"counts": _reading(column)} for name, column in named.items()}
    return Plan(
        file, f"known weights, the readings of {len(cells)} cells beside each other",
        "one load and several readings in a row", "guess", "offline-fit", "weights",
        entries, tuple(named), wide, blanks=asked,
        warnings=(
            "taken that every cell carried the whole load by itself; if the load stood on all "
            "of them, give each its share",
        ),
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
    entries |= {f"{name}_counts": _reading(column) for name, column in named.items()}
    return Plan(
        file, "a running recording while the load changes", "time, load and readings", "likely",
        "offline-fit", "weights_stream", entries, tuple(named), blanks=asked,
    )  # fmt: skip


def _unloaded(file: FileGuess, cell: ColumnGuess) -> Plan:
    """One cell alone, with no load beside it."""
    time, rate, blanks = _times(file, needed=True)
    name = next(iter(channel_names([cell])))
    name = name if name not in ("counts", "reading", "value", "cell_1") else "cell"
    entries = {**time, f"{name}_counts": _reading(cell), **_extras(file)}
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


def _cells(file: FileGuess, cells: list[ColumnGuess]) -> Plan:
    """Several cells in time: feet that stand or walk."""
    named = channel_names(cells)
    time, rate, blanks = _times(file, needed=True)
    entries = {**time, **{f"{n}_counts": _reading(c) for n, c in named.items()}}
    if "temperature_degc" in (extras := _extras(file)):
        entries["temperature_degc"] = extras["temperature_degc"]
    feet: dict[str, list[str]] = {}
    for name in named:
        foot, _, place = name.partition("_")
        feet.setdefault(foot if foot in ("left", "right") and place else "foot", []).append(
            place if foot in ("left", "right") and place else name
        )
    lines: list[str] = []
    for foot, places in feet.items():
        lines.append(f"# [robot.feet.{foot}.cells]    # x forward, y left, from the foot's origin")
        lines += [f"# {_key(place)} = {{ x_m = , y_m =  }}" for place in places]
    positions = Blank(tuple(lines), "no log says where the cells sit")
    plate = Blank(
        ("# [robot.nameplate]", "# scale_n_per_count =    # by the data sheet; zero_counts too"),
        "nothing says how many newtons a count is; or give --parameters of a bench calibration",
    )  # fmt: skip
    forces = all(c.unit in _FORCES for c in cells)
    if forces:
        plate = Blank(("# [robot.nameplate]", "# scale_n_per_count = 1.0"), "the log has newtons")
    renamed = () if set(feet) != {"foot"} else (
        "cells of `foot` are called foot_<cell> in [columns] once [robot.feet] names them",
    )  # fmt: skip
    return Plan(
        file, f"{len(cells)} load cells in time: standing or walking",
        f"a wide table of {len(cells)} readings" + (" and time" if time else ""), "likely",
        "static-init", "cells", entries, tuple(named), rate_hz=rate,
        blanks=(_MASS, positions, plate, *blanks), warnings=renamed,
    )  # fmt: skip


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else f'"{name}"'


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
        **{f"{n}_counts": _reading(c) for n, c in named.items()},
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


def _transducers(file: FileGuess, six: dict[str, dict[str, ColumnGuess]]) -> Plan:
    """Six-axis transducers: hanging with an attitude, or feet that stand and walk."""
    pose = attitude(file) or matrix(file)
    labels = [c for c in file.of("label") if c.words]
    orientation = [c for c in file.of("orientation") if c.words]
    time, rate, blanks = _times(file, needed=True)
    entries: dict[str, Entry] = dict(time)
    warnings: list[str] = []
    for name, (column, unit) in pose.items():
        entries[name] = Entry(column, unit, sure=column.sure, why=column.why)
    if pose and "body_roll_rad" in pose and "body_yaw_rad" not in pose:
        entries["body_yaw_rad"] = Entry(value="0.0", why="gravity does not depend on the heading")
    if orientation and not pose:
        entries["orientation"] = of(orientation[0])
    sides = {name.partition("_")[0] for name in six}
    if sides >= {"left", "right"} and len(six) == 2 and not orientation:
        return _ankles(file, six, entries, tuple(blanks))
    wide = {name: _axes(group) for name, group in six.items()} if len(six) > 1 else {}
    if not wide:
        entries |= _axes(next(iter(six.values())))
        leg = next(iter(six))
        entries["leg"] = of(labels[0]) if labels else Entry(value=leg, why="one transducer")
    else:
        warnings.append("every transducer is taken to hang free of the ground")
    for column in file.of("phase", "temperature"):
        key = "phase_rad" if column.quantity == "phase" else "temperature_degc"
        entries.setdefault(key, of(column, column.unit))
    missing: tuple[Blank, ...] = ()
    if not pose and not orientation:
        missing = (Blank(
            ('# body_qx = "…"    # the attitude: body_qx … body_qw, or body_roll_rad …, or',
             "#                  # body_r11 … body_r33, or gravity_x gravity_y gravity_z"),
            "the log has no attitude, so nothing says which way gravity pulls",
        ),)  # fmt: skip
    weight = Blank(("# leg_weight_n =    # what hangs on the transducer, roughly",),
                   "a start only: the weight is estimated", False)  # fmt: skip
    return Plan(
        file, f"{len(six)} six-axis transducer{'s' * (len(six) > 1)} turned under gravity",
        "six axes" + (" and an attitude" if pose else " and orientations" if orientation else ""),
        "likely" if pose or orientation else "guess", "hang-calib", "hang", entries, (), wide,
        "leg", rate, blanks=(*missing, weight, *blanks), warnings=tuple(warnings),
    )  # fmt: skip


def _axes(group: dict[str, ColumnGuess], prefix: str = "") -> dict[str, Entry]:
    return {
        f"{prefix}{_AXIS_COLUMNS[axis]}": of(
            group[axis], group[axis].unit or ("N" if axis[0] == "f" else "N*m")
        )
        for axis in _AXIS_COLUMNS
    }


def _ankles(
    file: FileGuess, six: dict[str, dict[str, ColumnGuess]], entries: dict[str, Entry],
    blanks: tuple[Blank, ...],
) -> Plan:  # fmt: skip
    entries = {name: entry for name, entry in entries.items() if name == "time_s"}
    for name, group in six.items():
        entries |= _axes(group, f"{name.partition('_')[0]}_")
    body = body_entries(file)
    entries |= {name: entry for name, entry in body.items() if name != "time_s"}
    command = "online-replay" if file.of("com") else "static-init"
    moves = ", with the body's motion" if file.of("com") else ""
    return Plan(
        file, f"six-axis transducers at two feet{moves}",
        "six axes on the left and on the right", "likely", command, "cells", entries, (),
        robot=("[robot.feet.left]", "[robot.feet.right]"),
        blanks=(
            _MASS,
            Blank(("# [robot.feet.left]",
                   "# transducer_position_m = [0.0, 0.0, 0.0]    # in the logged foot frame",
                   "# weight_below_n = 0.0    # what hangs below the transducer"),
                  "no log says how the transducers are mounted", False),
            *blanks,
        ),
    )  # fmt: skip


def body_entries(file: FileGuess) -> dict[str, Entry]:
    """The robot's own stream: stamps, centre of mass, its acceleration, poses of the feet."""
    entries, _, _ = _times(file, needed=False)
    for quantity, pattern in (("com", "com_{}_m"), ("com_acc", "com_acc_{}_mps2")):
        entries |= {pattern.format(c.name.axis): of(c) for c in file.of(quantity)}
    return entries | _feet_poses(file)


def _feet_poses(file: FileGuess) -> dict[str, Entry]:
    """Poses of the feet beside the transducers."""
    found: dict[str, Entry] = {}
    for side in ("left", "right"):
        for column in file.columns:
            if column.name.side != side or column.values is None:
                continue
            plain = column.column.lower()
            last = re.split(r"[_.\s]", plain)[-1]
            if column.quantity == "quaternion":
                found[f"{side}_foot_q{column.name.axis}"] = of(column)
            elif last in ("x", "y", "z") and "foot" in plain and column.quantity != "force":
                found[f"{side}_foot_{last}_m"] = of(column, column.unit or "m")
            elif last == "yaw" and "foot" in plain:
                found[f"{side}_foot_yaw_rad"] = of(column, column.unit or "rad")
    return found
