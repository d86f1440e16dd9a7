"""One column made of two: a sum, a difference, a quotient, seconds and nanoseconds.

Room: tables; asked by sources.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.reading import ForeignColumn
from footcal_cli.tables.units import conversion


def with_nanoseconds(
    whole: RawColumn, rest: RawColumn, place: ForeignColumn, path: Path
) -> RawColumn:
    """Whole seconds and the nanoseconds beside them as one stamp in integer nanoseconds."""
    for raw, column in ((whole, place.column), (rest, place.nanoseconds)):
        if raw.kind != "number" or raw.values.dtype.kind not in "iu":
            raise DataError(
                "holds no whole numbers of seconds or nanoseconds", file=path, column=column,
                remedy="take `nanoseconds` out of [columns]",
            )  # fmt: skip
    stamps = whole.values.astype(np.int64) * 10**9 + rest.values.astype(np.int64)
    return replace(whole, kind="stamp", values=stamps, empty=whole.empty | rest.empty)


def divided(raw: RawColumn, by: RawColumn, place: ForeignColumn, path: Path) -> RawColumn:
    """A column by another one; empty where that is nought."""
    _refuse_texts(((raw, place.column), (by, place.over)), "over", path)
    size = by.values.astype(np.float64)
    empty = raw.empty | by.empty | (size == 0.0)
    values = raw.values.astype(np.float64) / np.where(empty, np.nan, size)
    return replace(raw, values=values, empty=empty)


def plus(
    raw: RawColumn, more: RawColumn, place: ForeignColumn, other: tuple[str, str], path: Path
) -> RawColumn:
    """A column with another one, in a unit of its own, on top; an empty cell adds nothing."""
    column, unit = other
    _refuse_texts(((raw, place.column), (more, column)), "plus", path)
    change = conversion(unit, place.unit or unit, 1.0)
    added = np.where(more.empty, 0.0, change(more.values.astype(np.float64)))
    values = np.where(raw.empty, 0.0, raw.values.astype(np.float64)) + added
    return replace(raw, values=values, empty=raw.empty & more.empty)


def minus(raw: RawColumn, less: RawColumn, place: ForeignColumn, path: Path) -> RawColumn:
    """A column less another one in the same unit; empty where either is."""
    _refuse_texts(((raw, place.column), (less, place.minus)), "minus", path)
    empty = raw.empty | less.empty
    values = raw.values.astype(np.float64) - np.where(less.empty, 0.0, less.values.astype(float))
    return replace(raw, values=values, empty=empty)


def _refuse_texts(columns: Iterable[tuple[RawColumn, str]], key: str, path: Path) -> None:
    """Refuse a column that holds no numbers, by its name and the key that asks for them."""
    for raw, name in columns:
        if raw.kind != "number":
            raise DataError("holds no numbers", file=path, column=name,
                            remedy=f"correct `{key}` in [columns]")  # fmt: skip
