"""What of a candidate shows beside the calibration, and from which size on it matters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.core.inference.grams import Grams
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray

_SWOLLEN = 0.25  # of an output's squared error is left beside a candidate: the rest was no noise
_LEAST = 1e-6


def yardsticks(problem: Problem, grams: Grams) -> tuple[FloatArray, FloatArray]:
    """Visible fraction and smallest size that matters of each candidate, shape (k,) each."""
    if problem.tracking is None:
        left = problem.left()
        if problem.known is not None:
            # what matters is what the calibration in use makes of an effect
            return problem.visible(left), problem.smallest_sizes(problem.columns)
        return problem.visible(left), _smallest_sizes(problem, left)
    if problem.held is not None:
        # as above; what a common gain would take is an error of the forces all the same
        return grams.visible[grams.candidates], problem.smallest_sizes(problem.columns)
    smallest = np.full(len(problem.signatures), np.inf)
    for o in range(len(problem.outputs)):
        rows = problem.output == o
        if not rows.any():
            continue
        rms = np.sqrt(grams.energy[o, grams.candidates] / rows.sum()) * problem.noise[rows][0]
        with np.errstate(divide="ignore"):
            smallest = np.minimum(smallest, problem.tolerance[o] / rms)
    return grams.visible[grams.candidates], smallest


def _smallest_sizes(problem: Problem, left: FloatArray) -> FloatArray:
    """The smallest size of each candidate that matters, in the noise that there is beside it.

    A large effect is mistaken for noise of the outputs that it touches. Calibration is then fitted
    to the others, and brings less of the effect into them than it will once the effect is known:
    what moves one foot's CoP by 2 mm would not matter.
    """
    smallest = problem.smallest_sizes(left)
    shares = _left_of_noise(problem, left)
    for k in np.flatnonzero(shares.min(axis=0) < _SWOLLEN):
        own = _in_noise(problem, int(k), np.sqrt(np.maximum(shares[:, k], _LEAST)))
        smallest[k] = own.smallest_sizes(own.left())[0]
    return smallest


def _left_of_noise(problem: Problem, left: FloatArray) -> FloatArray:
    """Share of the squared error of each output that is left beside each candidate, (o, k)."""
    error = problem.left_of(problem.residual)
    size = left.T @ error / np.maximum(np.einsum("mk,mk->k", left, left), 1e-300)
    shares = np.ones((len(problem.outputs), left.shape[1]))
    for o in range(len(problem.outputs)):
        rows = problem.output == o
        whole = error[rows] @ error[rows]
        if whole > 0.0:
            shares[o] = np.sum((error[rows, None] - left[rows] * size) ** 2, axis=0) / whole
    return shares


def _in_noise(problem: Problem, candidate: int, scale: FloatArray) -> Problem:
    """One candidate alone, rows in units of a noise that is smaller by a factor per output."""
    rows = scale[problem.output]
    return replace(
        problem.scaled(rows),
        columns=problem.columns[:, [candidate]] / rows[:, None],
        signatures=(problem.signatures[candidate],),
        noise=problem.noise * rows,
    )
