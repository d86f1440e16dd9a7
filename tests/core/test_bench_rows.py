"""Rows of a bench log that contradict each other, and clean logs that do not."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.bench_rows import check_stuck_reading, check_tare, pieces_by_pauses

LOAD = np.repeat([0.0, 5.0, 10.0, 20.0, 10.0, 5.0, 0.0], 8)


def readings(rng: np.random.Generator, load: np.ndarray, noise: float = 40.0) -> np.ndarray:
    return np.round(8.3e6 - 3e4 * load + noise * rng.normal(size=load.size))


def test_clean_logs_are_left_alone() -> None:
    """Curvature, a closed loop, creep, coarse converters and few or many repeats."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        load = np.repeat(np.array([0, 5, 10, 20, 10, 5, 0.0])[: rng.integers(4, 8)],
                         rng.integers(2, 12))  # fmt: skip
        count = readings(rng, load, float(rng.choice([0.4, 3.0, 40.0])))
        count += rng.choice([0, 3e3]) * np.sin(load / 7)
        count += rng.choice([0, 500]) * np.arange(load.size) / load.size
        count = np.round(count / rng.choice([1, 3000]))
        assert check_stuck_reading(load, count, "x") == []
        assert check_tare(load, count, "x") == []


def test_a_stuck_reading_and_a_stuck_load_are_found() -> None:
    rng = np.random.default_rng(2)
    count = readings(rng, LOAD)
    stuck = count.copy()
    stuck[12:26] = stuck[12]
    assert [f.code for f in check_stuck_reading(LOAD, stuck, "x")] == ["stuck"]
    load = LOAD.copy()
    load[12:26] = load[12]
    assert [f.code for f in check_stuck_reading(load, count, "x")] == ["stuck_load"]


def test_a_tare_between_two_rows_is_found_where_it_was() -> None:
    rng = np.random.default_rng(3)
    load = np.repeat([0.0, 2.0, 5.0, 0.0, 5.0, 10.0], 8)
    count = readings(rng, load)
    count[24:] -= 65_000
    (found,) = check_tare(load, count, "x")
    assert found.severity == "warning"
    assert "from row 25 of 48" in found.sentence


def test_three_days_without_a_name_are_three_sessions() -> None:
    """A ladder of one morning is one session, and so is a row per day for months."""
    morning = 12.0 * np.arange(40, dtype=np.float64)
    day = 86400.0 * np.arange(3, dtype=np.float64)
    dated = np.asarray(1.77e9 + day[:, None] + morning).ravel()
    found = pieces_by_pauses(dated)
    assert np.array_equal(found, np.repeat([0, 1, 2], 40))
    shuffled = np.random.default_rng(3).permutation(120)
    assert np.array_equal(pieces_by_pauses(dated[shuffled]), found[shuffled])
    assert pieces_by_pauses(morning).max() == 0
    assert pieces_by_pauses(np.linspace(0.0, 3e7, 300)).max() == 0
    assert pieces_by_pauses(np.full(9, np.nan)).max() == 0
