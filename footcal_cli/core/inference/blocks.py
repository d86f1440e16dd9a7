"""Linear regression whose rows come in blocks: readings of a session share an offset and a gain.

``y = X β + Z u_block + ε``, u_k ~ N(0, σ_k²), ε ~ N(0, σ_e²), where Z holds a column of ones and,
where asked for, the load: re-seating a cell moves its zero and its sensitivity. Rows of one session
are not independent evidence of either; treated as such, intervals are far too narrow, and a
quantity that differs between sessions (temperature) is credited with what chance moved. The ratios
σ_k²/σ_e² are found by restricted maximum likelihood (Patterson and Thompson 1971), β by generalised
least squares, and the t quantiles use Satterthwaite's degrees of freedom.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import stats
from scipy.optimize import minimize, minimize_scalar

from footcal_cli.core.parameters import FloatArray, IntArray

_LOG_RATIO_RANGE = (-12.0, 12.0)
_BOUNDARY_WEIGHT = 0.5
"""Weight of ``−ln λ`` beside the deviance: keeps σ_u off zero, where few sessions would otherwise
put it too often and make intervals too narrow (Chung et al. 2013)."""
_LEAST_SEEN = 1e-14
"""Smaller eigenvalues, as a share of the largest, are rounding: they may even be negative."""
_SAME_IN_ALL = 1e-3
"""A column whose share of an offset or a gain varies less than this is the same in all blocks."""


@dataclass(frozen=True)
class BlockFit:
    """A regression and what each coefficient's uncertainty is made of.

    Parameters
    ----------
    coefficients, covariance
        Shape (p,) and (p, p).
    dof
        Degrees of freedom of each coefficient's interval, shape (p,).
    sd_within
        σ_e, scatter within a block.
    sd_between
        Scatter of the blocks' offsets; 0 with one block.
    sd_gain
        Scatter of the blocks' gains, per unit of the second column of Z; 0 without one.
    rank, condition
        Of the design with columns scaled to unit length.
    """

    coefficients: FloatArray
    covariance: FloatArray
    dof: FloatArray
    sd_within: float
    sd_between: float
    rank: int
    condition: float
    sd_gain: float = 0.0

    @property
    def sd(self) -> FloatArray:
        """Standard deviation of each coefficient, shape (p,)."""
        return np.sqrt(np.clip(np.diag(self.covariance), 0.0, None))

    def half_width(self, level: float = 0.95) -> FloatArray:
        """Half the width of each coefficient's interval, shape (p,)."""
        return np.asarray(stats.t.ppf(0.5 + level / 2.0, self.dof) * self.sd)


@dataclass(frozen=True)
class _Blocks:
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

    def shrink(self, ratio: FloatArray) -> tuple[FloatArray, float]:
        """``(Λ⁻¹ + ZᵀZ)⁻¹`` of each block, shape (g, q, q), and ``Σ ln det(1 + Λ ZᵀZ)``.

        In closed form (Cramer's rule): the search for the ratios asks for it ten thousand times.
        """
        minors, adjugates = self._polynomials
        powers = np.concatenate([ratio, ratio[:1] * ratio[1:]])
        det = 1.0 + powers @ minors
        taken = (powers @ adjugates).reshape(self.square.shape) / det[:, None, None]
        return taken, float(np.sum(np.log(det)))

    def normal(self, ratio: FloatArray) -> tuple[FloatArray, float]:
        """``[X y]ᵀ V⁻¹ [X y]`` in units of σ_e², shape (p + 1, p + 1), and ``ln det V``."""
        taken, log_det = self.shrink(ratio)
        return self.whole - (taken.ravel() @ self._pairs).reshape(self.whole.shape), log_det


