r"""Cells that share one weight: a foot's placements in which no column says what was put on.

Room: sniff; asked by pivots and placed.

The weight :math:`F` goes from cell to cell as it is put on other places, and all cells together
carry the same: with scales of one size, :math:`\sum_i w_i r_i = F + b` for some
:math:`w_i` between a half and two.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.sniff.guesses import ColumnGuess, codes_of
from footcal_cli.sniff.said_weights import DASHES, says_nothing

LEAST_CELLS, LEAST_PLACES = 3, 3
"""So many cells share a weight, on so many places."""
_TOGETHER, _BY_PLACE = 0.05, 0.95
"""Variance of the weighted sum as a share of what its parts have alone; and what the places
explain of each reading's variance at least, where they come again."""
_ALIKE = (0.5, 2.0)


def loaded_places(label: ColumnGuess) -> tuple[IntArray, set[str]]:
    """Which place each row is of, −1 where a word says that nothing lay there; and these words."""
    empty = {w for w in label.words if not w or w in DASHES or says_nothing(w)}
    none = [at for at, word in enumerate(label.words) if word in empty]
    codes = codes_of(label)
    return np.where(np.isin(codes, none), -1, codes), empty


def share_one_weight(readings: Sequence[FloatArray], places: IntArray) -> bool:
    """Whether readings are of one weight that was put on places of a plate on these cells.

    Parameters
    ----------
    readings
        Of each cell, shape (n,) each.
    places
        Which place each row is of, shape (n,), −1 where none is named.
    """
    if len(readings) < LEAST_CELLS or any(r.size != places.size for r in readings):
        return False
    read = np.column_stack(readings)
    good = np.isfinite(read).all(axis=1) & (places >= 0)
    read, at = read[good], np.unique(places[good], return_inverse=True)[1].ravel()
    number = np.bincount(at)
    if number.size < LEAST_PLACES or len(read) <= read.shape[1]:
        return False
    off = read - read.mean(axis=0)
    spread = np.mean(off**2, axis=0)
    if not np.all(spread > 0):
        return False
    if number.max() > 1:
        means = np.stack([np.bincount(at, column) for column in off.T], axis=1) / number[:, None]
        within = np.mean((off - means[at]) ** 2, axis=0)
        if np.any(within > (1 - _BY_PLACE) * spread):
            return False
    from footcal_cli.core.inference.linear import bounded_least_squares  # scipy, only where asked

    each = bounded_least_squares(off / np.sqrt(spread.max()), np.zeros(len(off)), *_ALIKE)
    return bool(np.mean((off @ each) ** 2) < _TOGETHER * (each**2 @ spread))
