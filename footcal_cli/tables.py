"""Logs as tables: the column contract applied to a file, without guessing.

A table type (`footcal_cli.columns`) declares its columns in canonical units; a file may hold a
column under a foreign name or in another unit, said by the recipe's ``[columns]`` or by a unit
suffix (``load_kg`` for ``load_n``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.columns import UNIT_SUFFIXES, Column, ForeignColumn, TableType, converts
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.errors import DataError, UsageError, nearest
from footcal_cli.logfiles import column_names, digest, raw_columns, write_csv, write_parquet
from footcal_cli.units import Conversion, conversion, unit_factor
from footcal_cli.values import durations, numbers, seconds, stamps, texts

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "ReadColumn", "Table", "column_names", "digest", "read_table", "refusal_of", "unit_factor",
    "write_csv", "write_parquet",
]  # fmt: skip


@dataclass(frozen=True)
class ReadColumn:
    """How one column of a file was read.

    Parameters
    ----------
    name, source
        Canonical name, and the file's own.
    unit
        What the file's numbers were taken for, in full; empty for texts and bare numbers.
    canonical_unit
        Unit of the canonical column.
    factor
        Canonical units in one of the file's; None where nothing was multiplied.
    as_written, as_read
        Smallest and largest value before and after; None for texts.
    """

    name: str
    source: str
    unit: str
    canonical_unit: str
    factor: float | None
    as_written: tuple[float, float] | None
    as_read: tuple[float, float] | None

    @property
    def converted(self) -> bool:
        """Whether another unit became the canonical one."""
        return self.factor is not None


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
    read_as
        Columns that stand under another name or in another unit in the file.
    findings
        What the choice of columns left to say.
    """

    data: pd.DataFrame
    path: Path
    digest: str
    source: Mapping[str, str] = field(default_factory=dict)
    read_as: tuple[ReadColumn, ...] = ()
    findings: tuple[Finding, ...] = ()

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


def read_table(
    path: Path,
    table: TableType,
    columns: Mapping[str, ForeignColumn] | None = None,
    *,
    gravity_mps2: float,
) -> Table:
    """Read the columns of a table type from CSV, CSV.gz or Parquet, in canonical units.

    Parameters
    ----------
    path, table
        The file, and the columns wanted of it.
    columns
        Where columns stand under foreign names or in other units.
    gravity_mps2
        With which masses weigh.

    Raises
    ------
    UsageError
        The file does not exist, or a unit is unknown.
    DataError
        The file is empty, truncated, lacks a column or has it twice, or holds a cell that is not a
        number.
    """
    header = column_names(path)
    places = _places(table, header, columns or {}, path)
    import pandas as pd

    wanted = {c.name: c for c in table.columns}
    as_text = {p.column for name, p in places.found.items() if wanted[name].kind == "text"}
    raw = raw_columns(path, sorted({p.column for p in places.found.values()}), as_text)
    if any(len(column.values) == 0 for column in raw.values()):
        raise DataError("no rows", file=path, remedy="record the log again")
    data: dict[str, NDArray[Any]] = {}
    read_as: list[ReadColumn] = []
    for name, place in places.found.items():
        spec, column = wanted[name], raw[place.column]
        renamed = place.column != name
        if spec.kind == "text":
            data[name] = texts(column, spec, place.column, path)
            if renamed:
                read_as.append(ReadColumn(name, place.column, "text", "", None, None, None))
            continue
        nanoseconds = stamps(column, spec, place.column, place.unit, path)
        spans = durations(column, spec, place.column, path)
        if nanoseconds is not None:
            spans = seconds(nanoseconds)
        if spans is not None:
            data[name] = spans
            said = {"duration": "duration", "number": "nanosecond"}.get(column.kind)
            said = said or "date, as seconds since 1970 UTC"
            span = _range(data[name])
            read_as.append(ReadColumn(name, place.column, said, "s", None, None, span))
            continue
        values = numbers(column, spec, place.column, place.unit, path)
        change = _conversion(spec, place, gravity_mps2, path)
        data[name] = values if change is None else change(values.astype(np.float64))
        if renamed or change is not None:
            read_as.append(_read_as(spec, place, change, values, data[name]))
    source = {name: place.column for name, place in places.found.items()}
    return Table(
        pd.DataFrame(data), path, digest(path), source, tuple(read_as),
        tuple(_passed_over(places, path)),
    )  # fmt: skip


def refusal_of(
    path: Path, table: TableType, columns: Mapping[str, ForeignColumn]
) -> DataError | None:
    """Why a file is no log of a table type (the first column it lacks), None where it is one."""
    missing = _looked_up(table, column_names(path), columns, path).missing
    return missing[0] if missing else None


