"""The width of a hysteresis loop: what is stated, and how far it depends on the loop's form."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from footcal_cli.core.effects.memory import play
from footcal_cli.core.effects.memory_effects import LOOP_FORM_ERROR, loop_width
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

Form = Callable[[FloatArray, float], FloatArray]


def log_of(readings: FloatArray) -> Log:
    rows = np.zeros(readings.size, dtype=np.int64)
    return Log("weights", ("a",), np.arange(float(readings.size)), readings[:, None], {}, rows)


def width(load: FloatArray, added: FloatArray) -> float:
    return float(loop_width(log_of(load), log_of(load + added))[0])


def stop(load: FloatArray, reach: float) -> FloatArray:
    """Share of the yield force of one slider, −1 … 1."""
    still = np.zeros(load.size, dtype=bool)
    return (load - play(load[:, None], np.array([reach]), np.zeros(1), still)[:, 0]) / reach


def _integrated(load: FloatArray, slope: Callable[[float, float], float]) -> FloatArray:
    out, state = np.zeros_like(load), 0.0
    for i in range(1, load.size):
        step = (load[i] - load[i - 1]) / 8.0
        for _ in range(8):
            state += step * slope(state, step)
        out[i] = state
    return out


def dahl(load: FloatArray, reach: float) -> FloatArray:
    """Dahl's solid friction (1968), exponent 1."""
    return _integrated(load, lambda z, step: (1.0 - np.sign(step) * z) / reach)


def bouc_wen(load: FloatArray, reach: float) -> FloatArray:
    """Wen (1976), exponent 1."""
    return _integrated(load, lambda z, step: (1.0 - abs(z) * (z * step > 0)) / reach)


def maxwell_slip(load: FloatArray, reach: float) -> FloatArray:
    """Twenty sliders that yield one after the other (Iwan, 1966)."""
    return np.asarray(np.mean([stop(load, r) for r in reach * np.linspace(0.05, 2.0, 20)], axis=0))


def ladder(rng: np.random.Generator) -> FloatArray:
    rungs = np.sort(np.concatenate([[0.0, 1.0], rng.uniform(0.06, 0.94, rng.integers(4, 8))]))
    return np.tile(np.repeat(np.concatenate([rungs, rungs[-2::-1]]), 5), 2)


def gait(rng: np.random.Generator) -> FloatArray:
    phase = 2.0 * np.pi * np.arange(0.0, 12.0, 0.02) / 1.1
    load = np.sin(phase) + 0.25 * np.sin(2.0 * phase + rng.uniform(0, 6)) + 0.2
    load = np.clip(load, 0.0, None) * (1.0 + 0.1 * np.sin(0.3 * phase))
    return np.asarray(load / load.max())


def fitted_play(load: FloatArray, added: FloatArray) -> FloatArray:
    """Least squares of a play, scale and bias refitted beside it."""
    basis = np.linalg.qr(np.column_stack([load, np.ones_like(load)]))[0]

    def left(x: FloatArray) -> FloatArray:
        return np.asarray(x - basis @ (basis.T @ x))

    wanted, best, found = left(added), np.inf, added
    for reach in np.geomspace(0.02, 0.6, 30):
        column = stop(load, reach)
        own = left(column)
        size = own @ wanted / (own @ own)
        loss = float(np.sum((wanted - size * own) ** 2))
        if loss < best:
            best, found = loss, size * column
    return found


def test_a_play_has_the_width_it_is_given_where_loads_open_it() -> None:
    load = np.concatenate([np.linspace(0, 20, 200), np.linspace(20, 0, 200)])
    assert width(load, -0.25 * stop(load, 2.0)) == pytest.approx(0.5, rel=1e-6)


def test_a_loop_that_loads_do_not_open_has_the_width_they_open() -> None:
    """Loads of 0 … 6 N, reach 4 N: x/4 of the force rising, (x − 2)/4 falling, below 4 N."""
    load = np.concatenate([np.linspace(0, 6, 600), np.linspace(6, 0, 600)])
    assert width(load, -0.25 * stop(load, 4.0)) == pytest.approx(0.125, rel=1e-6)


def test_noise_turns_no_direction() -> None:
    rng = np.random.default_rng(0)
    load = np.tile(np.repeat(np.concatenate([np.arange(0, 21, 2), np.arange(18, -1, -2)]), 9), 3)
    seen = load + 0.05 * rng.normal(size=load.size)
    assert width(seen, -0.25 * stop(load, 2.0)) == pytest.approx(0.5, rel=0.03)


def test_loads_that_only_rise_have_no_loop() -> None:
    load = np.linspace(0.0, 20.0, 300)
    assert width(load, -0.25 * stop(load, 2.0)) == 0.0


def test_what_the_form_of_a_loop_does_to_the_width_stated() -> None:
    """Play fitted without noise to loops of other forms: how far off the widest loop is."""
    rng = np.random.default_rng(0)
    off = []
    for loads in (ladder, gait):
        for form in (dahl, bouc_wen, maxwell_slip):
            for _ in range(8):
                load = loads(rng)
                added = -0.5 * form(load, float(rng.uniform(0.05, 0.25)))
                off.append(width(load, fitted_play(load, added)) / width(load, added) - 1.0)
    rms = float(np.sqrt(np.mean(np.square(off))))
    assert rms == pytest.approx(LOOP_FORM_ERROR, abs=0.01)
    assert np.mean(np.abs(off) < 2.0 * LOOP_FORM_ERROR) >= 0.9


def test_a_loop_that_runs_ahead_has_a_width_below_zero() -> None:
    """What is added upward on the way up: over-compensated gauges, not friction."""
    load = ladder(np.random.default_rng(1))
    lags = -stop(load, 0.2)
    assert width(load, lags) == pytest.approx(-width(load, -lags))
    assert width(load, lags) > 0.5
