"""What recording does to a reading and no physics: the low-pass at lift-off, the converter's step.

Both repeat with the gait, so that a test for anything that repeats would find them.
"""

from __future__ import annotations

from math import comb

import numpy as np
from scipy.ndimage import uniform_filter1d

from footcal_cli.core.contact import ContactRule
from footcal_cli.core.experiments.walk import channel_contact
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import low_pass, low_pass_stretches, stretches

_LEVEL_QUANTILE = 0.05
"""A few odd readings between the levels of a converter do not make its step small."""
_WINDOW_S = 0.1
"""Over which noise is measured: it may grow with the load, and a foot that lands is none."""
_ORDER = 4
"""Of the differences in which noise is measured: half as quick a load is a thirtieth in them."""


def swings_apart(log: Log, raw: FloatArray, rate_hz: float) -> Log:
    """Smooth the readings of each swing on their own.

    A zero-phase low-pass over the whole recording carries a trace of the load into the swing, from
    before lift-off and from after touch-down: 3·10⁻⁴ of the load 60 ms away, which is more than
    the noise of a good cell at rest. What the two ways differ by at the ends of a swing runs out
    over the transitions beside it: a step there would be the sharpest change that a sensor's lag
    ever saw.

    Parameters
    ----------
    log
        Filtered readings and settled contact.
    raw
        The same rows unfiltered, shape (n, c).
    """
    readings = log.readings.copy()
    width = round(ContactRule().settle_s * rate_hz)
    ramp = 1.0 - np.arange(1, width + 1) / (width + 1)
    for c, contact in enumerate(channel_contact(log).T):
        air = (contact == 0.0) & np.isfinite(raw[:, c]) & np.isfinite(readings[:, c])
        alone = low_pass_stretches(raw[:, c : c + 1], air, rate_hz)
        step = np.where(air, alone[:, 0] - readings[:, c], 0.0)
        between = np.isnan(contact)
        for start, stop in stretches(air):
            for edge, side in ((start, -1), (stop - 1, 1)):
                rows = edge + side * np.arange(1, ramp.size + 1)
                rows = rows[(rows >= 0) & (rows < len(step))]
                held = np.cumprod(between[rows])
                step[rows] += held * ramp[: rows.size] * step[edge]
        readings[:, c] += step
    return log.with_readings(readings)


def steps_of(raw: FloatArray) -> FloatArray:
    """Distance between neighbouring levels of each channel, in its unit, shape (c,)."""
    steps = np.zeros(raw.shape[1])
    for c, values in enumerate(raw.T):
        gaps = np.diff(np.unique(values[np.isfinite(values)]))
        steps[c] = np.quantile(gaps, _LEVEL_QUANTILE) if gaps.size else 0.0
    return steps


def noise_of_smoothed(raw: FloatArray, smooth: FloatArray, rate_hz: float) -> FloatArray:
    """Noise left in smoothed readings, from what changes at the quickest if noise is white, (c,).

    ``σ² = Σ_k |Δ⁴x|² / 70``: loads of a gait hold next to nothing near half the rate, but much of
    what a low-pass takes off. The median over stretches: nor is a touch-down.
    """
    good = np.isfinite(raw).all(axis=1) & np.isfinite(smooth).all(axis=1)
    if good.sum() < _ORDER + 2:
        return np.zeros(raw.shape[1])
    impulse = np.zeros((round(2 * rate_hz) + 1, 1))
    impulse[impulse.size // 2] = 1.0
    passed = float(np.sum(low_pass(impulse, rate_hz) ** 2))
    quick = np.diff(raw[good], _ORDER, axis=0) ** 2 / comb(2 * _ORDER, _ORDER)
    local = uniform_filter1d(quick, max(round(_WINDOW_S * rate_hz), 1), axis=0)
    return np.asarray(np.sqrt(np.maximum(np.median(local, axis=0), 0.0) * passed))
