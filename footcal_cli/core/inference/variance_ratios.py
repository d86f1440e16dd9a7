"""Variance ratios of blocks by restricted maximum likelihood, with first and second derivatives.

``V = 1 + Z Λ Zᵀ`` in units of σ_e², Λ = diag(λ) and λ_k = σ_k²/σ_e², block by block. Profiled over
β and σ_e², the restricted deviance (Patterson and Thompson 1971) is

``D = (n − p) ln r + ln det V + ln det XᵀV⁻¹X``,  r = yᵀV⁻¹y − yᵀV⁻¹X (XᵀV⁻¹X)⁻¹ XᵀV⁻¹y,

of which only sums per block are needed. With ``M = ZᵀV⁻¹Z`` and ``c_k = [X y]ᵀV⁻¹z_k`` of a block,
and all derivatives by ``ln λ``:

``∂_k [X y]ᵀV⁻¹[X y] = −λ_k Σ c_k c_kᵀ`` and ``∂_l c_k = −λ_l M_kl c_l``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from footcal_cli.core.inference.descent import descend
from footcal_cli.core.parameters import BoolArray, FloatArray

LOG_RATIO_RANGE = (-12.0, 12.0)
_BOUNDARY_WEIGHT = 0.5
"""Weight of ``−ln λ`` beside the deviance: keeps σ_u off zero, where few sessions would otherwise
put it too often and make intervals too narrow (Chung et al. 2013)."""
_STARTS = {q: np.array(list(product(np.linspace(-7.5, 7.5, 6), repeat=q))) for q in (1, 2)}
"""Logarithms of q ratios from the best of which the search starts: it may have two minima."""
_LONGEST_STEP = 2.5
_SEEN = 1e-12
_TINY = np.finfo(float).tiny
_LEAST_CURVATURE = 1e-3


@dataclass(frozen=True)
class BlockSums:
    """Sums per block from which the likelihood at any variance ratios follows.

    `square` is ``ZᵀZ`` (g, q, q) and `cross` ``Zᵀ[X y]`` (g, q, p + 1) of each block, `whole`
    ``[X y]ᵀ[X y]`` (p + 1, p + 1) of all; q is 1 or 2.
    """

    square: FloatArray
    cross: FloatArray
    whole: FloatArray

    @cached_property
    def _pairs(self) -> FloatArray:
        """Products of each block's rows of `cross`, shape (g q q, (p + 1)²)."""
        products = np.einsum("gka,glb->gklab", self.cross, self.cross)
        return np.asarray(products.reshape(-1, self.whole.size))

    @cached_property
    def _polynomials(self) -> tuple[FloatArray, FloatArray]:
        """Of 1 + Λ ZᵀZ: what λ (or λ₁, λ₂, λ₁λ₂) add to its determinant, and to Λ adj(…)."""
        blocks, q, _ = self.square.shape
        first = self.square[:, 0, 0]
        if q == 1:
            return first[None], np.ones((1, blocks))
        second, across = self.square[:, 1, 1], self.square[:, 0, 1]
        adjugates = np.zeros((3, blocks, 2, 2))
        adjugates[0, :, 0, 0] = adjugates[1, :, 1, 1] = 1.0
        adjugates[2, :, 0, 0], adjugates[2, :, 1, 1] = second, first
        adjugates[2, :, 0, 1] = adjugates[2, :, 1, 0] = -across
        minors = np.stack([first, second, first * second - across**2])
        return minors, adjugates.reshape(3, -1)

    def shrink(self, ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        """``(Λ⁻¹ + ZᵀZ)⁻¹`` of each block, shape (…, g, q, q), and ``ln det V``, shape (…).

        In closed form (Cramer's rule), for many ratios (…, q) at once.
        """
        minors, adjugates = self._polynomials
        powers = np.concatenate([ratio, ratio[..., :1] * ratio[..., 1:]], axis=-1)
        det = 1.0 + powers @ minors
        taken = (powers @ adjugates).reshape(*ratio.shape[:-1], *self.square.shape)
        return taken / det[..., None, None], np.sum(np.log(det), axis=-1)

    def normal(self, taken: FloatArray) -> FloatArray:
        """``[X y]ᵀ V⁻¹ [X y]``, shape (…, p + 1, p + 1), with what `shrink` gives."""
        return np.asarray(self.whole - self.summed(taken))

    def summed(self, weights: FloatArray) -> FloatArray:
        """``Σ crossᵀ W cross`` over blocks, shape (…, p + 1, p + 1), of W (…, g, q, q)."""
        flat = weights.reshape(*weights.shape[:-3], -1) @ self._pairs
        return np.asarray(flat.reshape(*weights.shape[:-3], *self.whole.shape))


@dataclass(frozen=True)
class Restricted:
    """The deviance at logarithms of ratios, shape (…, q), with the weight of the boundary.

    `freedom` is n − p.
    """

    sums: BlockSums
    freedom: int
    log_ratio: FloatArray

    @cached_property
    def _taken(self) -> tuple[FloatArray, FloatArray]:
        return self.sums.shrink(np.exp(self.log_ratio))

    @cached_property
    def _parts(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """W with ``Wᵀ XᵀV⁻¹X W = 1`` on what is seen, ``Wᵀ XᵀV⁻¹y``, r, and the cost."""
        taken, log_det = self._taken
        normal = self.sums.normal(taken)
        values, vectors = np.linalg.eigh(normal[..., :-1, :-1])
        # what a design short of rank does not see has no determinant
        values = np.where(values > _SEEN * values[..., -1:], values, np.inf)
        root = vectors / np.sqrt(values)[..., None, :]
        moment = (normal[..., -1:, :-1] @ root)[..., 0, :]
        left = normal[..., -1, -1] - (moment**2).sum(axis=-1)
        left = np.maximum(left, np.finfo(float).eps * self.sums.whole[-1, -1] + _TINY)
        spread = np.log(np.where(np.isinf(values), 1.0, values)).sum(axis=-1)
        weight = _BOUNDARY_WEIGHT * self.log_ratio.sum(axis=-1)
        return root, moment, left, self.freedom * np.log(left) + log_det + spread - weight

    @property
    def costs(self) -> FloatArray:
        """The cost at each of the ratios, shape (…)."""
        return self._parts[3]

    @property
    def cost(self) -> float:
        """The cost at one pair of ratios (q,)."""
        return float(self._parts[3])

    @cached_property
    def _derivatives(self) -> tuple[FloatArray, FloatArray]:
        """Gradient (q,) and Hessian (q, q) by the logarithms."""
        root, moment, left, _ = self._parts
        ratio, square, q = np.exp(self.log_ratio), self.sums.square, self.log_ratio.size
        own = np.eye(q) - self._taken[0] @ square  # Zᵀ V⁻¹ = ownᵀ Zᵀ
        shared = square @ own  # M
        u = own * np.sqrt(ratio)
        rated = shared * np.sqrt(np.outer(ratio, ratio))
        # derivatives of −(Λ⁻¹ + ZᵀZ)⁻¹: −λ_k u_k u_kᵀ with u_k the columns of `own`
        first = -np.einsum("gak,gbk->kgab", u, u)
        mixed = np.einsum("gkl,gak,gbl->klgab", rated, u, u)
        second = mixed + mixed.swapaxes(-1, -2)
        second[range(q), range(q)] += first
        summed = self.sums.summed(np.concatenate([first, second.reshape(-1, *square.shape)]))
        moved = summed @ np.append(-root @ moment, 1.0)
        across = moved[:, :-1] @ root
        slopes = moved[:, -1] - across @ moment  # wᵀ (…) w with w = (−β, 1)
        inner = root.T @ summed[:, :-1, :-1] @ root
        traces = np.einsum("kii->k", inner)
        slope, bend = slopes[:q], slopes[q:].reshape(q, q) - 2.0 * across[:q] @ across[:q].T
        own_det = np.einsum("gkk->k", rated)
        gradient = self.freedom * slope / left + own_det + traces[:q] - _BOUNDARY_WEIGHT
        flat = inner[:q].reshape(q, -1)
        hessian = (
            self.freedom * (bend / left - np.outer(slope, slope) / left**2)
            + np.diag(own_det)
            - (rated**2).sum(axis=0)
            + traces[q:].reshape(q, q)
            - flat @ flat.T
        )
        return gradient, hessian

    @property
    def slope(self) -> FloatArray:
        """First derivatives of the cost by the logarithms, shape (q,)."""
        return self._derivatives[0]

    @property
    def curvature(self) -> FloatArray:
        """Second derivatives of the cost by the logarithms, shape (q, q)."""
        return self._derivatives[1]

    @cached_property
    def _free(self) -> BoolArray:
        """Ratios that are not at an end of their range with the cost falling beyond, shape (q,)."""
        low, high = LOG_RATIO_RANGE
        at_low, at_high = self.log_ratio <= low, self.log_ratio >= high
        return ~((at_low & (self.slope > 0.0)) | (at_high & (self.slope < 0.0)))

    @property
    def gradient(self) -> FloatArray:
        """The slope along which the ratios may move, shape (q,)."""
        return np.where(self._free, self.slope, 0.0)

    def hessian(self) -> FloatArray:
        """The curvature along which they may, made positive definite, shape (q, q)."""
        both = np.outer(self._free, self._free)
        values, vectors = np.linalg.eigh(np.where(both, self.curvature, 0.0))
        return np.asarray((vectors * np.maximum(np.abs(values), _LEAST_CURVATURE)) @ vectors.T)


def reml_ratios(sums: BlockSums, n: int, p: int) -> FloatArray:
    """λ_k = σ_k²/σ_e² that maximise the restricted likelihood, kept off zero, shape (q,).

    Parameters
    ----------
    sums
        Of the rows.
    n, p
        Rows and columns of X.
    """

    def at(log_ratio: FloatArray) -> Restricted:
        return Restricted(sums, n - p, log_ratio)

    def move(log_ratio: FloatArray, step: FloatArray) -> FloatArray:
        short = min(1.0, _LONGEST_STEP / (float(np.max(np.abs(step))) + _TINY))
        return np.asarray(np.clip(log_ratio + short * step, *LOG_RATIO_RANGE))

    starts = _STARTS[sums.square.shape[1]]
    begin = starts[int(np.argmin(at(starts).costs))]
    return np.asarray(np.exp(descend(at, move, begin).point))
