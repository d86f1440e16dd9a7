"""Streams on two clocks: merging, low-pass, delay, and how much a correlated series is worth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

_REACH_S = 0.01
_MOST_KEPT = 2**20
"""Values from which a median is taken; of longer series every second, fourth …"""


class ThinnedSeries:
    """A series of which so many values are kept as its median needs.

    Parameters
    ----------
    least
        From which value on it counts as loaded.
    """

    def __init__(self, least: float) -> None:
        self.least = least
        self.kept = np.zeros(0)
        self.every, self.count, self.loaded, self.largest = 1, 0, 0, -np.inf

    def add(self, values: FloatArray) -> None:
        """Take in the next values, shape (n,)."""
        chosen = values[(-self.count) % self.every :: self.every]
        self.kept = np.concatenate([self.kept, chosen])
        while self.kept.size > _MOST_KEPT:
            self.kept, self.every = self.kept[::2], 2 * self.every
        self.count += values.size
        self.loaded += int(np.sum(values > self.least))
        self.largest = max(self.largest, float(np.nanmax(values, initial=-np.inf)))

    @property
    def median(self) -> float:
        """Of all that were kept."""
        known = self.kept[np.isfinite(self.kept)]
        return float(np.median(known)) if known.size else np.nan


CUTOFF_HZ = 10.0
"""Low-pass of force and acceleration terms ([NAO], section 4.1)."""
_FILTER_ORDER = 2
GAP_PERIODS = 3.5
"""An interval this many times the median one is long, and a gap where its time stays lost."""
CUT_STEPS = 3.0
"""A file that begins within so many sample periods after another one's end goes on with it."""
_AROUND_GAP = 20
_LOST_SHARE, _LEAST_LOST = 0.5, 1.5
_ON_STAMP = 1e-9
_NORMAL_SD = 1.4826  # sd of a normal variable over its median size
_CARRIES = 50.0  # autocorrelation times in a series that can tell its own


PART_ROWS = 2**18
"""Rows of a long recording that are worked on together."""


def parts_of(size: int, rows: int | None = None) -> Iterator[slice]:
    """Successive parts of `rows` rows, `PART_ROWS` unless given, of a recording of so many rows."""
    step = PART_ROWS if rows is None else rows
    for start in range(0, size, step):
        yield slice(start, min(start + step, size))


@dataclass(frozen=True)
class Clock:
    """How many stamps of a stream are wrong, by kind of fault.

    Parameters
    ----------
    keep
        Rows left after repeated and backward stamps are dropped.
    duplicates, backward
        Rows dropped because their stamp repeats or precedes the one before.
    gaps, longest_gap_s, missing
        Intervals longer than 3.5 periods that no hurry afterwards makes up for, the longest, and
        the samples that would fill them.
    gap_s
        How long each gap lasts, shape (gaps,).
    """

    keep: IntArray
    period_s: float
    duplicates: int
    backward: int
    gaps: int
    longest_gap_s: float
    missing: int
    gap_s: FloatArray


def missing_in(gap_s: FloatArray, period_s: float) -> int:
    """How many samples would fill gaps of such lengths (g,)."""
    return int(np.sum(np.round(gap_s / period_s) - 1)) if gap_s.size else 0


def clock_of(time_s: FloatArray) -> Clock:
    """Find repeated and backward stamps and gaps.

    Parameters
    ----------
    time_s
        Stamps as logged, shape (n,); not finite ones are dropped as backward.
    """
    highest = np.maximum.accumulate(np.where(np.isfinite(time_s), time_s, -np.inf))
    before = np.concatenate([[-np.inf], highest[:-1]])
    keep = np.flatnonzero(time_s > before)
    duplicates = int(np.sum(time_s[1:] == before[1:]))
    interval = np.diff(time_s[keep])
    period = float(np.median(interval)) if interval.size else np.nan
    long = interval[gaps_of(time_s[keep])]
    return Clock(
        keep=keep,
        period_s=period,
        duplicates=duplicates,
        backward=int(time_s.size - keep.size - duplicates),
        gaps=int(long.size),
        longest_gap_s=float(long.max() if long.size else interval.max(initial=0.0)),
        missing=missing_in(long, period),
        gap_s=long,
    )


