"""A hexapod with six-axis transducers at the hips: hanging while its legs turn, and standing.

A transducer reads what the leg and the ground do to it, plus its offset. A turning leg is
accelerated: ``w = o + [m (g − r̈); r × m (g − r̈)]``, with r̈ of the motion as it was.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from tests.foreign.biped import GRAVITY_MPS2
from tests.foreign.files import Recorded
from tests.foreign.kinds import Kind, kind_of
from tests.foreign.noise import Array, Rng, coloured, slow, stream

LEGS = ("fl", "ml", "hl", "fr", "mr", "hr")
LEGS_OF = {
    4: ("fl", "hl", "fr", "hr"),
    6: LEGS,
    8: ("l1", "l2", "l3", "l4", "r1", "r2", "r3", "r4"),
    10: ("l1", "l2", "l3", "l4", "l5", "r1", "r2", "r3", "r4", "r5"),
}
AXES = ("fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm")
_OFFSETS = ("fx", "fy", "fz", "tx", "ty", "tz")
DOWN = {"+x": (1.0, 0, 0), "-x": (-1.0, 0, 0), "+z": (0, 0, 1.0), "-z": (0, 0, -1.0)}
FORCE_SD_N, TORQUE_SD_NM = 0.03, 0.0015
POSE_FORCE_SD_N, POSE_TORQUE_SD_NM = 0.05, 0.003
ENCODER_RAD = 2.0 * np.pi / 4096
NEAR_S = 1e-3
"""Step of differences in time."""
UNEVEN = 0.15
"""How much a leg's speed varies over a turn, relative: gravity works against its motor."""
LEG_INERTIA_KGM2 = 2e-5
"""Product of inertia of a leg about its CoM: a torque that turns with the shaft."""


@dataclass(frozen=True)
class Hexapod:
    """A drawn robot; first axis legs.

    Parameters
    ----------
    mass_kg : of the whole robot
    leg_kg : (6,); offset : (6, 6)
    arm_m : (6, 3, 4) CoM of the leg by 1, sin φ, cos φ, sin 2φ in transducer axes
    rot_bt : (6, 3, 3) transducer to body, as mounted; hip_m (6, 3), as mounted
    nominal_rot_bt, nominal_hip_m : as designed
    chassis_com_m : (3,) in the body
    kind : its make
    """

    mass_kg: float
    leg_kg: Array
    offset: Array
    arm_m: Array
    rot_bt: Array
    hip_m: Array
    nominal_rot_bt: Array
    nominal_hip_m: Array
    chassis_com_m: Array
    kind: Kind

    @property
    def legs(self) -> tuple[str, ...]:
        """Names, left ones first, from the front."""
        return LEGS_OF[len(self.leg_kg)]

    @property
    def noise_sd(self) -> Array:
        """Of each channel, (6,)."""
        sd = self.kind.noise * np.array([FORCE_SD_N] * 3 + [TORQUE_SD_NM] * 3)
        return sd if self.kind.noise == 1.0 else sd * np.array([1.0] * 3 + [_reach(self.kind)] * 3)

    def truth(self) -> dict[str, float]:
        """Offsets, leg and robot weight by the names of ``parameters.json``."""
        values = {"robot.weight": self.mass_kg * GRAVITY_MPS2}
        for name, kg, offset in zip(self.legs, self.leg_kg, self.offset, strict=True):
            values[f"{name}.weight"] = float(kg * GRAVITY_MPS2)
            values |= {
                f"{name}.offset_{a}": float(o) for a, o in zip(_OFFSETS, offset, strict=True)
            }
        return values

    def recipe(self) -> dict[str, object]:
        """``[robot]`` as its owner writes it: the design, and the scale's reading."""
        legs = {}
        for name, hip, rot in zip(self.legs, self.nominal_hip_m, self.nominal_rot_bt, strict=True):
            turn = float(np.arctan2(rot[1, 0], rot[0, 0]))
            legs[name] = {"position_m": hip.tolist(), "rotation_rpy_rad": [0.0, 0.0, turn]}
        mass = self.mass_kg * (1.0 + self.kind.mass_off)
        return {"name": "foreign hexapod", "mass_kg": mass, "legs": legs}


def _reach(kind: Kind) -> float:
    """Lengths relative to those of the usual hexapod."""
    return 1.0 if kind.mass_kg == (4.0, 9.0) else (sum(kind.mass_kg) / 18.0) ** (1.0 / 3.0)


