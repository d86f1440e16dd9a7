"""Plans of standing and walking, and the motion and the ground forces that come of them.

The zero-moment point is planned, the centre of mass follows it as a linear pendulum, the links
follow the centre of mass; then Newton and Euler say what the ground must have done.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from tests.foreign.biped import GRAVITY_MPS2, Biped, angles_of, leg_points, link_centres
from tests.foreign.noise import Array, Rng, slow

Derive = Callable[[Array], Array]
FINE_HZ = 400.0
STANDING_S = 2.0
IMPACT_M, IMPACT_S = 1.5e-4, 0.012
"""Size and width of the bump that a touch-down leaves in the height of the CoM."""
SOLE_PLACE_M, SOLE_ROLL_M = 8e-4, 1.2e-3
"""How far a loaded sole lies from where the joints have it, and how far it rolls in a stance."""


@dataclass(frozen=True)
class Plan:
    """What a robot intends, on the fine clock.

    Parameters
    ----------
    time_s : (n,)
    feet_m : (n, 2, 3) soles; yaw_rad, pitch_rad : (n, 2)
    share : (n, 2) part of the weight on each foot, 0 in the air
    push_m : (n,) the ZMP before the weighted centres of the soles
    lean_m : (n, 2) its deviation in world axes beside that
    hips_m : (n,) height of the hips over the ankles
    number : (n, 2) of the stance of each foot
    """

    time_s: Array
    feet_m: Array
    yaw_rad: Array
    pitch_rad: Array
    share: Array
    push_m: Array
    lean_m: Array
    hips_m: Array
    number: Array


@dataclass(frozen=True)
class Motion:
    """What really happened, on the fine clock.

    Parameters
    ----------
    plan : what was intended, feet included: the joints are stiff
    com_m, com_acc_mps2 : (n, 3); angmom_rate_nm : (n, 2) about the CoM
    torso_m : (n, 3) midpoint of the hips; attitude : (n, 3, 3) torso to world
    cells_n : (n, cells) what the cells feel, plates included
    ground_n : (n, cells) what the ground does under each cell
    """

    plan: Plan
    com_m: Array
    com_acc_mps2: Array
    angmom_rate_nm: Array
    torso_m: Array
    attitude: Array
    cells_n: Array
    ground_n: Array


def rate(values: Array) -> Array:
    """Derivative in time of samples on the fine clock."""
    return np.asarray(np.gradient(values, 1.0 / FINE_HZ, axis=0))


def _rise(phase: Array) -> Array:
    """From 0 to 1 without jerk at the ends."""
    s = np.clip(phase, 0.0, 1.0)
    return np.asarray(s**4 * (35.0 - 84.0 * s + 70.0 * s**2 - 20.0 * s**3))


def plan_walk(robot: Biped, rng: Rng, seconds: float, turn_radps: float | None) -> Plan:
    """Two seconds of standing, then steps to the end."""
    size = robot.kind.size
    step_s = float(rng.uniform(0.5, 0.75)) * size**0.5
    double_s = step_s * float(rng.uniform(0.28, 0.36))
    speed = float(rng.uniform(0.02, 0.1)) * size**0.5
    turn = (
        float(rng.choice([0.0, 1.0]) * rng.uniform(-0.1, 0.1)) if turn_radps is None else turn_radps
    )
    n = round(seconds * FINE_HZ)
    time_s = np.arange(n) / FINE_HZ
    feet, yaw, pitch = np.zeros((n, 2, 3)), np.zeros((n, 2)), np.zeros((n, 2))
    feet[:, 0, 1], feet[:, 1, 1] = robot.hip_m, -robot.hip_m
    left, push, number = np.full(n, 0.5), np.zeros(n), np.zeros((n, 2))
    start, side, heading, here = STANDING_S, 1, 0.0, np.zeros(2)
    while start + double_s + step_s < seconds:
        lift, land = start + double_s, start + step_s
        left += (float(1 - side == 0) - left) * _rise((time_s - start) / double_s)
        push += (-0.012 * size - push) * _rise((time_s - start) / double_s)
        push += 0.028 * size * _rise((time_s - lift) / (land - lift))
        heading += turn * step_s
        here = here + speed * step_s * np.array([np.cos(heading), np.sin(heading)])
        across = robot.hip_m * (1 - 2 * side) * np.array([-np.sin(heading), np.cos(heading)])
        target = np.array([*(here + across + rng.normal(0.0, 0.002, 2)), 0.0])
        phase = (time_s - lift) / (land - lift)
        moved = _rise(phase)
        feet[:, side] += (target - feet[:, side]) * moved[:, None]
        aim = heading + rng.normal(0.0, 0.01)
        yaw[:, side] += (aim - yaw[:, side]) * moved
        s = np.clip(phase, 0.0, 1.0)
        feet[:, side, 2] += 0.02 * size * (4.0 * s * (1.0 - s)) ** 3
        pitch[:, side] += 0.08 * (4.0 * s * (1.0 - s)) ** 3 * np.cos(np.pi * s)
        number[time_s >= lift, side] += 1
        start, side = land, 1 - side
    bob = 0.002 * size * np.sin(2.0 * np.pi * time_s / step_s) * _rise((time_s - STANDING_S) / 1.0)
    share = np.column_stack([left, 1.0 - left])
    return Plan(time_s, feet, yaw, pitch, share, push, np.zeros((n, 2)), robot.leg_m + bob, number)


def plan_stance(robot: Biped, rng: Rng, seconds: float, start_s: float, number: int) -> Plan:
    """One quiet stance: feet placed anew, the weight shifted, the knees more or less bent."""
    n = round(seconds * FINE_HZ)
    feet, yaw = np.zeros((2, 3)), np.zeros(2)
    size = robot.kind.size
    feet[:, 1] = np.array([1.0, -1.0]) * (robot.hip_m + size * rng.uniform(0.0, 0.02, 2))
    feet[:, 0] = size * rng.uniform(-0.03, 0.03, 2)
    yaw[:] = rng.uniform(-0.3, 0.3, 2)
    left = float(rng.uniform(0.2, 0.8))
    hips = robot.leg_m * float(rng.uniform(0.85, 1.0))
    sway = 6e-4 * size * slow(rng, n, 2, 0.4 * FINE_HZ)
    ones = np.ones(n)
    return Plan(
        start_s + np.arange(n) / FINE_HZ, np.tile(feet, (n, 1, 1)), np.tile(yaw, (n, 1)),
        np.zeros((n, 2)), np.column_stack([left * ones, (1.0 - left) * ones]),
        size * float(rng.uniform(-0.02, 0.02)) * ones, sway, hips * ones,
        np.full((n, 2), float(number)),
    )  # fmt: skip


def move(robot: Biped, plan: Plan, rng: Rng) -> Motion:
    """Links, centre of mass, ground forces and cells of a plan."""
    n = len(plan.time_s)
    centre = _centres(robot, plan, plan.feet_m[..., :2])
    heading = plan.yaw_rad.mean(axis=1)
    ahead = np.column_stack([np.cos(heading), np.sin(heading)])
    zmp = np.einsum("nf,nfk->nk", plan.share, centre) + plan.push_m[:, None] * ahead + plan.lean_m
    lean = _smooth(0.01 * slow(rng, n, 2, 0.8 * FINE_HZ), 0.3)
    attitude = _attitude(lean, heading)
    height = robot.ankle_m + plan.hips_m + robot.kind.size * _bumps(plan)
    momentum = np.zeros((n, 2))
    for _ in range(3):
        fz = robot.mass_kg * GRAVITY_MPS2
        planned = zmp + np.column_stack([momentum[:, 1], -momentum[:, 0]]) / fz
        wanted = _pendulum(_smooth(planned, 0.1), float(np.median(height)) + 0.02 * robot.kind.size)
        torso = np.column_stack([wanted, height])
        for _ in range(3):
            links = _links(robot, plan, torso, attitude)
            com = np.einsum("k,nki->ni", robot.masses_kg, links) / robot.mass_kg
            torso[:, :2] += wanted - com[:, :2]
        links = _links(robot, plan, torso, attitude)
        com = np.einsum("k,nki->ni", robot.masses_kg, links) / robot.mass_kg
        turning = robot.torso_inertia_kgm2 * rate(lean)
        momentum = rate(angular_momentum(robot.masses_kg, links, com, rate) + turning)
    acc = rate(rate(com))
    force = robot.mass_kg * (acc + np.array([0.0, 0.0, GRAVITY_MPS2]))
    turning = np.column_stack([momentum[:, 1], -momentum[:, 0]])
    cop = com[:, :2] - (com[:, 2:] * force[:, :2] + turning) / force[:, 2:]
    ground = _ground(robot, plan, rng, cop, force[:, 2])
    cells = ground - _plates(robot, plan)
    return Motion(plan, com, acc, momentum, torso, attitude, cells, ground)


def angular_momentum(masses_kg: Array, links: Array, com: Array, derive: Derive) -> Array:
    """Σ m (r − c) × (v − ċ) about x and y, (n, 2); links as points."""
    from_com = links - com[:, None]
    speed = derive(from_com)
    return np.asarray(np.einsum("k,nki->ni", masses_kg, np.cross(from_com, speed))[:, :2])


def _links(robot: Biped, plan: Plan, torso: Array, attitude: Array) -> Array:
    hips = np.array([[0.0, robot.hip_m, 0.0], [0.0, -robot.hip_m, 0.0]])
    ankle = plan.feet_m + np.array([0.0, 0.0, robot.ankle_m])
    local = np.einsum("nji,nfj->nfi", attitude, ankle - torso[:, None]) - hips
    return link_centres(robot, torso, attitude, *leg_points(robot, angles_of(robot, local)))


def _attitude(roll_pitch: Array, yaw: Array) -> Array:
    """Torso to world from small roll and pitch (n, 2) and heading (n,)."""
    lean = np.column_stack([roll_pitch, np.zeros(len(yaw))])
    turn = np.outer(yaw, [0.0, 0.0, 1.0])
    return np.asarray((Rotation.from_rotvec(turn) * Rotation.from_rotvec(lean)).as_matrix())


def _centres(robot: Biped, plan: Plan, sole: Array) -> Array:
    forward = robot.cells_m[:, 0].mean()
    toward = np.stack([np.cos(plan.yaw_rad), np.sin(plan.yaw_rad)], axis=-1)
    return np.asarray(sole + forward * toward)


def _smooth(values: Array, seconds: float) -> Array:
    window = np.hanning(round(seconds * FINE_HZ) // 2 * 2 + 3)
    half = len(window) // 2
    padded = np.pad(values, ((half, half), (0, 0)), mode="edge")
    return np.stack([np.convolve(c, window / window.sum(), "valid") for c in padded.T], axis=1)


def _pendulum(zmp: Array, height_m: float) -> Array:
    """CoM over that ZMP: ``c = (ω/2) ∫ exp(−ω|t − s|) p(s) ds``, by two one-sided filters."""
    decay = float(np.exp(-np.sqrt(GRAVITY_MPS2 / height_m) / FINE_HZ))

    def one_sided(values: Array) -> Array:
        first = decay * values[:1]
        return np.asarray(lfilter([1.0 - decay], [1.0, -decay], values, axis=0, zi=first)[0])

    return one_sided(one_sided(zmp)[::-1])[::-1]


def _bumps(plan: Plan) -> Array:
    """What touch-downs leave in the height of the robot."""
    height = np.zeros(len(plan.time_s))
    for foot in range(2):
        down = np.flatnonzero((plan.share[1:, foot] > 0.0) & (plan.share[:-1, foot] <= 0.0))
        for t in plan.time_s[down]:
            height -= IMPACT_M * np.exp(-0.5 * ((plan.time_s - t) / IMPACT_S) ** 2)
    return height


def _ground(robot: Biped, plan: Plan, rng: Rng, cop: Array, fz: Array) -> Array:
    """Forces under the cells: exact in sum and moments, uneven within each foot."""
    toward = np.stack([np.cos(plan.yaw_rad), np.sin(plan.yaw_rad)], axis=-1)
    stances = int(plan.number.max()) + 1
    size = robot.kind.size
    place = rng.normal(0.0, size * SOLE_PLACE_M, (stances, 2, 2))
    roll = rng.normal(0.0, size * SOLE_ROLL_M, (stances, 2, 2))
    each = plan.number.astype(int)
    foot = np.arange(2)
    shift = place[each, foot] + roll[each, foot] * (plan.share - 0.5)[..., None]
    sole = plan.feet_m[..., :2] + shift
    centre = _centres(robot, plan, sole)
    off = cop - np.einsum("nf,nfk->nk", plan.share, centre)
    count = len(robot.cells)
    out = np.empty((len(fz), 2 * count))
    uneven = 0.5 * np.tanh(slow(rng, len(fz), 2, 0.5 * FINE_HZ))
    for side in range(2):
        point = centre[:, side] + off - sole[:, side]
        c, s = toward[:, side].T
        local = np.column_stack(
            [c * point[:, 0] + s * point[:, 1], c * point[:, 1] - s * point[:, 0]]
        )
        load = plan.share[:, side] * fz
        part = slice(count * side, count * (side + 1))
        out[:, part] = load[:, None] * _shares(robot.cells_m, local, uneven[:, side])
    return out


def _shares(cells_m: Array, point_m: Array, uneven: Array) -> Array:
    """Parts of a load on a sole's cells (n, c) with their centre in `point_m` (n, 2)."""
    if len(cells_m) == 3:
        grid = np.vstack([np.ones(3), cells_m.T])
        return np.asarray(
            np.linalg.solve(grid, np.column_stack([np.ones(len(point_m)), point_m]).T).T
        )
    middle = cells_m.mean(axis=0)
    x, y = ((point_m - middle) / (cells_m[0] - middle)).T
    waist = 0.25 * (1.0 + 0.5 * uneven) if len(cells_m) == 6 else 0.0 * uneven
    x = x / (1.0 - waist)
    corners = 0.25 * np.stack(
        [(1 + x) * (1 + y), (1 + x) * (1 - y), (1 - x) * (1 + y), (1 - x) * (1 - y)], axis=1
    )
    least = np.abs(corners).min(axis=1)
    corners = corners + (uneven * least)[:, None] * np.array([1.0, -1.0, -1.0, 1.0])
    if len(cells_m) == 4:
        return np.asarray(corners)
    corners = corners * (1.0 - waist)[:, None]
    sides = 0.5 * waist[:, None] * np.column_stack([1 + y, 1 - y])
    return np.hstack([corners[:, :2], sides, corners[:, 2:]])


def _plates(robot: Biped, plan: Plan) -> Array:
    """m z̈ of the plates under the cells (n, cells): what the ground lifts and no cell feels."""
    x = robot.cells_m[:, 0]
    height = plan.feet_m[:, :, None, 2] - np.sin(plan.pitch_rad)[..., None] * x
    return np.asarray(robot.plate_kg * rate(rate(height.reshape(len(height), -1))))
