"""A reading that is pushed to a second level and comes back: spells, not coloured noise.

Spells of a constant push have the spectrum of coloured noise, so that only their two levels tell
them from it. Compared are the likelihoods of two models of a channel: noise of any colour (an
autoregression, fitted), and a weaker coloured noise on a level that is pushed at random times, now
harder and now less hard, averaged over pushes, rates and colours that are fixed beforehand. Under
the first model the mean of this ratio is at most one, hence ``p ≤ 1/ratio`` (Markov's inequality).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg import solve_toeplitz

from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.whitening import residual_within_blocks
from footcal_cli.core.parameters import FloatArray, IntArray

_ORDER = 5
_STAYS = ((6.0, 4.0), (18.0, 12.0), (54.0, 36.0))
"""Mean rows without and with the push: from a few rows to most of a stretch."""
_COLOURS = (0.0, 0.4, 0.8, 0.95, 0.985)
_PUSHES = (0.8, 1.1, 1.4, 1.7, 1.95)  # over the sd of the reading, were all pushes alike
_HARD = np.array([0.6, 1.0, 1.4])
"""Single pushes over their mean: nothing pulls twice as hard."""
_TINY = 1e-300
_SHORTEST = 30
_STANDS = 0.4
"""A reading that repeats itself more often than this shows its converter's steps, which are levels
too: white noise of one step is the same twice running in 28 %. Simulated noise of six colours and
seven steps has ratios below one to 0.5 where it is even and to 0.44 where it grows with the load,
far above one from 0.55 on."""
_LEAST_SPREAD = 0.3
_LOAD = "load"


@dataclass(frozen=True)
class _Switching:
    """Models of a level that switches, one per entry, shape (g,) each.

    `level` and `start` are (g, levels), the one without a push first, `change` (from, to, g).
    """

    colour: FloatArray
    level: FloatArray
    noise: FloatArray
    start: FloatArray
    change: FloatArray


def levels_p(problem: Problem, left: FloatArray) -> float:
    """Bound on the p that no channel is pushed to a second level and comes back.

    Each block has its own calibration; noise that grows with the load is made even. The ratios of
    the channels are averaged, which keeps the bound.

    Parameters
    ----------
    problem
        Rows that are series of channels.
    left
        What no function of the recorded signals explains, shape (m,).
    """
    if problem.traces is None:
        return 1.0
    residual = residual_within_blocks(problem, left)
    p = []
    for channel in range(len(problem.traces.names)):
        rows = np.flatnonzero(problem.traces.channel == channel)
        fresh = np.flatnonzero(np.diff(problem.sequence[rows])) + 1
        series = [s for s in np.split(rows, fresh) if s.size >= _SHORTEST]
        if series and _repeats(problem, series) < _STANDS:
            rows = np.concatenate(series)
            even = np.split(_evened(problem, residual, rows), np.cumsum([s.size for s in series]))
            p.append(switching_p(even[:-1]))
    return float(1.0 / np.mean(1.0 / np.maximum(p, _TINY))) if p else 1.0


def _repeats(problem: Problem, series: Sequence[IntArray]) -> float:
    """Share of readings that are the one before, where nothing was changed.

    Not to the last digit: a model that corrects for temperature moves every row a little.
    """
    steps = [np.empty(0)]
    little = _HELD * np.ptp(problem.calibration, axis=0)
    for rows in series:
        held = np.all(np.abs(np.diff(problem.calibration[rows], axis=0)) <= little, axis=1)
        steps.append(np.diff(problem.residual[rows])[held])
    step = np.abs(np.concatenate(steps))
    if not step.size:
        return 0.0
    return float(np.mean(step <= _SAME * np.sqrt(np.mean(step**2))))


_SAME = 0.05  # of the usual step from row to row
_HELD = 1e-3  # of the range of a calibration column


def _evened(problem: Problem, residual: FloatArray, rows: IntArray) -> FloatArray:
    """Residual over its usual size at the load, ``a + b·load²``."""
    size = np.abs(residual[rows])
    basis = np.ones((rows.size, 1))
    if _LOAD in problem.regressors:
        load = problem.regressors[_LOAD][rows]
        basis = np.column_stack([basis, load**2 / max(float(np.mean(load**2)), _TINY)])
    usual = basis @ np.linalg.lstsq(basis, size, rcond=None)[0]
    least = _LEAST_SPREAD * float(size.mean()) + _TINY
    return np.asarray(residual[rows] / np.maximum(usual, least))


def switching_p(series: Sequence[FloatArray]) -> float:
    """Bound on the p that a channel's noise alone makes what looks like spells.

    Parameters
    ----------
    series
        The channel in gap-free stretches, each of mean zero and even noise.
    """
    long = [s for s in series if s.size > 2 * _ORDER]
    if not long or not any(np.any(s) for s in long):
        return 1.0
    quiet = _coloured(long)
    pushed = _switched(long)
    highest = float(pushed.max())
    ratio = highest - quiet + float(np.log(np.mean(np.exp(pushed - highest))))
    return float(np.exp(-np.clip(ratio, 0.0, 700.0)))


def _coloured(series: Sequence[FloatArray]) -> float:
    """Log likelihood of the fitted autoregression, of all rows with a full past."""
    covariance = np.zeros(_ORDER + 1)
    for s in series:
        covariance += [s[lag:] @ s[: s.size - lag] for lag in range(_ORDER + 1)]
    covariance[0] *= 1.0 + 1e-6
    share = solve_toeplitz(covariance[:-1], covariance[1:])
    left = np.concatenate(
        [
            s[_ORDER:] - sum(a * s[_ORDER - 1 - i : s.size - 1 - i] for i, a in enumerate(share))
            for s in series
        ]
    )
    return -0.5 * left.size * float(np.log(2.0 * np.pi * np.mean(left**2) + _TINY) + 1.0)


def _switched(series: Sequence[FloatArray]) -> FloatArray:
    """Log likelihoods of every model of a switching level, of the same rows, shape (g,)."""
    models = _models(float(np.mean(np.concatenate(series) ** 2)))
    longest = max(s.size for s in series)
    rows = np.zeros((len(series), longest))
    there = np.zeros(rows.shape, dtype=bool)
    for i, s in enumerate(series):
        rows[i, : s.size], there[i, : s.size] = s, True
    first = models.noise / np.sqrt(1.0 - models.colour**2)
    state = models.start * _normal(rows[:, 0, None, None] - models.level, first[:, None])
    total = np.zeros(state.shape[:2])
    state /= state.sum(axis=2, keepdims=True) + _TINY
    # all changes at once, sorted by the level they lead to: shape (g, changes)
    after, before = np.nonzero(models.change[..., 0].T > 0.0)
    leads_to = np.flatnonzero(np.diff(after, prepend=-1))
    mean = models.level[:, after] - models.colour[:, None] * models.level[:, before]
    share = models.change[before, after].T
    for t in range(1, longest):
        step = rows[:, t, None] - models.colour * rows[:, t - 1, None]
        chance = share * _normal(step[:, :, None] - mean, models.noise[:, None])
        moved = np.add.reduceat(state[:, :, before] * chance, leads_to, axis=2)
        sum_ = moved.sum(axis=2) + _TINY
        known = there[:, t, None]
        if t >= _ORDER:
            total += np.where(known, np.log(sum_), 0.0)
        state = np.where(known[:, :, None], moved / sum_[:, :, None], state)
    return np.asarray(total.sum(axis=0))


def _models(variance: float) -> _Switching:
    """Pushes up and down on noise of several colours, all of the variance of the reading."""
    tried = [(*stay, *rest) for stay, *rest in product(_STAYS, _COLOURS, _PUSHES, (1.0, -1.0))]
    quiet, pulled, colour, push, side = np.array(tried).T
    on = pulled / (quiet + pulled)
    part = on * (1.0 - on) * push**2
    usual = on * np.mean(_HARD**2) - (on * _HARD.mean()) ** 2  # variance of levels, mean push one
    size = side * np.sqrt(variance * part / usual)
    hard = np.concatenate([[0.0], _HARD])
    of_each = np.full(_HARD.size, 1.0 / _HARD.size)
    change = np.zeros((hard.size, hard.size, on.size))
    change[0, 0], change[0, 1:] = 1.0 - 1.0 / quiet, of_each[:, None] / quiet
    change[1:, 0] = 1.0 / pulled
    change[range(1, hard.size), range(1, hard.size)] = 1.0 - 1.0 / pulled
    return _Switching(
        colour=colour,
        level=(hard - (on * _HARD.mean())[:, None]) * size[:, None],
        noise=np.sqrt(variance * (1.0 - part) * (1.0 - colour**2)),
        start=np.concatenate([1.0 - on[:, None], on[:, None] * of_each], axis=1),
        change=change,
    )


def _normal(x: FloatArray, sd: FloatArray) -> FloatArray:
    return np.asarray(np.exp(-0.5 * (x / sd) ** 2) / (sd * np.sqrt(2.0 * np.pi)))
