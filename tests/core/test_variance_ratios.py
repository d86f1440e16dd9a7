"""Variance ratios by REML: the dense likelihood, finite differences, a search without them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from footcal_cli.core.inference.variance_ratios import (
    LOG_RATIO_RANGE,
    BlockSums,
    Restricted,
    reml_ratios,
)
from footcal_cli.core.parameters import FloatArray, IntArray


def sums_of(x: FloatArray, y: FloatArray, z: FloatArray, block: IntArray) -> BlockSums:
    """Sums block by block, by loops; the target less its ordinary least squares."""
    both = np.column_stack([x, y - x @ np.linalg.lstsq(x, y, rcond=None)[0]])
    parts = [(z[block == k], both[block == k]) for k in np.unique(block)]
    return BlockSums(
        np.array([own.T @ own for own, _ in parts]),
        np.array([own.T @ rows for own, rows in parts]),
        both.T @ both,
    )


def sessions(
    seed: int, sd_between: float, sd_gain: float, blocks: int = 5, q: int = 2
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """X, y, Z and the session of readings of a cell that is re-seated; a session's noise is 1."""
    rng = np.random.default_rng(seed)
    block = np.repeat(np.arange(blocks), rng.integers(8, 20, size=blocks))
    load = rng.uniform(0.0, 1.0, size=block.size)
    x = np.column_stack([load, np.ones_like(load), rng.normal(size=load.size)])
    shift, gain = rng.normal(size=(2, blocks))
    y = x @ [40.0, -7.0, 0.3] + rng.normal(size=load.size)
    y += sd_between * shift[block] + sd_gain * gain[block] * load
    return (
        x,
        y,
        np.column_stack([np.ones_like(load), load / np.sqrt(np.mean(load**2))])[:, :q],
        block,
    )


CASES = [
    pytest.param(seed, between, gain, q, marks=[pytest.mark.slow] * (seed > 1))
    for seed in range(12)
    for between, gain, q in (
        (0.0, 0.0, 2), (0.5, 0.0, 2), (0.0, 5.0, 2), (3.0, 1.0, 2), (300.0, 30.0, 2),
        (0.0, 0.0, 1), (1.0, 0.0, 1), (1000.0, 0.0, 1),
    )
]  # fmt: skip


def dense(
    x: FloatArray, y: FloatArray, z: FloatArray, block: IntArray, log_ratio: FloatArray
) -> float:
    """The restricted deviance by matrices of all rows, and the weight of the boundary."""
    n, p = x.shape
    same = block[:, None] == block
    v = np.eye(n) + same * ((z * np.exp(log_ratio)) @ z.T)
    inverse = np.linalg.inv(v)
    normal = x.T @ inverse @ x
    rest = y - x @ np.linalg.solve(normal, x.T @ inverse @ y)
    log_det = np.linalg.slogdet(v)[1] + np.linalg.slogdet(normal)[1]
    deviance = (n - p) * np.log(rest @ inverse @ rest) + log_det
    return float(deviance - 0.5 * np.sum(log_ratio))


@pytest.mark.parametrize("q", [1, 2])
def test_the_cost_is_the_restricted_deviance(q: int) -> None:
    x, y, z, block = sessions(1, 2.0, 3.0, q=q)
    sums = sums_of(x, y, z, block)
    for log_ratio in np.random.default_rng(2).uniform(-6.0, 6.0, size=(20, q)):
        found = Restricted(sums, len(y) - 3, log_ratio).cost
        assert found == pytest.approx(dense(x, y, z, block, log_ratio), abs=1e-7)


@pytest.mark.parametrize("q", [1, 2])
def test_derivatives_are_those_of_finite_differences(q: int) -> None:
    x, y, z, block = sessions(3, 2.0, 3.0, q=q)
    sums, step = sums_of(x, y, z, block), 1e-4
    for log_ratio in np.random.default_rng(4).uniform(-5.0, 5.0, size=(20, q)):
        here = Restricted(sums, len(y) - 3, log_ratio)
        moved = [
            [Restricted(sums, len(y) - 3, log_ratio + sign * e) for sign in (1.0, -1.0)]
            for e in step * np.eye(q)
        ]
        slopes = [(up.cost - down.cost) / (2.0 * step) for up, down in moved]
        np.testing.assert_allclose(here.slope, slopes, rtol=1e-5, atol=1e-6)
        bends = [(up.slope - down.slope) / (2.0 * step) for up, down in moved]
        np.testing.assert_allclose(here.curvature, bends, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(("seed", "between", "gain", "q"), CASES)
def test_no_search_without_slopes_finds_a_better_optimum(
    seed: int, between: float, gain: float, q: int
) -> None:
    x, y, z, block = sessions(seed, between, gain, q=q)
    sums = sums_of(x, y, z, block)

    def cost(log_ratio: FloatArray) -> float:
        return Restricted(sums, len(y) - 3, np.clip(log_ratio, *LOG_RATIO_RANGE)).cost

    found = np.log(reml_ratios(sums, len(y), 3))
    starts = [found, np.full(q, -4.0), np.full(q, 4.0)]
    best = min(
        (minimize(cost, start, method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-11})
         for start in starts),
        key=lambda one: float(one.fun),
    )  # fmt: skip
    assert cost(found) < best.fun + 1e-7
    np.testing.assert_allclose(found, np.clip(best.x, *LOG_RATIO_RANGE), atol=2e-3)


def test_sessions_that_differ_by_nothing_but_rounding_end_at_a_bound_or_within() -> None:
    """Rows without noise: the likelihood has no maximum, the search still ends in its range."""
    x, _, z, block = sessions(5, 0.0, 0.0)
    y = x @ [40.0, -7.0, 0.3] + np.arange(5.0)[block]
    found = np.log(reml_ratios(sums_of(x, y, z, block), len(y), 3))
    assert np.all((found >= LOG_RATIO_RANGE[0]) & (found <= LOG_RATIO_RANGE[1]))
    assert found[0] > 5.0  # what there is lies between the sessions


def test_a_column_twice_changes_no_ratio() -> None:
    x, y, z, block = sessions(6, 2.0, 3.0)
    plain = reml_ratios(sums_of(x, y, z, block), len(y), 3)
    twice = np.column_stack([x, x[:, 0]])
    # n − p counts the columns of X, of which one is no degree of freedom
    found = reml_ratios(sums_of(twice, y, z, block), len(y) + 1, 4)
    np.testing.assert_allclose(found, plain, rtol=1e-5)
