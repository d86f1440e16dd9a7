"""Raw channels that cannot be right by themselves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.quality import RAISED, Finding, listed
from footcal_cli.core.signals import stretches

OFFSET_BINARY_SHARE = 0.05
"""Readings this close to mid-scale, as a share of it, look offset-binary."""
LONGEST_GLITCH = 3
"""Samples in a row that a glitch may have; what lasts longer is a load."""
FAR = 2.0
"""A glitch lies outside the channel's usual range by this multiple of it."""
_LEFT_OUT, _MOST_LEFT_OUT = 10, 10.0
"""Samples at each end of a short log that its usual range does not run to, and how many percent."""
_FEWEST_LEVELS = 3
_FROZEN = 50
"""Samples of one value from which a channel may be frozen."""
_CODES = tuple(2.0**bits for bits in (16, 18, 20, 22, 24, 32))
SIGN_SPAN, _LEVEL_APART = 0.25, 0.1
"""Share of a converter's range in which codes lie that lost their sign, and of their own span
between two levels."""
_FEWEST_CODES, _BENT, _STRAIGHT = 2.0**8, 0.9, 0.999
"""Codes of the smallest converter; squared correlations with a load of readings that lost their
sign, and of the same with it."""
DEAD_SPAN = 0.02
"""Share of its siblings' span below which a channel stands still."""
LINEAR = 0.5
"""Squared correlation of counts with known loads below which a cell does not weigh them."""

STUCK = "check that the channel is connected, or take it out of `channels` in [robot]"
"""What to do about a reading that never changes."""


def find_glitches(reading: FloatArray, resolution: float = 0.0) -> BoolArray:
    """Single samples far outside the channel's range, shape (n,).

    The range runs from the 1st to the 99th percentile, of a short log from the tenth smallest to
    the tenth largest sample; a glitch lies `FAR` of it outside, which white noise reaches less than
    once in 10¹⁰ samples, and lasts no longer than `LONGEST_GLITCH`.

    Parameters
    ----------
    reading
        Shape (n,), NaN where a sample was lost.
    resolution
        Step of the converter: a range of less than two of them is not known to be that narrow.
    """
    found = np.zeros(reading.size, dtype=bool)
    good = reading[np.isfinite(reading)]
    if good.size < 50:
        return found
    edge = max(1.0, min(100.0 * _LEFT_OUT / good.size, _MOST_LEFT_OUT))
    low, high = np.percentile(good, [edge, 100.0 - edge])
    span = float(high - low)
    if not span > 0:
        span = float(np.median(np.abs(good))) * 1e-3 or 1.0
    span = max(span, 2.0 * resolution)
    with np.errstate(invalid="ignore"):
        far = (reading < low - FAR * span) | (reading > high + FAR * span)
    for start, stop in stretches(far):
        found[start:stop] = stop - start <= LONGEST_GLITCH
    return found


def find_end_codes(counts: FloatArray, bits: int) -> BoolArray:
    """Readings that are the first or last code of a converter, signed or offset-binary.

    What a converter clips to is the largest or smallest of its readings; others pass such a code
    by chance.

    Parameters
    ----------
    counts
        Shape (n,), NaN where a sample was lost.
    """
    half, full = 2.0 ** (bits - 1), 2.0**bits
    if not np.isfinite(counts).any():
        return np.zeros(counts.size, dtype=bool)
    low, high = np.nanmin(counts), np.nanmax(counts)
    at_end = (counts == high) & np.isin(counts, [half - 1, full - 1])
    at_end |= (counts == low) & ((low == -half) | ((low == 0) & (half < high < full)))
    return np.asarray(at_end)


def signed(values: NDArray[Any], at: float) -> NDArray[Any]:
    """Codes (n,) of a converter whose sign was lost: those beyond the middle are negative."""
    return np.where(values >= at / 2, values - values.dtype.type(at), values)


def lost_sign(counts: FloatArray) -> float:
    """2^bits of a converter whose negative codes are read as the largest ones; 0 of any other.

    Codes then lie at both ends of the range with nothing between, and close together once those
    beyond the middle count as negative. Three levels at least: of two, each may be an end.
    """
    seen = np.unique(counts[np.isfinite(counts)])
    if seen.size < _FEWEST_LEVELS or seen[0] < 0 or np.any(seen != np.round(seen)):
        return 0.0
    for at in _CODES:
        codes = np.sort(signed(seen, at))
        span = codes[-1] - codes[0]
        apart = seen[-1] < at and np.ptp(seen) > (1.0 - SIGN_SPAN) * at and span < SIGN_SPAN * at
        if apart and np.sum(np.diff(codes) > _LEVEL_APART * span) >= _FEWEST_LEVELS - 1:
            return at
    return 0.0


def straightness(load: FloatArray, counts: FloatArray) -> float:
    """Squared correlation of readings with a load, shape (n,) each; 0 where one never changes."""
    good = np.isfinite(load) & np.isfinite(counts)
    x, y = load[good], counts[good]
    if x.size < _FEWEST_LEVELS or not np.ptp(x) > 0 or not np.ptp(y) > 0:
        return 0.0
    return float(np.corrcoef(x, y)[0, 1]) ** 2


