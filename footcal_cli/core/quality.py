"""What is wrong with raw data, as findings: nothing here changes a number."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import wraps
from itertools import combinations
from typing import Literal, ParamSpec

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import gaps_of

Severity = Literal["alarm", "warning", "note"]
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
"""Turns an exponent into raised digits."""
_PLAIN_CHANCE, _LEAST_CHANCE = 1e-3, 1e-300
"""From where on a chance is written out, and what a smaller one than a float holds counts as."""

INDEPENDENT_SPREAD = 1e-3
"""Cells that are at all independent differ by more than this share of their loading span."""
REPEAT_ALPHA = 1e-3
"""Chance below which repeated readings across channels are called unlikely."""
IMPLAUSIBLE_RATIO = 100.0
"""Loads this many times outside the intended range are a unit that cannot be right."""


@dataclass(frozen=True)
class Finding:
    """Something about the data that the user should know.

    Parameters
    ----------
    code
        Stable machine-readable name (``readings_repeat_across_channels``).
    severity
        ``alarm``: results would be meaningless; ``warning``: results suffer; ``note``.
    sentence, remedy
        What was seen, with numbers, and what to do.
    """

    code: str
    severity: Severity
    where: str
    sentence: str
    remedy: str


def some_of(names: Sequence[str], most: int) -> str:
    """``a, b and 3 more``."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(names[:most])}{more}"


Params = ParamSpec("Params")


def listed(check: Callable[Params, Iterator[Finding]]) -> Callable[Params, list[Finding]]:
    """A check that yields its findings, called for all of them."""

    @wraps(check)
    def called(*args: Params.args, **words: Params.kwargs) -> list[Finding]:
        return list(check(*args, **words))

    return called


CAUSES = frozenset({
    "axes_exchanged", "axis_turned", "cell_gain", "hole_elsewhere", "leg_elsewhere", "mass_differs",
    "transducer_turned", "weight_otherwise",
})  # fmt: skip
"""Findings that name what is wrong before any effect is looked for."""
STOPPING = frozenset({"readings_repeat_across_channels", "intermittent_contact"})
"""Findings that make blocks no independent evidence, or are the answer themselves; alarms stop a
diagnosis too."""


def stopping(findings: Sequence[Finding]) -> list[Finding]:
    """The findings with which a diagnosis would be meaningless."""
    return [f for f in findings if f.severity == "alarm" or f.code in STOPPING]


def check_repeats_across_channels(
    counts: Mapping[str, FloatArray], loads: Mapping[str, FloatArray]
) -> list[Finding]:
    """Find readings that independent channels would not share.

    Under independence two channels at the same load differ by at least `INDEPENDENT_SPREAD` of
    their span (sd σ), so a pair coincides exactly with probability 1/(2σ√π) and the number of
    coincidences is about Poisson.

    Parameters
    ----------
    counts, loads
        Raw readings and loads per channel, each shape (n_channel,).
    """
    at_load = _distinct_readings(counts, loads)
    span = float(np.median([np.ptp(values) for values in counts.values()])) if counts else 0.0
    if len(counts) < 2 or span < 1.0:
        return []
    spread = max(INDEPENDENT_SPREAD * span, 1.0)
    exact = expected = 0.0
    examples: list[tuple[int, str]] = []
    close: list[tuple[float, int, float]] = []
    for load, readings in at_load.items():
        pairs = list(combinations(readings.values(), 2))
        expected += len(pairs) / (2.0 * spread * np.sqrt(np.pi))
        exact += sum(a == b for a, b in pairs)
        values = np.array(list(readings.values()))
        for value in np.unique(values):
            times = int(np.sum(values == value))
            if times > 1:
                examples.append((times, f"{value:,.0f} in {times} channels at {load:.4g} N"))
        group, width = _tightest_majority(values)
        close.append((load, group, width))
    if not exact:
        return []
    from scipy.special import pdtrc

    chance = float(pdtrc(exact - 1, expected))
    if chance > REPEAT_ALPHA:
        return []
    shown = "; ".join(text for _, text in sorted(examples, key=lambda e: -e[0])[:3])
    tight = [(load, n, w) for load, n, w in close if n > 2 and w < INDEPENDENT_SPREAD * span]
    also = "".join(
        f"; at {load:.4g} N {n} of {len(counts)} channels lie within {w:.0f} counts"
        for load, n, w in tight
    )
    return [
        Finding(
            "readings_repeat_across_channels",
            "warning",
            "all channels",
            f"{exact:.0f} pairs of channels show exactly the same raw reading at the same load "
            f"(independent cells: {expected:.1f} expected, chance {_as_power(chance)}): "
            f"{shown}{also} (span {span:,.0f} counts)",
            "check whether cells share an amplifier or rows were copied; record each cell alone",
        )
    ]


