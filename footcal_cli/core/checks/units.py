"""Known loads of which some were noted in another unit than the others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import UNIT_RATIOS, Finding, listed

SAME_RATIO = 0.04
OF_A_KIND = 0.15
"""Share by which the scales of cells of one make differ."""
SAME_WEIGHTS = 0.005
"""The same weights in two units are in the ratio of the units, but for the digits written."""
UNITS_MISTAKEN = (
    ("kg", "N"), ("lbf", "N"), ("g", "N"), ("kN", "N"), ("lbf", "kg"), ("g", "kg"), ("N", "kg"),
    ("kg", "lbf"), ("N", "lbf"), ("g", "lbf"), ("kg", "g"), ("lbf", "g"), ("N", "g"),
)  # fmt: skip
"""Unit in which some loads were noted, unit of the others; of pairs of one ratio the first is
named."""


@listed
def check_units_of_sessions(
    channel: str, load_n: FloatArray, counts: FloatArray, session: FloatArray
) -> Iterator[Finding]:
    """Find sessions whose loads were noted in another unit: a slope off by a known ratio.

    A unit is off by 9.8 or 2.2, never by a per mille: what is not near a ratio is no unit. Of two
    sessions the largest loads must be in that ratio too.

    Parameters
    ----------
    load_n, counts, session
        Of one channel, shape (n,) each.
    """
    slopes, largest = _by_part(load_n, counts, session)
    sure = len(slopes) > 2
    for number, ratio, unit, other in _odd(slopes, {} if sure else largest, SAME_RATIO):
        yield Finding(
            "another_unit", "alarm", channel,
            f"session {int(number) + 1} of {channel} reads {ratio:.3g} x as much per load as "
            f"the others: its loads look noted in {unit}, the others' in {other}",
            "correct the unit of that session's loads",
        )  # fmt: skip


@listed
def check_units_of_channels(
    channel: FloatArray, load_n: FloatArray, counts: FloatArray, names: Sequence[str]
) -> Iterator[Finding]:
    """Find cells whose loads were noted in another unit than those of the others.

    Cells of one make have nearly one scale; cells of two makes were loaded with other weights. So
    both must be off by the ratio of two units: the scale nearly, the largest load exactly.

    Parameters
    ----------
    channel, load_n, counts
        Shape (n,) each.
    names
        Of the channels, by their number in `channel`.
    """
    slopes, largest = _by_part(load_n, counts, channel)
    slopes = {number: abs(slope) for number, slope in slopes.items()}  # a bridge may be turned
    for number, ratio, unit, other in _odd(slopes, largest, OF_A_KIND):
        name = names[int(number)]
        yield Finding(
            "another_unit", "alarm", name,
            f"{name} reads {ratio:.3g} x as much per load as the others, under weights of "
            f"the same numbers but for a unit: its loads look noted in {unit}, the others' in "
            f"{other}",
            "correct the unit of that cell's loads",
        )  # fmt: skip


def _by_part(
    load_n: FloatArray, counts: FloatArray, part: FloatArray
) -> tuple[dict[float, float], dict[float, float]]:
    """Slope of the counts over the load, and the largest load, of each part of a log (n,)."""
    slopes, largest = {}, {}
    for number in np.unique(part).tolist():
        mine = (part == number) & np.isfinite(load_n) & np.isfinite(counts)
        if mine.sum() > 2 and np.ptp(load_n[mine]) > 0:
            slopes[number] = float(np.polyfit(load_n[mine], counts[mine], 1)[0])
            largest[number] = float(np.abs(load_n[mine]).max())
    return slopes, largest


def _odd(
    slopes: Mapping[float, float], largest: Mapping[float, float], tolerance: float
) -> Iterator[tuple[float, float, str, str]]:
    """Parts off the others by the ratio of two units: part, its ratio, its unit, theirs.

    Parameters
    ----------
    largest
        Largest loads, which must be off by the same; empty: the slopes are enough.
    tolerance
        Share by which a slope may be off the ratio.
    """
    newtons = {**UNIT_RATIOS, "N": 1.0}
    numbers = list(slopes)
    for number in numbers[1:] if len(numbers) == 2 else numbers:  # of two either may be the odd one
        others = numbers if len(numbers) > 2 else [n for n in numbers if n != number]
        typical = float(np.median([slopes[n] for n in others])) if others else 0.0
        ratio = slopes[number] / typical if typical else 1.0
        for unit, other in UNITS_MISTAKEN:
            factor = newtons[unit] / newtons[other]
            if abs(ratio / factor - 1.0) >= tolerance:
                continue
            if not largest or _same(largest, number, others, factor):
                yield number, ratio, unit, other
                break


def _same(
    largest: Mapping[float, float], number: float, others: list[float], factor: float
) -> bool:
    """Whether a part's largest load is that of the others, in another unit."""
    usual = float(np.median([largest[n] for n in others]))
    return abs(largest[number] * factor / usual - 1.0) < SAME_WEIGHTS if usual else False
