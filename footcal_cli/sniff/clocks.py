"""Columns of time: counters and dates, their unit, and which of several clocks counts."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, seconds_of
from footcal_cli.sniff.units import LOADS
from footcal_cli.tables.canonical import NOT_SAID, unwrapped
from footcal_cli.tables.units import TIMES

_EPOCHS = {"s": 1e9, "ms": 1e12, "us": 1e15, "ns": 1e18}
_SECONDS = re.compile(r"(?:^|[._ ])(?:sec|secs|seconds)$", re.IGNORECASE)
_NANOSECONDS = re.compile(r"(?:^|[._ ])(?:nano|n)(?:sec|secs|seconds)$", re.IGNORECASE)
_MOST_HZ = 20_000.0
_RUN_ROWS = 20
"""Stamps of a long table go on for so many rows before they begin again."""
_TYPED_ROWS, _HELD_S = 100, 5.0
"""Fewer rows than this, further apart than this, are readings noted one by one."""
_ROWS_OF_A_STREAM, _OFTEN = 60, 0.5
"""Fewer rows are no running recording; nor is what has another load in more of its rows."""
_FEW_LOADS = 20
_RISING = 0.9
"""Share of the steps of stamps that go up."""
TICKS, _TICKING = 12, 0.7
"""Rows in which no reading only ever increases, and how many of these steps are not none."""
_CLOCK_STEPS = 8
"""So many steps of nearly one size nobody typed."""


def unwrapped_counter(column: ColumnGuess) -> ColumnGuess:
    """A counter of 16, 24 or 32 bits that began again from zero, as if it had gone on."""
    values = column.values
    if values is None or not _whole(column) or increases(values, strictly=False):
        return column
    for bits in (16, 24, 32):
        onward = unwrapped(values, 2.0**bits)
        drops = np.sum(np.diff(values) < 0)
        # it goes on through the zero with the same steps as before
        if values.max() < 2**bits and values.max() > 0.98 * 2**bits and (
            increases(onward) and even(onward) and drops < values.size / 8
        ):  # fmt: skip
            made = column.as_quantity("time", "likely", f"a counter of {bits} bits, unwrapped")
            return replace(made, values=onward, wraps_at=2.0**bits)
    return column


def seconds_apart(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Stamps in two columns: whole seconds, then nanoseconds, as ROS 2 writes them."""
    for whole, rest in pairwise(columns):
        if whole.values is None or rest.values is None or not _whole(whole) or not _whole(rest):
            continue
        named = bool(_SECONDS.search(whole.column) and _NANOSECONDS.search(rest.column))
        since_1970 = 1e9 < whole.values[0] < 5e9 and _rises_within(whole.values, rest.values)
        inside = rest.values.min() >= 0 and 1e6 < rest.values.max() < 1e9
        if not (inside and (named or since_1970)):
            continue
        time = whole.as_quantity("time", "sure" if named else "likely", "seconds and nanoseconds")
        time = replace(
            time, unit=None, values=whole.values + 1e-9 * rest.values, nanoseconds=rest.column
        )
        other = rest.as_quantity("other", "likely", f"nanoseconds of {whole.column}")
        return [{id(whole): time, id(rest): other}.get(id(c), c) for c in columns]
    return columns


def _rises_within(whole: FloatArray, rest: FloatArray) -> bool:
    """Whether numbers never fall, and others rise while they stay, as parts of a second do."""
    steps = np.diff(whole)
    inside = np.diff(rest)[steps == 0]
    return bool(np.all(steps >= 0) and np.all(inside >= 0) and np.any(inside > 0))


def _whole(column: ColumnGuess) -> bool:
    return column.values is not None and bool(np.all(column.values == np.round(column.values)))


