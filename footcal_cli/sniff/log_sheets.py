"""A table of six axes, and a log sheet with a row for each of its rows: when, and how warm.

Room: sniff; asked by several.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import escaped
from footcal_cli.sniff.file_names import Beside, Part
from footcal_cli.sniff.groups import wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.numbered import numbered

_NOTED = ("time", "temperature")


def by_log_sheet(file: FileGuess, sheet: FileGuess) -> Part | None:
    """The plan for a table with the times and temperatures of its sheet; None where it has none.

    Rows are the same if a column of both has the same numbers or words.
    """
    if file.rows != sheet.rows or not wrenches(numbered(file)) or wrenches(numbered(sheet)):
        return None
    noted = [c for kind in _NOTED if not file.of(kind) for c in sheet.of(kind)[:1]]
    key = next((c.column for c in sheet.columns for own in file.columns if _same(c, own)), None)
    if not noted or key is None:
        return None
    stem = sheet.path.name.rsplit(".", 1)[0]
    joined = tuple(replace(c, column=f"{stem}.{c.column}") for c in noted)
    plan = plan_of(replace(file, columns=(*file.columns, *joined)))
    if plan is None or plan.role not in ("hang", "poses"):
        return None
    # stamps are of the sheet: the table is joined to it by its rows
    beside = replace(sheet, columns=tuple(c for c in sheet.columns if c.quantity != "time"))
    join = Beside(beside, "row", 0.0, f"{key} is the same in both")
    plan = replace(plan, file=file, why=f"{plan.why}, by {sheet.path.name}")
    return Part(plan, (file.path,), escaped(file.path.name), (join,))


def _same(one: ColumnGuess, other: ColumnGuess) -> bool:
    """Whether two columns have one name and say the same in every row."""
    if one.column != other.column:
        return False
    if one.values is not None and other.values is not None:
        return bool(np.array_equal(one.values, other.values))
    if one.codes is None or other.codes is None:
        return False
    return one.words == other.words and bool(np.array_equal(one.codes, other.codes))
