"""Spells in which a reading is off to one side: a tugged cable comes and goes at no set time."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from footcal_cli.core.diagnosis.jumps import jump_beside
from footcal_cli.core.inference.evidence import sign_flip_max_t
from footcal_cli.core.inference.linear import left_by
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.whitening import residual_within_blocks
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import starts_of

WINDOWS = (1, 5, 13)
"""Rows over which the residual is averaged before it is asked for its side."""
_RCOND = 1e-9
_SHORTEST = 3 * max(WINDOWS)
_ORDER = "order of recording"
_NEIGHBOURS = 6
_PATTERNS = 4095


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
    """Sign-flip p that placements are like those just before them, ``Σ_t Σ_{k≤6} e_t·e_{t−k}``.

    Every setting-up has its own offsets and gains first.
    """
    if problem.settings is not None:
        number, loose = problem.settings.number, problem.settings.columns
        own = [np.where((number == s)[:, None], loose, 0.0) for s in np.unique(number)]
        fitted = np.hstack([fitted, *own])
    residual = left_by(fitted, problem.residual, _RCOND)
    place, when = np.unique(problem.regressors[_ORDER], return_inverse=True)
    error = np.zeros((place.size, len(problem.outputs)))
    for o in range(len(problem.outputs)):
        rows = problem.output == o
        spread = float(np.sqrt(np.mean(residual[rows] ** 2))) if rows.any() else 0.0
        if spread > 0:
            error[when[rows], o] = residual[rows] / spread
    apart = np.arange(place.size)[:, None] - np.arange(place.size)[None]
    alike = np.where((apart > 0) & (apart <= _NEIGHBOURS), error @ error.T, 0.0)
    signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(_PATTERNS, place.size))
    null = np.einsum("pt,pt->p", signs @ alike, signs)
    return float((1 + np.sum(null >= alike.sum())) / (1 + _PATTERNS))
