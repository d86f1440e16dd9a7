"""Temperatures whose name no table of words knows: the letter of degrees, and numbers of a room.

Room: sniff; asked by columns. ``shitsuon_C`` and ``lampotila C`` are temperatures, and one of the
cells ``cell_A cell_B cell_C`` is none.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.readings import straightness
from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.names import words_of
from footcal_cli.sniff.units import degrees
from footcal_cli.tables.units import conversion

_ROOM_DEGC, _CHANGE_DEGC = (-20.0, 60.0), 30.0
"""Where people and robots measure, and how far the temperature of one log changes."""
_LETTER = re.compile(r"(.*?[\W_])[A-Za-z]")
_FOLLOWS = 0.9
"""How much of a temperature a load explains at most."""


def with_temperatures(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Columns of which one that ends with C or K, and holds such numbers, is a temperature.

    Another column with the same name and another letter makes it one of several cells; without a
    column that could be read beside it, it is the reading itself.
    """
    if any(c.quantity == "temperature" for c in columns):
        return columns
    warm = [c for c in columns if _of_a_room(c) and not _siblings(c, columns)]
    others = [c for c in columns if c.quantity in ("reading", "force", "unknown") and c not in warm]
    loads = [c.values for c in columns if c.quantity == "load" and c.values is not None]
    if len(warm) != 1 or not any(c.values is not None for c in others):
        return columns
    if any(_follow(load, warm[0]) for load in loads):
        return columns
    unit = degrees(words_of(warm[0].column), None)
    made = warm[0].as_quantity("temperature", "likely", f"its letter, and numbers in {unit}")
    return [replace(made, unit=unit) if c is warm[0] else c for c in columns]


def _of_a_room(column: ColumnGuess) -> bool:
    """Whether a column without a unit ends with a letter of degrees and holds such numbers."""
    unit = degrees(words_of(column.column), column.unit)
    if column.quantity != "unknown" or unit is None or column.unit or column.values is None:
        return False
    if _LETTER.fullmatch(column.column.strip()) is None:
        return False
    known = column.values[np.isfinite(column.values)]
    if not known.size:
        return False
    values = conversion(unit, "degC", 1.0)(known)
    inside = _ROOM_DEGC[0] <= float(values.min()) and float(values.max()) <= _ROOM_DEGC[1]
    return inside and float(np.ptp(values)) <= _CHANGE_DEGC


def _siblings(column: ColumnGuess, columns: list[ColumnGuess]) -> bool:
    """Whether another column has the same name but for its last letter."""
    found = _LETTER.fullmatch(column.column.strip())
    return found is not None and any(
        (other := _LETTER.fullmatch(c.column.strip())) is not None and other[1] == found[1]
        for c in columns if c is not column
    )  # fmt: skip


def _follow(load: FloatArray, column: ColumnGuess) -> bool:
    """Whether the numbers of a column follow a load: it is a reading then."""
    values = column.values
    return values is not None and values.size == load.size and straightness(load, values) > _FOLLOWS
