"""Two levels are told from noise of any colour, by a bound that noise keeps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from footcal_cli.core.diagnosis.telegraph import levels_p, switching_p
from footcal_cli.core.inference.lines import Traces
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray
from tests.core.test_diagnosis_spells import BLOCKS, ROWS, series, spells

DECAYS = {"white": 0.0, "ar90": 0.9, "ar98": 0.98}


def noise(rng: np.random.Generator, decay: float) -> FloatArray:
    """Stationary, of unit sd, shape (BLOCKS, ROWS)."""
    drive = rng.standard_normal((BLOCKS, ROWS + 300)) * np.sqrt(1.0 - decay**2)
    return np.asarray(lfilter([1.0], [1.0, -decay], drive, axis=1)[:, 300:])


def pushed(rng: np.random.Generator) -> FloatArray:
    pull = np.stack([spells(rng, ROWS) for _ in range(BLOCKS)])
    return np.asarray(pull - pull.mean(axis=1, keepdims=True))


@pytest.mark.parametrize("draws", [10, pytest.param(25, marks=pytest.mark.slow)])
@pytest.mark.parametrize("family", DECAYS)
def test_noise_keeps_the_bound(family: str, draws: int) -> None:
    rng = np.random.default_rng(1)
    p = np.array([switching_p(list(noise(rng, DECAYS[family]))) for _ in range(draws)])
    assert np.all(p > 0.05)  # P(p < α) ≤ α


@pytest.mark.parametrize("family", ["ar90", "ar98"])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_pushes_of_their_noise_are_seen_in_noise_of_their_colour(family: str, sign: float) -> None:
    rng = np.random.default_rng(2)
    shown = noise(rng, DECAYS[family]) + sign * 1.8 * pushed(rng)
    assert switching_p(list(shown)) < 1e-4


@pytest.mark.parametrize("seed", [6, 7, 8])
def test_pushes_of_several_strengths_are_seen_in_white_noise(seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert switching_p(list(noise(rng, 0.0) + 1.5 * pushed(rng))) < 1e-4


@pytest.mark.parametrize(("family", "step"), [("white", 1.0), ("ar90", 0.5), ("ar98", 0.22)])
def test_pushes_are_seen_by_a_converter_of_one_step_of_noise(family: str, step: float) -> None:
    rng = np.random.default_rng(9)
    quiet = noise(rng, DECAYS[family])
    for shown, seen in ((quiet, False), (quiet + 1.8 * pushed(rng), True)):
        traced = _traced(step * np.round(shown / step))
        assert 0.2 < np.mean(np.diff(traced.residual) == 0.0) < 0.4
        p = levels_p(traced, traced.residual)
        assert p < 1e-4 if seen else p > 0.05


def test_noise_of_the_spectrum_of_spells_is_not_taken_for_them() -> None:
    """The same power at every frequency, with random phases: normal, without levels."""
    rng = np.random.default_rng(3)
    shown = noise(rng, 0.9) + 1.8 * pushed(rng)
    power = np.abs(np.fft.rfft(shown, axis=1))
    turned = power * np.exp(2j * np.pi * rng.random(power.shape))
    other = np.fft.irfft(turned, ROWS, axis=1)
    assert switching_p(list(shown)) < 1e-4
    assert switching_p(list(other)) > 0.05


def test_a_reading_that_stands_shows_its_converter_and_no_push() -> None:
    rng = np.random.default_rng(4)
    slow = noise(rng, 0.98)
    coarse = series(np.round(slow))
    assert levels_p(coarse, coarse.residual) == 1.0  # without channels nothing is said
    traced = _traced(np.round(slow))
    assert levels_p(traced, traced.residual) == 1.0
    # nor does one that a model moves a little from row to row
    moved = _traced(np.round(slow) + 1e-3 * np.sin(np.arange(slow.shape[1])))
    assert levels_p(moved, moved.residual) == 1.0
    seen = _traced(slow + 1.8 * pushed(rng))
    assert levels_p(seen, seen.residual) < 1e-4


def _traced(values: FloatArray) -> Problem:
    """The same as rows of one cell."""
    problem = series(values)
    time_s = np.arange(problem.residual.size, dtype=float)
    channel = np.zeros(problem.residual.size, dtype=np.int64)
    return replace(problem, traces=Traces(time_s, channel, ("cell",)))