def lost_sign_by_load(counts: FloatArray, load: FloatArray) -> float:
    """2^bits of a converter whose codes are straight in a load once signed; 0 of any other.

    Of any number of bits, however far the codes lie apart: the load says which reading is true.
    Shape (n,) each.
    """
    seen = counts[np.isfinite(counts)]
    levels = np.unique(load[np.isfinite(load) & np.isfinite(counts)])
    if levels.size < _FEWEST_LEVELS or seen.min() < 0 or np.any(seen != np.round(seen)):
        return 0.0
    at = float(2.0 ** np.ceil(np.log2(seen.max() + 1.0)))
    both = at >= _FEWEST_CODES and np.any(seen < at / 2) and straightness(load, counts) < _BENT
    return at if both and straightness(load, signed(counts, at)) > _STRAIGHT else 0.0


@listed
def check_codes(channel: str, counts: FloatArray, bits: int) -> Iterator[Finding]:
    """Find saturated codes, a stuck channel and offset-binary readings of one channel."""
    half = 2.0 ** (bits - 1)
    at_end = find_end_codes(counts, bits)
    if at_end.any():
        yield Finding(
            "saturated_codes", "alarm", channel,
            f"{int(at_end.sum())} of {counts.size} readings are an end code of a {bits}-bit "
            f"converter ({counts[at_end][0]:,.0f})",
            "lower the gain or the load; check the wiring of the bridge",
        )  # fmt: skip
    if at := lost_sign(counts):
        yield Finding(
            "sign_lost", "alarm", channel,
            f"readings lie at both ends of 0 … {at:,.0f} with nothing between: negative codes were "
            "read without their sign",
            f'write {{ column = "…", wraps_at = {at:.0f} }} for it in [columns]',
        )  # fmt: skip
    if counts.size > 1 and np.ptp(counts) == 0:
        yield Finding(
            "stuck_channel", "alarm", channel,
            f"all {counts.size} readings are {counts[0]:,.0f}",
            "check that the channel is connected and that its reading is refreshed",
        )  # fmt: skip
    elif counts.size > 1 and np.all(np.abs(counts - half) < OFFSET_BINARY_SHARE * half):
        yield Finding(
            "offset_binary", "note", channel,
            f"readings lie around {half:,.0f} = 2{str(bits - 1).translate(RAISED)}: "
            "offset-binary, zero is mid-scale",
            "nothing to do: the bias absorbs it",
        )  # fmt: skip


def find_frozen(reading: FloatArray) -> BoolArray:
    """Samples of runs of one value that last 50 samples and far longer than usual runs."""
    edges = np.concatenate([[0], np.flatnonzero(np.diff(reading) != 0) + 1, [reading.size]])
    lengths = np.diff(edges)
    usual = float(np.percentile(lengths, 90))
    frozen = lengths >= max(_FROZEN, 10.0 * usual)
    if reading.size > 1:
        frozen |= lengths == reading.size
    return np.repeat(frozen, lengths)


def resolution_of(readings: FloatArray) -> float:
    """The coarsest of the smallest steps that siblings in one unit take, shape (n, c).

    A channel that takes two values only does not show whether they are one step apart.
    """
    values = [np.unique(column[np.isfinite(column)]) for column in readings.T]
    steps = [float(np.diff(v).min()) for v in values if v.size > _FEWEST_LEVELS]
    return max(steps, default=0.0)


def check_glitches(
    reading: FloatArray, time_s: FloatArray, where: str, resolution: float = 0.0
) -> list[Finding]:
    """Say where single samples are far off."""
    at = np.flatnonzero(find_glitches(reading, resolution))
    if not at.size:
        return []
    worst = at[np.argmax(np.abs(reading[at] - np.nanmedian(reading)))]
    low, high = np.nanpercentile(reading, [1, 99])
    return [
        Finding(
            "outliers", "warning", where,
            f"{at.size} single samples lie far outside the usual {low:,.6g} … {high:,.6g}, the "
            f"furthest {reading[worst]:,.6g} at {time_s[worst]:.6g} s",
            "check the link and the logger; say in [robot.adc] lost_reading what a lost sample "
            "looks like",
        )
    ]  # fmt: skip


def _by_rank(load: FloatArray, count: FloatArray) -> float:
    """Spearman's correlation, which a few glitches do not move far."""
    from scipy import stats

    return float(stats.spearmanr(load, count)[0])


def check_known_loads(load_n: FloatArray, counts: FloatArray, channel: str) -> list[Finding]:
    """Find a cell whose counts do not follow its known loads.

    Parameters
    ----------
    load_n, counts
        Shape (n,).
    """
    good = np.isfinite(load_n) & np.isfinite(counts)
    load, count = load_n[good], counts[good]
    if load.size < 4 or np.unique(load).size < 3 or not np.ptp(count) > 0:
        return []
    with np.errstate(over="ignore", invalid="ignore"):
        r = float(np.corrcoef(load, count)[0, 1])
    if r**2 > LINEAR or _by_rank(load, count) ** 2 > LINEAR:
        return []
    return [
        Finding(
            "dead_cell", "alarm", channel,
            f"the counts do not follow the loads (correlation {r:.2f} over {load.size} rows)",
            "check that the cell carries the weight, and that no rows or channels are mixed up; "
            "a dead one: take it out of `channels` in [robot]",
        )
    ]  # fmt: skip
