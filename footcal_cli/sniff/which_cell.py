"""Which cell a load lay on: the column that tells cells apart, by its words and by the readings.

Room: intake of unknown logs (`footcal_cli.sniff`), used by `footcal_cli.sniff.weights`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.bench.split_lines import split_lines
from footcal_cli.core.readings import straightness
from footcal_cli.core.signals import span_of
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, codes_of, numbers_of
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.pairs import pair_of_columns
from footcal_cli.sniff.plan import Blank
from footcal_cli.sniff.texts import numbers_as_labels
from footcal_cli.sniff.units import split_unit
from footcal_cli.sniff.ways import ways_of

_BY_CHANCE = 1e-6
"""How rarely groups of one cell are so far apart by chance: a few columns per log, many logs."""
_FOLLOWS, _IDLE = 0.98, 0.2
"""How much of its reading's variance a load explains on the cell it lies on; and how much of its
own range another one moves by at most."""
_ALONE, _LEAST_ROWS = 0.95, 4
"""Share of loaded rows in which one reading alone moves, and how many rows say so at least."""
ON_WHICH = Blank(
    ("# a column with the name of the loaded cell in every row; then footcal init again",),
    "the weights lay on one cell at a time, and no column says on which",
)


def named_alike(words: Sequence[str], cells: Sequence[ColumnGuess]) -> Mapping[str, ColumnGuess]:
    """The reading that each word names; empty unless every word names one of its own.

    ``front left`` names the columns ``front_left``, ``ADC front left`` and ``fl``; ``L0`` names
    ``L0_kgf``.
    """
    ways = (
        lambda word, c: _plain(word) in (*_called(c), _plain(c.name.address)),
        lambda word, c: any(own.endswith(_plain(word)) for own in _called(c)),
        lambda word, c: bool(c.name.place) and name_guess(word).address == c.name.address,
    )
    for alike in ways:
        on = {word: [c for c in cells if alike(word, c)] for word in words}
        if all(len(own) == 1 for own in on.values()):
            found = {word: own[0] for word, own in on.items()}
            if len({c.column for c in found.values()}) == len(found):
                return found
    return {}


def followers(
    load: ColumnGuess, label: ColumnGuess, cells: Sequence[ColumnGuess]
) -> Mapping[str, ColumnGuess]:
    """The reading that alone follows the load in the rows of each word; empty where two do.

    Words of rows without any load, as ``-``, name no cell.
    """
    force, codes = numbers_of(load), codes_of(label)
    if any(numbers_of(c).size != force.size for c in cells) or codes.size != force.size:
        return {}
    found: dict[str, ColumnGuess] = {}
    for word in loaded_words(load, label):
        rows = codes == label.words.index(word)
        if np.unique(force[rows]).size < 2:
            return {}
        moved = [c for c in cells if span_of(numbers_of(c)[rows]) > _IDLE * span_of(numbers_of(c))]
        if len(moved) != 1 or straightness(force[rows], numbers_of(moved[0])[rows]) < _FOLLOWS:
            return {}
        found[word] = moved[0]
    return found if len({c.column for c in found.values()}) == len(found) else {}


def loaded_words(load: ColumnGuess, label: ColumnGuess) -> list[str]:
    """Words of a column in whose rows anything lay on a cell; all of another size."""
    force, codes = np.nan_to_num(numbers_of(load)), codes_of(label)
    if codes.size != force.size:
        return list(label.words)
    return [word for at, word in enumerate(label.words) if np.any(force[codes == at])]


def loaded_cell(
    file: FileGuess, load: ColumnGuess, cells: Sequence[ColumnGuess]
) -> ColumnGuess | None:
    """The column that says which cell the load lies on, whatever it is called; None without one.

    In the rows of each of its words, or of its small whole numbers, one reading alone follows the
    load, each time another. An empty cell means the word above it, as in merged cells of a sheet.
    """
    for column in file.columns:
        others = [c for c in cells if c.column != column.column]
        label = as_label(column)
        if label is None or len(others) < 2:
            continue
        words = loaded_words(load, label)
        if len(words) > 1 and len(followers(load, label, others)) == len(words):
            return label
    return None


def as_label(column: ColumnGuess) -> ColumnGuess | None:
    """A column as words that hold for rows; None for loads, stamps and what varies too much."""
    if column.quantity in ("time", "load"):
        return None
    if column.values is not None:
        empty = ~np.isfinite(column.values)
        if not column.values.size or empty[0]:
            return None
        above = np.maximum.accumulate(np.where(empty, 0, np.arange(empty.size)))
        found = numbers_as_labels(column.values[above], np.inf)
        return found and replace(found, column=column.column, held=bool(empty.any()))
    if column.codes is None or len(column.words) < 2 or column.codes.size == 0:
        return None
    gaps = column.codes < 0
    if gaps[0]:
        return None
    above = np.maximum.accumulate(np.where(gaps, 0, np.arange(gaps.size)))
    return replace(column, codes=column.codes[above], held=bool(gaps.any()))


def one_cell_moves(load: ColumnGuess, cells: Sequence[ColumnGuess]) -> bool:
    """Whether in the loaded rows one reading alone has left its zero, and not always the same.

    Each reading is compared with its largest way from the median of the rows without a load.
    """
    force = numbers_of(load)
    if len(cells) < 2 or any(numbers_of(c).size != force.size for c in cells):
        return False
    read = np.column_stack([numbers_of(c) for c in cells])
    known = np.isfinite(force) & np.isfinite(read).all(axis=1)
    free, loaded = known & (force == 0), known & (force != 0)
    if not free.any() or loaded.sum() < _LEAST_ROWS:
        return False
    way = np.abs(read[loaded] - np.median(read[free], axis=0))
    largest = way.max(axis=0)
    if not np.all(largest > 0):
        return False
    share = way / largest
    second, first = np.sort(share, axis=1)[:, -2:].T
    alone = second < _IDLE * first
    return bool(alone.mean() >= _ALONE and np.unique(share.argmax(axis=1)[alone]).size > 1)


def not_used(label: ColumnGuess | None) -> tuple[str, ...]:
    """What is said of a column of texts beside several readings, which may name the cells."""
    if label is None or len(label.words) < 2:
        return ()
    some = ", ".join(label.words[:3]) + " …" * (len(label.words) > 3)
    return (
        f"{label.column} ({some}) is not used: if it names the cell of each row, its readings are "
        f'of one cell; write channel = "{label.column}" and wide_into = "repeat"',
    )


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", "", name).lower()


def _called(column: ColumnGuess) -> tuple[str, str]:
    """A column's name as it stands and without its unit: ``l0kgf`` and ``l0``."""
    return _plain(column.column), _plain(split_unit(column.column)[0])


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
    one = np.zeros(force.size, dtype=np.int64)
    # up and down are two words for one cell, not two cells
    labels = [c for c in labels if not ways_of(force, c, one)]
    if (both := pair_of_columns(force, read, _in_order(file, labels))) is not None:
        return both
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


def _in_order(file: FileGuess, labels: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Columns that may name cells, labels or small whole numbers, in the order of the file."""
    found = {c.column: c for c in _numbers_and_places(file)}
    found |= {c.column: as_label(c) or c for c in labels}  # a foot may stand once above its rows
    return [found[c.column] for c in file.columns if c.column in found]


def _numbers_and_places(file: FileGuess) -> list[ColumnGuess]:
    """Columns of few small whole numbers, and of places, that nothing else uses."""
    found = [c for c in file.of("placement") if c.codes is not None and len(c.words) > 1]
    # a name that stands once above the rows it is of, as in merged cells of a sheet
    merged = (as_label(c) for c in file.of("other") if c.codes is not None)
    found += [c for c in merged if c is not None and c.held]
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
