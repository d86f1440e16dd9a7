"""Stances of several rows: sway within one tells more than what the next one does not repeat."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core.diagnosis.detection import detect
from footcal_cli.core.diagnosis.features import features_of
from footcal_cli.core.diagnosis.weighing import alike_as
from footcal_cli.core.inference.evidence import sign_patterns
from footcal_cli.core.inference.grams import Grams, whitened_grams
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.products import block_products
from footcal_cli.core.inference.scores import scores
from footcal_cli.core.inference.wandering import (
    variance_beside,
    wandering_columns,
    wandering_variance,
)
from footcal_cli.core.inference.whitening import has_single_rows
from footcal_cli.core.parameters import FloatArray

STANCES, PIECES, OUTPUTS = 24, 4, 3
APART, WITHIN, SWAY = 1.0, 0.1, 0.3
"""Sd of what a stance does not repeat, of one piece, and of the load's sway within a stance."""
LEVEL = 0.01


def standing(seed: int, size: float = 0.0, *, shared: float = 0.0) -> Problem:
    """Offset and gain of every output are fitted; two candidates.

    Parameters
    ----------
    size
        Of ``load² − 1`` in the first output, which sways.
    shared
        Of a step of the second output in every other stance, which does not.
    """
    rng = np.random.default_rng(seed)
    block = np.repeat(np.arange(STANCES), OUTPUTS * PIECES)
    output = np.tile(np.repeat(np.arange(OUTPUTS), PIECES), STANCES)
    load = (
        np.repeat(rng.normal(size=STANCES), OUTPUTS * PIECES)
        + SWAY * rng.normal(size=(STANCES, 1, PIECES)).repeat(OUTPUTS, axis=1).ravel()
    )
    noise = WITHIN * rng.normal(size=block.size)
    noise += APART * np.repeat(rng.normal(size=STANCES * OUTPUTS), PIECES)
    columns = np.stack(
        [(load**2 - 1.0) * (output == 0), np.where(block % 2 == 0, 1.0, -1.0) * (output == 1)], 1
    )
    unit = np.eye(OUTPUTS)[output]
    return Problem(
        residual=columns @ np.array([size, shared]) + noise,
        calibration=np.hstack([unit, unit * load[:, None]]),
        columns=columns,
        signatures=(Signature("bent", "size", "all", "-"), Signature("step", "size", "all", "-")),
        block=block,
        output=output,
        sequence=block * OUTPUTS + output,
        outputs=("fz", "mx", "my"),
        units=("N", "Nm", "Nm"),
        noise=np.ones(block.size),
        tolerance=np.full(OUTPUTS, 0.1),
        regressors={"load": load},
        pieces=True,
    )


def grams_of(problem: Problem) -> Grams:
    return whitened_grams(problem, np.empty((problem.residual.size, 0)))[0]


def estimate(problem: Problem, candidate: int) -> tuple[float, float]:
    """Size of a candidate and the sd that the noise law promises."""
    grams = grams_of(problem)
    found = scores(grams.inner, grams.calibration, grams.candidates[[candidate]])
    return float(found.size[0]), float(1.0 / np.sqrt(found.information.sum()))


def best_possible(problem: Problem) -> float:
    """Sd of the first candidate's size by generalised least squares with the true covariance."""
    same = problem.sequence[:, None] == problem.sequence[None]
    covariance = APART**2 * same + WITHIN**2 * np.eye(problem.residual.size)
    root = np.linalg.cholesky(covariance)
    white = np.linalg.solve(root, np.column_stack([problem.calibration, problem.columns[:, :1]]))
    return float(np.sqrt(np.linalg.inv(white.T @ white)[-1, -1]))


def test_rows_within_a_stance_are_as_noisy_as_its_pieces_are() -> None:
    sd = [standing(seed).law.whitener.sd for seed in range(20)]
    assert np.sqrt(np.mean(np.square(sd))) == pytest.approx(WITHIN, rel=0.1)


def test_one_long_stance_among_short_ones_changes_no_noise() -> None:
    """It alone has rows enough for a calibration of its own; that of the others is as far off."""
    sd = []
    for seed in range(20):
        problem = standing(seed)
        off = problem.residual + problem.calibration @ np.full(2 * OUTPUTS, 30.0)
        block = np.maximum(problem.block, 5) - 5  # six stances without a break are one block
        sd.append(replace(problem, residual=off, block=block).law.whitener.sd)
    assert np.sqrt(np.mean(np.square(sd))) == pytest.approx(WITHIN, rel=0.1)


@pytest.mark.slow
def test_a_bend_is_known_as_well_as_the_true_law_of_the_noise_allows() -> None:
    """Nearly: consistent with its sd, and that half as large again as the least possible.

    That gains repeat, while offsets do not, is not known beforehand. Means know far less.
    """
    size, errors, reached = 0.2, [], []
    for seed in range(80):
        problem = standing(seed, size)
        found, sd = estimate(problem, 0)
        errors.append((found - size) / sd)
        reached.append(abs(found - size) / best_possible(problem))
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(1.0, abs=0.25)
    assert np.sqrt(np.mean(np.square(reached))) < 1.6
    known = [estimate(standing(seed, size).averaged, 0)[1] for seed in range(20)]
    assert np.median(known) > 2.0 * best_possible(standing(0))


