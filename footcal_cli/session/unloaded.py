"""Cells that stand still in one log of several: dead, or only unloaded there.

Part of the room `session`, beside `footcal_cli.session.inspection`, which looks at one log alone. A
robot that stands may rest on some of a foot's cells; one that walks loads all of them in each log.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.checks.siblings import check_dead_channels
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding, some_of
from footcal_cli.recipe import Robot
from footcal_cli.tables.columns import TableType
from footcal_cli.tables.table import Table

_LOADED = 0.5
"""Siblings that move in a log by less than this share of what they move by in all logs are not
loaded and unloaded in it: that a cell stands still beside them says nothing."""
_MOST_NAMED = 4


def still_cells(values: FloatArray, names: Sequence[str], log: str) -> list[Finding]:
    """Cells of a foot that stand still in a log while the others move.

    Parameters
    ----------
    values
        Readings, NaN where a sample was lost, shape (n, c).
    log
        Name of the file.
    """
    return [
        replace(found, sentence=f"{found.sentence}, in {log}")
        for found in check_dead_channels(values, names)
    ]


def over_logs(
    noted: Sequence[Finding], tables: Sequence[Table], kind: TableType, robot: Robot
) -> list[Finding]:
    """Findings of all logs of a run, with cells that stand still in some judged by all of them.

    Parameters
    ----------
    noted
        What every log said by itself.
    """
    dead = {finding.where for finding in noted if finding.code == "dead_cell"}
    if kind.name != "cells" or len(tables) < 2 or not dead:
        return list(noted)
    kept = list(noted)
    for foot, spec in robot.feet.items():
        names = [f"{foot}_{cell}" for cell in spec.cells]
        columns = [f"{name}_counts" for name in names]
        if not dead & set(names) or any(c not in table for table in tables for c in columns):
            continue
        values = [without_lost(table.numbers(columns), robot) for table in tables]
        for cell in sorted(dead & set(names)):
            kept = _judged(kept, cell, names, values, [table.path.name for table in tables])
    return kept


def _judged(
    noted: list[Finding], cell: str, names: Sequence[str], values: Sequence[FloatArray],
    logs: Sequence[str],
) -> list[Finding]:  # fmt: skip
    """Findings with one about a cell in place of one for every log in which it stands still."""
    alone = [
        [f for f in still_cells(rows, names, log) if f.where == cell]
        for rows, log in zip(values, logs, strict=True)
    ]
    at = [i for i, found in enumerate(alone) if found]
    own = [found for i in at for found in alone[i] if found in noted]
    if not own:
        return noted
    rest = [finding for finding in noted if finding not in own]
    everything = np.concatenate(values)
    always = any(f.where == cell for f in check_dead_channels(everything, names))
    mates = [k for k, name in enumerate(names) if name != cell]
    moved = _span(everything, mates)
    little = all(_span(values[i], mates) < _LOADED * moved for i in at)
    where = _named([logs[i] for i in at], len(logs))
    if always or not little:
        return [*rest, replace(own[0], sentence=f"{_before(own[0])}, in {where}")]
    return [
        *rest,
        Finding(
            "cell_unloaded", "note", cell,
            f"the cell carries nothing that changes in {where}; it moves in the others",
            "nothing to do where the robot stood so",
        ),
    ]  # fmt: skip


def _before(finding: Finding) -> str:
    return finding.sentence.rpartition(", in ")[0]


def _named(logs: Sequence[str], count: int) -> str:
    """Names of some logs, and of how many they are."""
    return f"{some_of(logs, _MOST_NAMED)} ({len(logs)} of {count} cells logs)"


def _span(values: FloatArray, columns: Sequence[int]) -> float:
    """From the 2nd to the 98th percentile, the median of some columns of (n, c)."""
    good = values[np.isfinite(values).all(axis=1)][:, columns]
    if not len(good):
        return 0.0
    return float(np.median(np.subtract(*np.percentile(good, [98, 2], axis=0))))


def without_lost(values: FloatArray, robot: Robot) -> FloatArray:
    """Readings, NaN where the logger wrote that a sample was lost; same shape."""
    lost = robot.adc.lost_reading
    return values if lost is None else np.where(values == lost, np.nan, values)
