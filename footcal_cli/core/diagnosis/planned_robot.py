"""Planned recordings of a whole robot: standing, bouncing, turning, walking, hanging, posing."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
from scipy.interpolate import CubicSpline

from footcal_cli.core.chain import Chain
from footcal_cli.core.diagnosis.planned_bench import Logs
from footcal_cli.core.diagnosis.rig import Rig
from footcal_cli.core.effects.foot import turned
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.biped_logs import (
    Course,
    StandPlan,
    Streams,
    biped_logs,
    standing_motion,
)
from footcal_cli.core.simulation.gait import Motion, WalkPlan, walking
from footcal_cli.core.simulation.hexapod_logs import (
    HangPlan,
    PosePlan,
    simulated_hang_log,
    simulated_pose_log,
)
from footcal_cli.core.simulation.robots import Biped

FACING_RAD = (0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi)
SQUATS_M = (0.0, 0.02, 0.04)
STRAIGHT_RAD, TOES_OUT_RAD = (0.0,), (0.25 * np.pi, -np.pi / 12.0)
"""Feet parallel; toes turned out and in by turns. What is wrong with a foot turns with the foot,
what is wrong with the body does not."""
TEMPO_HZ = (0.5, 4.0)
BOUNCE_MPS2 = 3.0
"""Peak vertical acceleration of a bounce."""
CIRCLE_S = 30.0
TURN_RADPS = 2.0 * np.pi / CIRCLE_S
SQUAT_SHARE, SQUAT_S = 0.2, 4.0
"""Depth over the height of the hips, and period, of the squats while bouncing."""
_RATE_HZ = 40.0
_SWAY_M = 0.015
_SWUNG_NM = 0.1
_STRETCH_S = 12.0
_NOTHING = Chain(())


def bounce(rig: Rig) -> Logs:
    """On both feet, one facing, one height."""
    return (_in_place(rig, FACING_RAD[:1], SQUATS_M[:1], STRAIGHT_RAD, 3.0 * _STRETCH_S),)


def turn_and_bounce(rig: Rig) -> Logs:
    """The same facing four ways, at three heights each, toes out and in by turns."""
    return (_in_place(rig, FACING_RAD, SQUATS_M, TOES_OUT_RAD, _STRETCH_S),)


def stand_turned(rig: Rig) -> Logs:
    """Quiet stances on both feet and on one, leaning this way and that, toes out and in."""
    plan = StandPlan(stances=14, one_foot=10, stance_s=4.0, sway_m=0.0, toes_rad=TOES_OUT_RAD)
    done = biped_logs(
        Course("stand", rig.biped, standing_motion(rig.biped, plan, 0), plan.duration_s),
        _NOTHING, {}, seed=0, streams=Streams(cell_rate_hz=2.0), to_counts=False,
    )  # fmt: skip
    return (done.cells.truth,)


def walk_turning(rig: Rig) -> Logs:
    """A full circle each way."""
    plan = WalkPlan(duration_s=CIRCLE_S + 6.0)
    return tuple(_walked(rig, replace(plan, turn_radps=sign * TURN_RADPS)) for sign in (1.0, -1.0))


def walk_straight(rig: Rig) -> Logs:
    """Straight ahead for a minute."""
    return (_walked(rig, WalkPlan(duration_s=66.0)),)


def walk_squatting(rig: Rig) -> Logs:
    """A full circle each way in small quick steps that bob, hips going down and up slowly.

    Slow squats change the height alone, quick bobs the vertical force: a tilt, an acceleration
    and a CoM that are off answer to them differently.
    """
    plan = WalkPlan(
        duration_s=CIRCLE_S + 6.0, speed_mps=0.02, step_s=0.6, bob_m=0.01,
        squat_m=0.3 * rig.biped.com_height_m, squat_s=2.5,
    )  # fmt: skip
    return tuple(_walked(rig, replace(plan, turn_radps=sign * TURN_RADPS)) for sign in (1.0, -1.0))


def walk_slow_fast(rig: Rig) -> Logs:
    """Thirty seconds of slow steps, thirty of fast ones."""
    plan = WalkPlan(duration_s=36.0)
    return tuple(_walked(rig, replace(plan, step_s=step)) for step in (1.2, 0.5))


def hang(rig: Rig) -> Logs:
    """Every leg in two opposite pairs of orientations."""
    robot = rig.hexapod
    plan = HangPlan(cycles=3, rate_hz=5.0)
    return tuple(
        simulated_hang_log(robot, leg, plan, _NOTHING, {}, seed=0).truth for leg in robot.legs
    )


def pose_tilted(rig: Rig) -> Logs:
    """Sixty poses on a floor that is tilted by up to 15°."""
    plan = PosePlan(poses=60, tripods=30, tilt_rad=np.deg2rad(15.0))
    return (simulated_pose_log(rig.hexapod, plan, _NOTHING, {}, seed=0).truth,)


def pose_tripods(rig: Rig) -> Logs:
    """Ninety poses on three legs in turn."""
    plan = PosePlan(poses=0, tripods=90)
    return (simulated_pose_log(rig.hexapod, plan, _NOTHING, {}, seed=0).truth,)


def _walked(rig: Rig, plan: WalkPlan) -> Log:
    robot = rig.biped
    done = biped_logs(
        Course("walk", robot, lambda time_s: walking(robot, plan, time_s), plan.duration_s),
        _NOTHING, {}, seed=0, streams=Streams(cell_rate_hz=_RATE_HZ), to_counts=False,
    )  # fmt: skip
    return done.cells.truth


def _in_place(
    rig: Rig,
    facing_rad: tuple[float, ...],
    squats_m: tuple[float, ...],
    toes_rad: tuple[float, ...],
    stretch_s: float,
) -> Log:
    """Both feet down: a stretch for each facing and height, moving; toes by turns."""
    robot = rig.biped
    stretches = list(product(facing_rad, squats_m))
    toes = np.resize(np.asarray(toes_rad), len(stretches))

    def motion_at(time_s: FloatArray) -> Motion:
        which = np.clip((time_s / stretch_s).astype(int), 0, len(stretches) - 1)
        facing, squat = np.array(stretches)[which].T
        local, acc = _moved(robot, time_s - which * stretch_s, stretch_s)
        lean = 0.01 * np.column_stack([np.cos(2.4 * which), np.sin(2.4 * which)])
        yaw = facing[:, None] + toes[which, None] * np.array([1.0, -1.0])
        return _both_feet_down(robot, time_s, yaw, squat, local + lean_z(lean), acc, which)

    done = biped_logs(
        Course("walk", robot, motion_at, len(stretches) * stretch_s), _NOTHING, {}, seed=0,
        streams=Streams(cell_rate_hz=_RATE_HZ), to_counts=False,
    )  # fmt: skip
    return done.cells.truth


def lean_z(lean_m: FloatArray) -> FloatArray:
    """A lean in the plane as a shift in space, shape (n, 3)."""
    return np.column_stack([lean_m, np.zeros(len(lean_m))])


def _moved(robot: Biped, since_s: FloatArray, stretch_s: float) -> tuple[FloatArray, FloatArray]:
    """Shift of the CoM and its acceleration in body axes while the tempo rises, (n, 3) each.

    Up and down so that the acceleration's peak stays the same, sideways and ahead so that the CoP
    does.
    """
    grid = np.arange(-0.5, stretch_s + 0.5, 1e-3)
    u = np.clip(grid, 0.0, stretch_s)
    slow, fast = TEMPO_HZ
    tempo = 2.0 * np.pi * (slow + (fast - slow) * u / stretch_s)
    phase = 2.0 * np.pi * (slow * u + 0.5 * (fast - slow) * u**2 / stretch_s)
    ramp = np.clip(np.minimum(u, stretch_s - u), 0.0, 1.0)
    ramp = ramp**2 * (3.0 - 2.0 * ramp)
    up = np.minimum(BOUNCE_MPS2 / tempo**2, 0.02) * np.sin(phase)
    reach = _SWAY_M / (1.0 + (0.5 * tempo) ** 2 * robot.com_height_m / robot.gravity_mps2)
    ahead, aside = reach * np.sin(0.5 * phase), reach * np.cos(0.5 * phase + 0.3)
    up -= 0.5 * SQUAT_SHARE * robot.com_height_m * (1.0 - np.cos(2.0 * np.pi * u / SQUAT_S))
    path = CubicSpline(grid, ramp[:, None] * np.column_stack([ahead, aside, up]))
    return np.asarray(path(since_s)), np.asarray(path(since_s, 2))


def _both_feet_down(
    robot: Biped,
    time_s: FloatArray,
    yaw: FloatArray,
    squat_m: FloatArray,
    moved_m: FloatArray,
    acc_mps2: FloatArray,
    block: FloatArray,
) -> Motion:
    """Feet side by side, each with its yaw (n, 2); the CoM over their middle and moved from there.

    The body faces the mean of both feet.
    """
    n = time_s.size
    facing_rad = yaw.mean(axis=1)
    side = np.array([robot.half_width_m, -robot.half_width_m])
    foot = turned(
        np.zeros((n, 2)), np.broadcast_to(side, (n, 2)), np.repeat(facing_rad[:, None], 2, axis=1)
    )
    middle = np.array([robot.cells_m(name).mean(axis=0) for name in robot.feet])
    ref = foot + turned(
        np.broadcast_to(middle[:, 0], (n, 2)), np.broadcast_to(middle[:, 1], (n, 2)), yaw
    )
    com, acc = (
        np.column_stack([turned(v[:, 0], v[:, 1], facing_rad), v[:, 2]])
        for v in (moved_m, acc_mps2)
    )
    com[:, :2] += ref.mean(axis=1)
    com[:, 2] += robot.com_height_m - squat_m
    return Motion(
        time_s=time_s,
        com_m=com,
        com_acc_mps2=acc,
        angmom_rate_nm=_SWUNG_NM * np.column_stack([np.sin(4.0 * time_s), np.cos(5.0 * time_s)]),
        foot_m=np.concatenate([foot, np.zeros((n, 2, 1))], axis=-1),
        foot_yaw_rad=yaw,
        foot_ref_m=ref,
        contact=np.ones((n, 2)),
        block=block.astype(np.int64),
    )
