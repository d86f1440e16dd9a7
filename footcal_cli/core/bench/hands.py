"""Loads that a hand noted a little early or late, and the hand's work while they are changed.

Part of the room `core.bench`. The rows around a change of load are of the load that the reading
stands at, not of the one that somebody had typed by then.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.bench.plateaus import Plateaus
from footcal_cli.core.parameters import BoolArray, FloatArray

AROUND_S = 3.0
"""So long a hand may still touch the weights around the moment at which a load was noted."""
_MOSTLY = 0.5
"""Share of a recording whose reading must stand still for it to say when loads were changed."""

_FEW = 0.05
"""Share of the samples at which a load changes that is noted by hand; a sensor's always does."""

_PART = 0.25
"""Share of the shorter of two loads that may be near the change between them."""

_STEPS_AROUND = 0.2
"""Of `AROUND_S`: sampled more coarsely, a reading does not show when it came to its load."""

_BEYOND = 0.75
"""In windows: a sudden change makes half a window before and after it move."""


def out_of_step(
    time_s: FloatArray, load_n: FloatArray, own: Plateaus, window_s: float
) -> BoolArray:
    """Samples near a change of load that may not be of the load beside them, shape (n,).

    Within `AROUND_S` of a change, or a quarter of a shorter load, a sample agrees where its reading
    stands still, in a hold most of whose samples bear the same load. Where the reading comes to
    that hold later, or leaves it earlier, what is near reaches as far. Of a change at which samples
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
    # a reading that is written down every ten seconds may creep in between
    finely = float(np.median(np.diff(time_s))) < _STEPS_AROUND * AROUND_S
    # of loads that change every other second most samples are near a change
    most = _PART * np.minimum(lasts[:-1], lasts[1:])
    for at, farthest in zip(when, most, strict=True):
        first, last = np.searchsorted(time_s, [at - farthest, at + farthest])
        stands = time_s[first:last][same[first:last]]  # at the load that is noted
        # a side on which no sample stands at its load says nothing of when it came
        before = [at - stands[stands < at].max()] if (stands < at).any() else []
        after = [stands[stands > at].min() - at] if (stands > at).any() else []
        far = min(max([AROUND_S, *before, *after]) if finely else AROUND_S, farthest)
        near = slice(*np.searchsorted(time_s, [at - far, at + far]))
        off = np.abs(time_s[near] - at)[~same[near]]
        disturbed = off.size and off.max() > _BEYOND * window_s
        out[near] |= True if disturbed else ~same[near]
    return out


def _bears_its_load(load_n: FloatArray, own: Plateaus) -> BoolArray:
    """Samples that lie in a hold of the reading and bear the load of most of it, shape (n,).

    Holds that a touch parts, in which the reading comes back, are one.
    """
    load, index = np.unique(load_n, return_inverse=True)
    counts = np.zeros((int(own.level.max(initial=-1)) + 1, load.size), dtype=np.int64)
    at = np.flatnonzero(own.hold >= 0)
    level = own.level[own.hold[at]]
    np.add.at(counts, (level, index[at]), 1)
    same = np.zeros(load_n.size, dtype=bool)
    same[at] = counts.argmax(axis=1)[level] == index[at]
    return same


def wrong_until(
    time_s: FloatArray, load_n: FloatArray, reading: FloatArray, tolerance_n: float
) -> float | None:
    """How long after changes of load errors last that a tolerance forbids; None for any others.

    All of them lie in the first half of their load, by the line through the rows of second halves:
    the weight came later than its number.

    Parameters
    ----------
    time_s, load_n, reading
        Of one session, shape (n,), times increasing.
    """
    changed = np.flatnonzero(np.diff(load_n) != 0) + 1
    edges = np.concatenate([[0], changed, [time_s.size]])
    number = np.searchsorted(changed, np.arange(time_s.size), side="right")
    since = time_s - time_s[edges[number]]
    late = since > 0.5 * (time_s[edges[number + 1] - 1] - time_s[edges[number]])
    if np.unique(load_n[late]).size < 2 or not np.ptp(reading[late]) > 0:
        return None
    line = np.polyfit(reading[late] - reading.mean(), load_n[late], 1)
    wrong = np.abs(np.polyval(line, reading - reading.mean()) - load_n) > tolerance_n
    if not wrong.any() or np.any(wrong & (late | (number == 0))):
        return None
    return float(since[wrong].max())
