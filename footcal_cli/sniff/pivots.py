"""Tables with a row for each foot or cell: by what they are turned into one row per sample.

Room: sniff; asked by columns before a table is taken as it stands.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.shared_weight import LEAST_CELLS, loaded_places, share_one_weight
from footcal_cli.tables.pivot import labels_of
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.reading import Pivot
from footcal_cli.tables.units import TIMES

_MOST = 25
_TAKE_TURNS = 0.5
"""In a table of one row per foot or cell the next row is mostly of another."""
_LEAST_ROWS = 3
_RARE = 0.05
_RATHER_FEWER = 2
"""Of a load that is noted when it changes there are so many times fewer rows than of readings."""
_FROM_THE_YEAR = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d")
_FILE = re.compile(r"[^*?<>|]*[^\W\d][^*?<>|]*\.[A-Za-z][A-Za-z0-9]{1,7}")
_LABELS = ("label", "placement")
_MEASURED = ("reading", "force", "cop", "unknown", "pressure")
_SIDES = {"left", "right"}
_ATTITUDES = ("quaternion", "angle", "matrix", "gravity", "acceleration", "orientation")
_AXES = {"fx", "fy", "fz", "tx", "ty", "tz"}


def pivot_of(columns: Sequence[ColumnGuess], raw: Mapping[str, RawColumn]) -> Pivot | None:
    """How a table is turned; None where its rows are samples, or known weights on cells.

    Parameters
    ----------
    columns
        What each column is taken for.
    raw
        The same columns as the file holds them.
    """
    named = [
        c for c in columns
        if len(c.words) > 1 and (c.quantity in _LABELS or _tell_loads(c) or _are_places(c))
    ]  # fmt: skip
    named = [c for c in named if c.codes is not None and np.all(c.codes >= 0)]
    placed = any(map(_are_places, named))
    measured = [
        c for c in columns
        if c.quantity in _MEASURED and c.values is not None and c.unit not in TIMES
    ]  # fmt: skip
    loaded = any(c.quantity == "load" and c.values is not None for c in columns)
    if any(map(_names_files, columns)):
        return None  # an index: each row says what a file is of
    if (by_cell := _cells_at_holes(columns)) is not None:
        return by_cell
    if not named or not measured or (loaded and not any(map(_tell_loads, named))):
        return None
    # six axes of legs are read as they stand, a row for each: they hang
    axes = {c.name.axis for c in columns if c.quantity == "force"}
    feet = any({name_guess(word).side for word in c.words} == _SIDES for c in named)
    if axes >= _AXES and (not feet or any(c.quantity in _ATTITUDES for c in columns)):
        return None
    cells = [c.values for c in measured if c.values is not None and c.name.axis in ("", "fz")]
    if not feet and any(share_one_weight(cells, loaded_places(c)[0]) for c in named):
        return None  # a weight on the holes of a plate: each row is a sample
    by = tuple(c.column for c in named)
    words = labels_of([raw[name] for name in by])
    rows_of = Counter(words.tolist())
    most = max(rows_of.values())
    # a line at the end of an archive is no sample of a variable
    labels = tuple(
        label for label, count in rows_of.items()
        if count > _RARE * most or name_guess(label).quantity == "load"
    )  # fmt: skip
    rows = [np.flatnonzero(words == label) for label in labels]
    least = min(own.size for own in rows)
    if not 1 < len(labels) <= _MOST or least < _LEAST_ROWS:
        return None
    at = _stamps(columns, raw, rows)
    loads = [name_guess(label).quantity == "load" for label in labels]
    noted = _noted_when_changed(labels, rows, loads)
    clock = next((c.column for c in columns if c.quantity == "time" and _in_order(c, raw)), "")
    if noted and clock:  # the load of a smart home, of a plant's archive
        return Pivot(by, tuple(sorted(labels, key=lambda label: label in noted)), clock, noted)
    turns = bool(np.mean(words[1:] != words[:-1]) >= _TAKE_TURNS)
    # databases list a variable after the other, the load among them, under the same stamps
    if not turns and not (at and (any(loads) or placed) and _together(raw[at], rows)):
        return None
    if not at and max(own.size for own in rows) > least + 1:
        return None
    return Pivot(by, labels, at)


def said_once(file: FileGuess, before: Sequence[ColumnGuess], pivot: Pivot) -> FileGuess:
    """A table of a row per hole, in which what all cells of a row have alike is one column.

    Parameters
    ----------
    file
        The turned table.
    before
        The columns as they stood: what these are called holds for what is said once.
    """
    if pivot != _cells_at_holes(before):
        return file
    turned = {c.column: c for c in file.columns}
    made = dict(turned)
    for own in before:
        each = [f"{label}.{own.column}" for label in pivot.labels]
        if own.quantity in _MEASURED or not {*each} <= {*turned}:
            continue
        first, *others = (turned[name] for name in each)
        if all(_alike(first, other) for other in others):
            made[each[0]] = replace(first, name=own.name, unit=own.unit, sure=own.sure, why=own.why)
            made = {name: c for name, c in made.items() if name not in each[1:]}
    return replace(file, columns=tuple(made.values()))


def _alike(one: ColumnGuess, other: ColumnGuess) -> bool:
    """Whether two columns hold the same in all rows."""
    if one.values is not None and other.values is not None:
        return np.array_equal(one.values, other.values, equal_nan=True)
    if one.codes is None or other.codes is None:
        return False
    return one.words == other.words and np.array_equal(one.codes, other.codes)


def _cells_at_holes(columns: Sequence[ColumnGuess]) -> Pivot | None:
    """Rows of a weight on a hole, one for each cell under the plate; None where they are others.

    Cells take turns in one order, and what is said of hole and load holds for all of one turn.
    """
    said = [c for c in columns if c.quantity in ("hole", "load") and c.values is not None]
    if not {("hole", "x"), ("hole", "y"), ("load", "")} <= {
        (c.quantity, c.name.axis) for c in said
    }:
        return None
    for column in columns:
        cells = len(column.words)
        if column.codes is None or not LEAST_CELLS <= cells <= _MOST or column.codes.size % cells:
            continue
        turns = column.codes.reshape(-1, cells)
        if len(turns) < _LEAST_ROWS or np.any(turns != np.arange(cells)):
            continue
        table = np.array([np.nan_to_num(numbers_of(c)).reshape(-1, cells) for c in said])
        if np.all(table == table[:, :, :1]) and np.ptp(table, axis=1).any():
            return Pivot((column.column,), column.words, "")
    return None


def _noted_when_changed(
    labels: Sequence[str], rows: Sequence[IntArray], loads: Sequence[bool]
) -> tuple[str, ...]:
    """Labels of loads that have a row where they changed, and so far fewer than readings have."""
    if all(loads):
        return ()
    least = min(own.size for own, load in zip(rows, loads, strict=True) if not load)
    return tuple(
        label for label, own, load in zip(labels, rows, loads, strict=True)
        if load and own.size * _RATHER_FEWER < least
    )  # fmt: skip


def _in_order(time: ColumnGuess, raw: Mapping[str, RawColumn]) -> bool:
    """Whether stamps can be compared as the file has them: numbers, or dates from the year on."""
    stamps = raw[time.column]
    return stamps.kind != "text" or all(_FROM_THE_YEAR.match(x) for x in stamps.values.tolist())


def _are_places(column: ColumnGuess) -> bool:
    """Whether every word of a column names another place under a foot, as series do."""
    said = [name_guess(word) for word in column.words]
    return all(n.place for n in said) and len({(n.side, n.place) for n in said}) == len(said)


def _names_files(column: ColumnGuess) -> bool:
    """Whether each row of a column names another file."""
    if column.codes is None or np.unique(column.codes).size < column.codes.size:
        return False
    return all(_FILE.fullmatch(word.strip()) for word in column.words)


def _tell_loads(column: ColumnGuess) -> bool:
    """Whether labels are names of variables, of which some are known loads and others are not."""
    quantities = {name_guess(word).quantity for word in column.words}
    return "load" in quantities and len(quantities) > 1


def _stamps(
    columns: Sequence[ColumnGuess], raw: Mapping[str, RawColumn], rows: Sequence[IntArray]
) -> str:
    """The column by which rows belong together; empty where only their order says so."""
    for quantity in ("time", "sequence"):
        for column in columns:
            unnamed = column.quantity == "unknown" and column.unit in TIMES  # aika_s
            if column.quantity != quantity and not (quantity == "time" and unnamed):
                continue
            own = raw[column.column]
            each = [own.values[at] for at in rows]
            if any(np.unique(values).size < values.size for values in each):
                continue
            if own.kind == "text":
                same = all(set(values) == set(each[0]) for values in each[1:])
                if same:
                    return column.column
            elif quantity == "time" or _shared(each):
                return column.column
    return ""


def _together(stamps: RawColumn, rows: Sequence[IntArray]) -> bool:
    """Whether every label has the stamps that the others have."""
    first = np.unique(stamps.values[rows[0]])
    return all(np.array_equal(first, np.unique(stamps.values[own])) for own in rows[1:])


def _shared(each: Sequence[FloatArray]) -> bool:
    """Whether numbers of rows count samples: most of them stand with every label."""
    common = set(each[0].tolist()).intersection(*(set(v.tolist()) for v in each[1:]))
    return len(common) * 2 > max(len(values) for values in each)
