"""Holds, outliers and directions of simulated recordings whose every sample is known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from footcal_cli.core import signals
from footcal_cli.core.bench.plateaus import (
    PlateauOptions,
    SampleState,
    find_direction,
    find_outliers,
    find_plateaus,
)
from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.study import find_loads

Array = NDArray[np.float64]
RATE_HZ = 20.0
LEVELS = (0.0, 10.0, 25.0, 60.0, 25.0, 0.0)


def staircase(
    rng: np.random.Generator, noise: float = 0.05, hold_s: float = 12.0, move_s: float = 2.0
) -> tuple[Array, Array, NDArray[np.int64]]:
    """Time, reading, and the true hold of every sample (−1 while a weight is being changed)."""
    reading, hold = [], []
    for i, level in enumerate(LEVELS):
        if i:
            n = int(move_s * RATE_HZ)
            ramp = np.linspace(LEVELS[i - 1], level, n) + 3.0 * rng.normal(size=n)
            reading.append(ramp)
            hold.append(np.full(n, -1))
        n = int(hold_s * RATE_HZ)
        reading.append(np.full(n, level))
        hold.append(np.full(n, i))
    y = np.concatenate(reading)
    y = y + noise * rng.normal(size=y.size)
    return np.arange(y.size) / RATE_HZ, y, np.concatenate(hold).astype(np.int64)


def test_every_hold_is_found_and_nothing_of_the_changes_is_called_settled() -> None:
    for seed in range(10):
        time, reading, truth = staircase(np.random.default_rng(seed))
        found = find_plateaus(time, reading)
        assert len(found) == len(LEVELS)
        np.testing.assert_allclose(found.median, LEVELS, atol=0.03)
        settled = found.state == SampleState.SETTLED
        inside = settled & (truth >= 0)
        assert settled.sum() - inside.sum() <= 2 * len(LEVELS), "a sample or two at an edge at most"
        assert inside.sum() > 0.8 * np.sum(truth >= 0)
        assert found.level.tolist() == [0, 1, 2, 3, 4, 5]


def test_creep_within_a_hold_is_settled_but_a_ramp_is_not() -> None:
    rng = np.random.default_rng(1)
    time = np.arange(0, 300, 0.05)
    creeping = 50.0 * (time > 20) * (1.0 + 0.003 * (1.0 - np.exp(-(time - 20) / 60)))
    found = find_plateaus(time, creeping + 0.01 * rng.normal(size=time.size))
    assert len(found) == 2
    assert found.n[1] > 0.98 * np.sum(time > 20)
    ramp = np.clip(time - 100, 0, 100) / 2.0 + 0.01 * rng.normal(size=time.size)
    moving = find_plateaus(time, ramp).state == SampleState.MOVING
    assert moving[(time > 105) & (time < 195)].all()


def test_glitches_and_dropouts_are_counted_exactly_and_steps_are_not_glitches() -> None:
    rng = np.random.default_rng(2)
    time, reading, truth = staircase(rng)
    quiet = np.flatnonzero(truth >= 0)
    quiet = quiet[(quiet > 40) & (quiet < reading.size - 40)]
    places = rng.choice(quiet[::9], size=20, replace=False)
    reading[places[:12]] += rng.choice([-1, 1], 12) * rng.uniform(5, 500, 12)
    reading[places[12:16]] = np.nan
    reading[places[16:]] = 2.0**23 - 1
    dropout, glitch = find_outliers(reading)
    assert sorted(np.flatnonzero(dropout)) == sorted(places[12:])
    assert set(places[:12]) <= set(np.flatnonzero(glitch))
    on_holds = glitch & (truth >= 0)
    assert on_holds.sum() == 12
    state = find_plateaus(time, reading).state
    assert np.sum(state == SampleState.DROPOUT) == 8
    assert state.size == reading.size

    step = np.where(np.arange(400) < 200, 0.0, 1000.0) + rng.normal(size=400)
    assert not find_outliers(step + 5000.0)[1].any()


def test_a_tared_cell_may_read_zero() -> None:
    rng = np.random.default_rng(3)
    reading = np.rint(2.0 * rng.normal(size=2000))
    assert (reading == 0).sum() > 100
    assert not find_outliers(reading)[0].any()
    stuck = 8.3e6 + rng.normal(size=2000)
    stuck[500:510] = 0.0
    assert find_outliers(stuck)[0].sum() == 10


def test_short_holds_pauses_and_settling_time() -> None:
    rng = np.random.default_rng(4)
    time, reading, _ = staircase(rng, hold_s=6.0)
    assert len(find_plateaus(time, reading, PlateauOptions(min_hold_s=30.0))) == 0
    assert np.any(find_plateaus(time, reading, PlateauOptions(min_hold_s=30.0)).state == 2)
    time[time > 3.0] += 60.0  # a pause in the first hold
    assert len(find_plateaus(time, reading, PlateauOptions(min_hold_s=2.0))) == len(LEVELS) + 1
    late = find_plateaus(time, reading, PlateauOptions(min_hold_s=2.0, settle_s=2.0))
    assert late.start_s[-1] == pytest.approx(
        find_plateaus(time, reading, PlateauOptions(min_hold_s=2.0)).start_s[-1] + 2.0, abs=0.06
    )


def test_direction_follows_from_the_order_in_time() -> None:
    load = np.array([0.0, 1.0, 1.0, 2.0, 1.0, 1.0, 0.0, 0.0, 5.0])
    time = np.arange(9.0)
    block = np.array([0, 0, 0, 0, 0, 0, 0, 1, 1])
    expected = np.array([0, 1, 1, 1, -1, -1, -1, 0, 1])
    np.testing.assert_array_equal(find_direction(load, time, block), expected)
    mixed = np.random.default_rng(0).permutation(9)
    np.testing.assert_array_equal(
        find_direction(load[mixed], time[mixed], block[mixed]), expected[mixed]
    )


def test_a_long_recording_is_judged_in_pieces_as_if_it_were_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    time_s, reading, _ = staircase(np.random.default_rng(7))
    reading[50], reading[51] = 1e4, np.nan
    whole = find_plateaus(time_s, reading)
    monkeypatch.setattr(signals, "PART_ROWS", 97)
    parts = find_plateaus(time_s, reading)
    np.testing.assert_array_equal(parts.state, whole.state)
    np.testing.assert_array_equal(parts.hold, whole.hold)
    np.testing.assert_allclose(parts.sd, whole.sd, rtol=1e-12)


def test_a_recorded_load_of_zero_is_no_dropout() -> None:
    rng = np.random.default_rng(8)
    load = np.repeat([0.0, 10.0, 20.0, 40.0, 0.0], 300)
    reading = 8.3e6 - load / 3.4e-5 + rng.normal(0, 300, load.size)
    record = BenchRecord(
        "left_fl",
        load,
        reading,
        np.arange(load.size) / RATE_HZ,
        np.zeros(load.size, dtype=np.int64),
    )
    found = find_loads(record, PlateauOptions(), ())
    settled = found.state == SampleState.SETTLED
    assert settled[load == 0.0].mean() > 0.9
    assert set(load[settled]) == {0.0, 10.0, 20.0, 40.0}


def test_a_change_counts_from_a_millionth_of_the_range_on() -> None:
    load = np.array([0.0, 0.9e-6, 0.0, 1.2e-6, 1.0])
    np.testing.assert_array_equal(find_direction(load), [0, 0, 0, 1, 1])
