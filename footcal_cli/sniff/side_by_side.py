"""Cells that were read once in each round, all rounds of a row side by side: ``A12_r1 … A19_r4``.

Room: sniff; asked by placed. Names are a cell and a number each, every cell with every number; the
rounds of one cell agree far better than it moves, as two cells under one load do not.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.groups import slug
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.sniff.names import name_guess, without_side
from footcal_cli.sniff.units import split_unit

_ROUND = r"(?P<word>[^\W\d_]*)[\W_]?(?P<round>\d+)"
_NAMED = (
    re.compile(rf"(?P<cell>.*?[^\W_])[\W_]+{_ROUND}"),
    re.compile(rf"(?P<cell>.*[^\W_])[\W_]+{_ROUND}"),
    re.compile(rf"{_ROUND}[\W_]+(?P<cell>[^\W_].*)"),
)
_AGAIN = 0.1
"""How far the rounds of a cell are apart in the middle row, by how far it moves."""


def by_rounds(cells: Sequence[ColumnGuess]) -> dict[str, list[ColumnGuess]]:
    """Number of a round -> its readings, named after their cells; empty where there are none."""
    for pattern in _NAMED:
        found = [pattern.fullmatch(split_unit(c.column)[0].strip()) for c in cells]
        parts = [(f["cell"], f["round"], f["word"].lower()) for f in found if f]
        names, rounds, words = (dict.fromkeys(own) for own in zip(*parts, strict=True)) if (
            len(parts) == len(cells)
        ) else ({}, {}, {})  # fmt: skip
        if len(words) != 1 or min(len(names), len(rounds)) < 2 or len({*parts}) < len(cells):
            continue
        if len(names) * len(rounds) != len(cells):
            continue
        table = {(cell, at): c for (cell, at, _), c in zip(parts, cells, strict=True)}
        if all(_agree([table[cell, at] for at in rounds]) for cell in names):
            return {at: [_of(table[cell, at], cell) for cell in names] for at in rounds}
    return {}


def _of(column: ColumnGuess, cell: str) -> ColumnGuess:
    name, own = name_guess(cell), slug(cell)
    place = name.place or (without_side(own, name.side) if name.side else "")
    said = replace(column.name, side=name.side, place=place, owner=own)
    return replace(column, name=said)


def _agree(read: Sequence[ColumnGuess]) -> bool:
    """Whether readings of rounds are those of one cell under the same loads."""
    table = np.array([numbers_of(c) for c in read])
    table = table[:, np.isfinite(table).all(axis=0)]
    return bool(table.size and np.median(np.ptp(table, axis=0)) < _AGAIN * np.ptp(table))
