"""Logs as tables: the column contract, units, and reading them without guessing.

The only module that knows pandas, pyarrow and pint. A table type (`footcal_cli.columns`) declares
its columns in canonical units; a file may hold a column under a foreign name or in another unit,
said by the recipe's ``[columns]`` or by a unit suffix (``load_kg`` for ``load_n``).
"""

from __future__ import annotations

import csv
import gzip
import hashlib
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pint
import pyarrow as pa
import pyarrow.parquet as pq

from footcal_cli.columns import UNIT_SUFFIXES, Column, ForeignColumn, TableType
from footcal_cli.core.parameters import FloatArray
from footcal_cli.errors import DataError, UsageError, nearest


@dataclass(frozen=True)
class Table:
    """A log that was read.

    Parameters
    ----------
    data
        Canonical columns in canonical units.
    path, digest
        The file and its SHA-256.
    source
        Canonical column -> the file's own name for it.
    """

    data: pd.DataFrame
    path: Path
    digest: str
    source: Mapping[str, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.data)

    def __contains__(self, name: object) -> bool:
        return name in self.data.columns

    def number(self, name: str) -> FloatArray:
        """One column as float64, shape (n,)."""
        return self.data[name].to_numpy(dtype=np.float64)

    def numbers(self, names: Sequence[str]) -> FloatArray:
        """Several columns as float64, shape (n, len(names))."""
        return self.data[list(names)].to_numpy(dtype=np.float64)

    def text(self, name: str) -> np.ndarray[Any, np.dtype[np.object_]]:
        """One column as strings, shape (n,)."""
        return self.data[name].astype(str).to_numpy(dtype=object)


@cache
def _registry() -> pint.UnitRegistry[float]:
    registry: pint.UnitRegistry[float] = pint.UnitRegistry()
    return registry


def unit_factor(unit: str, to: str, gravity_mps2: float) -> Callable[[FloatArray], FloatArray]:
    """A conversion of arrays between units; a mass becomes its weight where a force is asked.

    Raises
    ------
    UsageError
        For a unit nobody knows, or one of another quantity.
    """
    registry = _registry()
    try:
        source, target = registry.Unit(unit), registry.Unit(to)
    except (pint.errors.UndefinedUnitError, pint.errors.DefinitionSyntaxError, ValueError):
        raise UsageError(
            f"unknown unit '{unit}'{nearest(unit, set(UNIT_SUFFIXES.values()))}",
            remedy="write a unit such as N, kg, g, lbf, kgf, mm or deg",
        ) from None
    if source.is_compatible_with("kg") and target.is_compatible_with("N"):
        source_n = float(registry.Quantity(1.0, source).to("kg").magnitude) * gravity_mps2
        factor = source_n / float(registry.Quantity(1.0, target).to("N").magnitude)
        return lambda values: values * factor
    if not source.is_compatible_with(target):
        raise UsageError(
            f"unit '{unit}' is not one of the same quantity as '{to}'",
            remedy=f"give a unit that converts to {to}",
        )
    offset = float(registry.Quantity(0.0, source).to(target).magnitude)
    slope = float(registry.Quantity(1.0, source).to(target).magnitude) - offset
    return lambda values: values * slope + offset


def read_table(
    path: Path,
    table: TableType,
    columns: Mapping[str, ForeignColumn] | None = None,
    *,
    gravity_mps2: float,
) -> Table:
    """Read the columns of a table type from CSV, CSV.gz or Parquet, in canonical units.

    Raises
    ------
    UsageError
        The file does not exist, or a unit is unknown.
    DataError
        The file is empty, truncated, lacks a column, or holds a cell that is not a number.
    """
    if not path.is_file():
        raise UsageError(
            "no such file", file=path, remedy="check the path in [data] or the command"
        )
    header = column_names(path)
    found = {
        spec.name: located
        for spec in table.columns
        if (located := _locate(spec, header, columns or {}, path)) is not None
    }
    raw = _read_columns(path, sorted({f.column for f in found.values()}), table, found)
    if raw.empty:
        raise DataError("no rows", file=path, remedy="record the log again")
    data = pd.DataFrame(index=raw.index)
    for spec in table.columns:
        if spec.name not in found:
            continue
        place = found[spec.name]
        if spec.kind == "text":
            data[spec.name] = _texts(raw[place.column], spec, path)
            continue
        values = _numbers(raw[place.column], spec, place, path)
        if spec.unit is not None and place.unit is not None and place.unit != spec.unit:
            try:
                values = unit_factor(place.unit, spec.unit, gravity_mps2)(values.astype(float))
            except UsageError as error:
                raise UsageError(
                    error.problem, file=path, column=place.column, remedy=error.remedy
                ) from None
        data[spec.name] = values
    source = {name: place.column for name, place in found.items()}
    return Table(data, path, digest(path), source)


