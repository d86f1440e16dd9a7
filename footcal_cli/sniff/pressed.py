"""Which axis of an instrument with three a known weight presses along.

Room: sniff; asked by weights.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.readings import straightness
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of

_ACROSS = 3.0
"""How much farther a load moves the axis that it presses along than those across it."""


def pressed_along(
    load: ColumnGuess, cells: Sequence[ColumnGuess]
) -> tuple[list[ColumnGuess], list[ColumnGuess]]:
    """Readings without those of an instrument's two axes across the load, and these.

    Three names that differ by a last x, y, z are of one instrument; the axis whose reading the load
    moves several times as far as the others' is the one that it presses along.
    """
    put, across = numbers_of(load), []
    stems: dict[str, dict[str, ColumnGuess]] = {}
    for cell in cells:
        if len(cell.column) > 1 and cell.column[-1] in "xyzXYZ":
            stems.setdefault(cell.column[:-1], {})[cell.column[-1].lower()] = cell
    for axes in stems.values():
        reach = {
            c.column: float(np.ptp(numbers_of(c))) * straightness(put, numbers_of(c))
            for c in axes.values() if numbers_of(c).size == put.size
        }  # fmt: skip
        most = max(reach, key=lambda name: reach[name], default="")
        others = [r for name, r in reach.items() if name != most]
        if set(axes) == {*"xyz"} == {n[-1].lower() for n in reach} and (
            max(others) * _ACROSS < reach[most]
        ):  # fmt: skip
            across += [c for c in axes.values() if c.column != most]
    return [c for c in cells if c not in across], across
