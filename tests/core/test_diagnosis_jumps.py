"""A cell in the air that jumps is seen; one that drifts, hums or is coarse is not taken for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.signal import lfilter

from footcal_cli.core.diagnosis.jumps import largest_jump
from footcal_cli.core.inference.lines import Traces
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray

CELLS, SWINGS, ROWS, RATE_HZ, CYCLE_S = 4, 50, 6, 20.0, 1.2
LEVEL = 0.1 * 0.02  # of a test among several


def walking(values: FloatArray, least: float = 0.0) -> Problem:
    """Four cells of one foot, six rows in the air in each step; values (SWINGS, ROWS, CELLS)."""
    time_s = (CYCLE_S * np.arange(SWINGS)[:, None] + np.arange(ROWS) / RATE_HZ).ravel()
    channel = np.repeat(np.arange(CELLS), time_s.size)
    residual = values.transpose(2, 0, 1).ravel()
    zeros = np.zeros(residual.size, dtype=np.int64)
    swing = np.repeat(np.arange(CELLS * SWINGS), ROWS)
    return Problem(
        residual=residual,
        calibration=np.eye(CELLS)[channel],
        columns=np.empty((residual.size, 0)),
        signatures=(),
        block=zeros,
        output=zeros,
        sequence=swing,
        outputs=("swing",),
        units=("N",),
        noise=np.ones(residual.size),
        tolerance=np.ones(1),
        rate_hz=RATE_HZ,
        drifts=True,
        least=np.array([least]),
        traces=Traces(np.tile(time_s, CELLS), channel, tuple("abcd")),
    )


def quiet(rng: np.random.Generator, family: str) -> FloatArray:
    """Noise within swings, and what wanders from swing to swing."""
    white = rng.normal(size=(SWINGS * ROWS, CELLS))
    if family == "coloured":
        white = lfilter([0.3], [1.0, -0.95], white, axis=0)
    wander = {"drifting": 0.5, "offsets": 0.0}.get(family, 0.0)
    walk = np.cumsum(wander * rng.normal(size=(SWINGS, 1, CELLS)), axis=0)
    fresh = 0.5 * rng.normal(size=(SWINGS, 1, CELLS)) if family == "offsets" else 0.0
    values = white.reshape(SWINGS, ROWS, CELLS) + walk + fresh
    return np.asarray(np.round(values / 3.0) * 3.0 if family == "coarse" else values)


@pytest.mark.parametrize("family", ["white", "coloured", "drifting", "offsets", "coarse"])
def test_what_wanders_is_no_jump(family: str) -> None:
    rng = np.random.default_rng(1)
    least = 3.0 / np.sqrt(12.0) if family == "coarse" else 0.0
    problems = [walking(quiet(rng, family), least) for _ in range(150)]
    p = np.array([largest_jump(problem, problem.residual).p for problem in problems])
    for level in (LEVEL, 0.05):
        assert np.sum(p < level) <= stats.binom.ppf(0.999, p.size, level)


@pytest.mark.parametrize("cells", [[2], [0, 1, 2, 3]])
def test_a_cable_that_pulls_in_three_spells_is_seen(cells: list[int]) -> None:
    rng = np.random.default_rng(2)
    pull = np.zeros((SWINGS, 1, CELLS))
    for start, stop in ((8, 13), (25, 30), (41, 44)):
        pull[start:stop, :, cells] = -4.0
    values = quiet(rng, "white") + pull
    problem = walking(values)
    assert largest_jump(problem, problem.residual).p < LEVEL


def test_channels_of_their_own_are_not_at_rest() -> None:
    """What is read all the time, a total force, is no cell in the air."""
    values = quiet(np.random.default_rng(3), "white")
    values[20:] += 5.0
    problem = walking(values)
    assert problem.traces is not None
    alone = Traces(problem.traces.time_s, 0 * problem.traces.channel, ("fz",))
    assert largest_jump(problem, problem.residual).p < LEVEL
    assert largest_jump(replace(problem, traces=alone), problem.residual).p == 1.0
    assert largest_jump(replace(problem, traces=None), problem.residual).p == 1.0
