"""Tables with a row for each foot or cell, as tables with one row per sample.

Room: tables; called by logfiles, so that every reader sees the turned table.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.errors import DataError, nearest
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.reading import Pivot

_STEPS = 1.5
"""Steps of a label's own rows within which its value is taken or interpolated."""


def pivoted_names(names: Sequence[str], pivot: Pivot, path: Path) -> list[str]:
    """Columns of the turned table: stamps, and ``<label>.<column>`` for every other column.

    Raises
    ------
    DataError
        A column that `pivot` names is not there.
    """
    for name in (*pivot.by, *((pivot.at,) if pivot.at else ())):
        if name not in names:
            raise DataError(
                f"missing column '{name}' that pivot names{nearest(name, names)}", file=path,
                remedy="correct pivot in [[files]]", foreign=True,
            )  # fmt: skip
    own = [name for name in names if name and name not in (*pivot.by, pivot.at)]
    stamps = [pivot.at] if pivot.at else []
    return [*stamps, *(f"{label}.{name}" for label in pivot.labels for name in own)]


def own_names(names: Sequence[str], pivot: Pivot) -> list[str]:
    """Columns of the file that some columns of the turned table are made of."""
    found = dict.fromkeys((*pivot.by, *((pivot.at,) if pivot.at else ())))
    for name in names:
        found[pivot.parts_of(name)[1]] = None
    return list(found)


def pivoted(
    raw: Mapping[str, RawColumn], names: Sequence[str], pivot: Pivot, path: Path
) -> dict[str, RawColumn]:
    """Columns of the turned table at the rows of the first label.

    Numbers of the other labels are taken at equal stamps, else interpolated between two rows that
    lie no farther apart than 1.5 of their steps; before the first and after the last the nearest is
    taken, no farther away. What a label of `held` says holds until its next row, and nothing does
    before its first. Without stamps the k-th rows belong together.

    Parameters
    ----------
    raw
        Columns of the file by name.
    names
        Columns wanted of the turned table.
    pivot
        What to turn by.
    path
        The file.

    Raises
    ------
    DataError
        A label without rows, stamps that do not increase, or rows that cannot be numbered.
    """
    words = labels_of([raw[name] for name in pivot.by])
    rows = {label: np.flatnonzero(words == label) for label in pivot.labels}
    for label, own in rows.items():
        if not own.size:
            raise DataError(
                f"no row of '{label}'", file=path, column=pivot.by[0],
                remedy="correct labels of pivot in [[files]]",
            )  # fmt: skip
    first = pivot.labels[0]
    if not pivot.at:
        rows = _counted_off(rows, path)
    base = rows[first]
    lines = next(iter(raw.values())).lines
    lines = None if lines is None else lines[base]
    found: dict[str, RawColumn] = {}
    for name in names:
        label, column_name = pivot.parts_of(name)
        column = raw[column_name]
        own = rows[label or first]
        if label in ("", first) or not pivot.at:
            values, empty = column.values[own], column.empty[own]
        elif label in pivot.held:
            values, empty = _last_said(column, raw[pivot.at], own, base)
        else:
            values, empty = _at_stamps(column, raw[pivot.at], own, base, path, pivot.at)
        found[name] = RawColumn(column.kind, values, empty, lines)
    return found


def labels_of(columns: Sequence[RawColumn]) -> NDArray[np.object_]:
    """What each row is of: the texts of some columns, joined by ``_``, shape (n,)."""
    texts = [
        [f"{v:g}" if isinstance(v, float) else str(v).strip() for v in column.values.tolist()]
        for column in columns
    ]
    return np.array(["_".join(row) for row in zip(*texts, strict=True)], dtype=object)


def _counted_off(rows: Mapping[str, IntArray], path: Path) -> dict[str, IntArray]:
    """The k-th rows of all labels; the last sample may be cut off."""
    counts = {label: own.size for label, own in rows.items()}
    least = min(counts.values())
    if max(counts.values()) > least + 1:
        said = ", ".join(f"{label} {count}" for label, count in counts.items())
        raise DataError(
            f"labels have different numbers of rows: {said}", file=path,
            remedy="name the column of stamps: pivot = { …, at = \"…\" }",
        )  # fmt: skip
    return {label: own[:least] for label, own in rows.items()}


def _at_stamps(
    column: RawColumn, stamps: RawColumn, own: IntArray, base: IntArray, path: Path, at: str
) -> tuple[NDArray[np.generic], NDArray[np.bool_]]:
    """Values (n,) of one label at the stamps of another, and where there is none."""
    order, position = np.unique(stamps.values[own], return_index=True)
    if order.size < own.size:
        raise DataError(
            "a stamp stands twice with one label", file=path, column=at,
            remedy="leave `at` out of pivot: rows are then numbered in order",
        )  # fmt: skip
    asked = stamps.values[base]
    after = np.clip(np.searchsorted(order, asked), 0, order.size - 1)
    equal = order[after] == asked
    taken = own[position[after]]
    values, empty = column.values[taken], column.empty[taken] | ~equal
    if equal.all() or stamps.kind == "text":
        return _emptied(values, empty), empty
    theirs, ours = (x.astype(np.float64) for x in (order, asked))
    near = _STEPS * float(np.median(np.diff(theirs))) if order.size > 1 else 0.0
    before = np.clip(after - 1, 0, order.size - 1)
    gap = np.abs(theirs[after] - theirs[before])
    ends = np.minimum(np.abs(ours - theirs[after]), np.abs(ours - theirs[before]))
    inside = (ours >= theirs[0]) & (ours <= theirs[-1])
    reached = np.where(inside, gap <= near, ends <= near)
    if column.kind == "number":
        there = column.values[own[position]].astype(np.float64)
        filled: FloatArray = np.interp(ours, theirs, there)
        values = np.where(equal, values.astype(np.float64), np.where(reached, filled, np.nan))
        return values, np.isnan(values)
    closer = np.abs(ours - theirs[before]) < np.abs(ours - theirs[after])
    taken = own[position[np.where(closer, before, after)]]
    empty = column.empty[taken] | ~(equal | reached)
    return _emptied(column.values[taken], empty), empty


def _last_said(
    column: RawColumn, stamps: RawColumn, own: IntArray, base: IntArray
) -> tuple[NDArray[np.generic], NDArray[np.bool_]]:
    """What one label last said at the stamps of another (n,), and where it had said nothing."""
    order = own[np.argsort(stamps.values[own], kind="stable")]
    at = np.searchsorted(stamps.values[order], stamps.values[base], side="right") - 1
    taken = order[np.maximum(at, 0)]
    empty = column.empty[taken] | (at < 0)
    return _emptied(column.values[taken], empty), empty


def _emptied(values: NDArray[np.generic], empty: NDArray[np.bool_]) -> NDArray[np.generic]:
    """Numbers (n,) with NaN where there is none."""
    if empty.any() and values.dtype.kind in "iu":
        return np.where(empty, np.nan, values.astype(np.float64))
    return values
