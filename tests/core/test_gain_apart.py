"""A scale that a stand moves away from those of the other cells: by chance, and with a cause."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.checks.gain_apart import check_gain_apart
from footcal_cli.core.parameters import FloatArray

CELLS = tuple(f"left_{i}" for i in range(4)) + tuple(f"right_{i}" for i in range(4))
PRIOR_SD, DRAWS = 0.02, 400


def fitted(rng: np.random.Generator, truth: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Gains and their covariance from fifteen sums over loads, with the prior."""
    load = rng.uniform(0.0, 1.0, (15, truth.size))
    noise = 0.008
    information = load.T @ load / noise**2 + np.eye(truth.size) / PRIOR_SD**2
    covariance: FloatArray = np.asarray(np.linalg.inv(information))
    seen = load @ truth + noise * rng.standard_normal(15)
    return covariance @ (load.T @ seen) / noise**2, np.asarray(covariance)


def found_in(rng: np.random.Generator, truth: FloatArray) -> list[str]:
    gain, covariance = fitted(rng, truth)
    prior = PRIOR_SD**2 * np.eye(truth.size)
    return [f.where for f in check_gain_apart(CELLS, gain, covariance, prior)]


def test_gains_that_are_as_unsure_as_stated_are_rarely_apart() -> None:
    rng = np.random.default_rng(7)
    said = sum(bool(found_in(rng, PRIOR_SD * rng.standard_normal(8))) for _ in range(DRAWS))
    assert said <= 10  # 4 expected at one in a hundred


def test_an_error_of_all_scales_alike_is_no_cell_apart() -> None:
    rng = np.random.default_rng(8)
    assert sum(bool(found_in(rng, np.full(8, 0.06))) for _ in range(DRAWS)) <= 2


def test_a_cell_that_lost_a_tenth_is_found_by_its_name() -> None:
    rng = np.random.default_rng(9)
    truth = np.zeros(8)
    truth[5] = -0.1
    found = [found_in(rng, truth) for _ in range(DRAWS)]
    assert sum(one == [CELLS[5]] for one in found) > 0.9 * DRAWS
    assert not any(one and one != [CELLS[5]] for one in found)
