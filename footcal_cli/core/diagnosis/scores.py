"""Scores, sizes and held-out gains of candidates, from block Gram matrices alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from footcal_cli.core.diagnosis.whitening import Grams
from footcal_cli.core.parameters import FloatArray, IntArray

_RCOND = 1e-9
_INSIDE = 1e-7
_EMPTY = 1e-14
"""A column whose visible part is below this share of itself lies within the base."""


@dataclass(frozen=True)
class Scores:
    """What the residual says about each candidate after the base has been refitted.

    Parameters
    ----------
    score
        ``g̃_b · r̃_b``, shape (B, k).
    information
        ``|g̃_b|²``, shape (B, k).
    inside
        Which candidates lie within the span of the base, shape (k,).
    """

    score: FloatArray
    information: FloatArray
    inside: FloatArray

    @property
    def size(self) -> FloatArray:
        """Expected size ``Σ s / Σ |g̃|²``, shape (k,)."""
        total = self.information.sum(axis=0)
        found: FloatArray = np.divide(
            self.score.sum(axis=0), total, out=np.zeros_like(total), where=self.inside == 0
        )
        return found


def scores(inner: FloatArray, base: IntArray, columns: IntArray) -> Scores:
    """Block scores of columns after projecting them and the residual off the base.

    Parameters
    ----------
    inner
        Gram matrices of the blocks, shape (B, n, n); the residual is the last column.
    base
        Columns that are fitted: calibration and what was accepted.
    columns
        Candidates.
    """
    last = inner.shape[1] - 1
    total = inner.sum(axis=0)
    wanted = np.append(columns, last)
    gamma = coefficients(total, base, wanted)
    left = inner[:, wanted[:, None], wanted[None, :]][:, :, -1]
    base_base = inner[:, base[:, None], base[None, :]]
    base_wanted = inner[:, base[:, None], wanted[None, :]]
    on_base = np.einsum("bij,j->bi", base_base, gamma[:, -1]) - base_wanted[:, :, -1]
    score = left - np.einsum("bik,i->bk", base_wanted, gamma[:, -1])
    score += np.einsum("ik,bi->bk", gamma, on_base)
    own = np.einsum("bkk->bk", inner[:, wanted[:, None], wanted[None, :]])
    information = (
        own
        - 2.0 * np.einsum("ik,bik->bk", gamma, base_wanted)
        + np.einsum("ik,bij,jk->bk", gamma, base_base, gamma, optimize=True)
    )
    information = np.clip(information[:, :-1], 0.0, None)
    whole = own[:, :-1].sum(axis=0)
    inside = (information.sum(axis=0) <= _INSIDE**2 * whole) | (whole == 0)
    keep = np.where(inside, 0.0, 1.0)
    return Scores(score[:, :-1] * keep, information * keep, inside.astype(float))


def coefficients(gram: FloatArray, base: IntArray, columns: IntArray) -> FloatArray:
    """Regression of columns on the base, shape (base, columns); rank-safe."""
    if not base.size:
        return np.empty((0, columns.size))
    square = gram[np.ix_(base, base)]
    own = np.diag(square)
    # a parameter that only the left-out block knows has nothing to be fitted to
    scale = np.sqrt(np.where(own > _EMPTY * own.max(initial=0.0), own, np.inf))
    normed = square / np.outer(scale, scale)
    inverse = np.linalg.pinv(normed, rcond=_RCOND, hermitian=True)
    return np.asarray((inverse @ (gram[np.ix_(base, columns)] / scale[:, None])) / scale[:, None])


def held_out_loss(
    inner: FloatArray, base: IntArray, judged: FloatArray | None = None
) -> FloatArray:
    """Squared error of each block predicted by a base fitted to the others, shape (B,).

    Parameters
    ----------
    inner
        Gram matrices that are fitted, shape (B, n, n).
    base
        Columns.
    judged
        Gram matrices in which the error is counted; `inner` where absent. Same column numbers,
        the residual last.
    """
    last = inner.shape[1] - 1
    total = inner.sum(axis=0)
    loss = np.empty(inner.shape[0])
    for b, gram in enumerate(inner):
        fitted = coefficients(total - gram, base, np.array([last]))[:, 0]
        weights = np.append(-fitted, 1.0)
        own = gram if judged is None else judged[b]
        used = np.append(base, own.shape[0] - 1)
        loss[b] = weights @ own[np.ix_(used, used)] @ weights
    return loss


@dataclass(frozen=True)
class Gains:
    """What each cause buys on blocks it was not fitted to.

    Parameters
    ----------
    white, plain
        Reduction of the held-out squared error, in the metric of the noise and as the user counts
        it, shape (B, causes).
    size
        Size of each cause's column that is best on all blocks, fitted without each block,
        shape (B, causes).
    """

    white: FloatArray
    plain: FloatArray
    size: FloatArray


def held_out_gains(
    inner: FloatArray, plain: FloatArray, base: IntArray, groups: Sequence[IntArray]
) -> Gains:
    """What each group of columns buys on blocks it was not fitted to.

    In each fold the best column of a group (a shape) is chosen on the other blocks.

    Parameters
    ----------
    inner
        Gram matrices that are fitted and judged, shape (B, n, n).
    plain
        Gram matrices in which the same fits are judged too.
    base
        Columns that are fitted anyway.
    groups
        Columns that are alternatives of one cause.
    """
    blocks, last = inner.shape[0], inner.shape[1] - 1
    total = inner.sum(axis=0)
    columns = np.concatenate([*groups, np.empty(0, dtype=np.int64)]).astype(np.int64)
    starts = np.concatenate([[0], np.cumsum([g.size for g in groups])]).astype(np.int64)
    white, counted, size = (np.zeros((blocks, len(groups))) for _ in range(3))
    if not columns.size:
        return Gains(white, counted, size)
    overall, _, _ = _one_extra(total, base, columns)
    best_overall = _best_of(overall, starts)
    for b, gram in enumerate(inner):
        rest = total - gram
        drop, beta, gamma = _one_extra(rest, base, columns)
        chosen = _best_of(drop, starts)
        theta = coefficients(rest, base, np.array([last]))[:, 0]
        moved = gamma[:, chosen] * beta[chosen]
        white[b] = _gain(gram, base, columns[chosen], theta, moved, beta[chosen])
        counted[b] = _gain(plain[b], base, columns[chosen], theta, moved, beta[chosen])
        size[b] = beta[best_overall]
    return Gains(white, counted, size)


def _gain(
    gram: FloatArray,
    base: IntArray,
    columns: IntArray,
    theta: FloatArray,
    moved: FloatArray,
    beta: FloatArray,
) -> FloatArray:
    """Squared error with the base alone less that with each column added, shape (columns,)."""
    used = np.append(base, gram.shape[0] - 1)
    square = gram[np.ix_(used, used)]
    before = np.append(-theta, 1.0)
    after = before[:, None] + np.vstack([moved, np.zeros(columns.size)])
    loss = np.einsum("ik,ij,jk->k", after, square, after, optimize=True)
    loss -= 2.0 * beta * np.einsum("ik,ik->k", after, gram[np.ix_(used, columns)])
    loss += beta**2 * gram[columns, columns]
    return np.asarray(before @ square @ before - loss)


def _one_extra(
    gram: FloatArray, base: IntArray, columns: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Drop in squared error, size, and base coefficients of each column added alone."""
    last = gram.shape[0] - 1
    gamma = coefficients(gram, base, columns)
    visible = gram[columns, columns] - np.einsum("ik,ik->k", gamma, gram[np.ix_(base, columns)])
    score = gram[columns, last] - gamma.T @ gram[base, last]
    seen = visible > _INSIDE**2 * np.maximum(gram[columns, columns], 1e-300)
    beta = np.divide(score, visible, out=np.zeros_like(score), where=seen)
    return beta * score, beta, gamma


