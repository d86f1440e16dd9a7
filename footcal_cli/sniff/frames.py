"""Counters of frames in place of a clock: how long a frame takes is asked, not taken for a second.

Room: sniff; asked by columns and several.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.plan import Blank, LogPlan
from footcal_cli.tables.canonical import NOT_SAID

_ROWS = 60
"""Fewer rows are no recording."""
_RATE = Blank(
    ('# in [columns]: unit = "?" of time_s becomes "s", with factor = 1 / rate_hz behind it',
     "# (the duration of one frame: 0.05 at 20 frames per second)"),
    "the log counts frames, and nothing says how many there are per second",
)  # fmt: skip
_EACH = 0.9
"""Share of rows that are the next frame; the others were lost between them."""


def in_frames(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """A clock that no name or unit calls one, and that counts by one, counts frames."""
    return [
        replace(c, unit=NOT_SAID, why="counts by one: frames, of a rate that nothing says")
        if c.quantity == "time" and c.sure == "guess" and c.unit == "s" and _frames(c) else c
        for c in columns
    ]  # fmt: skip


def rate_asked(plan: LogPlan) -> LogPlan:
    """A plan that asks how long a frame takes, where its clock counts frames."""
    clock = plan.entries.get("time_s")
    if clock is None or clock.unit != NOT_SAID:
        return plan
    return replace(plan, blanks=(*plan.blanks, _RATE), options=())  # holds were counted in s


def _frames(column: ColumnGuess) -> bool:
    named = not column.column.startswith("column_")
    plain = named and name_guess(column.column).quantity != "time"
    return plain and column.values is not None and _by_one(column.values)


def _by_one(values: FloatArray) -> bool:
    """Whether whole numbers (n,) rise, nearly always by one."""
    if values.size < _ROWS or not np.isfinite(values).all():
        return False
    steps = np.diff(values)
    whole = bool(np.all(values == np.round(values)) and steps.min() > 0)
    return whole and float(np.mean(steps == 1)) > _EACH
