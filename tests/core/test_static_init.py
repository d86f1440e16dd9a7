from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.centroidal import pressure
from footcal_cli.core.contact import judge
from footcal_cli.core.effects.contract import Scope, columns_of
from footcal_cli.core.experiments import stand
from footcal_cli.core.log import Log
from footcal_cli.core.next_stance import next_stances, stance_curve
from footcal_cli.core.online.belief import belief_from
from footcal_cli.core.parameters import FloatArray, Status
from footcal_cli.core.quiet import QuietRule, QuietSet, select_quiet
from footcal_cli.core.stances import stance_rows
from footcal_cli.core.static_init import StaticInit, fit_static, stance_errors, without_false_lifts
from footcal_cli.errors import FitError
from tests.core.walk_data import Standing, make_standing
from tests.core.walking import belief_of, stand_log, turned_world

AHEAD = 6
"""Stances kept back to judge on."""


def fit_first(
    made: Standing, stances: int, calibration: StaticInit | None = None
) -> tuple[StaticInit, Log, np.ndarray]:
    """Fit on the first stances; the others are marked for judging."""
    log = stand_log(made)
    belief = (
        belief_of(made) if calibration is None else belief_from(calibration.estimates, log.channels)
    )
    quiet = select_quiet(log, belief.forces(log.readings), rule=QuietRule(warm_s=0.0))
    first = QuietSet(np.where(made.stance < stances, made.stance, -1), quiet.validity)
    return fit_static(stance_rows(log, first, belief), belief), log, made.stance >= stances


def cop_error_m(
    made: Standing, log: Log, gain: FloatArray, bias: FloatArray, rows: np.ndarray
) -> float:
    forces = belief_of(made).forces(log.readings) * (1 + gain) + bias
    ours = pressure(forces[rows], made.cells[rows]).cop_m
    true = pressure(made.force[rows], made.cells[rows]).cop_m
    return float(np.sqrt(np.mean(np.sum((ours - true) ** 2, axis=1))))


@pytest.mark.parametrize(
    ("stances", "replace", "rank"), [(1, False, 3), (10, False, 11), (10, True, 14), (20, True, 14)]
)
def test_the_rank_is_what_total_force_and_cop_can_show(
    stances: int, replace: bool, rank: int
) -> None:
    fit, _, _ = fit_first(make_standing(stances, 5, replace=replace), stances)
    assert fit.observability.rank == rank
    assert set(fit.observability.weakest(2)) == {
        "left foot: diagonal twist of the biases",
        "right foot: diagonal twist of the biases",
    }


def test_a_lifted_foot_shows_the_twists_too() -> None:
    fit, _, _ = fit_first(make_standing(12, 5, replace=True, lift=True), 12)
    assert fit.observability.rank == 16


def test_the_fit_is_never_worse_than_its_prior_and_least_squares_is() -> None:
    for stances in (1, 2, 5, 10):
        scores = []
        for seed in range(12):
            made = make_standing(stances + AHEAD, seed, replace=False)
            fit, log, later = fit_first(made, stances)
            scores.append(
                [
                    cop_error_m(made, log, np.zeros(8), np.zeros(8), later),
                    cop_error_m(made, log, fit.gain, fit.bias_n, later),
                    cop_error_m(made, log, fit.least_squares[:8], fit.least_squares[8:], later)
                    if stances != 2  # its forces may sum to nothing: no CoP at all
                    else np.inf,
                ]
            )
        prior, posterior, plain = np.sqrt(np.mean(np.square(scores), axis=0))
        assert posterior < 1.02 * prior
        if stances < 10:
            assert plain > 2.0 * posterior


