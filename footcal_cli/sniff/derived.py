"""What was worked out of other columns: statistics, quotients and multiples are no readings.

Room: sniff; asked by columns and loads.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.sniff.names import STATISTICS, words_of
from footcal_cli.sniff.units import LENGTHS, split_unit
from footcal_cli.sniff.vocabulary import SCATTER

_CENTRES = ("mean", "avg", "average", "median", "50%")
_SUMMARIES = {*STATISTICS, "count", "n", "25%", "50%", "75%", "q1", "q2", "q3", "range"}
SCATTERS = {"std", "sd", "dev", "var", "variance", "rms", "sem", *SCATTER}
_LEAST_SUMMARIES = 2
_EXTREMES = re.compile(r"[\W_]*(?:min|max|minimum|maximum)[\W_]*", re.IGNORECASE)
_CENTRE = re.compile(r"[\W_]*(?:mean|avg|average|median)[\W_]*", re.IGNORECASE)
_AGAIN = re.compile(r"\.\d+$")
"""Behind a name that stands there a second time."""
_DIFFERENT, _LEAST, _MEASURED = 4, 3, 10
_TARED = 1e-4
"""How much of its range a reading less a constant moves by, as both are rounded."""
_PRINTED = 1e-5
"""How exactly a multiple agrees, of the largest number: as far as both were printed."""

IS_SCATTER = "the scatter of what was read"
"""Why a column is no reading that says how far the readings of a mean lay apart."""


def without_derived(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """A table's columns, those worked out of others, and positions, as no reading."""
    columns = _without_scatter(_whole_quaternions(columns))
    return _without_tared(_without_extremes(_without_multiples(_without_places(columns))))


