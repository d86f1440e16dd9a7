"""Shaft angles and contacts of legs, next to their transducers.

Room: sniff; called by six_axis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.names import Quantity, words_of
from footcal_cli.sniff.plan import Entry, of
from footcal_cli.sniff.vocabulary import LEGS

_LARGEST_RAD = 13.0
"""An angle without a unit that goes further than two turns in radians is in degrees."""


def beside(
    file: FileGuess, six: Mapping[str, Mapping[str, ColumnGuess]], *quantities: Quantity
) -> dict[str, ColumnGuess]:
    """The one column of a quantity that belongs to each transducer; empty unless all have one."""
    found: dict[str, ColumnGuess] = {}
    for name, group in six.items():
        own = group["fx"].name
        there = [
            c for c in _columns(file, quantities)
            if (c.name.side, c.name.place) == (own.side, own.place)
            and set(own.owner.split("_")) <= {*c.name.owner.split("_"), ""}
        ]  # fmt: skip
        if len(there) != 1:
            return {}
        found[name] = there[0]
    return found


def legs_first(labels: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Columns of labels, those before others that are called after legs."""
    return sorted(labels, key=lambda c: not LEGS & {*words_of(c.column)})


def shafts(
    file: FileGuess, six: Mapping[str, Mapping[str, ColumnGuess]]
) -> tuple[Entry | None, dict[str, Entry]]:
    """The shaft angle of every row, and that of each transducer in a wide log."""
    named = _columns(file, ("phase",)) or _columns(file, ("angle",))
    if len(six) == 1 and len(named) > 1:  # the joint that moves the leg, not those that are held
        named = [max(named, key=lambda c: float(np.nanstd(numbers_of(c))))]
    if len(named) == 1:
        return _angle(named[0]), {}
    each = beside(file, six, "phase") or beside(file, six, "angle")
    return None, {name: _angle(column) for name, column in each.items()}


def _columns(file: FileGuess, quantities: tuple[Quantity, ...]) -> list[ColumnGuess]:
    """Columns of numbers; of angles those that are of no attitude."""
    return [
        c for c in file.of(*quantities)
        if c.values is not None and (c.quantity != "angle" or c.name.axis == "angle")
    ]  # fmt: skip


def _angle(column: ColumnGuess) -> Entry:
    """A shaft angle in its unit, or in the one that its size says."""
    if column.unit:
        return of(column, column.unit)
    most = float(np.nanmax(np.abs(numbers_of(column)), initial=0.0))
    return of(column, "deg" if most > _LARGEST_RAD else "rad")
