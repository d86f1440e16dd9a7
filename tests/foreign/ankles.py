"""Six-axis transducers at the ankles of a biped: Newton and Euler of a foot."""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from tests.foreign.biped import FEET, GRAVITY_MPS2, Biped
from tests.foreign.motion import FINE_HZ, Motion, rate
from tests.foreign.noise import Array, Rng, coloured, slow, stream

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
UNITS = ("n", "n", "n", "nm", "nm", "nm")


def ankle_offsets(robot: Biped) -> Array:
    """Offsets of both transducers (2, 6): a few per cent of the weight."""
    rng = stream(round(1e6 * robot.mass_kg), "ankles")
    sd = robot.weight_n * np.array([0.03] * 3 + [0.006 * robot.leg_m] * 3)
    return np.asarray(sd * rng.normal(size=(2, 6)))


def sole(robot: Biped, yaw: Array, pitch: Array) -> Rotation:
    """Attitude of a sole that pitches, and rolls where the ankle has two axes."""
    roll = robot.kind.ankle_roll / 0.08 * np.abs(pitch)
    return Rotation.from_euler("ZYX", np.column_stack([yaw, pitch, roll]))


def foot_attitude(robot: Biped, foot: str, yaw: Array, pitch: Array) -> dict[str, Array]:
    """Columns of a foot's attitude: yaw of one that stands on cells, a quaternion else."""
    if robot.kind.cells:
        return {f"{foot}_foot_yaw_rad": yaw}
    quat = sole(robot, yaw, pitch).as_quat()
    return {f"{foot}_foot_q{a}": quat[:, i] for i, a in enumerate("xyzw")}


def sole_origins(robot: Biped, ankles_m: Array, yaw: Array, pitch: Array) -> Array:
    """Origins of the sole frames of ankles (n, 2, 3): below these along the sole's own axis.

    On cells nobody logs pitch and roll: there the frame stays level.
    """
    up = np.array([0.0, 0.0, robot.ankle_m])
    if robot.kind.cells:
        return np.asarray(ankles_m - up)
    turn = [sole(robot, yaw[:, side], pitch[:, side]) for side in range(len(FEET))]
    return np.asarray(ankles_m - np.stack([one.apply(up) for one in turn], axis=1))


def ankles(
    robot: Biped, motion: Motion, rng: Rng, hz: float, _distort: object, _drift: object
) -> pd.DataFrame:
    """Wrenches: the ground's through the cells of the soles, less the foot's weight and inertia."""
    plan, count = motion.plan, len(robot.cells)
    time_s = np.arange(plan.time_s[0] + 0.01, plan.time_s[-1] - 0.01, 1.0 / hz)
    columns: dict[str, Array] = {"time_s": np.asarray(np.round(time_s, 5), dtype=np.float64)}
    push = robot.mass_kg * motion.com_acc_mps2[:, :2]
    for side, foot in enumerate(FEET):
        turn = sole(robot, plan.yaw_rad[:, side], plan.pitch_rad[:, side])
        cells = motion.ground_n[:, count * side : count * (side + 1)]
        normal = cells.sum(axis=1)
        share = plan.share[:, side : side + 1]
        cop = np.column_stack([cells @ robot.cells_m, -robot.ankle_m * normal])
        cop = cop / np.maximum(normal, 1e-9)[:, None]
        ground = turn.inv().apply(np.column_stack([push * share, normal]))
        twist = 0.005 * robot.kind.size * normal * slow(rng, len(normal), 1, 400.0)[:, 0]
        arm = np.array(robot.com_below_m)
        at = plan.feet_m[:, side] + np.array([0, 0, robot.ankle_m]) + turn.apply(arm)
        specific = rate(rate(at)) + np.array([0.0, 0.0, GRAVITY_MPS2])
        below = -robot.below_kg * turn.inv().apply(specific)
        torque = np.cross(cop, ground) + np.cross(arm, below)
        torque[:, 2] += twist
        wrench = np.column_stack([ground + below, torque]) + ankle_offsets(robot)[side]
        seen = np.stack([np.interp(time_s, plan.time_s, w) for w in _averaged(wrench).T], axis=1)
        sd = robot.sd_n * np.array([1.0, 1.0, 1.0, *[0.1 * robot.leg_m] * 3])
        seen = seen + sd * coloured(rng, len(time_s), 6, 0.1 * hz)
        for i, (axis, unit) in enumerate(zip(AXES, UNITS, strict=True)):
            columns[f"{foot}_{axis}_{unit}"] = seen[:, i]
    return pd.DataFrame(columns)


def _averaged(values: Array) -> Array:
    """Means over some milliseconds, as a transducer's filter takes them."""
    window = np.ones(round(0.0075 * FINE_HZ)) / round(0.0075 * FINE_HZ)
    return np.stack([np.convolve(c, window, "same") for c in values.T], axis=1)
