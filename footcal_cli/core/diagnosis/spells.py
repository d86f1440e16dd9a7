"""Spells in which a reading is off to one side: a tugged cable comes and goes at no set time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from footcal_cli.core.diagnosis.jumps import jump_beside
from footcal_cli.core.inference.evidence import sign_flip_max_t
from footcal_cli.core.inference.linear import left_by
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.whitening import residual_within_blocks
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.signals import starts_of

WINDOWS = (1, 5, 13)
"""Rows over which the residual is averaged before it is asked for its side."""
_RCOND = 1e-9
_SHORTEST = 3 * max(WINDOWS)
_ORDER = "order of recording"
_REACHES = (3, 6, 12, 24)
"""Placements before that one is compared with: spells are of any length."""
_PATTERNS, _DRAWS = 4096, 16
_TINY = 1e-300


def spell_p(problem: Problem, signs: FloatArray, accepted: FloatArray | None = None) -> float:
    """The p of spells: by sign flips, that the residual leans to one side within blocks.

    Third moment ``Σ x³ / (Σ x²)^{3/2}`` of each block about its own calibration: noise of any
    colour, quantised or growing with the load, is as often long-tailed up as down. A spell pulls
    one way. Where the calibration drifts, channels that rest must not jump. Single placements are
    no series: there a spell makes neighbours in time alike.

    Parameters
    ----------
    problem
        Rows.
    signs
        Sign patterns of the blocks.
    accepted
        Row columns of effects that were named, shape (m, a).
    """
    fitted = problem.fitted if accepted is None else np.hstack([problem.fitted, accepted])
    if problem.rate_hz <= 0 and _ORDER in problem.regressors:
        return _neighbours_p(problem, fitted)
    if problem.drifts:
        return jump_beside(problem, fitted).p
    if problem.rate_hz <= 0 or problem.settings is not None:
        return 1.0
    residual = residual_within_blocks(problem, left_by(fitted, problem.residual, _RCOND))
    leaning = np.zeros((problem.blocks, len(WINDOWS)))
    starts = starts_of(problem.sequence)
    for rows in np.split(np.arange(residual.size), starts[1:]):
        if rows.size < _SHORTEST:
            continue
        for i, window in enumerate(WINDOWS):
            x = ndimage.uniform_filter1d(residual[rows], window, mode="nearest")
            spread = float(np.mean(x**2))
            if spread > 0:
                lean = np.mean((x - x.mean()) ** 3) / spread**1.5
                leaning[problem.block[rows[0]], i] += lean * np.sqrt(rows.size)
    return float(sign_flip_max_t(leaning, signs).p.min())


def _neighbours_p(problem: Problem, fitted: FloatArray) -> float:
    """Sign-flip p that placements are like those just before them, ``Σ_t Σ_{k≤K} e_t·e_{t−k}``.

    Over the whole squared error, for a few reaches K, of which the largest in units of its own
    scatter counts. Every setting-up has its own offsets and gains first. What is fitted makes
    neighbours unlike, so that placements of turned sign are fitted again (Freedman and Lane).
    """
    if problem.settings is not None:
        number, loose = problem.settings.number, problem.settings.columns
        own = [np.where((number == s)[:, None], loose, 0.0) for s in np.unique(number)]
        fitted = np.hstack([fitted, *own])
    residual = left_by(fitted, problem.residual, _RCOND)
    place, when = np.unique(problem.regressors[_ORDER], return_inverse=True)
    reaches = [reach for reach in _REACHES if reach < place.size]
    if not residual.any() or not reaches:
        return 1.0
    rng = np.random.default_rng(0)
    found = [_alike(problem, residual[None], when, reaches)]
    for _ in range(_DRAWS):
        signs = rng.choice([-1.0, 1.0], size=(_PATTERNS // _DRAWS, place.size))
        turned = left_by(fitted, (signs[:, when] * residual).T, _RCOND).T
        found.append(_alike(problem, turned, when, reaches))
    alike = np.concatenate(found)
    null = alike[1:]
    largest = np.max((alike - null.mean(axis=0)) / (null.std(axis=0) + _TINY), axis=1)
    return float(np.mean(largest >= largest[0]))


def _alike(
    problem: Problem, residual: FloatArray, when: IntArray, reaches: Sequence[int]
) -> FloatArray:
    """Sums of products with the placements before, over that of squares, (patterns, reaches)."""
    sums, whole = np.zeros((len(reaches), len(residual))), np.full(len(residual), _TINY)
    for o in range(len(problem.outputs)):
        rows = problem.output == o
        spread = np.sqrt(np.mean(residual[:, rows] ** 2, axis=1, keepdims=True))
        error = np.zeros((len(residual), int(when.max()) + 1))
        error[:, when[rows]] = residual[:, rows] / (spread + _TINY)
        so_far = np.cumsum(error, axis=1)
        sums += _products(error[:, 1:], so_far)  # less those with what is too long ago
        for i, reach in enumerate(reaches):
            sums[i] -= _products(error[:, reach + 1 :], so_far)
        whole += _products(error, error)
    return np.asarray((sums / whole).T)


def _products(error: FloatArray, so_far: FloatArray) -> FloatArray:
    """Sum over the rows of two arrays of patterns, the longer cut at its end, shape (patterns,)."""
    return np.asarray(np.einsum("pt,pt->p", error, so_far[:, : error.shape[1]]))
