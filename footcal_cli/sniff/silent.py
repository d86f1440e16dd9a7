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
_NINES = re.compile(r"-?9{3,}(?:\.9+)?")
_APART = 3.0
"""A number that means nothing lies so many spans of all others away from them."""
_SHARE = 0.3
"""No more of the rows are silent in a column that is read."""
_DIFFERENT = 3
"""Different readings beside it, so that it is no load among few."""
_WORDS = 3
_LEVELS = 20
"""Different numbers of a signal in which -1 would not be the only negative one."""
SUMMARY = re.compile(
    r"(?i)(?:\S+\s+)?(?:grand\s+|sub-?\s?)?(?:total|totals|sum|average|mean|summe|mittelwert|gesamt\w*|"
    r"ergebnis|somme|moyenne|total général|promedio|suma|media|somma|totale|medel|summa)[:.]?"
)
"""What a sheet says in front of a line that sums up those above it: ``500 Average``."""
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
    if _is_lost(good):
        return ("-1",)
    nines = [v for v in np.unique(good).tolist() if _NINES.fullmatch(f"{v:.10g}")]
    others = good[~np.isin(good, nines)]
    if not nines or others.size < (1 - _SHARE) * good.size or np.unique(others).size < _DIFFERENT:
        return ()
    low, high = float(others.min()), float(others.max())
    far = [v for v in nines if max(low - v, v - high) > _APART * (high - low)]
    return tuple(f"{v:.10g}" for v in far)


def _is_lost(good: FloatArray) -> bool:
    """Whether -1 is what a driver gives for a lost packet: again and again, and nothing else < 0.

    Next to counts of a converter it lies farther off than these move.
    """
    others = good[good != -1.0]
    lost = good.size - others.size
    if lost < _WORDS or lost > _SHARE * good.size or np.unique(others).size < _LEVELS:
        return False
    whole = bool(np.all(others == np.round(others)))
    return float(others.min()) >= (_APART * float(np.ptp(others)) if whole else 0.0)


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
    summed = [word for word in others if SUMMARY.fullmatch(word)]
    if len(others) - len(summed) > _WORDS or others.total() > _SHARE * len(words):
        return ()
    known = all(word in summed or _ERROR.fullmatch(word) for word in others)
    return tuple(others) if any_word or known else ()
