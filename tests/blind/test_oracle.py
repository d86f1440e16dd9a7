"""The oracle against closed forms, and against trials simulated with the generator's own noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.linalg import solve_triangular

from tests.blind.hidden import CATALOGUE
from tests.blind.noise import FAMILIES, Spread
from tests.blind.oracle import Gram, attained, gram_of, limits
from tests.blind.plan import Cell
from tests.blind.trials import drawn
from tests.blind.whitening import Whitening, inputs_of, whitened
from tests.blind.world import Array, World
from tests.blind.worlds import WORLDS
from tests.blind.yardstick import yardstick


def test_a_test_at_one_per_cent_finds_nothing_in_one_per_cent() -> None:
    assert attained(0.0) == pytest.approx(0.01)
    assert attained(2.326348) == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("family", FAMILIES)
def test_the_law_of_noise_is_that_of_its_draws(family: str) -> None:
    rng = np.random.default_rng(3)
    load = np.tile(np.linspace(0.0, 9.0, 30), 4000)[:, None]
    spread = Spread(family, load, np.repeat(np.arange(4000), 30), np.array([0.5]), 0.3)
    drawn_rows = spread.draw(rng).reshape(4000, 30)
    found = drawn_rows.T @ drawn_rows / 4000
    law = spread.covariance(slice(0, 30), 0)
    scale = np.sqrt(np.outer(np.diag(law), np.diag(law)))
    # correlations scatter by 1/√4000
    assert np.abs(found - law).max() / scale.max() < 6 / np.sqrt(4000)


def _law(world: World) -> Whitening:
    stick = yardstick(WORLDS[world.experiment], world)
    return Whitening(world, stick, inputs_of(world, stick))


@pytest.mark.parametrize("experiment", sorted(WORLDS))
@pytest.mark.parametrize("seed", [1, pytest.param(5, marks=pytest.mark.slow)])
def test_noise_of_every_generator_becomes_white(experiment: str, seed: int) -> None:
    maker = WORLDS[experiment]
    world = replace(maker.draw(np.random.default_rng(seed), {}), quantum_n=0.0)
    law = _law(world)
    shake = law.entries(maker.error(world.noisy()) - law.stick.clean_error)
    white = np.concatenate([whitened(b, shake[b.entries, None])[:, 0] for b in law.blocks()])
    assert np.mean(white**2) == pytest.approx(1.0, abs=5 * np.sqrt(2.0 / white.size))
    assert abs(white[1:] @ white[:-1]) / white.size < 5 / np.sqrt(white.size)


def _white_weights() -> World:
    world = WORLDS["weights"].draw(np.random.default_rng(0), {})
    assert world.spread is not None
    spread = replace(world.spread, family="white", repeatability=0.0)
    rng = np.random.default_rng(1)
    return replace(world, spread=spread, noise=spread.draw(rng), quantum_n=0.0)


def test_in_white_noise_the_distance_is_rho_times_the_root_of_the_rows() -> None:
    world = _white_weights()
    stick = yardstick(WORLDS["weights"], world)
    act = CATALOGUE["nonlinearity/table"].act
    hidden = act(world, 2e-4, np.random.default_rng(0))
    touched = np.abs(stick.influence(hidden)).max(axis=0) > 0
    rows = int(stick.valid[:, touched].sum())
    found = limits(world, stick, [hidden], [["nonlinearity"]])
    # the yardstick's noise is that of one draw
    assert found["d0"][0] == pytest.approx(stick.rho(hidden) * np.sqrt(rows), rel=0.05)
    assert found["d1"][0] < found["d0"][0]
    assert found["right"] == attained(found["d0"][0])


def test_of_two_equal_signatures_none_is_told_from_the_other() -> None:
    world = _white_weights()
    stick = yardstick(WORLDS["weights"], world)
    warm = world.row["temperature_degc"][:, None] - 25.0
    hidden = world.with_shown(world.shown + 0.01 * warm)
    own = limits(world, stick, [hidden], [["temperature_bias"]])
    other = limits(world, stick, [hidden], [["another name"]])
    assert own["nearest"] != ["temperature_bias"]
    assert other["nearest"] == ["temperature_bias"]
    # what rounding leaves of the whole
    assert other["d1"][0] < 1e-3 * own["d0"][0]
    assert other["exact"] == pytest.approx(0.01, abs=1e-3)


def test_a_one_way_rival_is_fitted_with_its_own_sign_only() -> None:
    products = np.array([[4.0, 2.0, -2.0], [2.0, 4.0, 0.0], [-2.0, 0.0, 4.0]])
    gram = Gram(products, np.diag(products).copy())
    assert gram.left(0, [1]) == pytest.approx(3.0)
    assert gram.left(0, [1], [1]) == pytest.approx(3.0)
    assert gram.left(0, [2]) == pytest.approx(3.0)
    assert gram.left(0, [2], [2]) == pytest.approx(4.0)
    assert gram.left(0, [1, 2], [2]) == pytest.approx(3.0)


def test_memory_and_poor_repeatability_hide_what_white_noise_shows() -> None:
    white = _white_weights()
    assert white.spread is not None
    distances = []
    for family, repeatability in (("white", 0.0), ("ar98", 0.0), ("ar98", 0.6)):
        spread = replace(white.spread, family=family, repeatability=repeatability)
        world = replace(white, spread=spread)
        stick = yardstick(WORLDS["weights"], world)
        warm = world.row["temperature_degc"][:, None] - 25.0
        hidden = world.with_shown(world.shown + 0.01 * warm)
        distances.append(limits(world, stick, [hidden], [["temperature_bias"]])["d0"][0])
    assert distances[0] > 3 * distances[1] > 3 * distances[2] > 0


def _redrawn(world: World, rng: np.random.Generator) -> Array:
    """A weighing's errors with nothing hidden, noise drawn anew and rounded by its converter."""
    assert world.spread is not None
    shown = world.shown + world.spread.draw(rng)
    if world.quantum_n > 0:
        shown = np.round(shown / world.quantum_n) * world.quantum_n
    return np.asarray(WORLDS["weights"].error(world.with_shown(shown)))


