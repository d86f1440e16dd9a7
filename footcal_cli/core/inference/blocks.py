"""Linear regression whose rows come in blocks: readings of a session share an offset and a gain.

``y = X β + Z u_block + ε``, u_k ~ N(0, σ_k²), ε ~ N(0, σ_e²), where Z holds a column of ones and,
where asked for, the load: re-seating a cell moves its zero and its sensitivity. Rows of one session
are not independent evidence of either; treated as such, intervals are far too narrow, and a
quantity that differs between sessions (temperature) is credited with what chance moved. The ratios
σ_k²/σ_e² are found by restricted maximum likelihood (`variance_ratios`), β by generalised least
squares, and the t quantiles use Satterthwaite's degrees of freedom.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import special

from footcal_cli.core.inference.linear import rank_of
from footcal_cli.core.inference.variance_ratios import BlockSums, reml_ratios
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.signals import begins

_NOTHING = 1e-100
"""A column of a gain without loads is what rounding left of zero."""
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

    def half_width(self) -> FloatArray:
        """Half the width of each coefficient's 95 % interval, shape (p,)."""
        return np.asarray(special.stdtrit(self.dof, 0.975) * self.sd)


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
    onto, singular, right = np.linalg.svd(scaled, full_matrices=False)
    rank, condition = rank_of(singular, design.shape)
    names, index = np.unique(block, return_inverse=True)
    many = names.size > 1 and names.size < n and n > p + names.size
    shared = np.ones((n, 1)) if shared is None else shared
    width = np.sqrt(np.mean(shared**2, axis=0))
    width = np.where(width > _NOTHING, width, 0.0)
    shared = shared / np.where(width > 0, width, 1.0)
    # sums of squares of the target itself would cancel: of what ordinary least squares leaves;
    # one block's residual is taken row by row below
    seen = int(np.sum(singular > np.sqrt(_LEAST_SEEN) * singular[0])) if many else 0
    explained = onto[:, :seen].T @ target
    plain = right[:seen].T @ (explained / singular[:seen])
    target = target - onto[:, :seen] @ explained
    sums = _sums(scaled, target, index if many else np.zeros(n, dtype=np.int64), shared)
    ratio = reml_ratios(sums, n, p) if many else np.zeros(shared.shape[1])
    taken, _ = sums.shrink(ratio)
    normal = sums.normal(taken)
    moment, energy = normal[:-1, -1], float(normal[-1, -1])
    inverse = _inverse(normal[:-1, :-1])
    beta = inverse @ moment
    dof = max(n - rank, 1)
    left = target - scaled @ beta
    squares = max(energy - float(beta @ moment), 0.0) if many else float(left @ left)
    variance = squares / dof if n > rank else np.nan
    coefficient_dof = (
        _satterthwaite(scaled, index, shared, sums, ratio, taken, inverse) if many else float(dof)
    )
    between = np.sqrt(variance * ratio) / np.where(width > 0, width, 1.0)
    return BlockFit(
        coefficients=(plain + beta) / scale,
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


def _sums(design: FloatArray, target: FloatArray, index: IntArray, shared: FloatArray) -> BlockSums:
    blocks, q = int(index.max()) + 1, shared.shape[1]
    both = np.column_stack([design, target])
    cross = np.zeros((blocks, q, both.shape[1]))
    np.add.at(cross, index, shared[:, :, None] * both[:, None])
    square = np.zeros((blocks, q, q))
    np.add.at(square, index, shared[:, :, None] * shared[:, None])
    return BlockSums(square, cross, both.T @ both)


def _satterthwaite(
    design: FloatArray,
    index: IntArray,
    shared: FloatArray,
    sums: BlockSums,
    ratio: FloatArray,
    taken: FloatArray,
    inverse: FloatArray,
) -> FloatArray:
    """Degrees of freedom per coefficient from the shares of its variance.

    With ``β̂_j = Σ w_ji y_i`` the share from within blocks is ``σ_e² Σ w²``, the one of the k-th
    quantity that blocks share ``σ_k² Σ_g (Σ_g z_k w)²``, known from as many blocks as the design
    leaves free.
    """
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


def _free_blocks(sums: BlockSums) -> FloatArray:
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
    rho, width = autoregression(time_s, block, correlation_s)
    rows = (design - rho[:, None] * np.roll(design, 1, axis=0)) / width[:, None]
    return rows, (target - rho * np.roll(target, 1)) / width


def autoregression(
    time_s: FloatArray, block: IntArray, correlation_s: float
) -> tuple[FloatArray, FloatArray]:
    """What a row's noise has of the row before, ρ, and of its own, ``sqrt(1 − ρ²)``, (n,) each.

    Parameters
    ----------
    time_s, block
        Shape (n,), in order of time within each block.
    correlation_s
        Above 0.
    """
    gap = np.diff(time_s, prepend=time_s[:1])
    first = begins(block)
    rho = np.where(first, 0.0, np.exp(-np.clip(gap, 1e-9, None) / correlation_s))
    rho = np.minimum(rho, 0.999)
    return rho, np.sqrt(1.0 - rho**2)


def correlation_time(residual: FloatArray, time_s: FloatArray, block: IntArray) -> float:
    """Correlation time of residuals, ``−Δt / ln ρ₁``; 0 where they do not persist.

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


def centring(session: IntArray) -> Callable[[FloatArray], FloatArray]:
    """What takes from rows (n, p) their session's mean, where there are several sessions (n,)."""
    names, index = np.unique(session, return_inverse=True)
    if names.size == 1:
        return lambda rows: rows
    count = np.bincount(index)[:, None]

    def centred(rows: FloatArray) -> FloatArray:
        sums = np.zeros((names.size, rows.shape[1]))
        np.add.at(sums, index, rows)
        return np.asarray(rows - (sums / count)[index])

    return centred