def has_columns(path: Path, table: TableType, columns: Mapping[str, ForeignColumn]) -> bool:
    """Whether a file has every required column of a table type."""
    header = column_names(path)
    try:
        for spec in table.columns:
            _locate(spec, header, columns, path)
    except DataError:
        return False
    return True


def write_parquet(columns: pd.DataFrame | Mapping[str, object], path: Path) -> None:
    """Write a table, or columns (n,) by name, as Parquet: zstd, no index, repeatable bytes."""
    data = columns if isinstance(columns, pd.DataFrame) else pd.DataFrame(dict(columns))
    pq.write_table(
        pa.Table.from_pandas(data, preserve_index=False).replace_schema_metadata(None),
        path,
        compression="zstd",
    )


def write_parquet_pieces(pieces: Iterable[Mapping[str, object]], path: Path) -> int:
    """Write columns that come piece by piece, a row group each; the first piece sets the types.

    Returns
    -------
    rows
        How many were written.
    """
    rows = 0
    writer: pq.ParquetWriter | None = None
    try:
        for piece in pieces:
            table = pa.table({name: pa.array(values) for name, values in piece.items()})
            if writer is None:
                writer = pq.ParquetWriter(path, table.schema, compression="zstd")
            writer.write_table(table.cast(writer.schema))
            rows += table.num_rows
    finally:
        if writer is not None:
            writer.close()
    return rows


