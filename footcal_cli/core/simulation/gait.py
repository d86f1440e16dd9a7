"""A planned walk: footsteps, the CoP that rolls from heel to toe, the CoM that goes with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.effects.foot import turned
from footcal_cli.core.effects.transport import hermite
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.simulation.noise import stream
from footcal_cli.core.simulation.robots import Biped

_GRID_S = 0.0025
_ROLL_M = 0.025
_SWING_HEIGHT_M = 0.02
_EASE_S = 1.0


@dataclass(frozen=True)
class WalkPlan:
    """What the robot is commanded to do.

    Parameters
    ----------
    duration_s, speed_mps
        Length of the log; mean forward speed.
    step_s, double_support
        Time per step, and the share of it with both feet down.
    stand_s
        Quiet standing before and after.
    turn_radps
        Turning while walking.
    bob_m
        Rise and fall of the CoM with each step.
    squat_m, squat_s
        Depth and period of slow squats while walking.
    angmom_rate_nm
        Size of L̇ from the swinging legs.
    variation_m, variation_seed
        Sd by which each step misses its place, forward and sideways; which steps they are.
    """

    duration_s: float = 60.0
    speed_mps: float = 0.04
    step_s: float = 0.8
    double_support: float = 0.25
    stand_s: float = 3.0
    turn_radps: float = 0.0
    bob_m: float = 0.004
    squat_m: float = 0.0
    squat_s: float = 2.0
    angmom_rate_nm: float = 0.25
    variation_m: float = 0.003
    variation_seed: int = 0

    @property
    def steps(self) -> int:
        """Steps that fit between the two stands."""
        return max(int((self.duration_s - 2.0 * self.stand_s) / self.step_s), 0)

    @property
    def walk_s(self) -> float:
        """Time spent stepping."""
        return self.steps * self.step_s


@dataclass(frozen=True)
class Motion:
    """What the body and feet do at given stamps.

    Parameters
    ----------
    time_s
        Shape (n,).
    com_m, com_acc_mps2
        Shape (n, 3).
    angmom_rate_nm
        Shape (n, 2): x and y.
    foot_m, foot_yaw_rad
        Foot frames in the world, shapes (n, feet, 3) and (n, feet).
    foot_ref_m
        Where each foot's CoP is while it takes over or hands over, shape (n, feet, 2).
    contact
        1 standing, 0 in the air, shape (n, feet).
    block
        Gait cycle or stance, shape (n,).
    """

    time_s: FloatArray
    com_m: FloatArray
    com_acc_mps2: FloatArray
    angmom_rate_nm: FloatArray
    foot_m: FloatArray
    foot_yaw_rad: FloatArray
    foot_ref_m: FloatArray
    contact: FloatArray
    block: IntArray


def _footprints(robot: Biped, plan: WalkPlan) -> FloatArray:
    """Pose (x, y, yaw) of both feet before the first step and after each, (steps + 1, 2, 3).

    The left foot steps first; the last step brings the feet side by side.
    """
    steps = plan.steps
    done = np.arange(steps + 1)
    travelled = plan.speed_mps * plan.step_s * np.minimum(done, max(steps - 1, 0))
    path = np.empty((steps + 1, 2))
    path[:, 0] = travelled[2 * ((done + 1) // 2) - 1] * (done > 0)
    path[:, 1] = travelled[2 * (done // 2)]
    if steps:
        path[-1] = travelled[-1]
    yaw = path / plan.speed_mps * plan.turn_radps if plan.speed_mps else np.zeros_like(path)
    radius_inv = plan.turn_radps / plan.speed_mps if plan.speed_mps else 0.0
    half = 0.5 * path * radius_inv
    chord = path * np.sinc(half / np.pi)
    centre = np.stack([chord * np.cos(half), chord * np.sin(half)], axis=-1)
    side = np.array([robot.half_width_m, -robot.half_width_m])
    missed = robot.room * _misses(plan)
    place = centre + turned(missed[..., 0], side + missed[..., 1], yaw)
    return np.concatenate([place, yaw[..., None]], axis=-1)


def _misses(plan: WalkPlan) -> FloatArray:
    """How far each foot stands from its planned place, ahead and to the left, (steps + 1, 2, 2)."""
    done = np.arange(plan.steps + 1)
    taken = np.stack([(done + 1) // 2, done // 2], axis=-1)
    rng = stream(plan.variation_seed, "footsteps")
    each = plan.variation_m * np.clip(rng.standard_normal((plan.steps // 2 + 2, 2, 2)), -2.0, 2.0)
    each[0] = 0.0
    return np.stack([each[taken[:, 0], 0], each[taken[:, 1], 1]], axis=1)


def _rolls(robot: Biped, plan: WalkPlan) -> tuple[float, float]:
    """How far behind and ahead of the foot's middle the CoP lands and leaves."""
    reach = robot.room * min(_ROLL_M, 0.5 * plan.speed_mps * plan.step_s + 0.008)
    return -reach, reach


