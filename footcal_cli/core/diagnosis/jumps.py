"""A channel at rest that jumps: what a tugged cable or a guide that jams leaves between steps.

A cell in the air reads nothing but its offset, and offsets wander slowly. From one swing to the
next they move by little, and by as much at any time; a jump of many times that much is no drift.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import stats

from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray

SWINGS = (1, 2, 4)
"""Swings that are averaged on both sides of a jump."""
_FEWEST = 8
"""Differences asked for: of fewer nobody knows what is usual."""
_BROKEN = 2.5
"""A swing ends where rows are further apart than this many samples."""
_NORMAL = 1.4826  # sd of a normal variable over its median |x|
_STEP = np.sqrt(12.0)  # of a converter over the sd of its rounding
_OFTEN = 0.9
"""A coarse reading stands, and now and then is a step off: its noise shows in the
largest tenth of all differences, not in half of them."""
_MEDIAN_EFFICIENCY = 0.37  # of a median-based variance against the mean square


def jump_p(problem: Problem, residual: FloatArray) -> float:
    """The p of the largest jump of any channel at rest, and of their mean (Bonferroni).

    Differences of neighbouring means over 1, 2 and 4 swings, over the usual difference: of this
    channel, of all channels or of the converter's steps, whichever is largest.

    Parameters
    ----------
    problem
        Rows; channels that share an output are looked at where their foot is in the air.
    residual
        What is left, shape (m,).
    """
    swings = list(_swings(problem, residual))
    rounded = max((r for _, r in swings), default=0.0)
    least, tests = 1.0, 0.0
    for count in SWINGS:
        steps = [_differences(s, count) for s, _ in swings if len(s) >= 2 * count + _FEWEST]
        if not steps:
            continue
        usual = [_NORMAL * np.median(np.abs(step), axis=0) for step in steps]
        cells = _of_all(np.concatenate([step[:, :-1].ravel() for step in steps]), rounded)
        means = _of_all(np.concatenate([step[:, -1] for step in steps]), 0.5 * rounded)
        # neighbouring differences share swings
        known = sum(step[:, :-1].size for step in steps) / (1.0 + 0.5 * count)
        for step, own in zip(steps, usual, strict=True):
            common = np.append(np.full(own.size - 1, cells), means)
            scale = np.maximum(np.maximum(own, common), 1e-12)
            largest = float(np.max(np.abs(step) / scale))
            least = min(least, 2.0 * float(stats.t.sf(largest, _MEDIAN_EFFICIENCY * known)))
            tests += step.size / count
    return min(1.0, tests * least) if tests else 1.0


def _of_all(differences: FloatArray, rounded: float) -> float:
    """Usual size of differences of all channels, whose rounding has the given sd."""
    size = np.abs(differences)
    usual = _NORMAL * float(np.median(size))
    if usual < _STEP * rounded:
        usual = max(usual, float(np.quantile(size, _OFTEN) / stats.norm.ppf(0.5 + 0.5 * _OFTEN)))
    return max(usual, rounded)


def _swings(problem: Problem, residual: FloatArray) -> Iterator[tuple[FloatArray, float]]:
    """Mean over each swing: of every channel of a foot, and of all together, shape (swings, c + 1).

    Channels that rest at the same times are one foot's. The first and the last one, in which a gait
    begins and ends, are no step like the others. With it what the converter's steps make.
    """
    if problem.traces is None or problem.rate_hz <= 0 or problem.settings is not None:
        return
    channel, time_s = problem.traces.channel, problem.traces.time_s
    for o in range(len(problem.outputs)):
        own = np.unique(channel[problem.output == o])
        if own.size < 2:
            continue
        feet: dict[bytes, list[FloatArray]] = {}
        for c in own:
            rows = np.flatnonzero((channel == c) & (problem.output == o))
            gap = np.diff(time_s[rows], prepend=time_s[rows[:1]]) * problem.rate_hz
            number = np.cumsum(np.abs(gap) > _BROKEN)
            mean = np.bincount(number, residual[rows]) / np.bincount(number)
            feet.setdefault(time_s[rows].tobytes(), []).append(mean[1:-1])
        least = 0.0 if problem.least is None else float(problem.least[o])
        for means in feet.values():
            cells = np.stack(means, axis=1)
            yield np.column_stack([cells, cells.mean(axis=1)]), least


def _differences(values: FloatArray, count: int) -> FloatArray:
    """Mean of the next so many rows less that of the last so many, shape (n + 1 − 2·count, c)."""
    total = np.cumsum(np.vstack([0.0 * values[:1], values]), axis=0)
    mean = (total[count:] - total[:-count]) / count
    return np.asarray(mean[count:] - mean[:-count])
