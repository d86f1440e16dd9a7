"""The noise model of the online filter: what rows share, what rounding leaves, what repeats."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.online.evidence import check_consistency, repetition
from footcal_cli.core.online.filter import run_filter
from footcal_cli.core.online.noise import kept_rounding_n
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.online.tuning import learn_noise
from footcal_cli.core.parameters import FloatArray
from tests.core.test_online_filter import NOISE, OPEN, toy_rows

JITTER_S = 0.002
SHARED = replace(NOISE, swing_n=0.3, swing_slow_n=0.2, swing_slow_s=0.5)


def jittery(seed: int, u: int = 400) -> Rows:
    """Rows of a body that now and then moves fast, its stamps wrong by `JITTER_S`."""
    rows, _ = toy_rows(seed, u)
    rng = np.random.default_rng(seed + 50)
    speed = np.array([5.0, 40.0, 20.0]) * (1.0 + 4.0 * (np.arange(u) % 12 < 3))[:, None]
    wrong = rng.normal(0.0, JITTER_S, u)
    error = rows.error.copy()
    error[:, :3] += speed * wrong[:, None]
    return replace(rows, error=error, per_stamp_s=speed)


def shaken(seed: int, u: int = 300) -> tuple[Rows, FloatArray]:
    """Rows whose cells' own noise, white and slow, goes into the totals as into their own rows."""
    rows, truth = toy_rows(seed, u, replace(NOISE, swing_n=1e-9))
    rng = np.random.default_rng(seed + 90)
    rho = np.exp(-0.05 / float(np.asarray(SHARED.swing_slow_s)))
    slow = np.zeros((u, 2))
    sd = float(np.asarray(SHARED.swing_slow_n))
    slow[0] = rng.normal(0.0, sd, 2)
    for k in range(1, u):
        slow[k] = rho * slow[k - 1] + rng.normal(0.0, sd * np.sqrt(1 - rho**2), 2)
    own = slow + rng.normal(0.0, float(np.asarray(SHARED.swing_n)), (u, 2))
    columns = rows.h[:, :, 2:] / rows.prior_sd[2:]
    error = rows.error - np.einsum("ukc,uc->uk", columns, own)
    return replace(rows, error=error, own=np.array([2, 3])), truth


def test_jitter_of_stamps_is_noise_where_the_body_moves_fast() -> None:
    told = [run_filter(jittery(s), replace(NOISE, jitter_s=JITTER_S), OPEN) for s in range(10)]
    silent = [run_filter(jittery(s), replace(NOISE, jitter_s=0.0), OPEN) for s in range(10)]
    ratio = [check_consistency(t).ratio for t in told]
    assert np.mean(ratio) == pytest.approx(1.0, abs=0.03)
    assert np.mean([check_consistency(t).ratio for t in silent]) > 1.5


def test_jitter_is_learnt_from_the_innovations() -> None:
    start = replace(NOISE, jitter_s=5e-4)
    found = [
        float(np.asarray(learn_noise(jittery(s), start, learnt=("jitter_s",)).noise.jitter_s))
        for s in range(3)
    ]
    assert np.exp(np.mean(np.log(found))) == pytest.approx(JITTER_S, rel=0.1)


def test_noise_that_totals_and_swing_share_is_counted_once() -> None:
    nis, nees, apart = [], [], []
    for seed in range(40):
        rows, truth = shaken(seed)
        track = run_filter(rows, SHARED, OPEN)
        error = track.values[-1] - truth[-1]
        nis.append(check_consistency(track, skip_s=0.0).ratio)
        nees.append(error @ np.linalg.solve(track.covariance, error) / 4)
        alone = run_filter(replace(rows, own=None), SHARED, OPEN)
        error = alone.values[-1] - truth[-1]
        apart.append(error @ np.linalg.solve(alone.covariance, error) / 4)
    assert np.mean(nis) == pytest.approx(1.0, abs=0.03)
    # 95 % of chi-squared with 160 degrees of freedom over 160
    assert 0.79 < np.mean(nees) < 1.23
    assert np.mean(apart) > 1.5


def test_momentary_errors_of_cells_are_followed() -> None:
    rows, _ = shaken(3)
    track = run_filter(rows, SHARED, OPEN)
    assert track.momentary is not None
    assert track.momentary.shape == (300, 2)
    assert 0.02 < np.std(track.momentary) < float(np.asarray(SHARED.swing_slow_n))
    assert run_filter(replace(rows, own=None), SHARED, OPEN).momentary is None


@pytest.mark.parametrize("noise_in_steps", [0.0, 0.15, 0.3, 0.4])
def test_rounding_that_lasts_is_what_noise_does_not_average_out(noise_in_steps: float) -> None:
    rng = np.random.default_rng(4)
    step, n, cells = 0.25, 4000, 60
    place = rng.uniform(-0.5, 0.5, cells) * step
    true = np.broadcast_to(place, (n, cells))
    noisy = true + rng.normal(0.0, noise_in_steps * step, true.shape)
    shown = np.round(noisy / step) * step
    # a converter is known by the steps it makes under load
    shown = np.vstack([shown, rng.integers(-40, 40, (400, cells)) * step])
    idle = np.arange(n + 400)[:, None] < np.full((1, cells), n)
    lasting = np.sqrt(np.mean((shown[:n].mean(axis=0) - place) ** 2))
    found = kept_rounding_n(shown, idle)
    assert found == pytest.approx(lasting, abs=0.12 * step / np.sqrt(12))


def test_correlated_surprises_widen_the_band() -> None:
    rows, _ = toy_rows(8, u=600)
    track = run_filter(rows, NOISE, OPEN)
    white = check_consistency(track)
    rng = np.random.default_rng(5)
    loud = np.repeat(rng.uniform(0.2, 1.8, 30), 20)
    lasting = check_consistency(replace(track, nis=track.nis * loud))
    assert white.low < white.ratio < white.high
    assert lasting.worth < 0.5 * white.worth
    assert lasting.high - lasting.low > 1.4 * (white.high - white.low)


def test_only_errors_that_come_back_count_as_repeated() -> None:
    rows, _ = toy_rows(9, u=1200)
    track = run_filter(rows, NOISE, OPEN)
    phase: FloatArray = (np.arange(1200.0) % 24) / 24
    assert repetition(track, phase, 3) == 1.0
    pattern = 0.7 * np.sin(2 * np.pi * phase)[:, None] * track.innovation_sd
    assert repetition(replace(track, innovation=track.innovation + pattern), phase, 3) > 4.0
