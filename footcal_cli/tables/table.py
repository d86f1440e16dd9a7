"""Logs as tables: the column contract applied to a file, without guessing.

A table type (`footcal_cli.tables.columns`) declares its columns in canonical units; a file may hold
a column under a foreign name or in another unit, said by the recipe's ``[columns]`` or by a unit
suffix (``load_kg`` for ``load_n``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.errors import DataError, FootcalError
from footcal_cli.tables.canonical import ReadColumn, canonical, conversion_of
from footcal_cli.tables.columns import (
    AXIS_ANGLE,
    BODY_GRAVITY,
    MATRIX,
    QUATERNION,
    ROTVEC,
    RPY,
    XYZ,
    ZYZ,
    Column,
    TableType,
)
from footcal_cli.tables.logfiles import (
    column_names,
    digest,
    write_csv,
    write_parquet,
    write_parquet_pieces,
)
from footcal_cli.tables.longfiles import give_back, is_long, raw_pieces
from footcal_cli.tables.matrices import rotations_of_columns, with_feet_turned
from footcal_cli.tables.places import Places, every_entry, passed_over, places_of
from footcal_cli.tables.plates import add_cells, with_plates
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.reading import READ_AGAIN, ForeignColumn, Reading
from footcal_cli.tables.sources import source_columns
from footcal_cli.tables.values import narrowed
from footcal_cli.tables.world import TO_Z_UP, WorldUp, with_z_up
from footcal_cli.tables.zeros_apart import zeros_apart

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "ReadColumn", "Table", "column_names", "digest", "read_pieces", "read_table", "refusal_of",
    "write_csv", "write_parquet", "write_parquet_pieces",
]  # fmt: skip


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
    beside
        Files joined to it, with their SHA-256.
    """

    data: pd.DataFrame
    path: Path
    digest: str
    source: Mapping[str, str] = field(default_factory=dict)
    read_as: tuple[ReadColumn, ...] = ()
    findings: tuple[Finding, ...] = ()
    beside: Mapping[Path, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.data)

    def __contains__(self, name: object) -> bool:
        return name in self.data.columns

    def number(self, name: str) -> FloatArray:
        """One column as float64, shape (n,)."""
        return self.data[name].to_numpy(dtype=np.float64)

    def optional(self, name: str) -> FloatArray:
        """As `number`; NaN where the log does not have the column."""
        return self.number(name) if name in self else np.full(len(self), np.nan)

    def numbers(self, names: Sequence[str]) -> FloatArray:
        """Several columns as float64, shape (n, len(names))."""
        return self.data[list(names)].to_numpy(dtype=np.float64)

    def text(self, name: str) -> np.ndarray[Any, np.dtype[np.object_]]:
        """One column as strings, shape (n,)."""
        return self.data[name].astype(str).to_numpy(dtype=object)

    def continued_by(self, late: Table) -> Table:
        """Rows of another log of the same columns below those of this one."""
        import pandas as pd

        data = pd.concat([self.data, late.data[list(self.data.columns)]], ignore_index=True)
        beside = {**self.beside, **late.beside, late.path: late.digest}
        return replace(self, data=data, findings=(*self.findings, *late.findings), beside=beside)


