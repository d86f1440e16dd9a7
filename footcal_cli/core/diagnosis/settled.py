"""Columns white across settings, whose variances an effect that is there does not swell."""

from __future__ import annotations

import numpy as np
from scipy import stats

from footcal_cli.core.diagnosis.problem import Problem
from footcal_cli.core.diagnosis.settings import (
    Parts,
    Settings,
    fitted,
    repeated,
    row_levels,
    variance_between,
    within_settings,
)
from footcal_cli.core.diagnosis.whitening import RowWhitener
from footcal_cli.core.parameters import FloatArray, IntArray

_MOST_SUSPECTS = 3
"""Candidates that may be taken for effects while variances are estimated."""
_RARE = 0.05
"""Probability with which the best of all candidates explains that much of noise."""
_INSIDE = 1e-8
"""Share of a column's square that calibration leaves, below which it leaves none."""


def settled(
    problem: Problem,
    settings: Settings,
    white: FloatArray,
    whitener: RowWhitener,
    shared: int,
    candidates: IntArray,
) -> FloatArray:
    """Columns whitened for what differs between settings, and between their parts, shape (n, k).

    Few hangings tell of the variance between them: an effect would pass for poor repeatability for
    most of its size. A candidate that stands out even so, the variance estimated beside it as in a
    t-test, is fitted while the variances are estimated; it remains a candidate.

    Parameters
    ----------
    problem, settings
        Rows, and what may differ.
    white
        Columns white within a part, the residual last, shape (n, k).
    whitener
        That made them so.
    shared
        How many of the columns are fitted in common; they come first.
    candidates
        Columns.
    """
    kept = whitener.kept
    loose, spread = whitener(settings.columns), whitener(settings.spread())
    parts, groups = settings.parts(problem.output, kept), settings.rows(kept)
    own = loose.shape[1]
    fitted_too = np.arange(shared)
    while True:
        both = _within(np.hstack([loose, white]), own, fitted_too + own, spread, parts)
        free, out = both[:, :own], both[:, own:]
        variance = variance_between(out[:, fitted_too], free, out[:, -1], groups, settings.kind)
        if candidates.size and fitted_too.size < shared + _MOST_SUSPECTS:
            best, _ = _strongest(out, fitted_too, candidates)
            beside = np.append(fitted_too, best)
            less = variance_between(out[:, beside], free, out[:, -1], groups, settings.kind)
            _, z = _strongest(repeated(out, free, groups, less), fitted_too, np.array([best]))
            if z > float(stats.norm.isf(0.5 * _RARE / candidates.size)):
                fitted_too = beside
                continue
        return repeated(out, free, groups, variance)


def _within(
    columns: FloatArray, offsets: int, common: IntArray, spread: FloatArray, parts: list[Parts]
) -> FloatArray:
    """Columns white within a setting, where it has parts.

    Parameters
    ----------
    columns
        Z first, the residual last.
    offsets
        Number of columns of Z.
    common
        Which of the columns are fitted in common.
    spread, parts
        Z of each setting, and of its parts.
    """
    if not parts:
        return columns
    loose = columns[:, :offsets]
    level = row_levels(columns[:, -1], loose, parts)[:, None]
    shared = np.hstack([columns[:, common], spread]) / level
    return within_settings(
        columns / level, shared, loose / level, columns[:, -1] / level[:, 0], parts
    )


def _strongest(white: FloatArray, base: IntArray, candidates: IntArray) -> tuple[int, float]:
    """The candidate with the largest ``|z| = |g̃·r̃| / |g̃|`` beside a base, and that."""
    wanted = white[:, np.append(candidates, white.shape[1] - 1)]
    left = wanted - white[:, base] @ fitted(white[:, base], wanted)
    information = np.sum(left[:, :-1] ** 2, axis=0)
    shown = information > _INSIDE * np.sum(wanted[:, :-1] ** 2, axis=0)
    z = np.abs(left[:, :-1].T @ left[:, -1]) / np.sqrt(np.where(shown, information, np.inf))
    best = int(np.argmax(z))
    return int(candidates[best]), float(z[best])
