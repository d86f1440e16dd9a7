"""Readings whose unit stands before the name of their cell: ``N_17_0412``, ``kgf left 2``.

Room: sniff; asked by columns. One such name alone may count things (``N_2``).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.units import LOADS, VOLTAGES

_UNITS = "|".join(sorted((*LOADS, *VOLTAGES), key=len, reverse=True))
_FIRST = re.compile(rf"\W*(?P<unit>{_UNITS})[\W_]+(?P<rest>\w.*)")
_FEWEST = 2
_SAYING = ("sequence", "unknown", "reading")


def with_units_first(columns: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Columns with the unit that several of them are called after, each of another cell.

    Axes behind the unit are of a transducer; whole numbers are counts or an order.
    """
    found: dict[str, dict[str, str]] = {}
    for column in columns:
        at = _FIRST.fullmatch(column.column)
        plain = column.quantity in _SAYING and column.unit is None and not column.name.axis
        if at is not None and plain and _broken(column):
            found.setdefault(at["unit"], {})[column.column] = at["rest"]
    cells = {
        name: (unit, rest) for unit, own in found.items() if len(own) >= _FEWEST
        for name, rest in own.items()
    }  # fmt: skip
    return [_read_in(c, *cells[c.column]) if c.column in cells else c for c in columns]


def _broken(column: ColumnGuess) -> bool:
    """Whether a column has numbers that are not whole."""
    if column.values is None:
        return False
    good = column.values[np.isfinite(column.values)]
    return bool(np.any(good != np.round(good)))


def _read_in(column: ColumnGuess, unit: str, rest: str) -> ColumnGuess:
    name = replace(name_guess(rest), quantity="reading", axis="", unit=unit)
    return replace(column, name=name, unit=unit, sure="likely", why="the unit before its name")
