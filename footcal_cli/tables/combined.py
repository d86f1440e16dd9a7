"""One column made of two: a sum, a difference, a quotient, seconds and nanoseconds.

Room: tables; asked by sources.
"""

from __future__ import annotations

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
    for one, name in ((raw, place.column), (by, place.over)):
        if one.kind != "number":
            raise DataError("holds no numbers", file=path, column=name,
                            remedy="correct `over` in [columns]")  # fmt: skip
    size = by.values.astype(np.float64)
    empty = raw.empty | by.empty | (size == 0.0)
    values = raw.values.astype(np.float64) / np.where(empty, np.nan, size)
    return replace(raw, values=values, empty=empty)


def plus(
    raw: RawColumn, more: RawColumn, place: ForeignColumn, other: tuple[str, str], path: Path
) -> RawColumn:
    """A column with another one, in a unit of its own, on top; an empty cell adds nothing."""
    column, unit = other
    for one, name in ((raw, place.column), (more, column)):
        if one.kind != "number":
            raise DataError("holds no numbers", file=path, column=name,
                            remedy="correct `plus` in [columns]")  # fmt: skip
    change = conversion(unit, place.unit or unit, 1.0)
    added = np.where(more.empty, 0.0, change(more.values.astype(np.float64)))
    values = np.where(raw.empty, 0.0, raw.values.astype(np.float64)) + added
    return replace(raw, values=values, empty=raw.empty & more.empty)


def minus(raw: RawColumn, less: RawColumn, place: ForeignColumn, path: Path) -> RawColumn:
    """A column less another one in the same unit; empty where either is."""
    for one, name in ((raw, place.column), (less, place.minus)):
        if one.kind != "number":
            raise DataError("holds no numbers", file=path, column=name,
                            remedy="correct `minus` in [columns]")  # fmt: skip
    empty = raw.empty | less.empty
    values = raw.values.astype(np.float64) - np.where(less.empty, 0.0, less.values.astype(float))
    return replace(raw, values=values, empty=empty)
