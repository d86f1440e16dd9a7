"""Hanging and posing on six-axis transducers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from footcal_cli.core.chain import Chain
from footcal_cli.core.effects.six_axis_beliefs import HANGINGS
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.simulation.measure import Simulated, measure
from footcal_cli.core.simulation.noise import FORCE_NOISE, TORQUE_NOISE, SimulatedNoise, stream
from footcal_cli.core.simulation.robots import Hexapod

STANCE_PHASES_RAD = tuple(np.deg2rad([-36.0, 0.0, 36.0]))
"""Shaft angles of [Wu]'s poses."""
ORIENTATION_NAMES = {"px": "+x", "mx": "-x", "pz": "+z", "mz": "-z"}


@dataclass(frozen=True)
class HangPlan:
    """Hanging four ways while the legs turn slowly.

    Parameters
    ----------
    cycles, cycle_s, rate_hz
        Turns per orientation, time per turn, samples per second.
    orientation_of
        Whose axes hang along gravity and give the orientations their names: each transducer's, or
        the body's (a transducer turned by π about z then reads −x in an orientation ``+x``).
    """

    cycles: int = 10
    cycle_s: float = 20.0
    rate_hz: float = 20.0
    orientation_of: Literal["transducer", "body"] = "transducer"
    force_noise: SimulatedNoise = FORCE_NOISE
    torque_noise: SimulatedNoise = TORQUE_NOISE


def offset_values(robot: Hexapod) -> dict[str, float]:
    """The robot's offsets as parameter values of the effect ``offset``."""
    return {
        f"{channel.split('.')[0]}.offset_{channel.split('.')[1]}": value
        for channel, value in zip(
            robot.channels, (v for leg in robot.legs.values() for v in leg.offset), strict=True
        )
    }


def simulated_hang_log(
    robot: Hexapod,
    leg: str,
    plan: HangPlan,
    chain: Chain,
    values: Mapping[str, float],
    *,
    seed: int,
) -> Simulated:
    """One leg hanging in all four orientations, one after the other; block: orientation and cycle.

    ``f = m (g d̂ − r̈)``, ``τ = r(φ) × f`` with d̂ the true direction of gravity and r̈ the leg's
    acceleration ([Wu], eqs. (4)–(7), which hold for a leg at rest).
    """
    spec = robot.legs[leg]
    axes_t = np.array(list(HANGINGS.values()), dtype=float) @ rot_named(robot, leg, plan)
    per_way = int(plan.cycles * plan.cycle_s * plan.rate_hz)
    way = np.repeat(np.arange(len(HANGINGS)), per_way)
    within = np.tile(np.arange(per_way), len(HANGINGS)) / plan.rate_hz
    start = stream(seed, f"phase {leg}").uniform(0.0, 2.0 * np.pi)
    phase = np.mod(start + 2.0 * np.pi * within / plan.cycle_s, 2.0 * np.pi)
    pause_s = 60.0
    rows = len(way)
    planned = Log(
        "hang",
        tuple(channel for channel in robot.channels if channel.startswith(f"{leg}.")),
        within + way * (plan.cycles * plan.cycle_s + pause_s),
        np.zeros((rows, 6)),
        {
            "phase_rad": phase,
            "gravity_dir": axes_t[way],
            "leg_weight_n": np.full(rows, spec.weight_n),
            "leg_com_m": spec.com_m(phase),
            "leg_acc_g": spec.com_acc_mps2(phase, 2.0 * np.pi / plan.cycle_s) / robot.gravity_mps2,
            "temperature_degc": np.full(rows, 22.0),
        },
        way * plan.cycles + np.minimum((within / plan.cycle_s).astype(int), plan.cycles - 1),
    )

    def loads(log: Log) -> FloatArray:
        force = log.known["leg_weight_n"][:, None] * (
            log.known["gravity_dir"] - log.known["leg_acc_g"]
        )
        return np.concatenate([force, np.cross(log.known["leg_com_m"], force)], axis=1)

    return measure(
        planned,
        loads,
        chain,
        values,
        force_noise=plan.force_noise,
        torque_noise=plan.torque_noise,
        rng=stream(seed, f"hang {leg}"),
    )


def rot_named(robot: Hexapod, leg: str, plan: HangPlan) -> FloatArray:
    """Rotation from a leg's transducer to the axes that its orientations name, shape (3, 3)."""
    return np.array(robot.legs[leg].rotation_bt) if plan.orientation_of == "body" else np.eye(3)


def orientation_of(log: Log, rot: FloatArray) -> list[str]:
    """Name of the orientation of each row: the axis along gravity, of a frame turned by ``rot``."""
    axes = np.array(list(HANGINGS.values()), dtype=float) @ rot
    names = [ORIENTATION_NAMES[name] for name in HANGINGS]
    return [names[i] for i in np.argmax(log.known["gravity_dir"] @ axes.T, axis=1)]


