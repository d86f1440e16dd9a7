"""Filters without `scipy.signal` give what it gives."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from scipy import signal

from footcal_cli.core import filters

RATE_HZ = 100.0


def walk(rows: int, *shape: int) -> np.ndarray:
    return np.cumsum(np.random.default_rng(rows).normal(size=(rows, *shape)), axis=0)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("cutoff_hz", [0.05, 5.0, 44.0])
def test_a_low_pass_is_scipys(order: int, cutoff_hz: float) -> None:
    mine = filters.butterworth(order, cutoff_hz, RATE_HZ)
    scipys = signal.butter(order, cutoff_hz, fs=RATE_HZ, output="sos")
    at_hz = np.linspace(0.0, 50.0, 200)
    _, expected = signal.freqz_sos(scipys, at_hz, fs=RATE_HZ)
    np.testing.assert_allclose(
        filters.response(mine, at_hz, RATE_HZ), np.abs(expected), rtol=1e-7, atol=1e-9
    )
    values = walk(400, 2, 3)
    start = signal.sosfilt_zi(scipys)[:, :, None, None] * values[:1]
    there, _ = signal.sosfilt(scipys, values, axis=0, zi=start)
    size = np.abs(values).max()
    np.testing.assert_allclose(filters.filtered(mine, values), there, atol=1e-9 * size)
    for padding in (None, 0, 1, 100, 399):
        both = signal.sosfiltfilt(scipys, values, axis=0, padlen=padding)
        np.testing.assert_allclose(
            filters.filtered_both_ways(mine, values, padding), both, atol=1e-8 * size
        )


@pytest.mark.parametrize("rows", [1, 2, 3, 50])
def test_a_recursion_goes_on_from_its_past(rows: int) -> None:
    values, before = walk(rows, 2), np.array([[0.3, -2.0]])
    expected, _ = signal.lfilter([0.2, 0.1], [1.0, -0.7], values, axis=0, zi=before)
    found = filters.recursion(values, (0.2, 0.1), (-0.7,), before)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_signal_that_is_too_short_is_refused() -> None:
    sections = filters.butterworth(4, 5.0, RATE_HZ)
    with pytest.raises(ValueError, match="cannot be continued"):
        filters.filtered_both_ways(sections, walk(15, 1))


@pytest.mark.parametrize(("window", "degree"), [(5, 2), (9, 4), (101, 4), (151, 2)])
@pytest.mark.parametrize("order", [1, 2])
def test_derivatives_of_local_polynomials_are_scipys(window: int, degree: int, order: int) -> None:
    values = walk(151, 2, 3)
    expected = signal.savgol_filter(values, window, degree, deriv=order, delta=0.02, axis=0)
    found = filters.polynomial_derivative(values, window, degree, order, 0.02)
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(("rows", "length"), [(300, 256), (1000, 256), (100, 100), (101, 101)])
def test_a_spectrum_is_welchs(rows: int, length: int) -> None:
    values = walk(rows, 3)
    at_hz, expected = signal.welch(values, RATE_HZ, nperseg=length, average="median", axis=0)
    frequency, found = filters.median_spectrum(values, RATE_HZ, length)
    np.testing.assert_allclose(frequency, at_hz, atol=1e-12)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12 * expected.max())


def test_no_module_of_the_product_brings_scipy_stats() -> None:
    """It takes a third of a second at the start of every command."""
    code = (
        "import pkgutil, sys, footcal_cli\n"
        "for m in pkgutil.walk_packages(footcal_cli.__path__, 'footcal_cli.'):\n"
        "    if not m.name.endswith('__main__'): __import__(m.name)\n"
        "assert 'scipy.stats' not in sys.modules and 'scipy.signal' not in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
