"""Logs that footcal reads as they are (CSV, Parquet): passed through, so that all can be joined."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.formats.arrays import stream_of
from footcal_cli.formats.contract import Clock, Columns, Stream, with_unit
from footcal_cli.tables.logfiles import (
    RawColumn,
    column_names,
    is_parquet,
    of_arrow,
    parquet_file,
    raw_columns,
)


def streams(path: Path, _clock: Clock) -> tuple[Stream, ...]:
    """The one table of the file under its own names; dates become nanoseconds since 1970.

    Raises
    ------
    DataError
        Empty, truncated, no header, or rows of another width.
    """
    if is_parquet(path):
        return (stream_of(path.name.split(".")[0], "Parquet", _unpacked(path)),)
    names = column_names(path)
    if len(names) == 1 and ";" in names[0]:
        raise DataError(
            "the columns are separated by semicolons", file=path,
            remedy="export it with commas as separators and decimal points",
        )  # fmt: skip
    columns = _plain(raw_columns(path, names, ()))
    if not len(next(iter(columns.values()))):
        raise DataError("no rows", file=path, remedy="record the log again")
    return (stream_of(path.name.split(".")[0], "CSV", columns),)


def _plain(raw: Mapping[str, RawColumn]) -> Columns:
    columns: Columns = {}
    for name, column in raw.items():
        if column.kind in {"stamp", "duration"}:
            columns[with_unit(name, "ns")] = column.values
        elif column.kind == "text":
            columns[name] = np.where(column.empty, "", column.values)
        else:
            columns[name] = column.values
    return columns


def _unpacked(path: Path) -> Columns:
    """Columns of a Parquet file; fields of structs by dotted names, lists of one length by number.

    Raises
    ------
    DataError
        A list whose length changes, or another type that is no number, text or time.
    """
    import pyarrow as pa

    file = parquet_file(path)
    if not file.metadata.num_rows:
        raise DataError("no rows", file=path, remedy="record the log again")
    raw: dict[str, RawColumn] = {}
    waiting = [(name, file.read(columns=[name]).column(0)) for name in file.schema_arrow.names]
    while waiting:
        name, column = waiting.pop(0)
        kind = column.type
        if pa.types.is_struct(kind):
            fields = [kind.field(i).name for i in range(kind.num_fields)]
            parts = zip(fields, column.flatten(), strict=True)
            waiting = [*((f"{name}.{field}", part) for field, part in parts), *waiting]
        elif pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind):
            rows = column.to_pylist()
            lengths = {len(row) for row in rows if row is not None}
            if len(lengths) != 1:
                raise DataError(
                    f"a list of now {min(lengths, default=0)}, now {max(lengths, default=0)} "
                    "values", file=path, column=name, remedy="take the column out",
                )  # fmt: skip
            each = range(lengths.pop())
            parted = [[None if row is None else row[i] for row in rows] for i in each]
            new = [
                (f"{name}_{i}", pa.chunked_array([pa.array(values, kind.value_type)]))
                for i, values in enumerate(parted)
            ]
            waiting = [*new, *waiting]
        else:
            raw[name] = of_arrow(column, name, path)
    return _plain(raw)
