"""What a calibration that wanders absorbs besides one that stands still: a smoother's share.

Scales and biases on a random walk of the rates that the generator drew, as straight lines between
knots; what they explain of an error is what the smoother with those rates explains.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

from tests.blind.world import Array

KNOT_S = 2.0
"""Much longer than a row, much shorter than what a random walk needs to be worth following."""


@dataclass(frozen=True)
class Wandering:
    """The smoother of one world, over its valid errors in units of noise.

    Parameters
    ----------
    columns
        Sparse, shape (m, parameters · knots).
    solver
        Factors of the information of the data and of the walk's increments together.
    """

    columns: sparse.csc_matrix
    solver: SuperLU

    def left(self, errors: Array) -> Array:
        """What the smoother does not explain of errors (m,)."""
        solved = self.solver.solve(self.columns.T @ errors)
        return np.asarray(errors - self.columns @ solved)


def wandering(
    time_s: Array, changes: Sequence[Array], rates: Sequence[float], valid: NDArray[np.bool_]
) -> Wandering:
    """The smoother for parameters whose unit changes the errors.

    Parameters
    ----------
    time_s
        Of the rows, shape (n,).
    changes
        Error in units of noise per unit of each parameter, each of shape (n, k).
    rates
        Random walk of each parameter, units per √s.
    valid
        Errors that count, shape (n, k).
    """
    last = max(int(np.ceil((time_s[-1] - time_s[0]) / KNOT_S)), 1)
    place = np.clip((time_s - time_s[0]) / KNOT_S, 0.0, last - 1e-9)
    before = place.astype(np.int64)
    share = place - before
    row_of = np.broadcast_to(np.arange(time_s.size)[:, None], valid.shape)[valid]
    number = np.arange(row_of.size)
    columns, blocks = [], []
    for change, rate in zip(changes, rates, strict=True):
        value = change[valid]
        on = np.flatnonzero(value)
        rows = np.concatenate([number[on], number[on]])
        knots = np.concatenate([before[row_of[on]], before[row_of[on]] + 1])
        weight = np.concatenate([1.0 - share[row_of[on]], share[row_of[on]]])
        columns.append(
            sparse.csc_matrix(
                (weight * np.tile(value[on], 2), (rows, knots)), shape=(row_of.size, last + 1)
            )
        )
        blocks.append(_increments(last + 1) / (rate**2 * KNOT_S))
    stacked = sparse.hstack(columns, format="csc")
    information = stacked.T @ stacked + sparse.block_diag(blocks) + _ridge(stacked)
    return Wandering(stacked, splu(information.tocsc()))


def _increments(knots: int) -> sparse.csc_matrix:
    """``Σ (a_{j+1} − a_j)²`` as a matrix; the start of the walk is free."""
    step = sparse.diags([-1.0, 1.0], [0, 1], shape=(knots - 1, knots), format="csc")
    return sparse.csc_matrix(step.T @ step)


def _ridge(columns: sparse.csc_matrix) -> sparse.csc_matrix:
    """A trace that keeps directions nothing is known of solvable, far below everything else."""
    typical = float(columns.multiply(columns).sum()) / max(columns.shape[1], 1)
    return 1e-9 * typical * sparse.identity(columns.shape[1], format="csc")