def _best_of(values: FloatArray, starts: IntArray) -> IntArray:
    """Index of the largest value of each group."""
    return np.array(
        [a + int(np.argmax(values[a:b])) for a, b in pairwise(starts)],
        dtype=np.int64,
    )


def cosines(inner: FloatArray, base: IntArray, columns: IntArray) -> FloatArray:
    """Cosines between the visible parts of columns, in the metric of the noise, shape (k, k)."""
    total = inner.sum(axis=0)
    gamma = coefficients(total, base, columns)
    visible = total[np.ix_(columns, columns)] - gamma.T @ total[np.ix_(base, columns)]
    own = np.diag(visible)
    seen = own > _INSIDE**2 * np.maximum(total[columns, columns], 1e-300)
    norm = np.where(seen, np.sqrt(np.maximum(own, 1e-300)), np.inf)
    return np.asarray(visible / np.outer(norm, norm))


def joint_sizes(grams: Grams, base: IntArray, chosen: IntArray) -> tuple[FloatArray, FloatArray]:
    """Sizes of chosen columns fitted together, and without each block, (k,) and (B, k)."""
    inner = grams.inner
    last = np.array([inner.shape[1] - 1])
    total = inner.sum(axis=0)
    together = np.concatenate([base, chosen])
    value = coefficients(total, together, last)[base.size :, 0]
    without = np.stack(
        [coefficients(total - gram, together, last)[base.size :, 0] for gram in inner]
    )
    return value, without
