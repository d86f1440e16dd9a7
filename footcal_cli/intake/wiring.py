"""What a walk or a stand says of its own wiring: exchanged, copied, frozen or turned channels."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.checks.streams import check_zeros
from footcal_cli.core.effects.calibration import AXES, AXIS_UNITS
from footcal_cli.core.effects.contract import Scope, columns_of, is_six_axis
from footcal_cli.core.effects.usual import middles_of_feet
from footcal_cli.core.experiments.walk import channel_contact, feet_of, reference_of
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.streams import Merged
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.plausibility import check_total_force
from footcal_cli.core.quality import Finding
from footcal_cli.core.wiring import check_balanced, check_channels_walking, check_exchanged_feet

_MOST_ROWS = 600
"""Of a recording, to see whether cells are exchanged: neighbours tell the same."""


def wiring_of(merged: Merged, belief: Belief | None, experiment: str) -> list[Finding]:
    """Exchanged cells; of a walk, copied or frozen ones and moving zeros; turned transducers."""
    log = merged.log
    if belief is None:
        from footcal_cli.core.pose.feet_balance import balance_of_feet, check_axes_of_feet
        from footcal_cli.core.pose.turned import check_turned_feet

        walks = experiment == "walk"
        feet = _feet_exchanged(log, log.readings) if walks else []
        moved = _zeros(merged, log.readings) if walks else []
        rows = balance_of_feet(log)
        turned = rows and (check_turned_feet(rows) or check_axes_of_feet(rows))
        return feet or [*_carried(merged), *(turned or ()), *moved]
    if experiment != "walk":
        return _exchanged(log, belief)
    forces = belief.forces(merged.raw)
    wrong = check_channels_walking(log.time_s, forces, log.channels)
    wrong = wrong or _feet_exchanged(log, forces)
    return wrong or [*_zeros(merged, forces), *_exchanged(log, belief)]


def _zeros(merged: Merged, forces_n: FloatArray) -> list[Finding]:
    """Sensors that read another force in the air at the end of a walk than at its beginning."""
    log, forces = merged.log, np.arange(merged.log.readings.shape[1])
    if is_six_axis(log.channels):
        forces = forces[forces % len(AXES) < AXIS_UNITS.index("Nm")]
    in_air = channel_contact(log)[:, forces] == 0.0
    names = [log.channels[i] for i in forces]
    return check_zeros(forces_n[:, forces], in_air, names, merged.weight_n)


def _exchanged(log: Log, belief: Belief) -> list[Finding]:
    """Cells of turned sign, or whose plugs are exchanged, by the CoP that the motion demands."""
    reference = reference_of(log)
    arms = log.known["cell_pos_m"] - reference.cop_m[:, None]
    known = np.isfinite(reference.fz_n) & np.isfinite(arms).all(axis=(1, 2))
    stands = (np.nan_to_num(log.known["contact"]) != 0.0).any(axis=1)
    rows = np.flatnonzero(known & stands & np.isfinite(log.readings).all(axis=1))
    if rows.size:
        rows = _unhurried(log, reference.cop_m, rows)
        rows = rows[:: max(rows.size // _MOST_ROWS, 1)]
    if not rows.size:  # insoles without a robot, or a few rows, know no CoP that is demanded
        return []
    forces = belief.forces(log.readings[rows])
    return check_balanced(forces, log.channels, arms[rows], reference.fz_n[rows])


def _feet_exchanged(log: Log, readings: FloatArray) -> list[Finding]:
    """Two feet that carry each other's load, by when they move."""
    feet = feet_of(log)
    if is_six_axis(log.channels):
        load = _vertical(log, readings)
    else:
        own = columns_of(Scope.FOOT, log.channels)
        load = np.stack([readings[:, cells].sum(axis=1) for cells in own], axis=1)
    soles = middles_of_feet(log)
    if soles is None:
        return []
    speed = np.hypot(*np.moveaxis(np.gradient(soles, log.time_s, axis=0), -1, 0))
    return check_exchanged_feet(load, speed, feet)


def _unhurried(log: Log, cop_m: FloatArray, rows: IntArray) -> IntArray:
    """The half of these rows in which the demanded CoP moves least: a delay hardly shows there."""
    speed = np.hypot(*np.gradient(cop_m, log.time_s, axis=0).T)[rows]
    known = np.isfinite(speed)
    rows, speed = rows[known], speed[known]
    return rows[speed <= np.median(speed)] if rows.size else rows


def _carried(merged: Merged) -> list[Finding]:
    """Vertical force of six-axis feet against the weight of the robot."""
    log = merged.log
    total = _vertical(log, log.readings).sum(axis=1) + log.known["foot_weight_n"].sum(axis=1)
    return check_total_force(total, merged.weight_n, "all feet")


def _vertical(log: Log, readings: FloatArray) -> FloatArray:
    """Force along the world's z of each transducer, however it is mounted, shape (n, feet), N."""
    up_t = log.known["foot_rot_wt"][:, :, 2, :]
    force = readings.reshape(*up_t.shape[:2], 6)[..., :3]
    return np.asarray(np.einsum("nkj,nkj->nk", up_t, force))
