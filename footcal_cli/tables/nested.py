"""Structs and lists of Parquet files as plain columns: fields by dotted names, lists by number."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from footcal_cli.errors import DataError

if TYPE_CHECKING:  # imported where they are used: a refusal waits for neither
    import pyarrow as pa
    import pyarrow.parquet as pq


def flat_names(file: pq.ParquetFile, path: Path) -> dict[str, str]:
    """Names of plain columns -> the column of the file that holds each."""
    import pyarrow as pa

    found: dict[str, str] = {}
    for name in file.schema_arrow.names:
        if pa.types.is_nested(file.schema_arrow.field(name).type) and file.metadata.num_rows:
            column = file.read_row_group(0, columns=[name]).column(0)
            found |= {flat: name for flat, _ in flattened(name, column, path)}
        else:
            found[name] = name
    return found


def flattened(name: str, column: pa.ChunkedArray, path: Path) -> list[tuple[str, pa.ChunkedArray]]:
    """Plain columns of one column, by name: fields of structs, and lists of one length.

    Raises
    ------
    DataError
        A list whose length changes.
    """
    import pyarrow as pa

    flat: list[tuple[str, pa.ChunkedArray]] = []
    waiting = [(name, column)]
    while waiting:
        name, column = waiting.pop(0)
        kind = column.type
        if pa.types.is_struct(kind):
            fields = [kind.field(i).name for i in range(kind.num_fields)]
            parts = zip(fields, column.flatten(), strict=True)
            waiting = [*((f"{name}.{field}", part) for field, part in parts), *waiting]
        elif _is_list(kind):
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
            flat.append((name, column))
    return flat


def _is_list(kind: pa.DataType) -> bool:
    """Whether a type is one of the lists."""
    import pyarrow as pa

    return bool(
        pa.types.is_list(kind) or pa.types.is_large_list(kind) or pa.types.is_fixed_size_list(kind)
    )
