"""The joint hanging fit: truth, bound, coverage, order, drift, subsets of orientations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from footcal_cli.core.hang.effect import HangResidual
from footcal_cli.core.hang.intake import hang_log
from footcal_cli.core.hang.joint import HangFit, HangOptions, fit_hang
from footcal_cli.core.hang.model import HangModel
from footcal_cli.core.hang.runs import blocked, hang_runs
from footcal_cli.core.inference.fit import numeric_jacobian
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, Status
from footcal_cli.errors import DataError
from tests.core.six_axis_data import (
    AXES,
    COM_M,
    FOUR_WAYS,
    LEGS,
    TABLE_2,
    WEIGHT_N,
    Array,
    Hanging,
    com_m,
    hang,
)


def truth(fit: HangFit, hanging: Hanging, leg: int, com: Array = COM_M) -> Array:
    """True values in the order of the estimates."""
    known = {f"offset_{axis}": value for axis, value in zip(AXES, TABLE_2[leg], strict=True)}
    known["weight"] = WEIGHT_N[leg]
    for axis, row in zip("xyz", com, strict=True):
        known |= {
            f"com_{axis}_{t}": v
            for t, v in zip(("mean", "sin", "cos", "sin2", "cos2"), row, strict=False)
        }
    tilt = np.einsum("li,lij->lj", hanging.turn_rad, fit.model.tilt_basis).ravel()
    known |= dict(zip(fit.model.tilt_names(), tilt, strict=True))
    return np.array([known[name.split(".")[1]] for name in fit.estimates.names])


@pytest.mark.parametrize("tilt", ["per_log", "mount", "base", "none"])
@pytest.mark.parametrize("extra", [False, True])
def test_the_jacobian_is_the_derivative_of_the_experiments_residual(tilt: str, extra: bool) -> None:
    rng = np.random.default_rng(1)
    model = HangModel(
        "hl", FOUR_WAYS, 2, "mount" if tilt == "base" else tilt, temperature=extra, drift=extra,  # type: ignore[arg-type]  # parametrised literal
        level_t=rng.normal(size=(len(FOUR_WAYS), 3, 2)) if tilt == "base" else None,
    )  # fmt: skip
    size = len(model.tilt_names()) + 7 + 12 * extra + 3 * model.com_columns
    theta = rng.normal(size=size)
    assert len(model.parameters(6.0)) == size
    coefficients = HangResidual.of(model).coefficients
    numeric = numeric_jacobian(lambda t: coefficients(t).ravel(), theta, np.full(size, 1e-6))
    analytic = model.coefficient_jacobian(theta).reshape(numeric.shape)
    np.testing.assert_allclose(analytic, numeric, atol=1e-7)


def test_noiseless_logs_give_back_the_truth_exactly_at_large_tilt() -> None:
    hanging = hang(
        np.random.default_rng(2), tilt_rad=0.2, exact_tilt=True, force_sd=1e-9, torque_sd=1e-9
    )
    fit = fit_hang(hanging.logs, HangOptions(white=True))
    np.testing.assert_allclose(fit.estimates.values, truth(fit, hanging, 0), atol=1e-9)


@dataclass(frozen=True)
class Study:
    """Errors of many fits in parameter units and in units of their claimed sd."""

    error: Array
    standard: Array
    bound: Array


def study(seeds: int, memory_s: float, rows: int = 2000, *, white: bool = False) -> Study:
    errors, standard, bounds = [], [], []
    for seed in range(seeds):
        leg = seed % 6
        hanging = hang(np.random.default_rng([7, seed]), leg, rows=rows, memory_s=memory_s)
        fit = fit_hang(hanging.logs, HangOptions(white=white, order=1 if white else None))
        assert fit.model.order == 1, "evidence must find the true number of harmonics"
        error = fit.estimates.values - truth(fit, hanging, leg)
        errors.append(error)
        standard.append(error / fit.estimates.sd)
        bounds.append(cramer_rao_sd(hanging, fit, truth(fit, hanging, leg), memory_s))
    return Study(np.array(errors), np.array(standard), np.array(bounds))


def cramer_rao_sd(hanging: Hanging, fit: HangFit, theta: Array, memory_s: float) -> Array:
    """``sqrt diag (Σ Jᵀ Γ⁻¹ J)⁻¹`` at the truth with the true noise, sample by sample."""
    size = theta.size
    information = np.zeros((size, size))
    slopes = fit.model.coefficient_jacobian(theta)
    rate_hz = 1.0 / (hanging.logs[0].time_s[1] - hanging.logs[0].time_s[0])
    rho = np.exp(-1.0 / (rate_hz * memory_s)) if memory_s else 0.0
    sd = np.array([0.1] * 3 + [0.01] * 3)
    for log, slope in zip(hanging.logs, slopes, strict=True):
        phase = log.known["phase_rad"]
        z = np.stack([np.ones_like(phase), np.sin(phase), np.cos(phase)], axis=1)
        seen = np.vstack([z[:1], (z[1:] - rho * z[:-1]) / np.sqrt(1.0 - rho**2)])
        for channel in range(6):
            j = seen @ slope[channel] / sd[channel]
            information += j.T @ j
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(information))))


@pytest.mark.parametrize(
    ("memory_s", "seeds"),
    [
        pytest.param(0.0, 240, marks=pytest.mark.slow),
        pytest.param(2.0, 240, marks=pytest.mark.slow),
        (2.0, 60),
    ],
)
def test_error_reaches_the_bound_and_intervals_cover(memory_s: float, seeds: int) -> None:
    result = study(seeds, memory_s)
    ratio = np.sqrt(np.mean((result.error / result.bound) ** 2, axis=0))
    # 3.28 sd of an rms of so many errors: 15 % of 240
    assert ratio.max() < 1.0 + 3.28 / np.sqrt(2.0 * seeds), dict(enumerate(ratio.round(3)))
    covered = np.mean(np.abs(result.standard) < 1.96)
    assert 0.93 <= covered <= 0.97


@pytest.mark.slow
def test_counting_every_sample_as_independent_covers_too_little() -> None:
    covered = np.mean(np.abs(study(40, 2.0, white=True).standard) < 1.96)
    assert covered < 0.75


def test_slow_noise_is_counted_by_its_memory() -> None:
    hanging = hang(np.random.default_rng(3), rows=10_000, rate_hz=50.0, memory_s=2.0)
    fit = fit_hang(hanging.logs)
    np.testing.assert_allclose(fit.effective_samples, 4 * 200.0 / (2 * 2.0), rtol=0.35)


def test_evidence_finds_a_second_harmonic_and_its_coefficients() -> None:
    com = np.column_stack([COM_M, [[0.002, 0.0], [0.0, 0.001], [0.0, 0.003]]])
    hanging = hang(np.random.default_rng(4), com=com)
    fit = fit_hang(hanging.logs)
    assert fit.model.order == 2
    standard = (fit.estimates.values - truth(fit, hanging, 0, com)) / fit.estimates.sd
    assert np.abs(standard).max() < 4.5
    phase = np.linspace(0.0, 6.0, 9)
    assert np.abs(fit.com_t_m(phase) - com_m(phase, com)).max() < 5 * fit.com_sd_m(phase).max()


def test_wald_evidence_orders_like_refitting() -> None:
    hanging = hang(np.random.default_rng(5), rows=300)
    fit = fit_hang(hanging.logs)
    refitted = {
        order: (lambda f: f.fit.residuals @ f.fit.residuals)(
            fit_hang(hanging.logs, HangOptions(order=order, noise_sd=None))
        )
        for order in (1, 2, 3)
    }
    n = np.log(fit.effective_samples.sum())
    wald = fit.evidence[1] - fit.evidence[2] + 6 * n
    assert wald >= 0.0
    assert set(fit.evidence) == {0, 1, 2, 3}
    assert refitted[3] > 0.0


def test_temperature_and_drift_terms_are_found_and_needed() -> None:
    hanging = hang(np.random.default_rng(6), temperature_slope=0.05)
    plain = fit_hang(hanging.logs)
    warm = fit_hang(hanging.logs, HangOptions(temperature=True))
    slopes = warm.values.temperature_bias
    sd = np.array([warm.estimates.sd_of(f"hl.temperature_bias_{axis}") for axis in AXES])
    assert np.abs((slopes - 0.05) / sd).max() < 4.0
    assert abs(warm.reference_temperature_degc - 25.5) < 1.0
    error_plain = abs(plain.values.weight_n - WEIGHT_N[0])
    assert abs(warm.values.weight_n - WEIGHT_N[0]) < 0.2 * error_plain

    drifting = fit_hang(hang(np.random.default_rng(7)).logs, HangOptions(drift=True))
    sd = np.array([drifting.estimates.sd_of(f"hl.offset_drift_{axis}") for axis in AXES])
    assert np.abs(drifting.values.offset_drift / sd).max() < 4.0


def test_one_pair_says_that_the_com_along_gravity_is_unknown() -> None:
    hanging = hang(np.random.default_rng(8), directions=FOUR_WAYS[:2])
    fit = fit_hang(hanging.logs, HangOptions(order=1))
    assert any("CoM along x" in sentence and "second axis" in sentence for sentence in fit.gaps)
    status = dict(zip(fit.estimates.names, fit.estimates.status, strict=True))
    assert status["hl.com_x_mean"] is Status.PRIOR_KEPT
    assert status["hl.com_y_sin"] is Status.ESTIMATED
    assert fit.estimates.sd_of("hl.com_x_mean") > 20 * fit.estimates.sd_of("hl.com_y_sin")
    assert abs(fit.values.weight_n - WEIGHT_N[0]) < 5 * fit.estimates.sd_of("hl.weight")


def test_one_orientation_says_that_weight_and_offset_are_one() -> None:
    hanging = hang(np.random.default_rng(9), directions=FOUR_WAYS[2:3])
    fit = fit_hang(hanging.logs, HangOptions(order=1, tilt="none"))
    assert any("one orientation only" in sentence for sentence in fit.gaps)
    status = dict(zip(fit.estimates.names, fit.estimates.status, strict=True))
    assert status["hl.weight"] is Status.PRIOR_KEPT
    assert status["hl.offset_fz"] is Status.PRIOR_KEPT
    assert status["hl.offset_fx"] is Status.ESTIMATED
    assert any("weight" in s and "offset_fz" in s for s in fit.gaps if "not seen" in s)


def test_four_ways_leave_no_gap() -> None:
    assert fit_hang(hang(np.random.default_rng(10)).logs).gaps == ()


def test_three_orientations_suffice_less_exactly() -> None:
    rng = np.random.default_rng(11)
    four = hang(rng)
    fit_four = fit_hang(four.logs)
    fit_three = fit_hang(four.logs[:3])
    assert not any("not seen" in s for s in fit_three.gaps)
    assert fit_three.estimates.sd_of("hl.weight") > fit_four.estimates.sd_of("hl.weight")
    assert abs(fit_three.values.weight_n - 6.2) < 5 * fit_three.estimates.sd_of("hl.weight")


def test_wrist_sensor_with_a_tool_in_many_orientations() -> None:
    standard = []
    for seed in range(20):
        rng = np.random.default_rng([12, seed])
        directions = rng.normal(size=(24, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        turn = np.tile(0.03 * rng.normal(size=3), (24, 1))
        hanging = hang(rng, directions=directions, rows=5, cycles=0.0, turn_rad=turn)
        fit = fit_hang(hanging.logs, HangOptions(tilt="mount"))
        assert fit.model.order == 0
        assert fit.model.tilt_names() == ("mount_rot_x", "mount_rot_y", "mount_rot_z")
        assert fit.gaps == ()
        arm = com_m(np.array([0.3]))[0]
        expected = np.concatenate([[WEIGHT_N[0]], TABLE_2[0], arm, -turn[0]])
        standard.append((fit.estimates.values - expected) / fit.estimates.sd)
    assert 0.88 < np.mean(np.abs(standard) < 1.96) < 0.99
    assert 0.8 < np.sqrt(np.mean(np.square(standard))) < 1.2


@pytest.mark.parametrize("seeds", [20, pytest.param(40, marks=pytest.mark.slow)])
def test_single_rows_per_orientation_still_have_honest_intervals(seeds: int) -> None:
    standard = []
    for seed in range(seeds):
        rng = np.random.default_rng([13, seed])
        directions = rng.normal(size=(15, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        turn = np.zeros((15, 3))
        hanging = hang(rng, directions=directions, rows=1, cycles=0.0, turn_rad=turn)
        fit = fit_hang(hanging.logs, HangOptions(tilt="mount"))
        expected = np.concatenate([[WEIGHT_N[0]], TABLE_2[0], com_m(np.array([0.3]))[0], [0] * 3])
        standard.append((fit.estimates.values - expected) / fit.estimates.sd)
    assert 0.88 < np.mean(np.abs(standard) < 1.96) < 0.99


@pytest.mark.parametrize("extra", [False, True])
def test_the_experiments_balance_is_the_estimators_residual(extra: bool) -> None:
    """Read off at a few rows, it is that of every row of the logs."""
    logs = hang(np.random.default_rng(14), temperature_slope=0.05).logs
    fit = fit_hang(logs, HangOptions(temperature=extra, drift=extra))
    runs, _ = hang_runs(logs)
    tables = HangResidual.of(fit.model).coefficients(fit.estimates.values)
    for run, error, table in zip(runs, fit.residuals(runs), tables, strict=True):
        z = fit.model.regressors(
            run.phase_rad, run.temperature_degc - fit.reference_temperature_degc,
            run.time_s - fit.reference_time_s,
        )  # fmt: skip
        np.testing.assert_allclose(error, run.wrench - z @ table.T, atol=1e-12)


def test_logs_of_different_legs_and_broken_readings_are_refused() -> None:
    rng = np.random.default_rng(15)
    with pytest.raises(ValueError, match="one leg"):
        fit_hang([*hang(rng, 0, rows=50).logs, *hang(rng, 1, rows=50).logs])
    log = hang(rng, rows=50).logs[0]
    broken = log.readings.copy()
    broken[3, 2] = np.nan
    with pytest.raises(ValueError, match="not numbers"):
        fit_hang([log.with_readings(broken)])
    assert LEGS[0] == "hl"


def _held(seed: int, holds: int, drift: FloatArray) -> tuple[FloatArray, HangFit]:
    """Errors in units of their sd after holds whose levels differ, and the fit."""
    offset, com, weight_n = (
        np.array([3.1, -7.4, 12.2, 0.12, -0.33, 0.05]),
        [2e-3, -4e-3, 0.061],
        9.1,
    )
    rng = np.random.default_rng(seed)
    down = rng.normal(size=(holds, 3))
    down = np.repeat(down / np.linalg.norm(down, axis=1, keepdims=True), 60, axis=0)
    force = weight_n * down
    wrench = np.hstack([force, np.cross(com, force)]) + offset
    wrench += np.array([0.2] * 3 + [4e-3] * 3) * rng.normal(size=wrench.shape)
    wrench += np.repeat(drift * rng.normal(size=(holds, 6)), 60, axis=0)
    time_s = np.arange(len(wrench)) / 50.0
    log = hang_log("wrist", time_s, np.zeros_like(time_s), wrench, down, leg_weight_n=9.0)
    fit = fit_hang([log], HangOptions(tilt="none"))
    truth = np.concatenate([[weight_n], offset, com])
    return (fit.estimates.values[: truth.size] - truth) / fit.estimates.sd[: truth.size], fit


def test_levels_that_differ_from_hold_to_hold_are_in_the_intervals() -> None:
    """Slow drift is constant within a hold: its noise there says nothing of it."""
    drift = np.array([0.1] * 3 + [3e-3] * 3)
    scores, fits = zip(*(_held(seed, 18, drift) for seed in range(12)), strict=True)
    # without it every error would be three to six sd
    assert 0.8 < np.sqrt(np.mean(np.square(scores))) < 1.25
    np.testing.assert_allclose(np.mean([f.level_sd for f in fits], axis=0), drift, rtol=0.2)


@pytest.mark.parametrize("seeds", [30, pytest.param(60, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("times", "least", "most"), [(0.0, 0.85, 1.15), (1.5, 0.85, 1.2)])
def test_levels_that_hardly_differ_are_in_the_intervals_too(
    times: float, least: float, most: float, seeds: int
) -> None:
    """Four holds; without levels an error would be 1.8 sd where they add 1.5 times its noise."""
    drift = times * np.array([0.2] * 3 + [4e-3] * 3) / np.sqrt(60.0)
    scores = [_held(seed, 4, drift)[0] for seed in range(seeds)]
    assert least < np.sqrt(np.mean(np.square(scores))) < most


def test_rows_out_of_order_are_no_thousand_orientations() -> None:
    rng = np.random.default_rng(0)
    down = rng.choice([-1.0, 1.0], 3000)[:, None] * np.array([1.0, 0.0, 0.0])
    log = hang_log(
        "fl", np.arange(3000.0), np.zeros(3000), np.zeros((3000, 6)), down, leg_weight_n=6.0
    )
    with pytest.raises(DataError, match=r"leg fl changes [\d,]+ times in 3,000 rows"):
        fit_hang([log])


def test_an_axis_that_shows_nothing_ends_in_a_fit() -> None:
    """A wire of one channel is off: its harmonics have no variance at all."""
    off = np.array([0.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    logs = hang(np.random.default_rng(9)).logs
    dead = [log.with_readings(log.readings * off) for log in logs]
    assert np.isfinite(fit_hang(dead).estimates.values).all()


@pytest.mark.parametrize(
    ("travel", "blocks"),
    [
        ("ten turns", 4 * 10),  # whole turns
        ("one turn", 4 * 4),  # too few to name anything: quarters
        ("to and fro", 4 * 4),
        ("still", 4),
    ],
)
def test_legs_that_turn_little_are_cut_into_quarters_of_a_turn(travel: str, blocks: int) -> None:
    share = np.linspace(0.0, 1.0, 400)
    moved = {
        "ten turns": 20.01 * np.pi * share,
        "one turn": 2.01 * np.pi * share,
        "to and fro": 0.55 * np.pi * np.sin(2.0 * np.pi * share),
        "still": np.zeros(400),
    }[travel]
    phase = np.angle(np.exp(1j * (moved + np.random.default_rng(1).normal(0.0, 1e-3, 400))))
    names = tuple(f"fl.{axis}" for axis in AXES)
    rows = np.zeros(400, dtype=np.int64)
    legs: dict[str, list[Log]] = {"fl": []}
    for i, down in enumerate(np.vstack([np.eye(3)[[0, 2]], -np.eye(3)[[0, 2]]])):
        known = {
            "phase_rad": phase, "gravity_dir": np.tile(down, (400, 1)),
            "leg_weight_n": np.zeros(400),
        }  # fmt: skip
        time_s = 60.0 * i + 30.0 * share
        legs["fl"].append(Log("hang", names, time_s, np.zeros((400, 6)), known, rows))
    (log,), in_order = blocked(legs)
    assert in_order
    assert np.unique(log.block).size == blocks
