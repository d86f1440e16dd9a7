"""Two streams whose seconds differ, of robots that walk straight on and of those that turn."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.body_stream import check_rates
from footcal_cli.core.parameters import FloatArray

STEP_S = 0.9


def walked(turn_radps: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Stamps, cells of two feet, and CoM with its acceleration, of a robot that turns as it goes.

    It sways once in two steps and bobs once in each: at half its pace a bob looks like a sway.
    """
    rng, time_s = np.random.default_rng(6), np.arange(0.0, 60.0, 0.01)
    sway = 2.0 * np.pi / (2.0 * STEP_S)
    heading = turn_radps * time_s
    aside, bob = np.sin(sway * time_s), np.sin(2.0 * sway * time_s)
    left = 0.03 * aside
    com = np.stack([-left * np.sin(heading), left * np.cos(heading), 0.3 + 0.003 * bob], axis=1)
    com[:, :2] += 0.02 * np.stack([np.cos(heading), np.sin(heading)], axis=1) * time_s[:, None]
    acc = np.gradient(np.gradient(com, time_s, axis=0), time_s, axis=0)
    share = 0.5 + 0.5 * np.clip(2.0 * aside, -1.0, 1.0)
    cells = 50.0 * np.stack([share, share, 1.0 - share, 1.0 - share], axis=1)
    cells += rng.normal(0.0, 0.2, cells.shape)
    return time_s, cells, np.concatenate([com, acc], axis=1)


@pytest.mark.parametrize("turn_radps", [0.0, 0.1, 0.2])
def test_a_robot_that_turns_has_one_clock(turn_radps: float) -> None:
    time_s, cells, motion = walked(turn_radps)
    assert check_rates(time_s, cells, time_s + 1e-4, motion, "walk") == []


def test_rows_of_one_table_have_one_clock() -> None:
    """Forces that look like half the pace of the motion, in a stance, are no clock's fault."""
    time_s, cells, motion = walked(0.0)
    motion[:, 2::3] = motion[:1, 2::3]
    slow = np.stack([np.interp(0.5 * time_s, time_s, cell) for cell in cells.T], axis=1)
    assert check_rates(time_s, slow, time_s + 1e-4, motion, "stand")[0].code == "rates_differ"
    assert check_rates(time_s, slow, time_s, motion, "stand") == []


@pytest.mark.parametrize("turn_radps", [0.0, 0.1])
@pytest.mark.parametrize("seconds", [0.5, 2.0])
def test_seconds_twice_as_long_are_found(turn_radps: float, seconds: float) -> None:
    time_s, cells, motion = walked(turn_radps)
    motion[:, 2::3] = motion[:1, 2::3]  # a level CoM: no bob stands in for a sway
    (found,) = check_rates(time_s / seconds, cells, time_s, motion, "walk")
    assert found.code == "rates_differ"
    assert f"seconds last {seconds:g} s" in found.sentence
