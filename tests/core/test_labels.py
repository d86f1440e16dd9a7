"""A weight that is written as another one, and what only looks like it."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.checks.labels import check_labels
from footcal_cli.core.parameters import FloatArray

LADDER = np.array([0.0, 5.0, 10.0, 20.0, 30.0, 50.0])
UP_AND_DOWN = np.concatenate([LADDER, LADDER[-2::-1]])
TRUE_N = np.concatenate([UP_AND_DOWN, UP_AND_DOWN[1:], UP_AND_DOWN[1:]])


def recorded(
    true_n: FloatArray, written_n: FloatArray, rows: int = 1
) -> tuple[FloatArray, FloatArray]:
    """Written loads and counts of a cell of 2000 counts per newton, of so many rows a load."""
    rng = np.random.default_rng(4)
    counts = 2000.0 * np.repeat(true_n, rows) - 8e4
    return np.repeat(written_n, rows), counts + 20.0 * rng.standard_normal(counts.size)


@pytest.mark.parametrize("rows", [1, 12])
@pytest.mark.parametrize("seed", range(4))
def test_one_wrong_weight_is_found_with_its_row_and_the_right_one(seed: int, rows: int) -> None:
    rng = np.random.default_rng([seed, 40])
    at = int(rng.integers(TRUE_N.size))
    written = TRUE_N.copy()
    written[at] = rng.choice(LADDER[TRUE_N[at] != LADDER])
    neighbours = written[[at - 1, (at + 1) % written.size]]
    if written[at] in neighbours:  # then the rows are those of one load with its neighbour
        written[at] = next(x for x in LADDER if x != TRUE_N[at] and x not in neighbours)
    (found,) = check_labels(*recorded(TRUE_N, written, rows), "left_fl")
    first, last = at * rows + 1, (at + 1) * rows
    where = f"row {first}" if rows == 1 else f"rows {first} to {last}"
    assert f"the load of {where} is written as {written[at]:.5g} N" in found.sentence
    assert f"what it reads at {TRUE_N[at]:.5g} N" in found.sentence
    assert found.severity == "alarm"


def test_a_slip_of_the_pen_is_a_load_that_is_written_once() -> None:
    written = TRUE_N.copy()
    written[7] *= 10.0
    (found,) = check_labels(*recorded(TRUE_N, written), "left_fl")
    assert f"{TRUE_N[7]:.5g} N" in found.sentence


@pytest.mark.parametrize(
    "shown",
    [
        TRUE_N,
        TRUE_N - 6e-3 * TRUE_N * (50.0 - TRUE_N),
        np.minimum(TRUE_N, 30.0),
        np.maximum(TRUE_N - 5.0, 0.0),
        TRUE_N + 3.0 * (np.arange(TRUE_N.size) > 17),
        TRUE_N + 0.1 * np.arange(TRUE_N.size),
        TRUE_N + 5.0 * np.exp(-np.arange(TRUE_N.size) / 4.0),
        TRUE_N - np.sign(np.diff(TRUE_N, prepend=-1.0)),
        np.where(np.arange(TRUE_N.size) == 9, 13.7, TRUE_N),
    ],
    ids=["clean", "curve", "end", "dead_zone", "jump", "drift", "warm_up", "loop", "glitch"],
)
def test_what_moves_readings_otherwise_is_no_wrong_weight(shown: FloatArray) -> None:
    _, counts = recorded(shown, TRUE_N)
    assert check_labels(TRUE_N, counts, "left_fl") == []


def test_a_reference_that_moves_has_no_labels() -> None:
    load = 25.0 + 25.0 * np.sin(np.linspace(0.0, 20.0, 2000))
    assert check_labels(*recorded(load, load), "left_fl") == []
