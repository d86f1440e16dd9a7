import numpy as np
import pytest

from footcal_cli.core.inference.observability import (
    describe_direction,
    observability,
    rank_candidates,
)

NAMES = tuple(
    f"{foot}_{cell}.{kind}"
    for kind in ("gain", "bias")
    for foot in ("left", "right")
    for cell in ("fl", "fr", "rl", "rr")
)
TWIST = np.array([1.0, -1.0, -1.0, 1.0]) / 2.0


def unit(at: slice, pattern: np.ndarray) -> np.ndarray:
    vector = np.zeros(16)
    vector[at] = pattern
    return vector


@pytest.mark.parametrize(
    ("vector", "words"),
    [
        (unit(slice(8, 12), TWIST), "left foot: diagonal twist of the biases"),
        (unit(slice(12, 16), -TWIST), "right foot: diagonal twist of the biases"),
        (unit(slice(0, 4), np.full(4, 0.5)), "left foot: common part of the gains"),
        (
            (unit(slice(8, 12), np.full(4, 0.51)) - unit(slice(12, 16), np.full(4, 0.5)))
            / np.sqrt(2),
            "left foot: common part of the biases against right foot: common part of the biases",
        ),
    ],
)
def test_a_direction_is_named_by_its_pattern(vector: np.ndarray, words: str) -> None:
    assert describe_direction(vector, NAMES) == words


def test_feet_with_three_cells_are_named_cell_by_cell() -> None:
    names = ("left_heel.bias", "left_medial.bias", "left_lateral.bias", "robot.delay")
    assert describe_direction(np.array([0.0, 1.0, 0.0, 0.0]), names) == "left_medial.bias"
    assert describe_direction(np.array([0.0, 0.0, 0.0, 1.0]), names) == "robot.delay"


def test_rank_and_unseen_direction_of_rows_that_see_two_of_three() -> None:
    rows = np.array([[2.0, 0.0, 0.0], [0.0, 1.0, 1.0]])
    seen = observability(rows, ("a", "b", "c"))
    assert (seen.rank, seen.unknowns) == (2, 3)
    np.testing.assert_allclose(seen.singular_values, [2.0, np.sqrt(2.0), 0.0], atol=1e-12)
    np.testing.assert_allclose(np.abs(seen.directions[2]), [0.0, 0.5**0.5, 0.5**0.5], atol=1e-12)
    assert "against" in seen.weakest(1)[0]


def test_where_everything_is_seen_the_weakest_comes_first() -> None:
    seen = observability(np.diag([3.0, 0.1, 2.0]), ("a", "b", "c"))
    assert seen.rank == 3
    assert seen.weakest(1) == ["b"]


def test_expected_information_is_the_closed_form_and_orders_the_menu() -> None:
    rows = np.diag([1.0, 0.0])
    menu = {"sees b": np.array([[0.0, 3.0]]), "sees a again": np.array([[3.0, 0.0]])}
    steps = rank_candidates(rows, np.eye(2), menu, ("a", "b"))
    assert [step.name for step in steps] == ["sees b", "sees a again"]
    # ½ ln(1 + P h²): P_b = 1, P_a = 1/2
    np.testing.assert_allclose(
        [step.gain_nats for step in steps], [0.5 * np.log(10.0), 0.5 * np.log(5.5)]
    )
    np.testing.assert_allclose(steps[0].sd_ratio, 1 / np.sqrt(10.0))
    assert [step.rank for step in steps] == [2, 1]
    assert steps[0].direction == "b"
