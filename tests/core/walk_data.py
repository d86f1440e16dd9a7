"""A walking pendulum made independently of the package: truth, and what sensors make of it.

Linear inverted pendulum that follows a planned ZMP, with a bobbing CoM, a given rate of angular
momentum, feet that carry the ZMP with their four cells, and a swinging foot that carries nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded
from scipy.signal import lfilter

Array = NDArray[np.float64]
G = 9.80665
CELLS = ("fl", "fr", "rl", "rr")
CHANNELS = tuple(f"{foot}_{cell}" for foot in ("left", "right") for cell in CELLS)
CELLS_FOOT = np.array([[0.07, 0.03], [0.07, -0.03], [-0.05, 0.03], [-0.05, -0.03]])
FINE_HZ = 400.0


@dataclass(frozen=True)
class Motion:
    """Truth on a fine grid."""

    time: Array
    com: Array
    acc: Array
    angmom_rate: Array
    feet: Array  # (n, 2, 2)
    yaw: Array  # (n, 2)
    force: Array  # (n, 8)
    contact: Array  # (n, 2), 1 / 0
    mass: float

    @property
    def cells(self) -> Array:
        out = []
        for foot in range(2):
            c, s = np.cos(self.yaw[:, foot]), np.sin(self.yaw[:, foot])
            x, y = CELLS_FOOT.T
            turned = np.stack(
                [c[:, None] * x - s[:, None] * y, s[:, None] * x + c[:, None] * y], -1
            )
            out.append(self.feet[:, foot, None] + turned)
        return np.concatenate(out, axis=1)


def smooth(values: Array, width: int) -> Array:
    window = np.hanning(width + 2)[1:-1]
    padded = np.pad(values, width // 2, mode="edge")
    return np.convolve(padded, window / window.sum(), mode="valid")[: values.size]


def coloured(rng: np.random.Generator, n: int, sd: float, samples: float, k: int = 1) -> Array:
    """First-order autoregressive noise (n, k) with a stationary sd and correlation time."""
    decay = np.exp(-1.0 / samples)
    white = rng.normal(0.0, sd * np.sqrt(1 - decay**2), (n, k))
    white[0] = rng.normal(0.0, sd, k)
    return lfilter([1.0], [1.0, -decay], white, axis=0)


def make_walk(
    speed: float = 0.04,
    seconds: float = 60.0,
    seed: int = 0,
    mass: float = 5.4,
    step: float = 0.6,
    double: float = 0.16,
    turn: float = 0.0,
    swing: float = 1.0,
) -> Motion:
    """Two seconds of standing, then steps to the end; `swing` scales the angular momentum."""
    rng = np.random.default_rng(seed)
    n = int(seconds * FINE_HZ)
    t = np.arange(n) / FINE_HZ
    zmp = np.zeros((n, 2))
    zmp[:, 0] = 0.01
    share = np.full(n, 0.5)  # of the left foot
    feet = np.zeros((n, 2, 2))
    feet[:, 0, 1], feet[:, 1, 1] = 0.05, -0.05
    yaw = np.zeros((n, 2))
    contact = np.ones((n, 2))
    start, side, reach, heading = 2.0, 1, 0.0, 0.0
    here = feet[0].copy()
    while start < seconds:
        # weight goes to the stance foot, the other one swings
        stance = 1 - side
        a, b, c = (int(x * FINE_HZ) for x in (start, start + double, start + step))
        heading += turn * step
        reach += speed * step
        direction = np.array([np.cos(heading), np.sin(heading)])
        left = np.array([-direction[1], direction[0]])
        target = reach * direction + (0.05 if side == 0 else -0.05) * left
        target = target + rng.normal(0, 0.002, 2)
        roll = np.linspace(-0.02, 0.02, max(min(c, n) - b, 1)) if b < n else np.zeros(1)
        middle = (a + b) // 2
        zmp[middle:] = here[stance] + [0.01 - 0.02, 0.0]
        if b < n:
            zmp[b : min(c, n)] = here[stance] + np.stack([0.01 + roll, 0 * roll], 1)
            zmp[min(c, n) - 1 :] = here[stance] + [0.03, 0.0]
        share[middle:] = 1.0 if stance == 0 else 0.0
        contact[b : min(c, n), side] = 0.0
        s = np.clip((np.arange(n) - b) / max(c - b, 1), 0, 1)[:, None]
        s = s**3 * (10 - 15 * s + 6 * s**2)
        feet[:, side] += s * (target - here[side])
        yaw[:, side] += s[:, 0] * (heading - yaw[-1, side])
        here[side] = target
        start, side = start + step, 1 - side
    width = int(double * FINE_HZ)
    # a moving ZMP lies between the feet in double support
    zmp = np.stack([smooth(zmp[:, i], width) for i in range(2)], 1)
    share = smooth(share, width)
    share = np.where(contact[:, 0] == 0, 0.0, np.where(contact[:, 1] == 0, 1.0, share))
    omega = 2 * np.pi / step
    rise = 0.003 * np.clip(t - 2, 0, 1) ** 2
    z = 0.27 + rise * np.sin(omega * t)
    z = z + coloured(rng, n, 0.0, 10)[:, 0]
    acc_z = np.gradient(np.gradient(z, t), t)
    drive = np.clip(t - 2, 0, 1)[:, None] * np.stack(
        [0.25 * np.sin(omega / 2 * t), 0.2 * np.sin(omega * t + 0.5)], 1
    )
    wander = np.stack([smooth(coloured(rng, n, 0.3, 20)[:, 0], 101) for _ in range(2)], 1)
    angmom_rate = swing * (drive + wander * np.clip(t - 2, 0, 1)[:, None])
    fz = mass * (acc_z + G)
    shift = np.stack([angmom_rate[:, 1], -angmom_rate[:, 0]], 1) / fz[:, None]
    k = z / (G + acc_z) * FINE_HZ**2
    k[[0, -1]] = 0
    bands = np.zeros((3, n))
    bands[0, 1:], bands[1], bands[2, :-1] = -k[:-1], 1 + 2 * k, -k[1:]
    com = solve_banded((1, 1), bands, zmp + shift)
    acc = np.gradient(np.gradient(com, t, axis=0), t, axis=0)
    # what really balances this motion, to the last digit
    moment = mass * z[:, None] * acc + np.stack([angmom_rate[:, 1], -angmom_rate[:, 0]], 1)
    true_zmp = com - moment / fz[:, None]
    force = _cell_forces(true_zmp, fz, share, feet, yaw, contact, rng)
    com3 = np.column_stack([com, z])
    acc3 = np.column_stack([acc, acc_z])
    return Motion(t, com3, acc3, angmom_rate, feet, yaw, force, contact, mass)


def _cell_forces(
    zmp: Array, fz: Array, share: Array, feet: Array, yaw: Array, contact: Array,
    rng: np.random.Generator,
) -> Array:  # fmt: skip
    """Foot loads by share, their centres so that the whole has its ZMP, cells with some twist."""
    n = len(zmp)
    parts = np.stack([share, 1 - share], 1)
    centres = feet + np.stack([[0.01, 0.0], [0.01, 0.0]])
    off = zmp - np.einsum("nf,nfk->nk", parts, centres)
    force = np.zeros((n, 8))
    twist = np.stack([smooth(coloured(rng, n, 0.6, 80)[:, 0], 61) for _ in range(2)], 1)
    for foot in range(2):
        load = parts[:, foot] * fz
        point = centres[:, foot] + off
        d = point - feet[:, foot]
        c, s = np.cos(yaw[:, foot]), np.sin(yaw[:, foot])
        local = np.stack([c * d[:, 0] + s * d[:, 1], -s * d[:, 0] + c * d[:, 1]], 1)
        u, v = (local[:, 0] - 0.01) / 0.06, local[:, 1] / 0.03
        signs = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
        cells = 0.25 * load[:, None] * (1 + u[:, None] * signs[:, 0] + v[:, None] * signs[:, 1])
        rock = twist[:, foot] * np.minimum(load / 20.0, 1.0)
        force[:, 4 * foot : 4 * foot + 4] = cells + rock[:, None] * np.array([1, -1, -1, 1])
    return force


@dataclass(frozen=True)
class Errors:
    """How wrong sensors and body model are."""

    gain_sd: float = 0.02
    bias_sd: float = 0.3
    gain_walk: float = 1e-4
    bias_walk: float = 0.01
    quantum: float = 0.5
    white: float = 0.1
    slow: float = 0.05
    delay: float = 0.0
    plate: float = 0.0
    com_offset: tuple[float, float] = (0.0, 0.0)
    com_noise: float = 0.001
    acc_noise: float = 0.05
    rate_noise: float = 0.05
    jumps: tuple[tuple[int, float, float], ...] = ()


@dataclass(frozen=True)
class Recording:
    """What a logger wrote, and the truth behind it, on the cells' clock."""

    cell_time: Array
    counts: Array
    body_time: Array
    com: Array
    acc: Array
    angmom_rate: Array
    feet: Array
    yaw: Array
    scale0: Array
    bias0: Array
    true_gain: Array  # (n, 8) true scale over believed scale - 1
    true_bias: Array  # (n, 8) what `bias` must become on top of the believed one
    force: Array
    cells: Array
    contact: Array
    mass: float
    extras: dict[str, Array] = field(default_factory=dict)


