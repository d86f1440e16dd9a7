"""Reference motions of the biped: footsteps, ZMP, centre of mass, leg inverse kinematics.

Frames: x forward, y left, z up, ground at z = 0; SI units. A foot pose is (x, y, z, yaw) of the
sole frame, whose origin lies on the sole under the ankle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

Array = NDArray[np.float64]

GRAVITY_MPS2 = 9.80665
HIP_OFFSET_M = 0.05
THIGH_M = 0.12
SHANK_M = 0.12
ANKLE_HEIGHT_M = 0.05
COM_HEIGHT_M = 0.274
"""Height of the whole-robot CoM in the normal stance; the hips are then about 0.27 m up."""
SOLE_CENTRE_X_M = 0.01
"""Centre of the four pads in the sole frame."""

PERIOD_S = 0.005
"""Sampling of reference motions, and period of the joint controller."""
STANDING_S = 2.0
FIRST_SHIFT_S, REST_S = 0.4, 1.0
"""What the first shift of weight takes beyond a double support, and the rest after a walk."""
STEP_S = 0.6
DOUBLE_SUPPORT_S = 0.16
LIFT_M = 0.02
ZMP_ROLL_M = 0.02
"""The ZMP travels from this far behind to this far before the sole centre in single support."""
ZMP_SMOOTHING_S = 0.1
STEP_SD_M, STEP_SD_RAD = 0.002, 0.01
"""Irregularity of the footsteps."""
SHIFT_S, STANCE_SWING_S, SETTLE_S = 1.0, 0.8, 0.5
"""Standing: durations of a shift of weight, of a single step, and of coming to rest after it."""


@dataclass(frozen=True)
class Plan:
    """Reference motion sampled every `PERIOD_S`.

    Parameters
    ----------
    com_m : (n, 3) centre of mass
    zmp_m : (n, 2) zero-moment point
    feet_m : (n, 2, 4) x, y, z (m) and yaw (rad) of the left and the right sole
    left_share : (n,) part of the weight on the left foot, 0 to 1
    stances : quiet stretches as (name, start_s, end_s)
    """

    com_m: Array
    zmp_m: Array
    feet_m: Array
    left_share: Array
    stances: tuple[tuple[str, float, float], ...] = ()

    @property
    def duration_s(self) -> float:
        """Return the time of the last sample."""
        return (len(self.com_m) - 1) * PERIOD_S

    @property
    def yaw_rad(self) -> Array:
        """Return the heading of the torso, half-way between the feet."""
        return np.asarray(self.feet_m[:, :, 3].mean(axis=1))

    @property
    def com_acc_mps2(self) -> Array:
        """Return the acceleration of the CoM, (n, 3)."""
        return rate(rate(self.com_m))

    def with_angular_momentum(self, rate_nm: Array, mass_kg: float) -> Plan:
        """Return the plan with the CoM path that keeps the ZMP, given L' (n, 3) about the CoM.

        [NAO], eqs. (10) and (11): the pendulum must follow p + (L'_y, -L'_x) / (m (g + z'')).
        """
        fz = mass_kg * (GRAVITY_MPS2 + self.com_acc_mps2[:, 2:])
        shift = np.column_stack([rate_nm[:, 1], -rate_nm[:, 0]]) / fz
        com = com_from_zmp(self.zmp_m + shift, self.com_m[:, 2])
        return replace(self, com_m=np.column_stack([com, self.com_m[:, 2]]))


def rate(x: Array) -> Array:
    """Return the time derivative of samples every `PERIOD_S`."""
    return np.asarray(np.gradient(x, PERIOD_S, axis=0))


def smooth_step(phase: Array) -> Array:
    """Return the minimum-jerk rise from 0 to 1 over phase 0 to 1, clipped outside."""
    s = np.clip(phase, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))


def com_from_zmp(zmp_m: Array, com_z_m: Array) -> Array:
    """Return the CoM path (n, 2) whose ZMP is `zmp_m` (n, 2), at rest over it at both ends.

    p = c - z c'' / (g + z''), as one tridiagonal system in c (Kagami et al., Auton. Robots 12,
    2002): the limit of Kajita's preview control for a long preview and no penalty on jerk.
    """
    k = com_z_m / (GRAVITY_MPS2 + rate(rate(com_z_m))) / PERIOD_S**2
    k[[0, -1]] = 0.0
    bands = np.zeros((3, len(k)))
    bands[0, 1:] = -k[:-1]
    bands[1] = 1.0 + 2.0 * k
    bands[2, :-1] = -k[1:]
    return np.asarray(solve_banded((1, 1), bands, zmp_m))


@dataclass
class _Script:
    """Timed key points from which a plan is sampled."""

    feet: Array
    zmp: list[tuple[float, float, float, float]]
    height: list[tuple[float, float]]
    swings: list[tuple[float, float, int, Array]]
    stances: list[tuple[str, float, float]]

    @classmethod
    def standing(cls) -> _Script:
        """Return a script that begins in the normal stance."""
        feet = np.array([[0.0, HIP_OFFSET_M, 0.0, 0.0], [0.0, -HIP_OFFSET_M, 0.0, 0.0]])
        return cls(feet, [(0.0, SOLE_CENTRE_X_M, 0.0, 0.5)], [(0.0, COM_HEIGHT_M)], [], [])

    def hold_zmp(self, until_s: float) -> None:
        """Keep the ZMP where it is."""
        self.zmp.append((until_s, *self.zmp[-1][1:]))

    def move_zmp(self, until_s: float, point_m: Array, left_share: float) -> None:
        """Move the ZMP in a straight line."""
        self.zmp.append((until_s, float(point_m[0]), float(point_m[1]), left_share))

    def plan(self, duration_s: float) -> Plan:
        """Sample the script."""
        t: Array = np.arange(round(duration_s / PERIOD_S) + 1, dtype=float) * PERIOD_S
        keys = np.array(self.zmp)
        window = np.hanning(2 * round(ZMP_SMOOTHING_S / 2 / PERIOD_S) + 3)[1:-1]
        x, y, left_share = (
            _filtered(np.interp(t, keys[:, 0], keys[:, i]), window) for i in (1, 2, 3)
        )
        zmp = np.column_stack([x, y])
        z = np.full(len(t), self.height[0][1])
        for (start, _), (end, target) in zip(self.height, self.height[1:], strict=False):
            z += (target - z) * smooth_step((t - start) / max(end - start, PERIOD_S))
        com = np.column_stack([com_from_zmp(zmp, z), z])
        feet = np.tile(self.feet, (len(t), 1, 1))
        for lift, land, side, pose in self.swings:
            phase = (t - lift) / (land - lift)
            across = smooth_step(phase)
            feet[:, side] += (pose - feet[:, side]) * across[:, None]
            s = np.clip(phase, 0.0, 1.0)
            feet[:, side, 2] += LIFT_M * (4.0 * s * (1.0 - s)) ** 2
        return Plan(com, zmp, feet, left_share, tuple(self.stances))


def _filtered(x: Array, window: Array) -> Array:
    """Return `x` smoothed by a symmetric window of odd length, ends held."""
    half = len(window) // 2
    return np.convolve(np.pad(x, half, mode="edge"), window / window.sum(), mode="valid")


def ground_point(foot_m: Array, forward_m: float = SOLE_CENTRE_X_M) -> Array:
    """Return the (x, y) of a point on the long axis of a sole, given in the sole frame."""
    return foot_m[:2] + forward_m * np.array([np.cos(foot_m[3]), np.sin(foot_m[3])])


def plan_walk(
    speed_mps: float, duration_s: float, rng: np.random.Generator, turn_radps: float = 0.0
) -> Plan:
    """Return a walk: 2 s of standing, then steps of `STEP_S` to the end, a little irregular."""
    script = _Script.standing()
    feet = script.feet.copy()
    script.hold_zmp(STANDING_S)
    start, centre, heading, side = STANDING_S + FIRST_SHIFT_S, np.zeros(2), 0.0, 1
    while start < duration_s + STEP_S:
        lift, land = start + DOUBLE_SUPPORT_S, start + STEP_S
        support = feet[1 - side]
        script.move_zmp(lift, ground_point(support, SOLE_CENTRE_X_M - ZMP_ROLL_M), side)
        script.move_zmp(land, ground_point(support, SOLE_CENTRE_X_M + ZMP_ROLL_M), side)
        heading += turn_radps * STEP_S
        ahead = np.array([np.cos(heading), np.sin(heading)])
        centre = centre + ahead * speed_mps * STEP_S
        offset = HIP_OFFSET_M * (1 - 2 * side) * np.array([-ahead[1], ahead[0]])
        x, y = centre + offset + rng.normal(0.0, STEP_SD_M, 2)
        feet[side] = [x, y, 0.0, heading + rng.normal(0.0, STEP_SD_RAD)]
        script.swings.append((lift, land, side, feet[side].copy()))
        start, side = land, 1 - side
    middle = (ground_point(feet[0]) + ground_point(feet[1])) / 2.0
    script.move_zmp(start + DOUBLE_SUPPORT_S, middle, 0.5)
    return script.plan(start + DOUBLE_SUPPORT_S + REST_S)


@dataclass(frozen=True)
class Stance:
    """A quiet stance.

    Parameters
    ----------
    name : its name
    left_m, right_m : x, y (m) and yaw (rad) of the soles
    weight : where the weight is, from -1 (right sole centre) to 1 (left sole centre)
    forward_m : CoM before the line of the sole centres
    com_z_m : height of the CoM
    """

    name: str
    left_m: tuple[float, float, float] = (0.0, HIP_OFFSET_M, 0.0)
    right_m: tuple[float, float, float] = (0.0, -HIP_OFFSET_M, 0.0)
    weight: float = 0.0
    forward_m: float = 0.0
    com_z_m: float = COM_HEIGHT_M


STANCES = (
    Stance("normal"),
    Stance("weight left", weight=0.5),
    Stance("weight right", weight=-0.5),
    Stance("weight front", forward_m=0.03),
    Stance("weight back", forward_m=-0.03),
    Stance("squat", com_z_m=COM_HEIGHT_M - 0.02),
    Stance("deep squat", com_z_m=COM_HEIGHT_M - 0.04),
    Stance("squat, weight left and front", weight=0.4, forward_m=0.02, com_z_m=0.26),
    Stance("left foot ahead", left_m=(0.06, 0.05, 0.0)),
    Stance("left foot ahead, weight left", left_m=(0.06, 0.05, 0.0), weight=0.6),
    Stance("left foot ahead, weight right", left_m=(0.06, 0.05, 0.0), weight=-0.6),
    Stance("wide", right_m=(0.0, -0.08, 0.0)),
    Stance("wide, weight right", right_m=(0.0, -0.08, 0.0), weight=-0.6),
    Stance("right foot turned out", right_m=(0.0, -0.06, -0.4)),
    Stance("right foot turned out, weight front", right_m=(0.0, -0.06, -0.4), forward_m=0.02),
    Stance("left foot back and turned out", left_m=(-0.05, 0.06, 0.3), right_m=(0.0, -0.06, 0.0)),
)


def plan_stand(stances: Sequence[Stance], seconds_each: float) -> Plan:
    """Return quiet stances of `seconds_each`, joined by slow shifts of weight and single steps."""
    script = _Script.standing()
    feet = script.feet.copy()
    t = STANDING_S
    script.hold_zmp(t)
    for stance in stances:
        script.height.append((t, script.height[-1][1]))
        for side, pose in enumerate((stance.left_m, stance.right_m)):
            target = np.array([pose[0], pose[1], 0.0, pose[2]])
            if np.allclose(target, feet[side]):
                continue
            script.move_zmp(t + SHIFT_S, ground_point(feet[1 - side]), side)
            script.swings.append((t + SHIFT_S, t + SHIFT_S + STANCE_SWING_S, side, target))
            feet[side] = target
            t += SHIFT_S + STANCE_SWING_S
            script.hold_zmp(t)
        left, right = ground_point(feet[0]), ground_point(feet[1])
        yaw = feet[:, 3].mean()
        ahead = stance.forward_m * np.array([np.cos(yaw), np.sin(yaw)])
        share = (1.0 + stance.weight) / 2.0
        script.move_zmp(t + SHIFT_S, share * left + (1.0 - share) * right + ahead, share)
        t += SHIFT_S
        script.height.append((t, stance.com_z_m))
        t += SETTLE_S
        script.stances.append((stance.name, t, t + seconds_each))
        t += seconds_each
        script.hold_zmp(t)
    return script.plan(t)


def leg_angles(hip_m: Array, torso_yaw_rad: float, foot_m: Array) -> Array:
    """Return the six joint angles that put a flat sole at `foot_m` (x, y, z, yaw), torso upright.

    Order: hip yaw, roll, pitch, knee, ankle pitch, roll (rad). Closed form for hip axes that
    meet and ankle axes that meet (Kajita et al., Introduction to Humanoid Robotics, 2.5).

    Raises
    ------
    ValueError : the sole is out of reach
    """
    ankle = foot_m[:3] + np.array([0.0, 0.0, ANKLE_HEIGHT_M])
    c, s = np.cos(foot_m[3]), np.sin(foot_m[3])
    d = hip_m - ankle
    x, y, z = c * d[0] + s * d[1], -s * d[0] + c * d[1], d[2]
    length = np.sqrt(x * x + y * y + z * z)
    if length > THIGH_M + SHANK_M:
        raise ValueError(f"leg of {THIGH_M + SHANK_M:.3f} m cannot span {length:.3f} m")
    cos_knee = (THIGH_M**2 + SHANK_M**2 - length**2) / (2.0 * THIGH_M * SHANK_M)
    knee = np.pi - np.arccos(cos_knee)
    ankle_roll = np.arctan2(y, z)
    ankle_pitch = -np.arctan2(x, np.hypot(y, z)) - np.arcsin(THIGH_M * np.sin(knee) / length)
    thigh = (
        _rotation_z(foot_m[3] - torso_yaw_rad)
        @ _rotation_x(-ankle_roll)
        @ _rotation_y(-knee - ankle_pitch)
    )
    yaw = np.arctan2(-thigh[0, 1], thigh[1, 1])
    roll = np.arctan2(thigh[2, 1], np.hypot(thigh[0, 1], thigh[1, 1]))
    pitch = np.arctan2(-thigh[2, 0], thigh[2, 2])
    return np.array([yaw, roll, pitch, knee, ankle_pitch, ankle_roll])


def _rotation_x(a: float) -> Array:
    c, s = np.cos(a), np.sin(a)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _rotation_y(a: float) -> Array:
    c, s = np.cos(a), np.sin(a)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def _rotation_z(a: float) -> Array:
    c, s = np.cos(a), np.sin(a)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
