"""Loose contacts of hanging legs: found where they were made, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.checks.intermittent import (
    check_loose_cells,
    check_spells,
    find_spells,
    loose_axes,
    spells_of,
    steps_of_axes,
)
from footcal_cli.core.parameters import BoolArray, FloatArray

N = 1500


def turning(rng: np.random.Generator, noise: str) -> FloatArray:
    """A force of a leg that turns once, with the noise of a sensor."""
    force = 4.0 * np.sin(np.linspace(0.0, 2.0 * np.pi, N) + rng.uniform(0.0, 6.0))
    white = rng.normal(0.0, 0.03, N)
    if noise == "slow":
        white = np.convolve(white, np.ones(20) / 20.0, mode="same") * 3.0
    if noise == "long-tailed":
        white = 0.02 * rng.standard_t(4.0, N)
    if noise == "coarse":
        return np.round((force + white) / 0.2) * 0.2
    return np.asarray(force + white)


def lost(rng: np.random.Generator, spells: int) -> BoolArray:
    """Samples of spells of 3 to 20 samples, apart from each other."""
    found = np.zeros(N, dtype=bool)
    for start in rng.choice(np.arange(20, N - 40, 60), spells, replace=False):
        found[start : start + rng.integers(3, 21)] = True
    return found


def _of_one(reading: FloatArray, away: BoolArray) -> tuple[FloatArray, BoolArray]:
    """A leg all of whose axes are one."""
    return np.tile(reading[:, None], 6), np.tile(away[:, None], 6)


@pytest.mark.parametrize("noise", ["white", "slow", "long-tailed", "coarse"])
@pytest.mark.parametrize("seed", range(5))
def test_spells_are_found_to_the_sample(seed: int, noise: str) -> None:
    rng = np.random.default_rng([71, seed])
    away = lost(rng, 8)
    reading = turning(rng, noise) - 4.0 * away
    np.testing.assert_array_equal(find_spells(reading, None, 0.2 * (noise == "coarse")), away)


@pytest.mark.parametrize("noise", ["white", "slow", "long-tailed", "coarse"])
def test_no_noise_is_a_loose_contact(noise: str) -> None:
    wrenches = [
        np.stack([turning(np.random.default_rng([72, seed, axis]), noise) for axis in range(6)], 1)
        for seed in range(40)
    ]
    for wrench in wrenches:
        assert check_spells("fl", wrench, spells_of(wrench)) == []


def test_a_coarse_converter_that_flickers_between_three_values_has_no_loose_contact() -> None:
    """A leg of 200 N, hung two ways, on steps of 0.7 N under noise of 0.2 N."""
    rng = np.random.default_rng(75)
    hung = [
        np.round((side * np.full((N, 6), 200.0) + rng.normal(0.0, 0.2, (N, 6))) / 0.7) * 0.7
        for side in (-1.0, 1.0)
    ]
    steps = steps_of_axes(np.concatenate(hung))
    np.testing.assert_allclose(steps, 0.7)
    assert not any(spells_of(one, None, steps).any() for one in hung)
    away = lost(rng, 8)
    broken = hung[0] - 20.0 * 0.7 * away[:, None]
    np.testing.assert_array_equal(spells_of(broken, None, steps)[:, 2], away)


def test_a_leg_that_is_turned_from_hold_to_hold_and_back_has_no_loose_contact() -> None:
    rng = np.random.default_rng(73)
    held = np.repeat(np.tile([0.0, 0.6], 15), N // 30)
    reading = 3.0 * np.cos(held) + rng.normal(0.0, 0.03, N)
    assert loose_axes(*_of_one(reading, find_spells(reading)))[0]
    assert not find_spells(reading, held[:, None] + rng.normal(0.0, 1e-4, (N, 1))).any()
    # an attitude that came in every other sample
    seldom = held[:, None] + rng.normal(0.0, 1e-4, (N, 1))
    seldom[1::2] = np.nan
    assert not find_spells(reading, seldom).any()


def test_what_moves_for_several_samples_has_no_loose_contact() -> None:
    """A leg that rests, moves within five samples to another posture, and comes back."""
    rng = np.random.default_rng(76)
    posture = np.convolve(np.repeat(np.tile([0.0, 1.0], 15), N // 30), np.ones(5) / 5.0, "same")
    assert not find_spells(3.0 * posture + rng.normal(0.0, 0.01, N))[5:-5].any()


def test_a_spell_at_either_end_is_found_and_a_touch_is_no_finding() -> None:
    rng = np.random.default_rng(74)
    away = np.zeros(N, dtype=bool)
    away[:7] = away[700:709] = away[-5:] = True
    reading = turning(rng, "white") + 3.0 * away
    reading[50] = np.nan
    np.testing.assert_array_equal(find_spells(reading), away)
    away[:7] = False
    assert not loose_axes(*_of_one(reading, away))[0]
    assert not find_spells(reading[:40]).any()


def test_the_finding_says_which_axis_how_often_and_how_far() -> None:
    rng = np.random.default_rng(75)
    wrench = np.stack([turning(rng, "white") for _ in range(6)], 1)
    away = lost(rng, 5)
    wrench[away, 4] -= 2.5
    (finding,) = check_spells("fl", wrench, spells_of(wrench))
    assert (finding.code, finding.where) == ("intermittent_contact", "fl")
    assert finding.sentence.startswith("ty: 5 times")
    assert " Nm, " in finding.sentence
    assert check_spells("fl", wrench, np.zeros(wrench.shape, dtype=bool)) == []


def test_slow_noise_that_goes_on_elsewhere_after_each_pause_is_no_loose_contact() -> None:
    """A tenth of a recording at each end is 2 % of the axis' span away from the rest."""
    rng = np.random.default_rng(78)
    wrench = np.concatenate([np.stack([turning(rng, "white") for _ in range(6)], 1)] * 3)
    lost_at = np.zeros(wrench.shape, dtype=bool)
    for first in range(0, 3 * N, N):
        lost_at[first : first + N // 10] = True
    slow, broken = wrench + 0.16 * lost_at, wrench + 6.0 * lost_at
    # each recording begins far from where the one before it ended
    slow, broken = (np.add(w, np.repeat([0.0, 9.0, -9.0], N)[:, None]) for w in (slow, broken))
    assert check_spells("fl", slow, lost_at) == []
    (finding,) = check_spells("fl", broken, lost_at)
    assert finding.code == "intermittent_contact"


def walking(rng: np.random.Generator) -> FloatArray:
    """Counts of four cells under a foot that walks: impacts, loads that move, flights."""
    time_s = np.arange(30 * 100) / 100.0
    phase = (time_s / 1.1) % 1.0
    stance = phase < 0.6
    forward = np.clip(phase / 0.6, 0.0, 1.0)
    front, rear = stance * forward, stance * (1.0 - forward)
    sway = 0.5 + 0.3 * np.sin(2 * np.pi * time_s / 7.0)
    shares = np.stack([front * sway, front * (1 - sway), rear * sway, rear * (1 - sway)], 1)
    return np.asarray(8e6 - 2e5 * 30.0 * shares + rng.normal(0.0, 400.0, shares.shape))


@pytest.mark.parametrize("seed", range(4))
def test_a_cell_that_loses_contact_under_a_walking_foot_is_found_and_no_other(seed: int) -> None:
    rng = np.random.default_rng([77, seed])
    counts = walking(rng)
    names = ["left_fl", "left_fr", "left_rl", "left_rr"]
    assert check_loose_cells(counts, names) == []
    cell = int(rng.integers(4))
    for start in rng.choice(np.arange(20, len(counts) - 60, 70), 25, replace=False):
        counts[start : start + rng.integers(4, 20), cell] += 1.5e6
    assert [f.where for f in check_loose_cells(counts, names)] == [names[cell]]
    assert check_loose_cells(counts[:, :1], names[:1]) == []


def test_feet_that_step_together_have_no_loose_contact() -> None:
    """All cells of a foot that is lifted for a moment, again and again."""
    rng = np.random.default_rng(78)
    counts = rng.normal(8e6, 300.0, (N, 4))
    counts[lost(rng, 12)] += [1e6, 8e5, 5e5, 9e5]
    assert check_loose_cells(counts, ["fl", "fr", "rl", "rr"]) == []


@pytest.mark.parametrize("seed", range(5))
def test_a_touch_down_that_is_over_within_a_sample_is_no_loose_contact(seed: int) -> None:
    """At 30 Hz a heel has its load at once, and the toe gets its own over some samples."""
    rng = np.random.default_rng(seed)
    phase = np.arange(1500) % 15 + rng.uniform(0.0, 1.0)
    heel = np.interp(phase, [3.2, 3.8, 11.2, 11.8], [0.0, 1.0, 0.9, 0.0])
    toe = np.interp(phase, [2.0, 6.0, 8.0, 12.0], [0.0, 0.45, 0.6, 0.0])
    counts = 800.0 * np.stack([heel, toe], axis=1) + 3.0 * rng.standard_normal((1500, 2))
    assert check_loose_cells(np.round(counts), ["heel", "toe"]) == []
