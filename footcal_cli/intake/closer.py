"""What `check` asks of each kind of log beyond what every command hears (`core.checks`)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from footcal_cli.core.checks import holes, legs, loads, streams
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import span_of
from footcal_cli.core.spatial import rotation_of_quaternion, rotations_of_rpy
from footcal_cli.recipe import Robot
from footcal_cli.session.unloaded import without_lost
from footcal_cli.tables.columns import AXIS_COLUMNS, QUATERNION
from footcal_cli.tables.table import Table

LIFTED = 0.8
"""Share of the weight that a foot's force must run through where the foot is lifted."""


def look_closer(by_kind: dict[str, list[Table]], robot: Robot) -> list[Finding]:
    """All that the logs of one run say, by their kinds."""
    found: list[Finding] = []
    for table in by_kind.get("weights", ()):
        found += _weights(table)
    for table in by_kind.get("placements", ()):
        found += _placements(table, robot)
    for table in by_kind.get("hang", ()):
        found += _hangings(table)
    for table in by_kind.get("poses", ()):
        found += _poses(table, robot)
    cells, bodies = by_kind.get("cells", []), by_kind.get("body", [])
    for table in cells:
        found += _cells(table, robot)
    if len(cells) == len(bodies) == 1:
        found += _sides(cells[0], bodies[0], robot)
    return found


def _weights(table: Table) -> list[Finding]:
    channel, load = table.text("channel"), table.number("load_n")
    label = table.text("session") if "session" in table else np.full(len(table), "")
    part = np.unique(label, return_inverse=True)[1].astype(float)
    counts = table.number("counts")
    cells = {
        name: (load[channel == name], counts[channel == name], part[channel == name])
        for name in dict.fromkeys(channel)
    }
    found = [one for name, rows in cells.items() for one in loads.check_line(name, *rows)]
    return found + loads.check_exchanged(cells)


def _placements(table: Table, robot: Robot) -> list[Finding]:
    found: list[Finding] = []
    foot, hole = table.text("foot"), table.numbers(["hole_x_m", "hole_y_m"])
    load = table.number("load_n")
    for name, spec in robot.feet.items():
        columns = [f"{cell}_counts" for cell in spec.cells]
        if len(columns) < 3 or any(c not in table for c in columns):
            continue
        counts = table.numbers(columns)
        mine = (foot == name) & np.isfinite(counts).all(axis=1) & np.isfinite(load)
        if not mine.any():
            continue
        # by its place too: one name may stand for several holes
        keys = [
            f"{p} at {1e3 * x:.0f}, {1e3 * y:.0f} mm"
            for p, (x, y) in zip(table.text("placement")[mine], hole[mine], strict=True)
        ]
        labels, own = np.unique(keys, return_inverse=True)
        cells = np.array([[cell.x_m, cell.y_m] for cell in spec.cells.values()])
        found += holes.check_holes(
            name, tuple(map(str, labels)), own, counts[mine], hole[mine], load[mine], cells
        )
    return found


def _hangings(table: Table) -> list[Finding]:
    if "orientation" not in table or any(c not in table for c in AXIS_COLUMNS):
        return []
    leg, orientation = table.text("leg"), table.text("orientation")
    wrench = table.numbers(list(AXIS_COLUMNS))
    found: list[Finding] = []
    names = list(dict.fromkeys(leg))
    for name in names:
        mine = leg == name
        hung = {o: wrench[mine & (orientation == o)] for o in dict.fromkeys(orientation[mine])}
        found += legs.check_hangings(str(name), hung)
    if "phase_rad" in table:
        keys = [f"{a} {b}" for a, b in zip(leg, orientation, strict=True)]
        part = np.unique(keys, return_inverse=True)[1].astype(float)
        found += legs.check_phase_unit(table.number("phase_rad"), wrench[:, 3:], part)
    return found


