"""What an error shares with the readings, and with L̇, measured from cycle to cycle of a gait."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from footcal_cli.core.experiments.contract import Balance, Experiment
from footcal_cli.core.inference.exogenous import shared_with_inputs
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

HZ, CYCLE, CYCLES = 80.0, 96, 120
ARM_M = 0.05
N = CYCLE * CYCLES
LEVERS = np.tile([ARM_M, -ARM_M], (1, 1, 1))


def _slow(rng: np.random.Generator, sd: float) -> FloatArray:
    """Noise below the third harmonic of the gait."""
    course = sosfiltfilt(butter(4, 1.5 * HZ / CYCLE, fs=HZ, output="sos"), rng.normal(size=N))
    return np.asarray(sd * course / course.std())


def _fast(rng: np.random.Generator, sd: float) -> FloatArray:
    """Noise above the sixth."""
    high = butter(4, 7.0 * HZ / CYCLE, "highpass", fs=HZ, output="sos")
    course = sosfiltfilt(high, rng.normal(size=N))
    return np.asarray(sd * course / course.std())


def _walk(felt_nm: FloatArray, error_nm: FloatArray, rate_nm: FloatArray) -> tuple[Log, Experiment]:
    """One foot of two cells: a moment that repeats, what cells feel, what the demand has wrong."""
    phase = 2.0 * np.pi * np.arange(N) / CYCLE
    repeats = np.sin(phase) + 0.5 * np.cos(3.0 * phase)
    half = 0.5 * (repeats + felt_nm) / ARM_M
    log = Log(
        "cells",
        ("left_a", "left_b"),
        np.arange(N) / HZ,
        np.column_stack([40.0 + half, 40.0 - half]),
        {
            "contact": (np.arange(N) % CYCLE < 60)[:, None].astype(float),
            "angmom_rate_nm": np.column_stack([rate_nm, np.zeros(N)]),
            "demanded_nm": repeats + error_nm,
        },
        np.arange(N) // CYCLE,
    )

    def balance(one: Log) -> Balance:
        moment = ARM_M * (one.readings[:, 0] - one.readings[:, 1])
        error = moment - one.known["demanded_nm"] - one.known["angmom_rate_nm"][:, 0]
        return Balance(("mx",), ("Nm",), error[:, None], np.ones((N, 1), dtype=bool))

    return log, Experiment("walk", {}, balance, ())


def _shared(
    felt_nm: FloatArray, error_nm: FloatArray, rate_nm: FloatArray
) -> tuple[FloatArray, FloatArray]:
    log, experiment = _walk(felt_nm, error_nm, rate_nm)
    found = shared_with_inputs(experiment, log, experiment.balance(log), LEVERS)
    return found[0][:, 0], found[1][:, 0]


def test_a_sole_that_lies_off_moves_readings_and_noise_of_an_acceleration_does_not() -> None:
    rng = np.random.default_rng(1)
    felt, demand = _slow(rng, 0.1), _fast(rng, 0.3)
    of_readings, of_turning = _shared(felt, demand, np.zeros(N))
    assert np.std(of_readings - felt) < 0.25 * felt.std()
    assert np.std(of_turning) < 0.1 * demand.std()


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_what_remains_of_the_readings_is_free_of_the_error(ratio: float) -> None:
    """Both slow: b = s²/(s² + d²) of variances s² felt and d² of the demand; the rest is least."""
    rng = np.random.default_rng(2)
    felt, demand = _slow(rng, 0.1), _slow(rng, 0.1 * ratio)
    error = felt - demand
    of_readings, _ = _shared(felt, demand, np.zeros(N))
    b = float(of_readings @ error / (error @ error))
    # of some 3 harmonics of 120 cycles
    assert b == pytest.approx(1.0 / (1.0 + ratio**2), abs=0.1)
    left = felt - of_readings
    assert abs(np.corrcoef(left, error)[0, 1]) < 0.15 < abs(np.corrcoef(felt, error)[0, 1])


def test_a_noisy_rate_of_angular_momentum_is_known_by_its_cycles() -> None:
    rng = np.random.default_rng(3)
    noise = _fast(rng, 0.2)
    of_readings, of_turning = _shared(_slow(rng, 0.1), np.zeros(N), noise)
    assert np.std(of_turning + noise) < 0.2 * noise.std()
    assert np.std(of_readings) < 1.3 * 0.1


def test_without_a_gait_all_is_the_readings() -> None:
    rng = np.random.default_rng(4)
    felt = _slow(rng, 0.1)
    log, experiment = _walk(felt, np.zeros(N), np.zeros(N))
    still = log.with_known(contact=np.ones((N, 1)))
    balance = experiment.balance(still)
    of_readings, of_turning = shared_with_inputs(experiment, still, balance, LEVERS)
    np.testing.assert_array_equal(of_readings, balance.error)
    assert not of_turning.any()


def test_noise_of_loads_reaches_a_moment_over_the_place_of_the_foot() -> None:
    """Four cells on two feet 0.2 m beside the CoP: independent noise σ gives Σ σ² y² in all."""
    rng = np.random.default_rng(5)
    levers = np.array([0.2 + ARM_M, 0.2 - ARM_M, -0.2 + ARM_M, -0.2 - ARM_M])
    noise = np.column_stack([_slow(rng, 0.3) for _ in levers])
    demand = np.column_stack([_slow(rng, 0.3), _slow(rng, 0.05)])
    # the load shifts between the feet from cycle to cycle, and the demand knows it
    carried = 40.0 + _slow(rng, 4.0)[:, None] * np.sign(levers)
    log = Log(
        "cells",
        ("left_a", "left_b", "right_a", "right_b"),
        np.arange(N) / HZ,
        carried + noise,
        {
            "contact": (np.arange(N) % CYCLE < 60)[:, None].astype(float) * np.ones(2),
            "angmom_rate_nm": np.zeros((N, 2)),
        },
        np.arange(N) // CYCLE,
    )
    rows = np.stack([np.ones(4), levers])

    def balance(one: Log) -> Balance:
        error = (one.readings - carried) @ rows.T - demand
        return Balance(("fz", "mx"), ("N", "Nm"), error, np.ones((N, 2), dtype=bool))

    experiment = Experiment("walk", {}, balance, ())
    of_readings, _ = shared_with_inputs(experiment, log, balance(log), rows[None])
    for k, own in enumerate(demand.T):
        felt = noise @ rows[k]
        error = felt - own
        b = float(of_readings[:, k] @ error / (error @ error))
        assert b == pytest.approx(np.var(felt) / (np.var(felt) + np.var(own)), abs=0.1)
