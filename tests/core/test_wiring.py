"""Exchanged cells of a foot and rows that were written twice."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.checks.units import check_units_of_channels, check_units_of_sessions
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.wiring import _twins, check_exchanged_cells

NAMES = ("left_fl", "left_fr", "left_rl", "left_rr")
CELL_M = np.array([[0.07, 0.03], [0.07, -0.03], [-0.05, 0.03], [-0.05, -0.03]])
SCALE = np.array([-3.4e-5, -3.1e-5, -3.6e-5, -3.3e-5])


def placements(seed: int, crosstalk: float = 0.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Counts, holes and weights of a stiff plate on four springs that rocks a little."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(-0.03, 0.05, 5), np.linspace(-0.02, 0.02, 3))
    hole = np.tile(np.column_stack([x.ravel(), y.ravel()]), (4, 1))
    load = np.tile(np.repeat([6.0, 20.0], 15), 2)
    arms = np.column_stack([np.ones(4), CELL_M - CELL_M.mean(axis=0)])
    shares = np.column_stack([np.ones(60), hole - CELL_M.mean(axis=0)])
    force = load[:, None] * (shares @ np.linalg.solve(arms.T @ arms, arms.T))
    force += load[:, None] * 0.03 * rng.standard_normal((60, 1)) * np.array([1, -1, -1, 1])
    mixing = np.eye(4) + crosstalk * (np.ones((4, 4)) - np.eye(4))
    force = force @ mixing.T + 0.02 * rng.standard_normal(force.shape)
    return np.rint(8.3e6 + force / SCALE), hole, load


@pytest.mark.parametrize("pair", [(0, 1), (0, 3), (2, 1)])
def test_exchanged_cells_are_found(pair: tuple[int, int]) -> None:
    counts, hole, load = placements(1)
    order = np.arange(4)
    order[list(pair)] = pair[::-1]
    (finding,) = check_exchanged_cells(counts[:, order], NAMES, CELL_M, hole, load)
    assert finding.severity == "alarm"
    assert set(finding.where.split(", ")) == {NAMES[i] for i in pair}


@pytest.mark.parametrize("crosstalk", [0.0, 0.02, 0.15])
def test_cells_in_their_places_are_left_alone(crosstalk: float) -> None:
    for seed in range(10):
        counts, hole, load = placements(seed, crosstalk)
        assert not check_exchanged_cells(counts, NAMES, CELL_M, hole, load)


def test_a_session_in_another_unit_is_found_and_a_gain_is_not() -> None:
    rng = np.random.default_rng(5)
    session, load = np.repeat(np.arange(6.0), 10), np.tile(np.linspace(0.0, 20.0, 10), 6)
    counts = 8.3e6 - load / 3.4e-5 * (1.0 + 0.02 * rng.standard_normal(6)[session.astype(int)])
    assert not check_units_of_sessions("left_fl", load, counts, session)
    in_kg = np.where(session == 2, load / 9.80665, load)
    (finding,) = check_units_of_sessions("left_fl", in_kg, counts, session)
    assert finding.severity == "alarm"
    assert "session 3" in finding.sentence
    assert "kg" in finding.sentence


@pytest.mark.parametrize(
    ("noted", "others", "ratio"),
    [
        ("kg", "N", 9.80665),
        ("lbf", "kg", 0.45359237),
        ("kg", "lbf", 2.2046226),
        ("g", "lbf", 0.0022046226),
    ],
)
def test_a_session_noted_in_one_unit_beside_others_in_another(
    noted: str, others: str, ratio: float
) -> None:
    """The number written for the same weight is 1/ratio of the others' unit."""
    session, load = np.repeat(np.arange(4.0), 8), np.tile(np.linspace(0.0, 20.0, 8), 4)
    counts = 8.3e6 - load / 3.4e-5
    written = np.where(session == 1, load / ratio, load)
    (finding,) = check_units_of_sessions("toe", written, counts, session)
    assert f"noted in {noted}, the others' in {others}" in finding.sentence


def test_two_sessions_under_the_same_weights_in_two_units() -> None:
    """Of two sessions the loads must be in the ratio too: a slope alone may be another cell's."""
    session, load = np.repeat([0.0, 1.0], 8), np.tile(np.linspace(0.0, 20.0, 8), 2)
    counts = 8.3e6 - load / 3.4e-5
    written = np.where(session == 1, load * 1000.0, load)
    (finding,) = check_units_of_sessions("toe", written, counts, session)
    assert "noted in g, the others' in kg" in finding.sentence
    smaller = np.where(session == 1, 0.5 * load * 1000.0, load)
    assert not check_units_of_sessions("toe", smaller, counts, session)


def test_one_cell_of_a_foot_whose_weights_were_noted_in_grams() -> None:
    """Four cells of one make within 4 %, one of them turned; one was noted in g beside kg."""
    cell, load = np.repeat(np.arange(4.0), 8), np.tile(np.linspace(0.0, 20.0, 8), 4)
    slope = np.array([1.0, 1.03, -0.97, 1.04])[cell.astype(int)] / 3.4e-5
    counts = 8.3e6 + slope * load
    assert not check_units_of_channels(cell, load, counts, NAMES)
    written = np.where(cell == 3, load * 1000.0, load)
    (finding,) = check_units_of_channels(cell, written, counts, NAMES)
    assert finding.where == "left_rr"
    assert "noted in g, the others' in kg" in finding.sentence


def test_a_stronger_cell_beside_weaker_ones_is_no_unit() -> None:
    """A cell for ten times the load, 9.8 times less sensitive, loaded with ten times as much."""
    cell, load = np.repeat(np.arange(4.0), 8), np.tile(np.linspace(0.0, 20.0, 8), 4)
    strong = cell == 2
    written = np.where(strong, load * 10.0, load)
    counts = 8.3e6 + load / 3.4e-5 * np.where(strong, 10.0 / 9.80665, 1.0)
    assert not check_units_of_channels(cell, written, counts, NAMES)


def test_a_cell_that_turns_another_over_is_no_copy_of_it() -> None:
    rng = np.random.default_rng(3)
    moved = rng.normal(size=(40, 3))
    moved /= np.linalg.norm(moved, axis=0)
    moved[:, 1] = -moved[:, 0]
    assert _twins([moved], NAMES[:3]) == []
    moved[:, 1] = moved[:, 0]
    (finding,) = _twins([moved], NAMES[:3])
    assert finding.where == f"{NAMES[0]}, {NAMES[1]}"
