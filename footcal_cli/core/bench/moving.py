"""A reference that never stands still: a press that runs up and down, a person on a plate.

Reading and reference are compared sample by sample. What one lags behind the other would look like
hysteresis, so the lag that leaves the least residual of ``S = (F(t − lag) − bias)/scale`` is taken
out first. Both are then averaged over intervals; noise that is left in the regressor pulls a slope
towards zero by its share of the regressor's variance (Fuller, Measurement Error Models, 1987, 1.1).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.bench.plateaus import (
    PlateauOptions,
    SampleState,
    find_outliers,
    find_plateaus,
)
from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

_LONGEST_LAG_S = 0.5
_STEPS = 40


@dataclass(frozen=True)
class Alignment:
    """How a reading follows a moving reference.

    Parameters
    ----------
    load_n
        The reference at the times that the reading shows, shape (n,); NaN beyond its ends.
    lag_s
        How late the reading is.
    attenuation
        Share by which noise in the reference or in the reading pulls the slope towards zero, if
        so many samples are averaged as the fit averages.
    """

    load_n: FloatArray
    lag_s: float
    attenuation: float


@dataclass(frozen=True)
class Aligned:
    """A record without its lags.

    Parameters
    ----------
    record
        Load and reading of the samples that can be used, NaN elsewhere.
    state
        `SampleState`, shape (n,).
    lags_s
        Of every session.
    attenuation
        The largest of any session.
    """

    record: BenchRecord
    state: IntArray
    lags_s: tuple[float, ...]
    attenuation: float


def never_still(record: BenchRecord, options: PlateauOptions) -> bool:
    """Whether the load is known at every sample, moves, and stands still at one level at most."""
    if not np.isfinite(record.load_n).all() or np.ptp(record.load_n) == 0:
        return False
    levels = sum(
        np.unique(
            find_plateaus(record.time_s[part], record.load_n[part], options.of_loads).level
        ).size
        for part in record.sessions()
    )
    return levels < 2


def without_lags(record: BenchRecord, options: PlateauOptions, averaged: int) -> Aligned:
    """Take the lag of every session out of a record whose reference never stands still.

    Parameters
    ----------
    record, options
        Samples, and what a glitch is.
    averaged
        How many neighbours the fit averages.
    """
    state = np.full(len(record), SampleState.SETTLED, dtype=np.int64)
    load, found = record.load_n.copy(), []
    for part in record.sessions():
        dropout, glitch = find_outliers(record.reading[part], options)
        state[part] = np.where(
            dropout, SampleState.DROPOUT, np.where(glitch, SampleState.GLITCH, state[part])
        )
        used = ~(dropout | glitch)
        one = align(record.time_s[part], load[part], record.reading[part], used, averaged)
        load[part] = one.load_n
        found.append(one)
    usable = (state == SampleState.SETTLED) & np.isfinite(load)
    return Aligned(
        replace(
            record, load_n=np.where(usable, load, np.nan),
            reading=np.where(usable, record.reading, np.nan),
        ),
        state, tuple(one.lag_s for one in found), max(one.attenuation for one in found),
    )  # fmt: skip


def align(
    time_s: FloatArray, load_n: FloatArray, reading: FloatArray, used: BoolArray, averaged: int
) -> Alignment:
    """Take the lag out of a reading under a moving reference.

    Parameters
    ----------
    time_s, load_n, reading
        One session, shape (n,); times increase.
    used
        Samples that are neither glitches nor dropouts, shape (n,).
    averaged
        How many neighbours the fit averages.
    """
    known = load_n[used & np.isfinite(load_n)]
    if not known.size or np.ptp(known) == 0.0:  # a load that never changes says no lag
        return Alignment(load_n, 0.0, 0.0)
    step = float(np.median(np.diff(time_s)))
    reach = min(_LONGEST_LAG_S, 0.05 * float(np.ptp(time_s)))
    coarse = np.linspace(-reach, reach, 2 * _STEPS + 1)
    lag = float(coarse[int(np.argmin([_misfit(x, time_s, load_n, reading, used) for x in coarse]))])
    width = float(coarse[1] - coarse[0])
    while width > 0.02 * step:  # parabola through three lags, ever closer
        left, mid, right = (
            _misfit(x, time_s, load_n, reading, used) for x in (lag - width, lag, lag + width)
        )
        bend = left - 2 * mid + right
        lag += float(np.clip(0.5 * (left - right) / bend, -1, 1)) * width if bend > 0 else 0.0
        width /= 2
    shifted = _shifted(lag, time_s, load_n)
    shares = [_noise_share(values[used], averaged) for values in (load_n, reading)]
    return Alignment(shifted, lag, max(shares))


def _shifted(lag_s: float, time_s: FloatArray, load_n: FloatArray) -> FloatArray:
    return np.asarray(np.interp(time_s - lag_s, time_s, load_n, left=np.nan, right=np.nan))


def _misfit(
    lag_s: float, time_s: FloatArray, load_n: FloatArray, reading: FloatArray, used: BoolArray
) -> float:
    """Mean square residual of the reading on the shifted reference."""
    shifted = _shifted(lag_s, time_s, load_n)
    at = used & np.isfinite(shifted)
    x = shifted[at] - shifted[at].mean()
    y = reading[at] - reading[at].mean()
    return float(np.mean((y - x * (x @ y) / (x @ x)) ** 2))


def _noise_share(values: FloatArray, averaged: int) -> float:
    """White noise of a smooth signal, by its third differences, as a share of its variance.

    Third differences of white noise of variance v have variance 20 v.
    """
    third = np.diff(values, 3)
    noise = float(np.median(third**2)) / 0.4549 / 20.0
    return noise / max(averaged, 1) / max(float(np.var(values)), 1e-300)
