"""Numbers of rounds, and what numbers alone in a log are: readings, or a count of what begins.

Room: sniff; asked by columns. Loads are followed by readings; a round holds all of them, counts
up by one and begins again.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.texts import FEW
from footcal_cli.sniff.units import NO_READING

_LEAST_ROWS = 3
"""Rows that a round has at least."""
_COUNTS, _DIFFERENT = 5, 4
"""Rows that count up by no chance; so many different numbers are no state of a machine."""
_HELD = 20
"""Rows through which no reading stays the same, time after time."""
_ALL_OF_IT = 0.7
"""Share of a reading's span that it passes in every round."""


def with_rounds(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """A table's columns, with a number of the round as the repeat where no other is one.

    A column of texts must say what differs within a round, or several readings stand side by side:
    of one reading, the number may be that of its cell.
    """
    if any(c.quantity == "repeat" for c in columns):
        return columns
    read = [c for c in columns if c.quantity in ("unknown", "reading", "force", "load")]
    read = [c for c in read if c.values is not None]
    named = any(c.quantity in ("label", "placement") and len(c.words) > 1 for c in columns)
    for column in columns:
        others = [c.values for c in read if c is not column and c.values is not None]
        enough = len(others) > 1 if named else len(others) > 2  # a load, and two cells
        plain = column.quantity in ("unknown", "reading", "sequence") and column.unit is None
        if plain and enough and column.values is not None and is_a_round(column.values, others):
            made = column.as_quantity("repeat", "likely", "counts rounds: all readings come again")
            return [made if c is column else c for c in columns]
    return columns


def with_stances(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """A table's columns beside a CoM, with a number that each stance has for itself as its number.

    A whole number that stays for many rows and does not come again is no reading of a cell.
    """
    if not any(c.quantity == "com" for c in columns):
        return columns
    return [
        c.as_quantity("sequence", "likely", "the number of a stance: it stays through each")
        if c.quantity in ("unknown", "reading") and c.values is not None and c.unit is None
        and _is_of_stances(c.values) else c for c in columns
    ]  # fmt: skip


def _is_of_stances(number: FloatArray) -> bool:
    """Whether whole numbers (n,) stay for many rows each, and none comes again."""
    if not np.isfinite(number).all() or np.any(number != np.round(number)):
        return False
    begins = np.flatnonzero(np.diff(number, prepend=np.nan) != 0)
    long = np.diff(np.append(begins, number.size)).min() >= _HELD
    return bool(long and 1 < begins.size == np.unique(number).size)


def is_a_round(number: FloatArray, read: list[FloatArray]) -> bool:
    """Whether numbers (n,) count up from 0 or 1, and readings (n,) pass their span in each.

    It is the median reading that must: a cell may be dead.
    """
    if not number.size or not np.isfinite(number).all() or number[0] not in (0.0, 1.0):
        return False
    steps = np.diff(number)
    if not np.all((steps == 0) | (steps == 1) | (number[1:] == number[0])):
        return False
    rounds = [number == at for at in np.unique(number)]
    if not 1 < len(rounds) <= FEW or min(own.sum() for own in rounds) < _LEAST_ROWS:
        return False
    shares = []
    for values in read:
        whole = _span(values) if values.shape == number.shape else 0.0
        if whole > 0:
            shares.append(min(_span(values[own]) for own in rounds) / whole)
    return bool(shares) and float(np.median(shares)) > _ALL_OF_IT


def _span(values: FloatArray) -> float:
    good = values[np.isfinite(values)]
    return float(np.ptp(good)) if good.size else 0.0


def only_numbers(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """The one column of numbers in a log is what was read, whatever it is called (``state``).

    One that counts up by one, the last row aside, says which part of a session begins.
    """
    clock = {c.nanoseconds for c in columns}
    some = [c for c in columns
            if c.values is not None and c.quantity != "time" and c.column not in clock]  # fmt: skip
    numbers = some[0].values if len(some) == 1 else None
    if numbers is None:
        return columns
    bare = some[0].quantity in ("reading", "unknown", "other") and some[0].unit is None
    up = numbers.size >= _COUNTS and abs(numbers[0]) <= 1 and np.all(np.diff(numbers[:-1]) == 1)
    if bare and up:
        counted = some[0].as_quantity("sequence", "likely", "counts up from row to row")
        return [counted if c is some[0] else c for c in columns]
    if some[0].quantity != "other" or some[0].unit in NO_READING:
        return columns
    if np.unique(numbers[np.isfinite(numbers)]).size < _DIFFERENT:
        return columns
    taken = some[0].as_quantity("reading", "guess", "the only numbers in the log")
    return [taken if c is some[0] else c for c in columns]
