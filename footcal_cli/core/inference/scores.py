"""Scores, sizes and held-out gains of candidates, from block Gram matrices alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.inference.grams import Grams
from footcal_cli.core.inference.linear import regressed, scaled_inverse
from footcal_cli.core.inference.products import Products
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

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


def scores(inner: Products, base: IntArray, columns: IntArray) -> Scores:
    """Block scores of columns after projecting them and the residual off the base.

    Parameters
    ----------
    inner
        Products of each block; the residual is the last column.
    base
        Columns that are fitted: calibration and what was accepted.
    """
    wanted = np.append(columns, inner.last)
    base_base = inner.part(base, base)
    base_wanted = inner.part(base, wanted)
    gamma = _regressed(base_base.sum(axis=0), base_wanted.sum(axis=0))
    left = inner.with_residual(wanted)
    on_base = base_base @ gamma[:, -1] - base_wanted[:, :, -1]
    score = left - gamma[:, -1] @ base_wanted
    score += on_base @ gamma
    own = inner.squares(wanted)
    # by block, since the products of all blocks at once would be as large again as `inner`
    information = own.copy()
    for b, (square, cross) in enumerate(zip(base_base, base_wanted, strict=True)):
        information[b] += np.einsum("ik,ik->k", gamma, square @ gamma - 2.0 * cross)
    information = np.clip(information[:, :-1], 0.0, None)
    whole = own[:, :-1].sum(axis=0)
    inside = (information.sum(axis=0) <= _INSIDE**2 * whole) | (whole == 0)
    keep = np.where(inside, 0.0, 1.0)
    return Scores(score[:, :-1] * keep, information * keep, inside.astype(float))


def coefficients(gram: FloatArray, base: IntArray, columns: IntArray) -> FloatArray:
    """Regression of columns on the base, shape (base, columns); rank-safe."""
    return _regressed(gram[np.ix_(base, base)], gram[np.ix_(base, columns)])


def _regressed(square: FloatArray, cross: FloatArray) -> FloatArray:
    """Regression from the products of a base with itself and with what is regressed on it."""
    # a parameter that only the left-out block knows has nothing to be fitted to
    return regressed(square, cross, _RCOND, _EMPTY)


def held_out_loss(inner: Products, base: IntArray, judged: Products | None = None) -> FloatArray:
    """Squared error of each block predicted by a base fitted to the others, shape (B,).

    Parameters
    ----------
    inner
        Products that are fitted.
    judged
        Products in which the error is counted; `inner` where absent. Same column numbers, the
        residual last.
    """
    weights = inner.fit(base, _weights_without_each)
    own = _of_fit(inner if judged is None else judged, base)
    return np.asarray(np.einsum("bi,bij,bj->b", weights, own, weights, optimize=True))


def losses_in_what_is_open(
    products: FloatArray, fitted: IntArray, without: BoolArray
) -> FloatArray:
    """Squared error of the blocks that are left out, as sure as the others are of it, shape (b,).

    ``rᵀ V⁻¹ r`` with ``V = I + A P Aᵀ``: r a block's error at the fit of the others, P⁻¹ what these
    know of all columns A. By Woodbury ``rᵀr − gᵀ (P⁻¹ + AᵀA)⁻¹ g``, ``g = Aᵀ r``. What a block
    alone knows (a plate's zero, by the one stance without load) is no error of its prediction.

    Parameters
    ----------
    products
        Of columns and, last, the residual, shape (B, k + 1, k + 1).
    fitted
        Columns that are fitted; the others are open, and 0.
    without
        Blocks that are left out, shape (B,).
    """
    rest, last = products[~without].sum(axis=0), products.shape[1] - 1
    weights = np.zeros(last + 1)
    weights[fitted] = -coefficients(rest, fitted, np.array([last]))[:, 0]
    weights[last] = 1.0
    found = []
    for own in products[without]:
        left = own @ weights
        known = scaled_inverse((rest + own)[:last, :last], _RCOND)
        found.append(float(weights @ left - left[:last] @ known @ left[:last]))
    return np.array(found)


def _weights_without_each(products: FloatArray) -> FloatArray:
    """``(−θ, 1)`` with θ the fit without each block, shape (B, p + 1)."""
    rest = products.sum(axis=0) - products
    weights = np.ones(products.shape[:2])
    weights[:, :-1] = -_regressed(rest[:, :-1, :-1], rest[:, :-1, -1:])[..., 0]
    return weights


def _of_fit(products: Products, base: IntArray) -> FloatArray:
    """Products of a base and the residual, which stands last, shape (B, p + 1, p + 1)."""
    used = np.append(base, products.last)
    return products.part(used, used)


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
    inner: Products, plain: Products, base: IntArray, groups: Sequence[IntArray]
) -> Gains:
    """What each group of columns buys on blocks it was not fitted to.

    In each fold the best column of a group (a shape) is chosen on the other blocks.

    Parameters
    ----------
    inner
        Products that are fitted and judged.
    plain
        Products in which the same fits are judged too.
    base
        Columns that are fitted anyway.
    groups
        Columns that are alternatives of one cause.
    """
    blocks = inner.blocks
    columns = np.concatenate([*groups, np.empty(0, dtype=np.int64)]).astype(np.int64)
    starts = np.concatenate([[0], np.cumsum([g.size for g in groups])]).astype(np.int64)
    white, counted, size = (np.zeros((blocks, len(groups))) for _ in range(3))
    if not columns.size:
        return Gains(white, counted, size)
    fitted = _with_each(inner, base, columns)
    judged = fitted if plain is inner else _with_each(plain, base, columns)
    total = fitted.summed()
    overall = _one_extra(total)[0]
    # the last of a smaller group again, which changes nothing of which is the first largest
    width = int(np.diff(starts).max())
    members = np.minimum(starts[:-1, None] + np.arange(width), starts[1:, None] - 1)
    best_overall = _best_of(overall, members)
    for b in range(blocks):
        rest = total.without(fitted, b)
        drop, beta, gamma, theta = _one_extra(rest)
        chosen = _best_of(drop, members)
        moved = gamma[:, chosen] * beta[chosen]
        white[b] = _gain(fitted, b, chosen, theta, moved, beta[chosen])
        counted[b] = (
            white[b] if judged is fitted else _gain(judged, b, chosen, theta, moved, beta[chosen])
        )
        size[b] = beta[best_overall]
    return Gains(white, counted, size)


@dataclass(frozen=True)
class _WithEach:
    """Inner products that adding one column to a base needs; the residual is the base's last.

    `base` (…, p + 1, p + 1) of base and residual, `cross` (…, p + 1, k) of these with each column,
    `own` (…, k) of each column with itself; of every block, or summed.
    """

    base: FloatArray
    cross: FloatArray
    own: FloatArray

    def summed(self) -> _WithEach:
        return _WithEach(self.base.sum(axis=0), self.cross.sum(axis=0), self.own.sum(axis=0))

    def without(self, parts: _WithEach, block: int) -> _WithEach:
        return _WithEach(
            self.base - parts.base[block],
            self.cross - parts.cross[block],
            self.own - parts.own[block],
        )


def _with_each(inner: Products, base: IntArray, columns: IntArray) -> _WithEach:
    used = np.append(base, inner.last)
    return _WithEach(inner.part(used, used), inner.part(used, columns), inner.squares(columns))


def _gain(
    parts: _WithEach,
    block: int,
    chosen: IntArray,
    theta: FloatArray,
    moved: FloatArray,
    beta: FloatArray,
) -> FloatArray:
    """Squared error with the base alone less that with each column added, shape (chosen,)."""
    square, cross = parts.base[block], parts.cross[block][:, chosen]
    before = np.append(-theta, 1.0)
    after = before[:, None] + np.vstack([moved, np.zeros(chosen.size)])
    loss = np.einsum("ik,ik->k", after, square @ after)
    loss -= 2.0 * beta * np.einsum("ik,ik->k", after, cross)
    loss += beta**2 * parts.own[block][chosen]
    return np.asarray(before @ square @ before - loss)


def _one_extra(parts: _WithEach) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Of each column added alone: drop in squared error, size, base coefficients; of the residual.

    Base coefficients are those of the regression on the base, shape (p, k) and (p,).
    """
    both = _regressed(parts.base[:-1, :-1], np.hstack([parts.cross[:-1], parts.base[:-1, -1:]]))
    gamma, theta = both[:, :-1], both[:, -1]
    visible = parts.own - np.einsum("ik,ik->k", gamma, parts.cross[:-1])
    score = parts.cross[-1] - gamma.T @ parts.base[:-1, -1]
    seen = visible > _INSIDE**2 * np.maximum(parts.own, 1e-300)
    beta = np.divide(score, visible, out=np.zeros_like(score), where=seen)
    return beta * score, beta, gamma, theta


def _best_of(values: FloatArray, members: IntArray) -> IntArray:
    """Index of the largest value of each group, `members` of shape (groups, width)."""
    best = np.argmax(values[members], axis=1)
    return np.asarray(members[np.arange(best.size), best])


def cosines(inner: Products, base: IntArray, columns: IntArray) -> FloatArray:
    """Cosines between the visible parts of columns, in the metric of the noise, shape (k, k)."""
    whole, visible = visible_products(inner, base, columns)
    own = np.diag(visible)
    seen = own > _INSIDE**2 * np.maximum(whole, 1e-300)
    norm = np.where(seen, np.sqrt(np.maximum(own, 1e-300)), np.inf)
    return np.asarray(visible / np.outer(norm, norm))


def visible_products(
    inner: Products, base: IntArray, columns: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Squares of columns, shape (k,), and products of what a base leaves of them, (k, k)."""
    # of many columns the products among themselves are the most work, and the same for any base
    beside = inner.part(base, np.concatenate([base, columns])).sum(axis=0)
    fitted, across = np.split(beside, [base.size], axis=1)
    total = np.block([[fitted, across], [across.T, inner.summed(columns)]])
    first, then = np.split(np.arange(len(total)), [base.size])
    gamma = coefficients(total, first, then)
    return np.diag(total)[then], total[np.ix_(then, then)] - gamma.T @ total[np.ix_(first, then)]


def joint_sizes(grams: Grams, base: IntArray, chosen: IntArray) -> tuple[FloatArray, FloatArray]:
    """Sizes of chosen columns fitted together, and without each block, (k,) and (B, k)."""
    small = _of_fit(grams.inner, np.concatenate([base, chosen]))
    total = small.sum(axis=0)
    return _last_sizes(total, chosen.size), _last_sizes(total - small, chosen.size)


def sizes_together(grams: Grams, base: IntArray, chosen: IntArray) -> FloatArray:
    """Sizes of chosen columns fitted together, shape (k,)."""
    small = _of_fit(grams.inner, np.concatenate([base, chosen]))
    return _last_sizes(small.sum(axis=0), chosen.size)


def _last_sizes(gram: FloatArray, wanted: int) -> FloatArray:
    """Of the last columns before the residual, shape (…, wanted)."""
    found = _regressed(gram[..., :-1, :-1], gram[..., :-1, -1:])[..., 0]
    return np.asarray(found[..., found.shape[-1] - wanted :])
