"""How a foot's load and CoP come to its cells, and how two feet share the body's."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.errors import UsageError

_NEWTON_STEPS = 30
_TOLERANCE_M = 1e-6


def shares(arms_m: FloatArray) -> FloatArray:
    """Shares of a load that put its CoP at the origin of the arms: ``Σ wᵢ = 1, Σ wᵢ pᵢ = 0``.

    The shares of largest entropy, ``wᵢ ∝ exp(λ · pᵢ)``, are never negative and depend smoothly on
    the CoP; on four cells at the corners of a rectangle they are bilinear. Newton's method on λ.

    Parameters
    ----------
    arms_m
        Cell positions minus CoP, shape (n, cells, 2); the CoP lies inside the cells' hull.
    """
    scale = max(float(np.abs(arms_m).max(initial=0.0)), 1e-9)
    arms = arms_m / scale
    multiplier = np.zeros((len(arms), 2))
    weights = np.empty(arms.shape[:2])
    for _ in range(_NEWTON_STEPS):
        exponent = arms[..., 0] * multiplier[:, :1] + arms[..., 1] * multiplier[:, 1:]
        weights = np.exp(exponent - exponent.max(axis=1, keepdims=True))
        weights /= weights.sum(axis=1, keepdims=True)
        x, y = arms[..., 0], arms[..., 1]
        mean_x, mean_y = np.sum(weights * x, axis=1), np.sum(weights * y, axis=1)
        if max(np.abs(mean_x).max(initial=0.0), np.abs(mean_y).max(initial=0.0)) < 1e-13:
            break
        xx = np.sum(weights * x * x, axis=1) - mean_x**2 + 1e-12
        yy = np.sum(weights * y * y, axis=1) - mean_y**2 + 1e-12
        xy = np.sum(weights * x * y, axis=1) - mean_x * mean_y
        determinant = xx * yy - xy**2
        step = np.stack([yy * mean_x - xy * mean_y, xx * mean_y - xy * mean_x], axis=-1)
        step /= np.maximum(determinant, 1e-12)[:, None]
        length = np.linalg.norm(step, axis=1, keepdims=True)
        multiplier -= step * np.minimum(1.0, 3.0 / np.maximum(length, 1e-12))
    missed_m = scale * np.abs(np.einsum("nc,nci->ni", weights, arms)).max(initial=0.0)
    if missed_m > _TOLERANCE_M:
        raise UsageError(
            "the centre of pressure leaves the foot's cells",
            value=round(1e3 * missed_m, 1), unit="mm beyond",
            remedy="ask for smaller steps, a slower turn, less lean or smaller corrections",
        )  # fmt: skip
    return weights


def foot_cops(
    cop_m: FloatArray, foot_ref_m: FloatArray, carries: FloatArray, spread_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Load share and CoP of two feet that together have a CoP.

    Share s of the second foot: projection of the CoP on the line between the feet's reference
    points, within what is carried; what the line misses moves both CoPs alike, so that
    ``(1 − s) p_1 + s p_2 = p`` exactly.

    Parameters
    ----------
    cop_m
        CoP of the body, shape (n, 2).
    foot_ref_m
        Reference point of each foot, shape (n, 2, 2).
    carries
        1 where a foot stands, 0 where it swings, shape (n, 2).
    spread_m
        How far the feet's CoPs are pulled apart, shape (n, 2); the body's stays.

    Returns
    -------
    share
        Shape (n, 2), rows sum to 1.
    foot_cop
        Shape (n, 2, 2).
    """
    line = foot_ref_m[:, 1] - foot_ref_m[:, 0]
    along = np.sum((cop_m - foot_ref_m[:, 0]) * line, axis=1) / np.sum(line**2, axis=1)
    second = np.clip(along, 1.0 - carries[:, 0], carries[:, 1])
    share = np.stack([1.0 - second, second], axis=-1)
    missed = cop_m - np.einsum("nf,nfi->ni", share, foot_ref_m)
    apart = np.stack([share[:, 1:] * spread_m, -share[:, :1] * spread_m], axis=1)
    return share, foot_ref_m + missed[:, None] + apart


def pulled_apart(time_s: FloatArray) -> FloatArray:
    """How far the CoPs of two feet are pulled apart along a recording, m, shape (n, 2)."""
    spread: FloatArray = 0.01 * np.stack([np.sin(0.9 * time_s), np.cos(0.7 * time_s)], axis=-1)
    return spread
