"""Block-aware regression and grouped choice: coverage, closed forms, rules that can break."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.inference.blocks import correlation_time, fit_blocks, whiten_autoregressive
from footcal_cli.core.inference.held_out import HeldOut, choose, folds, hold_out
from footcal_cli.core.parameters import FloatArray


def test_one_block_is_ordinary_least_squares() -> None:
    rng = np.random.default_rng(0)
    x, y = rng.normal(size=(40, 3)), rng.normal(size=40)
    fit = fit_blocks(x, y, np.zeros(40, dtype=np.int64))
    beta, rss, *_ = np.linalg.lstsq(x, y, rcond=None)
    np.testing.assert_allclose(fit.coefficients, beta, rtol=1e-10)
    np.testing.assert_allclose(fit.covariance, rss[0] / 37 * np.linalg.inv(x.T @ x), rtol=1e-9)
    assert fit.dof.tolist() == [37.0] * 3


@pytest.mark.parametrize(
    ("sessions", "sd_between"),
    [
        (4, 0.3),
        pytest.param(6, 0.3, marks=pytest.mark.slow),
        pytest.param(6, 0.1, marks=pytest.mark.slow),
        (10, 0.05),
    ],
)
def test_intervals_cover_with_session_offsets(sessions: int, sd_between: float) -> None:
    rng = np.random.default_rng(sessions)
    session = np.repeat(np.arange(sessions), 15)
    load = np.tile(np.linspace(0.0, 1.0, 15), sessions)
    design = np.column_stack([load - 0.5, np.ones_like(load)])
    runs, hits = 600, np.zeros(2)
    for _ in range(runs):
        offset = sd_between * rng.normal(size=sessions)
        y = 2.0 * load + 1.0 + offset[session] + 0.1 * rng.normal(size=load.size)
        fit = fit_blocks(design, y, session)
        hits += np.abs(fit.coefficients - [2.0, 2.0]) < fit.half_width()
    # 95 % within the resolution of 600 runs (2 sd = 1.8 %), the slope and the offset alike
    assert np.all(hits / runs > 0.925)
    assert np.all(hits / runs < 0.98)


def test_rows_treated_as_independent_would_not_cover() -> None:
    rng = np.random.default_rng(1)
    session = np.repeat(np.arange(5), 30)
    hits = 0
    for _ in range(300):
        y = 0.3 * rng.normal(size=5)[session] + 0.1 * rng.normal(size=150)
        fit = fit_blocks(np.ones((150, 1)), y, np.zeros(150, dtype=np.int64))
        hits += int(np.abs(fit.coefficients[0]) < fit.half_width()[0])
    assert hits / 300 < 0.5


def test_noise_that_persists_is_whitened() -> None:
    rng = np.random.default_rng(2)
    time = np.arange(0.0, 150.0, 0.5)
    block = np.zeros(300, dtype=np.int64)
    design = np.column_stack([np.sin(time / 7.0), np.ones(300)])
    hits, lengths, runs = np.zeros(2), [], 300
    for _ in range(runs):
        noise = np.empty(300)
        noise[0] = rng.normal()
        for i in range(1, 300):
            noise[i] = 0.7 * noise[i - 1] + np.sqrt(1 - 0.49) * rng.normal()
        y: FloatArray = design @ [1.0, 2.0] + noise
        rest: FloatArray = y - design @ np.linalg.lstsq(design, y, rcond=None)[0]
        lengths.append(correlation_time(rest, time, block))
        fit = fit_blocks(*whiten_autoregressive(design, y, time, block, lengths[-1]), block)
        hits += np.abs(fit.coefficients - [1.0, 2.0]) < fit.half_width()
    assert np.mean(lengths) == pytest.approx(-0.5 / np.log(0.7), rel=0.1)
    assert np.all(np.abs(hits / runs - 0.95) < 0.035)


def test_independent_noise_is_left_alone() -> None:
    rng = np.random.default_rng(3)
    block = np.zeros(400, dtype=np.int64)
    found = [correlation_time(rng.normal(size=400), np.arange(400.0), block) for _ in range(50)]
    assert np.mean(np.array(found) == 0.0) > 0.9


def test_a_design_short_of_rank_says_so() -> None:
    x = np.column_stack([np.arange(12.0), 2 * np.arange(12.0), np.ones(12)])
    fit = fit_blocks(x, np.arange(12.0), np.repeat([0, 1], 6))
    assert fit.rank == 2
    np.testing.assert_allclose(x @ fit.coefficients, np.arange(12.0), atol=1e-6)


def test_groups_are_never_split() -> None:
    group = np.array([3, 3, 1, 1, 2, 7, 7, 7])
    masks = list(folds(group, most=3))
    assert np.sum(masks, axis=0).tolist() == [1] * 8
    for mask in masks:
        assert not set(group[mask]) & set(group[~mask])


def test_held_out_rows_are_predicted_without_them() -> None:
    truth = np.array([1.0, 1.0, 5.0, 5.0])
    group = np.array([0, 0, 1, 1])
    out = hold_out(lambda mask: np.full(4, truth[~mask].mean()), truth, group)
    np.testing.assert_allclose(out.error, [4.0, 4.0, -4.0, -4.0])


def test_the_simpler_model_wins_ties_and_loses_when_it_is_worse() -> None:
    rng = np.random.default_rng(4)
    group = np.repeat(np.arange(20), 5)
    base = rng.normal(size=100)
    same = [HeldOut(base, group), HeldOut(base * 1.0, group)]
    assert choose(same).chosen == 0
    slightly = [HeldOut(base, group), HeldOut(base + 0.05 * rng.normal(size=100), group)]
    assert choose(slightly).chosen == 0
    worse = [HeldOut(base + 1.0, group), HeldOut(base, group)]
    assert choose(worse).chosen == 1


def test_a_gain_of_loads_that_are_nothing_is_none() -> None:
    rng = np.random.default_rng(5)
    block = np.repeat(np.arange(6), 8)
    shared = np.column_stack([np.ones(48), 1e-155 * rng.normal(size=48)])
    target = 2.0 + rng.normal(size=48) + rng.normal(size=6)[block]
    with np.errstate(all="raise", under="ignore"):
        found = fit_blocks(np.ones((48, 1)), target, block, shared)
    assert np.isfinite(found.sd_gain)
    alone = fit_blocks(np.ones((48, 1)), target, block)
    assert found.coefficients == pytest.approx(alone.coefficients, rel=1e-6)