def _without_scatter(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Scatter beside the mean of one quantity: ``StdCounts`` next to ``MeanCounts``.

    ``std`` by itself may be a standard: it is scatter where another name says the same without it,
    or with one more word, the same for several (``std_LV_N`` next to ``F_LV_N``).
    """
    said = {c.column: frozenset(words_of(split_unit(c.column)[0])) for c in columns}
    rests = {name: own - SCATTERS for name, own in said.items() if own & SCATTERS}
    means = [own - set(_CENTRES) for name, own in said.items() if name not in rests]
    more = [{own - rest for own in means if rest and rest < own} for rest in rests.values()]
    alike = [own for own in set[frozenset[str]]().union(*more) if len(own) == 1]
    shared = max(alike, key=lambda own: sum(own in each for each in more), default=None)
    several = shared is not None and sum(shared in each for each in more) >= _LEAST_SUMMARIES

    def scatter(column: ColumnGuess) -> bool:
        rest = rests.get(column.column)
        if rest is None:
            return False
        if not {w for w in rest if not w.isdigit()} and len(said[column.column]) > 1:
            return True  # nothing but words of scatter: dev_std_0
        return rest in means or (several and any(own - rest == shared for own in means))

    return [
        c.as_quantity("other", "likely", IS_SCATTER) if c.values is not None and scatter(c) else c
        for c in columns
    ]


def _whole_quaternions(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Numbered components of a quaternion are four, from 0 on: Q1 … Q4 are four quadrants."""
    counted = [c for c in columns if c.quantity == "quaternion" and c.name.axis.isdigit()]
    if {c.name.axis for c in counted} >= set("0123"):
        return columns
    names = {c.column for c in counted}
    return [
        c.as_quantity("unknown", "guess", "no component of a whole quaternion")
        if c.column in names else c for c in columns
    ]  # fmt: skip


def _without_tared(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Readings less a constant, next to these themselves: two cells have noise of their own."""
    kept: list[ColumnGuess] = []
    again: list[ColumnGuess] = []
    for column in columns:
        if column.quantity not in ("reading", "unknown") or column.values is None:
            continue
        own = numbers_of(column)
        others = [numbers_of(c) for c in kept if numbers_of(c).shape == own.shape]
        same = any(_less_a_constant(own, other) for other in others)
        (again if same else kept).append(column)
    why = "another column less a constant, as a tare is taken off"
    known = {id(c) for c in again}
    return [c.as_quantity("other", "likely", why) if id(c) in known else c for c in columns]


def _less_a_constant(one: FloatArray, other: FloatArray) -> bool:
    """Whether numbers (n,) are others but for a constant, in rows in which they change enough."""
    good = np.isfinite(one) & np.isfinite(other)
    if np.unique(one[good]).size < _MEASURED:
        return False
    rounded = _TARED * float(np.nanmax(one) - np.nanmin(one))
    return float(np.ptp(one[good] - other[good])) <= rounded


def _without_extremes(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Least and largest samples beside their mean, which lies between them in every row."""
    centres = {
        _CENTRE.sub("_", c.column, 1).lower(): c for c in columns if _CENTRE.search(c.column)
    }

    def extreme(column: ColumnGuess) -> bool:
        centre = centres.get(_EXTREMES.sub("_", column.column, 1).lower())
        if centre is None or not _EXTREMES.search(column.column):
            return False
        if centre.values is None or column.values is None:
            return False
        side = column.values - centre.values
        return bool(np.all(side <= 0) or np.all(side >= 0))

    why = "a statistic of what was read"
    return [c.as_quantity("other", "likely", why) if extreme(c) else c for c in columns]


def _without_multiples(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """A displacement in another measure, as a strain is: a constant times a length."""
    lengths = [c for c in columns if c.unit in LENGTHS and c.values is not None]

    def multiple(column: ColumnGuess) -> bool:
        return column.quantity in ("reading", "unknown") and column.values is not None and any(
            one is not column and _times_a_constant(numbers_of(one), column.values)
            for one in lengths
        )  # fmt: skip

    why = "a length times a constant"
    return [c.as_quantity("other", "likely", why) if multiple(c) else c for c in columns]


def _times_a_constant(one: FloatArray, other: FloatArray) -> bool:
    """Whether numbers (n,) are others times one constant, to all the digits that are printed."""
    good = np.isfinite(one) & np.isfinite(other)
    one, other = one[good], other[good]
    if np.unique(one).size < _DIFFERENT or not np.any(other):
        return False
    left = other - one * (one @ other) / (one @ one)
    return bool(np.abs(left).max() <= _PRINTED * np.abs(other).max())


def _without_places(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Positions: columns along x, y or z in a length, a second of one name too."""

    def place(column: ColumnGuess) -> bool:
        stem, unit, _ = split_unit(_AGAIN.sub("", column.column))
        along = words_of(stem)[-1:] in (["x"], ["y"], ["z"])
        return column.quantity in ("reading", "unknown") and along and unit in LENGTHS

    return [
        c.as_quantity("position", "likely", "its name: where something is") if place(c) else c
        for c in columns
    ]


def quotients(loads: Sequence[ColumnGuess], cells: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Columns that are a reading by its load, or the load by it: a scale that was worked out.

    They agree to the digits that are printed, in every row with a load.
    """
    if len(loads) != 1 or len(cells) < 2:
        return []
    load = numbers_of(loads[0])
    found = []
    for column in cells:
        own = numbers_of(column)
        printed = own[np.isfinite(own)]
        digits = next((d for d in range(7) if np.allclose(printed, np.round(printed, d))), 7)
        step = 10.0**-digits
        for other in cells:
            read = numbers_of(other)
            good = np.isfinite(load + own + read) & (load != 0) & (read != 0)
            if other is column or own.shape != read.shape or good.sum() < _LEAST:
                continue
            ratios = (read[good] / load[good], load[good] / read[good])
            if any(np.all(np.abs(own[good] - ratio) <= step) for ratio in ratios) and (
                np.ptp(own[good]) > 2 * step
            ):  # fmt: skip
                found.append(column)
                break
    return found


def copies(loads: Sequence[ColumnGuess], cells: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Columns that are a measured load times a constant: its stress, or the load once more.

    A cell has noise and a zero of its own; numbers of a load that was measured are not round.
    """
    measured = [
        numbers_of(c) for c in loads
        if np.unique(numbers_of(c)).size >= _MEASURED
        and np.any(np.abs(numbers_of(c) * 1000 - np.round(numbers_of(c) * 1000)) > _PRINTED)
    ]  # fmt: skip
    return [c for c in cells if any(_times_a_constant(one, numbers_of(c)) for one in measured)]


def one_statistic(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Of count, mean, scatter and quartiles of one reading, the mean (else the median) is it."""
    plain = {c.column: split_unit(c.column)[0].lower() for c in columns if c.values is not None}
    said = {column for column, name in plain.items() if name in _SUMMARIES}
    by_name = {plain[column]: column for column in said}
    taken = next((by_name[name] for name in _CENTRES if name in by_name), "")
    if not taken or len(said) < _LEAST_SUMMARIES:
        return columns
    why = "a statistic of what was read"
    return [
        c.as_quantity("reading", "likely", f"{why}: its centre") if c.column == taken
        else c.as_quantity("other", "likely", why) if c.column in said else c for c in columns
    ]  # fmt: skip
