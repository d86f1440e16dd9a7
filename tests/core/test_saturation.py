"""Samples at the end of a sensor's range, against signals that were cut on purpose."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.saturation import find_saturated

N = 2000


def turning(seed: int, noise: float = 0.02) -> FloatArray:
    """A leg that turns four times, N."""
    wave = 5.0 * np.sin(np.linspace(0.0, 8.0 * np.pi, N))
    return np.asarray(wave + noise * np.random.default_rng(seed).normal(size=N))


@pytest.mark.parametrize("step", [0.0, 0.05])
@pytest.mark.parametrize("limit", [2.5, 4.0])
def test_a_transducer_that_is_cut_is_found_at_exactly_those_samples(
    step: float, limit: float
) -> None:
    wave = turning(1)
    wave = np.round(wave / step) * step if step else wave
    cut = np.clip(wave, -10.0, limit)
    found = find_saturated("fx_n", cut, 24, in_time=True)
    top = cut == cut.max()
    if top.mean() > 0.2:
        assert not found.any()
    else:
        np.testing.assert_array_equal(found, top)
    assert not find_saturated("fx_n", wave, 24, in_time=True).any()


@pytest.mark.parametrize("noise", [0.0, 0.02, 0.3])
@pytest.mark.parametrize("step", [1e-6, 0.02, 0.2])
def test_a_range_that_suffices_loses_no_sample(noise: float, step: float) -> None:
    for seed in range(20):
        wave = np.round(turning(seed, noise) / step) * step
        assert not find_saturated("tx_nm", wave, 24, in_time=True).any()


def test_a_foot_in_the_air_is_not_saturated() -> None:
    load = np.maximum(turning(2), 0.0)  # a plate that shows no load below its threshold
    assert not find_saturated("left_fz_n", load, 24, in_time=True).any()
    codes = np.clip(np.round(512.0 + 80.0 * turning(3)), 0, 1023)
    clipped = find_saturated("left_fl_counts", np.maximum(codes - 500.0, 0.0), 10, in_time=True)
    assert not clipped.any()


def test_a_cell_at_its_end_code_and_an_impact_that_is_cut_are_found() -> None:
    codes = np.clip(np.round(400.0 + 130.0 * turning(4)), 0, 1023)
    found = find_saturated("left_fl_counts", codes, 10, in_time=True)
    np.testing.assert_array_equal(found, codes == 1023)
    acc = np.random.default_rng(5).normal(size=N)
    acc[::60] += 40.0
    cut = np.clip(acc, -19.6, 19.6)
    np.testing.assert_array_equal(
        find_saturated("imu_acc_z_mps2", cut, 24, in_time=True), cut == 19.6
    )
