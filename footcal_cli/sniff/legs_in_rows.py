"""Wrenches of legs as six numbers in a row each: ``phi_LF_0`` … ``phi_RH_5``.

Room: sniff; asked by numbered. What six numbers of every leg are is said by their sizes: three of
them go further than angles do, and much further than the other three.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.sniff.names import name_guess

_LEAST_LEGS = 2
_LARGER = 3.0
"""Forces in N are larger than torques in Nm by this much, in nearly every log."""
_LARGEST_ANGLE = 6.5
"""A whole turn in radians, and a little more."""


def of_legs(stems: Mapping[str, Sequence[ColumnGuess]]) -> dict[str, list[ColumnGuess]]:
    """Six numbers of each of several legs by what stands before the numbers; empty without such."""
    six = {stem: list(c) for stem, c in stems.items() if len(c) == 6 and _is_wrench(c)}
    legs = {stem: (name.side, name.place) for stem in six if (name := name_guess(stem))}
    named = {stem for stem, leg in legs.items() if any(leg)}
    if len(named) < _LEAST_LEGS or len({legs[stem] for stem in named}) < len(named):
        return {}
    return {stem: six[stem] for stem in named}


def _is_wrench(columns: Sequence[ColumnGuess]) -> bool:
    """Whether three of six numbers are forces by their size, and three torques."""
    if any(c.name.axis or c.unit or c.counts for c in columns):
        return False
    if any(c.quantity not in ("unknown", "reading", "force") for c in columns):
        return False
    first, last = (np.column_stack([numbers_of(c) for c in own])
                   for own in (columns[:3], columns[3:]))  # fmt: skip
    small, large = sorted(float(np.nanstd(own, axis=0).max()) for own in (first, last))
    most = max(float(np.nanmax(np.abs(own))) for own in (first, last))
    return large > _LARGER * small and most > _LARGEST_ANGLE
