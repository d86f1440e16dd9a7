import numpy as np
import pytest

from footcal_cli.core.online.evidence import (
    bootstrap_mean,
    bootstrap_ratio,
    paired_p,
)
from footcal_cli.core.online.judged import squares, squares_per_cycle


def test_squares_count_finite_errors_and_those_of_parts_add_up() -> None:
    errors = np.array([3.0, 4.0, np.nan, 1.0, np.nan, 7.0])
    cycle = np.array([0, 0, 0, 1, 1, -1])
    found = squares_per_cycle(errors, cycle)
    np.testing.assert_allclose(found.rms, [np.sqrt(12.5), 1.0])
    vectors = np.stack([errors, errors], axis=1)
    np.testing.assert_allclose(squares_per_cycle(vectors, cycle).rms, found.rms * np.sqrt(2))
    assert squares(np.array([[3.0, 4.0], [np.nan, 1.0]])).rms == 5.0
    assert np.isnan(squares_per_cycle(errors, np.array([0, 0, 0, 2, 2, 2])).rms[1])
    assert (squares(errors[:2]) + squares(errors[2:])).rms == squares(errors).rms
    first = squares_per_cycle(errors[:1], cycle[:1]).widened(2)
    np.testing.assert_allclose((first + squares_per_cycle(errors[1:], cycle[1:])).rms, found.rms)


def test_resamples_of_a_long_walk_are_those_of_one_draw() -> None:
    values = np.random.default_rng(2).gamma(4.0, 0.25, 1200)
    found = bootstrap_mean(values, np.random.default_rng(3))
    whole = values[np.random.default_rng(3).integers(0, 1200, (2000, 1200))].mean(axis=1)
    # SciPy interpolates between draws in another order than NumPy: the last digit may differ
    ends = pytest.approx(np.quantile(whole, [0.025, 0.975]), rel=1e-15)
    assert (found.low, found.high) == ends


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