@pytest.mark.parametrize("seeds", [12, pytest.param(30, marks=pytest.mark.slow)])
def test_an_effect_does_not_pass_for_poor_repeatability(seeds: int) -> None:
    """A step between stances, as large as what they do not repeat; few tell of that variance."""
    alone, beside = [], []
    for seed in range(seeds):
        problem = standing(seed, shared=1.5)
        grams = grams_of(problem)
        plain = wandering_variance(grams.rows, grams.calibration, grams.wandering)
        freed = variance_beside(grams.rows, grams.calibration, grams.wandering, grams.candidates)
        alone.append(plain.max())
        beside.append(freed.max())
    assert np.median(beside) < 0.6 * np.median(alone)


def test_nothing_is_taken_for_an_effect_more_often_than_said() -> None:
    """z of a candidate that is not there, the variance estimated from the same stances."""
    z = []
    for seed in range(100):
        found, sd = estimate(standing(seed), 1)
        z.append(found / sd)
    # 24 stances tell of the variance: Student's t on some 20 degrees of freedom
    assert np.mean(np.abs(z) > stats.t.isf(0.025, 20)) < 0.05 + 3 * np.sqrt(0.05 / 100)


def test_what_wanders_hangs_on_no_rounding() -> None:
    """Of columns of equal information any mixture is an eigenvector."""
    problem = standing(0)
    rng = np.random.default_rng(1)
    near = 1.0 + 1e-12 * rng.standard_normal(problem.calibration.shape)
    turned = replace(problem, calibration=problem.calibration * near)
    one, other = (wandering_columns(p, p.law.whitener) for p in (problem, turned))
    assert one.shape[1] > OUTPUTS
    np.testing.assert_allclose(other, one, atol=1e-6 * np.abs(one).max())


def test_a_direction_that_one_block_shows_is_free_there() -> None:
    """However far that block is off; the others know nothing of it."""
    rng = np.random.default_rng(2)
    block = np.repeat(np.arange(20), 10)
    alone = np.where(block == 3, 1.0, 0.0)
    columns = np.column_stack([np.ones(200), rng.standard_normal(200), alone])
    residual = rng.standard_normal(200) + 1e9 * alone
    rows = block_products(np.column_stack([columns, residual]), block, 20)
    variance = wandering_variance(rows, np.array([0]), np.array([1, 2]))
    assert np.all(np.isfinite(variance))
    assert variance[0] < 1.0 < variance[1]


@pytest.mark.slow
def test_noise_of_stances_bends_with_nothing() -> None:
    """Pieces of one stance are no observations apart: 3 % and less of clean logs below 0.03."""
    p = []
    for seed in range(60):
        problem = standing(seed)
        assert has_single_rows(problem)
        features = features_of(problem)
        grams, _ = whitened_grams(problem, features.columns)
        signs = sign_patterns(grams.blocks)
        p.append(detect(problem, grams, features, grams.calibration, signs).curve.p)
    assert np.sum(np.array(p) < 0.03) <= stats.binom.ppf(0.999, 60, 0.03)
    assert np.mean(np.array(p) < 0.5) > 0.25


def test_the_mean_of_a_sequence_is_one_row() -> None:
    problem = standing(3, 0.5)
    means = problem.averaged
    assert means.residual.size == STANCES * OUTPUTS
    first = problem.sequence == problem.sequence[0]
    assert means.residual[0] == pytest.approx(problem.residual[first].mean())
    assert means.averaged.residual == pytest.approx(means.residual)


def _with_columns(columns: FloatArray) -> tuple[Grams, float]:
    problem = standing(0)
    bare = replace(
        problem, columns=columns,
        signatures=tuple(Signature("", "", str(i), "") for i in range(columns.shape[1])),
    )  # fmt: skip
    grams = grams_of(bare)
    return grams, alike_as(grams, grams.calibration, grams.candidates, LEVEL)


def test_columns_that_are_alike_count_as_one_test() -> None:
    rng = np.random.default_rng(0)
    one = rng.normal(size=(STANCES * OUTPUTS * PIECES, 1))
    assert _with_columns(np.repeat(one, 12, axis=1))[1] == pytest.approx(1.0, abs=0.15)
    apart = rng.normal(size=(one.size, 12))
    assert _with_columns(apart)[1] == pytest.approx(12.0, rel=0.15)


def test_a_column_that_the_base_holds_is_no_test() -> None:
    """What rounding leaves of it is of either sign."""
    problem = standing(0)
    rng = np.random.default_rng(4)
    held = problem.calibration @ rng.normal(size=(problem.calibration.shape[1], 12))
    assert _with_columns(held)[1] == 1.0
    apart = rng.normal(size=(held.shape[0], 12))
    assert _with_columns(np.hstack([held, apart]))[1] == pytest.approx(12.0, rel=0.15)


def test_a_family_of_shapes_keeps_its_level() -> None:
    """Knees along a load: two dozen tests, of which many are nearly the same one."""
    problem = standing(0)
    load = problem.regressors["load"]
    knees = np.stack([np.clip(load - k, 0.0, None) for k in np.linspace(-1.2, 1.2, 24)], axis=1)
    grams, many = _with_columns(knees * (problem.output == 0)[:, None])
    assert 2.0 < many < 18.0
    total = grams.inner.summed(np.arange(grams.inner.size))
    base, own = grams.calibration, grams.candidates
    left = total[np.ix_(own, own)] - total[np.ix_(own, base)] @ np.linalg.solve(
        total[np.ix_(base, base)], total[np.ix_(base, own)]
    )
    scale = np.sqrt(np.diag(left))
    z = np.random.default_rng(9).multivariate_normal(
        np.zeros(own.size), left / np.outer(scale, scale), size=20_000, method="eigh"
    )
    smallest = many * 2.0 * stats.norm.sf(np.abs(z).max(axis=1))
    assert np.mean(smallest < LEVEL) == pytest.approx(LEVEL, rel=0.25)