def fit_blocks(
    design: FloatArray,
    target: FloatArray,
    block: IntArray | None = None,
    shared: FloatArray | None = None,
) -> BlockFit:
    """Regress with a random offset, and perhaps a random gain, per block.

    Parameters
    ----------
    design
        X, shape (n, p).
    target
        y, shape (n,).
    block
        Session of each row, shape (n,); one block, or None, gives ordinary least squares.
    shared
        Z: how a block's offset (and its gain) enter each row, shape (n, 1) or (n, 2); a column of
        ones where absent.
    """
    n, p = design.shape
    block = np.zeros(n, dtype=np.int64) if block is None else block
    norms = np.linalg.norm(design, axis=0)
    scale = np.where(norms > 0, norms, 1.0)
    scaled = design / scale
    singular = np.linalg.svd(scaled, compute_uv=False)
    rank = int(np.sum(singular > max(n, p) * np.finfo(float).eps * singular[0]))
    condition = float(singular[0] / singular[-1]) if singular[-1] > 0 else np.inf
    names, index = np.unique(block, return_inverse=True)
    many = names.size > 1 and names.size < n and n > p + names.size
    shared = np.ones((n, 1)) if shared is None else shared
    width = np.sqrt(np.mean(shared**2, axis=0))
    shared = shared / np.where(width > 0, width, 1.0)
    sums = _sums(scaled, target, index if many else np.zeros(n, dtype=np.int64), shared)
    ratio = _reml_ratios(sums, n, p) if many else np.zeros(shared.shape[1])
    normal, _ = sums.normal(ratio)
    moment, energy = normal[:-1, -1], float(normal[-1, -1])
    inverse = _inverse(normal[:-1, :-1])
    beta = inverse @ moment
    dof = max(n - rank, 1)
    left = target - scaled @ beta
    squares = max(energy - float(beta @ moment), 0.0) if many else float(left @ left)
    variance = squares / dof if n > rank else np.nan
    coefficient_dof = (
        _satterthwaite(scaled, index, shared, sums, ratio, inverse) if many else float(dof)
    )
    between = np.sqrt(variance * ratio) / np.where(width > 0, width, 1.0)
    return BlockFit(
        coefficients=beta / scale,
        covariance=variance * inverse / np.outer(scale, scale),
        dof=np.broadcast_to(np.asarray(coefficient_dof, dtype=float), (p,)),
        sd_within=float(np.sqrt(variance)),
        sd_between=float(between[0]),
        rank=rank,
        condition=condition,
        sd_gain=float(between[1]) if between.size > 1 else 0.0,
    )


def _inverse(normal: FloatArray) -> FloatArray:
    """Pseudo-inverse of a normal matrix: directions that only rounding shows count as unseen."""
    values, vectors = np.linalg.eigh(normal)
    seen = values > _LEAST_SEEN * values[-1]
    return np.asarray((vectors[:, seen] / values[seen]) @ vectors[:, seen].T)


def _sums(design: FloatArray, target: FloatArray, index: IntArray, shared: FloatArray) -> _Blocks:
    blocks, q = int(index.max()) + 1, shared.shape[1]
    both = np.column_stack([design, target])
    cross = np.zeros((blocks, q, both.shape[1]))
    np.add.at(cross, index, shared[:, :, None] * both[:, None])
    square = np.zeros((blocks, q, q))
    np.add.at(square, index, shared[:, :, None] * shared[:, None])
    return _Blocks(square, cross, both.T @ both)


def _reml_ratios(sums: _Blocks, n: int, p: int) -> FloatArray:
    """λ_k = σ_k²/σ_e² that maximise the restricted likelihood, kept off zero, shape (q,)."""

    def deviance(log_ratio: FloatArray) -> float:
        normal, log_det = sums.normal(np.exp(log_ratio))
        values, vectors = np.linalg.eigh(normal[:-1, :-1])
        seen = values > 1e-12 * values[-1]  # a design short of rank has no other determinant
        projected = vectors[:, seen].T @ normal[:-1, -1]
        left = float(normal[-1, -1]) - float(np.sum(projected**2 / values[seen]))
        rss = max(left, np.finfo(float).tiny)
        spread = float(np.sum(np.log(values[seen])))
        return (n - p) * float(np.log(rss)) + log_det + spread

    def cost(log_ratio: FloatArray) -> float:
        return deviance(log_ratio) - _BOUNDARY_WEIGHT * float(np.sum(log_ratio))

    (low, high), q = _LOG_RATIO_RANGE, sums.square.shape[1]
    # the offsets alone first: with them known, one more search finds the gains
    alone = minimize_scalar(
        lambda z: cost(np.concatenate([[z], np.full(q - 1, low)])),
        bounds=_LOG_RATIO_RANGE,
        method="bounded",
    )
    if q == 1:
        return np.array([np.exp(alone.x)])
    gain = minimize_scalar(
        lambda z: cost(np.array([alone.x, z])), bounds=_LOG_RATIO_RANGE, method="bounded"
    )
    found = minimize(
        cost,
        np.array([alone.x, gain.x]),
        method="Nelder-Mead",
        bounds=((low, high), (low, high)),
        options={"xatol": 1e-2, "fatol": 1e-4, "maxfev": 120},
    )
    return np.asarray(np.exp(found.x), dtype=np.float64)


