"""A running log of a foot's cells, and a table of when the weight lay on which hole.

Room: sniff; asked by several. The log is looked at as a table with a row for each placement.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import IntArray
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import escaped
from footcal_cli.sniff.file_names import Beside, Part
from footcal_cli.sniff.groups import readings, wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.plan import Entry, of
from footcal_cli.sniff.protocol import apart_of, holds, lasting_s, seconds_by
from footcal_cli.sniff.shared_weight import LEAST_CELLS, LEAST_PLACES
from footcal_cli.sniff.which_cell import as_label

_FEWER = 4
"""A placement is of so many rows of the log at least, on average."""
_SAID = ("hole", "placement", "load", "repeat", "sequence")


def indexed_placements(files: Sequence[FileGuess]) -> tuple[list[Part], list[FileGuess]]:
    """Placements of which a table says when they were, and the files that are none of them."""
    for log in files:
        cells = readings(log)
        if len(cells) < LEAST_CELLS or not log.of("time") or wrenches(numbered(log)):
            continue
        if log.of("load", "hole", "com"):
            continue
        for sheet in files:
            if sheet is log or not sheet.of("time"):
                continue
            if sheet.rows < LEAST_PLACES or sheet.rows * _FEWER > log.rows:
                continue
            part = _joined(log, sheet, cells)
            if part is not None:
                return [part], [f for f in files if f is not log and f is not sheet]
    return [], list(files)


def _joined(log: FileGuess, sheet: FileGuess, cells: Sequence[ColumnGuess]) -> Part | None:
    """The placements of one log by one sheet; None where the sheet does not say where and when."""
    clock, stamp = log.of("time")[0], sheet.of("time")[0]
    at, since = seconds_by(log, clock), seconds_by(sheet, stamp)
    if not np.all(np.diff(since) > 0) or since[0] < at[0] or since[-1] > at[-1]:
        return None
    until = lasting_s(sheet, stamp)
    ends = np.append(since[1:], at[-1]) if until is None else since + until
    apart = apart_of(at, since, ends, list(cells)) if until is None else 0.0
    if apart is None:
        return None
    longest = float(np.min(ends - since)) if until is not None else float(np.max(ends - since))
    on = holds(at, since, since + longest, apart)
    if {*on.tolist()} - {-1} != {*range(sheet.rows)}:
        return None
    medians = [_medians(c, on, sheet.rows) for c in cells]
    found = (
        (said, plan_of(replace(
            log, columns=(*said, *medians), rows=sheet.rows, rate_hz=None, text=sheet.text
        ))) for said in _said(sheet, spans=until is not None)
    )  # fmt: skip
    made = next((x for x in found if x[1] is not None and x[1].role == "placements"), None)
    if made is None or (plan := made[1]) is None:
        return None
    said = made[0]
    stem = sheet.path.name.rsplit(".", 1)[0]
    own = {c.column for c in said}
    entries = {name: _beside(entry, own, stem) for name, entry in plan.entries.items()}
    plan = replace(
        plan, file=log, entries={**entries, "time_s": of(clock)}, why=f"{plan.why}, by "
        f"{sheet.path.name}",
    )  # fmt: skip
    why = "where the weight lies from there on"
    why += f"; rows closer to a stamp than apart_s = {apart:g} are left out" * bool(apart)
    beside = replace(sheet, columns=(stamp, *(c for c in sheet.columns if c is not stamp)))
    join = Beside(beside, "time", 0.0, why, "previous", longest, apart)
    return Part(plan, (log.path,), escaped(log.path.name), (join,))


def _said(sheet: FileGuess, *, spans: bool) -> Iterator[list[ColumnGuess]]:
    """What a sheet may say of its rows: its columns as they are, then each of words as the holes.

    Rows with a start and an end are events, whatever their names are called (``Name``, ``Label``).
    """
    said = [c for c in sheet.of(*_SAID, "label") if c.values is not None or c.codes is not None]
    yield said
    if not spans or sheet.of("hole", "placement"):
        return
    for column in sheet.of("label", "other", "unknown", "sequence"):
        named = as_label(column)
        if named is None or not LEAST_PLACES <= len(named.words) < sheet.rows:
            continue
        hole = replace(named, name=replace(column.name, quantity="placement"))
        yield [hole, *(c for c in said if c.column != column.column)]


def _medians(cell: ColumnGuess, on: IntArray, rows: int) -> ColumnGuess:
    """A reading's medians in each placement, shape (rows,)."""
    read = numbers_of(cell)
    return replace(cell, values=np.array([np.nanmedian(read[on == k]) for k in range(rows)]))


def _beside(entry: Entry, columns: set[str], stem: str) -> Entry:
    """An entry of the sheet's columns, which is empty between placements."""
    if entry.column is None or entry.column.column not in columns:
        return entry
    column = replace(entry.column, column=f"{stem}.{entry.column.column}")
    return replace(entry, column=column, missing=("",))
