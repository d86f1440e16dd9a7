"""Straight lines through readings of which a few are far off; how far a series moved by its end."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import median_sd

_ROUNDS = 30


def weighted_residual(design: FloatArray, target: FloatArray, weight: FloatArray) -> FloatArray:
    """Target minus what least squares with weights makes of the design, shape (n,).

    Parameters
    ----------
    design, target, weight
        Shapes (n, k), (n,), (n,).
    """
    scaled = design / np.maximum(np.abs(design).max(axis=0), 1e-300)
    found = np.linalg.lstsq(weight[:, None] * scaled, weight * target, rcond=None)[0]
    left: FloatArray = target - scaled @ found
    return left


def least_absolute(design: FloatArray, target: FloatArray) -> FloatArray:
    """Residual of the line of least absolute errors, which a few far rows do not draw, shape (n,).

    By least squares weighted anew with ``1/√|r|``, after Weiszfeld (1937).
    """
    weight = np.ones(target.size)
    for _ in range(_ROUNDS):
        residual = weighted_residual(design, target, weight)
        sd = median_sd(residual)
        weight = 1.0 / np.sqrt(np.maximum(np.abs(residual), 0.1 * sd + 1e-12))
    return residual


def moved_between_ends(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How far the last quarter of a series lies above the first on average, and the sd of that.

    By differences between neighbours (von Neumann 1941), which what moves slowly leaves alone.

    Parameters
    ----------
    values
        Shape (n,) or (n, c).
    """
    quarter = max(len(values) // 4, 1)
    moved = values[-quarter:].mean(axis=0) - values[:quarter].mean(axis=0)
    return moved, np.sqrt(np.mean(np.diff(values, axis=0) ** 2, axis=0) / quarter)
