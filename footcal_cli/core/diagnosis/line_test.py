"""Lines in what no recorded signal explains: hum and swinging weights, not the gait's harmonics."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from footcal_cli.core.diagnosis.features import GAIT, Features
from footcal_cli.core.inference.linear import least_squares
from footcal_cli.core.inference.lines import Line, Traces, pieces_of
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import begins

_ROUNDING = 1e-6


def line_of(problem: Problem, fitted: FloatArray, unexplained: Callable[[], FloatArray]) -> Line:
    """Strongest line of what was recorded, or of the rows where nothing else was.

    Rows are first rid of every function of the recorded signals, and each piece of its own
    calibration: a drifting gain would look like a line at the frequency of the load.
    """
    if problem.raw is not None:
        return problem.raw.strongest
    if problem.rate_hz <= 0:
        return Line()
    traces = problem.traces or _of_outputs(problem)
    left = unexplained().copy()
    own = np.hstack([fitted, np.ones((left.size, 1))])
    # a knee changes no row under no load but by the rounding of the noise that was taken out
    own[np.abs(own) < _ROUNDING * np.sqrt(np.mean(own**2, axis=0))] = 0.0
    for rows in pieces_of(traces, problem.rate_hz):
        left[rows] = _rid_of(left[rows], own[rows])
    return traces.series(left, problem.rate_hz).strongest


def rid_of_signals(problem: Problem, features: Features, fitted: FloatArray) -> FloatArray:
    """What no function of the recorded signals explains, output by output, shape (m,)."""
    left, harmonics = problem.residual.copy(), _harmonics(problem)
    for o in range(len(problem.outputs)):
        mine = np.flatnonzero(problem.output == o)
        known = (fitted[mine], features.columns[mine], harmonics[mine])
        left[mine] = _rid_of(left[mine], np.hstack(known))
    return left


def _harmonics(problem: Problem) -> FloatArray:
    """Sine and cosine of the harmonics of the gait below the rate, shape (m, 2 k).

    A step is sharper than what functions of its phase show: its tenth harmonic is no mains hum, nor
    what folds from above half the rate of rows that are samples and no means.
    """
    phase = problem.regressors.get(GAIT)
    if phase is None or problem.rate_hz <= 0:
        return np.empty((problem.residual.size, 0))
    steps = np.diff(phase)
    step = float(np.median(steps[steps > 0.0])) if np.any(steps > 0.0) else 1.0
    angle = 2.0 * np.pi * phase[:, None] * np.arange(1, int(1.0 / step) + 1)
    return np.hstack([np.sin(angle), np.cos(angle)])


def _of_outputs(problem: Problem) -> Traces:
    """Sequences as pieces of their output, where nothing is known of channels."""
    fresh = begins(problem.sequence)
    index = np.arange(fresh.size)
    since = index - np.maximum.accumulate(np.where(fresh, index, 0))
    return Traces(since / problem.rate_hz, problem.output, problem.outputs)


def _rid_of(values: FloatArray, basis: FloatArray) -> FloatArray:
    """Values less their regression on a basis, where rows are enough for one.

    Most columns are of other outputs or other cells, and zero here: they cost nothing.
    """
    basis = basis[:, basis.any(axis=0)]
    if basis.shape[0] <= 2 * basis.shape[1]:
        return values
    return np.asarray(values - basis @ least_squares(basis, values, 1e-8))