def test_errors_have_the_size_that_the_covariance_says() -> None:
    squared = []
    for seed in range(40):
        made = make_standing(8, seed, replace=True, lift=True, com_sd=0.001)
        log, belief = stand_log(made), belief_of(made)
        quiet = QuietSet(made.stance, judge({}, len(log)))
        rows = stance_rows(
            log, quiet, belief, force_sd_n=0.01, moment_sd_nm=0.001 * 53.0, swing_sd_n=0.001
        )
        fit = fit_static(rows, belief)
        error = np.concatenate([fit.gain - made.true_gain, fit.bias_n - made.true_bias])
        squared.append(error @ np.linalg.solve(fit.covariance, error) / 16)
    # chi-squared of 16 over 16, 40 seeds: 1 ± 0.056 (1 sd)
    assert 0.8 < np.mean(squared) < 1.2


@pytest.mark.parametrize("seeds", [20, pytest.param(40, marks=pytest.mark.slow)])
@pytest.mark.parametrize("ahead", [False, True])
def test_a_com_that_all_stances_have_in_a_wrong_place_is_in_the_intervals(
    ahead: bool, seeds: int
) -> None:
    """Its errors do not average out: stated as if they did, sd are several times too small."""
    squared: list[float] = []
    alone: list[float] = []
    for seed in range(seeds):
        made = make_standing(12, seed, replace=True, com_sd=0.0)
        log, belief = stand_log(made), belief_of(made)
        off = np.random.default_rng(900 + seed).normal(0.0, 2e-3, 2) * [1.0, float(not ahead)]
        yaw = log.known["foot_yaw_rad"].mean(axis=1)
        turned_by = np.stack([np.cos(yaw), np.sin(yaw), -np.sin(yaw), np.cos(yaw)], axis=1)
        moved = np.einsum("nij,i->nj", turned_by.reshape(-1, 2, 2), off)
        log = log.with_known(com_m=log.known["com_m"] + np.pad(moved, ((0, 0), (0, 1))))
        quiet = QuietSet(made.stance, judge({}, len(log)))
        for found, com_sd_m in ((squared, 2e-3), (alone, 0.0)):
            rows = stance_rows(log, quiet, belief, force_sd_n=1e-3, moment_sd_nm=1e-4,
                               com_sd_m=com_sd_m)  # fmt: skip
            fit = fit_static(rows, belief)
            error = np.concatenate([fit.gain - made.true_gain, fit.bias_n - made.true_bias])
            found.append(float(error @ np.linalg.solve(fit.covariance, error)) / 16)
    assert 0.8 < np.mean(squared) < 1.2  # chi-squared of 16 over 16, 20 seeds: 1 ± 0.079 (1 sd)
    assert np.mean(alone) > 5.0


def test_stances_that_contradict_each_other_are_no_surer_than_that() -> None:
    """Loads that pass by the cells are no noise of a reading: 10 times what it allows."""
    squared = []
    for seed in range(30):
        made = make_standing(12, seed, replace=True)
        log, belief = stand_log(made), belief_of(made)
        rows = stance_rows(log, QuietSet(made.stance, judge({}, len(log))), belief)
        noise = np.random.default_rng(700 + seed).normal(0.0, 10.0, rows.sd.size) * rows.sd
        fit = fit_static(replace(rows, error=rows.error + noise), belief)
        error = np.concatenate([fit.gain - made.true_gain, fit.bias_n - made.true_bias])
        squared.append(float(error @ np.linalg.solve(fit.covariance, error)) / 16)
        assert fit.chi2 > 3.0 * fit.dof
    # 1, and a little more: the residual of n rows is smaller than their noise
    assert 0.7 < np.mean(squared) < 2.0