def goes_on(before_s: FloatArray, after_s: FloatArray) -> bool:
    """Whether one recording goes on with another: its next sample is the other one's first.

    Parameters
    ----------
    before_s, after_s
        Stamps of both, s.
    """
    if before_s.size < 2 or not after_s.size:
        return False
    step_s = float(np.median(np.abs(np.diff(before_s))))
    return 0.0 < float(after_s.min() - before_s.max()) <= CUT_STEPS * step_s


def gaps_of(time_s: FloatArray) -> IntArray:
    """Rows after which samples are missing.

    A stamp that was only late makes one interval long and the next ones short: the samples around
    it still lie on one even grid. Where samples were lost the grid jumps by their time.

    Parameters
    ----------
    time_s
        Increasing stamps, shape (n,).
    """
    steps = np.diff(time_s)
    if steps.size < 2:
        return np.zeros(0, dtype=np.int64)
    long = np.flatnonzero(steps > GAP_PERIODS * float(np.median(steps)))
    # jitter makes single steps lean to one side; over many of them it does not add up
    reach = _AROUND_GAP if steps.size > 5 * _AROUND_GAP else 1
    period = float(np.median(time_s[reach:] - time_s[:-reach])) / reach
    found = []
    for i in long:
        # a longer interval near by would be counted again
        longer = long[steps[long] > steps[i]]
        first = max(i + 1 - _AROUND_GAP, int(longer[longer < i].max(initial=-1)) + 1)
        last = min(i + 1 + _AROUND_GAP, int(longer[longer > i].min(initial=len(time_s))) + 1)
        before, after = time_s[first : i + 1], time_s[i + 1 : last]
        # each side's own idea of the moment between the two
        left = np.median(before + period * np.arange(before.size, 0, -1))
        right = np.median(after - period * np.arange(after.size))
        if right - left > max(_LOST_SHARE * (steps[i] - period), _LEAST_LOST * period):
            found.append(i)
    return np.array(found, dtype=np.int64)


