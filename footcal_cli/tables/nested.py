"""Parquet files with structs and lists as plain columns."""

from __future__ import annotations

from pathlib import Path

from footcal_cli.errors import DataError
from footcal_cli.tables.logfiles import of_arrow, parquet_file
from footcal_cli.tables.rawcolumn import RawColumn


def unpacked(path: Path) -> dict[str, RawColumn]:
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
    return raw
