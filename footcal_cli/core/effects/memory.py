"""Operators with memory that the effects are made of, vectorised over rows and channels.

A recording starts afresh (`RowIntervals.fresh`) where its stamps step back, and where nothing was
recorded between two blocks for longer than `BREAK_S`: two sessions in one log share no memory.
Readings by hand are as far apart within a session: where the next session goes on at that pace,
nothing else was loaded meanwhile, and a cell remembers (`PACE`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.effects.contract import ArrayTransform, EffectParameter, GridOf, State, Theta
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

BREAK_S = 10.0
"""Time without a row between two blocks after which nobody knows what was loaded meanwhile; within
a block a long hold may have few rows."""
PACE = 1.5
"""So many times as long as the rows before it lay apart is still the next reading, not a break."""
HALF_AN_HOUR_S = 1800.0
_STEADY = 1e-9
"""A drift that settles by less of itself in half an hour is steady."""
_FEW = 16
"""Rows per one that is still open, from which the open ones alone are joined."""
_FORGOTTEN = 1e-30
"""A decay this small over a stretch leaves nothing to carry on."""


@dataclass(frozen=True)
class RowIntervals:
    """Time between rows, and where a recording starts afresh.

    Parameters
    ----------
    interval_s
        Time since the row before, shape (n,); 0 at a fresh start.
    fresh
        Rows that start a recording, shape (n,).
    """

    interval_s: FloatArray
    fresh: BoolArray


def recording(
    time_s: FloatArray,
    last_s: float | None,
    block: IntArray | None = None,
    last_block: int = -1,
    last_apart_s: float = 0.0,
) -> RowIntervals:
    """Intervals of a chunk, and where a recording starts afresh.

    Parameters
    ----------
    time_s, last_s
        Stamps, shape (n,), and that of the row before, if any.
    block, last_block
        Block of each row, shape (n,), and of the row before; without them a break is not seen.
    last_apart_s
        Time from the row before that one to it, 0 where they are of two blocks.
    """
    before = np.concatenate([[np.inf if last_s is None else last_s], time_s[:-1]])
    fresh = time_s < before
    if block is not None:
        other = block != np.concatenate([[last_block], block[:-1]])
        since = time_s - before
        apart = np.concatenate([[last_apart_s], np.where(other | fresh, 0.0, since)[:-1]])
        fresh |= other & (since > np.maximum(BREAK_S, PACE * apart))
    return RowIntervals(np.where(fresh, 0.0, time_s - before), fresh)


RowState = tuple[float, int, float]
"""Stamp and block of the last row, and how long after the one before it in its block it came."""


def row_intervals(log: Log, last: RowState | None) -> tuple[RowIntervals, RowState]:
    """The recording of a log's chunk after the row `last`, and what the next chunk goes on from."""
    return log.of_time(_rows_of_all) if last is None else _rows_after(log, last)


def _rows_of_all(log: Log) -> tuple[RowIntervals, RowState]:
    return _rows_after(log, (None, -1, 0.0))


def _rows_after(log: Log, last: tuple[float | None, int, float]) -> tuple[RowIntervals, RowState]:
    last_s, last_block, apart_s = last
    passed = recording(log.time_s, last_s, log.block, last_block, apart_s)
    block_before = last_block if len(log) == 1 else int(log.block[-2])
    within = int(log.block[-1]) == block_before
    apart_s = float(passed.interval_s[-1]) if within else 0.0
    return passed, (float(log.time_s[-1]), int(log.block[-1]), apart_s)


ElapsedState = tuple[float, float]
"""First and last stamp of the recording so far."""


def elapsed(log: Log, state: ElapsedState | None) -> tuple[FloatArray, ElapsedState]:
    """Time since each recording's first row (n,), and what the next chunk goes on from."""
    return log.of_time(_elapsed_of_all) if state is None else _elapsed_after(log, state)


def _elapsed_of_all(log: Log) -> tuple[FloatArray, ElapsedState]:
    return _elapsed_after(log, (np.nan, None))


