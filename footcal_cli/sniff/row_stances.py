"""A table with a row for each stance: a mean that stands for seconds, and no recording at 100 Hz.

Room: sniff; asked by several. From row to row of a recording a stand hardly changes; stances that
were noted one by one change as much as any two of them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.derived import IS_SCATTER
from footcal_cli.sniff.guesses import numbers_of
from footcal_cli.sniff.plan import NO_RATE, LogPlan

_MOST_ROWS, _LEAST_ROWS = 400, 4
_CHANGES = 0.5
"""Squared steps from row to row as a share of twice the variance; of independent rows it is 1."""
_COM = ("com_x_m", "com_y_m")
_NO_STAMPS_HZ = 100.0
_HELD_S = 3.0
"""How long a stance is taken to be held: the first second of a log is left out."""


def with_row_stances(plan: LogPlan) -> LogPlan:
    """A stand whose rows are stances, each of them held for seconds; any other plan as it is.

    A walk whose rows bring the scatter of what was read is one, too: its rows are means; and one
    whose CoM jumps from row to row.
    """
    rows, means = plan.file.rows, any(c.why == IS_SCATTER for c in plan.file.columns)
    places = [numbers_of(e.column) for n, e in plan.entries.items()
              if n in _COM and e.column is not None and e.column.values is not None]  # fmt: skip
    means |= bool(places) and min(map(_changes, places)) > _CHANGES
    stands = plan.command == "static-init" or (plan.command == "online-replay" and means)
    if plan.role != "cells" or not stands or "time_s" in plan.entries:
        return plan
    if not _LEAST_ROWS <= rows <= _MOST_ROWS:
        return plan
    read = [numbers_of(e.column) for n, e in plan.entries.items()
            if n.endswith(("_counts", "_fz_n")) and e.column is not None
            and e.column.values is not None]  # fmt: skip
    if not read or float(np.median([_changes(values) for values in read])) < _CHANGES:
        return plan
    rate = plan.rate_hz or _NO_STAMPS_HZ
    layout = replace(plan.file.layout, row_lasts=round(_HELD_S * rate))
    file = replace(plan.file, text=replace(plan.file.text, layout=layout))
    blanks = tuple(blank for blank in plan.blanks if blank is not NO_RATE)
    kind = f"{plan.kind}, a row for each stance"
    return replace(plan, file=file, blanks=blanks, kind=kind, rate_hz=rate, command="static-init")


def _changes(values: FloatArray) -> float:
    """How much numbers (n,) change from row to row: 1 where rows have nothing in common."""
    good = values[np.isfinite(values)]
    spread = 2.0 * float(np.var(good)) if good.size > 1 else 0.0
    return float(np.mean(np.diff(good) ** 2)) / spread if spread > 0 else 0.0
