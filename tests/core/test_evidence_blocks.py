"""Sign flips, permutations and intervals over blocks: sizes under the null, exactness, scaling."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core.inference.evidence import (
    Pooled,
    effective_blocks,
    held_out_interval,
    jackknife_interval,
    local_max_t,
    permutation_max_t,
    sign_flip_max_t,
    sign_flip_mean,
    sign_patterns,
    smallest_p,
)
from footcal_cli.core.parameters import FloatArray, IntArray


def test_all_sign_patterns_are_enumerated_once_for_few_blocks() -> None:
    signs = sign_patterns(5)
    assert signs.shape == (16, 5)
    assert np.unique(signs, axis=0).shape == (16, 5)
    assert (signs[0] == 1).all()
    assert (signs[:, 0] == 1).all()


def test_a_score_of_one_sign_in_every_block_reaches_the_smallest_p() -> None:
    rng = np.random.default_rng(0)
    scores = np.abs(rng.standard_normal((9, 1)))
    test = sign_flip_max_t(scores, sign_patterns(9))
    assert test.p[0] == pytest.approx(float(smallest_p(9.0)))


def test_blocks_without_information_do_not_count() -> None:
    information = np.array([[1.0, 4.0], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0]])
    np.testing.assert_allclose(effective_blocks(information), [4.0, 1.0])


def test_family_wise_p_is_uniform_under_the_null_with_heavy_tails_and_unequal_blocks() -> None:
    rng = np.random.default_rng(1)
    signs = sign_patterns(10)
    smallest = []
    for _ in range(400):
        size = rng.lognormal(0.0, 1.0, (10, 1))
        common = rng.standard_t(3, (10, 1))
        scores = size * (rng.standard_t(3, (10, 6)) + common)
        smallest.append(sign_flip_max_t(scores, signs).p.min())
    assert 0.02 < np.mean(np.array(smallest) <= 0.05) < 0.085
    assert stats.kstest(smallest, "uniform").pvalue > 0.005


def test_units_of_a_candidate_change_no_p_value() -> None:
    rng = np.random.default_rng(2)
    scores = rng.standard_normal((8, 4)) + 0.5
    signs = sign_patterns(8)
    np.testing.assert_allclose(
        sign_flip_max_t(scores, signs).p,
        sign_flip_max_t(scores * np.array([1e-6, 1.0, 9.80665, 1e6]), signs).p,
    )


def test_mean_test_is_one_sided_and_exact() -> None:
    signs = sign_patterns(6)
    assert sign_flip_mean(np.ones(6), signs) == pytest.approx(1 / 64)
    assert sign_flip_mean(-np.ones(6), signs) == pytest.approx(1.0)


def test_permutations_find_a_driver_that_moves_blocks_and_keep_their_size() -> None:
    rng = np.random.default_rng(3)
    driver = rng.standard_normal(12)
    driver -= driver.mean()
    found, false = [], []
    for _ in range(60):
        noise = rng.standard_normal((12, 2))
        drivers = np.zeros((12, 2, 2))
        drivers[:, 0, 0] = driver
        drivers[:, 1, 1] = driver
        false.append(permutation_max_t(noise - noise.mean(0), drivers, permutations=399).p.min())
        moved = noise + np.outer(2.0 * driver, [1.0, 0.0])
        found.append(permutation_max_t(moved - moved.mean(0), drivers, permutations=399).p[0])
    assert np.mean(np.array(found) < 0.01) > 0.85
    assert np.mean(np.array(false) < 0.05) < 0.15


def test_blocks_of_other_sensors_do_not_change_places() -> None:
    """One cell is loaded in half of the blocks: elsewhere it has neither driver nor response."""
    rng = np.random.default_rng(7)
    kind = np.repeat([0, 1], 12)
    smallest = []
    for _ in range(300):
        drivers, noise = np.zeros((24, 2, 2)), np.zeros((24, 2))
        for cell in (0, 1):
            mine = kind == cell
            drivers[mine, cell, cell] = stats.zscore(rng.standard_normal(12))
            noise[mine, cell] = stats.zscore(rng.standard_normal(12))
        smallest.append(permutation_max_t(noise, drivers, permutations=199, kind=kind).p.min())
    assert 0.02 < np.mean(np.array(smallest) <= 0.05) < 0.08
    assert stats.kstest(smallest, "uniform").pvalue > 0.005


def sessions_of_cells(
    rng: np.random.Generator, found: float, spread: FloatArray
) -> tuple[FloatArray, FloatArray, IntArray, Pooled]:
    """Each cell's sessions answer to a driver of their own; the first cell really does."""
    cells, each = spread.size, 6
    kind = np.repeat(np.arange(cells), each)
    drivers, noise = np.zeros((kind.size, cells, cells)), np.zeros((kind.size, cells))
    for cell in range(cells):
        mine = kind == cell
        drivers[mine, cell, cell] = stats.zscore(rng.standard_normal(each))
        moved = found * drivers[mine, cell, cell] if cell == 0 else 0.0
        y = spread[cell] * rng.standard_normal(each) + moved
        noise[mine, cell] = y - y.mean()
    information = np.einsum("bqk->k", drivers**2)
    return noise, drivers, kind, Pooled(np.zeros(cells, dtype=np.int64), information)


