"""What recording does to readings, and what one piece of evidence is in standing."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.diagnosis.blocks import STANCES, cut_stances
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.recording import noise_of_smoothed, steps_of, swings_apart
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import rows_of
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.scores import scores
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import low_pass
from tests.core.test_diagnosis_bridge import walk_case

RATE_HZ = 100.0


def _log(time_s: FloatArray, readings: FloatArray, contact: FloatArray) -> Log:
    return Log(
        "stand", tuple(f"left_{i}" for i in range(readings.shape[1])), time_s, readings,
        {"contact": contact}, np.zeros(len(time_s), dtype=np.int64),
    )  # fmt: skip


def test_a_swing_is_smoothed_without_the_load_before_and_after_it() -> None:
    time_s = np.arange(400) / RATE_HZ
    # unloaded within 0.1 s, 1 N of offset in the air
    load = 20.0 * np.clip(np.abs(time_s - 2.0) / 0.1 - 5.0, 0.0, 1.0)[:, None]
    raw = load + 1.0
    contact = np.where(np.abs(time_s - 2.0) < 0.44, 0.0, 1.0)[:, None]
    air = contact[:, 0] == 0.0
    log = _log(time_s, low_pass(raw, RATE_HZ), contact)
    assert np.abs(log.readings[air] - 1.0).max() > 1e-3
    apart = swings_apart(log, raw, RATE_HZ)
    np.testing.assert_allclose(apart.readings[air], 1.0, atol=1e-9)
    np.testing.assert_array_equal(apart.readings[~air], log.readings[~air])


def test_what_smoothing_a_swing_by_itself_changes_runs_out_beside_it() -> None:
    rng = np.random.default_rng(5)
    time_s = np.arange(400) / RATE_HZ
    raw = 20.0 * np.clip(np.abs(time_s - 2.0) / 0.1 - 5.0, 0.0, 1.0)[:, None]
    raw = raw + rng.normal(0.0, 0.5, raw.shape)
    contact = np.select(
        [np.abs(time_s - 2.0) < 0.44, np.abs(time_s - 2.0) < 0.52], [0.0, np.nan], 1.0
    )
    whole = low_pass(raw, RATE_HZ)
    apart = swings_apart(_log(time_s, whole, contact[:, None]), raw, RATE_HZ).readings
    air, stance = np.flatnonzero(contact == 0.0), contact == 1.0
    np.testing.assert_array_equal(apart[stance], whole[stance])
    for edge, beside in ((air[0], air[0] - 1), (air[-1], air[-1] + 1)):
        step = abs(float(apart[edge, 0] - whole[edge, 0]))
        added = (apart - apart[edge]) - (whole - whole[edge])
        assert abs(float(added[beside, 0])) < 0.2 * step


def test_the_step_of_a_converter_is_seen_in_its_levels() -> None:
    rng = np.random.default_rng(1)
    load = rng.normal(0.0, 2.0, (3000, 2))
    raw = np.column_stack([np.round(load[:, 0] / 0.3) * 0.3, load[:, 1]])
    coarse, fine = steps_of(raw)
    assert coarse == pytest.approx(0.3, rel=1e-6)
    assert fine < 1e-3


def test_noise_under_load_is_measured_where_readings_move() -> None:
    rng = np.random.default_rng(2)
    time_s = np.arange(6000) / RATE_HZ
    load = 10.0 * np.sin(2 * np.pi * 0.8 * time_s)[:, None]
    noise = rng.normal(0.0, 0.4, (time_s.size, 1))
    raw = load + noise
    found = noise_of_smoothed(raw, low_pass(raw, RATE_HZ), RATE_HZ)[0]
    assert found == pytest.approx(float(low_pass(noise, RATE_HZ).std()), rel=0.15)


def test_loads_of_a_quick_gait_are_no_noise_of_readings() -> None:
    """Half a second per step: double support passes the load in 0.15 s, above the cut-off too."""
    rng = np.random.default_rng(4)
    time_s = np.arange(6000) / RATE_HZ
    load = 10.0 * np.clip(5.0 * np.abs(2.0 * (time_s % 1.0) - 1.0) - 2.0, 0.0, 1.0)
    # as far as a foot's own spring and damper round it
    load = np.convolve(load, np.hanning(9) / np.hanning(9).sum(), mode="same")[:, None]
    for sd in (0.02, 0.2):
        noise = rng.normal(0.0, sd, (time_s.size, 1))
        found = noise_of_smoothed(load + noise, low_pass(load + noise, RATE_HZ), RATE_HZ)[0]
        assert found == pytest.approx(float(low_pass(noise, RATE_HZ).std()), rel=0.25)


def _stances(count: int, seconds: float) -> Log:
    """Stances with a pause of 2 s between them, the second foot lifted in every other one."""
    n = int(seconds * RATE_HZ)
    time_s = np.concatenate([i * (seconds + 2.0) + np.arange(n) / RATE_HZ for i in range(count)])
    contact = np.ones((count * n, 2))
    for i in range(1, count, 2):
        contact[i * n : (i + 1) * n, 1] = 0.0
        contact[i * n : i * n + 6, 1] = np.nan  # where the detection cannot tell yet
    readings = np.repeat(np.arange(count, dtype=float), n)[:, None]
    return _log(time_s, readings, contact)


def test_a_stance_is_one_piece_of_evidence() -> None:
    log = cut_stances(_stances(STANCES + 2, 7.0))
    counted = log.at(log.block >= 0)
    np.testing.assert_array_equal(counted.block, counted.readings[:, 0])
    assert set(counted.block) == set(range(STANCES + 2))
    assert np.isin(counted.known["contact"], [0.0, 1.0]).all()


def test_few_long_stances_are_cut_further() -> None:
    assert cut_stances(_stances(2, 31.0)).block.max() + 1 == 20


@pytest.mark.slow
def test_neighbouring_blocks_of_a_walk_are_independent() -> None:
    """Lag-one correlation of block scores; of B independent ones about their mean it is −1/B."""
    excess = []
    for seed in range(4):
        case = walk_case(seed, duration_s=45.0)
        problem = problem_from(case, rows_of(case), TABLE.values(), describe)
        grams, _ = whitened_grams(problem, problem.columns[:, :0])
        found = scores(grams.inner, grams.calibration, grams.candidates).score
        found = found[np.any(found != 0.0, axis=1)]
        found = found[:, np.any(found != 0.0, axis=0)]
        assert len(found) >= 20
        left = found - found.mean(axis=0)
        lagged = np.sum(left[1:] * left[:-1], axis=0) / np.sum(left**2, axis=0)
        excess.append(float(lagged.mean()) + 1.0 / len(found))
    # sd 1/√B of each; candidates that look alike count as a dozen
    assert np.mean(excess) == pytest.approx(0.0, abs=3.0 / np.sqrt(4 * 12 * 20))


def test_a_lag_shows_next_to_nothing_while_a_foot_swings() -> None:
    """A swing that began with a step of its cells would outweigh all touch-downs."""
    case = walk_case(3)
    rows = rows_of(case)
    problem = problem_from(case, rows, [TABLE["sensor_lag"]], describe)
    swing = problem.output == problem.outputs.index("swing")
    for column in problem.columns.T:
        standing = float(np.abs(column[~swing] * problem.noise[~swing]).max())
        assert float(np.abs(column[swing] * problem.noise[swing]).max()) < 0.1 * standing
