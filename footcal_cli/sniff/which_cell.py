"""Which column of a long table tells its cells apart: its groups are straight in the load.

Room: intake of unknown logs (`footcal_cli.sniff`), used by `footcal_cli.sniff.weights`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.bench.split_lines import split_lines
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, codes_of, numbers_of
from footcal_cli.sniff.texts import numbers_as_labels

_BY_CHANCE = 1e-6
"""How rarely groups of one cell are so far apart by chance: a few columns per log, many logs."""


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
    tests = [(split_lines(force, read, codes_of(c)), c) for c in labels]
    if not labels:
        others = [c for c in _numbers_and_places(file) if c.column != cell.column]
        tests = [(split_lines(force, read, codes_of(c)), c) for c in others]
        tests = [(t, c) for t, c in tests if t and max(t.one_zero, t.one_slope) < _BY_CHANCE]
    found = [(t.variance, i) for i, (t, _) in enumerate(tests) if t and t.one_line < _BY_CHANCE]
    if not found:
        return labels[0] if labels else None
    best = tests[min(found)[1]][1]
    why = "its groups are straight in the load, each on a line of its own"
    return best.as_quantity("label", "likely", why)


def _numbers_and_places(file: FileGuess) -> list[ColumnGuess]:
    """Columns of few small whole numbers, and of places, that nothing else uses."""
    found = [c for c in file.of("placement") if c.codes is not None and len(c.words) > 1]
    for column in file.of("unknown", "placement", "sequence", "reading"):
        if (
            column.values is not None
            and (words := numbers_as_labels(column.values, np.inf)) is not None
        ):
            column = ColumnGuess(
                column.column, column.name, None, "likely", words.why, words=words.words,
                codes=words.codes,
            )  # fmt: skip
            found.append(column)
    return found
