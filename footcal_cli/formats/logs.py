"""Logs that footcal reads as they are (CSV, Parquet): passed through, so that all can be joined."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.formats.arrays import stream_of
from footcal_cli.formats.contract import Arrays, ClockOf, Stream, with_unit
from footcal_cli.tables.logfiles import column_names, is_parquet, raw_columns, unpacked
from footcal_cli.tables.rawcolumn import RawColumn


def streams(path: Path, _clock: ClockOf) -> tuple[Stream, ...]:
    """The one table of the file under its own names; dates become nanoseconds since 1970.

    Raises
    ------
    DataError
        Empty, truncated, no header, or rows of another width.
    """
    if is_parquet(path):
        return (stream_of(path.name.split(".")[0], "Parquet", _plain(unpacked(path))),)
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


def _plain(raw: Mapping[str, RawColumn]) -> Arrays:
    columns: Arrays = {}
    for name, column in raw.items():
        if column.kind in {"stamp", "duration"}:
            columns[with_unit(name, "ns")] = column.values
        elif column.kind == "text":
            columns[name] = np.where(column.empty, "", column.values)
        else:
            columns[name] = column.values
    return columns