def _as_power(chance: float) -> str:
    """The next power of ten above a small chance: ``< 10⁻¹⁷``; larger ones as they are."""
    if chance >= _PLAIN_CHANCE:
        return f"{chance:.1g}"
    power = int(np.ceil(np.log10(max(chance, _LEAST_CHANCE))))
    return f"< 10{str(power).translate(RAISED)}"


def _distinct_readings(
    counts: Mapping[str, FloatArray], loads: Mapping[str, FloatArray]
) -> dict[float, dict[str, float]]:
    """Load -> channel -> its median reading there, for loads that two channels share."""
    table: dict[float, dict[str, float]] = {}
    for channel, values in counts.items():
        for load in np.unique(loads[channel]):
            table.setdefault(float(load), {})[channel] = float(
                np.median(values[loads[channel] == load])
            )
    return {load: readings for load, readings in table.items() if len(readings) > 1}


def _tightest_majority(values: FloatArray) -> tuple[int, float]:
    """Number and width of the tightest group of more than two thirds of the values."""
    ordered = np.sort(values)
    best: tuple[int, float] = (0, np.inf)
    for size in range(len(ordered), (2 * len(ordered)) // 3, -1):
        widths = ordered[size - 1 :] - ordered[: len(ordered) - size + 1]
        width = float(widths.min())
        if width < 0.25 * best[1]:
            best = (size, width)
    return best


def check_load_unit(
    loads_n: FloatArray, intended_n: tuple[float, float] | None, weight_n: float | None
) -> list[Finding]:
    """Find loads whose unit cannot be right, against the intended range or the body weight."""
    largest = float(np.max(np.abs(loads_n)))
    reference = intended_n[1] if intended_n is not None else weight_n
    if reference is None or largest == 0:
        return []
    ratio = largest / reference
    if 1.0 / (IMPLAUSIBLE_RATIO * 10) < ratio < IMPLAUSIBLE_RATIO:
        return []
    return [
        Finding(
            "implausible_unit", "alarm", "load",
            f"the largest load is {largest:.4g} N, {ratio:.2g} x the {reference:.4g} N expected",
            "check the unit of the load column (kg, g or N?) in [columns]",
        )
    ]  # fmt: skip


UNIT_RATIOS = {"kg": 9.80665, "lbf": 4.4482216, "g": 9.80665e-3, "kN": 1e3}
"""Newtons in one of the unit that a load may have been noted in."""


@listed
def check_duplicate_channels(readings: FloatArray, channels: Sequence[str]) -> Iterator[Finding]:
    """Find channels of a stream that show the same readings throughout.

    Parameters
    ----------
    readings
        Shape (n, c); NaN where a sample was lost.
    """
    for i, j in combinations(range(len(channels)), 2):
        both = np.isfinite(readings[:, i]) & np.isfinite(readings[:, j])
        a, b = readings[:, i], readings[:, j]
        if not both.all():
            a, b = a[both], b[both]
        if a.size > 10 and np.ptp(a) > 0 and np.mean(a == b) > 0.95:
            yield Finding(
                "duplicate_channel", "alarm", f"{channels[i]}, {channels[j]}",
                f"{np.mean(a == b):.0%} of the readings of the two channels are identical",
                "check the channel map of the logger; one of the cells is not recorded",
            )  # fmt: skip


STUCK_SECONDS = 1.0
"""A channel that shows one value for longer while others move is stuck."""
FEW_STEPS = 50
"""Siblings that take fewer different values are of a coarse converter, of which a channel that is
loaded a little may rest between two."""


LATE_SHARE = 0.01
"""More samples than this that come after a later one are no stragglers of a link."""


def check_order(time_s: FloatArray, stream: str) -> list[Finding]:
    """Find stamps that go back: rows out of order, or recordings that were joined.

    Parameters
    ----------
    time_s
        Stamps in order of the file, shape (n,).
    """
    time_s = time_s[np.isfinite(time_s)]
    back = np.flatnonzero(np.diff(time_s) < 0)
    if not back.size:
        return []
    at, late = int(back[0]), int(np.sum(time_s < np.maximum.accumulate(time_s)))
    return [
        Finding(
            "time_goes_back", "alarm" if late > LATE_SHARE * time_s.size else "warning", stream,
            f"{back.size} stamps lie before their predecessor, the first at row {at + 2} "
            f"({time_s[at]:.6g} s, then {time_s[at + 1]:.6g} s); {late} of {time_s.size} samples "
            "come too late to be used",
            "sort the log by time, or split recordings that were joined",
        )
    ]  # fmt: skip


@listed
def check_clock(time_s: FloatArray, stream: str) -> Iterator[Finding]:
    """Find stamps that go back or repeat, gaps, and an uneven rate.

    Parameters
    ----------
    time_s
        Stamps in order of the file, shape (n,).
    """
    if time_s.size < 3:
        return
    steps = np.diff(time_s)
    yield from check_order(time_s, stream)
    if np.any(steps == 0):
        yield Finding(
            "duplicate_stamps", "warning", stream,
            f"{int(np.sum(steps == 0))} of {time_s.size} stamps repeat",
            "stamp at the sensor, not at the receiver; repeated stamps are used once",
        )  # fmt: skip
    rising = time_s[np.concatenate([[True], time_s[1:] > np.maximum.accumulate(time_s)[:-1]])]
    gaps = gaps_of(rising)
    if gaps.size:
        widths = np.diff(rising)
        longest = int(gaps[np.argmax(widths[gaps])])
        yield Finding(
            "gaps", "warning", stream,
            f"{gaps.size} gap{'s' if gaps.size > 1 else ''}, the longest "
            f"{widths[longest]:.3g} s at {rising[longest]:.6g} s "
            f"(usual interval {np.median(widths):.3g} s)",
            "check the link or the logger's load; nothing is interpolated across a gap",
        )  # fmt: skip


@listed
def check_stream(
    time_s: FloatArray | None, readings: FloatArray, channels: Sequence[str]
) -> Iterator[Finding]:
    """Find lost samples, stuck and duplicated channels of a stream.

    Parameters
    ----------
    time_s
        Shape (n,); None of rows that are no stream in time.
    readings
        Shape (n, c); NaN where a sample was lost.
    """
    yield from check_duplicate_channels(readings, channels)
    step_s = STUCK_SECONDS
    if time_s is not None:
        step_s = float(np.median(np.diff(time_s))) if time_s.size > 2 else np.nan
    longest = np.array([_longest_run(readings[:, i]) for i in range(len(channels))])
    for name, column, run in zip(channels, readings.T, longest, strict=True):
        lost = int(np.sum(~np.isfinite(column)))
        if lost:
            much: Severity = "alarm" if lost == column.size else "warning"
            yield Finding(
                "lost_samples", much if lost > 0.01 * column.size else "note", name,
                f"{lost} of {column.size} samples are missing",
                "check the connection of the channel; lost samples are left out",
            )  # fmt: skip
        others = float(np.median(longest)) if longest.size > 1 else 0.0
        stuck = run * step_s > STUCK_SECONDS and run > 10 * max(others, 1.0)
        if stuck and not _rests_between_steps(readings, name, channels):
            lasts = f"{run} rows" if time_s is None else f"{run * step_s:.3g} s ({run} samples)"
            yield Finding(
                "stuck_channel", "alarm", name, f"one value for {lasts} while others move",
                "check that the channel is connected and that its reading is refreshed",
            )  # fmt: skip


def _rests_between_steps(readings: FloatArray, name: str, channels: Sequence[str]) -> bool:
    """Whether a channel of a coarse converter takes two values at most."""
    own = list(channels).index(name)
    values = [np.unique(column[np.isfinite(column)]).size for column in readings.T]
    # few rows have few values: of a coarse converter they come again
    few = min(FEW_STEPS, len(readings) / 2)
    return values[own] <= 2 and float(np.median(np.delete(values, own))) < few


def check_frozen(time_s: FloatArray, readings: FloatArray, stream: str) -> list[Finding]:
    """Find a stream that repeats whole rows for long while its stamps go on.

    Parameters
    ----------
    time_s, readings
        Shapes (n,) and (n, c).
    """
    if len(readings) < 3:
        return []
    same = np.ones(len(readings), dtype=bool)
    same[0] = False
    for column in readings.T:  # the differences of all channels of a long log are as large as it is
        same[1:] &= np.diff(column) == 0
    edges = np.flatnonzero(~same)
    lengths = np.diff(np.r_[edges, len(readings)])
    longest = int(np.argmax(lengths))
    first, run = int(edges[longest]), int(lengths[longest])
    lasts = float(time_s[first + run - 1] - time_s[first])
    if len(lengths) < 20 or lasts < STUCK_SECONDS or run < 10.0 * np.percentile(lengths, 90):
        return []
    return [
        Finding(
            "stream_frozen", "warning", stream,
            f"all channels repeat one row for {lasts:.3g} s ({run} samples) from "
            f"{time_s[first]:.6g} s",
            "check the driver or the logger: it repeats its last sample; leave that time out",
        )
    ]  # fmt: skip


def _longest_run(values: FloatArray) -> int:
    """Length of the longest run of equal values."""
    same = np.concatenate([[False], np.diff(values) == 0, [False]])
    edges = np.flatnonzero(same[1:] != same[:-1])  # where runs of equal values begin and end
    return min(values.size, 1 + int(np.max(np.diff(edges)[::2], initial=0)))
