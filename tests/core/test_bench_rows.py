"""Rows of a bench log that contradict each other, and clean logs that do not."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.bench_rows import (
    check_stuck_reading,
    check_tare,
    check_uneven,
    pieces_by_pauses,
)
from footcal_cli.core.parameters import FloatArray

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


def bench_of(rng: np.random.Generator, loop_n: float, sd_n: FloatArray) -> list[str]:
    """One ladder up and down on each of eight cells, the third of which lags by a loop."""
    kg = np.array([0.0, 2.0, 5.0, 10.0, 15.0, 20.0, 10.0, 5.0, 0.0])
    back = np.array([0.0] * 6 + [1.0, 0.7, 0.3])
    load = np.tile(9.81 * kg, 8)
    felt = load + np.repeat(sd_n, kg.size) * rng.standard_normal(load.size)
    felt += loop_n * np.tile(back, 8) * np.repeat(np.arange(8) == 2, kg.size)
    found = check_uneven(
        load, 8e4 + 210.0 * felt, np.repeat(np.arange(8.0), kg.size), np.zeros(load.size),
        [f"cell_{c}" for c in range(8)],
    )  # fmt: skip
    return [finding.where for finding in found]


@pytest.mark.parametrize("seed", range(20))
def test_cells_that_scatter_alike_or_nearly_are_no_finding(seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert bench_of(rng, 0.0, 0.12 * rng.uniform(0.5, 1.6, 8)) == []


def test_a_cell_with_a_loop_among_straight_ones_is_found() -> None:
    assert bench_of(np.random.default_rng(3), 1.6, np.full(8, 0.12)) == ["cell_2"]