def test_forces_that_agree_do_not_hide_moments_that_do_not() -> None:
    """Soles that lie elsewhere in each stance move moments by twice what these are worth at best.

    Over all rows that is three times the variance, for the moments four times.
    """
    squared: list[float] = []
    tight: list[float] = []
    for seed in range(40):
        made = make_standing(12, seed, replace=True, com_sd=0.0)
        log, belief = stand_log(made), belief_of(made)
        rows = stance_rows(log, QuietSet(made.stance, judge({}, len(log))), belief, com_sd_m=0.0)
        moments = np.isin(rows.output, ("mx", "my"))
        noise = np.random.default_rng(800 + seed).normal(0.0, 1.0, rows.sd.size) * rows.sd
        error = rows.error + np.where(moments, 2.0, 1.0) * noise
        for found, floor in ((squared, rows.sd), (tight, 4.0 * rows.sd)):
            fit = fit_static(replace(rows, error=error, sd=floor), belief)
            off = np.concatenate([fit.gain - made.true_gain, fit.bias_n - made.true_bias])
            found.append(float(off @ np.linalg.solve(fit.covariance, off)) / 16)
    assert 0.8 < np.mean(squared) < 1.3  # chi-squared of 16 over 16, 40 seeds: 1 ± 0.056 (1 sd)
    assert np.mean(tight) < 0.8, "what a stance is worth at best stays the least noise"


@pytest.mark.parametrize("size", [0.5, 1.0, 3.0])
def test_what_a_moment_is_worth_goes_with_the_size_of_the_robot(size: float) -> None:
    """Lengths times `size`: moments of the same weight are so many times as large and as wrong."""
    made = make_standing(4, 1, replace=True)
    log, belief = stand_log(made), belief_of(made)
    height = float(log.known["com_m"][:, 2].mean())
    tall = log.with_known(com_m=log.known["com_m"] * [1.0, 1.0, size])
    _, moment, _ = stance_rows(tall, QuietSet(made.stance, judge({}, len(log))), belief).floors
    assert moment == pytest.approx(0.002 * size * height * made.mass * 9.80665, rel=1e-6)


def test_what_standing_did_not_show_is_not_called_estimated() -> None:
    fit, _, _ = fit_first(make_standing(1, 0, replace=False), 1)
    assert set(fit.estimates.status) == {Status.PRIOR_KEPT}
    lifted, _, _ = fit_first(make_standing(16, 0, replace=True, lift=True), 16)
    by_name = dict(zip(lifted.estimates.names, lifted.estimates.status, strict=True))
    assert by_name["left_fl.bias"] is Status.ESTIMATED


def test_estimates_are_scale_and_bias_of_the_raw_counts() -> None:
    made = make_standing(6, 3, replace=True)
    fit, log, _ = fit_first(made, 6)
    scale = np.array([fit.estimates[f"{c}.scale"] for c in log.channels])
    bias = np.array([fit.estimates[f"{c}.bias"] for c in log.channels])
    by_gain = belief_of(made).forces(log.readings) * (1 + fit.gain) + fit.bias_n
    np.testing.assert_allclose(log.readings * scale + bias, by_gain, atol=1e-9)
    again = belief_from(fit.estimates, log.channels, least_gain_sd=1e-9, least_bias_sd_n=1e-9)
    np.testing.assert_allclose(np.diag(again.covariance), np.diag(fit.covariance), rtol=0.1)


def test_an_earlier_calibration_is_a_prior_that_standing_keeps_or_improves() -> None:
    made = make_standing(20, 9, replace=True, lift=True)
    first, _, _ = fit_first(made, 8)
    second, _, _ = fit_first(made, 16, first)
    assert (second.estimates.sd <= first.estimates.sd * 1.01).all()


def test_the_next_stance_offered_is_the_one_that_teaches_most() -> None:
    made = make_standing(1, 0, replace=False)
    log = stand_log(made)
    belief = belief_of(made)
    quiet = select_quiet(log, belief.forces(log.readings))
    rows = stance_rows(log, quiet, belief)
    feet = [list(map(int, c)) for c in columns_of(Scope.FOOT, log.channels)]
    menu = next_stances(rows, made.cells[0], feet, ("left", "right"), made.mass * 9.8, belief)
    gains = [step.gain_nats for step in menu]
    assert gains == sorted(gains, reverse=True)
    assert menu[0].name.startswith("stand on the")
    assert menu[-1].name == "squat"
    assert menu[0].rank > menu[-1].rank
    assert 0 < menu[0].sd_ratio < menu[-1].sd_ratio < 1


