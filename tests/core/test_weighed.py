"""The robot on its own cells: closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.contact import judge
from footcal_cli.core.online.belief import nameplate
from footcal_cli.core.online.weighed import (
    Weighed,
    as_unsure_as_weighed,
    weighed_by_each_foot,
    weighed_standing,
    weighed_walking,
)
from footcal_cli.core.parameters import Status
from footcal_cli.core.quiet import QuietSet
from footcal_cli.core.stances import stance_rows, weight_of
from footcal_cli.core.static_init import fit_static
from tests.core.walk_data import make_standing
from tests.core.walking import belief_of, stand_log

CHANNELS = tuple(f"cell {i}" for i in range(8))


def test_scales_that_all_moved_alike_say_another_mass() -> None:
    belief = nameplate(CHANNELS, np.full(8, 1e-5), np.zeros(8), gain_sd=0.02)
    # cells are right and the robot is stated 7.5 % too heavy: every scale seems 7.5 % too small
    tiny = 1e-8 * np.eye(8)
    found = weighed_walking(belief, np.full(8, 0.075), tiny, 1.0, 5.3 * 1.075)
    assert found.mass_kg == pytest.approx(5.3, abs=1e-3)
    assert found.sd_kg == pytest.approx(5.3 * 0.02 / np.sqrt(8), rel=1e-3)
    assert found.findings()[0].code == "mass_differs"
    scattered = 0.03 * np.array([1, -1, 1, -1, 1, -1, 1, -1])
    assert not weighed_walking(belief, scattered, tiny, 1.0, 5.3).findings()


def test_what_a_walk_hardly_shows_is_weighed_by_its_own_say() -> None:
    belief = nameplate(CHANNELS, np.full(8, 1e-5), np.zeros(8), gain_sd=0.02)
    prior = 0.02**2 / 8
    own = 3.0 * prior
    # one measurement of the mean gain, of variance `own`, that says 4 %
    after = 1.0 / (1.0 / prior + 1.0 / own)
    covariance = np.full((8, 8), after)
    found = weighed_walking(belief, np.full(8, 0.04 * after / own), covariance, 1.0, 5.0)
    assert found.mass_kg == pytest.approx(5.0 / 1.04, rel=1e-6)
    assert found.sd_kg == pytest.approx(5.0 / 1.04 * np.sqrt(prior + own), rel=1e-6)


def test_errors_that_repeat_make_a_weight_unsure_and_no_other() -> None:
    """Covariances nine times as large say nothing of what the rows asked for."""
    belief = nameplate(CHANNELS, np.full(8, 1e-5), np.zeros(8), gain_sd=0.02)
    prior = 0.02**2 / 8
    after = 1.0 / (1.0 / prior + 3.0 / prior)
    asked = 0.01
    gain = np.full(8, asked * (1.0 - after / prior))
    found = weighed_walking(belief, gain, np.full((8, 8), 9.0 * after), 9.0, 5.0)
    assert found.mass_kg == pytest.approx(5.0 / (1.0 + asked), rel=1e-9)
    assert found.sd_kg == pytest.approx(5.0 / 1.01 * np.sqrt(prior + 9.0 * prior / 3.0), rel=1e-9)
    assert not found.findings()


def test_standing_weighs_with_all_that_is_known_of_zeros_and_scales() -> None:
    row = np.concatenate([np.full(8, 6.5 * 0.02), np.full(8, 0.3)])
    h = np.tile(row, (3, 1))
    found = weighed_standing(h, np.full(3, -3.9), np.full(3, 0.15), np.eye(16), 55.9, 5.7)
    assert found.mass_kg == pytest.approx(5.7 * (1.0 - 3.9 / 55.9))
    force_sd = np.sqrt(8 * (6.5 * 0.02) ** 2 + 8 * 0.3**2 + 0.15**2 / 3)
    assert found.sd_kg == pytest.approx(5.7 / 55.9 * force_sd)
    assert found.findings()
    assert found.hidden_kg == pytest.approx(4.0 * found.sd_kg)
    assert not weighed_standing(
        h, np.full(3, 0.3), np.full(3, 0.15), np.eye(16), 55.9, 5.7
    ).findings()


def stepping(mass_kg: float, faulty: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces of two feet of two cells that take turns, zeros off by 3 N; contact; m g."""
    left = np.tile(np.repeat([1.0, 0.0], 100), 4)
    foot = np.column_stack([left, left, 1.0 - left, 1.0 - left])
    forces = foot * mass_kg * 9.80665 * np.array([0.3, 0.7, 0.5, 0.5]) + 3.0
    forces[:, 0] *= faulty
    return forces, foot, np.full(800, 5.0 * 9.80665)


def test_each_foot_weighs_a_robot_that_is_heavier_than_stated() -> None:
    forces, contact, demand = stepping(5.5)
    found = weighed_by_each_foot(forces, contact, [(0, 1), (2, 3)], demand, np.full(4, 0.02), 5.0)
    assert found is not None
    assert found.mass_kg == pytest.approx(5.5)
    # the foot that says least: shares 0.3 and 0.7
    assert found.sd_kg == pytest.approx(5.0 * 0.02 * np.hypot(0.3, 0.7))
    assert found.findings("so")[0].sentence.endswith("so")


