"""Rows of a log in which the cells carry nothing: zeros alone, and no part of a stand.

Room: tables; asked by table.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footcal_cli.errors import DataError, nearest
from footcal_cli.tables.columns import TableType
from footcal_cli.tables.logfiles import column_names
from footcal_cli.tables.longfiles import columns_of
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.reading import Reading


def zeros_apart(
    raw: Mapping[str, RawColumn], reading: Reading, table: TableType, path: Path
) -> Mapping[str, RawColumn]:
    """Columns of zeros in the rows that `zeros_where` names, of any other log in all others."""
    if not reading.zeros_where or reading.rows_of:
        return raw
    of_zeros = _rows_where(path, reading, reading.zeros_where)
    kept = of_zeros if table.name == "zeros" else ~of_zeros
    return {name: column.of_rows(kept) for name, column in raw.items()}


def _rows_where(
    path: Path, reading: Reading, asked: Mapping[str, str | tuple[str, ...]]
) -> NDArray[np.bool_]:
    """Rows of a log in which each of some columns holds one of its texts, or the number it is.

    Raises
    ------
    DataError
        The log lacks such a column, or has no row of one of the texts.
    """
    said = {name: (texts,) if isinstance(texts, str) else texts for name, texts in asked.items()}
    names = column_names(path, reading.layout)
    if unknown := {*said} - {*names}:
        raise DataError(
            f"missing column '{min(unknown)}' that zeros_where names"
            f"{nearest(min(unknown), names)}", file=path,
            remedy="correct zeros_where in [[files]]", foreign=True,
        )  # fmt: skip
    raw = columns_of(path, sorted(said), (), reading.layout)
    kept = np.ones(len(next(iter(raw.values())).values), dtype=bool)
    for name, texts in said.items():
        held = [_holds(raw[name], text) for text in texts]
        for text, own in zip(texts, held, strict=True):
            if not np.any(kept & own):
                raise _no_row(name, text, raw[name], path)
        kept &= np.logical_or.reduce(held)
    return kept


def _no_row(name: str, text: str, column: RawColumn, path: Path) -> DataError:
    words = sorted({str(word).strip() for word in column.values.tolist()})
    return DataError(
        f'no row has {name} = "{text}"{nearest(text, words)}', file=path, column=name,
        remedy="correct zeros_where in [[files]]",
    )  # fmt: skip


def _holds(column: RawColumn, text: str) -> NDArray[np.bool_]:
    try:
        number = float(text)
    except ValueError:
        number = np.nan
    if column.kind == "number":
        return np.asarray(column.values == number)
    said = np.array([str(word).strip() for word in column.values.tolist()])
    return np.asarray((said == text) & ~column.empty)
