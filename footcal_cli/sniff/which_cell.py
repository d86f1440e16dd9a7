"""Which column of a long table tells its cells apart: its groups are straight in the load.

Room: intake of unknown logs (`footcal_cli.sniff`), used by `footcal_cli.sniff.weights`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import fdtrc

from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, codes_of, numbers_of
from footcal_cli.sniff.texts import numbers_as_labels

_BY_CHANCE = 1e-6
"""How rarely groups of one cell are so far apart by chance: a few columns per log, many logs."""
_LEAST = 3
"""Readings of a cell from which a line has a residual."""


def cell_column(
    file: FileGuess, load: ColumnGuess, cell: ColumnGuess, labels: Sequence[ColumnGuess]
) -> ColumnGuess | None:
    r"""The column of the cells: of several labels, or of small whole numbers among no labels.

    Each group of rows :math:`g` has a line :math:`y = a_g + b_g F`. Labels are compared with one
    line for all by the F test; of those that split the rows the one with the least residual
    variance is taken, and the first label where none does. Numbers or places that no name calls a
    cell are one only if neither :math:`a_g = a` (a place on one cell: without a load it says
    nothing) nor :math:`b_g = b` (runs after another tare) holds.

    Parameters
    ----------
    file
        The log.
    load, cell
        Known loads and the readings of one column, shape (n,) each.
    labels
        Columns of texts that may be names of cells.
    """
    force, read = numbers_of(load), numbers_of(cell)
    if force.size != read.size:
        return labels[0] if labels else None
    if len(labels) == 1:
        return labels[0]
    tests = [(_split(force, read, codes_of(c)), c) for c in labels]
    if not labels:
        tests = [(_split(force, read, codes_of(c)), c) for c in _numbers_and_places(file)]
        tests = [(t, c) for t, c in tests if t is not None and max(t[2:]) < _BY_CHANCE]
    found = [(t[0], i) for i, (t, _) in enumerate(tests) if t is not None and t[1] < _BY_CHANCE]
    if not found:
        return labels[0] if labels else None
    best = tests[min(found)[1]][1]
    why = "its groups are straight in the load, each on a line of its own"
    return best.as_quantity("label", "likely", why)


def _numbers_and_places(file: FileGuess) -> list[ColumnGuess]:
    """Columns of few small whole numbers, and of places, that nothing else uses."""
    found = [c for c in file.of("placement") if c.codes is not None and len(c.words) > 1]
    for column in file.of("unknown", "placement", "sequence"):
        if column.values is not None and (words := numbers_as_labels(column.values)) is not None:
            column = ColumnGuess(
                column.column, column.name, None, "likely", words.why, words=words.words,
                codes=words.codes,
            )  # fmt: skip
            found.append(column)
    return found


def _split(
    force: FloatArray, read: FloatArray, codes: IntArray
) -> tuple[float, float, float, float] | None:
    """Residual variance of a line per group; chances of one line, one zero and one slope for all.

    None where a group has too few rows or one load alone.
    """
    if codes.size != force.size:
        return None
    good = np.isfinite(force) & np.isfinite(read)
    x, y, groups = force[good], read[good], codes[good]
    names = np.unique(groups)
    each = [x[groups == name] for name in names]
    if groups.min(initial=0) < 0 or len(names) < 2:
        return None
    if any(own.size < _LEAST or np.ptp(own) == 0 for own in each):
        return None
    zeros = (groups[:, None] == names).astype(np.float64)
    slopes = zeros * x[:, None]
    one = np.ones_like(x)
    own, free = _residual(np.hstack([zeros, slopes]), y), y.size - 2 * len(names)
    # no residual is below the rounding of the readings themselves
    own = max(own, free * (np.finfo(np.float64).eps * float(np.abs(y).max())) ** 2)
    if free < 1 or own == 0:
        return None

    def chance(design: FloatArray) -> float:
        fewer = 2 * len(names) - design.shape[1]
        ratio = max(_residual(design, y) - own, 0.0) / fewer / (own / free)
        return float(fdtrc(fewer, free, ratio))

    return (
        own / free, chance(np.column_stack([one, x])), chance(np.column_stack([one, slopes])),
        chance(np.column_stack([zeros, x])),
    )  # fmt: skip


def _residual(design: FloatArray, y: FloatArray) -> float:
    """Sum of squares that a linear model leaves of y, shape (n,)."""
    scale = np.linalg.norm(design, axis=0)
    scaled = design / np.where(scale > 0, scale, 1.0)
    return float(np.sum((y - scaled @ np.linalg.lstsq(scaled, y, rcond=None)[0]) ** 2))
