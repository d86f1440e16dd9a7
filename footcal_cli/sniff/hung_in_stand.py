"""The stance of a stand in which the robot hangs: no cell carries anything, and all do else.

Room: sniff; asked by several.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.sniff.guesses import ColumnGuess, numbers_of
from footcal_cli.sniff.lifted import IN_THE_AIR
from footcal_cli.sniff.plan import LogPlan

_LEAST_CELLS, _LEAST_STANCES, _MOST_STANCES, _LEAST_ROWS = 3, 4, 200, 10
_ALIKE = 0.5
"""Sums of all readings in stances, the least as a share of the largest: cells of one make."""
_SELDOM = 0.5
"""Share of rows in which a robot that stands hangs at most."""
_IDLE = 0.05
"""How far a cell of a robot in the air may read from its extreme, as a share of what it moves."""


def with_hung_stance(plan: LogPlan) -> LogPlan:
    """A stand whose own rows are the zeros of its cells; any other plan as it is."""
    if plan.role != "cells" or plan.command != "static-init" or plan.zeros_where:
        return plan
    read = [e.column for n, e in plan.entries.items() if n.endswith("_counts") and e.column]
    used = {e.column.column for e in plan.entries.values() if e.column is not None}
    if len(read) < _LEAST_CELLS:
        return plan
    table = np.column_stack([numbers_of(c) for c in read])
    least = _LEAST_ROWS if plan.file.layout.row_lasts == 1 else 1
    for column in plan.file.columns:
        if called := _called(column, len(table)):
            return replace(plan, zeros_where={column.column: called})
        said = None if column.column in used else _spells(column, len(table), least)
        at = None if said is None else _hung(table, said)
        if said is not None and at is not None:
            return replace(plan, zeros_where={column.column: (said[at][0],)})
    return plan


def _called(column: ColumnGuess, rows: int) -> tuple[str, ...]:
    """Texts of a column that say in words which of the rows are of a robot in the air."""
    if column.codes is None or column.codes.size != rows:
        return ()
    found = tuple(
        word for i in np.unique(column.codes[column.codes >= 0])
        if _in_the_air(word := column.words[i])
    )  # fmt: skip
    held = np.mean(np.isin(column.codes, [column.words.index(word) for word in found]))
    return found if held < _SELDOM else ()


def _in_the_air(text: str) -> bool:
    return any(IN_THE_AIR.fullmatch(word) for word in re.findall(r"[^\W\d_]+", text.lower()))


def _spells(column: ColumnGuess, rows: int, least: int) -> list[tuple[str, BoolArray]] | None:
    """Texts of a column that numbers or names stances, and the rows of each; None of any other."""
    if column.codes is not None and column.codes.size == rows:
        found = [(word, column.codes == at) for at, word in enumerate(column.words)]
    elif column.values is not None and column.values.size == rows:
        values = column.values
        if not np.array_equal(values, np.round(values)):
            return None
        numbers = np.unique(values)
        if numbers.size > _MOST_STANCES:
            return None
        found = [(f"{number:.0f}", values == number) for number in numbers]
    else:
        return None
    found = [(text, own) for text, own in found if own.sum() >= least]
    return found if len(found) >= _LEAST_STANCES else None


def _hung(table: FloatArray, said: list[tuple[str, BoolArray]]) -> int | None:
    """Which of several groups of rows of readings (n, c) is of a robot in the air; None if none.

    A group that is called so may have cells that read less in some stance, as a sole bends.
    """
    rows = [own for _, own in said]
    if not all(np.isfinite(table[own]).any(axis=0).all() for own in rows):
        return None  # a channel that read nothing in one of them
    means = np.array([np.nanmean(table[own], axis=0) for own in rows])
    found = []
    for at, own in enumerate(means):
        others = np.delete(means, at, axis=0)
        way = np.sign(np.median(others, axis=0) - own)
        lifted = way * (others - own)
        low = np.any(lifted.min(axis=0) < -_IDLE * np.ptp(means, axis=0))
        if low and not _in_the_air(said[at][0]):
            continue
        # cells of one make: the weight of the robot is about the same sum in all stances
        total = lifted.sum(axis=1)
        if total.min() > _ALIKE * total.max() > 0.0:
            found.append(at)
    return found[0] if len(found) == 1 else None
