"""Errors of a running recording that last as long as a load stands on the cell."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core.bench.channel import fit_channel
from footcal_cli.core.bench.law_of_noise import with_law_of_noise
from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.study import study_samples
from footcal_cli.core.parameters import FloatArray

LOADS_N = (0.0, 5.0, 10.0, 20.0, 10.0, 5.0, 0.0, 10.0, 20.0, 0.0)
ROWS, SCALE = 25, 5e-4


def recorded(
    seed: int, of_load_n: float, white_n: float = 0.01, drift_n: float = 0.0, rows: int = ROWS
) -> BenchRecord:
    """Rows of 1 s under each load: an error of the load, white noise, and a random walk."""
    rng = np.random.default_rng([seed, 61])
    load = np.repeat(LOADS_N, rows)
    error = np.repeat(of_load_n * rng.standard_normal(len(LOADS_N)), rows)
    error += white_n * rng.standard_normal(load.size)
    error += drift_n * np.cumsum(rng.standard_normal(load.size))
    time_s = np.arange(float(load.size))
    return BenchRecord("x", load, (load + error) / SCALE, time_s, np.zeros(load.size, np.int64))


def pulls(records: Iterable[BenchRecord]) -> tuple[FloatArray, FloatArray]:
    """Errors of the scale in their sd, and their degrees of freedom."""
    fits = [fit_channel(with_law_of_noise(record)) for record in records]
    error = [(fit.linear[0] - SCALE) / np.sqrt(fit.linear_covariance[0, 0]) for fit in fits]
    return np.array(error), np.array([fit.dof[0] for fit in fits])


def test_a_scale_is_as_sure_as_loads_repeat_and_not_as_rows_do() -> None:
    error, dof = pulls(recorded(seed, 0.2) for seed in range(60))
    # ten loads less two coefficients
    assert np.median(dof) == pytest.approx(8.0, abs=0.1)
    covered = np.mean(np.abs(error) < stats.t.isf(0.025, dof))
    low, high = stats.binom.ppf(np.array([0.005, 0.995]), 60, 0.95) / 60
    assert low <= covered <= high
    # the mean square of Student's t of eight degrees is 8 / 6
    assert 0.75 < np.sqrt(np.mean(np.square(error)) * 6.0 / 8.0) < 1.35


def test_white_noise_is_no_error_of_loads() -> None:
    assert sum(with_law_of_noise(recorded(seed, 0.0)).renewed for seed in range(40)) <= 2


def test_a_zero_that_walks_is_covered_by_either_law() -> None:
    error, dof = pulls(recorded(seed, 0.0, drift_n=0.02) for seed in range(60))
    covered = np.mean(np.abs(error) < stats.t.isf(0.025, dof))
    assert covered >= stats.binom.ppf(0.005, 60, 0.95) / 60


def shown(zero_n: FloatArray) -> BenchRecord:
    """Ten loads of 20 s at 10 Hz under a zero that moves."""
    record = recorded(7, 0.0, rows=200)
    time_s = record.time_s / 10.0
    return BenchRecord("x", record.load_n, record.reading + zero_n / SCALE, time_s, record.session)


TIME_S = np.arange(2000) / 10.0


@pytest.mark.parametrize(
    ("zero_n", "model"),
    [
        (3.0 * np.exp(-TIME_S / 50.0), "warm-up"),
        (2.0 * (TIME_S >= 87.3), "bias jump"),
        (0.01 * TIME_S, "bias drift"),
    ],
    ids=["warm_up", "jump", "drift"],
)
def test_a_zero_that_moves_is_followed_and_leaves_the_scale_alone(
    zero_n: FloatArray, model: str
) -> None:
    study = study_samples(shown(zero_n))
    assert study.model == model
    scale, sd = study.estimates.values[0], study.estimates.sd[0]
    assert abs(scale - SCALE) < 3.5 * sd
    assert sd < 1e-3 * SCALE


def test_the_largest_load_is_predicted_from_the_others() -> None:
    """Twice the range of all others and more: a term in the model sets no limit there."""
    record = shown(0.01 * TIME_S)
    loads = np.where(record.load_n == 20.0, 80.0, record.load_n)
    far = BenchRecord("x", loads, record.reading + (loads - record.load_n) / SCALE,
                      record.time_s, record.session)  # fmt: skip
    ladder = study_samples(far).ladder
    assert ladder is not None
    assert ladder.model == "bias drift"
    assert ladder.held_out.rmse < 0.05


@pytest.mark.parametrize(
    ("late", "unequal"),
    [
        (0.0, False),
        (1.0, True),
        pytest.param(0.0, True, marks=pytest.mark.slow),
        pytest.param(1.0, False, marks=pytest.mark.slow),
    ],
)
def test_when_a_load_was_changed_in_a_pause_is_learnt(late: float, *, unequal: bool) -> None:
    """A creep of 2 % and 25 s in pauses of 4 s; where all are alike, it is one with its size."""
    rng = np.random.default_rng(9)
    pause = 4.0 * (rng.uniform(0.3, 1.7, len(LOADS_N)) if unequal else np.ones(len(LOADS_N)))
    starts = np.cumsum(12.0 + pause)
    fine_s = np.arange(0.0, starts[-1] + 12.0, 0.1)
    loads = np.array([0.0, *LOADS_N])
    row = np.searchsorted(starts, fine_s, side="right")
    load = loads[np.searchsorted(starts - (1.0 - late) * pause, fine_s, side="right")]
    slow, share = np.zeros(load.size), 1.0 - np.exp(-0.1 / 25.0)
    for k in range(1, load.size):
        slow[k] = slow[k - 1] + share * (load[k - 1] - slow[k - 1])
    kept = fine_s - np.array([0.0, *starts])[row] < 12.0
    force = (load + 0.02 * slow + 1e-3 * rng.standard_normal(load.size))[kept]
    none = np.zeros(force.size, np.int64)
    study = study_samples(BenchRecord("x", loads[row][kept], force / SCALE, fine_s[kept], none))
    assert study.model.startswith("creep")
    scale, sd = study.estimates.values[0], study.estimates.sd[0]
    assert abs(scale - SCALE) < max(3.0 * sd, 2e-4 * SCALE)
    assert sd < (2e-4 if unequal else 2e-3) * SCALE
