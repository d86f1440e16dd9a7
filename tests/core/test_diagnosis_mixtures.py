"""A linear cause against mixtures of a foot's readings that have no name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.diagnosis.mixtures import MIXTURE, against_mixtures
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.unnamed import Unnamed
from footcal_cli.core.inference.evidence import sign_patterns
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from tests.core.diagnosis_world import (
    World,
    library_effects,
    make_world,
    noise_of,
    outputs_of,
    problem_of,
    sized,
)
from tests.core.test_diagnosis_unnamed import rows

RULES = Rules()
REMOVED = 100.0


def heard(world: World, listener: int, other: int) -> FloatArray:
    """What one cell that hears another one adds, (B, n, 3)."""
    cells = np.zeros_like(world.cells)
    cells[..., listener] = world.cells[..., other]
    return outputs_of(cells)


def mixtures(world: World) -> FloatArray:
    """Each cell hears each other one, shape (m, 12)."""
    pairs = [(i, j) for i in range(4) for j in range(4) if i != j]
    columns = np.stack([rows(heard(world, i, j)) for i, j in pairs], axis=1)
    return np.asarray(columns / np.sqrt(np.mean(columns**2, axis=0)))


def judged(hidden: str, seed: int) -> Unnamed:
    """Crosstalk of all cells is named whatever is hidden."""
    rng = np.random.default_rng(seed)
    world = make_world(rng, trials=12)
    named = library_effects(world)["crosstalk"][0][1]
    shown = named if hidden == "crosstalk" else heard(world, 0, 1)
    problem = problem_of(world, sized(world, shown, 1.0) + noise_of(world, "ar9", rng))
    after = replace(problem, accepted=rows(named)[:, None])
    return against_mixtures(after, mixtures(world), sign_patterns(problem.blocks, seed))


@pytest.mark.parametrize("seed", range(4))
def test_the_right_mixture_leaves_nothing_to_others(seed: int) -> None:
    assert not judged("crosstalk", seed).spoils(REMOVED, RULES)


@pytest.mark.parametrize("seed", range(4))
def test_another_mixture_shows_beside_it(seed: int) -> None:
    found = judged("one cell hears its neighbour", seed)
    assert found.left.p < RULES.alpha_form
    assert found.spoils(REMOVED, RULES)


def test_a_small_share_spoils_linear_names_only() -> None:
    found = judged("one cell hears its neighbour", 0)
    removed = 20.0 * found.left.bought
    assert found.spoils(removed, RULES)
    assert not replace(found, as_form=False).spoils(removed, RULES)


def test_a_mixture_is_what_it_is_called_and_its_inverse_undoes_it() -> None:
    channels = ("left_fl", "left_fr", "left_rr", "left_rl")
    load = np.random.default_rng(0).uniform(0.0, 20.0, (41, 4))
    log = Log("stand", channels, np.arange(41.0), load, {}, np.zeros(41, dtype=np.int64))
    theta = {"heard": np.array([0.0, 0.1, 0.0, 0.0]), "heard_from": np.full(4, 2.0)}
    shown, _ = MIXTURE.apply(log, theta, None)
    np.testing.assert_allclose(shown.readings[:, 1], load[:, 1] + 0.1 * load[:, 3])
    np.testing.assert_allclose(np.delete(shown.readings, 1, 1), np.delete(load, 1, 1))
    back, _ = MIXTURE.remove(shown, theta, None)
    np.testing.assert_allclose(back.readings, load, atol=1e-12)
