"""A named cause against curves of the cells' loads that have no name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.unnamed import KNEE, Curves, Unnamed, against_curves
from footcal_cli.core.inference.evidence import sign_patterns
from footcal_cli.core.inference.problem import Problem
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

RULES = Rules()


def rows(values: FloatArray) -> FloatArray:
    """(B, n, 3) -> (B·3·n,), in the order of `problem_of`."""
    return np.moveaxis(values, 2, 1).reshape(-1)


def curves(world: World) -> Curves:
    """Knees at three loads, for all cells and for each."""
    shared, own = [], []
    for share in (0.2, 0.5, 0.8):
        knee = np.quantile(world.cells, share)
        bent = np.maximum(world.cells - knee, 0.0)
        shared.append(rows(outputs_of(bent)))
        own += [rows(outputs_of(bent * one)) for one in np.eye(4)]
    stacked = [np.stack(c, axis=1) for c in (shared, own)]
    return Curves(*(c / np.sqrt(np.mean(c**2, axis=0)) for c in stacked))


def judged(hidden: str, rho: float, seed: int) -> tuple[Unnamed, Problem]:
    """Crosstalk is named whatever is hidden."""
    rng = np.random.default_rng(seed)
    world = make_world(rng, trials=12)
    table = library_effects(world)
    residual = sized(world, table[hidden][0][1], rho) + noise_of(world, "ar9", rng)
    problem = problem_of(world, residual)
    named = rows(table["crosstalk"][0][1])[:, None]
    after = replace(problem, accepted=named)
    signs = sign_patterns(problem.blocks, seed)
    return against_curves(problem, after, named, curves(world), signs, RULES), problem


@pytest.mark.parametrize("seed", range(4))
def test_a_true_name_leaves_nothing_to_curves_and_is_not_replaced_by_them(seed: int) -> None:
    found, _ = judged("crosstalk", 0.6, seed)
    assert not found.rival
    assert found.left.p > RULES.alpha_form


@pytest.mark.parametrize("seed", range(4))
def test_a_curve_that_was_taken_for_crosstalk_shows(seed: int) -> None:
    found, _ = judged("quadratic", 0.6, seed)
    assert found.rival or found.left.p < RULES.alpha_form
    assert found.rival or found.left.bought > 0.0


@pytest.mark.parametrize("seed", range(4))
def test_a_curve_that_leaves_less_than_a_name_does_takes_its_place(seed: int) -> None:
    """A name that is most of a curve: neither is all, the curve is more."""
    rng = np.random.default_rng(seed)
    world = make_world(rng, trials=12)
    table = library_effects(world)
    other = rows(sized(world, table["crosstalk"][0][1], 1.0))
    bent = curves(world).shared[:, 1]
    blank = problem_of(world, noise_of(world, "ar9", rng))
    problem = replace(blank, residual=blank.residual + 3.0 * bent)
    named = (bent + 0.3 * other / np.sqrt(np.mean(other**2)))[:, None]
    signs = sign_patterns(problem.blocks, seed)
    after = replace(problem, accepted=named)
    assert against_curves(problem, after, named, curves(world), signs, RULES).rival


def test_a_knee_is_what_it_is_called_and_its_inverse_undoes_it() -> None:
    load = np.linspace(0.0, 20.0, 41)[:, None]
    log = Log("stand", ("left_fl",), np.arange(41.0), load, {}, np.zeros(41, dtype=np.int64))
    theta = {"gain": np.array([0.1]), "knee": np.array([8.0])}
    shown, _ = KNEE.apply(log, theta, None)
    np.testing.assert_allclose(shown.readings, load + 0.1 * np.maximum(load - 8.0, 0.0))
    back, _ = KNEE.remove(shown, theta, None)
    np.testing.assert_allclose(back.readings, load, atol=1e-12)
