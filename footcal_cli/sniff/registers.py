"""Two columns that are the halves of one reading: registers of sixteen bits.

Room: sniff; asked by columns.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.readings import straightness
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.tables.registers import WORD, thirty_two_bits

_STRAIGHT, _LEFT = 0.999, 0.02
"""How much of the whole's variance the load explains; what it leaves, of what it leaves of a half.
"""


def joined_registers(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Columns in which two halves of a reading, that a known load shows to be such, are one."""
    loads = [c for c in columns if c.quantity == "load" and c.values is not None]
    words = [c for c in columns if c.quantity in ("reading", "unknown") and _sixteen_bits(c)]
    if len(loads) != 1 or len(words) < 2:
        return columns
    load = numbers_of(loads[0])
    for high, low in permutations(words, 2):
        upper, lower = _codes(high), _codes(low)
        if np.ptp(lower) < WORD / 4 or np.unique(upper).size < 2 or lower.size != load.size:
            continue
        whole = thirty_two_bits(upper, lower)
        parts = (straightness(load, upper), straightness(load, lower))
        left = 1 - straightness(load, whole)
        if left > 1 - _STRAIGHT or left > _LEFT * (1 - max(parts)):
            continue
        joined = replace(
            low.as_quantity("reading", "likely", f"its high word is {high.column}"),
            values=whole, high_word=high.column, wraps_at=None,
        )  # fmt: skip
        other = high.as_quantity("other", "likely", f"the high word of {low.column}")
        return [joined if c is low else other if c is high else c for c in columns]
    return columns


def _codes(column: ColumnGuess) -> FloatArray:
    """Numbers without the sign that was read into them."""
    values = numbers_of(column)
    return np.where(values < 0, values + WORD, values) if column.wraps_at else values


def _sixteen_bits(column: ColumnGuess) -> bool:
    values = column.values
    if values is None or not np.isfinite(values).all():
        return False
    return bool(np.all(values == np.round(values)) and np.abs(values).max(initial=0.0) < WORD)
