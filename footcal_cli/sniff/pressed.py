"""Which axis of an instrument with three a known weight presses along; three cells are no axes.

Room: sniff; asked by numbered and weights.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.readings import straightness
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of

_ACROSS = 3.0
"""How much farther a load moves the axis that it presses along than those across it."""

_PART, _AT_REST = 0.2, 0.3
"""What a cell of a foot bears beside the one that bears most, and how near its zero it begins."""


def carry_alike(columns: Sequence[ColumnGuess]) -> bool:
    """Whether numbered forces are of cells in a row: each presses one way, from about its zero on.

    Of a vector's components those along the floor change sign, or are small beside the one across.
    """
    ends = np.array([np.nanquantile(numbers_of(c), [0.02, 0.98]) for c in columns])
    ends = ends if ends.sum() > 0 else -ends[:, ::-1]
    reach = np.ptp(ends, axis=1)
    near = np.abs(ends[:, 0]) < _AT_REST * reach
    return bool(near.all() and reach.min() > _PART * reach.max())


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
