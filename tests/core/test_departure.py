"""How far a known calibration must move, and when one of two causes is surely likelier."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core.diagnosis.departure import Departure, departure_of
from footcal_cli.core.diagnosis.rivals import likelier, odds_of
from footcal_cli.core.inference.problem import Problem

ROWS, BLOCKS = 120, 12


def problem(bias: float, known_sd: float | None) -> Problem:
    """One output whose zero is off by a constant, in units of the noise."""
    rng = np.random.default_rng(5)
    block = np.repeat(np.arange(BLOCKS), ROWS // BLOCKS)
    load = rng.uniform(1.0, 2.0, ROWS)
    return Problem(
        residual=bias + rng.normal(size=ROWS),
        calibration=np.stack([np.ones(ROWS), load], axis=1),
        columns=np.empty((ROWS, 0)),
        signatures=(),
        block=block,
        output=np.zeros(ROWS, dtype=np.int64),
        sequence=block,
        outputs=("fz",),
        units=("N",),
        noise=np.ones(ROWS),
        tolerance=np.ones(1),
        known=None if known_sd is None else np.eye(2) / known_sd**2,
    )


def test_a_calibration_that_must_move_is_far_and_a_name_that_spares_it_is_sure() -> None:
    before = problem(1.0, 0.05)
    after = before.holding(np.ones((ROWS, 1)))  # a cause that is free to be that constant
    found = departure_of(before, after, before.law, 1, 1.0)
    assert found is not None
    assert found.directions == 2
    # the closed form: θ = (XᵀX/s² + K)⁻¹ Xᵀr/s², D = θᵀKθ
    x, s = before.calibration, before.law.whitener.sd[0]
    theta = np.linalg.solve(x.T @ x / s**2 + before.known, x.T @ before.residual / s**2)
    assert found.before == pytest.approx(float(theta @ before.known @ theta), rel=0.2)
    assert found.before > stats.chi2.isf(1e-6, 2)
    assert found.after < 10.0


def test_its_p_is_that_of_the_f_distribution() -> None:
    known = Departure(before=40.0, after=26.0, directions=14, causes=1, among=1.0)
    assert known.p == pytest.approx(float(stats.f.sf(14.0 / 2.0, 1, 13)))
    # a stated sd is not taken to be too large: what is left counts for one at least
    small = Departure(before=15.0, after=1.0, directions=14, causes=1, among=1.0)
    assert small.p == pytest.approx(float(stats.f.sf(14.0, 1, 13)))
    assert Departure(9.0, 0.0, 1, 1, 1.0).p == 1.0
    # the best of many tests is as likely by chance as any one of them (Šidák)
    best = Departure(before=40.0, after=26.0, directions=14, causes=1, among=20.0)
    assert best.p == pytest.approx(1.0 - (1.0 - known.p) ** 20.0)
    # and no more than any direction of all that are known could be by chance (Scheffé)
    few = Departure(before=200.0, after=1.0, directions=6, causes=1, among=1e6)
    assert few.p == pytest.approx(float(stats.f.sf(199.0 / 6.0, 6, 5)))


def test_far_is_beyond_what_its_sd_allows() -> None:
    assert not Departure(100.0, 14.0, 14, 1, 1.0).far
    assert Departure(100.0, 40.0, 14, 1, 1.0).far


def test_nothing_known_tells_nothing() -> None:
    free = problem(1.0, None)
    assert departure_of(free, free, free.law, 1, 1.0) is None


def test_a_cause_is_out_at_given_odds_but_not_by_one_block() -> None:
    noise = problem(0.0, None).law
    best = np.full(BLOCKS, ROWS / BLOCKS)
    assert likelier(best, best + 10.0 / BLOCKS, noise, 0.01)  # exp(-5) < 0.01
    assert not likelier(best, best + 8.0 / BLOCKS, noise, 0.01)
    one = best.copy()
    one[0] += 50.0
    one[1:] -= 0.1
    assert not likelier(best, one, noise, 0.01)
    # four times the square that the law of noise expects: the same loss is worth a quarter
    assert not likelier(4.0 * best, 4.0 * best + 10.0 / BLOCKS, noise, 0.01)


def test_the_form_of_a_cause_bounds_how_sure_a_loss_is() -> None:
    noise, best = problem(0.0, None).law, np.full(BLOCKS, ROWS / BLOCKS)
    lost = 40.0 / BLOCKS * (1.0 + 0.1 * np.cos(np.arange(BLOCKS)))
    assert odds_of(best, best + lost, noise) < 1e-6
    assert odds_of(best, best + lost, noise, lost.sum()) == pytest.approx(0.01)
    assert odds_of(best, best + lost, noise, 4.0 * lost.sum()) == pytest.approx(0.01**0.25)
    back = odds_of(best + lost, best, noise, 4.0 * lost.sum())
    assert back == pytest.approx(0.01**-0.25)


def test_without_names_p_is_one_where_nothing_moves() -> None:
    before = problem(0.0, 0.05)
    found = departure_of(before, before, before.law, 1, 1.0)
    assert found is not None
    assert found.p == 1.0
