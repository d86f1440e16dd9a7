"""What a log says against the recipe and against itself, whoever reads it.

`footcal_cli.session.session` asks for it whenever a command reads a file, so that every command
hears the same of the same file. What needs a calibration or two streams is asked where they come
together (`footcal_cli.intake.recordings`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core import bench_rows, body_stream, quality, readings
from footcal_cli.core.body_positions import check_positions
from footcal_cli.core.checks import siblings, units
from footcal_cli.core.checks.impossible import check_impossible
from footcal_cli.core.checks.intermittent import check_loose_cells, check_spells
from footcal_cli.core.checks.labels import check_labels
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.plausibility import check_scale, check_shares
from footcal_cli.core.quality import Finding
from footcal_cli.core.wiring import check_exchanged_cells
from footcal_cli.recipe import Robot
from footcal_cli.session.spells import hanging_spells
from footcal_cli.session.stamps import stamp_unit
from footcal_cli.session.uneven import sessions_in_order
from footcal_cli.session.unloaded import still_cells, without_lost
from footcal_cli.tables.columns import AXIS_COLUMNS, QUATERNION, TableType
from footcal_cli.tables.table import Table

_SLOWEST_LEGS_S, _SLOWEST_BENCH_S = 5.0, 60.0
"""Longest usual interval of hanging legs and of weighing; walking and standing are faster."""


def inspect(table: Table, kind: TableType, robot: Robot) -> list[Finding]:
    """Findings about one log by itself, by its kind."""
    look: Callable[[Table, Robot], list[Finding]] | None = {
        "weights": _weights,
        "weights_stream": _weights_stream,
        "weights_together": _weights_together,
        "placements": _placements,
        "cells": _cells,
        "six_axis_feet": _stream,
        "body": _body,
        "hang": _hanging,
        "legs": _legs,
        "poses": _legs,
    }.get(kind.name)
    return look(table, robot) if look is not None else []


def over_pieces(said: Sequence[Sequence[Finding]]) -> list[Finding]:
    """Findings of a long log that was read in pieces: each once, with how many pieces show it."""
    first: dict[tuple[str, str], Finding] = {}
    count: dict[tuple[str, str], int] = {}
    for found in said:
        for finding in found:
            key = (finding.code, finding.where)
            first.setdefault(key, finding)
            count[key] = count.get(key, 0) + 1
    if len(said) == 1:
        return list(first.values())
    return [
        replace(
            finding,
            sentence=f"{finding.sentence} (the first of {count[key]} pieces that show it, of "
            f"{len(said)})",
        )
        for key, finding in first.items()
    ]


def weights_findings(
    tables: Sequence[Table], robot: Robot, intended_load_n: tuple[float, float] | None
) -> list[Finding]:
    """What all weights logs of a run say together."""
    channel = np.concatenate([table.text("channel") for table in tables])
    load, counts = (
        np.concatenate([table.number(name) for table in tables]) for name in ("load_n", "counts")
    )
    names = list(dict.fromkeys(channel))
    bits = robot.adc.bits
    codes = [f for n in names for f in readings.check_codes(n, counts[channel == n], bits)]
    found = _merged([f for f in codes if f.severity == "note"], len(names))
    found += quality.check_load_unit(load, intended_load_n, robot.weight_n)
    session = sessions_in_order(tables)
    for name in names:
        at = channel == name
        found += units.check_units_of_sessions(name, load[at], counts[at], session[at])
        found += bench_rows.check_held(load[at], counts[at], str(name))
    which = np.array([names.index(name) for name in channel], dtype=np.float64)
    found += units.check_units_of_channels(which, load, counts, [str(name) for name in names])
    return found + quality.check_repeats_across_channels(
        {n: counts[channel == n] for n in names}, {n: load[channel == n] for n in names}
    )


def _weights(table: Table, robot: Robot) -> list[Finding]:
    channel = table.text("channel")
    load, counts = table.number("load_n"), table.number("counts")
    # repeats are sessions where no column says these: a zero may move between them
    of = next((name for name in ("session", "repeat") if name in table), None)
    session = np.full(len(table), "") if of is None else table.text(of).astype(str)
    found: list[Finding] = []
    for name in dict.fromkeys(channel):
        mine = channel == name
        found += _codes(name, counts[mine], robot)
        stuck = bench_rows.check_stuck_reading(load[mine], counts[mine], name)
        tared = [
            finding for part in dict.fromkeys(session[mine])
            for at in [mine & (session == part)]
            for check in (bench_rows.check_tare, check_labels)
            for finding in check(load[at], counts[at], name)
        ]  # fmt: skip
        # a stuck cell is said once, not also that it does not follow its loads
        found += stuck or [*tared, *_known(name, load[mine], counts[mine], robot)]
    found += _loads(load, robot)
    if "time_s" in table:
        for name, part in dict.fromkeys(zip(channel, session, strict=True)):
            stamps = table.number("time_s")[(channel == name) & (session == part)]
            where = f"{name} {part}".strip()
            found += stamp_unit(table, stamps, where, _SLOWEST_BENCH_S, by_hand=True)
    return found


def _weights_stream(table: Table, robot: Robot) -> list[Finding]:
    time_s, names = table.number("time_s"), _kept(table)
    found = stamp_unit(table, time_s, table.path.name, _SLOWEST_BENCH_S)
    for name in names:
        values = table.number(name)
        found += _codes(name, values, robot)
        if "load_n" in table:
            cell, load = name.removesuffix("_counts"), table.number("load_n")
            found += _known(cell, load, values, robot)
            found += check_labels(load, values, cell)
    if "load_n" in table:
        found += _loads(table.number("load_n"), robot)
    return found


def _weights_together(table: Table, robot: Robot) -> list[Finding]:
    found: list[Finding] = []
    for name in (str(c) for c in table.data.columns if str(c).endswith("_counts")):
        cell = name.removesuffix("_counts")
        found += _codes(name, table.number(name), robot)
        if f"{cell}_load_n" in table:
            load = table.number(f"{cell}_load_n")
            found += readings.check_known_loads(load, table.number(name), cell)
    loads = [str(c) for c in table.data.columns if str(c).endswith("_load_n")]
    if loads:
        found += _loads(table.numbers(loads).ravel(), robot)
    return found


def _placements(table: Table, robot: Robot) -> list[Finding]:
    found: list[Finding] = []
    names = [str(c) for c in table.data.columns if str(c).endswith("_counts")]
    for name in names:
        found += _codes(name, table.number(name), robot)
    found += _loads(table.number("load_n"), robot)
    found += _exchanged(table, robot)
    furthest = float(np.nanmax(np.abs(table.numbers(["hole_x_m", "hole_y_m"]))))
    if furthest > 2.0:
        found.append(
            Finding(
                "holes_not_metres", "alarm", "hole_x_m, hole_y_m",
                f"a hole lies {furthest:.4g} m from the middle of the foot: it looks given in mm",
                'give the unit in [columns], hole_x_m = { column = "…", unit = "mm" }',
            )
        )  # fmt: skip
    return found


def _exchanged(table: Table, robot: Robot) -> list[Finding]:
    """Cells of a foot that are copied or exchanged, by its placements: means by hole and load."""
    foot, load = table.text("foot"), table.number("load_n")
    hole = table.numbers(["hole_x_m", "hole_y_m"])
    found: list[Finding] = []
    for name, spec in robot.feet.items():
        columns = [f"{cell}_counts" for cell in spec.cells]
        mine = np.flatnonzero(foot == name)
        if not columns or not mine.size or any(c not in table for c in columns):
            continue
        names = [f"{name}_{cell}" for cell in spec.cells]
        rows = np.column_stack([hole, load, table.numbers(columns)])[mine]
        rows = rows[np.isfinite(rows).all(axis=1)]
        _, own = np.unique(rows[:, :3].round(6), axis=0, return_inverse=True)
        own = own.ravel()
        means = np.stack([rows[own == k].mean(axis=0) for k in range(int(own.max(initial=-1)) + 1)])
        found += quality.check_duplicate_channels(rows[:, 3:], names)
        cells = np.array([[cell.x_m, cell.y_m] for cell in spec.cells.values()])
        found += check_exchanged_cells(means[:, 3:], names, cells, means[:, :2], means[:, 2])
        turned = check_shares(rows[:, 3:], names, rows[:, 2], calibrated=False)
        # where no nameplate says which way the bridges read, one may be wired the other way round
        known = robot.nameplate.scale_n_per_count is not None
        found += turned if known else [replace(f, severity="warning") for f in turned]
        if len(means) < 2:  # a file of one placement: nothing there that a cell could follow
            continue
        found += siblings.check_dead_channels(
            rows[:, 3:], names, rows[:, 2:3] * np.column_stack([np.ones(len(rows)), rows[:, :2]])
        )
    return found


def _cells(table: Table, robot: Robot) -> list[Finding]:
    found = _stream(table, robot)
    for foot, spec in robot.feet.items():
        names = [f"{foot}_{cell}" for cell in spec.cells]
        if not names or any(f"{name}_counts" not in table for name in names):
            continue
        values = without_lost(table.numbers([f"{name}_counts" for name in names]), robot)
        found += siblings.check_loose_channels(values, names)
        found += check_loose_cells(values, names)
        still = still_cells(values, names, table.path.name)
        found += still or siblings.check_turned_channels(values, names)
    return found


def _stream(table: Table, robot: Robot) -> list[Finding]:
    """Stamps, and every channel for itself and beside the others."""
    time_s = table.number("time_s")
    at = {n: n.rpartition("_cop_")[0] for n in _kept(table) if n.endswith(("_cop_x_m", "_cop_y_m"))}
    names = [n for n in _kept(table) if n not in at]
    values = without_lost(table.numbers(names), robot)
    found = stamp_unit(table, time_s, table.path.name)
    found += quality.check_order(time_s, table.path.name)
    found += quality.check_frozen(time_s, values, table.path.name)
    found += quality.check_stream(time_s, values, names)
    for foot in dict.fromkeys(at.values()):  # a foot in the air has no CoP: loggers write 0
        stands = np.abs(table.number(f"{foot}_fz_n")) > robot.least_force_n
        own_names = [n for n in at if at[n] == foot]
        found += quality.check_stream(time_s[stands], table.numbers(own_names)[stands], own_names)
    del values
    for name in names:
        own = without_lost(table.number(name), robot)
        if name.endswith("_counts"):
            known = {(f.code, f.where) for f in found}
            found += [f for f in _codes(name, own, robot) if (f.code, f.where) not in known]
            own = np.where(readings.find_end_codes(own, robot.adc.bits), np.nan, own)
        found += readings.check_glitches(own, time_s, name)
    return found


def _body(table: Table, robot: Robot) -> list[Finding]:
    time_s, where = table.number("time_s"), table.path.name
    found = stamp_unit(table, time_s, where)
    found += quality.check_order(time_s, where)
    names = _kept(table)
    for name in names:
        found += check_impossible(table.number(name), name)
    lost = [n for n in names if not np.isfinite(table.number(n)).any()]
    found += quality.check_stream(time_s, table.numbers(lost), lost) if lost else []
    com = table.numbers([f"com_{a}_m" for a in "xyz"])
    found += quality.check_frozen(time_s, com, where)
    feet = [f for f in robot.feet or ("left", "right") if f"{f}_foot_x_m" in table]
    if feet:
        at = [table.numbers([f"{f}_foot_{a}_m" for a in "xyz"]) for f in feet]
        found += check_positions(com, np.stack(at, axis=1), where)
    if "com_acc_x_mps2" in table:
        acc = table.numbers([f"com_acc_{a}_mps2" for a in "xyz"])
        found += body_stream.check_acceleration(time_s, com, acc, robot.gravity_mps2, where)
        found += body_stream.check_saturation(acc, "com_acc")
    if "imu_acc_x_mps2" in table:
        imu = table.numbers([f"imu_acc_{a}_mps2" for a in "xyz"])
        found += body_stream.check_imu(imu, robot.gravity_mps2, where)
        found += body_stream.check_saturation(imu, "imu_acc")
    for foot in feet:
        if f"{foot}_foot_yaw_rad" in table:
            name = f"{foot}_foot_yaw_rad"
            yaw = table.number(name)
            both = (
                (at[feet.index("left")], at[feet.index("right")])
                if {"left", "right"} <= set(feet) else None
            )  # fmt: skip
            found += body_stream.check_heading(time_s, yaw, name, both)
        if f"{foot}_foot_qw" in table:
            columns = [f"{foot}_foot_q{a}" for a in "xyzw"]
            # a link's frame may point anywhere, as transducer_rotation_rpy_rad then says
            spec = robot.feet.get(foot)
            upright = spec is None or not any(spec.transducer_rotation_rpy_rad)
            # with y up in the world it is mostly so in the foot too; a matrix has no order
            upright &= robot.world_up == "+z" and f"{foot}_foot_r11" not in table
            found += body_stream.check_quaternions(
                table.numbers(columns), f"{foot}_foot_qx …", upright=upright
            )
    return found


def _hanging(table: Table, robot: Robot) -> list[Finding]:
    found, leg, lost = _legs(table, robot, upright=False), table.text("leg"), hanging_spells(table)
    for name in dict.fromkeys(leg):
        mine = leg == name
        found += check_spells(name, table.numbers(AXIS_COLUMNS)[mine], lost[mine])
    return found


def _legs(table: Table, robot: Robot, *, upright: bool = True) -> list[Finding]:
    """Hanging and standing robots with transducers at the hips, long form."""
    found: list[Finding] = []
    names = [c for c in _kept(table) if not c.startswith("body_")]  # an arm holds an attitude
    leg = table.text("leg")
    part = table.text("orientation") if "orientation" in table else np.full(len(table), "")
    for name in dict.fromkeys(leg):
        mine = leg == name
        values = table.numbers(names)[mine]
        labels = [f"{name}.{c.rsplit('_', 1)[0]}" for c in names]
        found += quality.check_stream(None, values, labels)
        if "time_s" not in table:
            continue
        for which in dict.fromkeys(part[mine]):
            at = mine & (part == which)
            stamps = table.number("time_s")[at]
            where = f"{name}, {which}".rstrip(", ")
            found += stamp_unit(table, stamps, where, _SLOWEST_LEGS_S, by_hand=True)
            for c, label in zip(names, labels, strict=True):
                alike = [i for i, n in enumerate(names) if n.endswith(c[c.rindex("_") :])]
                step = readings.resolution_of(values[:, alike])
                found += readings.check_glitches(table.number(c)[at], stamps, label, step)
    if "body_qw" in table:
        found += body_stream.check_quaternions(
            table.numbers(QUATERNION), "body_qx …", upright=upright
        )
    return found


def _known(channel: str, load: FloatArray, counts: FloatArray, robot: Robot) -> list[Finding]:
    """A cell against its known loads, and its slope against the nameplate."""
    found = readings.check_known_loads(load, counts, channel)
    plate = robot.nameplate.scale_n_per_count
    good = np.isfinite(load) & np.isfinite(counts)
    if found or not plate or good.sum() < 3 or not np.ptp(counts[good]) > 0:
        return found
    with np.errstate(all="ignore"):
        offset = counts[good] - counts[good].mean()
        scale = float(offset @ load[good] / (offset @ offset))
    return check_scale(channel, scale, plate)


def _loads(load: FloatArray, robot: Robot) -> Iterator[Finding]:
    load = load[np.isfinite(load)]
    if not load.size:
        return
    yield from quality.check_load_unit(load, None, robot.weight_n)
    if not load.any():
        yield Finding(
            "no_load", "warning", "load",
            f"all {load.size} loads are 0 N",
            "check the load column; rows without a load determine only the zero",
        )  # fmt: skip
    if float(load.max()) <= 0.0 and float(load.min()) < 0.0:
        yield Finding(
            "negative_loads", "warning", "load",
            f"all loads are negative ({load.min():.4g} … {load.max():.4g} N): a weight that "
            "presses is positive here",
            "turn the sign of the load column, unless the cells were really pulled",
        )  # fmt: skip


def _codes(name: str, values: FloatArray, robot: Robot) -> list[Finding]:
    """End codes and stuck readings of one channel, lost samples left out."""
    good = values[np.isfinite(values)]
    if not good.size:
        return []
    found = readings.check_codes(name, good, robot.adc.bits)
    return [f for f in found if f.severity == "alarm"]


def _kept(table: Table) -> list[str]:
    """Channels of a stream: number columns but for stamps and drivers."""
    drivers = {"time_s", "load_n", "temperature_degc", "phase_rad", "contact"}
    return [
        str(c)
        for c in table.data.columns
        if c not in drivers
        and not str(c).startswith("gravity_")
        and table.data[c].dtype.kind in "if"
    ]


def _merged(findings: Sequence[Finding], channels: int) -> list[Finding]:
    """One finding for all channels that have the same one."""
    kept: list[Finding] = []
    for code in dict.fromkeys(finding.code for finding in findings):
        alike = [finding for finding in findings if finding.code == code]
        same = len(alike) > 1 and len({f.sentence for f in alike}) == 1
        where = "all channels" if len(alike) == channels else ", ".join(f.where for f in alike)
        kept += [replace(alike[0], where=where)] if same else alike
    return kept
