"""How much repeats without a name: known functions of a signal in noise that is correlated."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.diagnosis.features import features_of
from footcal_cli.core.diagnosis.material import MOST, Nameless, repeating
from footcal_cli.core.inference.problem import Problem

BLOCKS, ROWS = 14, 100


def _walk(size: float, seed: int) -> Problem:
    """One output with a sine of the gait phase of that RMS, and noise with a memory of ten rows."""
    rng = np.random.default_rng(seed)
    n = BLOCKS * ROWS
    phase = (np.arange(n) / 23.7) % 1.0
    noise = np.empty(n)
    noise[0] = rng.normal()
    for i in range(1, n):
        noise[i] = 0.9 * noise[i - 1] + np.sqrt(1.0 - 0.81) * rng.normal()
    block = np.repeat(np.arange(BLOCKS), ROWS)
    return Problem(
        residual=size * np.sqrt(2.0) * np.sin(2.0 * np.pi * phase) + noise,
        calibration=np.empty((n, 0)),
        columns=np.empty((n, 0)), signatures=(),
        block=block, output=np.zeros(n, dtype=np.int64), sequence=block,
        outputs=("fz",), units=("N",), noise=np.ones(n), tolerance=np.array([0.1]),
        regressors={"gait phase": phase}, rate_hz=20.0,
    )  # fmt: skip


@pytest.mark.parametrize("size", [0.0, 0.3, 0.6])
def test_what_repeats_is_measured_without_bias_in_correlated_noise(size: float) -> None:
    found = []
    for seed in range(12):
        problem = _walk(size, seed)
        found.append(float(repeating(problem, features_of(problem))[0]))
    # a product of two halves is cut at zero, which at nothing leaves half of its scatter
    assert np.mean(found) == pytest.approx(size**2, abs=0.03 + 0.06 * size)
    assert np.sqrt(np.mean(found)) < size + 0.2


def test_a_small_error_that_repeats_is_a_remark_and_a_large_one_a_finding() -> None:
    assert not Nameless("fz", "N", 0.1, 0.3, 0.0, 0.25).matters
    assert Nameless("fz", "N", 0.3, 0.4, 0.4, 0.25).matters
    assert Nameless("fz", "N", 0.0, MOST * 0.25, 0.0, 0.25).matters
    assert not Nameless("fz", "N", 0.0, 10 * 0.25, 10 * 0.25, 0.25).matters, "white noise"
