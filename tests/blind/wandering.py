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

from tests.blind.world import Array, Ints

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
    last, before, share = between_knots(time_s)
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
        blocks.append(increments(last + 1) / (rate**2 * KNOT_S))
    stacked = sparse.hstack(columns, format="csc")
    information = stacked.T @ stacked + sparse.block_diag(blocks) + _ridge(stacked)
    return Wandering(stacked, splu(information.tocsc()))


@dataclass(frozen=True)
class Follower:
    """What `Wandering` follows with, row by row.

    Parameters
    ----------
    before, share
        Of each row the knot before it, and how far beyond, shape (m,).
    prior
        Information of the walk's increments, shape (parameters · knots, …).
    knots
        Number of knots.
    """

    before: Ints
    share: Array
    prior: Array
    knots: int

    @property
    def size(self) -> int:
        """Number of values of all parameters at all knots."""
        return len(self.prior)

    def columns(self, moves: Array, rows: slice) -> tuple[Ints, Array]:
        """Values that act on some rows, and what each does there, shape (r, values).

        Parameters
        ----------
        moves
            Errors of those rows per unit of each parameter, shape (r, parameters).
        """
        before, share = self.before[rows], self.share[rows]
        mine = np.arange(before.min(), before.max() + 2)
        after = mine[None, :] == before[:, None] + 1
        hat = np.where(
            after, share[:, None], (mine[None, :] == before[:, None]) * (1 - share[:, None])
        )
        own = (np.arange(moves.shape[1])[:, None] * self.knots + mine).ravel()
        return own, (moves[:, :, None] * hat[:, None, :]).reshape(len(moves), -1)


def follower(time_s: Array, rates: Sequence[float]) -> Follower:
    """The follower of parameters with these random walks (units per √s), for stamps (m,)."""
    last, before, share = between_knots(time_s)
    blocks = [increments(last + 1) / (rate**2 * KNOT_S) for rate in rates]
    return Follower(before, share, np.asarray(sparse.block_diag(blocks).toarray(), float), last + 1)


def between_knots(time_s: Array) -> tuple[int, Ints, Array]:
    """Number of stretches between knots; of each row the knot before it, and how far beyond."""
    last = max(int(np.ceil((time_s[-1] - time_s[0]) / KNOT_S)), 1)
    place = np.clip((time_s - time_s[0]) / KNOT_S, 0.0, last - 1e-9)
    before = place.astype(np.int64)
    return last, before, np.asarray(place - before)


def increments(knots: int) -> sparse.csc_matrix:
    """``Σ (a_{j+1} − a_j)²`` as a matrix; the start of the walk is free."""
    step = sparse.diags([-1.0, 1.0], [0, 1], shape=(knots - 1, knots), format="csc")
    return sparse.csc_matrix(step.T @ step)


def _ridge(columns: sparse.csc_matrix) -> sparse.csc_matrix:
    """A trace that keeps directions nothing is known of solvable, far below everything else."""
    typical = float(columns.multiply(columns).sum()) / max(columns.shape[1], 1)
    return 1e-9 * typical * sparse.identity(columns.shape[1], format="csc")
