"""Loads that do not stand in every row: held until the next one, none at all, or not noted.

Room: sniff; asked by loads. The readings decide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.readings import straightness
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.sniff.said_weights import DASHES

_STRAIGHT, _WORSE = 0.98, 0.005
"""What loads explain of a reading at least once gaps are filled in, and how much less at most."""


def without_gaps(load: ColumnGuess, cells: Sequence[ColumnGuess]) -> ColumnGuess:
    """A load whose gaps mean what the readings in them say.

    An empty cell below a load is of the same load where the readings agree (merged cells); rows
    without a load are left out otherwise. A dash among weights is no load where they agree.
    """
    values = numbers_of(load)
    read = [numbers_of(c) for c in cells if numbers_of(c).size == values.size]
    if not read:
        return load
    dashes = [word for word in load.names if word in DASHES]
    if dashes and np.any(values != 0.0):
        noted = np.where(values == 0.0, np.nan, values)
        if not _as_straight(noted, values, read):
            names = {word: n for word, n in load.names.items() if word not in DASHES}
            missing = (*load.missing, *dashes)
            return replace(load, values=noted, names=names, missing=missing)
        return load
    gaps = ~np.isfinite(values)
    if not gaps.any() or load.held or load.missing or gaps.all():
        return load
    above = np.maximum.accumulate(np.where(gaps, -1, np.arange(values.size)))
    held = np.where(above < 0, np.nan, values[np.maximum(above, 0)])
    if not gaps[0] and _as_straight(values, held, read):
        why = "its name; an empty cell means what stands above it"
        return replace(load, values=held, held=True, why=why)
    return replace(load, missing=("",), why="its name; rows without it are left out")


def _as_straight(noted: FloatArray, filled: FloatArray, read: Sequence[FloatArray]) -> bool:
    """Whether filled-in loads explain the readings about as well as those that were noted."""
    most = max(straightness(filled, r) for r in read)
    return most > _STRAIGHT and most >= max(straightness(noted, r) for r in read) - _WORSE
