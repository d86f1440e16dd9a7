"""Noise that wanders for longer than an autoregression reaches."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from footcal_cli.core.inference.autoregression import ChannelNoise, fit_noise
from footcal_cli.core.parameters import FloatArray

ROWS, RATE_HZ = 6000, 100.0


def records(seed: int, memory_s: float, slow_sd: float) -> tuple[list[FloatArray], FloatArray]:
    """Four minutes of six channels, white of sd one and a slow part, less a leg's regressors."""
    rng = np.random.default_rng(seed)
    turn = 2.0 * np.pi * 3.0 * np.arange(ROWS) / ROWS
    waves = [f(k * turn) for k in (1, 2, 3) for f in (np.cos, np.sin)]
    z = np.column_stack([np.ones(ROWS), *waves])
    found = []
    for _ in range(4):
        noise = rng.normal(size=(ROWS, 6))
        if memory_s:
            phi = np.exp(-1.0 / (RATE_HZ * memory_s))
            drive = np.sqrt(1.0 - phi**2) * slow_sd * rng.normal(size=(ROWS + 4000, 6))
            noise += lfilter([1.0], [1.0, -phi], drive, axis=0)[4000:]
        found.append(noise - z @ np.linalg.lstsq(z, noise, rcond=None)[0])
    return found, z


@pytest.mark.parametrize(("memory_s", "slow_sd"), [(2.0, 0.5), (5.0, 0.5), (5.0, 1.0)])
def test_the_mean_of_a_record_is_as_uncertain_as_its_slow_noise_makes_it(
    memory_s: float, slow_sd: float
) -> None:
    """Spectrum at frequency zero: ``1 + s² (1 + φ)/(1 − φ)``; thirty lags show half."""
    phi = np.exp(-1.0 / (RATE_HZ * memory_s))
    true = 1.0 + slow_sd**2 * (1.0 + phi) / (1.0 - phi)
    ratios = []
    for seed in range(8):
        left, z = records(seed, memory_s, slow_sd)
        found = [c.samples_per_effective * c.sd**2 for c in fit_noise(left, [z] * 4)]
        ratios.append(np.sqrt(np.median(found) / true))
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("coefficient", [0.0, 0.6, 0.95])
def test_noise_that_the_lags_hold_has_no_slow_part(coefficient: float) -> None:
    rng = np.random.default_rng(1)
    z = np.ones((ROWS, 1))
    left = [lfilter([1.0], [1.0, -coefficient], rng.normal(size=(ROWS, 6)), axis=0) for _ in "abcd"]
    left = [part - part.mean(axis=0) for part in left]
    assert sum(bool(c.slow[0]) for c in fit_noise(left, [z] * 4)) <= 1


def test_innovations_are_those_of_the_dense_covariance() -> None:
    """``L⁻¹ x`` with ``L Lᵀ = σ² (I + v φ^|i−j|)``, past the row where the gain is steady too."""
    noise = ChannelNoise(np.empty(0), 0.5, 0.7, (0.8, 0.9))
    columns = np.random.default_rng(2).normal(size=(300, 2))
    covariance = 0.25 * (np.eye(300) + 0.8 * toeplitz(0.9 ** np.arange(300.0)))
    expected = np.linalg.solve(np.linalg.cholesky(covariance), columns)
    np.testing.assert_allclose(noise.whitened(columns), expected, atol=1e-7)
    assert noise.samples_per_effective == pytest.approx((0.5 / 0.7) ** 2 * (1.0 + 0.8 * 19.0))


@pytest.mark.parametrize("amplitude", [0.02, 0.05])
def test_what_changes_with_the_sense_of_turning_is_no_noise_without_bounds(
    amplitude: float,
) -> None:
    """Legs that turn there and back under a loop: what is left is no noise, and not endless."""
    seconds = 0.05 * np.arange(1280)
    phase = 2.0 * np.pi * (1.0 - np.abs(1.0 - seconds / 32.0))
    z = np.stack([np.ones(1280), np.sin(phase), np.cos(phase)], axis=1)
    for seed in range(6):
        rng = np.random.default_rng(seed)
        left = []
        for _ in range(4):
            loop = amplitude * np.sin(phase) * np.where(seconds < 32.0, 1.0, -1.0)
            shown = 0.01 * rng.normal(size=(1280, 6)) + np.outer(loop, rng.normal(size=6))
            left.append(shown - z @ np.linalg.lstsq(z, shown, rcond=None)[0])
        usual = float(np.std(np.concatenate(left), axis=0).max())
        assert max(c.sd for c in fit_noise(left, [z] * 4)) < 10.0 * usual
