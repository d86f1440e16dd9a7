"""A few sessions of one cell against a driver between them: Student's t with a shared scatter."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.diagnosis.weighing import is_possible, of_one_form_p
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.parameters import FloatArray

CELLS, EACH, SCATTER = 8, 7, 0.3


def p_of_cells(
    rng: np.random.Generator, size: float, unlike: float, each: int = EACH, *, centred: bool = True
) -> FloatArray:
    """Single p of each cell, shape (CELLS,): score ``u ~ N(β i, φ i)``, β of the first cell."""
    kind = np.repeat(np.arange(CELLS), each)
    mine = kind[:, None] == np.arange(CELLS)
    information = np.where(mine, rng.exponential(4.0, (kind.size, 1)), 0.0)
    scatter = SCATTER * unlike ** np.linspace(-1.0, 1.0, CELLS)
    score = np.sqrt(scatter * information) * rng.standard_normal(information.shape)
    score[:, 0] += size * information[:, 0]
    form = np.zeros(CELLS, dtype=np.int64)
    return of_one_form_p(score, information, form, kind if centred else None)


@pytest.mark.parametrize("unlike", [1.0, 2.0])
def test_clean_cells_are_named_no_more_often_than_said(unlike: float) -> None:
    rng = np.random.default_rng(1)
    p = np.array([p_of_cells(rng, 0.0, unlike) for _ in range(1500)])
    for level in (0.05, 0.01, 0.001):
        assert np.mean(p < level) < 1.3 * level + 2.0 * np.sqrt(level / p.size)


@pytest.mark.parametrize("each", [2, pytest.param(4, marks=pytest.mark.slow)])
def test_a_few_sessions_of_each_clean_cell_keep_the_level(each: int) -> None:
    """Student's t with the scatter of all cells is exact; the floor of a cell's own is safe."""
    rng = np.random.default_rng(3)
    p = np.array([p_of_cells(rng, 0.0, 1.0, each, centred=False) for _ in range(4000)])
    for level in (0.01, 0.001):
        assert np.mean(p < level) < level + 3.0 * np.sqrt(level / p.size)


def test_seven_sessions_of_one_cell_reach_the_level_of_a_family() -> None:
    """At 6 sd of its size; alone they have five degrees of freedom."""
    rng = np.random.default_rng(2)
    size = 6.0 * np.sqrt(SCATTER / (EACH * 4.0))
    p = np.array([p_of_cells(rng, size, 1.0) for _ in range(400)])
    assert np.mean(CELLS * p[:, 0] < 0.01) > 0.7


def test_what_one_session_alone_knows_is_nothing() -> None:
    kind = np.arange(4)
    assert (of_one_form_p(np.ones((4, 4)), np.eye(4), np.zeros(4, np.int64), kind) == 1).all()


def test_a_linear_size_may_overshoot_as_far_as_the_end_still_explains_most() -> None:
    """At the end e of the range ``(1 − e/β)²`` of what size β explains is lost."""
    stops = Signature("saturation", "saturation", "fl", "-", lower=0.0, upper=1.0)
    assert is_possible(stops, 1.9, 0.0, 0.25)
    assert not is_possible(stops, 2.1, 0.0, 0.25)
    assert not is_possible(stops, 1.1, 0.0, 0.0)
    assert is_possible(stops, 1.1, 0.2, 0.0)
    assert not is_possible(stops, -0.1, 0.0, 0.25), "no other sign"
    flipped = Signature("sign_flip", "sign_flip", "fl", "-", lower=0.7, upper=1.3)
    assert not is_possible(flipped, 0.6, 0.0, 0.25), "what falls short does not overshoot"
    assert not is_possible(flipped, 0.0, 0.0, 0.25)
