"""Numbers and names of poses in a table with a row for each leg and pose, in whatever language.

Room: sniff; asked by six_axis. Of ``pozycja``, ``postura``, ``shisei`` nothing need be known: each
of their values stands once beside each leg.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, codes_of, numbers_of

_WHY = "each of its values stands once next to each leg"
_TAKEN_FOR = ("placement", "sequence", "repeat", "unknown", "label", "load", "reading", "other")
_LEAST_POSES = 3
_WHOLE = 0.9
"""Share of poses that have a row of each leg; a few may have lost one."""


def pose_numbers(file: FileGuess, labels: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Columns without a unit, of which each value stands once beside each leg.

    Numbers that go up by one may have been taken for loads or readings.
    """
    if not labels or labels[0].codes is None:
        return []
    legs, number = labels[0].codes, len(labels[0].words)
    found = []
    for column in file.of(*_TAKEN_FOR):
        if column.column == labels[0].column or column.unit is not None:
            continue
        if column.codes is not None:
            called = codes_of(column).astype(float)
        elif column.values is not None:
            called = numbers_of(column)
        else:
            continue
        if not np.isfinite(called).all() or np.any(called != np.round(called)):
            continue
        pairs = np.unique(np.column_stack([called, legs]), axis=0)
        poses = np.unique(called).size
        if poses >= _LEAST_POSES and len(pairs) == file.rows >= _WHOLE * poses * number:
            found.append(column.as_quantity("placement", "likely", _WHY))
    return found
