"""None is a claim about the residual: it must be small against what is known without the log.

A calibration that is free in every block, or in every stance, follows a crosstalk or a wrong mass,
and no test then finds anything in what is left. The residual of the calibration in use is compared
with the noise of single rows and with how far that calibration may be off.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.inference.case import Case, Rows
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.signatures import calibration_columns
from footcal_cli.core.inference.whitening import noise_of
from footcal_cli.core.parameters import FloatArray

_RCOND = 1e-12
MOST = 5.0
"""So many times the floor is no residual of nothing."""


def times_floor(case: Case, rows: Rows, problem: Problem) -> FloatArray:
    """RMS residual of each output over its floor ``√(s² + mean(J C Jᵀ))``, shape (outputs,).

    s is the innovation sd of the rows, C the covariance of what was known of the calibration; where
    nothing was known, the residual is what the best calibration leaves.
    """
    floor = noise_of(problem).whitener.sd ** 2
    left = problem.residual
    if case.known is None:
        if problem.drifts:
            return np.zeros(floor.size)
        left = problem.left_of(left)
    else:
        columns, turn = calibration_columns(case, rows)
        covariance = scaled_inverse(turn.T @ case.known @ turn, _RCOND)
        floor = floor + _mean(np.sum((columns @ covariance) * columns, axis=1), problem)
    return np.sqrt(_mean(left**2, problem) / np.maximum(floor, 1e-300))


def _mean(values: FloatArray, problem: Problem) -> FloatArray:
    """Mean over the rows of each output, shape (outputs,)."""
    outputs = len(problem.outputs)
    count = np.bincount(problem.output, minlength=outputs)
    return np.bincount(problem.output, values, minlength=outputs) / np.maximum(count, 1)
