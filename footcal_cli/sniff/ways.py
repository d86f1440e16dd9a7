"""Which way known loads go, of a column of two or three words: by the loads beside it.

Room: sniff; asked by experiment and which_cell. Words of any language will do: where rows of one
word never have a smaller load than the row before, and rows of another never a larger one, these
are up and down.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.sniff.guesses import ColumnGuess, codes_of
from footcal_cli.sniff.plan import LogPlan, of

_LEAST_STEPS = 3
"""Loads that rise, and such that fall: one ladder of three words by chance has fewer."""
_WORDS = (2, 3)
_MAY_SAY = ("label", "direction", "other", "unknown")


def with_ways(plan: LogPlan) -> LogPlan:
    """Known weights with the column that says whether they are put on or taken off."""
    if plan.role != "weights" or "direction" in plan.entries:
        return plan
    said = next((c for c in plan.file.of("direction") if c.values is not None or c.names), None)
    if said is not None:
        return replace(plan, entries={**plan.entries, "direction": of(said)})
    every = [plan.entries, *plan.wide.values()]
    columns = (own["load_n"].column for own in every if "load_n" in own)
    load = next((c.values for c in columns if c is not None and c.values is not None), None)
    used = {e.column.column for own in every for e in own.values() if e.column is not None}
    used |= {name for own in every for e in own.values() for name in e.only_where}
    cell = plan.entries.get("channel")
    of_cell = None if cell is None or cell.column is None else cell.column.codes
    if load is None:
        return plan
    for column in plan.file.of(*_MAY_SAY):
        if column.column in used or column.codes is None:
            continue
        names = ways_of(load, column, np.zeros(load.size, np.int64) if of_cell is None else of_cell)
        if names:
            why = "its words say whether the load is larger or smaller than before"
            made = replace(column, names=names, why=why)
            return replace(plan, entries={**plan.entries, "direction": of(made)})
    return plan


def ways_of(load: FloatArray, column: ColumnGuess, cell: IntArray) -> dict[str, str]:
    """Words -> 1 (more load), −1 (less) or 0 (neither: the load stands); empty where not all do so.

    Parameters
    ----------
    load
        In any unit, shape (n,).
    column
        Of words.
    cell
        Which cell each row is of, shape (n,): loads of one say nothing of those of another.
    """
    if len(column.words) not in _WORDS:
        return {}
    codes = codes_of(column)
    if codes.size != load.size or cell.size != load.size or np.any(codes < 0):
        return {}
    if not np.isfinite(load).all():
        return {}
    put = load if np.ptp(np.sign(load)) == 2 else np.abs(load)
    rises, falls = (np.zeros(len(column.words), np.int64) for _ in range(2))
    for code, steps in _steps(put, codes, cell):
        rises[code] += np.sum(steps > 0)
        falls[code] += np.sum(steps < 0)
    names = {
        word: "0" if not up and not down else "1" if not down else "-1" if not up else ""
        for word, up, down in zip(column.words, rises, falls, strict=True)
    }
    both = sorted(names.values()) in (["-1", "1"], ["-1", "0", "1"])
    enough = min(rises.sum(), falls.sum()) >= _LEAST_STEPS
    return names if both and enough and not _within_another(put, codes, cell, names, column) else {}


def _steps(put: FloatArray, codes: IntArray, cell: IntArray) -> Iterator[tuple[int, FloatArray]]:
    """Steps of the load within each run of one word on one cell, with the word."""
    starts = np.flatnonzero(np.diff(codes) | np.diff(cell)) + 1
    for rows in np.split(np.arange(put.size), starts):
        yield int(codes[rows[0]]), np.diff(put[rows])


def _within_another(
    put: FloatArray, codes: IntArray, cell: IntArray, names: dict[str, str], column: ColumnGuess
) -> bool:
    """Whether a ladder goes up again before it was down: the order of rows tells, words do not."""
    way = np.array([int(names[word]) for word in column.words])[codes]
    for which in np.unique(cell):
        own = cell == which
        load, up = put[own], way[own] > 0
        again = np.flatnonzero(up[1:] & (way[own][:-1] < 0)) + 1
        if np.any(load[again] > load.min() + 1e-9 * (1.0 + np.ptp(load))):
            return True
    return False
