"""Where a bench recording stands still: settled samples, holds, outliers, direction of loading.

A weight that is being put on, a hand on the rig and a glitch of the ADC look like data: every
sample gets one state, with the reason where it is not settled.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import pairwise

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.signals import parts_of
from footcal_cli.errors import DataError

_MAD_TO_SD = 1.4826
RAIL_CODES = (float(2**23 - 1), float(-(2**23)), float(2**24 - 1))
"""Readings a 24-bit converter shows when it is saturated or not answering."""
_MEDIAN_OF, _SCATTER_OF = 7, 31
_HALO = _MEDIAN_OF // 2 + _SCATTER_OF // 2
_GAP_FACTOR = 10.0
"""A pause this many sample intervals long ends a hold."""


class SampleState(IntEnum):
    """What a sample of a bench recording is good for."""

    SETTLED = 0
    MOVING = 1
    SHORT = 2
    GLITCH = 3
    DROPOUT = 4

    @property
    def reason(self) -> str:
        """The state in words."""
        return _REASONS[self]


_REASONS = {
    SampleState.SETTLED: "settled",
    SampleState.MOVING: "still moving",
    SampleState.SHORT: "hold too short",
    SampleState.GLITCH: "glitch: far from its neighbours",
    SampleState.DROPOUT: "dropout: no reading, or a converter's rail or zero code",
}


@dataclass(frozen=True)
class PlateauOptions:
    """What counts as standing still; tolerances that are 0 are chosen from the recording.

    Parameters
    ----------
    window_s
        Length over which a trend and a scatter are judged.
    min_hold_s
        Shorter holds are not used.
    settle_s
        Time cut from the start of every hold.
    max_change
        Largest trend over one window, in units of the reading.
    max_scatter
        Largest sd about that trend, in units of the reading.
    same_level
        Neighbouring holds whose readings differ by less than this share of the span are one load
        that was touched in between.
    glitch_sd
        Distance from the running median, in robust sd, beyond which a sample is a glitch.
    dropout_codes
        Readings that mean "no reading".
    """

    window_s: float = 2.0
    min_hold_s: float = 3.0
    settle_s: float = 0.0
    max_change: float = 0.0
    max_scatter: float = 0.0
    same_level: float = 0.02
    glitch_sd: float = 8.0
    dropout_codes: tuple[float, ...] = (0.0, *RAIL_CODES)

    @property
    def of_loads(self) -> PlateauOptions:
        """The same for a load that is known at every sample: zero is a load, not a dropout."""
        return replace(self, dropout_codes=())


@dataclass(frozen=True)
class Plateaus:
    """The holds of a recording and the state of every sample.

    Parameters
    ----------
    state
        `SampleState` per sample, shape (n,).
    hold
        Index of the hold of a settled sample, −1 elsewhere, shape (n,).
    level
        Index of the load a hold belongs to: holds interrupted by a touch share one, shape (h,).
    start_s, stop_s
        First and last settled sample of each hold, shape (h,).
    median, sd
        Reading of each hold, and its scatter about its own trend, shape (h,).
    n
        Settled samples of each hold, shape (h,).
    """

    state: IntArray
    hold: IntArray
    level: IntArray
    start_s: FloatArray
    stop_s: FloatArray
    median: FloatArray
    sd: FloatArray
    n: IntArray

    def __len__(self) -> int:
        return self.start_s.size


def find_outliers(
    reading: FloatArray, options: PlateauOptions | None = None
) -> tuple[BoolArray, BoolArray]:
    """Dropouts and glitches of a recording.

    A glitch is a sample (or two) further than `glitch_sd` robust sd from the running median of
    seven, which follows a true step: a weight put on is not a glitch.

    Parameters
    ----------
    reading
        Shape (n,), one uninterrupted recording in order of time.

    Returns
    -------
    dropout, glitch
        Shape (n,) each; no sample is both.
    """
    from scipy.ndimage import median_filter

    options = options or PlateauOptions()
    dropout = ~np.isfinite(reading) | np.isin(reading, options.dropout_codes)
    if dropout.all():
        return dropout, np.zeros_like(dropout)
    if _is_a_real_level(reading, dropout):
        dropout = ~np.isfinite(reading)
    filled = _fill(reading, dropout) if dropout.any() else reading
    steps = np.abs(np.diff(filled))
    quiet = _MAD_TO_SD * float(np.median(steps)) / np.sqrt(2.0) if steps.size else 0.0
    least = max(quiet, _smallest_step(filled))
    glitch = np.empty_like(dropout)
    for part in parts_of(filled.size):
        around = slice(max(part.start - _HALO, 0), part.stop + _HALO)  # what the filters reach
        near = filled[around]
        away = np.abs(near - median_filter(near, size=_MEDIAN_OF, mode="nearest"))
        # local scatter: where the load is moved by hand, neighbours differ without being wrong
        local = _MAD_TO_SD * median_filter(away, size=_SCATTER_OF, mode="nearest")
        inside = slice(part.start - around.start, part.stop - around.start)
        glitch[part] = (away > options.glitch_sd * np.maximum(local, least))[inside]
    return dropout, glitch & ~dropout


def find_plateaus(
    time_s: FloatArray, reading: FloatArray, options: PlateauOptions | None = None
) -> Plateaus:
    """Holds of a recording: where trend and scatter over a window are both small.

    Within a centred window of `window_s` a line is fitted; a sample is moving where the line
    changes by more than `max_change` over the window or the scatter about it exceeds
    `max_scatter`. Without given tolerances these are 4 quiet sd, at least 0.2 % and 0.1 % of the
    span: creep passes, a hand does not.

    Parameters
    ----------
    time_s, reading
        Shape (n,), times increasing.
    """
    options = options or PlateauOptions()
    if np.any(np.diff(time_s) < 0):
        raise DataError(
            "times of a recording must increase", column="time_s",
            remedy="sort the rows by time, or check the clock",
        )  # fmt: skip
    dropout, glitch = find_outliers(reading, options)
    state = np.full(reading.size, SampleState.MOVING, dtype=np.int64)
    state[dropout], state[glitch] = SampleState.DROPOUT, SampleState.GLITCH
    used = ~(dropout | glitch)
    hold = np.full(reading.size, -1, dtype=np.int64)
    if used.sum() < 3:
        return _collect(time_s, reading, state, hold, 0.0)
    slope, scatter = _window_trend(time_s[used], reading[used], options.window_s)
    low, high = np.quantile(reading[used], [0.01, 0.99])
    max_change, max_scatter = _tolerances(reading[used], scatter, options)
    still = (np.abs(slope) * options.window_s <= max_change) & (scatter <= max_scatter)
    del slope, scatter  # a day at 80 Hz: 110 MB
    at = np.flatnonzero(used)
    number = 0
    for first, last in _runs(time_s[at], still):
        run = at[first : last + 1]
        run = run[time_s[run] >= time_s[run[0]] + options.settle_s]
        if run.size < 3 or time_s[run[-1]] - time_s[run[0]] < options.min_hold_s:
            state[at[first : last + 1]] = SampleState.SHORT
            continue
        state[run], hold[run] = SampleState.SETTLED, number
        number += 1
    return _collect(time_s, reading, state, hold, options.same_level * float(high - low))


def _tolerances(
    reading: FloatArray, scatter: FloatArray, options: PlateauOptions
) -> tuple[float, float]:
    """Largest trend and largest scatter of a window that stands still."""
    quiet = float(np.quantile(scatter, 0.2))
    low, high = np.quantile(reading, [0.01, 0.99])
    max_change = options.max_change or max(4.0 * quiet, 0.002 * (high - low))
    max_scatter = options.max_scatter or max(4.0 * quiet, 0.001 * (high - low))
    return float(max_change), float(max_scatter)


def find_direction(
    load_n: FloatArray, time_s: FloatArray | None = None, block: IntArray | None = None
) -> IntArray:
    """Whether a load was reached from below (+1) or above (−1); 0 before the first change.

    What is less than a millionth of the range of the loads is no change.

    Parameters
    ----------
    load_n
        True loads, shape (n,).
    time_s
        Order in which they were applied; row order where absent.
    block
        Session of each row; a direction is not carried over from one session to the next.
    """
    order = np.arange(load_n.size) if time_s is None else np.argsort(time_s, kind="stable")
    if block is not None:
        order = order[np.argsort(block[order], kind="stable")]
    ordered = load_n[order]
    change = np.diff(ordered, prepend=ordered[:1])
    tolerance = 1e-6 * (float(np.ptp(ordered)) if ordered.size else 0.0)
    sign = np.where(np.abs(change) > tolerance, np.sign(change), 0.0)
    new_block = np.zeros(load_n.size, dtype=bool)
    if block is not None and load_n.size:
        new_block[1:] = np.diff(block[order]) != 0
    marks = np.flatnonzero((sign != 0) | new_block)
    sign[new_block] = 0.0
    last = np.searchsorted(marks, np.arange(load_n.size), side="right") - 1
    direction = np.zeros(load_n.size, dtype=np.int64)
    known = last >= 0
    direction[order[known]] = sign[marks[last[known]]].astype(np.int64)
    return direction


def _is_a_real_level(reading: FloatArray, dropout: BoolArray) -> bool:
    """A code that is where the neighbours are is a level, not a dropout (a tared cell reads 0)."""
    finite = np.isfinite(reading)
    coded, plain = reading[dropout & finite], reading[~dropout]
    if not coded.size or not plain.size:
        return False
    margin = 0.05 * float(np.ptp(plain))
    return bool(np.all((coded >= plain.min() - margin) & (coded <= plain.max() + margin)))


def _fill(reading: FloatArray, missing: BoolArray) -> FloatArray:
    """Missing samples interpolated from their neighbours."""
    at = np.arange(reading.size)
    return np.asarray(np.interp(at, at[~missing], reading[~missing]))


def _smallest_step(reading: FloatArray) -> float:
    steps = np.diff(np.unique(reading))
    return float(steps.min()) if steps.size else 0.0


def _window_trend(
    time_s: FloatArray, reading: FloatArray, window_s: float
) -> tuple[FloatArray, FloatArray]:
    """Slope and scatter of a line over a centred window around each sample, piece by piece."""
    slope, scatter, middle = np.empty_like(time_s), np.empty_like(time_s), np.median(reading)
    for part in parts_of(time_s.size):
        ends = time_s[part.start] - window_s, time_s[part.stop - 1] + window_s
        first, stop = np.searchsorted(time_s, ends)
        inside = slice(part.start - first, part.stop - first)
        y = reading[first:stop] - middle
        slope[part], scatter[part] = _trend(time_s[first:stop], y, window_s, inside)
    return slope, scatter


def _trend(
    time_s: FloatArray, y: FloatArray, window_s: float, inside: slice
) -> tuple[FloatArray, FloatArray]:
    """Slope and scatter around the samples inside a piece, from running sums."""
    t = time_s - time_s.mean()
    sums = [
        np.concatenate([[0.0], np.cumsum(values)])
        for values in (np.ones_like(t), t, y, t * t, t * y, y * y)
    ]
    first = np.searchsorted(t, t[inside] - window_s / 2.0, side="left")
    stop = np.searchsorted(t, t[inside] + window_s / 2.0, side="right")
    n, st, sy, stt, sty, syy = (total[stop] - total[first] for total in sums)
    var_t, cov, var_y = stt - st**2 / n, sty - st * sy / n, syy - sy**2 / n
    enough = (n >= 3) & (var_t > 0)
    slope = np.divide(cov, var_t, out=np.zeros_like(cov), where=enough)
    rest = np.clip(var_y - slope * cov, 0.0, None)
    scatter = np.sqrt(np.divide(rest, n - 2, out=np.zeros_like(rest), where=n >= 3))
    return slope, scatter


def _runs(time_s: FloatArray, still: BoolArray) -> list[tuple[int, int]]:
    """First and last index of every stretch of still samples without a pause in it."""
    interval = float(np.median(np.diff(time_s))) if time_s.size > 1 else 0.0
    broken = np.zeros(still.size, dtype=bool)
    broken[1:] = np.diff(time_s) > _GAP_FACTOR * interval
    starts = still & (broken | ~np.concatenate([[False], still[:-1]]))
    ends = still & ~np.concatenate([still[1:] & ~broken[1:], [False]])
    return list(zip(np.flatnonzero(starts).tolist(), np.flatnonzero(ends).tolist(), strict=True))


def _collect(
    time_s: FloatArray, reading: FloatArray, state: IntArray, hold: IntArray, same_level: float
) -> Plateaus:
    """Statistics of every hold."""
    rows = []
    at = np.flatnonzero(hold >= 0)
    ends = np.searchsorted(hold[at], np.arange(int(hold.max(initial=-1)) + 2))
    for start, stop in pairwise(ends):
        t, y = time_s[at[start:stop]], reading[at[start:stop]]
        slope, intercept = np.polyfit(t - t[0], y, 1)
        rest = y - (intercept + slope * (t - t[0]))
        rows.append((t[0], t[-1], np.median(y), rest.std(ddof=2), y.size))
    table = np.array(rows).reshape(-1, 5).T
    moved = np.abs(np.diff(table[2], prepend=table[2][:1])) > same_level
    return Plateaus(
        state=state,
        hold=hold,
        level=np.cumsum(moved),
        start_s=table[0],
        stop_s=table[1],
        median=table[2],
        sd=table[3],
        n=table[4].astype(np.int64),
    )


def why_no_hold(
    time_s: FloatArray, reading: FloatArray, options: PlateauOptions
) -> tuple[str, str]:
    """Why nothing stands still long enough, and the tolerance that would take the stillest part.

    Parameters
    ----------
    time_s, reading
        One session, shape (n,).
    options
        The thresholds that found nothing.
    """
    dropout, glitch = find_outliers(reading, options)
    used = ~(dropout | glitch)
    if used.sum() < 3:
        return f"{int(dropout.sum())} of {reading.size} readings are dropouts", "check the wiring"
    times, values = time_s[used], reading[used]
    if np.ptp(times) < options.min_hold_s:
        return (
            f"the recording lasts {np.ptp(times):.3g} s, less than min_hold_s = "
            f"{options.min_hold_s:g} s", f"set min_hold_s below {np.ptp(times):.3g}",
        )  # fmt: skip
    slope, scatter = _window_trend(times, values, options.window_s)
    max_change, max_scatter = _tolerances(values, scatter, options)
    trend = np.abs(slope) * options.window_s
    still = (trend <= max_change) & (scatter <= max_scatter)
    runs = [(times[last] - times[first], times[first]) for first, last in _runs(times, still)]
    if runs:
        longest, start = max(runs)
        return (
            f"the longest stretch that stands still lasts {longest:.3g} s (from {start:.5g} s), "
            f"less than min_hold_s = {options.min_hold_s:g} s",
            f"hold each load longer, or set min_hold_s = {0.9 * longest:.2g}",
        )  # fmt: skip
    at = int(np.argmin(np.maximum(trend / max_change, scatter / max_scatter)))
    if trend[at] > max_change:
        return (
            f"the stillest window of {options.window_s:g} s (at {times[at]:.5g} s) still changes "
            f"by {trend[at]:.3g}, more than max_change = {max_change:.3g}",
            f"hold each load longer, or set max_change = {1.2 * trend[at]:.2g}",
        )  # fmt: skip
    return (
        f"the stillest window of {options.window_s:g} s (at {times[at]:.5g} s) scatters by "
        f"{scatter[at]:.3g}, more than max_scatter = {max_scatter:.3g}",
        f"damp the rig, or set max_scatter = {1.2 * scatter[at]:.2g}",
    )  # fmt: skip
