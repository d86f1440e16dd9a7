"""Linear regression whose rows come in blocks: the readings of a session share an offset.

``y = X β + u_block + ε``, u ~ N(0, σ_u²), ε ~ N(0, σ_e²). Rows of one session are not independent
evidence of its offset; treated as such, intervals are far too narrow. The ratio σ_u²/σ_e² is found
by restricted maximum likelihood (Patterson and Thompson 1971), β by generalised least squares, and
the t quantiles use Satterthwaite's degrees of freedom.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.optimize import minimize_scalar

from footcal_cli.core.parameters import FloatArray, IntArray

_LOG_RATIO_RANGE = (-12.0, 12.0)
_BOUNDARY_WEIGHT = 0.5
"""Weight of ``−ln λ`` beside the deviance: keeps σ_u off zero, where few sessions would otherwise
put it too often and make intervals too narrow (Chung et al. 2013)."""


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
        σ_u, scatter of the blocks' offsets; 0 with one block.
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

    @property
    def sd(self) -> FloatArray:
        """Standard deviation of each coefficient, shape (p,)."""
        return np.sqrt(np.clip(np.diag(self.covariance), 0.0, None))

    def half_width(self, level: float = 0.95) -> FloatArray:
        """Half the width of each coefficient's interval, shape (p,)."""
        return np.asarray(stats.t.ppf(0.5 + level / 2.0, self.dof) * self.sd)


@dataclass(frozen=True)
class _Blocks:
    """Sums per block from which the likelihood at any variance ratio follows."""

    sizes: FloatArray
    sum_x: FloatArray
    sum_y: FloatArray
    gram: FloatArray
    moment: FloatArray
    energy: float

    def shrink(self, ratio: float) -> FloatArray:
        """``λ/(1 + λ n_g)``: what a block's own offset takes away from its mean."""
        return np.asarray(ratio / (1.0 + ratio * self.sizes))

    def normal(self, ratio: float) -> tuple[FloatArray, FloatArray, float]:
        """``XᵀV⁻¹X, XᵀV⁻¹y, yᵀV⁻¹y`` in units of σ_e²."""
        shrink = self.shrink(ratio)
        return (
            self.gram - (self.sum_x.T * shrink) @ self.sum_x,
            self.moment - (self.sum_x.T * shrink) @ self.sum_y,
            self.energy - float(shrink @ self.sum_y**2),
        )


def fit_blocks(
    design: FloatArray, target: FloatArray, block: IntArray, offset: FloatArray | None = None
) -> BlockFit:
    """Regress with a random offset per block.

    Parameters
    ----------
    design
        X, shape (n, p).
    target
        y, shape (n,).
    block
        Session of each row, shape (n,); one block gives ordinary least squares.
    offset
        How a block's offset enters each row, shape (n,); ones unless the rows were whitened.
    """
    n, p = design.shape
    norms = np.linalg.norm(design, axis=0)
    scale = np.where(norms > 0, norms, 1.0)
    scaled = design / scale
    singular = np.linalg.svd(scaled, compute_uv=False)
    rank = int(np.sum(singular > max(n, p) * np.finfo(float).eps * singular[0]))
    condition = float(singular[0] / singular[-1]) if singular[-1] > 0 else np.inf
    names, index = np.unique(block, return_inverse=True)
    many = names.size > 1 and names.size < n and n > p + names.size
    offset = np.ones(n) if offset is None else offset
    sums = _sums(scaled, target, index if many else np.zeros(n, dtype=np.int64), offset)
    ratio = _reml_ratio(sums, n, p) if many else 0.0
    normal, moment, energy = sums.normal(ratio)
    inverse = np.asarray(np.linalg.pinv(normal, hermitian=True), dtype=np.float64)
    beta = inverse @ moment
    dof = max(n - rank, 1)
    variance = max(energy - float(beta @ moment), 0.0) / dof if n > rank else np.nan
    coefficient_dof = (
        _satterthwaite(scaled, index, offset, sums, ratio, inverse) if many else float(dof)
    )
    return BlockFit(
        coefficients=beta / scale,
        covariance=variance * inverse / np.outer(scale, scale),
        dof=np.broadcast_to(np.asarray(coefficient_dof, dtype=float), (p,)),
        sd_within=float(np.sqrt(variance)),
        sd_between=float(np.sqrt(variance * ratio)),
        rank=rank,
        condition=condition,
    )


def _sums(design: FloatArray, target: FloatArray, index: IntArray, offset: FloatArray) -> _Blocks:
    blocks = int(index.max()) + 1
    sum_x = np.zeros((blocks, design.shape[1]))
    np.add.at(sum_x, index, design * offset[:, None])
    return _Blocks(
        sizes=_sum_by(index, offset**2, blocks),
        sum_x=sum_x,
        sum_y=_sum_by(index, target * offset, blocks),
        gram=design.T @ design,
        moment=design.T @ target,
        energy=float(target @ target),
    )


def _sum_by(index: IntArray, values: FloatArray, blocks: int) -> FloatArray:
    return np.asarray(np.bincount(index, weights=values, minlength=blocks), dtype=np.float64)


def _reml_ratio(sums: _Blocks, n: int, p: int) -> float:
    """λ = σ_u²/σ_e² that maximises the restricted likelihood, kept off zero."""

    def deviance(ratio: float) -> float:
        normal, moment, energy = sums.normal(ratio)
        values, vectors = np.linalg.eigh(normal)
        seen = values > 1e-12 * values[-1]  # a design short of rank has no other determinant
        projected = vectors[:, seen].T @ moment
        rss = max(energy - float(np.sum(projected**2 / values[seen])), np.finfo(float).tiny)
        log_det = float(np.sum(np.log(values[seen])))
        return float((n - p) * np.log(rss) + np.sum(np.log1p(ratio * sums.sizes)) + log_det)

    found = minimize_scalar(
        lambda log_ratio: deviance(float(np.exp(log_ratio))) - _BOUNDARY_WEIGHT * log_ratio,
        bounds=_LOG_RATIO_RANGE,
        method="bounded",
    )
    return float(np.exp(found.x))


def _satterthwaite(
    design: FloatArray,
    index: IntArray,
    offset: FloatArray,
    sums: _Blocks,
    ratio: float,
    inverse: FloatArray,
) -> FloatArray:
    """Degrees of freedom per coefficient from the two shares of its variance.

    With ``β̂_j = Σ w_ji y_i`` the share from within blocks is ``σ_e² Σ w²``, the one from between
    them ``σ_u² Σ_g (Σ_g w)²``.
    """
    shared = (sums.shrink(ratio)[:, None] * sums.sum_x)[index] * offset[:, None]
    weights = (design - shared) @ inverse
    within = np.sum(weights**2, axis=0)
    per_block = np.zeros_like(sums.sum_x)
    np.add.at(per_block, index, weights * offset[:, None])
    between = ratio * np.sum(per_block**2, axis=0)
    (n, p), blocks = design.shape, sums.sizes.size
    spread = within**2 / max(n - blocks - p + 1, 1) + between**2 / (blocks - 1)
    return np.asarray((within + between) ** 2 / spread)


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
