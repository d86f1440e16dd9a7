"""Which model the data support: errors on left-out groups, the one-standard-error rule."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

TIE = 0.01
"""A share of the mean squared error (half of it in rmse) that is not worth a more complex model."""


def folds(group: IntArray, most: int = 10) -> Iterator[BoolArray]:
    """Held-out masks: whole groups, shared out over at most `most` folds in order.

    Parameters
    ----------
    group
        Shape (n,).
    """
    names = np.unique(group)
    for part in range(min(most, names.size)):
        yield np.isin(group, names[part :: min(most, names.size)])


@dataclass(frozen=True)
class HeldOut:
    """Errors of predictions for groups that were left out of the fit.

    Parameters
    ----------
    error
        Predicted − true per row, shape (n, k) or (n,).
    group
        Shape (n,).
    """

    error: FloatArray
    group: IntArray

    @property
    def rmse(self) -> float:
        """Over all rows (and axes: root of the mean squared norm)."""
        return float(np.sqrt(np.mean(self._squared())))

    @property
    def rmse_sd(self) -> float:
        """Standard error of `rmse` from the scatter of the groups' mean squares."""
        groups = self.mse_by_group()
        if groups.size < 2 or self.rmse == 0.0:
            return float("nan")
        return float(groups.std(ddof=1) / np.sqrt(groups.size) / (2.0 * self.rmse))

    def mse_by_group(self) -> FloatArray:
        """Mean squared error of each group, shape (g,)."""
        _, index = np.unique(self.group, return_inverse=True)
        return np.asarray(np.bincount(index, weights=self._squared()) / np.bincount(index))

    def _squared(self) -> FloatArray:
        squared = np.asarray(self.error**2)
        return np.asarray(squared.sum(axis=1) if squared.ndim == 2 else squared)


def hold_out(
    predict: Callable[[BoolArray], FloatArray], truth: FloatArray, group: IntArray, most: int = 10
) -> HeldOut:
    """Errors of `predict`, given which rows were held out, on those rows.

    Parameters
    ----------
    predict
        Maps the held-out mask (n,) to predictions for *all* rows, fitted on the others.
    truth
        Shape (n,) or (n, k).
    group
        Placement, load or session of each row, shape (n,).
    """
    error = np.full(truth.shape, np.nan)
    for out in folds(group, most):
        error[out] = predict(out)[out] - truth[out]
    return HeldOut(error, group)


@dataclass(frozen=True)
class Choice:
    """Which of several nested or rival models the held-out errors support.

    Parameters
    ----------
    chosen, best
        Index of the chosen model, and of the one with the smallest error.
    """

    chosen: int
    best: int


def choose(candidates: Sequence[HeldOut], order: Sequence[float] | None = None) -> Choice:
    """The simplest model within one standard error of the best (Breiman et al. 1984).

    The standard error is that of the difference between the two models group by group, so that
    groups which are hard for both do not blur the comparison; differences below `TIE` are ties.

    Parameters
    ----------
    candidates
        Held-out errors on the same rows and groups.
    order
        Complexity of each candidate, ascending; position in the list where absent.
    """
    table = np.array([candidate.mse_by_group() for candidate in candidates])
    loss = table.mean(axis=1)
    best = int(np.argmin(loss))
    difference = table - table[best]
    groups = table.shape[1]
    error = difference.std(axis=1, ddof=1) / np.sqrt(groups) if groups > 1 else loss * 0.0
    rank = np.arange(len(candidates)) if order is None else np.asarray(order)
    tie = TIE * loss[best]
    within = difference.mean(axis=1) <= error + tie
    chosen = min(np.flatnonzero(within), key=lambda i: (rank[i], loss[i]))
    return Choice(int(chosen), best)