@dataclass(frozen=True)
class PosePlan:
    """Standing still in many poses.

    Parameters
    ----------
    poses
        How many of the 3⁶ combinations of shaft angles.
    tripods
        How many further poses stand on three legs, the others lifted.
    friction_n, uneven
        Sd of the sideways ground forces; relative sd of the shares of the load.
    tilt_rad
        Largest slope of the floor, another one in every pose.
    """

    poses: int = 120
    tripods: int = 0
    friction_n: float = 1.5
    uneven: float = 0.25
    tilt_rad: float = 0.0
    force_noise: SimulatedNoise = FORCE_NOISE
    torque_noise: SimulatedNoise = TORQUE_NOISE


def _phases(
    robot: Hexapod, plan: PosePlan, rng: np.random.Generator
) -> tuple[FloatArray, BoolArray]:
    """Shaft angles and standing legs, shape (poses, legs)."""
    legs = len(robot.legs)
    everything = np.array(list(product(STANCE_PHASES_RAD, repeat=legs)))
    chosen = rng.choice(len(everything), plan.poses, replace=plan.poses > len(everything))
    phase = everything[chosen]
    standing = np.ones((plan.poses, legs), dtype=bool)
    if plan.tripods:
        sets = _standing_in_turn(robot.hip_pos_b_m)
        on = sets[np.arange(plan.tripods) % len(sets)]
        lifted = np.pi + rng.uniform(-0.5, 0.5, (plan.tripods, legs))
        stance = rng.choice(STANCE_PHASES_RAD, (plan.tripods, legs))
        phase = np.concatenate([phase, np.where(on, stance, lifted)])
        standing = np.concatenate([standing, on])
    return phase, standing


def _standing_in_turn(hip_b_m: FloatArray) -> BoolArray:
    """Sets of legs that carry a robot while the others are lifted, shape (sets, legs).

    Every other leg along each side, across the body; fewer than six legs are lifted one at a time.
    """
    legs = len(hip_b_m)
    if legs < 6:
        return ~np.eye(legs, dtype=bool)
    left = hip_b_m[:, 1] >= 0
    behind = hip_b_m[:, None, 0] < hip_b_m[None, :, 0]
    place = np.sum(behind & (left[:, None] == left[None, :]), axis=1)
    odd = place % 2 == np.where(left, 0, 1)
    return np.stack([odd, ~odd])


def feet_b_m(robot: Hexapod, phase_rad: FloatArray) -> FloatArray:
    """Foot positions in the body, shape (n, legs, 3): φ = 0 points down, φ > 0 moves back."""
    side = np.where(robot.hip_pos_b_m[:, 1] >= 0, 1.0, -1.0)
    reach = robot.foot_arm_m * np.sin(phase_rad)
    drop = robot.foot_arm_m * np.cos(phase_rad)
    out = np.broadcast_to(side * robot.foot_outward_m, phase_rad.shape)
    feet: FloatArray = robot.hip_pos_b_m + np.stack([-reach, out, -drop], axis=-1)
    return feet


def _attitude(
    feet: FloatArray, standing: BoolArray, tilt_rad: float, rng: np.random.Generator
) -> FloatArray:
    """Body-to-world rotation that puts the standing feet on the floor, shape (n, 3, 3).

    Least-squares plane through the feet, some yaw, and the slope of the floor.
    """
    weight = standing[..., None].astype(float)
    centre = (feet * weight).sum(axis=1, keepdims=True) / weight.sum(axis=1, keepdims=True)
    _, _, axes = np.linalg.svd((feet - centre) * weight)
    up = axes[:, 2]
    up = up * np.sign(up[:, 2:])
    forward = np.cross(np.array([0.0, 1.0, 0.0]), up)
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    level = np.stack([forward, np.cross(up, forward), up], axis=1)
    yaw = Rotation.from_rotvec(
        0.3 * rng.standard_normal((len(feet), 1)) * np.array([0.0, 0.0, 1.0])
    ).as_matrix()
    turned: FloatArray = yaw @ level
    if tilt_rad:
        slope = np.column_stack(
            [rng.uniform(-tilt_rad, tilt_rad, (len(feet), 2)), 0.0 * yaw[:, 0, 0]]
        )
        turned = Rotation.from_rotvec(slope).as_matrix() @ turned
    return turned


