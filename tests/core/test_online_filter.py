"""The filter and the smoother against the dense solutions they must equal, and their guards."""

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.online.evidence import check_consistency
from footcal_cli.core.online.filter import Guards, WalkNoise, run_filter, run_settings
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.online.smoother import run_smoother
from footcal_cli.core.online.tuning import learn_noise
from footcal_cli.core.parameters import FloatArray

OPEN = Guards(huber=np.inf, least_gain_nats=-1.0, jump_threshold=np.inf)
NOISE = WalkNoise(
    force_n=0.2,
    moment_nm=0.03,
    force_slow_n=1e-9,
    moment_slow_nm=1e-9,
    swing_n=0.1,
    swing_slow_n=0.0,
    gain_walk=1e-3,
    bias_walk_n=0.02,
)


def row_sd(noise: WalkNoise) -> FloatArray:
    return np.array(
        [float(noise.force_n)] + [float(noise.moment_nm)] * 2 + [float(noise.swing_n)] * 2
    )


def toy_rows(
    seed: int, u: int = 120, noise: WalkNoise = NOISE, wander: float = 1.0
) -> tuple[Rows, FloatArray]:
    """Rows of two cells that are what a filter believes of them, and the true unknowns (u, p)."""
    rng = np.random.default_rng(seed)
    names = ("left_a.gain", "right_a.gain", "left_a.bias", "right_a.bias")
    prior_sd = np.array([0.02, 0.02, 0.3, 0.3])
    step = 0.05
    walk_sd = np.array([float(noise.gain_walk)] * 2 + [float(noise.bias_walk_n)] * 2)
    truth = prior_sd * rng.normal(size=4) + wander * np.vstack(
        [np.zeros(4), np.cumsum(rng.normal(size=(u - 1, 4)) * walk_sd * np.sqrt(step), axis=0)]
    )
    load = rng.uniform(0.0, 50.0, (u, 2))
    swing = np.arange(u) % 12 < 5
    load[swing, 0] = 0.0
    arms = rng.uniform(-0.1, 0.1, (u, 2, 2))
    h = np.zeros((u, 5, 4))
    h[:, 0, :2], h[:, 0, 2:] = load, 1.0
    for axis in range(2):
        h[:, 1 + axis, :2] = load * arms[:, :, axis]
        h[:, 1 + axis, 2:] = arms[:, :, axis]
    h[:, [3, 4], [0, 1]] = load
    h[:, [3, 4], [2, 3]] = 1.0
    sd = row_sd(noise)
    error = -np.einsum("ukp,up->uk", h, truth) + rng.normal(size=(u, 5)) * sd
    valid = np.ones((u, 5), dtype=bool)
    valid[:, 3] = swing
    valid[:, 4] = False
    time: FloatArray = np.arange(u, dtype=float) * step
    rows = Rows(
        time, names, ("-", "-", "N", "N"), prior_sd, np.eye(4),
        ("fz", "mx", "my", "left_a", "right_a"), 3, h * prior_sd, error, valid,
        np.arange(u), np.ones(2),
    )  # fmt: skip
    return rows, truth


def dense_posterior(rows: Rows, noise: WalkNoise, last: int) -> tuple[FloatArray, FloatArray]:
    """Means (u, p) and variances (u, p) of all states given rows 0..last, as one linear system."""
    u, p = last + 1, len(rows.names)
    walk = np.array([float(noise.gain_walk)] * 2 + [float(noise.bias_walk_n)] * 2) / rows.prior_sd
    information = np.zeros((u * p, u * p))
    information[:p, :p] = np.eye(p)
    for k in range(1, u):
        q = np.diag(1.0 / (walk**2 * (rows.time_s[k] - rows.time_s[k - 1])))
        a, b = slice((k - 1) * p, k * p), slice(k * p, (k + 1) * p)
        information[a, a] += q
        information[b, b] += q
        information[a, b] -= q
        information[b, a] -= q
    pull = np.zeros(u * p)
    sd = row_sd(noise)
    for k in range(u):
        at = rows.valid[k]
        h = rows.h[k, at] / sd[at, None]
        block = slice(k * p, (k + 1) * p)
        information[block, block] += h.T @ h
        pull[block] -= h.T @ (rows.error[k, at] / sd[at])
    covariance = np.linalg.inv(information)
    mean = (covariance @ pull).reshape(u, p) * rows.prior_sd
    return mean, np.diag(covariance).reshape(u, p) * rows.prior_sd**2