def draw_hexapod(seed: int) -> Hexapod:
    """A robot of 6–12 kg or of its kind; right transducers turned by π about z, a little askew."""
    rng, kind = stream(seed, "hexapod"), kind_of(seed)
    legs, reach = kind.legs or 6, _reach(kind)
    mass = float(np.round(rng.uniform(*(kind.mass_kg if kind.legs else (6.0, 12.0))), 3))
    size = reach * np.array([rng.uniform(0.16, 0.25), rng.uniform(0.11, 0.16)])
    ahead = np.linspace(1.0, -1.0, legs // 2)
    wide = np.where(np.abs(ahead) < 1.0, 1.15, 1.0)
    place = np.concatenate([np.column_stack([ahead, wide]), np.column_stack([ahead, -wide])])
    nominal = np.column_stack([np.round(place * size, 3), np.zeros(legs)])
    right = np.arange(legs) >= legs // 2
    turn = Rotation.from_rotvec(np.pi * np.outer(right, [0, 0, 1])).as_matrix()
    askew = Rotation.from_rotvec(rng.normal(0.0, 0.012, (legs, 3))).as_matrix()
    arm = np.zeros((legs, 3, 4))
    radius, lag = rng.uniform(0.02, 0.035, legs), rng.uniform(-0.4, 0.4, legs)
    arm[:, :, 0] = np.column_stack(
        [rng.normal(0, 0.004, legs), rng.uniform(0.03, 0.06, legs), rng.normal(0, 0.006, legs)]
    )
    arm[:, 0, 1:3] = np.column_stack([radius * np.cos(lag), radius * np.sin(lag)])
    arm[:, 2, 1:3] = np.column_stack([radius * np.sin(lag), -radius * np.cos(lag)])
    arm[:, :, 3] = rng.normal(0.0, 1e-4, (legs, 3))
    heavy = reach**3
    return Hexapod(
        mass, mass * rng.uniform(0.06, 0.08) * (1 + rng.normal(0, 0.02, legs)),
        heavy * rng.normal(size=(legs, 6)) * np.array([3.0] * 3 + [0.2 * reach] * 3),
        reach * arm, askew @ turn, nominal + rng.normal(0.0, 0.002, (legs, 3)), turn, nominal,
        np.append(rng.normal(0.0, 0.003, 2), rng.normal(0.0, 0.01)), kind,
    )  # fmt: skip


def arm_at(arm_m: Array, phase: Array) -> Array:
    """CoM of one leg (n, 3) from (3, 4)."""
    basis = np.stack([np.ones_like(phase), np.sin(phase), np.cos(phase), np.sin(2 * phase)], -1)
    return np.asarray(basis @ arm_m.T)


def hang(
    seed: int, *, turn_s: float | None = None, turns: float = 10.3, rate_hz: float | None = None
) -> Recorded:
    """Four orientations, `turns` turns of `turn_s` in each; the body hangs askew in each.

    The legs do not stop at whole turns and do not turn evenly.
    """
    robot, rng = draw_hexapod(seed), stream(seed, "hang")
    kind = robot.kind
    turn_s, rate_hz = turn_s or kind.turn_s, rate_hz or kind.rate_hz
    mount = np.einsum("kij,kil->kjl", robot.rot_bt, robot.nominal_rot_bt)
    frames = []
    n = round(turns * turn_s * rate_hz)
    drift = _drifts(robot, rng, len(DOWN))
    for log, (name, axis) in enumerate(DOWN.items()):
        lean = Rotation.from_rotvec(rng.normal(0.0, 0.02, 3)).as_matrix()
        down_b = lean @ np.array(axis)
        time_s = np.arange(n) / rate_hz
        for k, leg in enumerate(robot.legs):
            start, heavy = rng.uniform(0.0, 2.0 * np.pi, 2)
            near = np.array([-NEAR_S, 0.0, NEAR_S])[:, None]
            phases = _turning(time_s + near, turn_s, start, heavy)
            wrench = _hanging(robot, k, robot.rot_bt[k].T @ down_b, phases, 1.0 / rate_hz, rng)
            wrench = converted(robot, wrench + drift[log, k])
            phase = phases[1]
            frames.append(
                pd.DataFrame(
                    {
                        "orientation": name,
                        "time_s": np.round(time_s + log * (n / rate_hz + 120.0), 4),
                        "leg": leg,
                        "phase_rad": np.round(phase / ENCODER_RAD) * ENCODER_RAD,
                        **{a: wrench[:, i] for i, a in enumerate(AXES)},
                    }
                )
            )
    truth = {
        "parameters": robot.truth(), "mount": mount, "arm_m": robot.arm_m, "turn_s": turn_s,
        "force_sd_n": FORCE_SD_N, "torque_sd_nm": TORQUE_SD_NM,
    }  # fmt: skip
    options = {"hang_calib": {"orientation_of": "body"}}
    return Recorded({"hang": pd.concat(frames, ignore_index=True)}, robot.recipe(), truth, options)


def _turning(time_s: Array, turn_s: float, start: float, heavy: float) -> Array:
    """Shaft angle whose speed varies by `UNEVEN` over each turn."""
    even = start + 2.0 * np.pi * time_s / turn_s
    return np.asarray(even + UNEVEN * np.sin(even + heavy))


def _hanging(
    robot: Hexapod, k: int, down_t: Array, phases: Array, period_s: float, rng: Rng
) -> Array:
    """Readings (n, 6) of a leg in a robot at rest; shaft angles (3, n) around each sample."""
    before, arm, after = (arm_at(robot.arm_m[k], at) for at in phases)
    acc = (before - 2.0 * arm + after) / NEAR_S**2
    force = robot.leg_kg[k] * (GRAVITY_MPS2 * down_t - acc)
    inertia = LEG_INERTIA_KGM2 * _reach(robot.kind) ** 5
    own = inertia * ((phases[2] - phases[0]) / (2.0 * NEAR_S)) ** 2
    turning = np.column_stack([own * np.sin(phases[1]), 0 * own, own * np.cos(phases[1])])
    torque = np.cross(arm, force) + turning
    noise = coloured(rng, len(arm), 6, 1.0 / period_s, 0.3)
    shown = np.column_stack([force, torque]) + robot.offset[k]
    return np.asarray(shown + robot.noise_sd * noise)


def _drifts(robot: Hexapod, rng: Rng, logs: int) -> Array:
    """How far the offsets lie from their mean in each log, (logs, legs, 6): they warm."""
    if not robot.kind.warming:
        return np.zeros((logs, len(robot.legs), 6))
    sd = robot.kind.warming * robot.mass_kg * GRAVITY_MPS2 / len(robot.legs)
    return np.asarray(
        sd * rng.normal(size=(logs, len(robot.legs), 6)) * [1, 1, 1, 0.05, 0.05, 0.05]
    )


def converted(robot: Hexapod, wrench: Array) -> Array:
    """Readings in steps of a converter that reaches over twice the weight."""
    if not robot.kind.bits:
        return wrench
    step = 4.0 * robot.kind.span * robot.mass_kg * GRAVITY_MPS2 / 2.0**robot.kind.bits
    steps = step * np.array([1.0] * 3 + [0.05 * _reach(robot.kind)] * 3)
    return np.asarray(np.round(wrench / steps) * steps)


def poses(
    seed: int, *, count: int = 120, slow_share: float | None = None, noise: float = 1.0
) -> Recorded:
    """Standing still in `count` poses on uneven ground, every third on a tripod.

    `slow_share` of the noise's variance lasts for some eight poses.
    """
    robot, rng = draw_hexapod(seed), stream(seed, "poses")
    kind, legs = robot.kind, len(robot.legs)
    slow_share = kind.share_drift if slow_share is None else slow_share
    noise *= kind.noise
    force_sd_n, torque_sd_nm = POSE_FORCE_SD_N * noise, POSE_TORQUE_SD_NM * noise
    if kind.noise != 1.0:
        torque_sd_nm *= _reach(kind)
    attitude = Rotation.from_euler(
        "zyx", rng.normal(0.0, 1.0, (count, 3)) * np.array([0.3, 0.12, 0.12])
    )
    down_b = attitude.inv().apply([0.0, 0.0, -1.0])
    wrench, contact, phases = [], [], []
    side = legs // 2
    odd = np.arange(legs) % 2 == 0  # alternate legs, across the body
    odd[side:] ^= side % 2 == 0
    for p in range(count):
        phase = rng.uniform(-0.6, 0.6, legs)
        on = np.ones(legs, dtype=bool)
        if p % 3 == 2 and legs == 4:  # one leg: on two the robot would fall
            on[rng.integers(4)] = False
        elif p % 3 == 2:
            on = odd if rng.random() < 0.5 else ~odd
        if p % 3 == 2:
            phase = np.where(on, phase, phase + np.pi)
        wrench.append(_standing(robot, down_b[p], phase, on, rng))
        contact.append(on)
        phases.append(phase)
    sd = np.array([force_sd_n] * 3 + [torque_sd_nm] * 3)
    # a pose is a mean over seconds: its noise is fresh, with a slow part from pose to pose
    slowly = slow(rng, count, 6 * legs, 8.0).reshape(count, legs, 6)
    error = sd * (
        rng.normal(size=(count, legs, 6)) * np.sqrt(1.0 - slow_share) + np.sqrt(slow_share) * slowly
    )
    shown = converted(robot, np.array(wrench) + robot.offset + error)
    pose, leg = (g.ravel() for g in np.meshgrid(np.arange(count), np.arange(legs), indexing="ij"))
    seen = Rotation.from_rotvec(rng.normal(0.0, 3e-4, (count, 3))) * attitude
    quat = seen.as_quat()
    frame = pd.DataFrame(
        {
            "pose": [f"pose {p + 1}" for p in pose],
            "leg": np.array(robot.legs)[leg],
            "phase_rad": np.round(np.array(phases).ravel() / ENCODER_RAD) * ENCODER_RAD,
            **{a: shown[pose, leg, i] for i, a in enumerate(AXES)},
            **{f"body_q{a}": quat[pose, i] for i, a in enumerate("xyzw")},
            "contact": np.array(contact).ravel().astype(int),
        }
    )
    truth = {
        "parameters": robot.truth(), "rot_bt": robot.rot_bt, "hip_m": robot.hip_m,
        "nominal_rot_bt": robot.nominal_rot_bt, "nominal_hip_m": robot.nominal_hip_m,
        "chassis_com_m": robot.chassis_com_m,
        "force_sd_n": force_sd_n, "torque_sd_nm": torque_sd_nm,
    }  # fmt: skip
    options = {"pose_calib": {"force_sd_n": force_sd_n, "torque_sd_nm": torque_sd_nm}}
    return Recorded({"poses": frame}, robot.recipe(), truth, options)


def _standing(robot: Hexapod, down_b: Array, phase: Array, on: Array, rng: Rng) -> Array:
    """Wrench of leg and ground on each transducer in its own axes, (6, 6)."""
    weight = robot.leg_kg * GRAVITY_MPS2
    com = np.array(
        [
            r @ arm_at(a, np.array([p]))[0]
            for r, a, p in zip(robot.rot_bt, robot.arm_m, phase, strict=True)
        ]
    )
    side = np.sign(robot.hip_m[:, 1])
    reach = _reach(robot.kind)
    foot = np.column_stack([0.09 * np.sin(phase), 0.08 * side, -0.06 - 0.09 * np.cos(phase)])
    tip = robot.hip_m + reach * foot + rng.normal(0.0, 0.005, (len(robot.legs), 3))
    chassis = robot.mass_kg * GRAVITY_MPS2 - weight.sum()
    # Σ ground = −(weight of all), Σ tip × ground = −(moments of all weights)
    pull = chassis * down_b + weight.sum() * down_b
    turn = np.cross(robot.chassis_com_m, chassis * down_b) + np.cross(
        robot.hip_m + com, weight[:, None] * down_b
    ).sum(axis=0)
    wanted = -np.concatenate([pull, turn])
    feet = np.flatnonzero(on)
    grid = np.concatenate([np.vstack([np.eye(3), _cross(tip[k])]) for k in feet], axis=1)
    share = rng.uniform(0.4, 1.0, feet.size)
    first = -(share / share.sum())[:, None] * pull + rng.normal(0.0, 1.0, (feet.size, 3))
    push = first.ravel() + np.linalg.pinv(grid) @ (wanted - grid @ first.ravel())
    ground = np.zeros((len(robot.legs), 3))
    ground[feet] = push.reshape(-1, 3)
    force = ground + weight[:, None] * down_b
    torque = np.cross(tip - robot.hip_m, ground) + np.cross(com, weight[:, None] * down_b)
    return np.concatenate(
        [np.einsum("kji,kj->ki", robot.rot_bt, v) for v in (force, torque)], axis=1
    )


def _cross(v: Array) -> Array:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