def read_all(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    """Every column of a CSV, CSV.gz or Parquet file under its own name, units untouched.

    Raises
    ------
    DataError
        Empty, truncated, no header, or rows of another width.
    """
    names = column_names(path)
    if len(names) == 1 and ";" in names[0]:
        raise DataError(
            "the columns are separated by semicolons", file=path,
            remedy="export it with commas as separators and decimal points",
        )  # fmt: skip
    everything = TableType("all", ())
    frame = _read_columns(path, names, everything, {})
    if frame.empty:
        raise DataError("no rows", file=path, remedy="record the log again")
    return {str(name): column.to_numpy() for name, column in frame.items()}


def digest(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _is_parquet(path: Path) -> bool:
    return path.suffix.lower() in {".parquet", ".pq"}


def column_names(path: Path) -> list[str]:
    """Column names of a file, checked for repeats.

    Raises
    ------
    DataError
        Empty, truncated or not text, no header, or a name that stands twice.
    """
    if path.stat().st_size == 0:
        raise DataError("the file is empty", file=path, remedy="record or export the log again")
    if _is_parquet(path):
        try:
            return list(pq.read_schema(path).names)
        except (pa.ArrowInvalid, OSError):
            raise DataError(
                "not a readable Parquet file (truncated?)", file=path, remedy="copy it again"
            ) from None
    opener = gzip.open if path.suffix == ".gz" else open
    try:
        with opener(path, "rt", encoding="utf-8-sig", newline="") as stream:
            names = [name.strip() for name in next(csv.reader(stream), [])]
    except (UnicodeDecodeError, OSError, EOFError):
        raise DataError(
            "not readable as UTF-8 text", file=path, remedy="export it as CSV (UTF-8) or Parquet"
        ) from None
    if not any(names):
        raise DataError("no header line", file=path, remedy="name the columns in the first line")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise DataError(
            "the column name stands twice in the header", file=path, column=twice[0],
            remedy="give every column its own name",
        )  # fmt: skip
    return names


def _locate(
    spec: Column, header: Sequence[str], columns: Mapping[str, ForeignColumn], path: Path
) -> ForeignColumn | None:
    """Find a canonical column: mapped by the recipe, by its name, or by its stem and a unit."""
    if spec.name in columns:
        place = columns[spec.name]
        if place.column not in header:
            if spec.optional:
                return None
            raise DataError(
                f"missing column '{place.column}' that [columns] names for {spec.name}"
                f"{nearest(place.column, header)}",
                file=path, remedy=f"the file has: {_some(header)}",
            )  # fmt: skip
        return ForeignColumn(place.column, place.unit or spec.unit)
    if spec.name in header:
        return ForeignColumn(spec.name, spec.unit)
    if spec.suffix is not None:
        stem = spec.name.removesuffix(spec.suffix)
        for name in header:
            suffix = name.removeprefix(stem)
            if name.startswith(stem) and suffix in UNIT_SUFFIXES:
                unit = UNIT_SUFFIXES[suffix]
                # true forces of a cell (left_fl_n) are not its counts in another unit
                if _converts(unit, UNIT_SUFFIXES[spec.suffix]):
                    return ForeignColumn(name, unit)
    if spec.optional:
        return None
    raise DataError(
        f"missing column '{spec.name}' ({spec.meaning}){nearest(spec.name, header)}",
        file=path, remedy=f"map it in the recipe's [columns]; the file has: {_some(header)}",
    )  # fmt: skip


def _converts(unit: str, to: str) -> bool:
    """Whether a quantity in one unit can be given in another."""
    try:
        unit_factor(unit, to, 1.0)
    except UsageError:
        return False
    return True


def _some(names: Sequence[str], at_most: int = 8) -> str:
    more = f" and {len(names) - at_most} more" if len(names) > at_most else ""
    return ", ".join(names[:at_most]) + more


def _read_columns(
    path: Path, names: Sequence[str], table: TableType, found: Mapping[str, ForeignColumn]
) -> pd.DataFrame:
    texts = {c.name for c in table.columns if c.kind == "text"}
    as_text = {place.column for name, place in found.items() if name in texts}
    try:
        if _is_parquet(path):
            # pre_buffer reads whole row groups of all columns ahead: slower and larger here
            frame: pd.DataFrame = pq.read_table(
                path, columns=list(names), pre_buffer=False
            ).to_pandas()
            return frame
        with warnings.catch_warnings():
            # a row with more fields than the header (a decimal comma?) would lose its tail
            warnings.simplefilter("error", pd.errors.ParserWarning)
            frame = pd.read_csv(
                path,
                dtype=dict.fromkeys(as_text, str),
                encoding="utf-8-sig",
                skipinitialspace=True,
                low_memory=False,
                index_col=False,
            )
        return frame.rename(columns=str.strip)[list(names)]
    except pd.errors.ParserWarning:
        raise DataError(
            "a row has more fields than the header (a decimal comma?)",
            file=path,
            remedy="write decimal points, or one field per column",
        ) from None
    except (pa.ArrowInvalid, pd.errors.ParserError, OSError, EOFError) as error:
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise DataError(
            f"cannot be read to its end (truncated?): {first}", file=path, remedy="copy it again"
        ) from None


def _row_words(path: Path, position: int) -> str:
    return f"row {position + 1}" if _is_parquet(path) else f"line {position + 2}"


def _texts(column: pd.Series[Any], spec: Column, path: Path) -> pd.Series[Any]:
    empty = column.isna().to_numpy()
    if empty.any() and spec.missing == "refuse":
        row = _row_words(path, int(np.argmax(empty)))
        raise DataError("empty cell", file=path, column=str(column.name), row=row,
                        remedy=f"fill in {spec.meaning}")  # fmt: skip
    return column.astype(str).str.strip()


def _numbers(
    column: pd.Series[Any], spec: Column, place: ForeignColumn, path: Path
) -> np.ndarray[Any, Any]:
    """One column as numbers, integers kept as they are; the first bad cell is named."""
    where = str(column.name)
    if not pd.api.types.is_numeric_dtype(column):
        numbers = pd.to_numeric(column, errors="coerce")
        bad = (numbers.isna() & column.notna()).to_numpy()
        if bad.any():
            at = int(np.argmax(bad))
            raise DataError(
                "not a number", file=path, column=where, row=_row_words(path, at),
                value=str(column.iloc[at]), unit=place.unit,
                remedy=f"correct the cell or leave the row out; the column is {spec.meaning}",
            )  # fmt: skip
        column = numbers
    values = column.to_numpy()
    if values.dtype.kind in "iu":
        return values
    values = values.astype(np.float64)
    bad = ~np.isfinite(values) if spec.missing == "refuse" else np.isinf(values)
    if bad.any():
        at = int(np.argmax(bad))
        raise DataError(
            "empty cell or NaN" if np.isnan(values[at]) else "infinite value",
            file=path, column=where, row=_row_words(path, at), value=values[at], unit=place.unit,
            remedy="fill it in or leave the row out",
        )  # fmt: skip
    return values
