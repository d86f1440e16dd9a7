"""Several streams as one table on the clock of one of them, by nearest or previous stamp."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from footcal_cli.formats.contract import Array, Arrays

How = Literal["nearest", "previous"]


@dataclass(frozen=True)
class Joined:
    """One table, and for each stream that was joined the rows that found no partner."""

    columns: Arrays
    unmatched: Mapping[str, int]


def joined(
    streams: Mapping[str, tuple[Arrays, str]], clock: str, how: How, tolerance_s: float
) -> Joined:
    """Join streams on the stamps of one.

    Parameters
    ----------
    streams
        By name: columns and the one that holds the stamps, all in one unit.
    clock
        The stream whose rows stay as they are.
    how
        ``nearest`` stamp, or the last one at or before (``previous``).
    tolerance_s
        The largest distance of a partner; beyond it a row keeps NaN.
    """
    columns, time = streams[clock]
    stamps = columns[time]
    result: Arrays = {time: stamps}
    result |= {f"{clock}.{n}": v for n, v in columns.items() if n != time}
    unmatched = {}
    for name, (others, other_time) in streams.items():
        if name == clock:
            continue
        order = np.argsort(others[other_time], kind="stable")
        there = others[other_time][order]
        at = _partners(stamps, there, how)
        scale = 1e-9 if time.endswith("_ns") else 1.0
        distance_s = np.abs((there[np.maximum(at, 0)] - stamps).astype(np.float64)) * scale
        missing = (at < 0) | ~(distance_s <= tolerance_s)
        unmatched[name] = int(missing.sum())
        rows = order[np.maximum(at, 0)]
        for column, values in others.items():
            result[f"{name}.{column}"] = _taken(values[rows], missing)
    return Joined(result, unmatched)


def _partners(stamps: Array, there: Array, how: How) -> Array:
    """Index of each row's partner, −1 where none precedes it."""
    before = np.searchsorted(there, stamps, side="right") - 1
    if how == "previous":
        return before
    after = np.minimum(before + 1, len(there) - 1)
    first = np.maximum(before, 0)
    return np.where(there[after] - stamps < stamps - there[first], after, first)


def _taken(values: Array, missing: Array) -> Array:
    if not missing.any():
        return values
    if values.dtype.kind in "OUS":
        return np.where(missing, "", values.astype(object))
    return np.where(missing, np.nan, values.astype(np.float64))