@pytest.mark.parametrize("seed", [2, pytest.param(7, marks=pytest.mark.slow)])
def test_hit_rate_of_the_likelihood_ratio_is_the_predicted_one(seed: int) -> None:
    """The nearest rival is true in half of the trials, the hidden effect in the others."""
    cell = Cell("single", "weights", ("temperature_bias/table",), 0.3)
    found = drawn(cell, seed)
    law = Whitening(found.clean, found.stick, inputs_of(found.clean, found.stick))
    clean = found.stick.clean_error
    effect = law.entries(found.stick.maker.error(found.alone[0]) - clean)
    rival = law.entries(found.stick.maker.error(_steps(found.clean)) - clean)
    # half of the size: a distance at which some trials are missed
    gram = gram_of(law, np.column_stack([effect, rival]))
    size = 3.0 / np.sqrt(gram.left(0, [1]))
    statistic = _statistic(law, size * effect, rival)
    rng = np.random.default_rng(seed)
    noise = np.array(
        [statistic @ law.entries(_redrawn(found.clean, rng) - clean) for _ in range(400)]
    )
    shift = statistic @ (size * effect)
    assert statistic @ rival == pytest.approx(
        0.0, abs=float(1e-6 * np.abs(statistic) @ np.abs(rival))
    )
    bound = stats.norm.isf(0.01)
    wrong, right = np.mean(noise > bound), np.mean(noise + shift > bound)
    assert right == pytest.approx(attained(3.0), abs=4 * np.sqrt(0.25 * 0.75 / 400))
    assert wrong < 0.01 + 4 * np.sqrt(0.01 / 400)


def _steps(clean: World) -> World:
    """The rival: a bias that jumps half way through the log."""
    later = np.arange(clean.time_s.size) >= clean.time_s.size // 2
    return clean.with_shown(clean.shown + later[:, None])


def _statistic(law: Whitening, effect: Array, rival: Array) -> Array:
    """Weights of the likelihood-ratio test of an effect against a rival of any size, unit sd."""
    moves = [law.entries(move * law.stick.noise) for move in law.stick.moves]
    columns = np.column_stack([effect, rival, *moves])
    blocks = list(law.blocks())
    white = np.concatenate([whitened(b, columns[b.entries]) for b in blocks])
    own, beside = white[:, 0], white[:, 1:] / np.linalg.norm(white[:, 1:], axis=0)
    left = own - beside @ np.linalg.lstsq(beside, own, rcond=None)[0]
    left /= np.linalg.norm(left)
    return np.concatenate(
        [solve_triangular(b.root, left[b.entries], lower=True, trans="T") for b in blocks]
    )


@pytest.mark.slow
def test_the_oracle_knows_its_law_in_pairs_and_drifting_walks() -> None:
    pair = drawn(Cell("pair", "placements", ("crosstalk/table", "wrong_weight/label"), 0.6), 3)
    rights = [effect["right"] for effect in pair.effects]
    both = limits(pair.clean, pair.stick, pair.alone, rights)
    first = limits(pair.clean, pair.stick, pair.alone[:1], rights[:1])
    assert both["d0"][0] <= first["d0"][0]
    assert both["exact"] <= both["right"] == attained(min(both["d0"]))
    still = drawn(Cell("single", "walk", ("hysteresis/table",), 0.3), 5)
    rates = (1e-3, 2e-2)
    wanders = replace(still.clean, drift_per_root_s=rates)
    stick = yardstick(WORLDS["walk"], wanders)
    followed = limits(wanders, stick, still.alone, [["hysteresis"]])
    fitted = limits(still.clean, still.stick, still.alone, [["hysteresis"]])
    assert 0 < followed["d0"][0] < fitted["d0"][0]
