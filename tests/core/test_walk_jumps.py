"""A cell that jumps once in a walk is named, where and when; what comes and goes is not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from footcal_cli.core.diagnosis.investigation import Investigation, investigate
from footcal_cli.core.diagnosis.jumps import Jump, at_rest
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.plots.diagnosis.jump import channel_of, in_words, plot_jump
from tests.core.test_diagnosis_bridge import ROBOT, Hidden, names, walk_case

DURATION_S = 45.0
CYCLE_S = 1.5
"""A cell is seen at rest once in each gait cycle."""


def drawn(seed: int) -> tuple[str, float, float]:
    """A cell, the size of its jump (N, of cells that carry 20 N) and its moment (s)."""
    rng = np.random.default_rng([seed, 7])
    size = rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 3.0)
    return str(rng.choice(ROBOT.channels)), size, rng.uniform(0.15, 0.85) * DURATION_S


def jump(cell: str, size_n: float, at_s: float) -> Hidden:
    return (
        "bias_jump", {cell: (cell,)}, {f"{cell}.bias_jump": size_n, f"{cell}.jump_time": at_s}
    )  # fmt: skip


@cache
def diagnosed(seed: int) -> Investigation:
    """A walk in which the cell of `drawn` jumps."""
    hidden = jump(*drawn(seed))
    return investigate(walk_case(seed, hidden, duration_s=DURATION_S), TABLE, describe)


@pytest.mark.parametrize(
    ("seeds", "low", "high"),
    # chi-squared of so many: 99 % of RMS errors lie in between, in sd; of one it has no lower end
    [([1], 0.0, 2.58), pytest.param(range(6), 0.34, 1.76, marks=pytest.mark.slow)],
)
def test_a_jump_is_named_with_its_cell_its_moment_and_an_interval_that_holds(
    seeds: Sequence[int], low: float, high: float
) -> None:
    errors = []
    for seed in seeds:
        cell, size, at = drawn(seed)
        found = diagnosed(seed)
        assert found.verdict == "named"
        assert names(found) == {"bias_jump"}
        (item,) = found.found
        assert item.owner == cell
        assert item.placed["jump_time"] == pytest.approx(at, abs=CYCLE_S)
        stated = item.cause.size
        errors.append((stated.value - size) / ((stated.high - stated.low) / (2 * 1.96)))
    assert low < np.sqrt(np.mean(np.square(errors))) < high


def test_what_settles_after_a_jump_is_small_beside_it_and_another_jump_is_not() -> None:
    jump = Jump(1e-20, after_s=27.0, before_s=28.0, size=20.0)
    settling = Jump(1e-4, after_s=31.0, before_s=32.0, size=4.0)
    assert settling.is_small_beside(jump, 0.25)
    assert not replace(settling, size=6.0).is_small_beside(jump, 0.25)


@pytest.mark.slow
def test_a_jump_that_settles_is_named_all_the_same() -> None:
    """A fifth of it comes within seconds: no form of the table, and nothing else that jumps."""
    cell, size, at = drawn(1)
    case = walk_case(1, None, duration_s=DURATION_S)
    (log,) = case.logs
    since = log.time_s - log.time_s[0] - at
    readings = log.readings.copy()
    moved = np.where(since >= 0.0, size * (1.0 - 0.2 * np.exp(-np.maximum(since, 0.0) / 3.0)), 0.0)
    readings[:, ROBOT.channels.index(cell)] += moved / case.values[f"{cell}.scale"]
    found = investigate(replace(case, logs=(replace(log, readings=readings),)), TABLE, describe)
    assert names(found) == {"bias_jump"}
    assert found.found[0].owner == cell


@pytest.mark.slow
@pytest.mark.parametrize("seed", [20, 21])
def test_a_cable_that_comes_and_goes_is_no_jump(seed: int) -> None:
    cell, size, _ = drawn(seed)
    case = walk_case(seed, None, duration_s=DURATION_S)
    (log,) = case.logs
    since = log.time_s - log.time_s[0]
    readings = log.readings.copy()
    pulled = (since > 15.0) & (since < 23.0)
    readings[pulled, ROBOT.channels.index(cell)] += size / ROBOT.scale_n_per_count
    found = investigate(replace(case, logs=(replace(log, readings=readings),)), TABLE, describe)
    assert "bias_jump" not in names(found)
    assert found.verdict in ("unknown", "named+unknown")


def test_the_figure_shows_the_cell_that_jumped() -> None:
    """Means of swings lie on two levels without the jump in the model, and on one with it."""
    cell, size, at = drawn(1)
    found = diagnosed(1)
    levels = []
    for problem in (found.problem, found.final):
        time_s, mean, unit = at_rest(problem, channel_of(found))
        after = time_s - found.case.logs[0].time_s[0] > at
        levels.append(mean[after].mean() - mean[~after].mean())
        assert unit == "N"
    # zeros wander by 0.01 N in a second, as a random walk: by 0.05 N in half a minute
    assert levels == pytest.approx([size, 0.0], abs=0.15)
    assert cell in in_words(found)
    assert plot_jump(found).axes
