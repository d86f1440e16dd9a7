"""Streams given in several files: one that goes on where the last one stopped is its next part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.signals import goes_on
from footcal_cli.tables.table import Table


def with_parts_joined(
    sensors: Sequence[Table], bodies: Sequence[Table]
) -> tuple[list[Table], list[Table]]:
    """Sensor logs and, unless there are none, their body logs; parts of one recording are joined.

    Cut in two, a stream would lose what lies at the cut: a body is read between its rows.
    """
    if len(bodies) not in {0, len(sensors)}:
        return list(sensors), list(bodies)
    joined = [list(sensors[:1]), list(bodies[:1])]
    for i in range(1, len(sensors)):
        parts = [sensors[i], *bodies[i : i + 1]]
        if all(_goes_on(own[-1], part) for own, part in zip(joined, parts, strict=False)):
            for own, part in zip(joined, parts, strict=False):
                own[-1] = own[-1].continued_by(part)
        else:
            for own, part in zip(joined, parts, strict=False):
                own.append(part)
    return joined[0], joined[1]


def _goes_on(early: Table, late: Table) -> bool:
    """Whether a log of the same columns begins where another one ends."""
    if set(early.data.columns) != set(late.data.columns):
        return False
    return goes_on(*(t[np.isfinite(t)] for t in (early.number("time_s"), late.number("time_s"))))