def test_quiet_standing_leaves_out_warm_up_and_motion_and_counts_them() -> None:
    made = make_standing(1, 1, replace=False, samples=480)
    log = stand_log(made)
    moving = log.known["com_acc_mps2"].copy()
    moving[160:250, 0] = 1.0
    log = log.with_known(com_acc_mps2=moving)
    forces = belief_of(made).forces(log.readings)
    quiet = select_quiet(log, forces, rule=QuietRule(warm_s=0.5))
    assert quiet.stances == 2
    assert (quiet.stance[:40] == -1).all()
    assert (quiet.stance[160:250] == -1).all()
    assert quiet.validity.counts["transition"] == 40 + 90 + 40
    assert quiet.validity.valid.sum() + 170 == len(log)


def test_a_shift_of_weight_without_haste_makes_another_stance() -> None:
    made = make_standing(3, 1, replace=False)
    log = stand_log(made)
    quiet = select_quiet(log, belief_of(made).forces(log.readings), rule=QuietRule(warm_s=0.25))
    assert quiet.stances == 3
    for number in range(3):
        assert set(made.stance[quiet.stance == number]) == {number}


def test_an_acceleration_that_is_all_noise_does_not_hide_the_stances() -> None:
    """The second derivative of a CoM that motion capture has within a millimetre."""
    made = make_standing(3, 1, replace=False)
    log = stand_log(made)
    noise = np.random.default_rng(1).normal(0.0, 0.4, (len(log), 3))
    noisy = log.with_known(com_acc_mps2=log.known["com_acc_mps2"] + noise)
    forces, rule = belief_of(made).forces(log.readings), QuietRule(warm_s=0.25)
    quiet = select_quiet(noisy, forces, rule=rule)
    assert quiet.stances == select_quiet(log, forces, rule=rule).stances == 3
    for number in range(3):
        assert set(made.stance[quiet.stance == number]) == {number}


def test_too_little_standing_says_how_much_is_missing() -> None:
    made = make_standing(1, 1, replace=False, samples=60)
    log = stand_log(made)
    with pytest.raises(FitError, match="40 after 80 of warming are needed") as failure:
        select_quiet(log, belief_of(made).forces(log.readings))
    assert "60 samples" in str(failure.value) or "60 samples" in (failure.value.remedy or "")


def test_the_stand_balance_is_zero_at_the_truth() -> None:
    made = make_standing(4, 2, replace=True, lift=True, white=0.0, com_sd=0.0)
    balance = stand.EXPERIMENT.balance(stand_log(made).with_readings(made.force))
    assert balance.outputs[:3] == ("fz", "mx", "my")
    assert np.abs(balance.error[balance.valid]).max() < 1e-12
    airborne = made.contact == 0
    assert balance.valid[:, 3:].sum() == 4 * airborne.sum()


def test_held_out_stances_are_predicted_better_than_by_the_prior() -> None:
    made = make_standing(12, 4, replace=True)
    log, belief = stand_log(made), belief_of(made)
    quiet = QuietSet(made.stance, judge({}, len(log)))
    rows = stance_rows(log, quiet, belief)
    found = {(e.stage, e.held_out): e for e in stance_errors(rows, belief, made.mass * 9.80665)}

    def rms(stage: str, held_out: bool) -> float:
        return float(np.sqrt(np.mean(found[stage, held_out].cop_m ** 2)))

    assert rms("after", False) < rms("after", True) < rms("before", True)
    assert rms("before", False) == pytest.approx(rms("before", True))
    # the CoP error of a stance is that of its mean force, against the CoM, as the robot faces
    forces = belief.forces(log.readings)
    error = pressure(forces, made.cells).cop_m - made.com[:, :2]
    yaw = log.known["foot_yaw_rad"]
    heading = np.arctan2(np.sin(yaw).mean(axis=1), np.cos(yaw).mean(axis=1))
    x, y, cos, sin = *error.T, np.cos(heading), np.sin(heading)
    centre = np.stack([cos * x + sin * y, cos * y - sin * x], axis=1)
    mean = np.array([centre[made.stance == k].mean(axis=0) for k in range(12)])
    np.testing.assert_allclose(found["before", False].cop_m, mean, atol=1.5e-4)