@pytest.mark.parametrize("spread", [np.ones(8), np.geomspace(0.5, 2.0, 8)], ids=["like", "unlike"])
def test_a_scatter_that_cells_share_keeps_the_level(spread: FloatArray) -> None:
    rng = np.random.default_rng(11)
    smallest = []
    for _ in range(300):
        noise, drivers, kind, pooled = sessions_of_cells(rng, 0.0, spread)
        test = permutation_max_t(noise, drivers, permutations=199, kind=kind, pooled=pooled)
        smallest.append(test.p.min())
    assert 0.02 < np.mean(np.array(smallest) <= 0.05) < 0.08


def test_an_effect_of_one_cell_does_not_hide_in_the_scatter_that_it_makes() -> None:
    """Six sessions at 3 sd each: beside their own scatter no statistic exceeds √6."""
    rng = np.random.default_rng(12)
    own, shared = [], []
    for _ in range(60):
        noise, drivers, kind, pooled = sessions_of_cells(rng, 3.0, np.ones(8))
        own.append(permutation_max_t(noise, drivers, permutations=999, kind=kind).p[0])
        test = permutation_max_t(noise, drivers, permutations=999, kind=kind, pooled=pooled)
        shared.append(test.p[0])
    assert np.mean(np.array(shared) < 0.01) > np.mean(np.array(own) < 0.01) + 0.2


def test_what_hardly_knows_of_a_place_does_not_say_how_its_repeats_scatter() -> None:
    """Four repeats know of each place; all other blocks know little and are quieter."""
    rng = np.random.default_rng(8)
    blocks, places = 48, 12
    weight = np.full((blocks, places), 0.01)
    for k in range(places):
        weight[4 * k : 4 * k + 4, k] = 1.0
    loud = np.where(weight == 1.0, 1.3, 0.8)
    smallest = [
        local_max_t(np.sqrt(weight) * loud * rng.standard_normal(weight.shape), weight)[1].min()
        for _ in range(1000)
    ]
    assert 0.03 < np.mean(np.array(smallest) <= 0.05) < 0.07


def test_jackknife_of_a_mean_is_students_interval() -> None:
    values = np.random.default_rng(5).standard_normal(11)
    without = (values.sum() - values) / 10
    ours = jackknife_interval(float(values.mean()), without)
    students = stats.t.interval(0.95, 10, values.mean(), stats.sem(values))
    assert (ours.low, ours.high) == pytest.approx(students)


def test_held_out_gains_scatter_more_than_their_mean_as_models_share_their_blocks() -> None:
    """Nadeau and Bengio: 1/B + 1/(B − 1) instead of 1/B."""
    values = np.random.default_rng(5).normal(size=12)
    without = (values.sum() - values) / 11.0
    mean = float(values.mean())
    plain, wider = jackknife_interval(mean, without), held_out_interval(mean, without)
    assert (wider.high - mean) / (plain.high - mean) == pytest.approx(np.sqrt(1.0 + 12.0 / 11.0))
    assert wider.low == pytest.approx(2.0 * mean - wider.high)
    assert held_out_interval(1.0, np.ones(1)).high == np.inf
    few = held_out_interval(mean, without, informative=4.0)
    assert (few.high - mean) / (wider.high - mean) == pytest.approx(
        stats.t.ppf(0.975, 3) / stats.t.ppf(0.975, 11)
    )


def test_a_size_that_few_blocks_inform_has_their_degrees_of_freedom() -> None:
    without = np.zeros(48)
    without[:12] = np.random.default_rng(6).normal(size=12)
    all_blocks, few = (jackknife_interval(0.0, without, informative=n) for n in (48.0, 12.0))
    assert few.high / all_blocks.high == pytest.approx(
        stats.t.ppf(0.975, 11) / stats.t.ppf(0.975, 47)
    )
