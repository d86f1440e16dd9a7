"""What happens once in a walk: a cell that dies in one step, somebody who holds the robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.investigation import investigate
from footcal_cli.core.diagnosis.odd_spell import OddSpell, odd_spell
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.parameters import BoolArray, FloatArray
from tests.core.test_diagnosis_bridge import ROBOT, walk_case

DIES = "left_rl"


def looked_at(case: Case) -> OddSpell | None:
    return odd_spell(case, problem_from(case, rows_of(case), [], describe))


def changed(case: Case, rows: BoolArray, share: FloatArray) -> Case:
    """The loads of rows times a share of each cell, shape (c,)."""
    (log,) = case.logs
    scale = np.array([case.values[f"{c}.scale"] for c in ROBOT.channels])
    zero = np.array([case.values[f"{c}.bias"] for c in ROBOT.channels])
    force = log.readings * scale + zero
    force[rows] *= share
    return replace(case, logs=(replace(log, readings=(force - zero) / scale),))


def carried(case: Case) -> tuple[FloatArray, FloatArray]:
    """Stamps since the first, and what the cell that dies carries."""
    (log,) = case.logs
    at = ROBOT.channels.index(DIES)
    force = log.readings[:, at] * case.values[f"{DIES}.scale"] + case.values[f"{DIES}.bias"]
    return log.time_s - log.time_s[0], force


def dead_in_one_step(seed: int) -> tuple[Case, float, float]:
    """A walk in which a cell reads no load in a step in its middle, and when that is."""
    case = walk_case(seed, None)
    since, force = carried(case)
    middle = np.abs(since - 31.0) < 3.0
    at = float(since[middle][np.argmax(force[middle])])
    rows = np.abs(since - at) < 0.3
    dead = np.array([0.0 if c == DIES else 1.0 for c in ROBOT.channels])
    return changed(case, rows, dead), at - 0.3, at + 0.3


@pytest.mark.parametrize(
    "seed", [1, pytest.param(2, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)]
)
def test_a_cell_that_dies_in_one_step_is_found_with_its_time(seed: int) -> None:
    case, start_s, end_s = dead_in_one_step(seed)
    found = looked_at(case)
    assert found is not None
    assert found.silent
    assert found.channel == DIES
    assert found.start_s == pytest.approx(start_s, abs=0.3)
    assert found.end_s == pytest.approx(end_s, abs=0.3)
    assert found.finding.code == "dead_cell"
    assert investigate(case, TABLE, describe).verdict == "bad-data"


@pytest.mark.parametrize(
    "seed", [1, 2, pytest.param(3, marks=pytest.mark.slow), pytest.param(4, marks=pytest.mark.slow)]
)
def test_a_walk_like_others_has_no_odd_spell(seed: int) -> None:
    assert looked_at(walk_case(seed, None)) is None
    hidden = ("hysteresis", {"all": ROBOT.channels}, {"all.hysteresis_width": 1.5})
    assert looked_at(walk_case(seed, hidden)) is None


def test_a_robot_that_is_held_is_no_dead_cell() -> None:
    case = walk_case(1, None)
    since, _ = carried(case)
    held = changed(case, np.abs(since - 30.0) < 0.6, np.full(len(ROBOT.channels), 0.7))
    found = looked_at(held)
    assert found is not None
    assert not found.silent
    assert found.output == "fz"
    assert found.finding.code == "odd_spell"
    assert found.off < -0.2 * ROBOT.mass_kg * 9.81


def test_a_spell_of_sensors_whose_zeros_are_not_tracked_is_of_no_channel() -> None:
    """As of transducers: it has a time, and no cell whose force would explain it."""
    case, start_s, _ = dead_in_one_step(1)
    gains = tuple(way for way in case.directions if way.kind != "bias")
    found = looked_at(replace(case, directions=gains))
    assert found is None or (not found.silent and abs(found.start_s - start_s) < 3.0)
