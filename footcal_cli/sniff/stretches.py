"""A log of six axes, and a sheet of stretches (from, to) in which the transducer was held still.

Room: sniff; asked by several.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.attitudes import attitude_of
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import escaped
from footcal_cli.sniff.file_names import Beside, Part
from footcal_cli.sniff.groups import wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.indexed import ATTITUDE
from footcal_cli.sniff.numbered import numbered, numbered_beside
from footcal_cli.tables.units import TIMES

_LEAST, _FEWER = 3, 4
"""So many stretches, each of so many rows of the log."""
_COULD_BE = ("time", "unknown", "reading", "sequence")


def by_stretches(file: FileGuess, sheet: FileGuess) -> Part | None:
    """The plan for a log with stretches; None where it has none, or no attitude is anywhere.

    An attitude in the log says by itself where it stood still; one in the sheet holds within each
    stretch, and rows outside have none.
    """
    clock, six = file.of("time"), wrenches(numbered(file))
    if not six or not clock or clock[0].values is None or wrenches(numbered(sheet)):
        return None
    found = _stretches(sheet)
    at = numbers_of(clock[0]) * TIMES.get(clock[0].unit or "s", 1.0)
    if found is None or sheet.rows * _FEWER > file.rows:
        return None
    start, since, until = found
    if until[0] < at[0] or since[-1] > at[-1]:
        return None
    if attitude_of(numbered(file), None) is not None:
        plan = plan_of(file)
        said = f"{sheet.path.name}: stretches at rest; the attitude in the log shows them, too"
        made = None if plan is None else replace(plan, warnings=(*plan.warnings, said))
        return None if made is None else Part(made, (file.path,), escaped(file.path.name))
    turned = [c for c in numbered_beside(sheet, file).of(*ATTITUDE) if c.values is not None]
    stem, holds_s = sheet.path.name.rsplit(".", 1)[0], float(np.min(until - since))
    on = np.clip(np.searchsorted(since, at, side="right") - 1, 0, None)
    within = (at >= since[on]) & (at <= since[on] + holds_s)
    joined = (
        replace(
            c, column=f"{stem}.{c.column}", values=np.where(within, numbers_of(c)[on], np.nan)
        ) for c in turned
    )  # fmt: skip
    plan = plan_of(replace(file, columns=(*file.columns, *joined))) if turned else None
    if plan is None or plan.role != "hang":
        return None
    others = (c for c in sheet.columns if c.column != start.column)
    beside = replace(sheet, columns=(start, *others))
    why = "each row holds from its start as long as the shortest stretch"
    join = Beside(beside, "time", 0.0, why, "previous", holds_s)
    plan = replace(plan, file=file, why=f"{plan.why}, by {sheet.path.name}")
    return Part(plan, (file.path,), escaped(file.path.name), (join,))


def _stretches(sheet: FileGuess) -> tuple[ColumnGuess, FloatArray, FloatArray] | None:
    """The column of starts, and starts and ends in s; None where rows are no stretches of time."""
    columns = [
        c for c in sheet.of(*_COULD_BE)
        if c.values is not None and np.isfinite(c.values).all() and len(c.values) >= _LEAST
    ]  # fmt: skip
    for start, end in permutations(columns, 2):
        unit = start.unit or end.unit or "s"
        if "time" not in (start.quantity, end.quantity) or unit not in TIMES:
            continue
        if start.unit != end.unit:
            continue
        since, until = (numbers_of(c) * TIMES[unit] for c in (start, end))
        if np.all(since < until) and np.all(until[:-1] <= since[1:]):
            taken = start.as_quantity("time", "likely", "a stretch of time begins")
            return replace(taken, unit=unit), since, until
    return None