def _satterthwaite(
    design: FloatArray,
    index: IntArray,
    shared: FloatArray,
    sums: _Blocks,
    ratio: FloatArray,
    inverse: FloatArray,
) -> FloatArray:
    """Degrees of freedom per coefficient from the shares of its variance.

    With ``β̂_j = Σ w_ji y_i`` the share from within blocks is ``σ_e² Σ w²``, the one of the k-th
    quantity that blocks share ``σ_k² Σ_g (Σ_g z_k w)²``, known from as many blocks as the design
    leaves free.
    """
    taken, _ = sums.shrink(ratio)
    carried = np.einsum("gkl,glp->gkp", taken, sums.cross[..., :-1])[index]
    weights = (design - np.einsum("nk,nkp->np", shared, carried)) @ inverse
    (n, p), blocks = design.shape, sums.square.shape[0]
    within = np.sum(weights**2, axis=0)
    total, spread = within, within**2 / max(n - blocks - p + 1, 1)
    free = _free_blocks(sums)
    for k in range(shared.shape[1]):
        per_block = np.zeros((blocks, p))
        np.add.at(per_block, index, weights * shared[:, k : k + 1])
        between = ratio[k] * np.sum(per_block**2, axis=0)
        total, spread = total + between, spread + between**2 / free[k]
    unseen = np.full(p, float(max(n - p, 1)))  # a column of zeros has no variance to share
    return np.asarray(np.divide(total**2, spread, out=unseen, where=spread > 0.0))


def _free_blocks(sums: _Blocks) -> FloatArray:
    """Blocks less the coefficients that differ from block to block, for each column of Z.

    A temperature that is another one in every session takes one of the sessions' gains away from
    what their scatter is known from.
    """
    blocks, q, _ = sums.cross.shape
    own = np.linalg.pinv(sums.square, hermitian=True) @ sums.cross[..., :-1]
    free = np.empty(q)
    for k in range(q):
        norms = np.linalg.norm(own[:, k], axis=0)
        columns = own[:, k][:, norms > 1e-9 * max(norms.max(), 1e-300)]
        columns = columns / np.linalg.norm(columns, axis=0)
        free[k] = max(blocks - np.linalg.matrix_rank(columns, tol=_SAME_IN_ALL), 1)
    return free


def whiten_autoregressive(
    design: FloatArray,
    target: FloatArray,
    time_s: FloatArray,
    block: IntArray,
    correlation_s: float,
) -> tuple[FloatArray, FloatArray]:
    """Rows whose noise is first-order autoregressive, made independent.

    ``z_k = (y_k − ρ_k y_{k−1}) / sqrt(1 − ρ_k²)`` with ``ρ_k = exp(−Δt_k/T)``; the first row of a
    block is kept as it is.

    Parameters
    ----------
    design, target
        Shape (n, p) and (n,), in order of time within each block.
    time_s, block
        Shape (n,).
    correlation_s
        T, the time over which the noise forgets itself; 0 for white noise.
    """
    if correlation_s <= 0:
        return design, target
    gap = np.diff(time_s, prepend=time_s[:1])
    first = np.diff(block, prepend=block[:1] - 1) != 0
    rho = np.where(first, 0.0, np.exp(-np.clip(gap, 1e-9, None) / correlation_s))
    rho = np.minimum(rho, 0.999)
    width = np.sqrt(1.0 - rho**2)
    rows = (design - rho[:, None] * np.roll(design, 1, axis=0)) / width[:, None]
    return rows, (target - rho * np.roll(target, 1)) / width


def correlation_time(residual: FloatArray, time_s: FloatArray, block: IntArray) -> float:
    """Time over which residuals forget themselves, ``−Δt / ln ρ₁``; 0 where they do not persist.

    Parameters
    ----------
    residual, time_s, block
        Shape (n,), in order of time within each block.
    """
    pair = (block[1:] == block[:-1]) & (np.diff(time_s) > 0)
    energy = float(np.mean(residual**2)) if residual.size else 0.0
    if pair.sum() < 8 or energy == 0.0:
        return 0.0
    rho = float(np.mean((residual[1:] * residual[:-1])[pair])) / energy
    # a correlation within its own sampling error is none
    if rho < 2.0 / np.sqrt(pair.sum()):
        return 0.0
    return float(-np.median(np.diff(time_s)[pair]) / np.log(min(rho, 0.999)))


def within(rows: FloatArray, session: IntArray) -> FloatArray:
    """Rows without their session's mean where there are several sessions.

    Parameters
    ----------
    rows, session
        Shape (n, p) and (n,).
    """
    names, index = np.unique(session, return_inverse=True)
    if names.size == 1:
        return rows
    sums = np.zeros((names.size, rows.shape[1]))
    np.add.at(sums, index, rows)
    return np.asarray(rows - (sums / np.bincount(index)[:, None])[index])
