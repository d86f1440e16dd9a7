"""The loop that a memory opens between rising and falling loads, as a data sheet states it."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.memory import play, recording
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

BINS = 24
"""Loads at which rising and falling readings are compared."""
LOOP_FORM_ERROR = 0.05
"""Sd of the width that a play fitted to another loop has, as a share: Dahl's, Bouc and Wen's and
Maxwell's slip model over ladders of weights and over gaits (tests/core/test_loops.py)."""
_TURN = 0.02
"""Share of the range of loads by which a load must turn back before it counts as turning."""


def loop_width(before: Log, after: Log) -> FloatArray:
    """Widest difference between readings of falling and rising loads at one load, shape (c,).

    The hysteresis error of VDI/VDE 2638 and OIML R 60, over the loads that were recorded; zero
    where loads do not return.

    Parameters
    ----------
    before, after
        The same recording without and with the effect.
    """
    load, added = before.readings, after.readings - before.readings
    low = load.min(axis=0)
    span = np.ptp(load, axis=0)
    fresh = recording(before.time_s, None).fresh
    # held by a play, a direction is not turned by noise
    held = play(load, _TURN * span, load[0], fresh)
    step = np.where(fresh[:, None], 1.0, np.sign(np.diff(held, axis=0, prepend=held[:1] - 1.0)))
    last = np.maximum.accumulate(np.where(step != 0, np.arange(len(step))[:, None], 0), axis=0)
    rising = np.take_along_axis(step, last, axis=0) > 0
    share = (load - low) / np.where(span > 0, span, 1.0)
    place = np.minimum((BINS * share).astype(np.int64), BINS - 1)
    return np.array([_widest(*column) for column in zip(place.T, rising.T, added.T, strict=True)])


def _widest(place: FloatArray, rising: FloatArray, added: FloatArray) -> float:
    """Largest difference of the means over falling and rising rows of one place."""
    number = place + BINS * rising.astype(np.int64)
    count = np.bincount(number, minlength=2 * BINS)
    mean = np.bincount(number, added, minlength=2 * BINS) / np.maximum(count, 1)
    apart = np.where((count[:BINS] > 0) & (count[BINS:] > 0), mean[:BINS] - mean[BINS:], 0.0)
    return float(apart.max())
