"""Columns of a linear problem, whatever their units: scaled, independent, fitted."""

from __future__ import annotations

import numpy as np
from scipy import linalg, optimize

from footcal_cli.core.parameters import FloatArray

_NEARLY_EXACT = 1e-12
_CLEARLY_SEEN = 1e-3
"""Diagonal of a factor of columns of norm one from which none depends on the others."""


def unit_columns(columns: FloatArray) -> FloatArray:
    """Columns that are not empty, at unit RMS, shape (m, kept)."""
    rms = np.sqrt(np.mean(columns**2, axis=0))
    return np.asarray(columns[:, rms > 0] / rms[rms > 0])


def _of_norm_one(columns: FloatArray) -> FloatArray:
    norm = np.sqrt(np.sum(columns**2, axis=0))
    return np.asarray(columns[:, norm > 0] / norm[norm > 0])


def orthonormal(columns: FloatArray, rcond: float) -> FloatArray:
    """Orthonormal basis of what columns span, shape (m, rank).

    Parameters
    ----------
    rcond
        Singular value of the scaled columns, against the largest, from which a direction counts.
    """
    scaled = _of_norm_one(columns)
    try:
        left, singular, _ = np.linalg.svd(scaled, full_matrices=False)
    except np.linalg.LinAlgError:  # divide and conquer fails on a few sound matrices
        left, singular, _ = linalg.svd(scaled, full_matrices=False, lapack_driver="gesvd")
    return np.asarray(left[:, singular > rcond * singular.max(initial=0.0)])


def orthogonal(columns: FloatArray, rcond: float) -> FloatArray:
    """As `orthonormal`, by a pivoted QR: a fit to it is that of `left_by`.

    Columns that are clearly independent need none: Cholesky factors of their products, twice, make
    a basis as exact (Yamamoto et al., ETNA 44, 2015) in a fraction of the time.

    Parameters
    ----------
    rcond
        As in `left_by`.
    """
    scaled = _of_norm_one(columns)
    if not scaled.shape[1]:
        return scaled
    independent = _of_independent(scaled)
    if independent is not None:
        return independent
    basis, upper, _ = linalg.qr(scaled, mode="economic", pivoting=True, check_finite=False)
    rank = basis.shape[1]
    if abs(upper[-1, rank - 1]) < _CLEARLY_SEEN * abs(upper[0, 0]):
        # gelsy's rank: its condition estimate sees more than the diagonal of R
        target = scaled[:, 0]
        rank = linalg.lstsq(scaled, target, cond=rcond, lapack_driver="gelsy", check_finite=False)[
            2
        ]
    return np.asarray(basis[:, :rank])


def _of_independent(scaled: FloatArray) -> FloatArray | None:
    """Orthonormal basis of columns of norm one, (m, n); None where one may depend on others."""
    basis = scaled
    for _ in range(2):
        try:
            lower = np.linalg.cholesky(basis.T @ basis)
        except np.linalg.LinAlgError:
            return None
        if not np.diag(lower).min() > _CLEARLY_SEEN:
            return None
        basis = basis @ np.linalg.inv(lower).T
    return basis


def rank_of(singular: FloatArray, shape: tuple[int, ...]) -> tuple[int, float]:
    """Numerical rank and condition number of a matrix with these singular values."""
    rank = int(np.sum(singular > max(shape) * np.finfo(float).eps * singular[0]))
    return rank, float(singular[0] / singular[-1]) if singular[-1] > 0 else np.inf


def left_by(basis: FloatArray, target: FloatArray, rcond: float) -> FloatArray:
    """What the best fit of a basis leaves of a target, shape (m,) or (m, targets).

    By a pivoted QR (LAPACK's gelsy): divide and conquer (gelsd) does not converge on every basis
    with dependent columns.

    Parameters
    ----------
    rcond
        Size of a scaled column beside those before it, from which it counts.
    """
    scaled = _of_norm_one(basis)
    if not scaled.shape[1]:
        return target
    found = linalg.lstsq(scaled, target, cond=rcond, lapack_driver="gelsy", check_finite=False)[0]
    return np.asarray(target - scaled @ found)


def least_squares(basis: FloatArray, target: FloatArray, rcond: float) -> FloatArray:
    """Coefficients of least squares, shape (columns,) or (columns, targets).

    The normal equations serve here: columns are scaled and dependent ones dropped.

    Parameters
    ----------
    rcond
        As in `scaled_inverse`.
    """
    return np.asarray(scaled_inverse(basis.T @ basis, rcond) @ (basis.T @ target))


