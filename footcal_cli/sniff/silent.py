"""What loggers write where a sensor gave no reading: numbers of nines, words between numbers.

Room: sniff; asked for each column by columns and texts.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

from footcal_cli.core.parameters import FloatArray

MEASURED = ("reading", "force", "unknown")
"""Quantities of columns in which a logger may say that there was nothing."""
_NINES = re.compile(r"-?9{3,}")
_APART = 3.0
"""A number that means nothing lies so many spans of all others away from them."""
_SHARE = 0.3
"""No more of the rows are silent in a column that is read."""
_DIFFERENT = 3
"""Different readings beside it, so that it is no load among few."""
_WORDS = 3
_ERROR = re.compile(r"#[A-Z/0!?]+")
_A_NUMBER = re.compile(r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?")


def no_reading(values: FloatArray) -> tuple[str, ...]:
    """Numbers such as -9999 that stand for no reading, as texts; empty where none does.

    They are made of nines, and far from all others.

    Parameters
    ----------
    values
        Of a column, shape (n,).
    """
    good = values[np.isfinite(values)]
    nines = [v for v in np.unique(good).tolist() if _NINES.fullmatch(f"{v:.10g}")]
    others = good[~np.isin(good, nines)]
    if not nines or others.size < (1 - _SHARE) * good.size or np.unique(others).size < _DIFFERENT:
        return ()
    low, high = float(others.min()), float(others.max())
    far = [v for v in nines if max(low - v, v - high) > _APART * (high - low)]
    return tuple(f"{v:.10g}" for v in far)


def words_for_nothing(words: Sequence[str], *, any_word: bool) -> tuple[str, ...]:
    """Words among the numbers of a column (``ERR``, ``#DIV/0!``); empty where it holds others.

    Parameters
    ----------
    words
        Its cells that are not empty.
    any_word
        Any word between readings means nothing; elsewhere the errors of a spreadsheet alone do
        (``tare`` among loads is one).
    """
    others = Counter(word for word in words if not _A_NUMBER.fullmatch(word))
    if not others or len(others) > _WORDS or others.total() > _SHARE * len(words):
        return ()
    return tuple(others) if any_word or all(map(_ERROR.fullmatch, others)) else ()