def test_the_filter_is_the_dense_posterior_of_each_moment() -> None:
    rows, _ = toy_rows(1)
    track = run_filter(rows, NOISE, OPEN)
    for last in (0, 17, 119):
        mean, variance = dense_posterior(rows, NOISE, last)
        np.testing.assert_allclose(track.values[last], mean[last], rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(track.sd[last] ** 2, variance[last], rtol=1e-6)


def test_the_smoother_is_the_dense_posterior_of_the_whole() -> None:
    rows, _ = toy_rows(2)
    smoothed = run_smoother(rows, NOISE, OPEN)
    mean, variance = dense_posterior(rows, NOISE, 119)
    np.testing.assert_allclose(smoothed.values, mean, rtol=1e-5, atol=1e-8)
    np.testing.assert_allclose(smoothed.sd**2, variance, rtol=1e-5)


def test_what_comes_later_does_not_change_what_was_known() -> None:
    rows, _ = toy_rows(3)
    whole = run_filter(rows, NOISE)
    early = run_filter(rows.part(0, 60), NOISE)
    np.testing.assert_array_equal(whole.values[:60], early.values)
    np.testing.assert_array_equal(whole.sd[:60], early.sd)


def test_many_settings_in_one_pass_are_the_single_runs() -> None:
    rows, _ = toy_rows(4)
    slow = replace(NOISE, force_slow_n=0.1, moment_slow_nm=0.02, swing_slow_n=0.03)
    stacked = np.stack([slow.stacked()[0], slow.stacked()[0] * 1.7])
    likelihood, values, _ = run_settings(rows, WalkNoise.of(stacked), OPEN)
    for b, single in enumerate(stacked):
        track = run_filter(rows, WalkNoise.of(single), OPEN)
        assert likelihood[b] == pytest.approx(track.log_likelihood, rel=1e-9)
        np.testing.assert_allclose(values[:, b], track.values, rtol=1e-7, atol=1e-10)


def test_intervals_and_innovations_are_consistent_over_seeds() -> None:
    inside, squared, ratios = [], [], []
    for seed in range(40):
        rows, truth = toy_rows(100 + seed)
        track = run_filter(rows, NOISE, OPEN)
        z = (track.values - truth) / track.sd
        inside.append(np.mean(np.abs(z[-1]) < 1.96))
        error = track.values[-1] - truth[-1]
        squared.append(error @ np.linalg.solve(track.covariance, error) / 4)
        ratios.append(check_consistency(track, skip_s=0.0).ratio)
    assert 0.90 < np.mean(inside) < 0.99
    assert 0.75 < np.mean(squared) < 1.25
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.03)


def test_the_learnt_noise_is_near_the_true_one() -> None:
    true = replace(NOISE, bias_walk_n=0.08, gain_walk=3e-3)
    found = []
    for seed in range(3):
        rows, _ = toy_rows(seed, u=600, noise=true)
        learnt = ("force_n", "moment_nm", "swing_n", "gain_walk", "bias_walk_n")
        tuning = learn_noise(rows, NOISE, learnt=learnt)
        assert tuning.log_likelihood[1] > tuning.log_likelihood[0]
        found.append([float(np.asarray(getattr(tuning.noise, name))) for name in learnt])
    expected = [float(np.asarray(getattr(true, name))) for name in learnt]
    np.testing.assert_allclose(np.exp(np.mean(np.log(found), axis=0)), expected, rtol=0.35)


