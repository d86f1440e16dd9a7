"""Whole robots in one table: a transducer per leg, and the attitude of the body alone.

Nothing in these logs says how a transducer is turned in the body; the weight it carries does.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import Array, Made, Rng, Tool, Truth, attitudes, rows, tool_truth, write

WRENCH = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")


def _legs(rng: Rng, names: tuple[str, ...]) -> dict[str, tuple[Tool, Rotation]]:
    """Each leg with its weight, and its transducer's frame: z along the leg, x down."""
    legs = {}
    for azimuth, name in zip(np.linspace(35, 325, len(names)).round(), names, strict=True):
        out = np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth)), 0.0])
        down = np.array([0.0, 0.0, -1.0])
        frame = np.column_stack([down, np.cross(out, down), out])
        weighed = Tool(
            float(rng.uniform(12, 30)), np.array([0.11, 0.0, 0.17]) + rng.normal(0, 0.006, 3),
            rng.normal(0, 1, 6) * np.array([5, 5, 5, 0.3, 0.3, 0.3]),
        )  # fmt: skip
        legs[name] = weighed, Rotation.from_matrix(frame)
    return legs


def _hung(
    rng: Rng, names: tuple[str, ...], holds: int = 14, hold: int = 40
) -> tuple[dict[str, Array], Array, Rotation, Truth]:
    """Wrench of each leg (n, 6), stamps in s, attitudes of the body, the truth."""
    legs = _legs(rng, names)
    rot, _ = attitudes(rng, holds, hold)
    body = Rotation.from_matrix(rot)
    down = body.inv().apply([0.0, 0.0, -1.0])
    wrenches: dict[str, Array] = {}
    values: dict[str, float] = {}
    within: dict[str, float] = {}
    for name, (weighed, frame) in legs.items():
        wrenches[name] = weighed.read(frame.inv().apply(down), rng)
        truth = tool_truth(weighed, name)
        values |= truth.values
        within |= truth.within
    t = np.arange(len(rot)) / 50.0
    return wrenches, t, body, Truth(values, within)


def hexapod_wide_in_degrees(to: Path, rng: Rng) -> Made:
    """Three legs a side called L1 … R3, stamps in ms, the inertial unit's angles in degrees."""
    wrenches, t, body, truth = _hung(rng, ("L1", "L2", "L3", "R3", "R2", "R1"))
    angles = body.as_euler("ZYX", degrees=True)
    head = ["Time_ms", "imu_yaw_deg", "imu_pitch_deg", "imu_roll_deg"]
    head += [f"{leg}_{axis}" for leg in wrenches for axis in WRENCH]
    lines = rows(1e3 * t, *angles.T, *np.hstack(list(wrenches.values())).T, form="%.7g")
    return Made([write(to / "hang.csv", [",".join(head), *lines])], truth)


def quadruped_long_pushes(to: Path, rng: Rng) -> Made:
    """A row per leg, a quaternion scalar first, and transducers that read what they exert."""
    wrenches, t, body, truth = _hung(rng, ("LF", "LH", "RH", "RF"))
    q = np.roll(body.as_quat(), 1, axis=1)
    lines = ["stamp,leg,force_x,force_y,force_z,torque_x,torque_y,torque_z,qw,qx,qy,qz"]
    for i, stamp in enumerate(t):
        for leg, wrench in wrenches.items():
            said = ",".join(f"{v:.6f}" for v in (*-wrench[i], *q[i]))
            lines.append(f"{stamp:.3f},{leg},{said}")
    return Made([write(to / "suspended.csv", lines)], truth)


def tool_in_the_arms_frame(to: Path, rng: Rng) -> Made:
    """A tool whose sensor is turned by 30° about the flange's axis; the arm logs the flange."""
    legs = _legs(rng, ("ft",))
    weighed, _ = legs["ft"]
    rot, _ = attitudes(rng, 12, 40)
    body = Rotation.from_matrix(rot)
    turn = Rotation.from_euler("z", 30, degrees=True)
    wrench = weighed.read(turn.inv().apply(body.inv().apply([0.0, 0.0, -1.0])), rng)
    lines = rows(np.arange(len(rot)) / 100, *wrench.T, *body.as_quat().T)
    head = "time,ft_fx,ft_fy,ft_fz,ft_tx,ft_ty,ft_tz,flange_qx,flange_qy,flange_qz,flange_qw"
    return Made([write(to / "arm.csv", [head, *lines])], tool_truth(weighed))


def hexapod_standing(to: Path, rng: Rng) -> Made:
    """Seventy standing poses: no leg carries its own weight alone."""
    legs = _legs(rng, ("L1", "L2", "L3", "R3", "R2", "R1"))
    body = Rotation.from_euler("ZYX", rng.uniform(-0.2, 0.2, (70, 3)))
    down = body.inv().apply([0.0, 0.0, -1.0])
    columns = [np.arange(1.0, 71.0), *body.as_euler("ZYX", degrees=True).T]
    for weighed, frame in legs.values():
        loads = -60 * down + rng.normal(0, 20, (70, 3)) + weighed.weight_n * down
        force = frame.inv().apply(loads)
        torque = rng.normal(0, 3, (70, 3))
        columns += list((np.hstack([force, torque]) + weighed.offset).T)
    head = ["pose", "yaw_deg", "pitch_deg", "roll_deg"]
    head += [f"{leg}_{axis}" for leg in legs for axis in WRENCH]
    lines = rows(*columns, form="%.7g")
    return Made([write(to / "poses.csv", [",".join(head), *lines])], says="where the transducers")


LEGGED = (hexapod_wide_in_degrees, quadruped_long_pushes, tool_in_the_arms_frame, hexapod_standing)
