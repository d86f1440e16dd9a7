"""Zeros of an empty plate that was taken off and put on again: each series has its own.

Room: intake; asked by placed_weights. A plate that is screwed on again loads its cells otherwise.
Where the empty plate reads something else from series to series than within them, each series is
read by its own zeros; `diagnose` takes the rows as they are, and may name the jump.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import stretches
from footcal_cli.tables.table import Table

_BY_CHANCE = 1e-3
"""How rarely zeros of one plate differ so much more from series to series."""


def with_own_zeros(
    tables: Sequence[Table], cells: Sequence[str]
) -> tuple[list[Table], list[Finding]]:
    """Placements whose series have zeros of their own, read as if they had those of all.

    Parameters
    ----------
    cells
        Of a foot, as the columns are called.
    """
    if not tables:
        return [], []
    columns = [f"{cell}_counts" for cell in cells]
    counts = np.concatenate([table.numbers(columns) for table in tables]).astype(np.float64)
    empty = np.concatenate([table.number("load_n") for table in tables]) == 0.0
    foot = np.concatenate([table.text("foot") for table in tables])
    of_table = np.repeat(np.arange(len(tables)), [len(table) for table in tables])
    moved = np.zeros_like(counts)
    for name in dict.fromkeys(foot.tolist()):
        own = foot == name
        for series in _series(tables, of_table):
            found = _moved(counts[own], empty[own], series[own], of_table[own])
            if found is not None:
                moved[own] = found
                break
    if not moved.any():
        return list(tables), []
    row, cell = divmod(int(np.argmax(np.abs(moved))), len(cells))
    at = tables[of_table[row]]
    made = [
        replace(table, data=table.data.assign(**{
            column: counts[of_table == i, j] - moved[of_table == i, j]
            for j, column in enumerate(columns)
        })) for i, table in enumerate(tables)
    ]  # fmt: skip
    return made, [Finding(
        "zeros_of_series", "note", at.path.name,
        f"the empty plate reads something else in each series, by up to "
        f"{abs(moved[row, cell]):.3g} off the mean in {cells[cell]}: each has its own zeros",
        "go on noting the empty plate in each series",
    )]  # fmt: skip


def _series(tables: Sequence[Table], of_table: IntArray) -> Iterator[IntArray]:
    """What may be a series of placements, shape (n,): a repeat of a file, of all files, a file."""
    if all("repeat" in table for table in tables):
        said = np.concatenate([table.number("repeat") for table in tables])
        repeat = np.unique(said, return_inverse=True)[1].ravel()
        yield of_table * (repeat.max() + 1) + repeat
        yield repeat
    yield of_table


def _moved(
    counts: FloatArray, empty: BoolArray, series: IntArray, of_table: IntArray
) -> FloatArray | None:
    """How far the zeros of each row's series lie off those of all, (n, c); None where they do not.

    By the F of the empty plate's readings between series and within them, one for each time that it
    was empty; cells of one plate have one scatter.
    """
    from footcal_cli.core import chances  # scipy, which not every log asks for

    means, whose = [], []
    for start, stop in stretches(empty):
        parts = np.flatnonzero(np.diff(series[start:stop]) | np.diff(of_table[start:stop])) + 1
        for rows in np.split(np.arange(start, stop), parts):
            means.append(np.nanmedian(counts[rows], axis=0))
            whose.append(series[rows[0]])
    names = np.unique(series)
    group, table = np.array(whose), np.array(means)
    loaded = np.isin(names, series[~empty]).all()
    if len(names) < 2 or not loaded or {*names.tolist()} != {*group.tolist()}:
        return None
    free = len(group) - len(names)
    if free < 1:
        return None
    each = np.array([table[group == name].mean(axis=0) for name in names])
    number = np.array([np.sum(group == name) for name in names])
    every = table.mean(axis=0)
    within = float(np.mean((table - each[np.searchsorted(names, group)]) ** 2)) * len(group) / free
    between = float(np.mean(number @ (each - every) ** 2)) / (len(names) - 1)
    ratio = between / max(within, np.finfo(np.float64).tiny)
    cells = counts.shape[1]
    chance = chances.f_sf(ratio, (len(names) - 1) * cells, free * cells)
    return (each - every)[np.searchsorted(names, series)] if chance < _BY_CHANCE else None