def record(motion: Motion, errors: Errors, seed: int, cell_hz: float = 80.0) -> Recording:
    """Put a motion through sensors."""
    rng = np.random.default_rng(seed + 10_000)
    t, last = motion.time, motion.time[-1]
    cell_time = np.arange(0.05, last - 0.05, 1 / cell_hz)
    body_time = np.arange(0.0, last, 0.01)

    def at(values: Array, when: Array) -> Array:
        flat = values.reshape(len(t), -1)
        columns = [np.interp(when, t, column) for column in flat.T]
        return np.stack(columns, 1).reshape(len(when), *values.shape[1:])

    force = at(motion.force, cell_time)
    n = len(cell_time)
    scale0 = -rng.uniform(2.2e-6, 3.6e-6, 8)
    bias0 = -scale0 * rng.uniform(8.31e6, 8.35e6, 8)
    root = np.sqrt(1 / cell_hz)
    gain = rng.normal(0, errors.gain_sd, 8) + np.cumsum(
        rng.normal(0, errors.gain_walk * root, (n, 8)), 0
    )
    bias = rng.normal(0, errors.bias_sd, 8) + np.cumsum(
        rng.normal(0, errors.bias_walk * root, (n, 8)), 0
    )
    for cell, when, size in errors.jumps:
        bias[cell_time >= when, cell] += size
    seen = force + rng.normal(0, errors.white, force.shape) + coloured(rng, n, errors.slow, 40, 8)
    contact = np.stack([np.interp(cell_time, t, motion.contact[:, f]) for f in range(2)], 1)
    contact = np.where((contact > 0) & (contact < 1), np.nan, contact)
    for foot in range(2):
        hanging = contact[:, foot] == 0
        seen[hanging, 4 * foot : 4 * foot + 4] -= errors.plate / 4
    # F = (1 + gain) F0 + bias, F0 = scale0 S + bias0
    shown = (seen - bias) / (1 + gain)
    if errors.quantum:
        shown = np.round(shown / errors.quantum) * errors.quantum
    counts = (shown - bias0) / scale0
    stamp = body_time - errors.delay
    com = at(motion.com, stamp)
    com[:, :2] += coloured(rng, len(com), errors.com_noise, 20, 2) - np.array(errors.com_offset)
    acc = at(motion.acc, stamp) + rng.normal(0, errors.acc_noise, (len(com), 3))
    rate = at(motion.angmom_rate, stamp) + rng.normal(0, errors.rate_noise, (len(com), 2))
    return Recording(
        cell_time, counts, body_time, com, acc, rate, at(motion.feet, stamp),
        at(motion.yaw, stamp), scale0, bias0, gain, bias, force, at(motion.cells, cell_time),
        contact, motion.mass,
    )  # fmt: skip


