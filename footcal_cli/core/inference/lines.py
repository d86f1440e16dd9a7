"""Lines: one frequency that stands out of the noise of a channel, wherever it comes from.

A hum of a fraction of the noise is nothing in a mean and everything in a spectrum. A spectrum needs
long series of one channel at its full rate: rows as they were recorded, before any filter, not cut
where a block or a step ends. Rows that do not count (a foot on the ground) stay empty slots.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import ndimage
from scipy.linalg import solve_toeplitz

from footcal_cli.core import chances
from footcal_cli.core.inference.linear import least_squares
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.signals import median_sd

SWING_SLOTS = 2048
"""A longer series of swings is cut: a hum keeps its phase for half a minute, not for an hour."""
ROW_SLOTS = 256
"""The same of rows without gaps: the line of a weight that swings is a few per cent wide."""
_SHORTEST = 64
_LONGEST_GAP = 0.1  # of the longest piece: a hum is followed across steps, not across a pause
_ORDER = 4
_WIDTH = 41  # independent frequencies in a running median
_MEDIAN_EFFICIENCY = 0.5  # of a median of exponentials against their mean
_CYCLES = 1.2  # a stretch holds at least so many cycles of what is looked for
_RESOLVED = 10.0  # and a piece so many: what is slower is drift
_NYQUIST = 2.0  # frequencies next to half the rate
_FILLED = 0.08  # share of its slots that a piece fills at least
_BURST = 6.0  # robust sd beyond which a value is cut: a jump is no line
_SURE = 60.0  # times the noise
_BUSY = 0.1  # share of samples that differ from the one before; a code that stands is no noise
_CAUTION = 20.0  # of p < 1e-3 on nulls there were ten times as many as there should be


@dataclass(frozen=True)
class Series:
    """What channels show over time, where they should show nothing but noise.

    Parameters
    ----------
    values, time_s, channel
        Of each row, shape (n,); rows of one channel stand together in the order of recording.
    rate_hz
        Usual rate of the rows.
    most_slots
        Longest piece of which one periodogram is made.
    """

    values: FloatArray
    time_s: FloatArray
    channel: IntArray
    names: tuple[str, ...]
    rate_hz: float
    most_slots: int = ROW_SLOTS

    @cached_property
    def strongest(self) -> Line:
        """The strongest line of any channel: found once, whatever is fitted meanwhile."""
        found = []
        tests = 0
        for channel, name in enumerate(self.names):
            mine = np.flatnonzero(self.channel == channel)
            slot, piece = _slots(self.time_s[mine], self.rate_hz, self.most_slots)
            white, kept = _whitened(self.values[mine], slot, piece)
            spectra = list(_spectra(_without_bursts(white), slot[kept], piece[kept]))
            if spectra:
                chance, ratio, at = _highest(spectra, _usual_stretch(slot, piece))
                found.append((chance, -ratio, name, at * self.rate_hz, channel))
                tests += max(s.slots for s in spectra)
        if not found:
            return Line(rate_hz=self.rate_hz)
        least, _, name, frequency, channel = min(found)
        p = min(_CAUTION * tests * least, 1.0)
        return Line(p, name, frequency, self.rate_hz, self._rms_at(frequency, channel))

    def _rms_at(self, frequency_hz: float, channel: int) -> float:
        """Of a wave that has a phase and a height of its own in each piece."""
        mine = np.flatnonzero(self.channel == channel)
        slot, piece = _slots(self.time_s[mine], self.rate_hz, self.most_slots)
        squared, count = 0.0, 0
        for number in np.unique(piece):
            rows = np.flatnonzero(piece == number)
            angle = 2.0 * np.pi * frequency_hz / self.rate_hz * slot[rows]
            wave = np.stack([np.sin(angle), np.cos(angle)], axis=1)
            if rows.size > _SHORTEST:
                part = wave @ least_squares(wave, self.values[mine[rows]], 1e-9)
                squared, count = squared + float(part @ part), count + rows.size
        return float(np.sqrt(squared / max(count, 1)))


@dataclass(frozen=True)
class Traces:
    """Of which channel each row of a problem is, and when it was taken.

    Parameters
    ----------
    time_s, channel
        Of each row, shape (m,).
    """

    time_s: FloatArray
    channel: IntArray
    names: tuple[str, ...]

    def series(self, values: FloatArray, rate_hz: float) -> Series:
        """Values of the rows as series of their channels."""
        order = np.argsort(self.channel, kind="stable")
        return Series(values[order], self.time_s[order], self.channel[order], self.names, rate_hz)


@dataclass(frozen=True)
class Line:
    """The strongest line.

    Parameters
    ----------
    p
        Family-wise over all channels and frequencies.
    frequency_hz
        Below half the rate; what is faster shows as one of its aliases ``|k·rate ± f|``.
    rate_hz
        At which it was sampled.
    rms
        Of it in its channel, in the unit of the values.
    """

    p: float = 1.0
    name: str = ""
    frequency_hz: float = 0.0
    rate_hz: float = 0.0
    rms: float = 0.0


def _highest(spectra: Sequence[_Spectrum], stretch: float) -> tuple[float, float, float]:
    """The p of the highest ratio of power to noise, the ratio, and its frequency per slot.

    Periodograms over their own running median are averaged over the pieces. Under the null the
    ratio has an F distribution, whose denominator is the scatter of the median.
    """
    at = np.linspace(0.0, 0.5, max(s.power.size for s in spectra))
    mean = np.mean([np.interp(at, s.at, _soft(s.power / s.level)) for s in spectra], axis=0)
    length = float(np.mean([s.slots for s in spectra]))
    width = float(np.mean([s.width for s in spectra]))
    freedom = 2.0 * len(spectra)
    behind = freedom * _MEDIAN_EFFICIENCY * width
    # what was regressed out leaves notches that all pieces share
    shared = ndimage.median_filter(mean, round(width / length * 2 * at.size) | 1, mode="mirror")
    ratio = mean / shared * float(chances.f_ppf(0.5, freedom, behind))
    lowest = max(_RESOLVED / length, _CYCLES / stretch)
    # near half the rate a stretch has one phase only
    highest = 0.5 - max(_NYQUIST / length, 1.0 / stretch)
    ratio[(at < lowest) | (at > highest)] = 0.0
    best = int(np.argmax(ratio))
    return float(chances.f_sf(ratio[best], freedom, behind)), float(ratio[best]), float(at[best])


def _soft(ratio: FloatArray) -> FloatArray:
    """Beyond what noise ever reaches a line counts by its logarithm: one piece is not all."""
    beyond = np.maximum(ratio / _SURE, 1.0)
    return np.asarray(np.minimum(ratio, _SURE) * (1.0 + np.log(beyond)))


def pieces_of(traces: Traces, rate_hz: float) -> list[IntArray]:
    """Rows of each piece of each channel, in the order of recording."""
    found = []
    for channel in range(len(traces.names)):
        mine = np.flatnonzero(traces.channel == channel)
        _, piece = _slots(traces.time_s[mine], rate_hz, ROW_SLOTS)
        found += np.split(mine, np.flatnonzero(np.diff(piece)) + 1)
    return [rows for rows in found if rows.size]


def _slots(time_s: FloatArray, rate_hz: float, most: int) -> tuple[IntArray, IntArray]:
    """Slot on the grid of the rate and number of the piece of each row, shape (n,) each.

    A piece ends at a long gap, where the clock starts anew, and where it becomes too long.
    """
    step = np.diff(time_s, prepend=time_s[:1]) * rate_hz
    run = np.cumsum((step > _LONGEST_GAP * most) | (step < 0))
    slot = np.zeros(time_s.size, dtype=np.int64)
    piece = np.zeros(time_s.size, dtype=np.int64)
    count = 0
    for number in np.unique(run):
        rows = np.flatnonzero(run == number)
        own = np.round((time_s[rows] - time_s[rows[0]]) * rate_hz).astype(np.int64)
        parts = int(own[-1]) // most + 1
        slot[rows] = own
        piece[rows] = count + own * parts // (int(own[-1]) + 1)
        count += parts
    return slot, piece


def _stretches(slot: IntArray, piece: IntArray) -> list[IntArray]:
    """Rows of each gap-free stretch."""
    broken = (np.diff(slot) != 1) | (np.diff(piece) != 0)
    return np.split(np.arange(slot.size), np.flatnonzero(broken) + 1)


def _usual_stretch(slot: IntArray, piece: IntArray) -> float:
    sizes = np.array([rows.size for rows in _stretches(slot, piece)])
    return float(np.median(np.repeat(sizes, sizes)))


def _whitened(values: FloatArray, slot: IntArray, piece: IntArray) -> tuple[FloatArray, IntArray]:
    """Innovations of an autoregression within gap-free stretches, and the rows that have one.

    The noise is then level whatever slots are empty.
    """
    stretches = [r for r in _stretches(slot, piece) if r.size > _ORDER]
    if not stretches:
        return values[:0], np.empty(0, dtype=np.int64)
    covariance = np.zeros(_ORDER + 1)
    for rows in stretches:
        for lag in range(_ORDER + 1):
            covariance[lag] += values[rows[lag:]] @ values[rows[: rows.size - lag]]
    coefficients = np.zeros(_ORDER)
    if covariance[0] > 0:
        covariance[0] *= 1.0 + 1e-6
        coefficients = solve_toeplitz(covariance[:-1], covariance[1:])
    past = np.concatenate([rows[_ORDER:] for rows in stretches])
    white = values[past].copy()
    for i, share in enumerate(coefficients):
        white -= share * values[past - i - 1]
    return white, past


def _without_bursts(values: FloatArray) -> FloatArray:
    spread = median_sd(values) if values.size else 0.0
    return np.clip(values, -_BURST * spread, _BURST * spread) if spread > 0 else values * 0.0


@dataclass(frozen=True)
class _Spectrum:
    """Periodogram of a piece and its running median, at frequencies `at` in cycles per slot.

    `width` independent values are in a median; the piece has so many `slots`.
    """

    at: FloatArray
    power: FloatArray
    level: FloatArray
    width: float
    slots: int


def _spectra(values: FloatArray, slot: IntArray, piece: IntArray) -> Iterator[_Spectrum]:
    """Of every piece that is long enough."""
    for number in np.unique(piece):
        rows = np.flatnonzero(piece == number)
        if rows.size < _SHORTEST or not np.any(values[rows]):
            continue
        own = slot[rows] - slot[rows[0]]
        length = int(own[-1]) + 1
        if rows.size < _FILLED * length:
            continue
        window = np.hanning(length + 2)[1:-1][own]
        grid = np.zeros(length)
        grid[own] = window * (values[rows] - window @ values[rows] / window.sum())
        size = 2 ** int(np.ceil(np.log2(2 * length)))
        power = np.abs(np.fft.rfft(grid, size)) ** 2
        width = min(round(_WIDTH * size / length), power.size // 2) | 1
        # a spectrum goes on as its own mirror image at both ends
        level = ndimage.median_filter(power, width, mode="mirror") / np.log(2.0)
        if np.all(level > 0):
            at = np.linspace(0.0, 0.5, power.size)
            yield _Spectrum(at, power, level, width * length / size, length)


def swing_series(
    time_s: FloatArray,
    forces: FloatArray,
    airborne: BoolArray,
    names: tuple[str, ...],
    rate_hz: float,
) -> Series:
    """What unfiltered channels show while their foot is in the air.

    Each swing less a straight line of its own and less what all swings have in common: the plate
    that hangs and shakes repeats with the gait, a hum does not.

    Parameters
    ----------
    time_s, forces
        Shape (n,) and (n, c).
    airborne
        Whether the foot of each channel surely swings, shape (n, c).
    names, rate_hz
        Of the channels; of the stamps.
    """
    values, rows_of, channel = [], [], []
    step = np.round(np.diff(time_s, prepend=time_s[:1]) * rate_hz)
    for c in range(len(names)):
        good = (airborne[:, c]) & np.isfinite(forces[:, c])
        rows = np.flatnonzero(good)
        broken = (np.diff(rows) != 1) | (step[rows[1:]] != 1)
        swings = np.split(rows, np.flatnonzero(broken) + 1)
        swings = [s for s in swings if s.size >= _SHORTEST_SWING and _busy(forces[s, c]) >= _BUSY]
        if not swings:
            continue
        levelled = np.concatenate([_levelled(forces[s, c]) for s in swings])
        share = np.concatenate([(np.arange(s.size) + 0.5) / s.size for s in swings])
        values.append(levelled - _common(levelled, share, max(_PARTS, len(swings))))
        rows_of.append(np.concatenate(swings))
        channel.append(np.full(share.size, c))
    if not values:
        return Series(np.empty(0), np.empty(0), np.empty(0, dtype=np.int64), (), rate_hz)
    at = np.concatenate(rows_of)
    return Series(
        np.concatenate(values), time_s[at], np.concatenate(channel), names, rate_hz, SWING_SLOTS
    )


_SHORTEST_SWING = 12
_PARTS = 8
"""Of a swing, each with its mean over all swings; as many as swings, where those are more."""


def _common(values: FloatArray, share: FloatArray, parts: int) -> FloatArray:
    """Mean over all swings at each `share` of a swing, joined by straight lines, shape (n,).

    Steps would leave saw-teeth, many samples long at 2 kHz, in time with the gait.
    """
    part = (share * parts).astype(np.int64)
    count = np.bincount(part, minlength=parts)
    used = count > 0
    at, mean = (np.bincount(part, v, parts)[used] / count[used] for v in (share, values))
    return np.interp(share, at, mean)


def _busy(values: FloatArray) -> float:
    return float(np.mean(np.diff(values) != 0))


def _levelled(values: FloatArray) -> FloatArray:
    """Less a straight line, of unit RMS: a few loud swings would leave the others unheard."""
    line = np.linspace(-1.0, 1.0, values.size)
    left = values - values.mean() - line * (line @ values) / (line @ line)
    return np.asarray(left / max(float(np.sqrt(np.mean(left**2))), 1e-300))
