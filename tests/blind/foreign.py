"""Distortions of one channel or stream, written from the literature and not from footcal's table.

Each takes arrays and a size and returns arrays; `fresh` marks rows where a memory starts rested.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, lfilter, lfilter_zi

from tests.blind.world import Array, Rng

Flags = NDArray[np.bool_]


def bouc_wen(x: Array, fresh: Flags, width_n: float, yield_n: float) -> Array:
    """Hysteresis after Bouc and Wen: ``dz = dx (1 − |z| (1 + sgn(z dx)) / 2) / D``, y = x − w z/2.

    Wen, J. Eng. Mech. Div. ASCE 102 (1976), exponent 1; z in −1 … 1.
    """
    step = np.diff(x, axis=0, prepend=x[:1]) / yield_n
    step[fresh] = 0.0
    z = np.zeros_like(x)
    state = np.zeros(x.shape[1])
    for i in range(len(x)):
        if fresh[i]:
            state = np.zeros(x.shape[1])
        # large steps in small ones, so that z stays below one
        parts = int(np.clip(np.ceil(np.abs(step[i]).max() * 4), 1, 40))
        for _ in range(parts):
            d = step[i] / parts
            state = state + d * (1.0 - np.abs(state) * (d * state > 0))
        z[i] = np.clip(state, -1.0, 1.0)
    return x - 0.5 * width_n * z


def preisach(x: Array, fresh: Flags, width_n: float, relays: int = 24) -> Array:
    """Hysteresis after Preisach: the mean of relays on a triangle of thresholds.

    The mean of the two branches at each load is taken out, so that only the loop is left.
    """
    low, high = float(x.min()), float(x.max())
    edge = np.linspace(low, high + 1e-9, relays + 1)
    up, down = (g.ravel() for g in np.meshgrid(edge[1:], edge[:-1], indexing="ij"))
    kept = up - down <= 0.35 * (high - low)
    kept &= up > down
    up, down = up[kept], down[kept]
    out = np.empty_like(x)
    for j in range(x.shape[1]):
        relay = -np.ones(up.size)
        for i, value in enumerate(x[:, j]):
            if fresh[i]:
                relay = np.where(value > 0.5 * (up + down), 1.0, -1.0)
            relay = np.where(value >= up, 1.0, np.where(value <= down, -1.0, relay))
            out[i, j] = relay.mean()
    rising = np.array([np.mean(np.where(e >= up, 1.0, -1.0)) for e in edge])
    falling = np.array([np.mean(np.where(e > down, 1.0, -1.0)) for e in edge])
    middle = np.interp(x, edge, 0.5 * (rising + falling))
    loop = float(np.max(falling - rising)) or 1.0
    return np.asarray(x + width_n * (out - middle) / loop)


def two_stage_creep(
    x: Array, time_s: Array, fresh: Flags, share: float, fast_s: float, slow_s: float
) -> Array:
    """Creep with two time constants, 40 % of it fast."""
    fast, slow = slow_part(x, time_s, fresh, fast_s), slow_part(x, time_s, fresh, slow_s)
    return x + share * (0.4 * fast + 0.6 * slow)


def slow_part(x: Array, time_s: Array, fresh: Flags, tau_s: float) -> Array:
    """First-order follower of the load, starting unloaded; exact for a load that steps."""
    decay = np.exp(-np.diff(time_s, prepend=time_s[:1]) / tau_s)
    out = np.zeros_like(x)
    state = np.zeros(x.shape[1])
    for i in range(len(x)):
        state = np.zeros(x.shape[1]) if fresh[i] else x[i] + (state - x[i]) * decay[i]
        out[i] = state
    return out


def tanh_saturation(x: Array, limit_n: float) -> Array:
    """An amplifier that bends before it stops: ``L tanh(x / L)``."""
    return np.asarray(limit_n * np.tanh(x / limit_n))


def exponential_bend(x: Array, size_n: float, load_n: float) -> Array:
    """A curve no polynomial table holds: ``x + s (1 − exp(−x / l))``."""
    return np.asarray(x + size_n * (1.0 - np.exp(-np.clip(x, 0.0, None) / load_n)))


def soft_dead_zone(x: Array, share: float, width_n: float) -> Array:
    """A cell that is deaf to small loads: ``x − s w tanh(x / w)``."""
    return np.asarray(x - share * width_n * np.tanh(x / width_n))


def soft_hinge(x: Array, share: float, load_n: float) -> Array:
    """A second spring comes to bear beyond a load, softly: ``x + s d log(1 + exp((x − l)/d))``."""
    width_n = 0.08 * load_n
    return np.asarray(x + share * width_n * np.logaddexp(0.0, (x - load_n) / width_n))


def neighbour_crosstalk(x: Array, share: float, feet: list[list[int]]) -> Array:
    """Each cell hears the next cell round the foot, and only that one."""
    y = x.copy()
    for cells in feet:
        y[:, cells] += share * np.roll(x[:, cells], 1, axis=1)
    return y


def soft_bypass(x: Array, share: float, touch_n: float, feet: list[list[int]]) -> Array:
    """A shell that comes to bear softly beside the cells of a foot and takes part of the load.

    A foot in the air carries nothing that it could take, whatever its cells show of their plates.
    """
    y = x.copy()
    width = 0.15 * touch_n + 0.2
    at_rest = np.logaddexp(0.0, -touch_n / width)
    for cells in feet:
        total = np.clip(x[:, cells].sum(axis=1), 1e-3, None)
        beside = share * width * (np.logaddexp(0.0, (total - touch_n) / width) - at_rest)
        y[:, cells] *= (1.0 - beside / total)[:, None]
    return y


def thermal_lag(degc: Array, time_s: Array, fresh: Flags, tau_s: float) -> Array:
    """Temperature of the gauge, which follows the thermometer with a lag, shape (n,)."""
    out = degc.copy()
    for i in range(1, len(degc)):
        decay = np.exp(-max(time_s[i] - time_s[i - 1], 0.0) / tau_s)
        out[i] = degc[i] if fresh[i] else degc[i] + (out[i - 1] - degc[i]) * decay
    return out


def jittered_delay(rng: Rng, time_s: Array, stream: Array, delay_s: float) -> Array:
    """A stream that comes late by resampling, with jitter of a tenth of the delay."""
    jitter = lfilter([0.3], [1.0, -0.7], rng.normal(size=time_s.size)) * 0.1 * abs(delay_s)
    then = time_s - delay_s - jitter
    flat = stream.reshape(len(stream), -1)
    late = np.stack([np.interp(then, time_s, column) for column in flat.T], axis=1)
    return late.reshape(stream.shape)


def butterworth_lag(time_s: Array, stream: Array, lag_s: float) -> Array:
    """A second-order low-pass whose delay at low frequency is `lag_s`."""
    rate = 1.0 / float(np.median(np.diff(time_s)))
    cutoff = np.sqrt(2.0) / (2.0 * np.pi * lag_s)
    if cutoff >= 0.45 * rate:
        return stream
    b, a = butter(2, cutoff / (0.5 * rate))
    flat = stream.reshape(len(stream), -1)
    late, _ = lfilter(b, a, flat, axis=0, zi=lfilter_zi(b, a)[:, None] * flat[:1])
    return np.asarray(late).reshape(stream.shape)


def mains_hum(rng: Rng, time_s: Array, size_n: float, channels: int) -> Array:
    """Pick-up of one frequency with an amplitude of its own per channel, shape (n, channels).

    The frequency is what 50 or 60 Hz folds to, or a fan's; it keeps its phase.
    """
    step = float(np.median(np.diff(time_s)[np.diff(time_s) > 0]))
    frequency = rng.uniform(0.07, 0.38) / step
    strength = rng.uniform(0.6, 1.4, channels)
    phase = rng.uniform(0, 0.6, channels)
    return np.asarray(size_n * strength * np.sin(2 * np.pi * frequency * time_s[:, None] + phase))


def sticking(rng: Rng, x: Array, fresh: Flags, friction_n: float) -> Array:
    """A cell whose guide jams now and then: it holds its reading until the force breaks it loose.

    Always jammed would be the play of a hysteresis; this one jams in spells of random length.
    """
    y = x.copy()
    jammed = np.zeros(len(x), dtype=bool)
    at = 0
    while at < len(x):
        free, stuck = int(rng.integers(10, 120)), int(rng.integers(10, 120))
        jammed[at + free : at + free + stuck] = True
        at += free + stuck
    held = x[0]
    for i in range(1, len(x)):
        loose = fresh[i] or not jammed[i] or not jammed[i - 1]
        held = np.where(loose | (np.abs(x[i] - held) > friction_n), x[i], held)
        y[i] = held
    return y


def ringing(
    x: Array, time_s: Array, fresh: Flags, share: float, frequency_hz: float, decay_s: float
) -> Array:
    """A loose mass that rings after every quick change of load."""
    jump = np.diff(x, axis=0, prepend=x[:1])
    jump[fresh] = 0.0
    step = np.diff(time_s, prepend=time_s[:1])
    pole = np.exp((2j * np.pi * frequency_hz - 1.0 / decay_s) * step)
    out = np.zeros_like(x)
    state = np.zeros(x.shape[1], dtype=complex)
    for i in range(len(x)):
        state = np.zeros_like(state) if fresh[i] else pole[i] * state + jump[i]
        out[i] = state.imag
    return x + share * out


def cable_tug(rng: Rng, time_s: Array, fresh: Flags, size_n: float) -> Array:
    """A cable that pulls now and then: spells of random length, one direction, shape (n,)."""
    out = np.zeros(time_s.size)
    edges = np.flatnonzero(fresh)
    for start, stop in zip(edges, [*edges[1:], time_s.size], strict=True):
        at = start
        while at < stop:
            quiet = int(rng.integers(1, max(2, (stop - start) // 3) + 1))
            pull = int(rng.integers(1, max(2, (stop - start) // 5) + 1))
            out[at + quiet : min(at + quiet + pull, stop)] = size_n * rng.uniform(0.5, 1.5)
            at += quiet + pull
    return out


def edge_contact(x: Array, share: float, limit: float, feet: list[list[int]]) -> Array:
    """A sole that rolls over its edge: the front unloads beyond a load share `limit`."""
    y = x.copy()
    for cells in feet:
        total = np.clip(x[:, cells].sum(axis=1), 1e-6, None)
        half = len(cells) // 2
        front = x[:, cells[:half]].sum(axis=1) / total
        beyond = np.clip(front - limit, 0.0, None) * total * share
        y[:, cells[:half]] -= beyond[:, None] / half * 0.3
        y[:, cells[half:]] += beyond[:, None] / (len(cells) - half)
    return y
