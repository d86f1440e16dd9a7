"""Full matrices of sensors loaded on many channels at once, and changes since last time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.bench.changes import find_parameter_changes
from footcal_cli.core.bench.matrix import fit_matrix, study_matrix
from footcal_cli.core.experiments.weights import balance
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import Estimates, FloatArray, IntArray, Status
from footcal_cli.errors import FitError

CELLS = ("left_fl", "left_fr", "left_rl", "left_rr")
AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
BRIDGES = tuple(f"bridge_{i}" for i in range(6))


def cells_together(
    rng: np.random.Generator, crosstalk: float, cases: int = 24
) -> tuple[FloatArray, FloatArray, IntArray, FloatArray]:
    """Counts, loads, load case of each row, true matrix; three repeats of every case."""
    mixing = np.eye(4) + crosstalk * rng.uniform(0.5, 1.5, (4, 4)) * (1 - np.eye(4))
    loads = np.repeat(rng.uniform(0, 20, (cases, 4)) * (rng.random((cases, 4)) < 0.6), 3, axis=0)
    scale = -3.4e-5 * (1 + 0.02 * rng.normal(size=4))
    counts = (loads @ mixing.T + 0.03 * rng.normal(size=loads.shape) - 280.0) / scale
    truth = np.linalg.inv(mixing) * scale
    return counts, loads, np.repeat(np.arange(cases), 3), truth


def test_crosstalk_is_recovered_and_preferred_only_where_it_is() -> None:
    for crosstalk, expected in ((0.0, True), (0.02, False)):
        for seed in range(4):
            counts, loads, case, truth = cells_together(np.random.default_rng(seed), crosstalk)
            block = np.zeros(len(loads), dtype=np.int64)
            study = study_matrix(CELLS, counts, CELLS, loads, block, case)
            assert study.chosen.diagonal is expected
            error = (study.full.matrix - truth).ravel()
            sd = study.full.estimates.sd.reshape(4, 5)[:, :4].ravel()
            assert np.abs(error / sd).max() < 4.5
            assert np.abs(error / np.abs(np.diag(truth)).mean()).max() < 0.003


def test_six_axis_sensor_intervals_cover_and_the_covariance_is_joint() -> None:
    rng = np.random.default_rng(0)
    truth = rng.normal(size=(6, 6)) * 1e-3 + np.diag(np.full(6, 5e-3))
    wrench = rng.uniform(-1, 1, (60, 6)) * [40, 40, 80, 4, 4, 4]
    session = np.repeat(np.arange(4), 15)
    inverse = np.linalg.inv(truth)
    hits, runs, scores = 0.0, 60, []
    for _ in range(runs):
        reading = wrench @ inverse.T + rng.normal(size=(60, 6)) * 2.0
        fit = fit_matrix(BRIDGES, reading, AXES, wrench, session, units=("N",) * 3 + ("Nm",) * 3)
        values = np.column_stack([truth, np.zeros(6)]).ravel()
        hits += float(np.mean((fit.ci95[:, 0] < values) & (values < fit.ci95[:, 1])))
        row = slice(0, 7)
        error = fit.estimates.values[row] - values[row]
        scores.append(error @ np.linalg.solve(fit.estimates.covariance[row, row], error) / 7)
    assert hits / runs == pytest.approx(0.95, abs=0.025)
    assert np.mean(scores) == pytest.approx(1.0, abs=0.35)
    assert fit.estimates.units[:7] == ("N/count",) * 6 + ("N",)
    assert np.all(np.linalg.eigvalsh(fit.estimates.covariance) > -1e-12)


def test_predictions_carry_their_sd_and_flag_extrapolation() -> None:
    rng = np.random.default_rng(1)
    counts, loads, _, _ = cells_together(rng, 0.02)
    fit = fit_matrix(CELLS, counts, CELLS, loads, np.zeros(len(loads), dtype=np.int64))
    found, sd, beyond = fit.predict(counts)
    assert np.std((found - loads) / sd) == pytest.approx(1.0, abs=0.1)
    assert not beyond.any()
    assert fit.predict(counts * 1.05)[2].all()


def test_loads_in_too_few_directions_are_refused() -> None:
    rng = np.random.default_rng(2)
    counts, loads, _, _ = cells_together(rng, 0.02)
    together = np.repeat(counts[:, :1], 4, axis=1)
    with pytest.raises(FitError, match="1 of 4 combinations"):
        fit_matrix(CELLS, together, CELLS, loads, np.zeros(len(loads), dtype=np.int64))
    dead = counts.copy()
    dead[:, 2] = 8e6
    with pytest.raises(FitError, match="left_rl"):
        fit_matrix(CELLS, dead, CELLS, loads, np.zeros(len(loads), dtype=np.int64))


def test_changes_are_counted_in_units_of_their_sd() -> None:
    names = ("left_rr.scale", "left_rr.bias", "left_fl.scale")
    now = Estimates(
        names, ("N/count", "N", "N/count"), np.array([0.969, 2.0, 1.0]),
        np.diag([1e-4, 0.04, 1e-4]), (Status.ESTIMATED,) * 3,
    )  # fmt: skip
    before = Estimates(
        (*names, "gone.scale"), ("N/count", "N", "lbf/count", "N/count"),
        np.array([1.0, 1.0, 2.2, 1.0]), np.diag([0.01, 0.1, 0.1, 0.1]) ** 2,
        (Status.ESTIMATED,) * 4,
    )  # fmt: skip
    first, second = find_parameter_changes(now, before)
    assert (first.name, second.name) == ("left_rr.bias", "left_rr.scale")
    assert second.in_earlier_sd == pytest.approx(-3.1)
    assert second.in_joint_sd == pytest.approx(-3.1 / np.sqrt(2))
    assert second.sentence("12 May") == "left_rr scale −3.1 sd since 12 May"
    assert first.p_value == pytest.approx(2 * 7.74e-6, rel=0.02)  # Holm: two compared


def test_shifts_by_chance_are_not_called_changes() -> None:
    rng = np.random.default_rng(3)
    names = tuple(f"cell_{i}.scale" for i in range(8))
    alarms = 0
    for _ in range(400):
        old, new = 1.0 + 0.01 * rng.normal(size=8), 1.0 + 0.02 * rng.normal(size=8)
        now = Estimates(names, ("N/count",) * 8, new, np.eye(8) * 4e-4, (Status.ESTIMATED,) * 8)
        before = replace(now, values=old, covariance=np.eye(8) * 1e-4)
        alarms += any(change.p_value < 0.05 for change in find_parameter_changes(now, before))
    assert alarms / 400 == pytest.approx(0.05, abs=0.025)


def test_weights_balance_is_reading_minus_load_and_skips_unknown_loads() -> None:
    load = np.array([[0.0, 5.0], [np.nan, 5.0]])
    log = Log("weights", CELLS[:2], np.zeros(2), np.array([[0.5, 5.0], [1.0, 4.0]]),
              {"load_n": load}, np.zeros(2, dtype=np.int64))  # fmt: skip
    found = balance(log)
    np.testing.assert_allclose(found.error[0], [0.5, 0.0])
    assert found.valid.tolist() == [[True, True], [False, True]]


def test_two_rows_are_refused_and_a_column_without_errors_is_correlated_with_none() -> None:
    readings = np.array([[1.0, 5.0], [3.0, 2.0], [4.0, 9.0], [6.0, 7.0]])
    loads = np.column_stack([np.zeros(4), readings[:, 1] ** 2])
    session = np.zeros(4, dtype=np.int64)
    with pytest.raises(FitError, match="2 rows"):
        fit_matrix(("a", "b"), readings[:2], ("a", "b"), loads[:2], session[:2], diagonal=True)
    fit = fit_matrix(("a", "b"), readings, ("a", "b"), loads, session, diagonal=True)
    assert fit.noise == pytest.approx(np.eye(2))


def test_a_load_that_never_changes_is_refused() -> None:
    """It gave a scale of zero: a calibration by which no reading would tell a force."""
    counts, loads, case, _ = cells_together(np.random.default_rng(1), 0.0)
    loads[:, 3] = 0.0
    with pytest.raises(FitError, match="left_rr never changes"):
        study_matrix(CELLS, counts, CELLS, loads, np.zeros(len(loads), dtype=np.int64), case)
