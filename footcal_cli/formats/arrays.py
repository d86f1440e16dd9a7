"""Arrays of a file by dotted name, gathered into tables: what has one length belongs together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from footcal_cli.formats.contract import (
    CHUNK_ROWS,
    Array,
    Arrays,
    Stream,
    component_names,
    seconds,
    time_column,
)

_MOST_COLUMNS_OF_A_MATRIX = 64


def tables(arrays: Mapping[str, Array], whole: str, kind: str) -> tuple[Stream, ...]:
    """Streams of all arrays: one-dimensional ones of one length become one table.

    Matrices become ``name_0 name_1 …``, along the axis whose length other arrays share, else along
    the longer one. Scalars and larger arrays are left out and said so. The struct or group that all
    names of a table lie in names the table, no longer its columns.

    Parameters
    ----------
    arrays
        By dotted name.
    whole
        Name of the table where the file holds only one.
    kind
        What the file is called in a listing.
    """
    lengths = {a.shape[0] for a in arrays.values() if a.ndim == 1 and a.size > 1}
    groups: dict[int, Arrays] = {}
    left_out: list[str] = []
    for name, array in arrays.items():
        found = _columns(name, array, lengths)
        if isinstance(found, str):
            left_out.append(found)
            continue
        rows = len(next(iter(found.values())))
        groups.setdefault(rows, {}).update(found)
    streams: list[Stream] = []
    for rows, columns in sorted(groups.items(), key=lambda item: -item[0]):
        parent = _parent(columns)
        name = whole if len(groups) == 1 else parent.rstrip(".") or f"{rows}_rows"
        columns = {column.removeprefix(parent): values for column, values in columns.items()}
        streams.append(stream_of(name, kind, columns, () if streams else tuple(left_out)))
    if not streams:
        streams.append(Stream(whole, kind, 0, (), None, "", lambda: iter(()), tuple(left_out)))
    return tuple(_named_apart(streams))


def stream_of(name: str, kind: str, columns: Arrays, left_out: tuple[str, ...] = ()) -> Stream:
    """A stream of columns that are in memory already."""
    names = tuple(columns)
    time = time_column(names)
    if time is not None and columns[time].dtype.kind not in "iuf":
        time = None
    rows = len(next(iter(columns.values()))) if columns else 0
    duration_s = None
    if time is not None and rows > 1:
        duration_s = float(seconds(columns[time], time)[-1])
    return Stream(
        name, kind, rows, names, time, f"column {time}" if time else "no stamps",
        partial(pieces, columns), left_out, duration_s,
    )  # fmt: skip


def pieces(columns: Arrays) -> Iterator[Arrays]:
    """Columns cut into pieces of at most `CHUNK_ROWS`."""
    rows = len(next(iter(columns.values())))
    for start in range(0, rows, CHUNK_ROWS):
        yield {name: values[start : start + CHUNK_ROWS] for name, values in columns.items()}


def _columns(name: str, array: Array, lengths: set[int]) -> Arrays | str:
    """An array as columns, or why it is left out."""
    if array.dtype.kind not in "biufSUO":
        return f"{name} ({array.dtype})"
    if array.ndim == 0 or array.size <= 1:
        return f"{name} (one value)"
    if array.ndim == len("ijt") and sorted(array.shape)[:2] == [3, 3]:
        return _of_rotations(name, array)
    if array.ndim > 2:
        return f"{name} ({' x '.join(str(n) for n in array.shape)})"
    if array.ndim == 1:
        return {name: array}
    if array.shape[0] not in lengths and (
        array.shape[1] in lengths or array.shape[1] > array.shape[0]
    ):
        array = array.T
    if array.shape[1] > _MOST_COLUMNS_OF_A_MATRIX:
        return f"{name} ({array.shape[0]} x {array.shape[1]})"
    return dict(zip(component_names(name, array.shape[1]), array.T, strict=True))


def _of_rotations(name: str, array: Array) -> Arrays:
    """A 3 x 3 matrix in each row, ``R_11`` … ``R_33``, rows along the longest axis."""
    each = np.moveaxis(array, int(np.argmax(array.shape)), 0)
    return {f"{name}_{i + 1}{j + 1}": each[:, i, j] for i in range(3) for j in range(3)}


def _parent(columns: Arrays) -> str:
    """The struct or group that all names of a table lie in, with its dot; else nothing."""
    paths = [name.split(".")[:-1] for name in columns]
    shared = [parts[0] for parts in zip(*paths, strict=False) if len(set(parts)) == 1]
    return "".join(f"{part}." for part in shared)


def _named_apart(streams: list[Stream]) -> Iterator[Stream]:
    """Streams whose names differ: a name that stands twice gets its number of rows."""
    names = [stream.name for stream in streams]
    for stream in streams:
        if names.count(stream.name) == 1:
            yield stream
        else:
            yield Stream(**{**vars(stream), "name": f"{stream.name}.{stream.rows}_rows"})


def as_table(values: np.ndarray[tuple[int, ...], np.dtype[np.void]], name: str) -> Arrays:
    """Fields of a structured array by dotted name."""
    return {f"{name}.{f}": np.asarray(values[f]) for f in values.dtype.names or ()}