def test_a_faulty_cell_under_one_foot_is_no_wrong_mass() -> None:
    forces, contact, demand = stepping(5.0, faulty=1.5)
    forces[:, 2:] *= 0.999
    assert (
        weighed_by_each_foot(forces, contact, [(0, 1), (2, 3)], demand, np.full(4, 0.02), 5.0)
        is None
    )


@pytest.mark.filterwarnings("error")
def test_feet_are_weighed_by_the_rows_that_all_their_cells_have() -> None:
    forces, contact, demand = stepping(5.5)
    forces[::3, 1] = np.nan
    every = [(0, 1), (2, 3)]
    found = weighed_by_each_foot(forces, contact, every, demand, np.full(4, 0.02), 5.0)
    assert found is not None
    assert found.mass_kg == pytest.approx(5.5)
    forces[:, 1] = np.nan
    assert weighed_by_each_foot(forces, contact, every, demand, np.full(4, 0.02), 5.0) is None


@pytest.mark.parametrize("cells_sd", [0.0007, 0.007, 0.05])
def test_scales_fitted_to_a_stated_mass_are_as_unsure_as_it_is(cells_sd: float) -> None:
    """Robots and cells drawn: the scales carry the error of the mass, whatever the cells say."""
    rng = np.random.default_rng(5)
    stated, ratio = 40.0, []
    for error in rng.normal(0.0, 0.01, 2000):
        by_cells = stated * (1.0 - error + rng.normal(0.0, cells_sd))
        ratio.append(error / Weighed(stated, by_cells, stated * cells_sd).shared_sd(0.01))
    assert np.sqrt(np.mean(np.square(ratio))) == pytest.approx(1.0, abs=0.15)
    assert np.mean(np.abs(ratio) > 3.0) < 0.005


def test_a_mass_that_is_known_exactly_leaves_scales_as_sure_as_they_are() -> None:
    belief = nameplate(CHANNELS, np.full(8, 1e-5), np.full(8, 2.0))
    fitted = belief.estimates(np.zeros(8), np.zeros(8), 1e-6 * np.eye(16), [Status.ESTIMATED] * 16)
    found = Weighed(5.0, 5.1, 0.03)
    assert found.shared_sd(1e-9) < 1e-8
    wider = as_unsure_as_weighed(fitted, 0.01)
    assert wider["cell 0.scale"] == fitted["cell 0.scale"]
    # the reading of an unloaded cell stays as sure as it was: all forces change, none has no zero
    at = [0, 8]
    unloaded = np.array([-2.0 / 1e-5, 1.0])
    before, after = (unloaded @ e.covariance[np.ix_(at, at)] @ unloaded for e in (fitted, wider))
    assert after == pytest.approx(before)
    assert wider.sd[0] == pytest.approx(np.hypot(fitted.sd[0], 1e-7))


def test_a_wrong_mass_goes_into_zeros_as_far_as_the_fit_takes_it_there() -> None:
    """Stances in which cells and mass are drawn as they are stated: errors are those stated.

    As if all scales followed the mass, they were stated to be unsure by 1 % more.
    """
    mass_sd, squared, follows = 0.01, [], []
    for seed in range(60):
        made = make_standing(12, seed, replace=True, com_sd=0.0)
        log, belief = stand_log(made), belief_of(made)
        rows = stance_rows(log, QuietSet(made.stance, judge({}, len(log))), belief, com_sd_m=0.0)
        total = np.array([name == "fz" for name in rows.output])
        weight = weight_of(log)
        rng = np.random.default_rng(600 + seed)
        off = rng.normal(0.0, 1.0, rows.sd.size) * rows.sd
        off -= weight * mass_sd * rng.normal() * total
        rows = replace(rows, error=rows.error + off)
        fit = fit_static(rows, belief)
        weighed = weighed_standing(
            rows.h[total], rows.error[total], rows.sd[total], rows.prior_correlation, weight, 5.0
        )
        per_share = weight * fit.per_newton
        wider = as_unsure_as_weighed(fit.estimates, weighed.shared_sd(mass_sd), per_share)
        true = belief.estimates(made.true_gain, made.true_bias, np.eye(16), fit.estimates.status)
        error = fit.estimates.values - true.values
        squared.append(float(error @ np.linalg.solve(wider.covariance, error)) / 16)
        follows.append(np.mean(per_share[:8] / fit.estimates.values[:8]))
    assert 0.85 < np.mean(squared) < 1.15  # chi-squared of 16 over 16, 60 seeds: 1 ± 0.046 (1 sd)
    assert np.mean(follows) < 0.7


def test_what_a_newton_does_to_a_fit_is_what_it_says() -> None:
    made = make_standing(8, 3, replace=True, com_sd=0.0)
    log, belief = stand_log(made), belief_of(made)
    rows = stance_rows(log, QuietSet(made.stance, judge({}, len(log))), belief)
    total = np.array([name == "fz" for name in rows.output])
    first, second = (
        fit_static(replace(rows, error=rows.error - off * total, sd=10.0 * rows.sd), belief)
        for off in (0.0, 1e-3)
    )
    change = (second.estimates.values - first.estimates.values) / 1e-3
    assert change == pytest.approx(first.per_newton, rel=1e-6)
