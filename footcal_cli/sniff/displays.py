"""Loads that a scale displayed, in files whose names say what was put on.

Room: sniff; asked by file_names.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.guesses import FileGuess, numbers_of
from footcal_cli.sniff.names import Quantity

_FLICKERS = 0.05
"""How much a display moves within a file, in spans of what it shows in all of them."""


def displayed(group: Sequence[FileGuess]) -> bool:
    """Whether a load in every file flickers about one value, another in each: a scale's display."""
    loads = [file.of("load") for file in group]
    # a load that is called one may be a reference, which knows better than a file's name
    if any(len(own) != 1 or own[0].values is None or own[0].sure != "guess" for own in loads):
        return False
    values = [numbers_of(own[0]) for own in loads]
    apart = np.ptp([np.nanmedian(v) for v in values])
    inside = [np.nanstd(v) for v in values]
    return bool(max(inside) > 0 and max(inside) < _FLICKERS * apart)


def without_display(file: FileGuess) -> FileGuess:
    """A log whose load is what a display showed: the names of files are believed."""
    return _with_load_as(file, "other", "a display: the files' names say what was put on")


def as_reading(file: FileGuess) -> FileGuess:
    """A log whose only load is what was read."""
    return _with_load_as(file, "reading", "a load in every file, whose names say others")


def _with_load_as(file: FileGuess, quantity: Quantity, why: str) -> FileGuess:
    return replace(file, columns=tuple(
        c.as_quantity(quantity, "likely", why) if c.quantity == "load" else c
        for c in file.columns
    ))  # fmt: skip
