"""Bounds of walks and stands against closed forms, and against an estimator that reaches them."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from tests.foreign.ankles import ankle_offsets
from tests.foreign.biped import draw_biped
from tests.foreign.efficiency import bounds_of
from tests.foreign.least import (
    Known,
    Rows,
    information,
    known_before,
    least,
    rows_of,
    white_and_slow,
)
from tests.foreign.least_ankles import wrenches_of
from tests.foreign.motion import SOLE_PLACE_M, SOLE_ROLL_M
from tests.foreign.noise import Array, coloured


def one_cell(load_n: Array, sd: float, body_sd: float, again: int = 4000) -> Rows:
    """A cell that carries the robot alone, white noise, a total force known to `body_sd` each."""
    n = load_n.size
    rng = np.random.default_rng(3)
    lever = np.zeros((1, n, 3, 1))
    lever[0, :, 0, 0] = 1.0
    off = body_sd * rng.normal(size=(again, 1, n, 3))
    whole = np.column_stack([load_n, 0.0 * load_n, 0.0 * load_n])[None]
    return Rows(
        load_n[None, :, None], np.ones((1, n, 1)), lever, whole, np.zeros((1, n, 0)),
        np.full(n, sd**2), off,
    )  # fmt: skip


def test_one_cell_white_noise_and_a_prior() -> None:
    load = np.repeat([0.0, 10.0, 40.0, 20.0], 8)
    prior = np.diag([0.02**2, 0.5**2])
    a = np.column_stack([load, np.ones(load.size)])
    for sd, body_sd in ((0.3, 0.1), (0.1, 0.4)):
        alone, walked = least(one_cell(load, sd, body_sd), Known(prior[None]))
        seen = np.linalg.inv(prior)
        expected = np.sqrt(np.diag(np.linalg.inv(seen + a.T @ a / sd**2)))
        assert alone[0] == pytest.approx(expected, rel=1e-9)
        expected = np.sqrt(np.diag(np.linalg.inv(seen + a.T @ a / (sd**2 + body_sd**2))))
        assert walked[0] == pytest.approx(expected, rel=0.02)  # a law from 4000 draws


def test_a_mass_that_is_known_poorly_is_what_the_scale_is_known_to() -> None:
    """Much data under one load of a cell without a zero: variances of both add in parallel."""
    load = np.full(64, 50.0)
    known = Known(np.diag([0.02**2, 1e-12])[None], mass_sd=0.01)
    _, sd = least(one_cell(load, 1e-3, 1e-3), known)
    assert sd[0, 0] == pytest.approx((0.02**-2 + 0.01**-2) ** -0.5, rel=1e-3)


def test_information_of_white_noise_is_that_of_least_squares() -> None:
    rng = np.random.default_rng(0)
    columns = rng.normal(size=(60, 2, 3))
    noise = np.array([[2.0, 0.5], [0.5, 1.0]])
    expected = np.einsum("nrp,rs,nsq->pq", columns, np.linalg.inv(noise), columns)
    assert information(columns, np.tile(noise, (60, 1, 1))) == pytest.approx(expected)


def test_power_of_noise_is_that_of_its_periodograms() -> None:
    n, hz = 500, 50.0
    law = white_and_slow(2.0, n, hz, hz, 0.0)
    rng = np.random.default_rng(1)
    seen = np.fft.fft(2.0 * coloured(rng, n, 4000, 0.1 * hz), axis=0)
    ratio = np.mean(np.abs(seen) ** 2, axis=1) / n / law
    assert ratio == pytest.approx(np.ones(n), abs=0.15)
    assert np.mean(law) == pytest.approx(4.0, rel=1e-3)


def test_least_squares_that_know_the_load_reach_the_bound() -> None:
    """300 logs of cells of a walk; white noise, generalised least squares with the prior."""
    seed = 9207002
    robot, rows = draw_biped(seed), rows_of(seed, "walk", again=8)
    known = known_before(seed, "online-replay, nameplate")
    n = rows.load_n.shape[1]
    sd = 20.0 * robot.sd_n
    white = Rows(**{**vars(rows), "power": np.full(n, sd**2)})
    bound, _ = least(white, known)
    rng = np.random.default_rng(7)
    ratios = []
    for i in range(rows.load_n.shape[2]):
        a = np.column_stack([rows.load_n[0, :, i], np.ones(n)])
        weight = np.linalg.inv(known.covariance[i])
        inverse = np.linalg.inv(a.T @ a / sd**2 + weight)
        true = rng.normal(size=(300, 2)) * np.sqrt(np.diag(known.covariance[i]))
        read = true @ a.T + sd * rng.normal(size=(300, n))
        found = (read @ a / sd**2) @ inverse
        ratios.append((found - true) / bound[i])
    share = np.sqrt(np.mean(np.square(ratios), axis=(0, 1)))
    sys.stdout.write(f"scale {share[0]:.3f}, zero {share[1]:.3f} of the bound\n")
    assert share == pytest.approx([1.0, 1.0], abs=3.0 / np.sqrt(2 * 8 * 300))


def test_readings_of_ankles_balance_but_for_the_soles() -> None:
    seed = 9207013
    robot, rows = draw_biped(seed), wrenches_of(seed, "stand", again=1)
    offsets = np.stack([ankle_offsets(robot)])[None]
    ground = rows.shown - offsets - rows.below[..., 0]
    left = np.einsum("snrfc,snfc->snr", rows.lever, ground) - rows.whole
    # cells of the soles are laid where these are: 0.8 mm, and 0.2 mm more while the weight shifts
    soles = 3.0 * np.hypot(SOLE_PLACE_M, SOLE_ROLL_M) * robot.kind.size * robot.weight_n
    assert np.abs(left[..., :3]).max() < 1e-3 * robot.weight_n
    assert np.abs(left[..., 3:]).max() < soles


def test_every_value_has_its_bound(tmp_path: Path) -> None:
    seed = 9207001
    bounds = bounds_of("online-replay, mounted anew", seed, tmp_path)
    anew = np.array(bounds["scale"])
    exact = np.array(bounds_of("online-replay", seed, tmp_path)["scale"])
    assert anew.shape == (len(draw_biped(seed).channels), 2)
    # the mass is known to 1 %, scales to 2 % each: all together are known to that and no better
    shared = (0.01**-2 + 8.0 * 0.02**-2) ** -0.5
    assert anew[:, 1].min() > shared
    assert exact[:, 1].max() < 0.1 * shared + 1e-3
    assert bounds_of("offline-fit", seed, tmp_path) == {}