@pytest.mark.parametrize("seeds", [4, pytest.param(20, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("replace", "ranks"), [(False, [3, 6, 11, 11]), (True, [3, 6, 14, 14])])
def test_more_stances_never_harm_the_next_one_and_least_squares_does(
    replace: bool, ranks: list[int], seeds: int
) -> None:
    curves = []
    for seed in range(5, 5 + seeds):
        made = make_standing(12, seed, replace=replace)
        log, belief = stand_log(made), belief_of(made)
        quiet = QuietSet(made.stance, judge({}, len(log)))
        # each stance's CoM is off by 1 mm of its own: so much its moments are worth
        rows = stance_rows(
            log, quiet, belief, moment_sd_nm=1e-3 * made.mass * 9.80665, com_sd_m=0.0
        )
        curves.append(stance_curve(rows, belief, made.mass * 9.80665))
    for points, used, rank in zip(zip(*curves, strict=True), (1, 2, 5, 10), ranks, strict=True):
        assert {(p.stances, p.rank, p.tried) for p in points} == {(used, rank, 12)}
        before, after, plain = (
            float(np.sqrt(np.mean([getattr(p, name) ** 2 for p in points])))
            for name in ("before_m", "after_m", "least_squares_m")
        )
        assert after < before
        assert plain > (2.0 if used < 5 else 1.0) * after


@pytest.mark.parametrize("angle_deg", [37.0, 90.0, -161.0])
def test_nothing_depends_on_where_the_world_lies(angle_deg: float) -> None:
    """Measured at 6403e2b: 0.16 sd between headings."""
    made = make_standing(8, 5, replace=True)
    log, belief = stand_log(made), belief_of(made)
    # sway along one axis of the robot, so that the scatter differs from axis to axis
    rng = np.random.default_rng(3)
    sway = np.cumsum(rng.normal(0.0, 2e-4, len(log)))
    log = log.with_known(com_m=log.known["com_m"] + sway[:, None] * np.array([0.0, 1.0, 0.0]))
    fits = []
    for one in (log, turned_world(log, np.deg2rad(angle_deg), np.array([130.0, -70.0]))):
        quiet = select_quiet(one, belief.forces(one.readings), rule=QuietRule(warm_s=0.0))
        fits.append(fit_static(stance_rows(one, quiet, belief), belief))
    first, second = fits
    sd = first.estimates.sd
    assert first.dof == second.dof
    assert np.all(np.abs(second.estimates.values - first.estimates.values) < 1e-6 * sd)
    assert second.estimates.sd == pytest.approx(sd, rel=1e-6)


def test_a_foot_whose_zero_is_far_off_is_not_taken_for_lifted() -> None:
    """By its data sheet a loaded foot may seem to hang in the air; the other rows contradict it."""
    made = make_standing(12, 5, replace=True, lift=True)
    log = stand_log(made)
    nameplate = belief_of(made)
    sd = np.concatenate([np.full(8, 0.03), np.full(8, 5.0)])
    belief = replace(nameplate, covariance=np.diag(sd**2))
    wrong = log.known["contact"].copy()
    both = [k for k in range(12) if (wrong[made.stance == k] == 1.0).all()]
    told = made.stance == both[0]
    wrong[told, 0] = 0.0
    fits = []
    for contact in (log.known["contact"], wrong):
        one = log.with_known(contact=contact)
        rows = stance_rows(one, QuietSet(made.stance, judge({}, len(log))), belief)
        sound = without_false_lifts(rows)
        lifts = [name.startswith("left_") and k == both[0]
                 for name, k in zip(sound.output, sound.stance, strict=True)]  # fmt: skip
        assert not any(lifts)
        fits.append(fit_static(sound, belief))
        if contact is not wrong:
            assert sound.error.size == rows.error.size, "true lifts stay"
    np.testing.assert_allclose(fits[1].estimates.values, fits[0].estimates.values, rtol=1e-12)