def _cop_knots(robot: Biped, plan: WalkPlan, feet: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Stamps and points between which the planned CoP moves, resting at each."""
    heel, toe = _rolls(robot, plan)
    middle = np.array([robot.cells_m(foot).mean(axis=0)[0] for foot in robot.feet])
    start = plan.stand_s + plan.step_s * np.arange(plan.steps)
    stance = 1 - np.arange(plan.steps) % 2
    pose = feet[np.arange(plan.steps), stance]
    lands = pose[:, :2] + turned(middle[stance] + heel, 0.0, pose[:, 2])
    leaves = pose[:, :2] + turned(middle[stance] + toe, 0.0, pose[:, 2])
    times = np.stack([start + plan.double_support * plan.step_s, start + plan.step_s], axis=-1)
    points = np.stack([lands, leaves], axis=1)
    rest = [
        (pose[:, :2] + turned(middle, 0.0, pose[:, 2])).mean(axis=0) for pose in (feet[0], feet[-1])
    ]
    end = plan.stand_s + plan.walk_s + plan.double_support * plan.step_s
    return (
        np.concatenate([[plan.stand_s], times.ravel(), [end]]),
        np.concatenate([rest[:1], points.reshape(-1, 2), rest[1:]]),
    )


def _com_path(
    knot_s: FloatArray, knot_m: FloatArray, omega: float, end_s: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Bounded CoM of a linear inverted pendulum under a planned CoP: stamps, path, speed.

    ``c − c̈/ω² = p`` has the bounded solution ``c = (ω/2) ∫ exp(−ω|t − s|) p(s) ds``: one low-pass
    forward in time, one backward.
    """
    from scipy.signal import lfilter

    grid = np.arange(-2.0, end_s + 2.0, _GRID_S)
    cop = _eased_path(grid, knot_s, knot_m)
    decay = np.exp(-omega * _GRID_S)
    slow = (1.0 - decay) / (omega * _GRID_S)
    numerator, denominator = [1.0 - slow, slow - decay], [1.0, -decay]

    def smoothed(signal: FloatArray) -> FloatArray:
        start = signal[0] * (1.0 - numerator[0])
        out, _ = lfilter(numerator, denominator, signal, axis=0, zi=start[None])
        return np.asarray(out)

    past, future = smoothed(cop), smoothed(cop[::-1])[::-1]
    return grid, 0.5 * (past + future), 0.5 * omega * (future - past)


def _eased_path(t: FloatArray, knot_s: FloatArray, knot_m: FloatArray) -> FloatArray:
    """Smooth path from point to point, at rest at each, shape (n, 2)."""
    left = np.clip(np.searchsorted(knot_s, t, side="right") - 1, 0, len(knot_s) - 2)
    u = (t - knot_s[left]) / (knot_s[left + 1] - knot_s[left])
    path: FloatArray = knot_m[left] + _ease(u)[0][:, None] * (knot_m[left + 1] - knot_m[left])
    return path


def _ease(u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Step from 0 to 1 on [0, 1] with its first two derivatives, continuous in all three."""
    u = np.clip(u, 0.0, 1.0)
    return (
        u**3 * (10.0 - 15.0 * u + 6.0 * u**2),
        30.0 * u**2 * (1.0 - u) ** 2,
        60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
    )


def _envelope(t: FloatArray, plan: WalkPlan) -> tuple[FloatArray, FloatArray, FloatArray]:
    """1 while walking, 0 while standing, with first and second derivative."""
    rise = _ease((t - plan.stand_s) / _EASE_S)
    fall = _ease((plan.stand_s + plan.walk_s - t) / _EASE_S)
    return (
        rise[0] * fall[0],
        (rise[1] * fall[0] - rise[0] * fall[1]) / _EASE_S,
        (rise[2] * fall[0] - 2.0 * rise[1] * fall[1] + rise[0] * fall[2]) / _EASE_S**2,
    )


def walking(robot: Biped, plan: WalkPlan, time_s: FloatArray) -> Motion:
    """The motion of a planned walk at any stamps."""
    feet = _footprints(robot, plan)
    knot_s, knot_m = _cop_knots(robot, plan, feet)
    omega = np.sqrt(robot.gravity_mps2 / robot.com_height_m)
    grid, path, speed = _com_path(knot_s, knot_m, omega, float(time_s[-1]))
    com_xy = hermite(grid, path, speed, time_s)
    cop = _eased_path(time_s, knot_s, knot_m)
    on, on_dot, on_ddot = _envelope(time_s, plan)
    cycle = 2.0 * np.pi / plan.step_s
    phase = cycle * (time_s - plan.stand_s)
    bob = np.cos(phase)
    rise = plan.bob_m * on * bob
    lift = plan.bob_m * (on_ddot * bob - 2.0 * cycle * on_dot * np.sin(phase) - cycle**2 * on * bob)
    deep = 2.0 * np.pi / plan.squat_s
    bent = np.cos(deep * (time_s - plan.stand_s))
    sine = np.sin(deep * (time_s - plan.stand_s))
    rise += 0.5 * plan.squat_m * on * (bent - 1.0)
    lift += (
        0.5
        * plan.squat_m
        * (on_ddot * (bent - 1.0) - 2.0 * deep * on_dot * sine - deep**2 * on * bent)
    )
    foot_m, foot_yaw, foot_ref, contact = _feet_at(robot, plan, feet, time_s)
    step = _step_number(plan, time_s)
    return Motion(
        time_s=time_s,
        com_m=np.column_stack([com_xy, robot.com_height_m + rise]),
        com_acc_mps2=np.column_stack([omega**2 * (com_xy - cop), lift]),
        angmom_rate_nm=plan.angmom_rate_nm
        * on[:, None]
        * np.stack([np.sin(0.5 * phase), np.sin(phase + 0.7)], axis=-1),
        foot_m=foot_m,
        foot_yaw_rad=foot_yaw,
        foot_ref_m=foot_ref,
        contact=contact,
        block=np.clip(step // 2 + 1, 0, plan.steps // 2 + 1),
    )


def _step_number(plan: WalkPlan, time_s: FloatArray) -> IntArray:
    """Number of the step a stamp falls in: −1 (and below) before, `steps` after."""
    number: IntArray = np.floor((time_s - plan.stand_s) / plan.step_s + 1e-12).astype(int)
    return np.clip(number, -1, plan.steps)


def _feet_at(
    robot: Biped, plan: WalkPlan, feet: FloatArray, time_s: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Foot positions, yaws, reference CoPs and contact at stamps."""
    step = _step_number(plan, time_s)
    stepping: BoolArray = (step >= 0) & (step < plan.steps)
    now = np.clip(step, 0, plan.steps)
    after = np.clip(step + 1, 0, plan.steps)
    u = (time_s - plan.stand_s) / plan.step_s - step
    swing = np.where(stepping, (u - plan.double_support) / (1.0 - plan.double_support), 0.0)
    moved = _ease(swing)[0][:, None, None]
    pose = feet[now] + np.where(stepping[:, None, None], moved, 0.0) * (feet[after] - feet[now])
    swinging = np.zeros((len(time_s), 2), dtype=bool)
    in_air = stepping & (swing > 0.0)
    swinging[np.flatnonzero(in_air), step[in_air] % 2] = True
    height = np.where(swinging, _SWING_HEIGHT_M * np.sin(np.pi * np.clip(swing, 0, 1))[:, None], 0)
    heel, toe = _rolls(robot, plan)
    middle = np.array([robot.cells_m(foot).mean(axis=0)[0] for foot in robot.feet])
    roll = np.zeros((len(time_s), 2))
    rows = np.flatnonzero(stepping)
    swing_foot = step[rows] % 2
    roll[rows, swing_foot] = np.where(step[rows] > 0, toe, 0.0)
    roll[rows, 1 - swing_foot] = heel
    ending = (step == plan.steps) & (u < plan.double_support)
    roll[np.flatnonzero(ending), 1 - plan.steps % 2] = 0.0
    ref = pose[..., :2] + turned(middle + roll, 0.0, pose[..., 2])
    foot_m = np.concatenate([pose[..., :2], height[..., None]], axis=-1)
    return foot_m, pose[..., 2], ref, np.where(swinging, 0.0, 1.0)
