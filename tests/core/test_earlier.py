"""An earlier calibration as prior: like its rows, consistent, and not where something changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core import calibrate
from footcal_cli.core.bench.regression import fit_affine
from footcal_cli.core.inference.earlier import with_earlier
from footcal_cli.core.parameters import Estimates, FloatArray, Status
from footcal_cli.errors import FitError

_TRUTH = np.array([2.0e-5, -163.0])
_LOAD = np.tile(np.array([0.0, 2.0, 5.0, 10.0, 20.0]), 5)
_NOISE_N = 0.05


def calibrated(rng: np.random.Generator, load_n: FloatArray, channel: str = "a") -> Estimates:
    """A cell of eight million counts under known weights."""
    counts = (load_n - _TRUTH[1]) / _TRUTH[0] + _NOISE_N / _TRUTH[0] * rng.normal(size=load_n.size)
    return fit_affine(channel, load_n, counts).estimates


def known_noise(rows: FloatArray, target: FloatArray) -> Estimates:
    covariance = np.asarray(np.linalg.inv(rows.T @ rows), dtype=np.float64)
    names = ("a.scale", "a.bias", "b.scale")
    values = covariance @ (rows.T @ target)
    return Estimates(names, ("N/count", "N", "N/count"), values, covariance,
                     (Status.ESTIMATED,) * 3)  # fmt: skip


def test_it_counts_like_the_rows_behind_it() -> None:
    """The normal equations of both recordings at once are the closed form."""
    rng = np.random.default_rng(1)
    first, second = rng.normal(size=(20, 3)), rng.normal(size=(15, 3))
    y1, y2 = rng.normal(size=20), rng.normal(size=15)
    both = known_noise(np.vstack([first, second]), np.concatenate([y1, y2]))
    found = with_earlier([known_noise(second, y2)], known_noise(first, y1))
    assert found.shared == both.names
    np.testing.assert_allclose(found.estimates[0].values, both.values, atol=1e-9)
    np.testing.assert_allclose(found.estimates[0].covariance, both.covariance, atol=1e-9)


def test_scale_and_zero_of_a_raw_converter_are_recovered_consistently() -> None:
    """Nearly collinear at 8 million counts: only the joint covariance keeps the load right."""
    rng = np.random.default_rng(2)
    pulls, loads, narrower = [], [], []
    reading = np.array([(15.0 - _TRUTH[1]) / _TRUTH[0], 1.0])
    for _ in range(200):
        earlier, now = calibrated(rng, _LOAD), calibrated(rng, _LOAD)
        found = with_earlier([now], earlier)
        if found.p < 1e-3:
            continue
        one = found.estimates[0]
        pulls.append((one.values - _TRUTH) / one.sd)
        sd = np.sqrt(reading @ one.covariance @ reading)
        loads.append(float((reading @ one.values - 15.0) / sd))
        narrower.append(one.sd / now.sd)
    assert len(loads) >= 195
    rms = np.sqrt(np.mean(np.square(pulls), axis=0))
    assert np.all((rms > 0.85) & (rms < 1.15)), rms
    assert 0.85 < float(np.sqrt(np.mean(np.square(loads)))) < 1.15
    # two recordings of one kind: half the variance
    assert np.mean(narrower) == pytest.approx(np.sqrt(0.5), rel=0.05)


def test_what_an_earlier_cell_says_of_another_moves_it_too() -> None:
    rng = np.random.default_rng(3)
    first, second = calibrated(rng, _LOAD, "a"), calibrated(rng, _LOAD, "b")
    sd = np.array([first.sd[0], second.sd[0]])
    joint = np.outer(sd, sd) * np.array([[1.0, 0.99], [0.99, 1.0]])
    earlier = Estimates(
        ("a.scale", "b.scale"), ("N/count",) * 2,
        np.array([first.values[0] + sd[0], second.values[0]]), joint, (Status.ESTIMATED,) * 2,
    )  # fmt: skip
    alone = Estimates(
        ("a.scale",), ("N/count",), earlier.values[:1], joint[:1, :1], (Status.ESTIMATED,)
    )
    moved = with_earlier([first, second], earlier).estimates[1].values[0] - second.values[0]
    assert abs(moved) > 0.1 * sd[1]
    assert with_earlier([first, second], alone).estimates[1].values[0] == second.values[0]


def test_a_changed_cell_differs_by_more_than_chance() -> None:
    rng = np.random.default_rng(4)
    earlier, now = calibrated(rng, _LOAD), calibrated(rng, _LOAD)
    shift = np.array([0.0, 10.0]) * earlier.sd
    assert with_earlier([now], earlier).p > 1e-3
    assert with_earlier([now], replace(earlier, values=earlier.values + shift)).p < 1e-6


def test_calibrations_from_arrays_count_together() -> None:
    rng = np.random.default_rng(6)
    counts = [(_LOAD - _TRUTH[1]) / _TRUTH[0] + 2500.0 * rng.normal(size=25) for _ in range(2)]
    first, second = (calibrate.weights("a", _LOAD, c).estimates for c in counts)
    both = calibrate.weights("a", _LOAD, counts[1]).counted_with(first)
    np.testing.assert_allclose(both.sd**-2, first.sd**-2 + second.sd**-2, rtol=0.05)
    moved = replace(first, values=first.values + np.array([0.0, 10.0]) * first.sd)
    with pytest.raises(FitError, match="more than chance"):
        calibrate.weights("a", _LOAD, counts[1]).counted_with(moved)


@pytest.mark.parametrize("what", ["unit", "apart", "name"])
def test_what_is_not_shared_is_left_alone(what: str) -> None:
    rng = np.random.default_rng(5)
    earlier, now = calibrated(rng, _LOAD), calibrated(rng, _LOAD)
    if what == "unit":
        earlier = replace(earlier, units=("N/mV", "kN"))
    elif what == "name":
        earlier = replace(earlier, names=("b.scale", "b.bias"))
    found = with_earlier([now], earlier, earlier.names if what == "apart" else ())
    assert found.shared == ()
    assert found.estimates == (now,)
