"""Cutting poses out of a stand-still log."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from footcal_cli.core.pose.steady import (
    SteadyRule,
    StretchVerdict,
    force_rate_nps,
    medians,
    steady_stretches,
    why_no_pose,
)
from footcal_cli.intake.legs import steady_frames
from tests.core.six_axis_data import Array

RATE_HZ = 100.0


def staircase(hold_s: list[float], noise_n: float = 0.0) -> tuple[Array, Array]:
    """Forces that hold a level, then move to the next within 0.5 s."""
    level, pieces = 0.0, []
    for duration in hold_s:
        pieces.append(np.full(round(duration * RATE_HZ), level))
        pieces.append(level + 5.0 * (1 - np.cos(np.linspace(0, np.pi, 50))) / 2)
        level += 5.0
    force = np.concatenate(pieces[:-1])
    time_s = np.arange(force.size) / RATE_HZ
    rng = np.random.default_rng(1)
    both = np.zeros((force.size, 2, 3))
    both[:, 0, 2] = force
    return time_s, both + noise_n * rng.normal(size=both.shape)


def test_derivative_of_a_ramp_is_its_slope() -> None:
    time_s = np.arange(500) / RATE_HZ
    force = np.zeros((500, 2, 3))
    force[:, 1] = time_s[:, None] * np.array([1.0, 2.0, 2.0])
    np.testing.assert_allclose(force_rate_nps(time_s, force, 0.5), 3.0)


def test_keeps_holds_and_says_why_the_rest_goes() -> None:
    time_s, force = staircase([3.0, 1.0, 2.5, 4.0], noise_n=0.01)
    stretches = steady_stretches(time_s, force)
    still = [s for s in stretches if s.verdict is not StretchVerdict.MOVING]
    assert [s.verdict for s in still] == [
        StretchVerdict.KEPT,
        StretchVerdict.TOO_SHORT,
        StretchVerdict.KEPT,
        StretchVerdict.KEPT,
    ]
    assert stretches[0].start == 0
    assert stretches[-1].stop == time_s.size
    assert all(a.stop == b.start for a, b in pairwise(stretches))
    assert 0.0 < still[1].duration_s < 1.0


@pytest.mark.parametrize(("holds_s", "sway_n"), [([0.9, 1.2], 0.0), ([4.0, 4.0], 5.0)])
def test_what_would_take_the_quietest_part_takes_it(holds_s: list[float], sway_n: float) -> None:
    time_s, force = staircase(holds_s, noise_n=0.01)
    force[..., 2] += sway_n * np.sin(2 * np.pi * 0.8 * time_s)[:, None]
    assert not len(medians(force, steady_stretches(time_s, force)))
    why, remedy = why_no_pose(time_s, force, SteadyRule())
    assert "(from " in why
    name, value = remedy.rsplit("set steady_", 1)[1].split(" = ")
    eased = replace(SteadyRule(), **{name: float(value)})
    assert len(medians(force, steady_stretches(time_s, force, eased)))


def test_median_represents_the_pose_and_ignores_a_spike() -> None:
    time_s, force = staircase([3.0, 3.0])
    stretches = steady_stretches(time_s, force)
    spiked = force.copy()
    spiked[100, 0, 2] += 50.0
    middle = medians(spiked, stretches)
    np.testing.assert_allclose(middle[:, 0, 2], [0.0, 5.0], atol=0.05)


def test_noisy_sensors_need_a_longer_window() -> None:
    time_s, force = staircase([4.0, 4.0], noise_n=0.3)
    kept = [
        sum(s.verdict is StretchVerdict.KEPT for s in steady_stretches(time_s, force, rule))
        for rule in (SteadyRule(window_s=0.2), SteadyRule(window_s=1.2))
    ]
    assert kept == [0, 2]


def test_streams_without_a_pose_give_none() -> None:
    frames, rejected, notes = steady_frames([], ("fl", "fr"), (1.0, 1.5, 0.5))
    assert frames.keys.size == 0
    assert not rejected
    assert not notes
