"""None is a claim about the residual: it must be small against what is known without the log.

A calibration that is free in every block, or in every stance, follows a crosstalk or a wrong mass,
and no test then finds anything in what is left. The residual of the calibration in use is compared
with the noise of single rows and with how far that calibration may be off.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.signatures import calibration_columns
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import means_of

_RCOND = 1e-12
MOST = 5.0
"""So many times the floor is no residual of nothing."""
_MOST_ROWS, _NORMAL = 0.9, float(chances.norm_isf(0.05))
"""Share of differences that spells leave alone, and what they are of a normal variable's sd: not
the half, in which coarse readings stand still."""
_LARGEST = 0.99
_MOST_OF_LEVELS = 3.0
"""Likewise of levels, in which the noise of single rows has averaged out."""


def times_floor(case: Case, problem: Problem) -> float:
    """Largest RMS residual of a log's output, or of its level from block to block, over a floor.

    ``√(s² + t² + mean(J C Jᵀ))`` for single rows, and with ``s²/n`` for the mean of the n rows of a
    block: s is the innovation sd of the rows, t the tolerance, C the covariance of what was known
    of the calibration. Where nothing was known, the residual is what the best calibration leaves. A
    law of what differs between hangings takes up a level that drifts in one leg; it is a residual
    all the same.
    """
    unit = np.maximum(means_of(problem.noise, problem.output, len(problem.outputs)), 1e-300)
    sd = problem.law.whitener.sd
    if problem.settings is not None:
        sd = np.minimum(sd, _sd_of_most(problem) / unit)
    noise = sd[problem.output] ** 2
    with np.errstate(over="ignore"):  # an output without noise has no floor
        allowed = ((problem.tolerance / unit) ** 2)[problem.output]
    left = problem.residual
    if case.known is None:
        if problem.drifts:
            return 0.0
        left = problem.left_of(left)
    else:
        columns, turn = calibration_columns(case, problem)
        covariance = scaled_inverse(turn.T @ case.known @ turn, _RCOND)
        allowed = allowed + np.sum((columns @ covariance) * columns, axis=1)
    outputs = len(problem.outputs)
    sensor = problem.log * outputs + problem.output
    times = np.sqrt(
        means_of(left**2, sensor) / np.maximum(means_of(noise + allowed, sensor), 1e-300)
    )
    if problem.pieces:
        times = np.maximum(times, _times_of_stances(case, problem))
    if problem.settings is not None:
        free = int(problem.settings.number.max())
        times = times / np.sqrt(_usual_excess(times**2, free))
        _, level = np.unique(np.stack([sensor, problem.block]), axis=1, return_inverse=True)
        at = level.ravel()
        mean, count = means_of(left, at), np.bincount(at)
        floor = np.maximum(means_of(noise, at) / count + means_of(allowed, at), 1e-300)
        whose = np.zeros(count.size, dtype=np.int64)
        whose[at] = sensor
        over = means_of(mean**2, whose) / np.maximum(means_of(floor, whose), 1e-300)
        levels = np.sqrt(over / _usual_excess(over, free))
        times = np.maximum(times, levels * MOST / _MOST_OF_LEVELS)
    return float(times.max(initial=0.0))


def _usual_excess(over: FloatArray, free: int) -> float:
    """What rows or levels of any sensor may vary by, as all of them do, in units of their floor.

    Noise with a long memory, and zeros that move with every hanging, are in all sensors alike;
    of a few levels each, the largest of many sensors is far above their median.

    Parameters
    ----------
    over
        Mean square of the rows, or the levels, of each sensor over its floor, shape (sensors,).
    free
        Number of settings without one: so many levels of a sensor are their own.
    """
    far = float(chances.chi2_ppf(_LARGEST, max(free, 1)) / chances.chi2_ppf(0.5, max(free, 1)))
    return 1.0 + far * max(float(np.median(over)) - 1.0, 0.0)


def _sd_of_most(problem: Problem) -> FloatArray:
    """Sd of single rows of each output, as most rows of a block differ from the next, (outputs,).

    What comes in spells makes the law of the noise as large as itself. Infinite without such rows.
    """
    sensor = problem.log * len(problem.outputs) + problem.output
    order = np.lexsort((np.arange(sensor.size), problem.block, sensor))
    next_to = np.diff(np.stack([sensor, problem.block])[:, order], axis=1)
    size = np.abs(np.diff((problem.residual * problem.noise)[order]))[~next_to.any(axis=0)]
    output = problem.output[order][1:][~next_to.any(axis=0)]
    found = np.full(len(problem.outputs), np.inf)
    for o in np.unique(output):
        found[o] = np.quantile(size[output == o], _MOST_ROWS) / (_NORMAL * np.sqrt(2.0))
    return found


def _times_of_stances(case: Case, problem: Problem) -> float:
    """RMS of a force from stance to stance over what tolerance and scatter within one allow.

    Of what the best calibration leaves. A robot weighs the same however it stands; moments are left
    out: where its CoM is believed is off by another amount in every stance. What does not repeat
    from load to load is usually as large as the noise of single readings, and is their noise: a
    level is large that is large against both.
    """
    times, left = [0.0], problem.left_of(problem.residual)
    single = case.reading_noise_n**2 * max(len(log.channels) for log in case.logs)
    for o in (i for i, unit in enumerate(problem.units) if unit == "N"):
        mine = problem.output == o
        count = np.bincount(problem.block[mine], minlength=problem.blocks)
        mean = means_of(left[mine], problem.block[mine], problem.blocks)
        several = count > 1
        if not several.any():
            continue
        apart = left[mine] - mean[problem.block[mine]]
        free = count[several] - 1
        own = np.bincount(problem.block[mine], apart**2, problem.blocks)[several] / free
        # of most stances: something may happen within one
        within = float(np.median(own / (chances.chi2_ppf(0.5, free) / free)))
        unit = float(np.mean(problem.noise[mine]))
        floor = within / np.maximum(count, 1) + (problem.tolerance[o] / unit) ** 2
        shown = count > 0
        level = np.sqrt(np.mean(mean[shown] ** 2))
        readings = level * unit / max(np.sqrt(single + problem.tolerance[o] ** 2), 1e-300)
        levels = level / np.sqrt(np.mean(floor[shown])) * MOST / _MOST_OF_LEVELS
        times.append(float(min(levels, readings)))
    return max(times)


def is_large(case: Case, problem: Problem) -> bool:
    """Whether a residual is no residual of nothing, whatever names were tried and refused."""
    return times_floor(case, problem) >= MOST