def acceleration_of(place_m: FloatArray, time_s: FloatArray) -> FloatArray:
    """Second derivative of places, shape of `place_m`; 0 where one is lost.

    ``2 (d₊ − d₋) / (t₊ − t₋)``, d the slopes to the sample 10 ms before and after, or the next
    one where samples are rarer: the resolution of encoders is not blown up at high rates, and the
    swing of a foot, 5 Hz, not flattened at low ones (by 0.8 % at ± 10 ms, by 3 % at 50 Hz).

    Parameters
    ----------
    place_m
        Shape (n, ...).
    time_s
        Increasing stamps of the stream, shape (n,).
    """
    acceleration = np.zeros_like(place_m)
    if len(time_s) < 3:
        return acceleration
    reach = max(round(_REACH_S / float(np.median(np.diff(time_s)))), 1)
    reach = min(reach, (len(time_s) - 1) // 2)
    shape = (-1, *[1] * (place_m.ndim - 1))
    steps = (time_s[reach:] - time_s[:-reach]).reshape(shape)
    slopes = (place_m[reach:] - place_m[:-reach]) / steps
    change, apart = slopes[reach:] - slopes[:-reach], steps[reach:] + steps[:-reach]
    acceleration[reach:-reach] = 2.0 * change / apart
    acceleration[:reach], acceleration[-reach:] = acceleration[reach], acceleration[-reach - 1]
    return np.asarray(np.nan_to_num(acceleration))


def slopes_of(values: FloatArray, time_s: FloatArray) -> FloatArray:
    """First derivative of values (n, ...) at increasing stamps (n,); 0 where lost.

    Over the sample before and the one after.
    """
    if len(time_s) < 2:
        return np.zeros_like(values)
    return np.asarray(np.nan_to_num(np.gradient(values, time_s, axis=0)))


def interpolate_stream(
    time_s: FloatArray, values: FloatArray, at_s: FloatArray, *, max_gap_s: float
) -> tuple[FloatArray, BoolArray]:
    """Linear interpolation onto another clock; nothing is invented over gaps or beyond the ends.

    Parameters
    ----------
    time_s
        Increasing stamps of the stream, shape (n,).
    values
        Shape (n, k); a NaN spoils only its own column's neighbours.
    at_s
        Stamps wanted, shape (m,).
    max_gap_s
        Longest interval to interpolate across.

    Returns
    -------
    values, shape (m, k), and where they may be trusted, shape (m,)
    """
    after = np.clip(np.searchsorted(time_s, at_s), 1, max(time_s.size - 1, 1))
    left, right = time_s[after - 1], time_s[after]
    weight = np.clip((at_s - left) / (right - left), 0.0, 1.0)[:, None]
    merged = values[after - 1] * (1.0 - weight) + values[after] * weight
    # on a stamp the other neighbour's NaN must not come through
    merged = np.where(weight < _ON_STAMP, values[after - 1], merged)
    merged = np.where(weight > 1.0 - _ON_STAMP, values[after], merged)
    inside = (at_s >= time_s[0]) & (at_s <= time_s[-1]) & (right - left <= max_gap_s)
    return merged, inside & np.isfinite(merged).all(axis=1)


def interpolate_slow(time_s: FloatArray, values: FloatArray, at_s: FloatArray) -> FloatArray | None:
    """What changes slowly, as a temperature does, at other times, its gaps filled in by lines.

    None where nothing of it is known.
    """
    known = np.isfinite(values) & np.isfinite(time_s)
    return np.interp(at_s, time_s[known], values[known]) if known.any() else None


def low_pass(
    values: FloatArray, rate_hz: float, cutoff_hz: float = CUTOFF_HZ, *, causal: bool = False
) -> FloatArray:
    """Butterworth low-pass along the first axis.

    Zero-phase: second order run forward and backward, −6 dB at the cut-off. Causal: second order
    run forward once from steady state, group delay near ``0.22 / cutoff_hz``.

    Parameters
    ----------
    values
        Evenly sampled and finite, shape (n, ...).
    rate_hz, cutoff_hz
        Sampling rate and cut-off; above 0.45 of the rate nothing is done.
    causal
        True: use no sample from the future.
    """
    if cutoff_hz >= 0.45 * rate_hz or len(values) < 2:
        return np.array(values, dtype=float)
    from scipy.signal import butter, sosfilt, sosfilt_zi, sosfiltfilt

    sections = butter(_FILTER_ORDER, cutoff_hz, fs=rate_hz, output="sos")
    if causal:
        start = sosfilt_zi(sections).reshape(len(sections), 2, *(1,) * (values.ndim - 1))
        filtered, _ = sosfilt(sections, values, axis=0, zi=start * values[:1])
        return np.asarray(filtered)
    padding = min(len(values) - 1, int(3 * rate_hz / cutoff_hz))
    return np.asarray(sosfiltfilt(sections, values, axis=0, padlen=padding))


def low_pass_stretches(
    values: FloatArray,
    good: BoolArray,
    rate_hz: float,
    cutoff_hz: float = CUTOFF_HZ,
    *,
    causal: bool = False,
) -> FloatArray:
    """Low-pass each unbroken stretch of good rows on its own; rows that are not good become NaN.

    Parameters
    ----------
    values
        Shape (n, k).
    good
        Shape (n,).
    """
    filtered = np.full(values.shape, np.nan)
    for start, stop in stretches(good):
        filtered[start:stop] = low_pass(values[start:stop], rate_hz, cutoff_hz, causal=causal)
    return filtered


def stretches(flags: BoolArray) -> list[tuple[int, int]]:
    """Runs of True as (start, stop)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def begins(numbers: IntArray) -> BoolArray:
    """Which rows do not have the number of the row before, shape (n,)."""
    return np.asarray(np.diff(numbers, prepend=numbers[:1] - 1) != 0)


def starts_of(numbers: IntArray) -> IntArray:
    """First row of every stretch of rows with the same number, in their order."""
    return np.flatnonzero(begins(numbers))


def peaks_kept(values: FloatArray, most: int) -> IntArray:
    """Numbers of the samples that draw a series of any length, shape (at most `most`,).

    Of every stretch the smallest and the largest value, in their order, so that no peak is lost.
    """
    if values.size <= most:
        return np.arange(values.size)
    stretches = most // 2
    length = -(-values.size // stretches)
    padded = np.full(stretches * length, np.nan)
    padded[: values.size] = values
    rows = padded.reshape(stretches, length)
    start = length * np.arange(stretches)
    low = start + np.argmin(np.where(np.isnan(rows), np.inf, rows), axis=1)
    high = start + np.argmax(np.where(np.isnan(rows), -np.inf, rows), axis=1)
    chosen = np.unique(np.concatenate([low, high]))
    return np.asarray(chosen[chosen < values.size])


def autocorrelation_time(series: FloatArray, sequence: IntArray | None = None) -> float:
    """Integrated autocorrelation time in samples, ``τ = 1 + 2 Σ ρ_k`` with Sokal's window of 5 τ.

    A series shorter than 50 τ does not carry that sum (Foreman-Mackey et al. 2013); there it is at
    least that of a first-order process, ``(1 + ρ_1)/(1 − ρ_1)``.

    Parameters
    ----------
    series
        Shape (n,), evenly sampled; its mean is taken off.
    sequence
        Number of the gap-free stretch of each sample, shape (n,), stretches together: products
        across a gap do not count.
    """
    centred = series - series.mean() if series.size else series
    if centred.size < 4 or not centred.any():
        return 1.0
    fresh = [0] if sequence is None else np.flatnonzero(np.diff(sequence, prepend=sequence[0] - 1))
    stretches = np.split(centred, fresh[1:])
    n = max(stretch.size for stretch in stretches)
    spectrum = np.zeros(n + 1)
    for stretch in stretches:
        spectrum += np.abs(np.fft.rfft(stretch, 2 * n)) ** 2
    correlation = np.fft.irfft(spectrum)[:n]
    correlation /= correlation[0]
    tau = 2.0 * np.cumsum(correlation) - 1.0
    beyond = np.flatnonzero(np.arange(n) >= 5.0 * tau)
    found = float(max(tau[int(beyond[0]) if beyond.size else n - 1], 1.0))
    if n > 1 and series.size < _CARRIES * found:
        found = max(found, float((1.0 + correlation[1]) / (1.0 - min(correlation[1], 0.999))))
    return found


def span_of(values: FloatArray) -> float:
    """Largest less least finite value, 0 without any."""
    good = values[np.isfinite(values)]
    return float(np.ptp(good)) if good.size else 0.0


def root_mean_square(values: FloatArray) -> float:
    """Of the finite values; NaN where there are none."""
    finite = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(finite**2))) if finite.size else float("nan")


def means_of(values: FloatArray, number: IntArray, least: int = 0, none: float = 0.0) -> FloatArray:
    """Mean of the values of each of at least so many numbers; of no values `none`."""
    sums, count = (np.bincount(number, weights, least) for weights in (values, None))
    return np.asarray(np.divide(sums, count, out=np.full(count.size, none), where=count > 0))


def median_sd(values: FloatArray) -> float:
    """The sd of a normal distribution about zero of the same median size; shape (n,)."""
    return _NORMAL_SD * float(np.median(np.abs(values)))
