"""Rows of a walk without the frequencies at which an ordinary estimator makes motion up.

An estimator's CoM acceleration holds motion that never was: odometry that changes its foot bumps at
every step, and each bump is differentiated twice. These false forces repeat with the gait, so that
thousands of steps never average them out, and gains of cells are bent until they fit. They are
harmonics of the step; what moves a robot from foot to foot is the step itself. Where errors repeat,
total rows are filtered below the second harmonic of the step, on both sides alike, and only as many
are kept as are independent.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.signal import butter, sosfiltfilt

from footcal_cli.core.contact import gait_cycles
from footcal_cli.core.log import Log
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.parameters import BoolArray, FloatArray

_HARMONICS = 2.4
"""Cutoff in cycles per stride: above the step, which is the second."""
_ORDER = 4
_SPARE = 1.1
"""Rows kept over the two per period that a cutoff leaves independent."""


def step_band_hz(log: Log) -> float:
    """Cutoff above the frequency of steps, Hz; ``inf`` without whole gait cycles."""
    cycle = gait_cycles(log.known["contact"])
    starts = np.flatnonzero(np.diff(cycle) > 0) + 1
    if starts.size < 2:
        return np.inf
    return float(_HARMONICS / np.median(np.diff(log.time_s[starts])))


def within_band(rows: Rows, cutoff_hz: float) -> Rows:
    """Totals without what lies above a frequency, and only as many as are independent.

    Errors and their derivatives are filtered alike, so that the rows stay exact. What swinging
    feet show needs no demand and stays as it is.
    """
    if not np.isfinite(cutoff_hz):
        return rows
    step = float(np.median(np.diff(rows.time_s)))
    every = int(1.0 / (2.0 * _SPARE * cutoff_hz * step))
    if every < 2:
        return rows
    sections = butter(_ORDER, 2.0 * cutoff_hz * step, output="sos")
    totals = slice(0, rows.totals)
    valid = rows.valid.copy()
    whole: BoolArray = np.asarray(valid[:, totals].all(axis=1))

    def filtered(values: FloatArray) -> FloatArray:
        held = _held(values, whole)
        return np.asarray(sosfiltfilt(sections, held, axis=0))

    h, error, stamps = rows.h.copy(), rows.error.copy(), rows.per_stamp_s
    h[:, totals], error[:, totals] = filtered(h[:, totals]), filtered(error[:, totals])
    stamps = None if stamps is None else filtered(stamps)
    # near a gap and near the ends the filter sees what was put there
    gaps = np.pad(~whole, every, constant_values=True)
    around = np.convolve(gaps, np.ones(2 * every + 1), "valid") > 0.5
    kept = np.zeros(whole.size, dtype=bool)
    kept[every // 2 :: every] = True
    valid[:, totals] &= (kept & ~around)[:, None]
    return replace(rows, h=h, error=error, per_stamp_s=stamps, valid=valid)


def _held(values: FloatArray, good: BoolArray) -> FloatArray:
    """Rows that do not count replaced by the last that did."""
    at = np.where(good, np.arange(good.size), -1)
    at = np.maximum.accumulate(at)
    first = int(np.argmax(good))
    return np.asarray(values[np.where(at < 0, first, at)])
