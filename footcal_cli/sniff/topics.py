"""Tables in which several topics take turns: whose rows count, and by which stamps.

Room: sniff; asked by columns.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.errors import DataError
from footcal_cli.sniff.names import name_guess
from footcal_cli.tables.columns import Column
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.values import seconds, stamps

_FEWEST = 3
_FELT = ("force", "reading")
_ISO = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d")


def topic(raw: Mapping[str, RawColumn]) -> str:
    """A column whose rows count where several topics take turns; empty where none do.

    Topics have no row in common, and a column of stamps has a value in all rows. Of several the one
    of forces counts.
    """
    topics: dict[bytes, list[str]] = {}
    for name, column in raw.items():
        if column.silent.any() and not column.silent.all():
            topics.setdefault(column.silent.tobytes(), []).append(name)
    if len(topics) < 2 or not any(stamps_of(column) is not None for column in raw.values()):
        return ""
    there = [~raw[names[0]].silent for names in topics.values()]
    if np.any(np.sum(there, axis=0) > 1):
        return ""
    whole = {name: column for name, column in raw.items() if not column.silent.any()}
    called = any(name_guess(name).quantity in _FELT for name in whole)
    if called or sum(map(_goes_both_ways, whole.values())) >= _FEWEST:
        return ""  # sensors are read in every row: remarks stand where something else is empty
    felt = (*_FELT, "load")
    named = [name for own in topics.values() for name in own if name_guess(name).quantity in felt]
    return named[0] if named else next(iter(topics.values()))[0]


def _goes_both_ways(column: RawColumn) -> bool:
    """Whether numbers rise and fall, as neither stamps nor counts of rows do."""
    if column.kind != "number":
        return False
    steps = np.diff(np.asarray(column.values, dtype=np.float64))
    return bool(np.any(steps > 0) and np.any(steps < 0))


def stamps_of(column: RawColumn) -> FloatArray | None:
    """Stamps in s or in their own unit, shape (n,), where a column can be the time of all rows."""
    if column.empty.any() or len(column.values) < _FEWEST:
        return None
    at = column.values
    if column.kind == "text" and _ISO.match(str(at[0])):
        try:
            found = stamps(column, Column("time_s", "time stamp"), "time", None, Path())
        except DataError:
            return None
        if found is None:
            return None
        at = seconds(found - found.min())
    elif column.kind not in ("number", "stamp"):
        return None
    at = np.asarray(at, dtype=np.float64)
    good = np.all(np.diff(at) >= 0) and at[0] != at[-1]
    return at if good else None