def read_table(
    path: Path,
    table: TableType,
    columns: Mapping[str, ForeignColumn] | Reading | None = None,
    *,
    gravity_mps2: float,
) -> Table:
    """Read the columns of a table type from CSV, CSV.gz or Parquet, in canonical units.

    Parameters
    ----------
    path, table
        The file, and the columns wanted of it.
    columns
        Where columns stand under foreign names or in other units, or all that a recipe says of
        the file.
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
    reading = _reading(columns)
    table = with_plates(table, reading.plates)
    parts = [
        (places, zeros_apart(
            source_columns(path, reading, places.found, _texts(table)), reading, table, path
        )) for places in places_of(table, reading, path)
    ]  # fmt: skip
    beside = {join.path: digest(join.path) for join in reading.joins}
    read = _canonical(
        parts, table, path, digest(path), gravity_mps2, beside, reading.world_up,
        by_row=reading.wide_into == READ_AGAIN,
    )  # fmt: skip
    del parts
    if is_long(path):
        read = replace(read, data=narrowed(read.data))
        give_back()
    data, added = add_cells(read.data, reading.plates)
    return replace(read, data=data, read_as=(*read.read_as, *added))


def read_pieces(
    path: Path,
    table: TableType,
    columns: Mapping[str, ForeignColumn] | Reading | None = None,
    *,
    gravity_mps2: float,
) -> Iterator[Table]:
    """As `read_table`, some rows at a time, each piece with the digest of the whole file.

    A file that is no plain table by itself comes in one piece.

    Raises
    ------
    UsageError, DataError
        As `read_table`.
    """
    reading = _reading(columns)
    places = places_of(with_plates(table, reading.plates), reading, path)
    found = places[0].found
    own = {p.column for p in found.values()} <= set(column_names(path, reading.layout))
    bare = all(
        p.in_file
        and not (p.pattern or p.names or p.held or p.only_where or p.missing or p.followed_by)
        for p in found.values()
    )
    whole = len(places) > 1 or reading.plates or reading.zeros_where
    if whole or not (reading.layout.plain and own and bare):
        yield read_table(path, table, reading, gravity_mps2=gravity_mps2)
        return
    sha256 = digest(path)
    as_text = {found[name].column for name in _texts(table) & found.keys()}
    rows = 0
    try:
        for raw in raw_pieces(path, sorted({p.column for p in found.values()}), as_text):
            by_name = {name: raw[place.column] for name, place in found.items()}
            piece = _canonical(
                [(places[0], by_name)], table, path, sha256, gravity_mps2, {}, reading.world_up
            )
            rows += len(piece)
            yield piece
    except DataError:
        if rows:  # the piece does not know which row of the file it is
            read_table(path, table, columns, gravity_mps2=gravity_mps2)
        raise
    if not rows:
        raise DataError("no rows", file=path, remedy="record the log again")


def _texts(table: TableType) -> frozenset[str]:
    """Canonical names of the columns that are texts."""
    return frozenset(c.name for c in table.columns if c.kind == "text")


def _canonical(
    parts: Sequence[tuple[Places, Mapping[str, RawColumn]]], table: TableType, path: Path,
    sha256: str, gravity_mps2: float, beside: Mapping[Path, str], world_up: WorldUp, *,
    by_row: bool = False,
) -> Table:  # fmt: skip
    """Raw columns in canonical names and units, the entries of a wide file below each other.

    `by_row`: entry by entry within each row of the file, else all rows of an entry together.
    """
    import pandas as pd

    wanted = {c.name: c for c in table.columns}
    frames: list[pd.DataFrame] = []
    read_as: list[ReadColumn] = []
    findings: list[Finding] = []
    for places, raw in parts:
        data: dict[str, NDArray[Any]] = {}
        for name, place in places.found.items():
            data[name], read = canonical(raw[name], wanted[name], place, gravity_mps2, path)
            read_as += [read] if read is not None else []
        frame, lost = _with_readings(pd.DataFrame(data, copy=False), wanted, places, path)
        frames.append(_with_empty_plates(frame, wanted, path))
        findings += [*passed_over(places, path), *lost]
    frame = frames[0] if len(frames) == 1 else pd.concat(frames)
    if by_row:
        frame = frame.sort_index(kind="stable")
    if not isinstance(frame.index, pd.RangeIndex):
        frame = frame.reset_index(drop=True)
    if not len(frame):
        raise DataError("no rows", file=path, remedy="record the log again")
    source = {name: p.column or name for name, p in parts[0][0].found.items()}
    frame = with_attitude(with_feet_turned(frame, path), table, path, world_up)
    frame = with_z_up(frame, world_up)
    return Table(frame, path, sha256, source, tuple(read_as), tuple(findings), beside)


_HOLE = ("hole_x_m", "hole_y_m")


def _with_empty_plates(
    frame: pd.DataFrame, wanted: Mapping[str, Column], path: Path
) -> pd.DataFrame:
    """Rows whose load is zero stand at no hole: an empty cell is the foot's origin there."""
    for name in _HOLE:
        if name not in wanted or "load_n" not in frame or name not in frame:
            continue
        nowhere = frame[name].isna().to_numpy()
        lost = nowhere & (frame["load_n"].to_numpy() != 0.0)
        if lost.any():
            raise DataError(
                "empty cell or NaN where a weight lies", file=path, column=name,
                row=f"{int(np.flatnonzero(lost)[0]) + 1} of the table",
                remedy=f"say {wanted[name].meaning}, or write 0 as the load of an empty plate",
            )  # fmt: skip
        frame[name] = frame[name].fillna(0.0)
    return frame


