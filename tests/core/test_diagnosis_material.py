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


@pytest.mark.parametrize("size", [0.0, 0.7])
def test_of_single_poses_a_curve_repeats_as_large_as_it_is(size: float) -> None:
    """Too few poses for a function of all 30 forces, enough for a curve in the one they bend with.

    A standard normal force x gives ``size · (x² − 1)/√2`` that RMS.
    """
    found = []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        blocks, rows, forces = 24, 5, 30
        n = blocks * rows
        force = {f"force along {i}": rng.normal(size=n) for i in range(forces)}
        bent = (force["force along 7"] ** 2 - 1.0) / np.sqrt(2.0)
        problem = Problem(
            residual=size * bent + 0.7 * rng.normal(size=n),
            calibration=np.ones((n, 1)),
            columns=np.empty((n, 0)), signatures=(),
            block=np.repeat(np.arange(blocks), rows), output=np.zeros(n, dtype=np.int64),
            sequence=np.arange(n), outputs=("fz",), units=("N",), noise=np.ones(n),
            tolerance=np.array([0.1]), regressors=force,
        )  # fmt: skip
        features = features_of(problem)
        assert repeating(problem, features)[0] == 0.0
        found.append(float(repeating(problem, features, "force along 7")[0]))
    assert np.sqrt(np.mean(found)) == pytest.approx(size, abs=0.15 if size else 0.2)
