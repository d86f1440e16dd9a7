"""The Kalman step and the window: compiled loops against array code, and against closed forms."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from footcal_cli.core.inference.kalman import correct, information, innovate, predict, smooth_back
from footcal_cli.core.log import Log
from footcal_cli.core.online import smoother
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.compiled import kalman_loops
from footcal_cli.core.online.filter import Guards, Track, WalkNoise, run_filter, run_settings
from footcal_cli.core.online.rows import Rows, cell_rows
from footcal_cli.core.online.smoother import run_smoother
from footcal_cli.core.study.window import Weights, run_window, run_window_fast, window_loops
from tests.core.walk_data import Errors, make_walk, record
from tests.core.walking import belief_of, walk_log

NOISE = WalkNoise(swing_fixed_n=0.07)
needs_compiler = pytest.mark.skipif(kalman_loops() is None, reason="numba is not installed")


@pytest.fixture(scope="module")
def walk() -> tuple[Log, Belief]:
    recording = record(make_walk(0.04, 20.0, seed=1), Errors(), seed=1)
    return walk_log(recording), belief_of(recording)


@pytest.fixture(scope="module")
def rows(walk: tuple[Log, Belief]) -> Rows:
    """A walk on which the bias of one cell jumps by 2 N at half time."""
    found = cell_rows(*walk)
    at = found.names.index("left_fl.bias")
    late = found.time_s > np.median(found.time_s)
    error = found.error + late[:, None] * found.h[:, :, at] * (-2.0 / found.prior_sd[at])
    return replace(found, error=error)


def same(one: Track, other: Track) -> None:
    for name in ("values", "sd", "momentary", "covariance", "nis", "innovation", "gain_nats"):
        a, b = getattr(one, name), getattr(other, name)
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-10 * np.nanmax(np.abs(a)))
    assert one.log_likelihood == pytest.approx(other.log_likelihood, abs=1e-8)
    np.testing.assert_array_equal(one.used, other.used)
    assert len(one.jumps) == len(other.jumps)
    for first, second in zip(one.jumps, other.jumps, strict=True):
        for field in fields(first):
            a, b = getattr(first, field.name), getattr(second, field.name)
            assert a == (b if isinstance(b, str) else pytest.approx(b, rel=1e-9))


@needs_compiler
def test_compiled_filter_finds_what_the_array_code_finds(rows: Rows) -> None:
    arrays = run_filter(rows, NOISE, fast=False)
    assert [jump.name for jump in arrays.jumps] == ["left_fl.bias"]
    same(arrays, run_filter(rows, NOISE))


@needs_compiler
def test_compiled_smoother_is_the_array_smoother(rows: Rows) -> None:
    jumps = run_filter(rows, NOISE).jumps
    one, other = (run_smoother(rows, NOISE, Guards(), jumps, fast=fast) for fast in (False, True))
    np.testing.assert_allclose(one.values, other.values, atol=1e-10 * np.abs(one.values).max())
    np.testing.assert_allclose(one.sd, other.sd, rtol=1e-9)


@pytest.mark.parametrize("length", [7, 100, 10_000])
def test_smoothing_by_stretches_is_smoothing_the_whole(
    rows: Rows, length: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    jumps = run_filter(rows, NOISE).jumps
    monkeypatch.setattr(smoother, "STRETCH", len(rows))
    whole = run_smoother(rows, NOISE, Guards(), jumps)
    monkeypatch.setattr(smoother, "STRETCH", length)
    parts = run_smoother(rows, NOISE, Guards(), jumps)
    for name in ("values", "sd", "nis", "momentary", "covariance"):
        one, other = getattr(whole, name), getattr(parts, name)
        np.testing.assert_allclose(one, other, atol=1e-10 * np.abs(one).max())


@needs_compiler
def test_compiled_settings_are_the_array_settings(rows: Rows) -> None:
    many = WalkNoise.of(NOISE.stacked() * np.geomspace(0.3, 3.0, 7)[:, None])
    one, other = run_settings(rows, many, fast=False), run_settings(rows, many)
    np.testing.assert_allclose(one[0], other[0], atol=1e-8)
    np.testing.assert_allclose(one[1], other[1], atol=1e-10 * np.abs(one[1]).max())
    np.testing.assert_allclose(run_settings(rows, many, states=False)[0], one[0], atol=1e-8)


@pytest.mark.skipif(window_loops() is None, reason="numba is not installed")
@pytest.mark.parametrize("method", [run_window, run_window_fast])
def test_compiled_windows_are_the_array_windows(walk: tuple[Log, Belief], method: object) -> None:
    assert callable(method)
    weights = Weights(4e4, 3e4, np.geomspace(1e1, 1e6, 5))
    one, other = method(*walk, weights, fast=False), method(*walk, weights)
    np.testing.assert_allclose(one.gain, other.gain, atol=1e-8 * np.abs(one.gain).max())
    np.testing.assert_allclose(one.bias_n, other.bias_n, atol=1e-8 * np.abs(one.bias_n).max())


def test_the_step_is_the_regression_of_all_that_was_seen() -> None:
    """Constant states, white noise: filtering row by row is weighted least squares with a prior."""
    rng = np.random.default_rng(0)
    h, noise = rng.normal(size=(9, 4)), np.diag(rng.uniform(0.5, 2.0, 9))
    truth = rng.normal(size=4)
    y = h @ truth + rng.normal(size=9)
    mean, cov, likelihood = np.zeros(4), np.eye(4), 0.0
    for part in np.split(np.arange(9), 3):
        seen = innovate(cov, h[part], y[part] - h[part] @ mean, noise[np.ix_(part, part)])
        likelihood += float(seen.log_likelihood)
        mean, cov = correct(mean, cov, seen)
    precision = np.eye(4) + h.T @ np.linalg.solve(noise, h)
    np.testing.assert_allclose(cov, np.linalg.inv(precision), atol=1e-12)
    np.testing.assert_allclose(mean, cov @ h.T @ np.linalg.solve(noise, y), atol=1e-12)
    whole = h @ h.T + noise
    expected = -0.5 * (
        y @ np.linalg.solve(whole, y) + np.linalg.slogdet(whole)[1] + 9 * np.log(2 * np.pi)
    )
    assert likelihood == pytest.approx(expected)


def test_information_is_the_gain_in_entropy_of_a_normal_law() -> None:
    cov, h = np.diag([4.0, 1.0]), np.array([[1.0, 0.0]])
    seen = innovate(cov, h, np.zeros(1), np.array([[1.0]]))
    assert information(cov, seen.weight) == pytest.approx(0.5 * np.log(5.0))


def test_smoothing_one_step_back_is_conditioning_on_both() -> None:
    """Random walk of two steps, measured at the end: closed form by the joint normal law."""
    mean, cov = np.zeros(1), np.array([[2.0]])
    ahead = predict(mean, cov, np.array([0.8]), np.array([0.5]))
    seen = innovate(ahead[1], np.eye(1), np.array([3.0]), np.array([[0.7]]))
    later = correct(*ahead, seen)
    value, variance = smooth_back(mean, cov, np.array([0.8]), ahead, later)
    total = 0.64 * 2.0 + 0.5 + 0.7
    assert value[0] == pytest.approx(2.0 * 0.8 / total * 3.0)
    assert variance[0, 0] == pytest.approx(2.0 - (2.0 * 0.8) ** 2 / total)