def _poses(table: Table, robot: Robot) -> list[Finding]:
    """Poses in their order, all legs of each in the body frame."""
    columns = [*AXIS_COLUMNS, *QUATERNION]
    if any(c not in table for c in columns):
        return []
    pose, leg = table.text("pose"), table.text("leg")
    poses, names = list(dict.fromkeys(pose)), tuple(dict.fromkeys(map(str, leg)))
    if any(name not in robot.legs for name in names) or len(set(zip(pose, leg, strict=True))) < len(
        table
    ):
        return []
    row = np.array([poses.index(p) for p in pose])
    column = np.array([names.index(str(name)) for name in leg])
    wrench = np.full((len(poses), len(names), 6), np.nan)
    turn = rotations_of_rpy(np.array([robot.legs[name].rotation_rpy_rad for name in names]))
    own = table.numbers(list(AXIS_COLUMNS))
    for half in (slice(0, 3), slice(3, 6)):
        wrench[row, column, half] = np.einsum("nij,nj->ni", turn[column], own[:, half])
    contact = np.ones((len(poses), len(names)), dtype=bool)
    if "contact" in table:
        contact[row, column] = table.number("contact") > 0.5
    attitude = np.full((len(poses), 4), np.nan)
    attitude[row] = table.numbers(columns[6:])
    length = np.linalg.norm(attitude, axis=1)
    if not np.allclose(length[np.isfinite(length)], 1.0, atol=1e-2):
        return []
    rotation = rotation_of_quaternion(attitude)
    return legs.check_poses(
        names, wrench, contact, rotation[:, 2, :], rotation[:, :, 2], robot.weight_n
    )


def _cells(table: Table, robot: Robot) -> list[Finding]:
    time_s, found = table.number("time_s"), list[Finding]()
    scale, weight_n = robot.nameplate.scale_n_per_count, robot.weight_n
    feet = [f for f, spec in robot.feet.items() if _has(table, f, tuple(spec.cells))]
    totals = []
    for foot in feet:
        names = [f"{foot}_{cell}" for cell in robot.feet[foot].cells]
        values = without_lost(table.numbers([f"{n}_counts" for n in names]), robot)
        for i, name in enumerate(names):
            found += streams.check_word(name, values[:, i])
        # standing loads siblings alike; only a foot that is lifted shows a cell's own gain
        if scale and weight_n and abs(scale) * span_of(values.sum(axis=1)) > LIFTED * weight_n:
            found += streams.check_gains_halfway(values, names)
        found += streams.check_hum(time_s, values, names)
        totals.append(values.sum(axis=1))
        del values
    if totals and len(feet) == len(robot.feet) and scale and weight_n:
        force = scale * np.column_stack(totals)
        totals.clear()
        found += streams.check_feet_together(time_s, force, feet, weight_n)
    return found


def _has(table: Table, foot: str, cells: Sequence[str]) -> bool:
    return bool(cells) and all(f"{foot}_{cell}_counts" in table for cell in cells)


def _sides(cells: Table, body: Table, robot: Robot) -> Iterable[Finding]:
    """Which foot carries, and which is in the air, by two logs of one walk."""
    sides = ("left", "right")
    known = [f"{side}_foot_{a}_m" for side in sides for a in "xyz"]
    scale = robot.nameplate.scale_n_per_count
    if set(robot.feet) != set(sides) or any(c not in body for c in known) or not scale:
        return []
    if not all(_has(cells, side, tuple(robot.feet[side].cells)) for side in sides):
        return []
    force = [
        scale * cells.numbers([f"{s}_{c}_counts" for c in robot.feet[s].cells]).sum(axis=1)
        for s in sides
    ]
    at = np.stack([body.numbers([f"{s}_foot_{a}_m" for a in "xyz"]) for s in sides], axis=1)
    time_s, own = body.number("time_s"), cells.number("time_s")
    order = np.argsort(own, kind="stable")
    carried = np.column_stack([np.interp(time_s, own[order], f[order]) for f in force])
    seen = [carried, at[:, :, 2]]
    if not all(np.isfinite(each).any(axis=0).all() for each in seen):
        return []  # a foot of which nothing is known
    carried -= np.nanmin(carried, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = carried / carried.sum(axis=1)[:, None]
    height = at[:, :, 2] - np.nanmin(at[:, :, 2], axis=0)
    across = np.full(len(at), np.nan)
    if "left_foot_yaw_rad" in body:
        yaw = body.number("left_foot_yaw_rad")
        apart = at[:, 0, :2] - at[:, 1, :2]
        across = -np.sin(yaw) * apart[:, 0] + np.cos(yaw) * apart[:, 1]
    return streams.check_sides(share, height, across, sides)
