"""Columns of a linear problem, whatever their units: scaled, independent, fitted."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import FloatArray


def unit_columns(columns: FloatArray) -> FloatArray:
    """Columns that are not empty, at unit RMS, shape (m, kept)."""
    rms = np.sqrt(np.mean(columns**2, axis=0))
    return np.asarray(columns[:, rms > 0] / rms[rms > 0])


def orthonormal(columns: FloatArray, rcond: float) -> FloatArray:
    """Orthonormal basis of what columns span, shape (m, rank).

    Parameters
    ----------
    rcond
        Singular value of the scaled columns, against the largest, from which a direction counts.
    """
    norm = np.sqrt(np.sum(columns**2, axis=0))
    scaled = columns[:, norm > 0] / norm[norm > 0]
    left, singular, _ = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray(left[:, singular > rcond * singular.max(initial=0.0)])


def least_squares(basis: FloatArray, target: FloatArray, rcond: float) -> FloatArray:
    """Coefficients of least squares, shape (columns,) or (columns, targets).

    The normal equations serve here: columns are scaled and dependent ones dropped.

    Parameters
    ----------
    rcond
        Eigenvalue of the scaled products, against the largest, from which a direction counts.
    """
    scale = np.sqrt(np.sum(basis**2, axis=0))
    scale = np.where(scale > 0, scale, np.inf)
    normed = basis / scale
    inverse = np.linalg.pinv(normed.T @ normed, rcond=rcond, hermitian=True)
    found = inverse @ (normed.T @ target)
    return np.asarray((found.T / scale).T)
