"""What a cell remembers of one ladder of weights when the next begins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.regressors import design_of, model_of
from footcal_cli.core.bench.study import Asked, study_samples
from footcal_cli.core.bench.terms import effect_term, hysteresis
from footcal_cli.core.effects.memory_effects import BIAS_DRIFT, CREEP
from footcal_cli.core.parameters import FloatArray


@pytest.mark.parametrize(("pause_s", "kept"), [(20.0, True), (86_400.0, False)])
def test_a_loop_goes_on_into_a_ladder_that_follows_at_the_same_pace(
    pause_s: float, kept: bool
) -> None:
    ladder = np.array([0.0, 8.0, 16.0, 8.0, 0.0])
    load, n = np.tile(ladder, 2), len(ladder)
    time_s = 20.0 * np.arange(2 * n) + np.repeat([0.0, pause_s - 20.0], n)
    session = np.repeat([0, 1], n)
    record = BenchRecord("a", load, load.copy(), time_s, session)
    (term,) = hysteresis(16.0).terms
    shown = term.phi(load, record, np.array([2.0]))
    # a loop 1 N wide lies half of it below the load on the way up, above it on the way down
    first = 0.5 * np.array([0.0, -1.0, -1.0, 1.0, 1.0])
    np.testing.assert_allclose(shown[:n], first)
    second = np.r_[0.5 if kept else 0.0, first[1:]]
    np.testing.assert_allclose(shown[n:], second)


def test_a_search_over_two_grids_makes_each_column_once_and_the_same() -> None:
    load = np.repeat([0.0, 8.0, 16.0, 8.0, 0.0], 6)
    record = BenchRecord("a", load, load.copy(), 5.0 * np.arange(30.0), np.zeros(30, np.int64))
    plain, made = (effect_term(CREEP), effect_term(BIAS_DRIFT, ((0.01, 0.03, 0.1),))), []

    def counted(number: int, loads: FloatArray, at: BenchRecord, shapes: FloatArray) -> FloatArray:
        made.append((number, *shapes))
        return plain[number].phi(loads, at, shapes)

    terms = tuple(
        replace(term, phi=lambda *given, i=i: counted(i, *given)) for i, term in enumerate(plain)
    )
    model = model_of(record, load, terms)
    grids = [len(term.grids[0]) for term in plain]
    assert len(model.starts) == grids[0] * grids[1]
    between = model.starts[1] + 0.1
    for at in (*model.starts, between, *model.starts, between):
        np.testing.assert_array_equal(model.design(at), design_of(record, load, plain, at))
    assert len(made) == sum(grids) + 2 * len(plain)  # between the grids nothing is remembered


def test_a_long_recording_keeps_its_creep() -> None:
    """Means over a share of eight hours would average a creep of a minute out of its first rows."""
    rng = np.random.default_rng(5)
    load = np.repeat(np.tile([0.0, 20.0, 40.0, 60.0, 40.0, 20.0], 8), 600)
    crept = lfilter([1 - np.exp(-1 / 60)], [1, -np.exp(-1 / 60)], load)  # at 1 Hz
    reading = (load + 0.003 * crept + 0.002 * rng.normal(size=load.size) + 5.0) / 3e-5
    time, one = np.arange(load.size, dtype=float), np.zeros(load.size, dtype=np.int64)
    study = study_samples(BenchRecord("cell", load, reading, time, one), Asked(most_degree=1))
    assert study.model == "creep"
    found = dict(zip(study.estimates.names, study.estimates.values, strict=True))
    assert found["cell.creep"] == pytest.approx(0.003, rel=0.03)
    assert found["cell.creep_time"] == pytest.approx(60.0, rel=0.03)
