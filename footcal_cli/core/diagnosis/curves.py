"""Does the residual bend with a recorded signal? An F test, where rows are single observations.

A stance or a pose is a mean over seconds: what rows do not share is as good as normal, and the
scatter of all rows tells how large it is. Sign flips ask for many blocks that carry the effect; a
sole that rolls over its edge in four stances of twenty cannot reach any level by them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.features import Features
from footcal_cli.core.inference.grams import Grams
from footcal_cli.core.inference.scores import coefficients
from footcal_cli.core.parameters import FloatArray, IntArray

_DEPENDENT = 1e-3
"""A direction with less than this share of the largest one's information is not counted."""
_RANK = 1e-9


@dataclass(frozen=True)
class Curve:
    """The signal with which the residual bends most surely.

    Parameters
    ----------
    p
        Over all signals (Bonferroni).
    name
        The signal.
    share
        Share of the squared error that its curve explains beyond chance.
    """

    p: float = 1.0
    name: str = ""
    share: float = 0.0


def strongest_curve(grams: Grams, features: Features, base: IntArray, rows: int) -> Curve:
    """Test the curves in every signal.

    ``F = (S/k) / ((R − S)/(n − r − k))`` with S the squared error that a signal's k independent
    curves take from what the base of rank r leaves, R.

    Parameters
    ----------
    grams, features
        Rows whitened, no series.
    base
        Columns that are fitted.
    rows
        How many rows there are, n.
    """
    left, whole, rank = _left(grams, base, grams.features[features.curved])
    error, freedom = float(left[-1, -1]), rows - rank
    found = []
    for g, name in enumerate(features.names):
        mine = np.flatnonzero(features.group[features.curved] == g)
        taken, k = _taken(left[np.ix_(mine, mine)], left[mine, -1], whole[mine])
        if k and freedom > 2 * k and taken < error:
            share = (taken - k * (error - taken) / (freedom - k)) / error
            found.append((_f_p(taken, k, error, freedom), name, share))
    if not found:
        return Curve()
    p, name, share = min(found)
    return Curve(min(1.0, len(found) * p), name, max(share, 0.0))


def explained(grams: Grams, base: IntArray, columns: IntArray) -> tuple[float, int]:
    """Squared error that columns take from what a base leaves, and how many are independent."""
    left, whole, _ = _left(grams, base, columns)
    return _taken(left[:-1, :-1], left[:-1, -1], whole)


def explained_each(grams: Grams, base: IntArray, columns: IntArray) -> FloatArray:
    """Squared error that each column takes alone from what a base leaves, shape (k,).

    None where a column depends on the base.
    """
    left, whole, _ = _left(grams, base, columns)
    own, score = np.diag(left)[:-1], left[:-1, -1]
    kept = own > _DEPENDENT**2 * whole
    return np.divide(score**2, own, out=np.zeros_like(own), where=kept)


def explained_p(grams: Grams, base: IntArray, columns: IntArray, rows: int) -> float:
    """The p, by the F test of `strongest_curve`, that columns explain nothing beside a base."""
    left, whole, rank = _left(grams, base, columns)
    error, freedom = float(left[-1, -1]), rows - rank
    taken, k = _taken(left[:-1, :-1], left[:-1, -1], whole)
    if not k or freedom <= 2 * k:
        return 1.0
    # columns that take all there is leave nothing to chance
    return _f_p(taken, k, error, freedom) if taken < error else 0.0


def _f_p(taken: float, k: int, error: float, freedom: int) -> float:
    """The p that k of so many free directions take so much of the squared error by chance."""
    scatter = (error - taken) / (freedom - k)
    return float(chances.f_sf(taken / k / scatter, k, freedom - k))


def _left(grams: Grams, base: IntArray, columns: IntArray) -> tuple[FloatArray, FloatArray, int]:
    """Products of columns and the residual, which stands last, after a base was fitted.

    Beside them squares of the columns before, shape (k,), and the rank of the base.
    """
    total = grams.inner.summed(np.concatenate([base, columns, [grams.inner.last]]))
    first, wanted = np.split(np.arange(len(total)), [base.size])
    left = total[np.ix_(wanted, wanted)]
    left = left - total[np.ix_(wanted, first)] @ coefficients(total, first, wanted)
    return left, np.diag(total)[wanted[:-1]], _rank(total[np.ix_(first, first)])


def _taken(seen: FloatArray, score: FloatArray, whole: FloatArray) -> tuple[float, int]:
    """``sᵀ I⁻¹ s`` over the independent directions, and their number."""
    own = np.diag(seen)
    kept = own > _DEPENDENT**2 * whole
    if not kept.any():
        return 0.0, 0
    scale = np.sqrt(own[kept])
    values, vectors = np.linalg.eigh(seen[np.ix_(kept, kept)] / np.outer(scale, scale))
    clear = values > _DEPENDENT * values.max()
    turned = (score[kept] / scale) @ vectors[:, clear]
    return float(np.sum(turned**2 / values[clear])), int(clear.sum())


def _rank(square: FloatArray) -> int:
    own = np.sqrt(np.clip(np.diag(square), 1e-300, None))
    return int(np.linalg.matrix_rank(square / np.outer(own, own), tol=_RANK, hermitian=True))