def _with_readings(
    frame: pd.DataFrame, wanted: Mapping[str, Column], places: Places, path: Path
) -> tuple[pd.DataFrame, list[Finding]]:
    """Rows of a log that needs every reading, without those that the recipe says have none."""
    asked = [n for n in places.found if wanted[n].missing == "refuse" or n in _HOLE]
    needed = [n for n in asked if places.found[n].missing]
    nothing = frame[needed].isna().any(axis=1).to_numpy() if needed else np.zeros(0, dtype=bool)
    if not nothing.any():
        return frame, []
    said = ", ".join(dict.fromkeys(f"'{places.found[name].column}'" for name in needed))
    return frame[~nothing], [
        Finding(
            "rows_without_reading", "note", path.name,
            f"{nothing.sum()} of {nothing.size} rows have no value in {said} and are left out, as "
            "`missing` in [columns] says",
            "find out why nothing stands there if the rows mattered",
        )
    ]  # fmt: skip


def _reading(columns: Mapping[str, ForeignColumn] | Reading | None) -> Reading:
    return columns if isinstance(columns, Reading) else Reading(columns or {})


def refuse_wrong_units(
    places: Iterable[tuple[str, ForeignColumn]], gravity_mps2: float, recipe: Path | None
) -> None:
    """Refuse a recipe that gives a column a unit of another quantity, whether a log has it or not.

    Raises
    ------
    UsageError
        Names the column.
    """
    for name, place in places:
        conversion_of(Column(name, ""), place, gravity_mps2, recipe or Path())


def refusal_of(
    path: Path, table: TableType, columns: Mapping[str, ForeignColumn] | Reading
) -> FootcalError | None:
    """Why a file is no log of a table type (the first column it lacks), None where it is one."""
    reading = _reading(columns)
    for places in every_entry(with_plates(table, reading.plates), reading, path):
        if places.missing:
            return places.missing[0]
    return None


def with_attitude(
    frame: pd.DataFrame, table: TableType, path: Path, up: WorldUp = "+z"
) -> pd.DataFrame:
    """Fill in the quaternions of attitudes logged as angles, vectors or matrices.

    Raises
    ------
    DataError
        A matrix that is no rotation.
    """
    if "body_qw" not in {c.name for c in table.columns} or "body_qw" in frame:
        return frame
    from footcal_cli.core.spatial import (
        about_axes,
        quaternions_of,
        rotations_of_euler,
        rotations_of_gravity,
        rotations_of_rotvec,
        rotations_of_rpy,
    )

    forms: Mapping[tuple[str, ...], Callable[[FloatArray], FloatArray]] = {
        RPY: rotations_of_rpy,
        ROTVEC: rotations_of_rotvec,
        ZYZ: partial(rotations_of_euler, "ZYZ"),
        XYZ: partial(rotations_of_euler, "XYZ"),
        AXIS_ANGLE: lambda numbers: rotations_of_rotvec(about_axes(numbers)),
        # gravity points down whatever the log calls its axes
        BODY_GRAVITY: lambda numbers: TO_Z_UP[up].T @ rotations_of_gravity(numbers),
        MATRIX: lambda _: rotations_of_columns(frame, "body", path),
    }
    form = next((names for names in forms if set(names) <= set(frame.columns)), None)
    if form is None:
        return frame
    numbers = frame[list(form)].to_numpy(dtype=np.float64)
    rotations = forms[form](numbers)
    return frame.assign(**dict(zip(QUATERNION, quaternions_of(rotations).T, strict=True)))