@dataclass(frozen=True)
class Standing:
    """Quiet stances, rows in order, as sensors see them."""

    time: Array
    counts: Array
    com: Array
    cells: Array
    yaw: Array
    stance: NDArray[np.int64]
    scale0: Array
    bias0: Array
    true_gain: Array
    true_bias: Array
    force: Array
    contact: Array
    mass: float


def make_standing(
    stances: int,
    seed: int,
    *,
    replace: bool,
    lift: bool = False,
    gain_sd: float = 0.02,
    bias_sd: float = 0.3,
    white: float = 0.1,
    com_sd: float = 0.001,
    samples: int = 160,
    mass: float = 5.4,
) -> Standing:
    """Stances of two seconds: weight shifted about, feet left in place or put elsewhere.

    lift: every other stance is on one foot.
    """
    rng = np.random.default_rng(seed)
    feet = np.array([[0.0, 0.05], [0.0, -0.05]])
    yaw = np.zeros(2)
    force, cells, coms, yaws, contacts = [], [], [], [], []
    for k in range(stances):
        if replace and k:
            feet = np.array([[0.0, 0.05], [0.0, -0.05]]) + rng.uniform(-0.04, 0.04, (2, 2))
            yaw = rng.uniform(-0.4, 0.4, 2)
        share = 0.5 if k == 0 else rng.uniform(0.2, 0.8)
        if lift and k % 2:
            share = float(k % 4 == 1)
        weight = mass * G
        f, p = [], []
        for foot, part in enumerate((share, 1 - share)):
            u, v, w = (0, 0, 0) if k == 0 else rng.uniform(-0.6, 0.6, 3) * (1, 1, 0.5)
            signs = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
            cell = 1 + u * signs[:, 0] + v * signs[:, 1] + w * signs[:, 0] * signs[:, 1]
            f.append(part * weight * cell / 4)
            c, s = np.cos(yaw[foot]), np.sin(yaw[foot])
            p.append(feet[foot] + CELLS_FOOT @ np.array([[c, s], [-s, c]]))
        f_all, p_all = np.concatenate(f), np.concatenate(p)
        cop = f_all @ p_all / f_all.sum()
        com = np.array([*(cop + rng.normal(0, com_sd, 2)), 0.27])
        force.append(np.tile(f_all, (samples, 1)))
        cells.append(np.tile(p_all, (samples, 1, 1)))
        coms.append(np.tile(com, (samples, 1)))
        yaws.append(np.tile(yaw, (samples, 1)))
        contacts.append(np.tile([float(share > 0), float(share < 1)], (samples, 1)))
    n = stances * samples
    scale0 = -rng.uniform(2.2e-6, 3.6e-6, 8)
    bias0 = -scale0 * rng.uniform(8.31e6, 8.35e6, 8)
    gain, bias = rng.normal(0, gain_sd, 8), rng.normal(0, bias_sd, 8)
    true = np.concatenate(force)
    seen = true + rng.normal(0, white, true.shape)
    counts = ((seen - bias) / (1 + gain) - bias0) / scale0
    return Standing(
        np.arange(n) / 80.0, counts, np.concatenate(coms), np.concatenate(cells),
        np.concatenate(yaws), np.repeat(np.arange(stances), samples), scale0, bias0, gain, bias,
        true, np.concatenate(contacts), mass,
    )  # fmt: skip
