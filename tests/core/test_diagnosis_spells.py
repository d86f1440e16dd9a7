"""Spells of a tugged cable are seen; noise of any colour is not taken for them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from footcal_cli.core.diagnosis.spells import spell_p
from footcal_cli.core.inference.evidence import local_max_t, sign_patterns
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray, IntArray

BLOCKS, ROWS = 24, 100
PLACEMENTS = 120


def series(residual: FloatArray) -> Problem:
    """Blocks of one output at 1 Hz, each with an offset; residual (BLOCKS, ROWS)."""
    block = np.repeat(np.arange(BLOCKS), ROWS)
    return _problem(residual.ravel(), block, np.zeros(block.size, dtype=np.int64), 1.0)


def placed(residual: FloatArray) -> Problem:
    """Placements one after the other, three outputs each; residual (PLACEMENTS, 3)."""
    count = residual.shape[0]
    block, output = np.repeat(np.arange(count), 3), np.tile(np.arange(3), count)
    return _problem(residual.ravel(), block, output, 0.0)


def _problem(residual: FloatArray, block: IntArray, output: IntArray, rate_hz: float) -> Problem:
    outputs = tuple(f"output {i}" for i in range(int(output.max()) + 1))
    pairs = np.stack([block, output])
    _, sequence = np.unique(pairs, axis=1, return_inverse=True)
    return Problem(
        residual=residual,
        calibration=np.ones((residual.size, 1)),
        columns=np.empty((residual.size, 0)),
        signatures=(),
        block=block,
        output=output,
        sequence=sequence.ravel(),
        outputs=outputs,
        units=("N",) * len(outputs),
        noise=np.ones(residual.size),
        tolerance=np.full(len(outputs), 0.1),
        regressors={} if rate_hz else {"order of recording": block.astype(float)},
        rate_hz=rate_hz,
    )


def noises(rng: np.random.Generator, family: str) -> FloatArray:
    white = rng.standard_normal((BLOCKS, ROWS))
    if family == "ar98":
        return np.asarray(lfilter([1.0], [1.0, -0.98], white, axis=1))
    if family == "growing":
        return white * np.linspace(0.2, 2.0, ROWS)
    return np.round(white) if family == "quantised" else white


def spells(rng: np.random.Generator, rows: int) -> FloatArray:
    """One-sided pulls of random length, from scratch."""
    out, at = np.zeros(rows), 0
    while at < rows:
        at += int(rng.integers(3, 33))
        length = int(rng.integers(2, 20))
        out[at : at + length] = rng.uniform(0.5, 1.5)
        at += length
    return out


@pytest.mark.parametrize("family", ["white", "ar98", "growing", "quantised"])
def test_noise_is_not_taken_for_spells(family: str) -> None:
    rng = np.random.default_rng(1)
    signs = sign_patterns(BLOCKS, 0)[:2000]
    p = np.array([spell_p(series(noises(rng, family)), signs, None) for _ in range(60)])
    assert np.mean(p < 0.05) < 0.15  # 3 of 60 expected; 9 has a chance of 0.1 %
    assert np.mean(p < 0.5) > 0.25


def test_a_tugged_cable_is_seen_in_series() -> None:
    rng = np.random.default_rng(2)
    signs = sign_patterns(BLOCKS, 0)[:2000]
    tug = np.stack([spells(rng, ROWS) for _ in range(BLOCKS)])
    for sign in (1.0, -1.0):
        noise = noises(rng, "white")
        assert spell_p(series(noise + sign * 2.0 * tug), signs, None) <= 1e-3


@pytest.mark.parametrize("draws", [24, pytest.param(100, marks=pytest.mark.slow)])
def test_neighbouring_placements_are_alike_under_a_tug_and_not_without(draws: int) -> None:
    rng = np.random.default_rng(3)
    signs = sign_patterns(10)
    p = [spell_p(placed(rng.standard_normal((PLACEMENTS, 3))), signs, None) for _ in range(draws)]
    assert np.mean(np.array(p) < 0.05) < 0.13
    tug = spells(rng, PLACEMENTS)[:, None] * [2.0, 0.5, 0.5]
    assert spell_p(placed(rng.standard_normal((PLACEMENTS, 3)) + tug), signs, None) < 1e-3


@pytest.mark.parametrize(
    ("draws", "tugged"), [(24, 6), pytest.param(60, 12, marks=pytest.mark.slow)]
)
def test_what_is_fitted_to_placements_does_not_hide_that_neighbours_are_alike(
    draws: int, tugged: int
) -> None:
    """Offsets of every round and of each place of many make neighbours unlike, whatever is off."""
    rng = np.random.default_rng(5)
    signs = sign_patterns(10)
    order = np.repeat(np.arange(PLACEMENTS), 3)
    known = np.hstack([np.eye(10)[order // 12], rng.standard_normal((3 * PLACEMENTS, 30))])

    def p_of(error: FloatArray) -> float:
        return spell_p(replace(placed(error), calibration=known), signs, None)

    noise = [rng.standard_normal((PLACEMENTS, 3)) for _ in range(draws)]
    p = np.array([p_of(error) for error in noise])
    assert np.mean(p < 0.05) < 0.13
    assert np.mean(p < 0.5) > 0.35
    tugs = [spells(rng, PLACEMENTS)[:, None] * [3.0, 1.0, 1.0] for _ in range(tugged)]
    seen = [p_of(error + tug) < 2e-3 for error, tug in zip(noise, tugs, strict=False)]
    assert np.mean(seen) > 0.7


def test_one_place_of_many_is_judged_by_the_scatter_of_repeats() -> None:
    rng = np.random.default_rng(4)
    places, repeats = 18, 8
    block = np.arange(places * repeats)
    weight = np.where(block[:, None] % places == np.arange(places), 2.0, 0.0)

    def score(off: float) -> FloatArray:
        noise = 0.7 * rng.standard_normal((block.size, 1)) * np.sqrt(weight)
        return np.asarray(noise + weight * np.where(np.arange(places) == 5, off, 0.0))

    smallest = np.array([local_max_t(score(0.0), weight)[1].min() for _ in range(400)])
    assert 0.02 < np.mean(smallest < 0.05) < 0.08
    t, p = local_max_t(score(1.0), weight)
    assert int(np.argmax(t)) == 5
    assert p[5] < 1e-3
