"""Files of logs as raw columns: CSV, CSV.gz and Parquet, each column with the type it really has.

Nothing is converted here, so that a stamp is not taken for a number, nor a truth value or a text.
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.parameters import IntArray
from footcal_cli.errors import DataError
from footcal_cli.tables.delimited import text_names, text_table
from footcal_cli.tables.nested import flat_names, flattened
from footcal_cli.tables.pivot import own_names, pivoted, pivoted_names
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.reading import Layout
from footcal_cli.tables.textfiles import regular_file, short, unreadable

if TYPE_CHECKING:  # imported where they are used: a refusal waits for neither
    import pandas as pd
    import pyarrow as pa
    import pyarrow.parquet as pq

MOST_COLUMNS = 10_000
MOST_VALUES = 500_000_000
"""Of a Parquet file read as a whole: a small one can unpack to more than any memory."""
_NANOSECONDS = {"s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1}
_EXACT = 2**53


def digest(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal; a pipe, which would be waited for, is refused."""
    regular_file(path)
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def is_parquet(path: Path) -> bool:
    """Whether the name is that of a Parquet file; anything else is CSV."""
    return path.suffix.lower() in {".parquet", ".pq"}


def column_names(path: Path, layout: Layout | None = None) -> list[str]:
    """Column names of a file, checked for repeats.

    Parameters
    ----------
    path, layout
        The file, and how its text is laid out; plain CSV where absent.

    Raises
    ------
    UsageError
        No such file, or none at all.
    DataError
        Empty, truncated or not text, no header, or a name that stands twice.
    """
    regular_file(path)
    if path.stat().st_size == 0:
        raise DataError("the file is empty", file=path, remedy="record or export the log again")
    names = _flat_names(path) if is_parquet(path) else text_names(path, layout or Layout())
    if not any(names):
        raise DataError(
            "no header line", file=path, remedy="name the columns in the first line", foreign=True
        )
    if len(names) > MOST_COLUMNS:
        raise DataError(
            f"{len(names)} columns, more than {MOST_COLUMNS}", file=path,
            remedy="check that columns and rows are not exchanged",
        )  # fmt: skip
    known: set[str] = set()
    for name in names:
        if name in known:
            raise DataError(
                "the column name stands twice in the header", file=path, column=short(name),
                remedy="give every column its own name", foreign=True,
            )  # fmt: skip
        known.add(name)
    pivot = layout.pivot if layout else None
    return names if pivot is None else pivoted_names(names, pivot, path)


def raw_columns(
    path: Path, names: Sequence[str], texts: Collection[str], layout: Layout | None = None
) -> Mapping[str, RawColumn]:
    """Columns of a file by name; those of `texts` as strings whatever they look like.

    Raises
    ------
    DataError
        The file cannot be read to its end, or holds a type that is neither number, text nor time.
    """
    if layout is not None and layout.row_lasts > 1:
        each = raw_columns(path, names, texts, replace(layout, row_lasts=1))
        return {name: column.lasting(layout.row_lasts) for name, column in each.items()}
    if layout is not None and (pivot := layout.pivot) is not None:
        own, flat = own_names(names, pivot), replace(layout, pivot=None)
        asked = {*own_names(list(texts), pivot)} - {*pivot.by, pivot.at}
        return pivoted(raw_columns(path, own, asked, flat), names, pivot, path)
    if is_parquet(path):
        import pyarrow as pa

        file = parquet_file(path)
        whole = flat_names(file, path)
        if file.metadata.num_rows * len(names) > MOST_VALUES:
            raise DataError(
                f"{file.metadata.num_rows} rows of {len(names)} columns are more than "
                f"{MOST_VALUES / 1e6:.0f} million values", file=path,
                remedy="cut the log, or leave out rows",
            )  # fmt: skip
        try:  # one after the other: of a long log two tables need not be held
            found: dict[str, RawColumn] = {}
            for held in dict.fromkeys(whole[name] for name in names):
                column = file.read(columns=[held], use_threads=False).column(held)
                found |= {
                    name: of_arrow(part, name, path)
                    for name, part in flattened(held, column, path) if name in names
                }  # fmt: skip
            return {name: found[name] for name in names}
        except (pa.ArrowException, OSError) as error:
            raise unreadable(path, error) from None
    frame, lines = text_table(path, layout or Layout(), texts)
    return {name: of_series(frame[name], lines) for name in names}


def _flat_names(path: Path) -> list[str]:
    """Names of the plain columns of a Parquet file, those in structs and lists too."""
    file = parquet_file(path)
    names = list(file.schema_arrow.names)
    return names if len({*names}) < len(names) else list(flat_names(file, path))


def unpacked(path: Path) -> dict[str, RawColumn]:
    """Columns of a Parquet file; fields of structs by dotted names, lists of one length by number.

    Raises
    ------
    DataError
        A list whose length changes, or another type that is no number, text or time.
    """
    if not parquet_file(path).metadata.num_rows:
        raise DataError("no rows", file=path, remedy="record the log again")
    return dict(raw_columns(path, _flat_names(path), ()))


