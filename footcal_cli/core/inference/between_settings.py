"""How much a setting-up does not repeat: the upper end of a variance between few settings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import optimize

from footcal_cli.core import chances
from footcal_cli.core.inference.linear import inverse_beside
from footcal_cli.core.inference.settings import RCOND, STEPS, STOP
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

_UPPER = 0.1
"""The variance is taken so large that a larger one would have shown less with this probability."""
_LEAST, _MOST = 1e-6, 1e6  # variance between settings against that of one row


def variance_between(
    calibration: FloatArray,
    loose: FloatArray,
    residual: FloatArray,
    groups: list[IntArray],
    kind: IntArray,
) -> FloatArray:
    """Upper value of each column's variance between settings, shape (q,).

    Predictions û of what differs come from the mixed-model equations (Henderson), in which the
    fitted calibration's own uncertainty counts, and the other kinds of columns at their variance.

    Parameters
    ----------
    calibration, loose, residual
        Columns that all settings share, Z, and the residual, white within a setting.
    kind
        As in `Settings`.
    """
    common = np.column_stack([calibration, residual])
    sums = _Sums(
        common.T @ common,
        np.stack([loose[rows].T @ common[rows] for rows in groups]),
        np.stack([loose[rows].T @ loose[rows] for rows in groups]),
    )
    kinds = int(kind.max()) + 1
    variance = np.full(kinds, _LEAST)
    for _ in range(STEPS):
        before = variance.copy()
        for g in range(kinds):
            variance[g] = _upper(sums.beside(kind == g, variance[kind]))
        if float(np.abs(np.log(variance / before)).max()) < STOP:
            break
    return np.asarray(variance[kind])


@dataclass(frozen=True)
class _Sums:
    """Products from which the mixed-model equations follow.

    Parameters
    ----------
    common
        Of the calibration's columns and the residual, shape (p + 1, p + 1).
    cross, own
        Of each setting's Z with these and with itself, shapes (S, q, p + 1) and (S, q, q).
    """

    common: FloatArray
    cross: FloatArray
    own: FloatArray

    def beside(self, asked: BoolArray, variance: FloatArray) -> Shown:
        """What settings show of the columns asked for, once all else is fitted.

        A setting's other columns touch no other setting: they are eliminated there, and then the
        calibration's columns from what is left.

        Parameters
        ----------
        asked
            Columns of Z, shape (q,).
        variance
            Of each, shape (q,): the prior of those not asked for.
        """
        others = ~asked
        inner = self.own[:, others][:, :, others] + np.diag(1.0 / variance[others])
        theirs = np.concatenate([self.own[:, others][:, :, asked], self.cross[:, others]], axis=2)
        solved = np.linalg.solve(inner, theirs)
        a = int(asked.sum())
        square = self.own[:, asked][:, :, asked] - theirs[..., :a].swapaxes(1, 2) @ solved[..., :a]
        cross = self.cross[:, asked] - theirs[..., :a].swapaxes(1, 2) @ solved[..., a:]
        taken = np.einsum("sox,soy->xy", theirs[..., a:], solved[..., a:])
        common = self.common - taken
        inverse = inverse_beside(common[:-1, :-1], np.sqrt(np.diag(self.common)[:-1]), RCOND)
        values, vectors = np.linalg.eigh(square)
        turned = np.reshape(vectors.swapaxes(1, 2) @ cross, (values.size, -1))
        size, ways = np.linalg.eigh(inverse)
        root = ways[:, size > 0.0] * np.sqrt(size[size > 0.0])
        score = turned[:, -1] - turned[:, :-1] @ (inverse @ common[:-1, -1])
        return Shown(np.maximum(values, 0.0).ravel(), turned[:, :-1] @ root, score)


@dataclass(frozen=True)
class Shown:
    """Information ``M = diag(λ) − W Wᵀ`` about predictions, and their score b, both turned alike.

    Parameters
    ----------
    own
        λ, what each setting alone shows, shape (n,).
    common
        W, what the calibration takes of it, shape (n, r).
    score
        Shape (n,).
    """

    own: FloatArray
    common: FloatArray
    score: FloatArray

    def more(self, log_variance: float) -> float:
        """``û'û / v`` of a variance v, less what it is with probability `_UPPER` at least.

        ``K = (I + v M)⁻¹`` by Woodbury: ``Σ k = n − tr K`` and ``Σ k² = n − 2 tr K + tr K²``.
        """
        v = float(np.exp(log_variance))
        inner = 1.0 / (1.0 + v * self.own)
        weighted = inner[:, None] * self.common
        beside = self.common.T @ weighted
        middle = v * np.linalg.inv(np.eye(len(beside)) - v * beside)
        squared = weighted.T @ weighted
        both = middle @ squared
        found = inner * self.score
        found = found + weighted @ (middle @ (weighted.T @ self.score))
        # 1 − 1/(1 + v λ) without the difference of what is nearly equal
        share = v * self.own * inner
        one = float(share.sum() - np.trace(both))
        cubed = np.trace(middle @ (weighted.T @ (inner[:, None] * weighted)))
        two = float(
            np.sum(share**2) + 2.0 * (cubed - np.trace(both)) + np.einsum("ij,ji->", both, both)
        )
        if one <= 0.0 or two <= 0.0:
            return 0.0
        return v * float(found @ found) - two / one * float(chances.chi2_ppf(_UPPER, one**2 / two))


def _upper(shown: Shown) -> float:
    """Variance v under which predictions as small as these come with probability `_UPPER`.

    ``û = v (I + v M)⁻¹ b``, M the information about u once all else is fitted, b the score. If v is
    true then û'û/v is a sum of χ²₁ with weights ``k_i = v λ_i / (1 + v λ_i)``, λ the eigenvalues
    of M; that is near to ``(Σk²/Σk) χ²`` on ``(Σk)²/Σk²`` degrees of freedom (Satterthwaite).
    """
    low, high = np.log(_LEAST), np.log(_MOST)
    if shown.more(low) <= 0.0:
        return _LEAST
    if shown.more(high) >= 0.0:
        return _MOST
    return float(np.exp(optimize.brentq(shown.more, low, high, xtol=STOP)))
