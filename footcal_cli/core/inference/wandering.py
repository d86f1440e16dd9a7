"""A calibration that wanders from block to block: where to, how far, and what that takes out.

``V_b = I + Z_b D Z_bᵀ``: Z has the directions in which a block's own calibration may differ, the
diagonal D their variances. Inner products are per block, shape (B, n, n), the residual last.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.outstanding import (
    MOST_SUSPECTS,
    SHARES,
    outstanding,
    strongest,
)
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.whitening import RowWhitener
from footcal_cli.core.parameters import FloatArray, IntArray

_EM_STEPS = 30
_EM_STOP = 1e-3
_LEAST_ROWS = 1.5  # rows of a block per direction in which its calibration may differ
_DROP = 1e-6
_RCOND = 1e-9


def wandering_columns(problem: Problem, whitener: RowWhitener) -> FloatArray:
    """Columns of the directions in which a block's own calibration may differ, shape (m, w).

    None where it is tracked, where it differs between settings instead, and where blocks have too
    few rows to show one of their own, unless pieces of one observation show their noise.
    """
    nothing = problem.calibration[:, :0]
    if problem.tracking is not None:
        return nothing
    if problem.settings is not None and problem.settings.part is not None:
        return nothing
    turn = _directions(problem, whitener)
    few = problem.residual.size <= _LEAST_ROWS * turn.shape[1] * problem.blocks
    if few and not problem.pieces:
        return nothing
    return np.asarray(np.hstack([problem.calibration, _offsets(problem)]) @ turn)


def _offsets(problem: Problem) -> FloatArray:
    """One column of ones per output."""
    return np.eye(len(problem.outputs))[problem.output]


def _directions(problem: Problem, whitener: RowWhitener) -> FloatArray:
    """Turn calibration and offsets into independent directions of unit information per block.

    Combinations that change no output are dropped.
    """
    basis = np.hstack([problem.calibration, _offsets(problem)])
    white = whitener(basis)
    gram = white.T @ white / max(problem.blocks, 1)
    scale = np.sqrt(np.clip(np.diag(gram), 1e-300, None))
    values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
    kept = values > _DROP * max(float(values.max(initial=0.0)), 1e-300)
    return np.asarray(vectors[:, kept] / scale[:, None] / np.sqrt(values[kept]))


def partial_out(inner: FloatArray, wandering: IntArray, variance: FloatArray) -> FloatArray:
    """``X'V⁻¹X`` by Woodbury: ``X'X − X'Z (D⁻¹ + Z'Z)⁻¹ Z'X``, block by block.

    Parameters
    ----------
    inner
        ``X'X``, Z among the columns.
    wandering, variance
        Which columns are Z, and of each its variance, shape (w,); without one it takes out nothing.
    """
    active = wandering[variance > 0]
    if not active.size:
        return inner
    precision = np.diag(1.0 / variance[variance > 0])
    out = np.empty_like(inner)
    for b, gram in enumerate(inner):
        cross = gram[active]
        middle = precision + gram[np.ix_(active, active)]
        out[b] = gram - cross.T @ np.linalg.solve(middle, cross)
    return out


def variance_beside(
    rows: FloatArray, base: IntArray, wandering: IntArray, candidates: IntArray
) -> FloatArray:
    """Variance between blocks of each wandering coefficient, beside candidates that stand out.

    Parameters
    ----------
    rows
        Inner products before anything is taken out.
    base, wandering, candidates
        Columns that are fitted in common, those of Z, and those that may stand out.

    Returns
    -------
    Shape (w,).
    """
    variance = wandering_variance(rows, base, wandering)
    if not candidates.size or not wandering.size:
        return variance
    for _ in range(MOST_SUSPECTS):
        suspects = {
            _strongest(rows, base, wandering, share * variance, candidates)[0] for share in SHARES
        }
        tested = {}
        for suspect in suspects:
            less = wandering_variance(rows, np.append(base, suspect), wandering)
            tested[suspect] = _strongest(rows, base, wandering, less, np.array([suspect]))[1]
        best = outstanding(tested, candidates.size)
        if best is None:
            break
        base = np.append(base, best)
        variance = wandering_variance(rows, base, wandering)
    return variance


def _strongest(
    rows: FloatArray,
    base: IntArray,
    wandering: IntArray,
    variance: FloatArray,
    candidates: IntArray,
) -> tuple[int, float]:
    """The candidate with the largest |z| beside a base, and that."""
    used = np.concatenate([wandering, base, candidates, [rows.shape[1] - 1]])
    small = rows[:, used[:, None], used[None, :]]
    total = partial_out(small, np.arange(wandering.size), variance).sum(axis=0)
    total = total[wandering.size :, wandering.size :]
    fitted = np.arange(base.size)
    inverse = scaled_inverse(total[np.ix_(fitted, fitted)], _RCOND)
    left = total - total[:, fitted] @ inverse @ total[fitted]
    theirs = slice(base.size, -1)
    best, z = strongest(left[theirs, -1], np.diag(left)[theirs], np.diag(total)[theirs])
    return int(candidates[best]), z


def wandering_variance(rows: FloatArray, calibration: IntArray, wandering: IntArray) -> FloatArray:
    """Variance between blocks of each wandering coefficient, by expectation maximisation.

    `rows` as in `variance_beside`; beside a `calibration` alone, shape (w,).
    """
    last = rows.shape[1] - 1
    if rows.shape[0] < 3 or not wandering.size:
        return np.zeros(wandering.size)
    zz = rows[:, wandering[:, None], wandering[None, :]]
    zr = rows[:, wandering, last]
    zj = rows[:, wandering[:, None], calibration[None, :]]
    fitted = np.append(calibration, last)
    zx = rows[:, wandering[:, None], fitted[None, :]]
    total = rows[:, fitted[:, None], fitted[None, :]].sum(axis=0)
    variance = np.ones(wandering.size)
    for _ in range(_EM_STEPS):
        posterior = np.linalg.inv(np.diag(1.0 / variance)[None] + zz)
        # X'V⁻¹X by Woodbury, as in `partial_out`, of what is fitted and the residual only
        left = total - np.sum(zx.swapaxes(1, 2) @ posterior @ zx, axis=0)
        theta = np.linalg.pinv(left[:-1, :-1], rcond=1e-10, hermitian=True) @ left[:-1, -1]
        mean = np.einsum("bij,bj->bi", posterior, zr - zj @ theta)
        updated = np.mean(mean**2 + np.einsum("bii->bi", posterior), axis=0)
        change = np.abs(np.log(updated / variance)).max()
        variance = updated
        if change < _EM_STOP:
            break
    return variance