def write_parquet(columns: pd.DataFrame | Mapping[str, object], path: Path) -> None:
    """Write a table, or columns (n,) by name, as Parquet: zstd, no index, repeatable bytes."""
    import pandas as pd
    import pyarrow as pa
    import pyarrow.parquet as pq

    data = columns if isinstance(columns, pd.DataFrame) else pd.DataFrame(dict(columns))
    pq.write_table(
        pa.Table.from_pandas(data, preserve_index=False).replace_schema_metadata(None),
        path,
        compression="zstd",
    )


def write_csv(columns: Mapping[str, object], path: Path) -> None:
    """Write columns (n,) by name as CSV."""
    import pandas as pd

    pd.DataFrame(dict(columns)).to_csv(path, index=False)


def write_parquet_pieces(pieces: Iterable[Mapping[str, object]], path: Path) -> int:
    """Write columns that come piece by piece, a row group each; the first piece sets the types.

    Returns
    -------
    rows
        How many were written.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

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


def parquet_file(path: Path) -> pq.ParquetFile:
    """An opened Parquet file; one line where it is none."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        return pq.ParquetFile(path, pre_buffer=False)
    except (pa.ArrowException, OSError) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise
        raise DataError(
            "not a readable Parquet file (truncated?)", file=path, remedy="copy it again"
        ) from None


def of_arrow(column: pa.ChunkedArray, name: str, path: Path) -> RawColumn:
    """A Parquet column by its declared type."""
    import pyarrow as pa

    if pa.types.is_dictionary(column.type):
        column = column.cast(column.type.value_type)
    kind = column.type
    empty = np.asarray(column.is_null().to_numpy(zero_copy_only=False), dtype=np.bool_)
    if pa.types.is_integer(kind) and empty.any():
        _exact(column, name, path)
    if pa.types.is_integer(kind) or pa.types.is_floating(kind):
        return RawColumn("number", column.to_numpy(zero_copy_only=False), empty)
    if pa.types.is_decimal(kind):
        return RawColumn("number", column.cast(pa.float64()).to_numpy(zero_copy_only=False), empty)
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        counted = column.cast(pa.int64()).fill_null(0).to_numpy(zero_copy_only=False)
        values = _nanoseconds(counted, _NANOSECONDS[kind.unit], name, path)
        return RawColumn("stamp" if pa.types.is_timestamp(kind) else "duration", values, empty)
    if pa.types.is_boolean(kind):
        filled = column.fill_null(False)
        return RawColumn("truth", filled.to_numpy(zero_copy_only=False), empty)
    if pa.types.is_string(kind) or pa.types.is_large_string(kind) or pa.types.is_string_view(kind):
        return RawColumn("text", np.array(column.to_pylist(), dtype=object), empty)
    if pa.types.is_null(kind):
        return RawColumn("number", np.full(len(column), np.nan), empty)
    raise DataError(
        f"holds the type {short(str(kind))}, which is neither a number nor a text nor a time",
        file=path, column=name, remedy="export plain numbers, one column each",
    )  # fmt: skip


def _exact(column: pa.ChunkedArray, name: str, path: Path) -> None:
    """Refuse integers beside empty cells that a float would round."""
    values = column.fill_null(0).to_numpy(zero_copy_only=False)
    large = (values > _EXACT) | (values < -_EXACT if values.dtype.kind == "i" else False)
    if large.any():
        at = int(np.argmax(large))
        raise DataError(
            "an integer above 2^53 in a column with empty cells", file=path, column=name,
            row=f"row {at + 1}", value=int(values[at]), remedy="fill in the empty cells",
        )  # fmt: skip


def _nanoseconds(
    counted: NDArray[np.int64], factor: int, name: str, path: Path
) -> NDArray[np.int64]:
    largest = np.iinfo(np.int64).max // factor
    wide = (counted > largest) | (counted < -largest)
    if wide.any():
        at = int(np.argmax(wide))
        raise DataError(
            "a date outside the years 1678 to 2262", file=path, column=name,
            row=f"row {at + 1}", remedy="correct the stamp",
        )  # fmt: skip
    return counted * factor


def of_series(column: pd.Series[Any], lines: IntArray | None = None) -> RawColumn:
    """A CSV column by what all its cells look like."""
    import pandas as pd

    empty = np.asarray(column.isna().to_numpy(), dtype=np.bool_)
    if pd.api.types.is_bool_dtype(column):
        return RawColumn("truth", column.to_numpy(dtype=bool), empty, lines)
    if pd.api.types.is_numeric_dtype(column):
        return RawColumn("number", column.to_numpy(), empty, lines)
    words = column.to_numpy(dtype=object)
    return RawColumn("text", words, empty, lines)
