"""Loads that a hand noted a little early or late, and the hand's work while they are changed.

Part of the room `core.bench`. The rows around a change of load are of the load that the reading
stands at, not of the one that somebody had typed by then.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.bench.plateaus import Plateaus
from footcal_cli.core.parameters import BoolArray, FloatArray

AROUND_S = 3.0
"""So early or late a load may be noted, and so long a hand may still touch the weights."""
_MOSTLY = 0.5
"""Share of a recording whose reading must stand still for it to say when loads were changed."""

_FEW = 0.05
"""Share of the samples at which a load changes that is noted by hand; a sensor's always does."""

_PART = 0.25
"""Share of the shorter of two loads that may be near the change between them."""

_BEYOND = 0.75
"""In windows: a sudden change makes half a window before and after it move."""


def out_of_step(
    time_s: FloatArray, load_n: FloatArray, own: Plateaus, window_s: float
) -> BoolArray:
    """Samples near a change of load that may not be of the load beside them, shape (n,).

    Within `AROUND_S` of a change, or a quarter of a shorter load, a sample agrees where its reading
    stands still, in a hold most of whose samples bear the same load. Of a change at which samples
    disagree that lie further off than half a window, no sample near it counts.

    Parameters
    ----------
    time_s, load_n
        Of one session, shape (n,), times increasing; an unknown load says nothing.
    own
        Where the reading itself stands still, judged over `window_s`.
    """
    out = np.zeros(load_n.size, dtype=bool)
    settled = own.hold >= 0
    changed = np.flatnonzero(np.diff(load_n) != 0)
    stepwise = 0 < changed.size < _FEW * load_n.size and np.isfinite(load_n).all()
    if not stepwise or settled.mean() < _MOSTLY:
        return out
    same = _bears_its_load(load_n, own)
    when = 0.5 * (time_s[changed] + time_s[changed + 1])
    lasts = np.diff(np.concatenate([time_s[:1], when, time_s[-1:]]))
    # of loads that change every other second most samples are near a change
    reach = np.minimum(AROUND_S, _PART * np.minimum(lasts[:-1], lasts[1:]))
    for at, far in zip(when, reach, strict=True):
        near = slice(*np.searchsorted(time_s, [at - far, at + far]))
        off = np.abs(time_s[near] - at)[~same[near]]
        disturbed = off.size and off.max() > _BEYOND * window_s
        out[near] |= True if disturbed else ~same[near]
    return out


def _bears_its_load(load_n: FloatArray, own: Plateaus) -> BoolArray:
    """Samples that lie in a hold of the reading and bear the load of most of it, shape (n,)."""
    level, index = np.unique(load_n, return_inverse=True)
    counts = np.zeros((len(own), level.size), dtype=np.int64)
    at = np.flatnonzero(own.hold >= 0)
    np.add.at(counts, (own.hold[at], index[at]), 1)
    same = np.zeros(load_n.size, dtype=bool)
    same[at] = counts.argmax(axis=1)[own.hold[at]] == index[at]
    return same