def _elapsed_after(log: Log, state: tuple[float, float | None]) -> tuple[FloatArray, ElapsedState]:
    (first, last), time_s = state, log.time_s
    fresh = recording(time_s, last).fresh
    start = np.maximum.accumulate(np.where(fresh, np.arange(time_s.size), -1))
    origin = np.where(start < 0, first, time_s[start])
    return time_s - origin, (float(origin[-1]), float(time_s[-1]))


def plus_since(
    amount: Callable[[FloatArray, Theta], FloatArray], sign: float = 1.0
) -> ArrayTransform:
    """``x + amount`` of the time since the recording's first row; with the sign −1 back."""

    def moved(x: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
        since, state = elapsed(log, state)
        return x + sign * amount(since, theta), state

    return moved


def settling(since_s: FloatArray, rate_ps: FloatArray) -> FloatArray:
    """A drift that comes to rest, ``t₁ (1 − exp(−r t)) / (1 − exp(−r t₁))``, or t where r is zero.

    After t₁, half an hour, it has come as far as a steady one: times a mean rate it is what has
    drifted, and how fast it settles changes that rate little.

    Parameters
    ----------
    since_s, rate_ps
        t and r, shapes that broadcast.
    """
    steady = rate_ps * HALF_AN_HOUR_S < _STEADY
    rate = np.where(steady, 1.0, rate_ps)
    settled = HALF_AN_HOUR_S * np.expm1(-rate * since_s) / np.expm1(-rate * HALF_AN_HOUR_S)
    return np.asarray(np.where(steady, since_s, settled))


def settling_rate() -> EffectParameter:
    """How soon a drift comes to rest, 1/s: steady at first, with 0 for good."""
    return EffectParameter(
        "drift_settling", "1/s", 0.0, 0.0, 10.0, 3e-3, True, (0.0, 2.5, 5.0, 10.0), GridOf.RATE
    )


def moment(name: str, parts: int) -> EffectParameter:
    """When a change happened, s since the recording's first row; tried at such parts of a log."""
    shares = tuple(round(k / parts, 2) for k in range(1, parts))
    return EffectParameter(name, "s", 20.0, 0.0, 1e6, 20.0, True, shares, GridOf.SPAN)


def linear_recurrence(decay: FloatArray, drive: FloatArray, start: FloatArray) -> FloatArray:
    """Solve ``s_k = decay_k s_{k−1} + drive_k`` for all rows at once by doubling.

    Parameters
    ----------
    decay, drive
        Shape (n, c); a decay of 0 starts afresh.
    start
        ``s_{−1}``, shape (c,).
    """
    factor, total = decay.copy(), drive.copy()
    total[0] += factor[0] * start
    reach = 1
    while reach < len(total):
        total[reach:] += factor[reach:] * total[:-reach]
        factor[reach:] = factor[reach:] * factor[:-reach]
        factor[:reach] = 0.0
        if np.abs(factor).max(initial=0.0) < _FORGOTTEN:
            break
        reach *= 2
    return total


def low_pass_decay(interval_s: FloatArray, time_constant_s: FloatArray) -> FloatArray:
    """``exp(−Δt/τ)``, shape (n, c); τ = 0 forgets at once."""
    with np.errstate(divide="ignore"):
        rate = 1.0 / np.asarray(time_constant_s)
    exponent = np.zeros((interval_s.size, rate.size))
    np.multiply(interval_s[:, None], rate, out=exponent, where=interval_s[:, None] > 0)
    return np.exp(-exponent)


SHORTEST_INTERVAL_S = 1e-6
LowPassState = tuple[float, FloatArray, FloatArray]
"""Last stamp, last input (c,), last output (c,) of a low-pass."""


def first_order_low_pass(
    x: FloatArray, time_s: FloatArray, time_constant_s: FloatArray, state: LowPassState | None
) -> tuple[FloatArray, LowPassState]:
    """First-order low-pass ``τ dy/dt = x − y`` of an input that is linear between its samples.

    ``y_k = a y_{k−1} + (1 − g) x_k + (g − a) x_{k−1}``, a = exp(−Δt/τ), g = (1 − a) τ/Δt.
    A recording starts settled, y = x. Small τ act as a delay of τ, also (to first order)
    below zero, so that the signature at τ = 0 is the delay's.
    """
    fresh, decay, gain, x_before, y_before = _low_pass_terms(x, time_s, time_constant_s, state)
    drive = np.multiply(gain - decay, x_before, out=x_before)
    drive += (1.0 - gain) * x
    np.copyto(drive, x, where=fresh)
    y = linear_recurrence(np.where(fresh, 0.0, decay), drive, y_before)
    return y, (float(time_s[-1]), x[-1], y[-1])


def invert_low_pass(
    y: FloatArray, time_s: FloatArray, time_constant_s: FloatArray, state: LowPassState | None
) -> tuple[FloatArray, LowPassState]:
    """The input that `first_order_low_pass` turned into y; exact."""
    swapped = None if state is None else (state[0], state[2], state[1])
    fresh, decay, gain, y_before, x_before = _low_pass_terms(y, time_s, time_constant_s, swapped)
    drive = np.multiply(decay, y_before, out=y_before)
    np.subtract(y, drive, out=drive)
    drive /= 1.0 - gain
    np.copyto(drive, y, where=fresh)
    x = linear_recurrence(np.where(fresh, 0.0, (decay - gain) / (1.0 - gain)), drive, x_before)
    return x, (float(time_s[-1]), x[-1], y[-1])


def _low_pass_terms(
    signal: FloatArray, time_s: FloatArray, time_constant_s: FloatArray, state: LowPassState | None
) -> tuple[BoolArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Fresh rows, a, g, the signal one row before (n, c), and the other one's last value (c,)."""
    last, before, other = state or (None, np.zeros_like(signal[0]), np.zeros_like(signal[0]))
    passed = recording(time_s, last)
    ratio = np.maximum(passed.interval_s, SHORTEST_INTERVAL_S)[:, None]
    with np.errstate(divide="ignore"):
        ratio = ratio / np.asarray(time_constant_s)
    positive = ratio > 0
    decay = np.where(positive, np.exp(-np.where(positive, ratio, 0.0)), 0.0)
    gain = (1.0 - decay) / ratio
    return passed.fresh[:, None], decay, gain, np.vstack([before, signal[:-1]]), other


def play(drive: FloatArray, radius: FloatArray, start: FloatArray, fresh: BoolArray) -> FloatArray:
    """Play (backlash) of a radius: ``z_k = min(max(z_{k−1}, x_k − r), x_k + r)``.

    Each row is a clamp and clamps compose to clamps, so the rows are joined by doubling.

    Parameters
    ----------
    drive
        x, shape (n, c).
    radius
        r, shape (c,), not negative.
    start
        ``z_{−1}``, shape (c,); rows in `fresh` start from 0 instead.
    """
    reset = fresh.copy()
    reset[0] = True
    before = np.where(fresh[:, None], 0.0, start)[reset]
    out = np.empty_like(drive)
    for c, (x, r) in enumerate(zip(np.ascontiguousarray(drive.T), radius, strict=True)):
        low, high = x - r, x + r
        low[reset] = high[reset] = np.clip(before[:, c], low[reset], high[reset])
        out[:, c] = _joined(low, high)
    return out


def _joined(low: FloatArray, high: FloatArray) -> FloatArray:
    """Where the clamps of all rows up to each one lead, shape (n,); the first is to one value.

    Once most rows lead to one value whatever came before, the others go on alone.
    """
    next_low, next_high = np.empty_like(low), np.empty_like(high)
    reach, size = 1, len(low)
    while reach < size and np.count_nonzero(low != high) * _FEW > size:
        for ends, ends_next in ((low, next_low), (high, next_high)):
            np.maximum(ends[:-reach], low[reach:], out=ends_next[reach:])
            np.minimum(ends_next[reach:], high[reach:], out=ends_next[reach:])
            ends_next[:reach] = ends[:reach]
        low, next_low, high, next_high = next_low, low, next_high, high
        reach *= 2
    rows = np.flatnonzero(low != high)
    while (rows := rows[rows >= reach]).size:
        before = rows - reach
        bottom, top = low[rows], high[rows]
        low[rows] = np.minimum(np.maximum(low[before], bottom), top)
        high[rows] = np.minimum(np.maximum(high[before], bottom), top)
        rows = rows[low[rows] != high[rows]]
        reach *= 2
    return low
