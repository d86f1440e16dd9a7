"""Wrenches of legs as six numbers in a row each: ``phi_LF_0`` … ``phi_RH_5``.

Room: sniff; asked by numbered. What six numbers of every leg are is said by their sizes: three of
them go further than angles do, and much further than the other three.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.sniff.names import name_guess

_PLUG = re.compile(r"(?P<word>[^\W\d_]*)[\W_]*(?P<number>\d{1,2})[\W_]*")
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
        return _of_plugs(six)
    return {stem: six[stem] for stem in named}


def _of_plugs(six: Mapping[str, list[ColumnGuess]]) -> dict[str, list[ColumnGuess]]:
    """Wrenches by the number of their plug, ``J1_0`` … ``J6_5``; empty unless all are alike."""
    plugs = {stem: found for stem in six if (found := _PLUG.fullmatch(stem))}
    words = {found["word"] for found in plugs.values()}
    larger_last = {_sizes(columns)[1] > _sizes(columns)[0] for columns in six.values()}
    alike = len(words) == len(larger_last) == 1 and len(plugs) == len(six)
    return dict(six) if alike and len(plugs) >= _LEAST_LEGS else {}


def _is_wrench(columns: Sequence[ColumnGuess]) -> bool:
    """Whether three of six numbers are forces by their size, and three torques."""
    if any(c.name.axis or c.unit or c.counts for c in columns):
        return False
    if any(c.quantity not in ("unknown", "reading", "force") for c in columns):
        return False
    small, large = sorted(_sizes(columns))
    most = max(float(np.nanmax(np.abs(numbers_of(c)))) for c in columns)
    return large > _LARGER * small and most > _LARGEST_ANGLE


def _sizes(columns: Sequence[ColumnGuess]) -> tuple[float, float]:
    """The largest sd of the first three of six numbers, and of the last three."""
    first, last = (
        max(float(np.nanstd(numbers_of(c))) for c in own) for own in (columns[:3], columns[3:])
    )
    return first, last