def _ground_forces(
    arms_w_m: FloatArray,
    demanded: FloatArray,
    standing: BoolArray,
    plan: PosePlan,
    rng: np.random.Generator,
) -> FloatArray:
    """Forces of the ground on the feet, shape (n, legs, 3), with friction and internal forces.

    Random forces, corrected by the smallest change that makes their sum and moment what is
    demanded (n, 6).
    """
    n, legs = standing.shape
    share = np.abs(1.0 + plan.uneven * rng.standard_normal((n, legs))) * standing
    share /= share.sum(axis=1, keepdims=True)
    force = np.concatenate(
        [plan.friction_n * rng.standard_normal((n, legs, 2)), np.zeros((n, legs, 1))], axis=-1
    )
    force[..., 2] = share * demanded[:, 2:3]
    force *= standing[..., None]
    eye = np.broadcast_to(np.eye(3), (n, legs, 3, 3))
    cross = np.zeros((n, legs, 3, 3))
    x, y, z = np.moveaxis(arms_w_m, -1, 0)
    cross[..., 0, 1], cross[..., 0, 2] = -z, y
    cross[..., 1, 0], cross[..., 1, 2] = z, -x
    cross[..., 2, 0], cross[..., 2, 1] = -y, x
    grasp = np.concatenate([eye, cross], axis=2) * standing[..., None, None]
    grasp = grasp.transpose(0, 2, 1, 3).reshape(n, 6, legs * 3)
    missing = demanded - np.einsum("nij,nj->ni", grasp, force.reshape(n, -1))
    correction = np.einsum("nji,nj->ni", grasp, np.linalg.solve(
        grasp @ grasp.transpose(0, 2, 1), missing[..., None])[..., 0])  # fmt: skip
    balanced: FloatArray = force + correction.reshape(n, legs, 3)
    return balanced


def simulated_pose_log(
    robot: Hexapod, plan: PosePlan, chain: Chain, values: Mapping[str, float], *, seed: int
) -> Simulated:
    """The robot standing in many poses; a row and a block per pose."""
    rng = stream(seed, "poses")
    phase, standing = _phases(robot, plan, rng)
    feet = feet_b_m(robot, phase)
    rot_wb = _attitude(feet, standing, plan.tilt_rad, rng)
    rows, legs = phase.shape
    planned = Log(
        "pose",
        robot.channels,
        8.0 * np.arange(float(rows)),
        np.zeros((rows, 6 * legs)),
        {
            "phase_rad": phase,
            "rot_wb": rot_wb,
            "hip_rot_bt": np.broadcast_to(robot.hip_rot_bt, (rows, legs, 3, 3)).copy(),
            "hip_pos_b_m": np.broadcast_to(robot.hip_pos_b_m, (rows, legs, 3)).copy(),
            "chassis_com_b_m": np.broadcast_to(np.array(robot.chassis_com_b_m), (rows, 3)).copy(),
            "robot_weight_n": np.full(rows, robot.weight_n),
            "leg_weight_n": np.broadcast_to(robot.leg_weight_n, (rows, legs)).copy(),
            "contact": standing.astype(float),
        },
        np.arange(rows),
    )

    def loads(log: Log) -> FloatArray:
        return _hip_wrenches(robot, log, feet, standing, plan, stream(seed, "ground"))

    return measure(
        planned,
        loads,
        chain,
        values,
        force_noise=plan.force_noise,
        torque_noise=plan.torque_noise,
        rng=stream(seed, "transducers"),
    )


def _hip_wrenches(
    robot: Hexapod,
    log: Log,
    feet: FloatArray,
    standing: BoolArray,
    plan: PosePlan,
    rng: np.random.Generator,
) -> FloatArray:
    """Wrenches of ground and leg weight on the transducers, in their nominal frames, (n, 6 legs).

    The ground carries the whole robot: its forces sum to M g with no moment about the CoM of
    chassis and legs; what the legs pass on then balances the chassis exactly.
    """
    rot_wb, leg_weight = log.known["rot_wb"], log.known["leg_weight_n"]
    hip, rot_bt = log.known["hip_pos_b_m"], log.known["hip_rot_bt"]
    com_t = np.stack(
        [leg.com_m(log.known["phase_rad"][:, i]) for i, leg in enumerate(robot.legs.values())],
        axis=1,
    )
    com_b = hip + np.einsum("nkij,nkj->nki", rot_bt, com_t)
    weight = log.known["robot_weight_n"]
    chassis = weight - leg_weight.sum(axis=1)
    whole_com = (
        chassis[:, None] * log.known["chassis_com_b_m"] + np.einsum("nk,nki->ni", leg_weight, com_b)
    ) / weight[:, None]
    arms_w = np.einsum("nij,nkj->nki", rot_wb, feet - whole_com[:, None])
    demanded = np.zeros((len(log), 6))
    demanded[:, 2] = weight
    ground_w = _ground_forces(arms_w, demanded, standing, plan, rng)
    ground_b = np.einsum("nji,nkj->nki", rot_wb, ground_w)
    leg_b = -leg_weight[..., None] * rot_wb[:, None, 2, :]
    force_b = ground_b + leg_b
    torque_b = np.cross(feet - hip, ground_b) + np.cross(com_b - hip, leg_b)
    wrench_b = np.stack([force_b, torque_b], axis=2)
    wrench_t = np.einsum("nkji,nkwj->nkwi", rot_bt, wrench_b)
    flat: FloatArray = wrench_t.reshape(len(log), -1)
    return flat
