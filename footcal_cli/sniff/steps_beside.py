"""Readings with the number or name of a step, and a sheet of what each step was: loads, attitudes.

Room: sniff; asked by several.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import escaped
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.groups import wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.indexed import ATTITUDE
from footcal_cli.sniff.numbered import numbered, numbered_beside

_LEAST_STEPS = 2


def steps_of(file: FileGuess, sheet: FileGuess) -> tuple[ColumnGuess, list[str]] | None:
    """The column of numbered or named steps that a log shares with a sheet, and the sheet's names.

    None where there is no such column, or the sheet does not say every step once.
    """
    keys = {c.column for c in sheet.columns} & {c.column for c in file.columns}
    if len(keys) != 1 or sheet.rows >= file.rows:
        return None
    key = keys.pop()
    named, ours = (next(c for c in f.columns if c.column == key) for f in (sheet, file))
    called, found = _texts_of(named), set(_texts_of(ours))
    if len(set(called)) < len(called) or not found <= set(called) or len(found) < _LEAST_STEPS:
        return None
    return ours, called


def _at_steps(ours: ColumnGuess, called: Sequence[str], column: ColumnGuess) -> ColumnGuess:
    """A column of a sheet at the rows of the log."""
    by_name = dict(zip(called, numbers_of(column).tolist(), strict=True))
    own = np.array([by_name[text] for text in _texts_of(ours)])
    return replace(
        column, column=ours.column, values=own, words=(), codes=None, format=None, pattern=None,
        nanoseconds="", wraps_at=None, held=False, missing=(),
    )  # fmt: skip


def _names(called: Sequence[str], column: ColumnGuess) -> dict[str, str]:
    """Steps -> the sheet's numbers, as a recipe has them."""
    return {
        text: f"{value:.10g}" for text, value in zip(called, numbers_of(column), strict=True)
    }  # fmt: skip


def by_steps(file: FileGuess, steps: FileGuess) -> Part | None:
    """Readings with the number of a step, and a table of what was put on at each step."""
    loads = [c for c in steps.of("load") if c.values is not None]
    shared = steps_of(file, steps)
    if len(loads) != 1 or shared is None:
        return None
    ours, called = shared
    put = _at_steps(ours, called, loads[0].as_quantity("load", "likely", f"by {steps.path.name}"))
    plan = plan_of(replace(file, columns=tuple(put if c is ours else c for c in file.columns)))
    if plan is None or plan.entries.get("load_n") is None:
        return None
    entry = replace(plan.entries["load_n"], names=_names(called, loads[0]))
    plan = replace(plan, entries={**plan.entries, "load_n": entry})
    return Part(plan, (file.path,), escaped(file.path.name))


def posed(file: FileGuess, sheet: FileGuess) -> Part | None:
    """A six-axis transducer with the number of a pose, and a sheet of the poses' attitudes."""
    turned = [c for c in numbered_beside(sheet, file).of(*ATTITUDE) if c.values is not None]
    shared = steps_of(file, sheet)
    if shared is None or not turned or not wrenches(numbered(file)):
        return None
    ours, called = shared
    names = {(c.quantity, c.name.axis): _names(called, c) for c in turned}
    joined = (_at_steps(ours, called, c) for c in turned)
    plan = plan_of(replace(file, columns=(*file.columns, *joined)))
    if plan is None:
        return None
    entries = {
        name: entry if entry.column is None or entry.column.column != ours.column
        else replace(entry, names=names.get((entry.column.quantity, entry.column.name.axis), {}))
        for name, entry in plan.entries.items()
    }  # fmt: skip
    why = f"{plan.why}, by {sheet.path.name}"
    plan = replace(plan, file=file, entries=entries, why=why)
    return Part(plan, (file.path,), escaped(file.path.name))


def _texts_of(column: ColumnGuess) -> list[str]:
    """Cells of a column that numbers or names steps, as texts."""
    if column.codes is not None:
        return [column.words[i] if i >= 0 else "" for i in column.codes]
    values = [] if column.values is None else column.values.tolist()
    return [f"{v:.0f}" if v == v and v == round(v) else str(v) for v in values]
