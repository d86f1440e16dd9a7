"""Motions of a biped that balance to the last digit: footsteps, centre of mass, cell forces.

The centre of mass follows a planned zero-moment point through the linear inverted pendulum, solved
in the frequency domain; the ground forces are then what the finished motion demands.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.signal import lfilter

from tests.blind.world import GRAVITY_MPS2, Array, Rng

FINE_HZ = 200.0
PAUSE_S = 2.0
"""Between two stances nothing is logged."""


@dataclass(frozen=True)
class Build:
    """A drawn robot: mass, height of the CoM, feet and their cells (foot frame, (4, 2))."""

    mass_kg: float
    height_m: float
    hip_m: float
    cells_m: Array


@dataclass(frozen=True)
class Motion:
    """A motion on a fine clock.

    Parameters
    ----------
    time_s : (n,); com_m, com_acc_mps2 : (n, 3); angmom_rate_nm : (n, 2)
    feet_m : (n, 2, 3) soles; yaw_rad : (n, 2)
    forces_n : (n, 8) left then right cells; swing : (n, 2) 1 while a foot is in the air
    cycle : (n,) number of the gait cycle or stance
    """

    time_s: Array
    com_m: Array
    com_acc_mps2: Array
    angmom_rate_nm: Array
    feet_m: Array
    yaw_rad: Array
    forces_n: Array
    swing: Array
    cycle: Array


def draw_build(rng: Rng) -> Build:
    """A robot of 3.5–9 kg with four cells per foot."""
    half = np.array([rng.uniform(0.05, 0.075), rng.uniform(0.025, 0.04)])
    cells = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]) * half + [rng.uniform(0.0, 0.015), 0.0]
    return Build(
        float(np.round(rng.uniform(3.5, 9.0), 3)),
        float(rng.uniform(0.22, 0.38)),
        float(rng.uniform(0.045, 0.06)),
        np.round(cells + rng.normal(0, 5e-4, (4, 2)), 4),
    )


def walk(
    rng: Rng,
    build: Build,
    seconds: float,
    *,
    step_s: float | None = None,
    turn_radps: float | None = None,
    squatting: bool = False,
) -> Motion:
    """Two seconds of standing, then steps to the end, perhaps in a curve; drawn if not given.

    Squatting: hardly ahead, bobbing by 1 cm a step, hips down by 30 % and up again every 2.5 s.
    """
    step_s = rng.uniform(0.5, 0.75) if step_s is None else step_s
    double_s = step_s * rng.uniform(0.25, 0.35)
    speed, turn = rng.uniform(0.02, 0.1), rng.choice([0.0, rng.uniform(-0.12, 0.12)])
    turn = turn if turn_radps is None else turn_radps
    speed = 0.02 if squatting else speed
    n = int(seconds * FINE_HZ)
    time_s = np.arange(n) / FINE_HZ
    feet = np.zeros((n, 2, 3))
    feet[:, 0, 1], feet[:, 1, 1] = build.hip_m, -build.hip_m
    yaw, swing, cycle = np.zeros((n, 2)), np.zeros((n, 2)), np.zeros(n)
    left_share = np.full(n, 0.5)
    roll = np.zeros(n)
    start, side, heading, here = 2.0, 1, 0.0, np.zeros(2)
    while round((start + step_s) * FINE_HZ) < n:
        a, b, c = (round(t * FINE_HZ) for t in (start, start + double_s, start + step_s))
        heading += turn * step_s
        here = here + speed * step_s * np.array([np.cos(heading), np.sin(heading)])
        out = (1 - 2 * side) * build.hip_m * np.array([-np.sin(heading), np.cos(heading)])
        target = here + out + rng.normal(0, 0.0015, 2)
        before = left_share[a]
        left_share[a:b] = before + (side - before) * _smooth_step(np.linspace(0, 1, b - a))
        left_share[b:] = float(side)
        phase = np.linspace(0, 1, c - b)
        move = _smooth_step(phase)[:, None]
        feet[b:c, side, :2] += move * (target - feet[b, side, :2])
        feet[b:c, side, 2] = 0.02 * np.sin(np.pi * phase)
        feet[c:, side, :2] = target
        yaw[b:c, side] += move[:, 0] * (heading - yaw[b, side])
        yaw[c:, side] = heading
        swing[b:c, side] = 1.0
        roll[b:c] = 0.018 * np.linspace(-1, 1, c - b)
        cycle[a:] += 1.0
        start, side = c / FINE_HZ, 1 - side
    omega = 2 * np.pi / step_s
    ramp = np.clip(time_s - 2.0, 0.0, 1.0)
    bob = 0.01 if squatting else rng.uniform(0.001, 0.004)
    height = build.height_m + bob * ramp * np.sin(omega * time_s + rng.uniform(0, 6))
    if squatting:
        deep = 2 * np.pi * np.clip(time_s - 2.0, 0.0, None) / 2.5
        height -= 0.15 * build.height_m * (1.0 - np.cos(deep))
    angmom = ramp[:, None] * np.column_stack(
        [
            rng.uniform(0.1, 0.3) * np.sin(0.5 * omega * time_s + rng.uniform(0, 6)),
            rng.uniform(0.1, 0.3) * np.sin(omega * time_s + rng.uniform(0, 6)),
        ]
    )
    angmom += ramp[:, None] * _slow(rng, n, 0.05, 0.2, 2)
    zmp = _planned(feet, yaw, left_share, build, roll)
    return _balanced(
        rng, build, time_s, zmp, height, angmom, feet, yaw, left_share, swing, cycle // 2
    )


def stances(
    rng: Rng,
    build: Build,
    count: int,
    seconds_each: float,
    *,
    toes_out: Sequence[float] = (0.0,),
) -> Motion:
    """Quiet stances: weight shifted about, heights changed, feet put down anew between them.

    Each stance has the next of the angles by which both feet are turned out.
    """
    n_each = int(seconds_each * FINE_HZ)
    n = count * n_each
    feet, yaw, swing = np.zeros((n, 2, 3)), np.zeros((n, 2)), np.zeros((n, 2))
    share, height, roll = np.zeros(n), np.zeros(n), np.zeros(n)
    side = np.zeros(n)
    for i in range(count):
        part = slice(i * n_each, (i + 1) * n_each)
        place = np.array([[0, build.hip_m], [0, -build.hip_m]]) + rng.normal(0, 0.01, (2, 2))
        feet[part, :, :2] = place
        out = toes_out[i % len(toes_out)]
        yaw[part] = np.array([out, -out]) + rng.normal(0, 0.06, 2)
        kind = i % 5
        share[part] = (0.5, 0.75, 0.25, 1.0, 0.0)[kind] + (
            rng.uniform(-0.1, 0.1) if kind < 3 else 0
        )
        if kind >= 3:
            swing[part, 1 if kind == 3 else 0] = 1.0
            feet[part, 1 if kind == 3 else 0, 2] = 0.02
        height[part] = build.height_m * rng.uniform(0.85, 1.0)
        roll[part], side[part] = rng.uniform(-0.025, 0.025), rng.uniform(-0.01, 0.01)
    time_s = np.arange(n) / FINE_HZ
    zmp = _planned(feet, yaw, share, build, roll)
    zmp[:, 1] += side
    sway = _slow(rng, n, 4e-4, 0.5, 2)
    com = np.column_stack([zmp + sway, height])
    # quiet: the sway's own acceleration is too small to see, the body stands still
    zeros = np.zeros((n, 2))
    cycle = np.repeat(np.arange(count, dtype=float), n_each)
    forces = _cell_forces(
        rng, build, com[:, :2], np.full(n, build.mass_kg * GRAVITY_MPS2), feet, yaw, share
    )
    time_s = time_s + PAUSE_S * cycle
    return Motion(time_s, com, np.zeros((n, 3)), zeros, feet, yaw, forces, swing, cycle)


def bounces(
    rng: Rng,
    build: Build,
    *,
    stretches: int,
    seconds_each: float,
    facing_ways: int,
    heights: int,
    toes_out: Sequence[float] = (0.0,),
) -> Motion:
    """On both feet, bouncing and swaying at a tempo that rises from 0.5 to 4 Hz in each stretch.

    The hips go down by a fifth and up again every four seconds. Each stretch has the next of the
    angles by which both feet are turned out.
    Between stretches the robot turns and bends its knees, unlogged.
    """
    n = int(seconds_each * FINE_HZ)
    time_s = np.arange(n) / FINE_HZ
    tempo = 2 * np.pi * (0.5 * time_s + 1.75 * time_s**2 / seconds_each)
    ramp = np.clip(np.minimum(time_s, seconds_each - time_s), 0.0, 1.0)
    parts = []
    for i in range(stretches):
        facing = 2 * np.pi * (i % facing_ways) / facing_ways
        bent = 1.0 - 0.05 * (i // facing_ways % heights)
        feet = np.zeros((n, 2, 3))
        place = np.array([[0, build.hip_m], [0, -build.hip_m]]) + rng.normal(0, 0.004, (2, 2))
        feet[:, :, :2] = turned(place, facing)
        out = toes_out[(i + i // facing_ways) % len(toes_out)]
        yaw = facing + np.broadcast_to(np.array([out, -out]) + rng.normal(0, 0.03, 2), (n, 2))
        rate = 2 * np.pi * (0.5 + 3.5 * time_s / seconds_each)
        up = np.minimum(1.5 / rate**2, 0.015) * np.sin(tempo + rng.uniform(0, 6))
        hips = build.height_m * (bent - 0.1 * (1.0 - np.cos(2 * np.pi * time_s / 4.0)))
        share = 0.5 + 0.3 * ramp * np.sin(0.5 * tempo + rng.uniform(0, 6))
        roll = 0.02 * ramp * np.sin(0.5 * tempo + rng.uniform(0, 6))
        zmp = _planned(feet, yaw, share, build, roll)
        # who sways turns the trunk as well
        turns = 2 * np.pi * np.array([0.7, 0.9]) * time_s[:, None]
        angmom = 0.15 * ramp[:, None] * np.sin(turns + rng.uniform(0, 6, 2))
        parts.append(
            _balanced(
                rng, build, time_s, zmp, hips + ramp * up, angmom, feet, yaw,
                share, np.zeros((n, 2)), np.full(n, float(i)),
            )
        )  # fmt: skip
    return joined(parts)


def joined(parts: Sequence[Motion]) -> Motion:
    """Motions one after the other, with nothing logged between them."""
    start, shifted = 0.0, []
    for part in parts:
        shifted.append(replace(part, time_s=part.time_s + start))
        start += float(part.time_s[-1]) + PAUSE_S
    return Motion(
        **{f.name: np.concatenate([getattr(p, f.name) for p in shifted]) for f in fields(Motion)}
    )


def turned(places: Array, angle_rad: float) -> Array:
    """Points (k, 2) turned about the origin."""
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return np.asarray(places @ np.array([[cos, sin], [-sin, cos]]))


def _smooth_step(phase: Array) -> Array:
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * phase))


def _slow(rng: Rng, n: int, sd: float, tau_s: float, columns: int) -> Array:
    """Twice-filtered noise, so that its second derivative exists."""
    decay = np.exp(-1.0 / (tau_s * FINE_HZ))
    noise = lfilter([1.0], [1.0, -decay], rng.normal(size=(n + 2000, columns)), axis=0)
    noise = lfilter([1.0], [1.0, -decay], noise, axis=0)[2000:]
    return np.asarray(sd * noise / noise.std(axis=0))


def _centres(feet: Array, yaw: Array, build: Build, roll: Array) -> Array:
    """Point of each sole that the plan loads, shape (n, 2, 2)."""
    forward = build.cells_m[:, 0].mean() + roll[:, None]
    return np.asarray(
        feet[:, :, :2] + np.stack([np.cos(yaw) * forward, np.sin(yaw) * forward], axis=-1)
    )


def _planned(feet: Array, yaw: Array, left_share: Array, build: Build, roll: Array) -> Array:
    centre = _centres(feet, yaw, build, roll)
    share = np.stack([left_share, 1.0 - left_share], axis=1)
    return np.asarray(np.einsum("nf,nfk->nk", share, centre))


def _pendulum(zmp: Array, height_m: float) -> Array:
    """CoM whose linear inverted pendulum has this ZMP: ``C = P / (1 + ω² h / g)``."""
    n = len(zmp)
    line = zmp[0] + (zmp[-1] - zmp[0]) * np.linspace(0, 1, n)[:, None]
    odd = np.concatenate([zmp - line, -(zmp - line)[::-1]])
    omega = 2 * np.pi * np.fft.rfftfreq(2 * n, 1.0 / FINE_HZ)
    spectrum = np.fft.rfft(odd, axis=0) / (1.0 + omega**2 * height_m / GRAVITY_MPS2)[:, None]
    return np.asarray(np.fft.irfft(spectrum, 2 * n, axis=0)[:n] + line)


def _balanced(
    rng: Rng,
    build: Build,
    time_s: Array,
    zmp: Array,
    height: Array,
    angmom: Array,
    feet: Array,
    yaw: Array,
    left_share: Array,
    swing: Array,
    cycle: Array,
) -> Motion:
    """Forces that the finished motion demands (Newton and Euler about the centre of mass)."""
    window = np.hanning(int(0.12 * FINE_HZ))
    smooth = np.stack(
        [
            np.convolve(np.pad(z, window.size // 2, mode="edge"), window / window.sum(), "same")[
                window.size // 2 : window.size // 2 + len(z)
            ]
            for z in zmp.T
        ],
        1,
    )
    com = np.column_stack([_pendulum(smooth, build.height_m), height])
    acc = np.gradient(np.gradient(com, time_s, axis=0), time_s, axis=0)
    fz = build.mass_kg * (acc[:, 2] + GRAVITY_MPS2)
    moment = build.mass_kg * com[:, 2:] * acc[:, :2] + np.column_stack(
        [angmom[:, 1], -angmom[:, 0]]
    )
    cop = com[:, :2] - moment / fz[:, None]
    forces = _cell_forces(rng, build, cop, fz, feet, yaw, left_share)
    return Motion(time_s, com, acc, angmom, feet, yaw, forces, swing, cycle)


def _cell_forces(
    rng: Rng, build: Build, cop: Array, fz: Array, feet: Array, yaw: Array, left_share: Array
) -> Array:
    """Loads of the eight cells: both feet carry their share, off-centre by the same amount."""
    share = np.stack([left_share, 1.0 - left_share], axis=1)
    centre = _centres(feet, yaw, build, np.zeros(len(fz)))
    off = cop - np.einsum("nf,nfk->nk", share, centre)
    middle = build.cells_m.mean(axis=0)
    arms = np.column_stack([np.ones(4), build.cells_m - middle])
    spread = np.linalg.solve(arms.T @ arms, arms.T)
    rock = np.linalg.svd(arms.T)[2][-1]
    forces = np.zeros((len(fz), 8))
    for foot in range(2):
        load = share[:, foot] * fz
        point = centre[:, foot] + off - feet[:, foot, :2]
        c, s = np.cos(yaw[:, foot]), np.sin(yaw[:, foot])
        local = np.column_stack(
            [c * point[:, 0] + s * point[:, 1], -s * point[:, 0] + c * point[:, 1]]
        )
        loads = np.column_stack([load, load[:, None] * (local - middle)]) @ spread
        uneven = _slow(rng, len(fz), 0.08, 0.5, 1)[:, 0] * load
        forces[:, 4 * foot : 4 * foot + 4] = loads + uneven[:, None] * rock
    return forces
