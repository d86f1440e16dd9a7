r"""Which of two numbered transducers is under which foot, by the body's own stream.

Room: sniff; asked by several. A foot that moves carries nothing: of the transducers a and b, a is
the left one where :math:`|f_a| - |f_b|` grows with the speed of the right foot less that of the
left.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.groups import wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.six_axis import forces_of

_CLEARLY = 0.3
"""Correlation from which the feet's steps say which transducer is whose."""


def with_sides(file: FileGuess, speed_mps: dict[str, FloatArray]) -> FileGuess:
    """The log with its two transducers called left and right; as it is where nothing says which.

    Parameters
    ----------
    speed_mps
        Of the left and the right foot in the rows of the log, any unit, shape (n,) each.
    """
    six = wrenches(file)
    if len(six) != 2 or {"left", "right"} <= six.keys() or speed_mps.keys() != {"left", "right"}:
        return file
    first, second = six.values()
    load = [np.linalg.norm(forces_of(group), axis=1) for group in (first, second)]
    steps = speed_mps["right"] - speed_mps["left"]
    good = np.isfinite(load[0]) & np.isfinite(load[1]) & np.isfinite(steps)
    pair = np.array([(load[0] - load[1])[good], steps[good]])
    if pair.shape[1] < 2 or not np.all(np.ptp(pair, axis=1) > 0):
        return file
    follows = float(np.corrcoef(pair)[0, 1])
    if abs(follows) < _CLEARLY:
        return file
    left, right = (first, second) if follows > 0 else (second, first)
    side = {c.column: s for s, group in (("left", left), ("right", right)) for c in group.values()}
    return replace(file, columns=tuple(_of_side(c, side) for c in file.columns))


def _of_side(column: ColumnGuess, side: dict[str, str]) -> ColumnGuess:
    own = side.get(column.column)
    if own is None:
        return column
    name = replace(column.name, side=own, place="", owner="")
    return replace(column, name=name, why=f"its load falls when the {own} foot moves")
