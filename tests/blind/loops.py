"""What a hidden hysteresis does at the loads of its log: the size a data sheet would state."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tests.blind.world import Array, World

Flags = NDArray[np.bool_]

PLACES = 20
"""Loads at which the two branches are compared."""
BACK = 0.03
"""Share of the range by which a load must come back to count as falling."""


def widest_loop_n(clean: World, hidden: World) -> float:
    """Widest difference between the readings of falling and rising loads at one load, N.

    Averaged over all passes, largest over the channels. A loop that friction opens only over loads
    that were never reached has no width there, whatever its parameter.
    """
    change = hidden.shown - clean.shown
    widths = [0.0]
    for load, added, fresh in _channels(clean, change):
        if np.any(added):
            widths.append(_widest(load, added, _falling(load, fresh)))
    return max(widths)


def _channels(clean: World, change: Array) -> list[tuple[Array, Array, Flags]]:
    """Load, change and first rows of recordings of each channel."""
    if "cell" not in clean.row:
        return [(clean.shown[:, i], change[:, i], clean.fresh) for i in range(change.shape[1])]
    cell = clean.row["cell"]
    return [
        (clean.shown[cell == i, 0], change[cell == i, 0], clean.fresh[cell == i])
        for i in np.unique(cell)
    ]


def _falling(load: Array, fresh: Flags) -> Flags:
    """Whether the load came down from its last extreme rather than up, shape (n,)."""
    margin = BACK * float(np.ptp(load))
    out = np.zeros(load.size, dtype=bool)
    falling, extreme = False, load[0]
    for i, value in enumerate(load):
        if fresh[i]:
            falling, extreme = False, value
        elif (value > extreme + margin) if falling else (value < extreme - margin):
            falling, extreme = not falling, value
        extreme = min(extreme, value) if falling else max(extreme, value)
        out[i] = falling
    return out


def _widest(load: Array, added: Array, falling: Flags) -> float:
    edges = np.linspace(load.min(), load.max(), PLACES + 1)
    place = np.clip(np.searchsorted(edges, load, side="right") - 1, 0, PLACES - 1)
    apart = [0.0]
    for i in range(PLACES):
        down, up = added[(place == i) & falling], added[(place == i) & ~falling]
        if down.size and up.size:
            apart.append(float(down.mean() - up.mean()))
    return max(apart)
