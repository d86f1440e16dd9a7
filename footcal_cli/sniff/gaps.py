"""Loads that do not stand in every row: held until the next one, none at all, or not noted.

Room: sniff; asked by loads. The readings decide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.readings import straightness
from footcal_cli.core.signals import span_of
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.sniff.said_weights import DASHES

_MOSTLY = 0.5
"""Share of rows without a load from which the others are not used alone."""
_LEAST_LOADS, _FAR = 2, 0.25
"""Loads beside a number that is none; how far a reading goes while a load is changed, as a share
of its range."""
_STRAIGHT, _WORSE = 0.98, 0.005
"""What loads explain of a reading at least once gaps are filled in, and how much less at most."""


def without_gaps(
    load: ColumnGuess, cells: Sequence[ColumnGuess], labels: Sequence[ColumnGuess] = ()
) -> ColumnGuess:
    """A load whose gaps mean what the readings in them say.

    An empty cell below a load is of the same load where the readings agree (merged cells); rows
    without a load are left out otherwise. A dash among weights is no load where they agree.
    """
    load = _without_changes(load, cells, labels)
    values = numbers_of(load)
    read = [numbers_of(c) for c in cells if numbers_of(c).size == values.size]
    own = next((c.codes for c in labels if c.codes is not None and len(c.words) > 1), None)
    if own is not None and own.size == values.size:
        # of cells in turn each has a line of its own
        parts = [own == code for code in np.unique(own)]
        read = [_on_one_line(values, r, parts) for r in read]
    if not read:
        return load
    dashes = [word for word in load.names if word in DASHES]
    if len(read) > 1:  # cells of a plate share the load
        read = [*read, np.sum(read, axis=0)]
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
    events = _as_straight(values, held, read) and bool(np.any(gaps & (above >= 0)))
    if events and not gaps[0]:
        why = "its name; an empty cell means what stands above it"
        return replace(load, values=held, held=True, why=why)
    if events or gaps.mean() > _MOSTLY:
        return load  # what lay there in most rows is not known
    return replace(load, missing=("",), why="its name; rows without it are left out")


def _without_changes(
    load: ColumnGuess, cells: Sequence[ColumnGuess], labels: Sequence[ColumnGuess]
) -> ColumnGuess:
    """A load without the one negative number (-1) that says that it is being changed.

    While one load lies there no reading moves; while loads are changed some goes far.
    """
    values = numbers_of(load)
    below = np.unique(values[values < 0])
    if below.size != 1 or np.unique(values[values > 0]).size < _LEAST_LOADS:
        return load
    rows = values == below[0]
    new = np.diff(rows, prepend=False)
    for label in labels:
        if label.codes is not None and label.codes.size == rows.size:
            new |= np.diff(label.codes, prepend=label.codes[:1]) != 0
    run = np.cumsum(new)
    runs = [np.flatnonzero(rows & (run == at)) for at in np.unique(run[rows])]
    read = [numbers_of(c) for c in cells if numbers_of(c).size == values.size]
    moved = any(span_of(r[own]) > _FAR * span_of(r) > 0.0 for r in read for own in runs)
    if rows.mean() > _MOSTLY or not moved:
        return load
    text = f"{below[0]:.10g}"
    why = f"its name; {text} while it is changed"
    known = np.where(rows, np.nan, values)
    return replace(load, values=known, missing=(*load.missing, text), why=why)


def _on_one_line(load: FloatArray, read: FloatArray, parts: Sequence[BoolArray]) -> FloatArray:
    """Readings (n,) of several cells, those of each as loads by the line of its noted ones."""
    found = np.full(read.size, np.nan)
    for part in parts:
        good = part & np.isfinite(load) & np.isfinite(read)
        if np.unique(load[good]).size > 1 and np.ptp(read[good]) > 0:
            found[part] = np.polyval(np.polyfit(read[good], load[good], 1), read[part])
    return found


def _as_straight(noted: FloatArray, filled: FloatArray, read: Sequence[FloatArray]) -> bool:
    """Whether filled-in loads explain the readings about as well as those that were noted."""
    most = max(straightness(filled, r) for r in read)
    return most > _STRAIGHT and most >= max(straightness(noted, r) for r in read) - _WORSE
