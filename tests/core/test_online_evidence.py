import numpy as np
import pytest

from footcal_cli.core.online.evidence import (
    bootstrap_mean,
    bootstrap_ratio,
    paired_p,
    rms,
    rms_per_cycle,
)


def test_rms_per_cycle_counts_valid_samples_only() -> None:
    errors = np.array([3.0, 4.0, 100.0, 1.0, np.nan, 7.0])
    cycle = np.array([0, 0, 0, 1, 1, -1])
    valid = np.array([True, True, False, True, True, True])
    found = rms_per_cycle(errors, cycle, valid)
    np.testing.assert_allclose(found, [np.sqrt(12.5), 1.0])
    vectors = np.stack([errors, errors], axis=1)
    np.testing.assert_allclose(rms_per_cycle(vectors, cycle, valid), found * np.sqrt(2))
    assert rms(np.array([[3.0, 4.0], [np.nan, 1.0]])) == 5.0
    empty = rms_per_cycle(errors, np.array([0, 0, 0, 2, 2, 2]), valid)
    assert np.isnan(empty[1])


def test_bootstrap_intervals_cover_the_mean_as_often_as_they_say() -> None:
    rng = np.random.default_rng(0)
    hits = 0
    for _ in range(200):
        interval = bootstrap_mean(rng.gamma(4.0, 0.25, 40), rng, resamples=400)
        hits += interval.low <= 1.0 <= interval.high
    assert 0.88 < hits / 200 < 0.985


def test_the_ratio_is_of_rms_and_pairs_its_cycles() -> None:
    rng = np.random.default_rng(1)
    theirs = rng.uniform(1.0, 5.0, 60)
    ratio = bootstrap_ratio(0.5 * theirs, theirs, rng)
    # cycles vary fivefold, their ratio does not: pairing leaves no width
    assert ratio.value == pytest.approx(0.5)
    assert ratio.high - ratio.low < 1e-9
    assert ratio.n == 60


def test_the_paired_test_holds_its_level_and_sees_a_difference() -> None:
    rng = np.random.default_rng(2)
    null = [paired_p(rng.normal(size=30), rng.normal(size=30)) for _ in range(300)]
    assert np.mean(np.array(null) < 0.05) == pytest.approx(0.05, abs=0.035)
    base = rng.uniform(1.0, 2.0, 30)
    assert paired_p(0.9 * base, base) < 1e-5
    assert np.isnan(paired_p(base[:4], base[:4]))
