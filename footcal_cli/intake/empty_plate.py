"""The empty plate among placements: its rows, and those that are noted so while a hand carries.

Room: intake; asked by placed_weights, zeros and the placements' case.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.signals import stretches
from footcal_cli.recipe import Robot
from footcal_cli.tables.table import Table

_FILMED = 50
"""Fewer rows without a load were each noted by themselves: the plate was empty."""
_OF_A_WEIGHT, _LIGHTEST = 0.05, 0.1
"""How far an empty plate may read from its lightest rows, of what weights make it read; and which
share of rows without a load these are."""
_MOVED = 0.25
"""Share of a weight by which the zeros of one emptying may differ from those of all."""


def carried(forces_n: FloatArray, load_n: FloatArray) -> BoolArray:
    """Rows noted without a load in which a weight is on its way, shape (n,).

    A label that is set once the weight rests, and taken back before it is lifted, leaves it on the
    plate for some rows without a load.

    Parameters
    ----------
    forces_n
        What all cells read times their scales, whatever their zeros, shape (n, c).
    """
    empty = load_n == 0.0
    if empty.sum() < _FILMED or empty.all():
        return np.zeros(load_n.size, dtype=bool)
    total = forces_n.sum(axis=1)
    high, usual = float(np.median(total[~empty])), float(np.median(total[empty]))
    way = 1.0 if high >= usual else -1.0
    low = way * float(np.quantile(way * total[empty], _LIGHTEST))
    away = np.abs(total - low)
    for start, stop in stretches(empty):
        # zeros that have moved by then are no weight
        own = way * float(np.quantile(way * total[start:stop], _LIGHTEST))
        if abs(own - low) < _MOVED * abs(high - low):
            away[start:stop] = np.abs(total[start:stop] - own)
    return np.asarray(empty & (away > _OF_A_WEIGHT * abs(high - low)))


def empty_plate(
    tables: Sequence[Table], robot: Robot, scale: Mapping[str, float]
) -> dict[tuple[str, ...], FloatArray]:
    """Channels of each foot -> its readings (n, c) in rows in which nothing lay on it.

    Parameters
    ----------
    scale
        Of each channel, N/count.
    """
    found = {}
    for foot in robot.feet:
        cells = tuple(robot.feet[foot].cells)
        channels = tuple(f"{foot}_{cell}" for cell in cells)
        own = [table for table in tables if {f"{cell}_counts" for cell in cells} <= {*table.data}]
        if not own or not set(channels) <= set(scale):
            continue
        at = np.concatenate([table.text("foot") for table in own]) == foot
        load = np.concatenate([table.number("load_n") for table in own])[at]
        counts = np.concatenate([table.numbers([f"{c}_counts" for c in cells]) for table in own])
        forces = counts[at] * np.array([scale[channel] for channel in channels])
        rows = (load == 0.0) & ~carried(forces, load)
        if rows.any() and not rows.all():
            found[channels] = counts[at][rows]
    return found


def with_others(placement: IntArray, load_n: FloatArray) -> IntArray:
    """Placements (n,) in which an empty plate goes with the hole before it, or the first one.

    It is at no hole: what leaves out one hole after the other would leave out all that is empty.
    """
    loaded = np.flatnonzero(load_n != 0.0)
    if not loaded.size:
        return placement
    before = np.searchsorted(loaded, np.arange(load_n.size), side="right") - 1
    return np.asarray(placement[loaded[np.maximum(before, 0)]])
