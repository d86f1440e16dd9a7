"""Whether readings side by side are of one cell: read again, or loaded one way and the other.

Room: sniff; asked by weights.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from footcal_cli.core.bench.split_lines import split_lines
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.sniff.names import words_of
from footcal_cli.sniff.units import split_unit

_BY_CHANCE = 1e-3
"""How rarely columns of one cell lie on lines so far apart."""
_READ_AGAIN = {
    "column", "reading", "value", "measurement", "messung", "messwert", "wert", "lectura", "valor",
    "lecture", "mesure", "valeur", "lettura", "misura", "leitura", "medida", "čtení", "odečet",
    "hodnota", "odczyt", "leolvasás", "lukema", "avläsning", "avlesning", "aflezing", "okuma",
    "ablesung", "rdg", "отсчёт", "показание", "读数", "読み",
}  # fmt: skip
"""What a number behind makes the same once more."""
_WAYS = {
    "up", "down", "loading", "unloading", "ascending", "descending", "increasing", "decreasing",
    "auf", "ab", "aufwärts", "abwärts", "belastung", "entlastung", "charge", "décharge", "mean",
    "average", "mittelwert", "moyenne",
}  # fmt: skip
"""Which way one cell was loaded."""
_DIGITS, _ROUNDED = 9, 0.51
"""Digits of a printed number, and how far from the truth it is in its last one."""


def one_cell(load: ColumnGuess, cells: Sequence[ColumnGuess]) -> bool:
    """Whether readings in columns without names, or counted ones, are of one cell.

    One line of the load is enough. ``adc1`` and ``adc2`` may be two cells that were tared alike.
    """
    called = {re.sub(r"\d+", "", split_unit(c.column)[0]) for c in cells}
    ways = all({*words_of(name)} <= _READ_AGAIN | _WAYS for name in called)
    if not ways or (len(called) > 1 and not any({*words_of(name)} & _WAYS for name in called)):
        return False
    force, read = numbers_of(load), np.concatenate([numbers_of(c) for c in cells])
    if read.size != len(cells) * force.size:
        return False
    codes = np.repeat(np.arange(len(cells)), force.size)
    found = split_lines(np.tile(force, len(cells)), read, codes)
    return found is not None and found.one_line > _BY_CHANCE


def in_one_row(load: ColumnGuess, cells: Sequence[ColumnGuess]) -> bool:
    """Whether the readings of a row were taken under one load, one after another.

    Where loads come again from row to row, the rows are what happened; else each column may be a
    ladder by itself, and is one where it is called after the way of its loads.
    """
    ways = any({*words_of(split_unit(c.column)[0])} & _WAYS for c in cells)
    force = numbers_of(load)
    force = force[np.isfinite(force)]
    return not ways and bool(np.unique(force).size < force.size)


def without_their_mean(cells: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Readings of one cell without the column that is the mean of all others, as it is printed."""
    for cell in cells if len(cells) > 2 else ():
        others = [c for c in cells if c is not cell]
        mean, read = np.mean([numbers_of(c) for c in others], axis=0), numbers_of(cell)
        digits = next(
            (d for d in range(_DIGITS) if np.array_equal(read, np.round(read, d))), _DIGITS
        )
        if np.nanmax(np.abs(mean - read)) <= _ROUNDED * 10.0**-digits:
            return others
    return list(cells)
