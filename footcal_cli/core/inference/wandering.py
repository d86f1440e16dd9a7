"""A calibration that wanders from block to block: where to, how far, and what that takes out.

``V_b = I + Z_b D Z_bᵀ``: Z has the numbers by which a block's own calibration may differ, the
diagonal D their variances.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components

from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.products import Products, block_products, middle
from footcal_cli.core.inference.settled import MOST_SUSPECTS, SHARES, outstanding, strongest
from footcal_cli.core.inference.whitening import RowWhitener
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

_EM_STEPS = 30
_EM_STOP = 1e-3
_LEAST_ROWS = 1.5  # rows of a block per direction in which its calibration may differ
_DROP = 1e-6
_RCOND = 1e-9
_DEPENDENT = 1e-10
_MOST = 1e8  # variance from which a direction is free in every block
_SMALLEST = 1e-300
_SHOWN = 1e-6  # of the most that a block shows of a column, from which a block shows it
_ALIKE = 4.0  # blocks' worth of what columns of other cells say of a variance
_CLEAR = 1e-3  # ratio of a Cholesky factor's diagonal, above which no direction is dependent


def wandering_columns(problem: Problem, whitener: RowWhitener) -> FloatArray:
    """Columns by which a block's own calibration may differ, of unit information per block, (m, w).

    Every column of the calibration and every offset, each on its own: eigenvectors of columns of
    nearly equal information are rounding. Those of one output are not, within one cell of a bench:
    there an offset and the calibration hold the same. What changes no output is dropped.
    None where it is tracked, where it differs between settings instead, and where blocks have too
    few rows to show one of their own, unless pieces of one observation show their noise.
    """
    nothing = problem.calibration[:, :0]
    if problem.tracking is not None or problem.turned:
        return nothing
    columns = np.hstack([problem.calibration, np.eye(len(problem.outputs))[problem.output]])
    white = whitener(columns)
    gram = white.T @ white / max(problem.blocks, 1)
    size = np.sqrt(np.maximum(np.diag(gram), _SMALLEST))
    bench, own = len(problem.outputs) == 1, gram
    if bench:
        every = np.arange(columns.shape[1])
        own = block_products(white, problem.block[whitener.kept], problem.blocks).part(every, every)
    ranks = _rank(own / np.outer(size, size))
    shown = ranks.sum() if bench else ranks * problem.blocks
    if problem.residual.size <= _LEAST_ROWS * shown and not problem.pieces:
        return nothing
    if bench:
        return _of_each_cell(problem, columns, own)
    acting = size > np.sqrt(_DROP) * size.max(initial=_SMALLEST)
    return np.asarray(columns[:, acting] / size[acting])


def _of_each_cell(problem: Problem, columns: FloatArray, own: FloatArray) -> FloatArray:
    """Directions of each cell of a bench, the best known first, zero in others' blocks, (m, w).

    Parameters
    ----------
    columns
        Of the calibration, and the offset behind them.
    own
        Their inner products in each block, shape (B, c, c).
    """
    shows, cell = _cells(np.diagonal(own, axis1=1, axis2=2)[:, :-1])
    everywhere = np.ones(problem.blocks, dtype=bool)
    parts = []
    for at in range(cell.max(initial=0) + 1):
        mine: BoolArray = np.any(shows[:, cell == at], axis=1) if cell.size else everywhere
        used = np.append(np.flatnonzero(cell == at), columns.shape[1] - 1)
        gram = own[np.ix_(mine, used, used)].sum(axis=0) / problem.blocks
        scale = np.sqrt(np.maximum(np.diag(gram), _SMALLEST))
        values, vectors = (
            found[..., ::-1] for found in np.linalg.eigh(gram / np.outer(scale, scale))
        )
        seen = values > _DROP * values.max(initial=_SMALLEST)
        turned = (columns[:, used] / scale) @ (vectors[:, seen] / np.sqrt(values[seen]))
        parts.append(turned * mine[problem.block][:, None])
    return np.hstack(parts)


def _rank(scaled: FloatArray) -> IntArray:
    """How many directions symmetric matrices know, shape (…)."""
    values = np.linalg.eigvalsh(scaled)
    most = values.max(axis=-1, keepdims=True, initial=_SMALLEST)
    return np.asarray((values > _DROP * most).sum(axis=-1))


def variance_beside(
    rows: Products, base: IntArray, wandering: IntArray, candidates: IntArray,
    *, bench: bool = False,
) -> FloatArray:  # fmt: skip
    """Variance between blocks of each wandering coefficient, beside candidates that stand out.

    Parameters
    ----------
    rows
        Products before anything is taken out.
    base, wandering, candidates
        Columns that are fitted in common, those of Z, and those that may stand out.
    bench
        As in `wandering_variance`.

    Returns
    -------
    Shape (w,).
    """
    variance = wandering_variance(rows, base, wandering, bench=bench)
    if not candidates.size or not wandering.size:
        return variance
    for _ in range(MOST_SUSPECTS):
        suspects = {
            _strongest(rows, base, wandering, share * variance, candidates)[0] for share in SHARES
        }
        tested = {}
        for suspect in suspects:
            less = wandering_variance(rows, np.append(base, suspect), wandering, bench=bench)
            tested[suspect] = _strongest(rows, base, wandering, less, np.array([suspect]))[1]
        best = outstanding(tested, candidates.size)
        if best is None:
            break
        base = np.append(base, best)
        variance = wandering_variance(rows, base, wandering, bench=bench)
    return variance


def _strongest(
    rows: Products, base: IntArray, wandering: IntArray, variance: FloatArray, candidates: IntArray
) -> tuple[int, float]:
    """The candidate with the largest |z| beside a base, and that."""
    used = np.concatenate([base, candidates, [rows.last]])
    # of all products those with the base and the residual, and squares, are enough
    few = np.append(np.arange(base.size), used.size - 1)
    products = rows.part(used[few], used).sum(axis=0).T
    own = rows.squares(used).sum(axis=0)
    active = wandering[variance > 0]
    if active.size:
        cross = rows.part(active, used)
        inner = middle(rows.part(active, active), variance[variance > 0])
        taken = np.linalg.solve(inner, cross)
        cross, taken = cross.reshape(-1, used.size), taken.reshape(-1, used.size)
        products = products - cross.T @ taken[:, few]
        own -= np.einsum("ij,ij->j", cross, taken)
    on_base = products[:, :-1]
    gamma = on_base @ scaled_inverse(on_base[: base.size], _RCOND)
    left = products[:, -1] - gamma @ on_base[-1]
    visible = own - np.einsum("ij,ij->i", gamma, on_base)
    theirs = slice(base.size, -1)
    best, z = strongest(left[theirs], visible[theirs], own[theirs])
    return int(candidates[best]), z


def wandering_variance(
    rows: Products, calibration: IntArray, wandering: IntArray, *, bench: bool = False
) -> FloatArray:
    """Variance between blocks of each wandering coefficient, by expectation maximisation.

    `rows` as in `variance_beside`; beside a `calibration` alone, shape (w,). Cells of a `bench`
    have few blocks each: their variances are drawn to what those of all cells have in common.

    Source
    ------
    Moderated variances: Smyth, Stat. Appl. Genet. Mol. Biol. 3 (2004), with a fixed weight.
    """
    if rows.blocks < 3 or not wandering.size:
        return np.zeros(wandering.size)
    zz = rows.part(wandering, wandering)
    fitted = np.append(calibration, rows.last)
    zx = rows.part(wandering, fitted)
    shown, cell = _cells(np.diagonal(zz, axis1=1, axis2=2))
    seen = np.maximum(shown.sum(axis=0), 1)
    # of each cell the columns are in order of their information: first ones are alike, and so on
    rank = np.array([np.count_nonzero(cell[:i] == own) for i, own in enumerate(cell)])
    total = rows.part(fitted, fitted).sum(axis=0)
    variance = np.ones(wandering.size)
    flat = zx.reshape(-1, fitted.size).T
    beside_theta = np.ones(fitted.size)  # the residual less what is fitted
    for _ in range(_EM_STEPS):
        posterior = np.linalg.inv(np.diag(1.0 / variance) + zz)
        shrunk = posterior @ zx
        # X'V⁻¹X by Woodbury, as in `partial_out`, of what is fitted and the residual only
        left = total - flat @ shrunk.reshape(-1, fitted.size)
        beside_theta[:-1] = -_solved(left[:-1, :-1], left[:-1, -1])
        mean = shrunk @ beside_theta
        squares = mean**2 + np.einsum("bii->bi", posterior)
        updated = np.mean(squares, axis=0)
        if bench:
            total_of = np.sum(shown * squares, axis=0)
            common = (np.bincount(rank, total_of) / np.bincount(rank, seen))[rank]
            updated = (total_of + _ALIKE * common) / (seen + _ALIKE)
        updated = np.minimum(updated, _MOST)
        change = np.abs(np.log(updated / variance)).max()
        variance = updated
        if change < _EM_STOP:
            break
    return variance


def _cells(squares: FloatArray) -> tuple[BoolArray, IntArray]:
    """Which blocks show each column, (B, w), and the cell of a bench that each column is of, (w,).

    No block shows columns of two cells.

    Parameters
    ----------
    squares
        Information of each block on each column, shape (B, w).
    """
    shown = squares > _SHOWN * squares.max(axis=0, initial=0.0)
    together = shown.T.astype(np.int64) @ shown
    return shown, connected_components(together, directed=False)[1].astype(np.int64)


def _solved(products: FloatArray, target: FloatArray) -> FloatArray:
    """Coefficients of least squares from inner products, dependent directions left out, (p,)."""
    try:
        root = np.diag(np.linalg.cholesky(products))
    except np.linalg.LinAlgError:
        root = np.zeros(1)
    if root.size and root.min() > _CLEAR * root.max():
        return np.asarray(np.linalg.solve(products, target))
    values, vectors = np.linalg.eigh(products)
    size = np.abs(values)
    seen = size > _DEPENDENT * size.max(initial=0.0)
    shares = np.divide(vectors.T @ target, values, out=np.zeros_like(values), where=seen)
    return np.asarray(vectors @ shares)
