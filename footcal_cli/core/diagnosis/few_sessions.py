"""A bench of two or three sessions per channel: what judges a cause where signs cannot.

Room: core.diagnosis; asked by weighing, search, nested, standing and engine.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

FEW_BLOCKS = 16
"""Below so many blocks in all, signs do not reach the level of a family in half of them."""
NOTHING = 1e-9  # share of the most informative block, below which one says nothing


def are_few_sessions(problem: Problem) -> bool:
    """Whether a bench has so few sessions in all that no signs could judge half of them.

    Each channel has its own; two sessions of each of four cells are eight blocks. How far block
    scores scatter is then known from all candidates of a form together.
    """
    loose = problem.drifts or problem.pieces or problem.known is not None
    return not loose and problem.settings is None and problem.blocks < FEW_BLOCKS


def of_few_sessions_p(
    score: FloatArray, information: FloatArray, form: IntArray, alone: BoolArray, forms: float
) -> FloatArray:
    """Single p of each candidate where a channel has two or three sessions, shape (k,).

    As `of_one_form_p`; but what moves block scores (drift, a weight put down anew) moves those of
    all forms, so that the scatter beside one's own size is known from so many independent ones:
    φ is the largest of the candidate's own, its form's, and that of all which are of one sensor,
    with (B − c) f degrees. What one of them has is no scatter of what all have.

    Parameters
    ----------
    score, information, form
        As in `of_one_form_p`.
    alone
        Candidates of one sensor, shape (k,).
    forms
        Number f of independent forms per sensor.
    """
    known = information > NOTHING * information.max(axis=0, initial=0.0)
    shares = np.where(known, information, np.inf)
    total = np.sum(np.where(known, information, 0.0), axis=0)
    size = np.sum(np.where(known, score, 0.0), axis=0) / total
    left = np.sum((score - size * information) ** 2 / shares, axis=0)
    freedom = known.sum(axis=0) - 1.0
    each = np.bincount(form, left) / np.maximum(np.bincount(form, freedom), 1.0)
    scatter = np.maximum(each[form], left / np.maximum(freedom, 1.0))
    degrees = float(np.bincount(form[alone], freedom[alone], minlength=1).max())
    if degrees < 1.0:
        return np.ones(size.size)
    scatter = np.maximum(scatter, left[alone].sum() / freedom[alone].sum())
    t = np.abs(size) * np.sqrt(total / np.maximum(scatter, 1e-300))
    return np.asarray(2.0 * chances.t_sf(t, degrees * max(forms, 1.0)))