def first_in_time(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """A first column that increases evenly is time where no other is, whatever it is called.

    Loads and labels, which may have been carried down from lines between, do not count; what alone
    could be read beside a load is no time.
    """
    first = next((c for c in columns if c.quantity not in ("load", "label")), columns[0])
    values = first.values
    read = [c for c in columns if c.quantity in ("reading", "unknown", "force") and c is not first]
    if (
        any(column.quantity == "time" for column in columns)
        or (not read and any(column.quantity == "load" for column in columns))
        or first.quantity not in ("reading", "unknown", "hole")
        or values is None
        or not (increases(values) and even(values))
        or (any(c.quantity == "load" for c in columns) and any(_evenly(c) for c in read))
    ):
        return columns
    taken = first.as_quantity("time", "guess", "the first column, increases evenly")
    return [taken if column is first else column for column in columns]


def _evenly(column: ColumnGuess) -> bool:
    return column.values is not None and increases(column.values) and even(column.values)


_COMPONENT = re.compile(r"[\W_]*(?:[0-3]|[xyz])[\W_]*$", re.IGNORECASE)


def _of_vectors(columns: Sequence[ColumnGuess]) -> set[str]:
    """Columns called by a number or an axis behind what two others are called too: ``p[0]``."""
    named = [c.column for c in columns if c.values is not None and c.column[:7] != "column_"]
    stems = {name: _COMPONENT.sub("", name) for name in named}
    counted = Counter(stems.values())
    return {name for name, stem in stems.items() if stem and stem != name and counted[stem] > 2}


def one_clock(columns: list[ColumnGuess], by_name: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Columns of which several increase evenly beside a load that does are its readings, no clocks.

    Nor is a component of a vector, as the way that somebody walks.

    Parameters
    ----------
    by_name
        The same columns as their names say.
    """
    made = [
        c.column for c, named in zip(columns, by_name, strict=True)
        if c.quantity == "time" and named.quantity not in ("time", "sequence")
        and c.unit not in TIMES
    ]  # fmt: skip
    walked = _of_vectors(columns) & {*made}
    columns = [
        named if c.column in walked else c for c, named in zip(columns, by_name, strict=True)
    ]
    loads = [c for c in columns if c.quantity == "load" or c.unit in LOADS]
    if len(made) < 2 or not any(_grows(c.values) for c in loads if c.values is not None):
        return columns
    return [named if c.column in made else c for c, named in zip(columns, by_name, strict=True)]


def _grows(values: FloatArray) -> bool:
    """Whether nearly all changes of a load go up."""
    steps = np.diff(values[np.isfinite(values)])
    moved = steps[steps != 0.0]
    return moved.size > 1 and bool(np.mean(moved > 0.0) > _RISING)


def without_orders(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Whole numbers that count up and begin again number rows where a load has a unit."""
    if not any(c.quantity == "load" or c.unit in LOADS for c in columns):
        return columns
    return [
        c.as_quantity("sequence", "likely", "counts rows, again and again")
        if c.quantity == "unknown" and c.unit is None and _counts_again(c.values)
        else c
        for c in columns
    ]


def _counts_again(values: FloatArray | None) -> bool:
    """Whether numbers go up by one or back to the first, several times."""
    if values is None or values.size < _CLOCK_STEPS or values[0] not in (0.0, 1.0):
        return False
    up, back = np.diff(values) == 1, values[1:] == values[0]
    return bool(np.all(up | back) and np.sum(back & ~up) > 1 and values.max() > values[0] + 1)


def one_time(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """The best column of time stamps alone is time, with its unit."""
    times = [c for c in columns if c.quantity == "time"]
    if not times:
        return columns
    with_dates = [c for c in times if c.values is None]
    stamped = [c for c in times if c.nanoseconds] + [
        c for c in times if "stamp" in c.column.lower() and "header" in c.column.lower()
    ]
    named = [c for c in times if c.unit is not None]
    best = (stamped or named or with_dates or times)[0]
    if with_dates and best.values is not None and np.ptp(best.values) == 0:
        best = with_dates[0]
    made = []
    for column in columns:
        if column.quantity != "time":
            made.append(column)
        elif column is not best:
            made.append(column.as_quantity("other", "likely", "another clock"))
        else:
            made.append(_with_time_unit(column))
    return made


def _with_time_unit(column: ColumnGuess) -> ColumnGuess:
    values = column.values
    if values is None or column.nanoseconds or column.unit in ("s", "ms", "us", "ns", "min", "h"):
        return replace(column, sure="sure") if column.unit else column
    values = values[np.isfinite(values)]
    first, steps = abs(float(values[0])), np.diff(values)
    step = usual_step(steps)
    words = column.column.lower()
    for word, unit in (("milli", "ms"), ("micro", "us"), ("nano", "ns"), ("msec", "ms")):
        if word in words:
            return replace(column, unit=unit, sure="sure")
    for unit, size in reversed(_EPOCHS.items()):
        if 0.5 * size < first < 5 * size:
            return replace(column, unit=unit, sure="sure", why=f"{unit} since 1970")
    if step == 0.0 or np.any(values != np.round(values)):
        rate = 1 / step if step else 0.0
        why = f"steps of {step:.4g}: {rate:.4g} Hz if in s"
        return replace(
            column, unit="s", sure="likely" if 0.2 < rate < _MOST_HZ else "guess", why=why
        )
    if values.size < _TYPED_ROWS and _HELD_S <= step < 1e4 and not _jitters(values):
        why = f"whole steps of {step:g} in {values.size} rows: typed by hand, in s"
        return replace(column, unit="s", sure="guess", why=why)
    unit = "s" if step <= 1 and float(values[-1]) < 1e5 and step == 1 else (
        "ms" if step <= 2000 else "us" if step <= 2e6 else "ns"
    )  # fmt: skip
    return replace(
        column, unit=unit, sure="guess", why=f"whole steps of {step:g}: taken for {unit}"
    )


def _jitters(values: FloatArray) -> bool:
    """Whether steps of whole numbers (n,) differ a little from row to row, as a clock's do."""
    steps = np.diff(values)
    return bool(steps.size >= _CLOCK_STEPS and np.unique(steps).size > 1 and even(values))


def recorded(file: FileGuess, load: ColumnGuess) -> bool:
    """Whether a log with stamps is a running recording, and no table of weights noted one by one.

    Noted is what has another load in most of its rows, and seconds between them.
    """
    stamped = file.of("time")
    if not stamped or file.rows < _ROWS_OF_A_STREAM:
        return False
    at = seconds_of(stamped[0])
    if at is None or load.values is None or at.size != load.values.size:
        return True
    return not _noted(load) or float(np.median(np.abs(np.diff(at)))) < _HELD_S


def _noted(load: ColumnGuess) -> bool:
    """Whether most rows have another load than the one before: nobody records that."""
    if load.values is None or load.values.size < 2:
        return False
    return float(np.mean(np.diff(load.values) != 0)) > _OFTEN


def noted_in_seconds(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Whole steps of a clock without a unit are seconds where a few weights change row by row."""
    weights = [c for c in columns if c.quantity == "load" and c.values is not None and _noted(c)]
    few = [c for c in weights if c.values is not None and np.unique(c.values).size <= _FEW_LOADS]
    why = "whole steps from weight to weight: typed by hand, in s"
    return [
        replace(c, unit="s", why=why)
        if few and c.quantity == "time" and c.sure == "guess" and c.unit in ("ms", "us") else c
        for c in columns
    ]  # fmt: skip


def increases(values: FloatArray, strictly: bool = True) -> bool:
    """Whether numbers (n,) rise from row to row; not `strictly`: or stay."""
    good = values[np.isfinite(values)]
    steps = np.diff(good)
    return bool(good.size > 2 and (np.all(steps > 0) if strictly else np.all(steps >= 0)))


def nearly_increases(values: FloatArray) -> bool:
    """Whether numbers (n,) rise from least to greatest but for few rows, as stamps out of order."""
    good = values[np.isfinite(values)]
    if good.size < _RUN_ROWS or good[0] != good.min() or good[-1] != good.max():
        return False
    steps = np.diff(good)
    return bool(np.any(steps < 0) and np.mean(steps > 0) >= _RISING)


def since_1970(values: FloatArray) -> str:
    """The unit of numbers (n,) that count from 1970 in this century; empty for others.

    Whole ones, or seconds with fractions, which no converter's readings have.
    """
    good = values[np.isfinite(values)]
    if good.size < 3 or not increases(good, strictly=False):
        return ""
    if np.any(good != np.round(good)):
        return "s" if good[0] > 1e9 and good[-1] < 2.2e9 else ""
    return next((u for u, size in _EPOCHS.items() if 0.5 * size < good[0] < 5 * size), "")


def restarts(values: FloatArray) -> bool:
    """Stamps that begin again now and then: with each leg or orientation of a long table."""
    steps = np.diff(values[np.isfinite(values)])
    return bool(steps.size > 2 and np.mean(steps < 0) < 1.0 / _RUN_ROWS and np.median(steps) > 0)


def one_after_another(group: Sequence[FileGuess]) -> bool:
    """Whether one clock goes on from log to log: one sensor's, not those of several at once."""
    stamps = [time.values for file in group for time in file.of("time")[:1]]
    spans = sorted((np.nanmin(v), np.nanmax(v)) for v in stamps if v is not None and v.size)
    apart = all(one[1] < other[0] for one, other in pairwise(spans))
    return len(spans) == len(group) > 1 and apart


_HALF = 0.5


def ticks(values: FloatArray) -> bool:
    """Whether a first column without a name is a counter of ticks, some of them seen twice."""
    if values.size < TICKS or not np.isfinite(values).all():
        return False
    steps = np.diff(values)
    whole = bool(np.all(values == np.round(values)) and steps.min() >= 0)
    return whole and float(np.mean(steps > 0)) > _TICKING


def even(values: FloatArray) -> bool:
    """Whether most steps of numbers (n,) are of one size, and most of these numbers are there."""
    good = np.isfinite(values)
    steps = np.diff(values[good])
    if np.mean(good) <= _HALF:
        return False
    return bool(np.quantile(np.abs(steps - np.median(steps)), 0.8) <= 0.3 * np.median(steps))


def usual_step(steps: FloatArray) -> float:
    """Mean of the steps near the median one, 0 without any: stamps in whole ms round each one."""
    later = steps[steps > 0]
    if not later.size:
        return 0.0
    middle = float(np.median(later))
    return float(np.mean(later[np.abs(later - middle) < 0.5 * middle]))


def rate_of(columns: list[ColumnGuess]) -> float | None:
    """Rows per second by the stamps, None without any."""
    for column in columns:
        if column.unit == NOT_SAID:
            continue
        if column.quantity == "time" and (at := seconds_of(column)) is not None:
            step = usual_step(np.diff(at)) * column.name.factor
            return 1.0 / step if step else None
    return None
