"""A step from one stance to the next, where columns take up nearly all that an output shows.

Units of outputs were estimated from what a fit left of them, without the numbers that it took: an
output of twelve stances, eleven of which were fitted, had no scatter, and any step in it was sure.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from scipy.signal import lfilter

from footcal_cli.core.diagnosis.jumps import step_beside
from footcal_cli.core.inference.lines import Traces
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray

STANCES, ROWS, OUTPUTS = 24, 2, ("fx", "mx", "my")
LEVEL = 0.01


def standing(values: FloatArray) -> Problem:
    """Residuals of all outputs in stances one after the other, shape (STANCES, outputs)."""
    rng = np.random.default_rng(0)
    block = np.repeat(np.arange(STANCES), ROWS * len(OUTPUTS))
    output = np.tile(np.repeat(np.arange(len(OUTPUTS)), ROWS), STANCES)
    residual = np.repeat(values.ravel(), ROWS) + 0.01 * rng.standard_normal(block.size)
    return Problem(
        residual=residual,
        calibration=np.empty((residual.size, 0)),
        columns=np.empty((residual.size, 0)),
        signatures=(),
        block=block,
        output=output,
        sequence=block * len(OUTPUTS) + output,
        outputs=OUTPUTS,
        units=("N", "Nm", "Nm"),
        noise=np.ones(residual.size),
        tolerance=np.ones(len(OUTPUTS)),
        pieces=True,
        traces=Traces(np.asarray(8.0 * block, dtype=np.float64), output, OUTPUTS),
    )


def fitted(problem: Problem, of_my: int, seed: int) -> FloatArray:
    """Columns of one number per stance: a constant of each output, and `of_my` for the last."""
    rng = np.random.default_rng(seed)
    own = np.eye(len(OUTPUTS))[problem.output]
    more = rng.standard_normal((STANCES, of_my))[problem.block] * own[:, [-1]]
    return np.column_stack([own, more])


def p_of(seed: int, of_my: int, alike: float = 0.0, step: float = 0.0) -> float:
    rng = np.random.default_rng(seed)
    values = lfilter(
        [np.sqrt(1 - alike**2)], [1.0, -alike], rng.standard_normal((STANCES, 3)), axis=0
    )
    values[STANCES // 2 :, 1] += step
    problem = standing(values)
    return step_beside(problem, fitted(problem, of_my, seed)).p


@pytest.mark.parametrize(("of_my", "alike"), [(0, 0.0), (12, 0.0), (21, 0.0), (0, 0.45)])
def test_what_is_fitted_or_goes_on_is_no_step(of_my: int, alike: float) -> None:
    p = np.array([p_of(seed, of_my, alike) for seed in range(150)])
    assert np.sum(p < LEVEL) <= stats.binom.ppf(0.999, p.size, LEVEL if alike == 0.0 else 4 * LEVEL)


@pytest.mark.parametrize("of_my", [0, 21])
def test_a_step_of_many_times_the_scatter_is_seen(of_my: int) -> None:
    assert max(p_of(seed, of_my, step=8.0) for seed in range(20)) < LEVEL