@dataclass(frozen=True)
class _Places:
    """Where the columns of a table type stand in a file.

    `twice` holds columns that stand there under several names, `passed_over` those whose name the
    recipe gives although the file has the canonical one too.
    """

    found: dict[str, ForeignColumn]
    missing: list[DataError]
    twice: dict[str, list[str]]
    passed_over: dict[str, list[str]]


def _places(
    table: TableType, header: Sequence[str], columns: Mapping[str, ForeignColumn], path: Path
) -> _Places:
    """`_looked_up`, refusing what is missing or ambiguous."""
    places = _looked_up(table, header, columns, path)
    if places.missing:
        raise places.missing[0]
    for name, names in places.twice.items():
        raise DataError(
            f"{name} stands there more than once: {', '.join(names)}", file=path, column=names[0],
            remedy=f"say which one in [columns], {name} = '{names[0]}', or take one out",
        )  # fmt: skip
    return places


def _looked_up(
    table: TableType, header: Sequence[str], columns: Mapping[str, ForeignColumn], path: Path
) -> _Places:
    """Find every column: mapped by the recipe, by its name, or by its stem and a unit."""
    places = _Places({}, [], {}, {})
    known = set(header)
    for spec in table.columns:
        own = _own_names(spec, header, known)
        if spec.name in columns:
            place = columns[spec.name]
            if place.column in known:
                places.found[spec.name] = ForeignColumn(place.column, place.unit or spec.unit)
                others = [name for name in own if name != place.column]
                if others:
                    places.passed_over[spec.name] = others
            elif not spec.optional:
                places.missing.append(DataError(
                    f"missing column '{place.column}' that [columns] names for {spec.name}"
                    f"{nearest(place.column, header)}",
                    file=path, remedy=f"the file has: {_some(header)}",
                ))  # fmt: skip
            continue
        if len(own) > 1:
            places.twice[spec.name] = list(own)
        if own:
            name = next(iter(own))
            places.found[spec.name] = ForeignColumn(name, own[name])
        elif not spec.optional:
            places.missing.append(DataError(
                f"missing column '{spec.name}' ({spec.meaning}){nearest(spec.name, header)}",
                file=path,
                remedy=f"map it in the recipe's [columns]; the file has: {_some(header)}",
            ))  # fmt: skip
    return places


def _own_names(spec: Column, header: Sequence[str], known: set[str]) -> dict[str, str | None]:
    """Names in a file that are the canonical one, or its stem with another unit; with the unit."""
    own: dict[str, str | None] = {spec.name: spec.unit} if spec.name in known else {}
    if spec.suffix is None:
        return own
    stem = spec.name.removesuffix(spec.suffix)
    for suffix, unit in UNIT_SUFFIXES.items():
        name = stem + suffix
        # true forces of a cell (left_fl_n) are not its counts in another unit
        if name in known and name != spec.name and converts(suffix, spec.suffix):
            own[name] = unit
    return own


def _passed_over(places: _Places, path: Path) -> list[Finding]:
    return [
        Finding(
            "column_passed_over", "note", path.name,
            f"{name} was read from '{places.found[name].column}', as [columns] says; the file has "
            f"{', '.join(others)} too",
            "take the entry out of [columns] if the other one is meant",
        )
        for name, others in places.passed_over.items()
    ]  # fmt: skip


def _conversion(
    spec: Column, place: ForeignColumn, gravity_mps2: float, path: Path
) -> Conversion | None:
    """How a column's numbers become canonical ones; None where they are already."""
    if place.unit is None or place.unit == spec.unit:
        return None
    if spec.unit is None:
        raise UsageError(
            f"{spec.name} has no unit, but [columns] gives it '{place.unit}'", file=path,
            column=place.column, remedy="take the unit out",
        )  # fmt: skip
    try:
        change = conversion(place.unit, spec.unit, gravity_mps2)
    except UsageError as error:
        raise UsageError(
            error.problem, file=path, column=place.column, remedy=error.remedy
        ) from None
    same = change.slope == 1.0 and change.offset == 0.0 and not change.weighed
    return None if same else change


def _read_as(
    spec: Column,
    place: ForeignColumn,
    change: Conversion | None,
    written: NDArray[Any],
    read: NDArray[Any],
) -> ReadColumn:
    unit = place.unit or ""
    if change is not None:
        unit = change.source.name + (" (its weight)" if change.weighed else "")
    return ReadColumn(
        spec.name, place.column, unit, spec.unit or "",
        None if change is None else change.slope,
        _range(written), _range(read),
    )  # fmt: skip


def _range(values: NDArray[Any]) -> tuple[float, float] | None:
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else None


def _some(names: Sequence[str], at_most: int = 8) -> str:
    more = f" and {len(names) - at_most} more" if len(names) > at_most else ""
    return ", ".join(name[:40] for name in names[:at_most]) + more
