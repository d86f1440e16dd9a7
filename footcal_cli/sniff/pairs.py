"""Cells that two columns name together: the foot, and the cell in it.

Room: sniff; asked by which_cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from footcal_cli.core.bench.split_lines import SplitLines, split_lines
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.sniff.guesses import ColumnGuess, codes_of
from footcal_cli.sniff.names import name_guess, words_of
from footcal_cli.sniff.vocabulary import OF_A_ROW

_BY_CHANCE = 1e-6
"""How rarely groups of one cell are so far apart by chance: a few columns per log, many logs."""
_NAMED = 1e-3
"""The same where one of the columns names feet: what the other says is of a cell or of a run."""
_MOST = 0.5
_CELLS = {*OF_A_ROW, "loadcell", "lc"}


def pair_of_columns(
    force: FloatArray, read: FloatArray, labels: Sequence[ColumnGuess]
) -> ColumnGuess | None:
    r"""Two columns whose texts together name the cell of a row, as one; None without such.

    Within most rows of one text of either column the other column must split the readings
    :math:`y = a_g + b_g F` into lines of their own, in zero and slope: runs after another tare
    share their slopes, places on one cell their zero. Where one of the columns names feet, a
    line of its own is enough; and nothing is asked of the readings where the other is called after
    cells (``sensor``): cells of one make under moving zeros have lines that look alike.

    Parameters
    ----------
    force, read
        Known loads and the readings of one column, shape (n,) each.
    labels
        Columns of texts, in the order of the file.
    """
    found: list[tuple[float, int, ColumnGuess]] = []
    for first, second in combinations(labels, 2):
        one, other = codes_of(first), codes_of(second)
        if one.size != force.size or other.size != force.size or min(one.min(), other.min()) < 0:
            continue
        both = _joined(first, second)
        if len(both.words) <= max(len({*one.tolist()}), len({*other.tolist()})):
            continue  # one of them says it all
        test = split_lines(force, read, codes_of(both))
        feet = _names_feet(first) or _names_feet(second)
        called = feet and any(_CELLS & {*words_of(c.column)} for c in (first, second))
        if test is None or (
            not called
            and not (
                _splits(force, read, one, other, feet) and _splits(force, read, other, one, feet)
            )
        ):
            continue
        found.append((test.variance, len(found), both))
    return min(found)[2] if found else None


def _splits(
    force: FloatArray, read: FloatArray, outer: IntArray, inner: IntArray, feet: bool
) -> bool:
    """Whether `inner` splits the rows of most groups of `outer` that it splits at all."""
    groups = [outer == code for code in np.unique(outer)]
    groups = [rows for rows in groups if np.unique(inner[rows]).size > 1]
    tests = [split_lines(force[rows], read[rows], inner[rows]) for rows in groups]
    split = [test is not None and _of_cells(test, feet) for test in tests]
    return bool(split) and float(np.mean(split)) > _MOST


def _of_cells(test: SplitLines, feet: bool) -> bool:
    """Whether groups are of different cells, and not runs of one."""
    if feet:
        return test.one_line < _NAMED
    return max(test.one_zero, test.one_slope) < _BY_CHANCE


def _names_feet(label: ColumnGuess) -> bool:
    """Whether the texts of a column are those of different feet."""
    said = [name_guess(word) for word in label.words]
    if not all(name.side or name.place for name in said):  # sol and sag, below ayak
        said = [name_guess(f"{label.column} {word}") for word in label.words]
    addresses = [name.address for name in said]
    return all(name.side or name.place for name in said) and len({*addresses}) == len(addresses) > 1


def _joined(first: ColumnGuess, second: ColumnGuess) -> ColumnGuess:
    """Two columns of texts as one, ``left`` and ``1`` as ``left_1``."""
    pairs = [
        f"{first.words[i]}_{second.words[j]}"
        for i, j in zip(codes_of(first), codes_of(second), strict=True)
    ]
    words = tuple(dict.fromkeys(pairs))
    codes = np.array([words.index(pair) for pair in pairs])
    return replace(
        first.as_quantity("label", "likely", f"with {second.column} it names the cell"),
        words=words, codes=codes, values=None, followed_by=second.column,
        held=first.held or second.held,
    )  # fmt: skip