def about_usual(
    design: FloatArray, target: FloatArray, usual: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Least squares of coefficients that are zero with a usual sd, noise as the residual says.

    ``(DᵀD / σ² + U⁻²) w = Dᵀt / σ²``: what the design determines stays as it was, and what moves
    the target by less than the noise stays at zero instead of following it.

    Parameters
    ----------
    design, target, usual
        D (n, k), t (n, q), and the sd of each coefficient (k,).

    Returns
    -------
    found
        Coefficients, shape (k, q).
    loose
        What of their covariance is that of their usual sizes, of each target, shape (k, k).
    """
    left, singular, right = np.linalg.svd(design * usual, full_matrices=False)
    along = left.T @ target
    freedom = max(len(design) - len(usual), 1) * target.shape[1]
    noise = max(float(np.sum((target - left @ along) ** 2)) / freedom, np.finfo(float).tiny)
    seen = singular**2 + noise
    back = usual[:, None] * right.T
    root = back * (noise / seen)
    return np.asarray(back @ ((singular / seen)[:, None] * along)), np.asarray(root @ root.T)


def scaled_inverse(products: FloatArray, rcond: float, empty: float = 0.0) -> FloatArray:
    """Pseudo-inverse of inner products of columns of any units, shape (…, n, n).

    Parameters
    ----------
    products
        One matrix, or one of each block.
    rcond
        Eigenvalue of the scaled products, against the largest, from which a direction counts.
    empty
        Square of a column against the largest, up to which there is nothing in it.
    """
    own = np.einsum("...ii->...i", products)
    most = own.max(axis=-1, initial=0.0, keepdims=True)
    scale = np.sqrt(np.where(own > empty * most, own, np.inf))
    outer = scale[..., :, None] * scale[..., None, :]
    values, vectors = np.linalg.eigh(products / outer)
    size = np.abs(values)
    seen = size > rcond * size.max(axis=-1, initial=0.0, keepdims=True)
    inverse = np.divide(1.0, values, out=np.zeros_like(values), where=seen)
    return np.asarray((vectors * inverse[..., None, :]) @ np.swapaxes(vectors, -1, -2) / outer)


def regressed(
    products: FloatArray, cross: FloatArray, rcond: float, empty: float = 0.0
) -> FloatArray:
    """``scaled_inverse(products) @ cross``, shape (…, n, k): solved where no column is dependent.

    Parameters
    ----------
    cross
        Products with what is regressed, shape (…, n, k).
    rcond, empty
        As in `scaled_inverse`.
    """
    own = np.einsum("...ii->...i", products)
    if own.size and np.all(own > empty * own.max(axis=-1, keepdims=True)):
        scale = np.sqrt(own)
        scaled = products / (scale[..., :, None] * scale[..., None, :])
        try:
            root = np.linalg.cholesky(scaled)
        except np.linalg.LinAlgError:
            root = np.zeros((1, 1))
        if np.einsum("...ii->...i", root).min() > _CLEARLY_SEEN:
            found = np.linalg.solve(scaled, cross / scale[..., None])
            return np.asarray(found / scale[..., None])
    return np.asarray(scaled_inverse(products, rcond, empty) @ cross)


def solve_information(
    information: FloatArray, vector: FloatArray, unit: FloatArray, rcond: float
) -> tuple[FloatArray, FloatArray, int]:
    """A linear fit from its normal equations, as far as its unknowns are seen.

    Parameters
    ----------
    information, vector
        ``Σ Aᵀ W A`` and ``Σ Aᵀ W y``, shape (n, n) and (n,).
    unit
        Size of each unknown, shape (n,): what "seen" is measured in.
    rcond
        Eigenvalue in these units, against the largest, from which a direction is seen.

    Returns
    -------
    Estimate (n,), covariance (n, n) and the number of directions seen; others are left at zero
    """
    outer = np.outer(unit, unit)
    values, vectors = np.linalg.eigh(information * outer)
    seen = values > rcond * values[-1]
    covariance = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T * outer
    return covariance @ vector, covariance, int(seen.sum())


def inverse_beside(products: FloatArray, size: FloatArray, rcond: float) -> FloatArray:
    """Pseudo-inverse of inner products of what an elimination left of columns, shape (n, n).

    Parameters
    ----------
    size
        Norm of each column before, shape (n,): one that was eliminated must not count by rounding.
    rcond
        As in `scaled_inverse`.
    """
    scale = np.where(size > 0.0, size, np.inf)
    outer = np.outer(scale, scale)
    return np.asarray(np.linalg.pinv(products / outer, rcond=rcond, hermitian=True) / outer)


def inverse_root(covariance: FloatArray) -> FloatArray:
    """W with ``Wᵀ W = covariance⁻¹``: what makes errors white, shape (…, n, n).

    Directions without variance count as nearly exact.
    """
    variance = np.einsum("...ii->...i", covariance)
    scale = np.sqrt(np.maximum(variance, np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(covariance / (scale[..., :, None] * scale[..., None, :]))
    size = np.sqrt(np.maximum(values, _NEARLY_EXACT * values[..., -1:]))
    return np.asarray(np.swapaxes(vectors, -1, -2) / size[..., :, None] / scale[..., None, :])


def variance_shares(squares: FloatArray, columns: FloatArray) -> FloatArray:
    """Variances v ≥ 0 of parts of an error, ``E squares = columns v``, shape (parts,).

    Non-negative least squares on relative deviations: squared errors scatter in proportion to
    their mean.
    """
    weight, found = np.ones_like(squares), np.zeros(columns.shape[1])
    for _ in range(4):
        found, _ = optimize.nnls(columns / weight[:, None], squares / weight)
        weight = np.maximum(columns @ found, 1e-18)
    return np.asarray(found)


def bounded_least_squares(
    basis: FloatArray, target: FloatArray, lower: float, upper: float
) -> FloatArray:
    """Coefficients of least squares between two bounds, shape (columns,)."""
    return np.asarray(optimize.lsq_linear(basis, target, (lower, upper)).x)