def test_an_update_that_teaches_nothing_changes_nothing() -> None:
    rows, _ = toy_rows(5)
    still = replace(NOISE, gain_walk=0.0, bias_walk_n=0.0)
    bored = run_filter(rows, still, Guards(least_gain_nats=5.0))
    assert not bored.used.any()
    assert not bored.values.any()
    np.testing.assert_allclose(bored.sd, np.tile(rows.prior_sd, (len(rows), 1)))
    awake = run_filter(rows, NOISE, Guards(least_gain_nats=1e-4))
    assert awake.used.mean() > 0.5
    assert (awake.gain_nats[awake.used] > 1e-4).all()


def test_single_outliers_move_the_robust_filter_little() -> None:
    rows, _ = toy_rows(6)
    hit = replace(rows, error=rows.error.copy())
    hit.error[60, 0] += 25.0
    quiet = Guards(jump_threshold=np.inf)
    plain = replace(quiet, huber=np.inf)
    moved = np.abs(run_filter(hit, NOISE, quiet).values - run_filter(rows, NOISE, quiet).values)
    naive = np.abs(run_filter(hit, NOISE, plain).values - run_filter(rows, NOISE, plain).values)
    assert moved[60:].max() < 0.25 * naive[60:].max()


@pytest.mark.parametrize(("name", "column"), [("left_a.bias", 2), ("right_a.bias", 3)])
def test_a_jump_is_found_named_timed_and_corrected(name: str, column: int) -> None:
    hits, errors = 0, []
    for seed in range(10):
        rows, truth = toy_rows(200 + seed, u=300)
        jumped = replace(rows, error=rows.error.copy())
        jumped.error[150:] -= 2.0 * rows.h[150:, :, column] / rows.prior_sd[column]
        track = run_filter(jumped, NOISE)
        assert track.jumps
        first = track.jumps[0]
        hits += first.name == name and abs(first.onset_s - rows.time_s[150]) <= 0.25
        after = truth[:, column] + 2.0 * (np.arange(300) >= 150)
        late = rows.time_s > rows.time_s[150] + 2.0
        errors.append(np.abs(track.values[late, column] - after[late]).max())
    assert hits >= 9
    assert np.median(errors) < 0.4


def test_no_jump_is_cried_where_there_is_none() -> None:
    cried = sum(len(run_filter(toy_rows(300 + seed)[0], NOISE).jumps) for seed in range(40))
    assert cried == 0


@pytest.mark.parametrize("fast", [False, True])
@pytest.mark.parametrize("column", [2, 3])
def test_a_belief_that_is_far_off_is_no_jump(column: int, fast: bool) -> None:
    for seed in range(5):
        rows, _ = toy_rows(400 + seed)
        off = 7.0 * rows.h[:, :, column]  # seven sd of what is believed before the walk, all along
        assert not run_filter(replace(rows, error=rows.error - off), NOISE, fast=fast).jumps


def test_a_track_with_jumps_is_not_smoothed_across_its_corrections() -> None:
    rows, _ = toy_rows(7, u=300)
    rows.error[150:] -= 3.0 * rows.h[150:, :, 2] / rows.prior_sd[2]
    smoothed = run_smoother(rows, NOISE, OPEN, run_filter(rows, NOISE).jumps)
    step = smoothed.values[155:, 2].mean() - smoothed.values[:145, 2].mean()
    assert step == pytest.approx(3.0, abs=0.3)
    # the smoother knows of the jump before the first row that shows it
    assert np.abs(np.diff(smoothed.values[140:160, 2])).argmax() in (8, 9, 10)


def test_gains_wander_no_further_than_they_were_unsure_of() -> None:
    """Learnt from gains that walk by 0.03/√s for 30 s, where the prior allows 0.02 in all."""
    rows, _ = toy_rows(5, u=600, noise=replace(NOISE, gain_walk=3e-2))
    tuning = learn_noise(rows, NOISE, learnt=("gain_walk",))
    # the mean of the walk's variance is reported, exp(s²) above its mode
    most = 0.02 / np.sqrt(float(np.ptp(rows.time_s))) * np.exp(float(tuning.sd_log[0]) ** 2)
    assert float(np.asarray(tuning.noise.gain_walk)) == pytest.approx(most, rel=1e-6)
