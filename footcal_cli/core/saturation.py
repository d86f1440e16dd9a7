"""Samples at which a sensor stood at the end of its range: they only say that it was beyond."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.readings import find_end_codes
from footcal_cli.core.signals import median_sd

_PILED, _FAR, _HARD_MPS2 = 5, 5.0, 2.0
"""Samples at an extreme value, and its distance in robust sd and m/s², that show cut impacts."""
_FEWEST = 20
_FLAT = 8
"""Samples that a flat top lasts, and how many times longer than any other value is held."""
_AT_REST = 0.2
"""Share of the samples that no sensor spends beyond its range: there it rests."""


def find_saturated(name: str, values: FloatArray, bits: int, *, in_time: bool) -> BoolArray:
    """Samples of a canonical column that stand at the end of its sensor's range, shape (n,).

    Counts at an end code of the converter; what is sampled in time at a flat top; accelerations
    where impacts pile up. An end where the sensor spends a fifth of the log is where it rests.

    Parameters
    ----------
    name
        Canonical column, as ``left_fl_counts``, ``imu_acc_z_mps2``, ``fx_n``.
    values
        Shape (n,), NaN where a sample was lost.
    bits
        Of the converter of counts.
    in_time
        Whether rows are samples of a clock in order; otherwise each is a reading of its own.
    """
    found = np.zeros(values.size, dtype=bool)
    if "acc_" in name:
        found = find_cut_impacts(values)
    elif in_time:
        found = find_flat_tops(values)
    if name.endswith("counts"):
        found |= find_end_codes(values, bits)
    for end in np.unique(values[found]):
        here = values == end
        if here.mean() > _AT_REST or (end == 0.0 and not name.endswith("counts")):
            found &= ~here
    return found


def find_cut_impacts(values: FloatArray) -> BoolArray:
    """Accelerations (m/s²) at an extreme value, far out and taken too often, shape (n,).

    A tail thins out towards its end. Where a value is the extreme one several times, more than
    twice as often as the value before, and far from where the sensor usually is, impacts were cut.
    """
    found = np.zeros(values.size, dtype=bool)
    good = values[np.isfinite(values)]
    levels, counts = np.unique(good, return_counts=True)
    if levels.size < _FEWEST:
        return found
    middle = np.median(good)
    usual = median_sd(good - middle)
    for end, before in ((0, 1), (-1, -2)):
        far = abs(levels[end] - middle) > max(_FAR * usual, _HARD_MPS2)
        if far and counts[end] >= _PILED and counts[end] > 2 * counts[before]:
            found |= values == levels[end]
    return found


def find_flat_tops(values: FloatArray) -> BoolArray:
    """Samples at an extreme value that is held far longer than any other value, shape (n,).

    Noise and motion move a reading; a sensor beyond its range shows the same end again and again.
    """
    found = np.zeros(values.size, dtype=bool)
    good = values[np.isfinite(values)]
    if np.unique(good).size < _FEWEST:
        return found
    starts = np.flatnonzero(np.concatenate([[True], np.diff(good) != 0.0]))
    held, lengths = good[starts], np.diff(np.concatenate([starts, [good.size]]))
    low, high = good.min(), good.max()
    between = lengths[(held > low) & (held < high)].max()
    for end in (low, high):
        if lengths[held == end].max() >= _FLAT * between:
            found |= values == end
    return found
