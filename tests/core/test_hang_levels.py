"""Levels of holds that drift together: how long they last, and intervals that allow for it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from footcal_cli.core.hang.intake import hang_log
from footcal_cli.core.hang.joint import HangOptions, fit_hang
from footcal_cli.core.inference.levels import kernel, lasting_levels, whitening
from footcal_cli.core.parameters import FloatArray

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
SD = np.array([0.05] * 3 + [0.003] * 3)


def slow(rng: np.random.Generator, rows: int, columns: int, memory: float) -> FloatArray:
    """Stationary noise of sd one that decays by e within so many rows."""
    decay = np.exp(-1.0 / memory)
    drive = rng.normal(size=(rows, columns)) * np.sqrt(1.0 - decay**2)
    return np.asarray(
        lfilter([1.0], [1.0, -decay], drive, axis=0, zi=decay * rng.normal(size=(1, columns)))[0]
    )


def offsets_off(seed: int, memory_s: float, hold_s: float) -> FloatArray:
    """Error over stated sd of the six offsets of a tool held in 18 attitudes."""
    rng, hz, holds = np.random.default_rng([seed, 5]), 50.0, 18
    rows, gap = round(hold_s * hz), round(2.0 * hz)
    aims = Rotation.random(holds, random_state=seed)
    mount = Rotation.from_rotvec(rng.normal(0.0, 0.004, 3))
    nominal = aims.inv().apply([0.0, 0.0, -1.0])
    force = 10.0 * (aims * mount).inv().apply([0.0, 0.0, -1.0])
    wrench = np.hstack([force, np.cross([0.005, -0.004, 0.06], force)])
    offset = rng.normal(size=6) * np.array([4.0] * 3 + [0.3] * 3)
    whole = holds * (rows + gap)
    kept = np.arange(whole) % (rows + gap) < rows
    noise = np.sqrt(0.5) * (rng.normal(size=(whole, 6)) + slow(rng, whole, 6, memory_s * hz))
    shown = np.repeat(wrench, rows, axis=0) + offset + SD * noise[kept]
    time_s = (np.arange(whole) / hz)[kept]
    log = hang_log("ft", time_s, np.zeros(len(shown)), shown, np.repeat(nominal, rows, axis=0),
                   leg_weight_n=10.0)  # fmt: skip
    found = fit_hang([log], HangOptions(tilt="mount")).estimates
    at = [found.names.index(f"ft.offset_{axis}") for axis in AXES]
    return np.asarray((found.values[at] - offset) / found.sd[at])


@pytest.mark.parametrize(
    ("memory_s", "hold_s"),
    [pytest.param(5.0, 6.0, marks=pytest.mark.slow), (20.0, 6.0), (1.0, 4.0)],
)
def test_offsets_err_as_stated_where_noise_lasts_from_hold_to_hold(
    memory_s: float, hold_s: float
) -> None:
    off = np.array([offsets_off(seed, memory_s, hold_s) for seed in range(25)])
    # holds that count as independent: 1.25 for noise of 5 s, 2.3 for noise of 20 s
    assert 0.8 < np.sqrt(np.mean(off**2)) < 1.25
    assert np.mean(np.abs(off) < 1.96) > 0.9


def test_whitened_levels_have_the_identity_as_covariance() -> None:
    time_s = np.array([0.0, 1.0, 3.0, 4.0])
    size = np.array([1.0, 2.0, 0.0, 3.0])
    covariance = 0.25 * kernel(time_s, 2.0)
    inverse = whitening(size, covariance)
    whole = np.eye(4) + size[:, None] * covariance * size
    np.testing.assert_allclose(inverse @ whole @ inverse.T, np.eye(4), atol=1e-12)
    np.testing.assert_array_equal(kernel(time_s, 0.0), np.eye(4))


@pytest.mark.parametrize("memory_s", [0.0, 30.0])
def test_sd_and_memory_of_levels_are_those_that_made_them(memory_s: float) -> None:
    """Sixty levels 8 s apart, three channels, of sd 0.5 under noise of 0.1, about their means."""
    time_s: FloatArray = 8.0 * np.arange(60.0)
    found = []
    size = np.full((60, 3), 10.0)
    slope = np.zeros((60, 3, 3))
    slope[:, range(3), range(3)] = 10.0
    for seed in range(20):
        rng = np.random.default_rng([seed, 9])
        level = slow(rng, 60, 3, memory_s / 8.0) if memory_s else rng.normal(size=(60, 3))
        error = 10.0 * (3.0 + 0.5 * level) + rng.normal(size=(60, 3))
        law = lasting_levels(time_s, error, slope, size)
        assert law is not None
        found.append([law.sd, np.exp(-8.0 / law.memory_s) if law.memory_s else 0.0])
    sd, decay = np.median(found, axis=0)
    assert sd == pytest.approx(0.5, rel=0.1)
    assert decay == pytest.approx(np.exp(-8.0 / memory_s) if memory_s else 0.0, abs=0.15)


def test_few_records_and_clocks_that_restart_show_no_memory() -> None:
    rng = np.random.default_rng(3)
    error, slope = rng.normal(size=(8, 3)), np.zeros((8, 3, 1))
    size = np.ones((8, 3))
    assert lasting_levels(np.arange(4.0), error[:4], slope[:4], size[:4]) is None
    assert lasting_levels(np.arange(8.0) % 4.0, error, slope, size) is None
    assert lasting_levels(np.arange(8.0), error, slope, size) is not None
