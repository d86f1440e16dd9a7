"""Where columns come from: the file, files beside it, its name, or the recipe alone."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.errors import DataError, UsageError, nearest
from footcal_cli.tables.canonical import canonical
from footcal_cli.tables.cells import cell_of, held, joined_texts
from footcal_cli.tables.columns import Column
from footcal_cli.tables.combined import divided, minus, plus, with_nanoseconds
from footcal_cli.tables.logfiles import column_names
from footcal_cli.tables.longfiles import columns_of
from footcal_cli.tables.rawcolumn import RawColumn, counted
from footcal_cli.tables.reading import ForeignColumn, Join, Reading
from footcal_cli.tables.registers import with_high_word
from footcal_cli.tables.textfiles import called_as

_TIME = Column("time_s", "time stamp")
_TOPIC_S = 0.1
"""How far the value of another topic may be from a row."""
_TIMES = ("time_s", "time_ms", "time_us", "time_ns")


def source_names(path: Path, reading: Reading) -> list[str]:
    """Columns of a log and of the files joined to it, these as ``<stem>.<column>``.

    A file whose stem is the log's, as ``walk.com`` next to ``walk.lsole``, is called by its name.
    """
    names = column_names(path, reading.layout)
    for join in reading.joins:
        own = source_names(join.path, join.reading)
        names += [before + name for before in _before(path, join.path) for name in own]
    return names


def _before(path: Path, joined: Path) -> list[str]:
    """What stands before the columns of a joined file."""
    alike = stem_of(path) == stem_of(joined)
    return [f"{stem_of(joined)}.", *([f"{joined.name}."] if alike else [])]


def row_time(reading: Reading) -> ForeignColumn | None:
    """The place of time stamps that count the rows of a file without any."""
    return None if reading.rate_hz is None else ForeignColumn()


def source_columns(
    path: Path, reading: Reading, places: Mapping[str, ForeignColumn], texts: frozenset[str]
) -> dict[str, RawColumn]:
    """Raw columns by canonical name.

    Parameters
    ----------
    path, reading
        The log and how it is read.
    places
        Canonical name -> where it is found.
    texts
        Canonical names of texts.

    Raises
    ------
    DataError
        The file cannot be read to its end, or a pattern finds nothing.
    """
    own = set(column_names(path, reading.layout))
    wanted = {p.column for p in places.values() if p.in_file}
    wanted |= {p.nanoseconds for p in places.values() if p.nanoseconds}
    wanted |= {p.high_word for p in places.values() if p.high_word}
    wanted |= {p.over for p in places.values() if p.over}
    wanted |= {p.followed_by for p in places.values() if p.followed_by}
    conditions = {name for p in places.values() for name in p.only_where}
    added = {name for p in places.values() for name in p.plus}
    taken = {p.minus for p in places.values() if p.minus}
    wanted |= conditions | added | taken
    names = {*source_names(path, reading)}
    for key, asked in {"only_where": conditions, "plus": added, "minus": taken}.items():
        if unknown := asked - names:
            raise DataError(
                f"missing column '{min(unknown)}' that {key} names"
                f"{nearest(min(unknown), sorted(own))}", file=path,
                remedy=f"correct {key} in [columns]",
            )  # fmt: skip
    if reading.rows_of and reading.rows_of not in own:
        raise DataError(
            f"missing column '{reading.rows_of}' that rows_of names"
            f"{nearest(reading.rows_of, sorted(own))}", file=path,
            remedy="correct rows_of in [[files]]", foreign=True,
        )  # fmt: skip
    wanted |= {reading.rows_of} - {""}
    here = sorted(wanted & own) or [column_names(path, reading.layout)[0]]
    as_text = {
        p.column for name, p in places.items() if name in texts or p.pattern or p.names
    } & own  # fmt: skip
    as_text |= conditions | {p.followed_by for p in places.values()} & own
    raw = dict(columns_of(path, here, as_text, reading.layout))
    rows = len(raw[here[0]].values)
    if rows == 0:
        raise DataError("no rows", file=path, remedy="record the log again")
    if reading.rows_of:
        raw = _of_one_topic(path, reading, raw)
        rows = len(raw[here[0]].values)
    lines = raw[here[0]].lines
    if wanted - own:
        for join in reading.joins:
            raw |= _joined(path, reading, join, wanted - own, rows, conditions)
    found = {}
    for name, place in places.items():
        if place.in_file:
            found[name] = cell_of(joined_texts(raw, place, path), place, reading, path)
            if place.only_where:
                found[name] = _only_where(found[name], raw, place)
            for other, unit in place.plus.items():
                more = cell_of(raw[other], place, reading, path)
                found[name] = plus(found[name], more, place, (other, unit), path)
            if place.minus:
                found[name] = minus(found[name], cell_of(raw[place.minus], place, reading, path),
                                     place, path)  # fmt: skip
            if place.high_word:
                both = (place.column, place.high_word)
                found[name] = with_high_word(found[name], raw[place.high_word], both, path)
            if place.over:
                found[name] = divided(found[name], raw[place.over], place, path)
            if place.nanoseconds:
                found[name] = with_nanoseconds(found[name], raw[place.nanoseconds], place, path)
        elif place.value is None and place.file_name is None:
            assert reading.rate_hz is not None, "only counted time has no source"
            seconds = counted(rows, reading.rate_hz, reading.layout.row_lasts)
            found[name] = RawColumn("number", seconds, np.zeros(rows, bool), lines)
        else:
            said = _said(place, path)
            said = f"{said:g}" if name in texts and isinstance(said, float) else said
            found[name] = _constant(said, rows, lines)  # leg 0 is called 0
    return _of_these(found, raw, places, path)


def _of_one_topic(
    path: Path, reading: Reading, raw: Mapping[str, RawColumn]
) -> dict[str, RawColumn]:
    """The rows of one topic, the columns of others brought to its times."""
    kept = ~raw[reading.rows_of].silent
    if not kept.any():
        raise DataError("no row has a value", file=path, column=reading.rows_of,
                        remedy="correct rows_of in [[files]]")  # fmt: skip
    stamps = time_of(path, replace(reading, joins=(), rows_of=""))
    return at_rows(raw, kept, stamps, _TOPIC_S)


def at_rows(
    raw: Mapping[str, RawColumn], kept: NDArray[np.bool_], stamps: NDArray[np.float64],
    tolerance_s: float,
) -> dict[str, RawColumn]:  # fmt: skip
    """Columns at some rows of their table; empty cells are filled in between their neighbours.

    Parameters
    ----------
    raw
        Columns by name, n rows each.
    kept, stamps
        The rows, and the time of each row, shape (n,).
    tolerance_s
        Farther from a value of its own, a cell stays empty.
    """
    found = {}
    for name, column in raw.items():
        lines = None if column.lines is None else column.lines[kept]
        there = np.flatnonzero(~column.silent)
        if not column.silent[kept].any() or not there.size:
            values, empty = column.values[kept], column.empty[kept]
            found[name] = RawColumn(column.kind, values, empty, lines)
            continue
        order = there[np.argsort(stamps[there], kind="stable")]
        join = Join(Path(), Reading(), tolerance_s=tolerance_s)
        filled = _at_times(stamps[kept], stamps[order], column, order, join)
        found[name] = replace(filled, lines=lines)
    return found


def _said(place: ForeignColumn, path: Path) -> str | float:
    """A value of the recipe or of the file's name."""
    if place.value is not None:
        return place.value
    found = re.search(place.file_name or "", called_as(path, place.file_name or ""))
    if found is None:
        raise DataError(
            "the file's name is not as [columns] says", file=path, value=place.file_name,
            remedy="correct the regular expression `file_name`, or the name",
        )  # fmt: skip
    said = found.group(1)
    return place.names.get(said, said)


def _constant(value: str | float, rows: int, lines: NDArray[np.int64] | None) -> RawColumn:
    kind: Any = "text" if isinstance(value, str) else "number"
    filled = np.full(rows, value, dtype=object if isinstance(value, str) else np.float64)
    return RawColumn(kind, filled, np.zeros(rows, dtype=bool), lines)


def _only_where(
    raw: RawColumn, columns: Mapping[str, RawColumn], place: ForeignColumn
) -> RawColumn:
    """Numbers that are 0 where another column does not say a certain text.

    Where empty cells of the numbers mean what stands above them, so do those of that column.
    """
    elsewhere = np.zeros(len(raw.values), dtype=bool)
    nothing = raw.empty.copy()
    for name, said in place.only_where.items():
        said_by = _said_by(columns[name], place)
        words = said_by.values.tolist()
        elsewhere |= np.array([str(word).strip() != said for word in words])
        nothing &= said_by.empty
    values = raw.values.copy()
    values[elsewhere & ~nothing] = "0" if raw.kind == "text" else 0
    return replace(raw, values=values, empty=raw.empty & ~elsewhere | nothing)


def _said_by(column: RawColumn, place: ForeignColumn) -> RawColumn:
    """A column of conditions; where a place is held, its empty cells mean what stands above."""
    return held(column) if place.held else column


def _of_these(
    found: Mapping[str, RawColumn], raw: Mapping[str, RawColumn],
    places: Mapping[str, ForeignColumn], path: Path,
) -> dict[str, RawColumn]:  # fmt: skip
    """Columns without the rows in which one of several conditions of `only_where` does not hold.

    A cell that one column says is loaded is read in every row; where it takes two (foot and cell)
    the other rows are readings of another foot's cell.
    """
    several = [place for place in places.values() if len(place.only_where) > 1]
    if not several:
        return dict(found)
    kept = np.logical_and.reduce([
        [str(word).strip() == said for word in _said_by(raw[name], place).values.tolist()]
        for place in several for name, said in place.only_where.items()
    ])  # fmt: skip
    if not kept.any():
        asked = ", ".join(f'{name} = "{said}"' for name, said in several[0].only_where.items())
        raise DataError(f"no row has {asked}", file=path, column=several[0].column,
                        remedy="correct only_where in [columns]")  # fmt: skip
    return {name: column.of_rows(kept) for name, column in found.items()}


def _joined(
    path: Path, reading: Reading, join: Join, wanted: set[str], rows: int, texts: set[str]
) -> dict[str, RawColumn]:
    """Columns of another file at the rows of this one, some of them as `texts`."""
    asked = {
        name: name.removeprefix(before) for before in _before(path, join.path) for name in wanted
        if name.startswith(before)
    }  # fmt: skip
    if not asked:
        return {}
    there = {
        name: ForeignColumn(column) for name, column in asked.items()
        if column in source_names(join.path, join.reading)
    }  # fmt: skip
    kept = _rows_meant(join)
    raw = source_columns(join.path, join.reading, there, frozenset(texts))
    raw = {name: column if kept is None else column.of_rows(kept) for name, column in raw.items()}
    if join.by == "row":
        short = [len(column.values) for column in raw.values()][:1]
        if short and short[0] != rows:
            raise DataError(
                f"{short[0]} rows, but {path.name} has {rows}", file=join.path,
                remedy="join them by time, or take the extra rows out",
            )  # fmt: skip
        return raw
    ours = time_of(path, reading)
    theirs = time_of(join.path, join.reading) + join.offset_s
    theirs = theirs if kept is None else theirs[kept]
    order = np.argsort(theirs, kind="stable")
    found = {
        name: _at_times(ours, theirs[order], column, order, join) for name, column in raw.items()
    }
    if all(column.empty.all() for column in found.values()):
        raise DataError(
            f"its stamps ({theirs.min():.9g} to {theirs.max():.9g} s) and those of {path.name} "
            f"({ours.min():.9g} to {ours.max():.9g} s) do not overlap", file=join.path,
            remedy="give offset_s of the join, which is added to this file's stamps",
        )  # fmt: skip
    return found


def _rows_meant(join: Join) -> NDArray[np.bool_] | None:
    """Rows of a joined file that `only_where` leaves, shape (n,); None for all."""
    if not join.only_where:
        return None
    asked = {name: ForeignColumn(name) for name in join.only_where}
    found = source_columns(join.path, replace(join.reading, joins=()), asked, frozenset(asked))
    kept = np.logical_and.reduce([
        [str(word).strip() == join.only_where[name] for word in column.values.tolist()]
        for name, column in found.items()
    ])  # fmt: skip
    if not kept.any():
        said = ", ".join(f'{name} = "{word}"' for name, word in join.only_where.items())
        raise DataError(f"no row has {said}", file=join.path, column=next(iter(asked)),
                        remedy="correct only_where of join in [[files]]")  # fmt: skip
    return np.asarray(kept)


def _at_times(
    ours: NDArray[np.float64], theirs: NDArray[np.float64], raw: RawColumn,
    order: NDArray[np.int64], join: Join,
) -> RawColumn:  # fmt: skip
    after = np.clip(np.searchsorted(theirs, ours, side="right"), 0, theirs.size)
    before = np.clip(after - 1, 0, theirs.size - 1)
    after = np.clip(after, 0, theirs.size - 1)
    back, ahead = np.abs(ours - theirs[before]), np.abs(theirs[after] - ours)
    taken = before if join.how == "previous" else np.where(ahead < back, after, before)
    far = np.where(taken == before, back, ahead) > join.tolerance_s
    far |= np.minimum(back, ahead) < join.apart_s
    if join.how == "previous":
        far |= ours < theirs[0]
    values = raw.values[order]
    if join.how == "interpolate" and raw.kind == "number":
        between = np.interp(ours, theirs, values.astype(np.float64))
        return RawColumn("number", np.where(far, np.nan, between), far)
    empty = far | raw.empty[order][taken]
    chosen = values[taken]
    if raw.kind == "number" and empty.any():
        chosen = np.where(empty, np.nan, chosen.astype(np.float64))
    return RawColumn(raw.kind, chosen, empty)


def time_of(path: Path, reading: Reading) -> NDArray[np.float64]:
    """Time stamps of a file in s, shape (n,).

    Raises
    ------
    UsageError
        The file has none and its rate is not given.
    """
    names = source_names(path, replace(reading, joins=()))
    place = reading.columns.get("time_s")
    if place is None or (place.in_file and place.column not in names):
        own = next((name for name in _TIMES if name in names), None)
        place = ForeignColumn(own, own.rsplit("_", 1)[-1]) if own else row_time(reading)
    if place is None:
        raise UsageError(
            f"no time stamps to join by{nearest('time_s', names)}", file=path,
            remedy="map time_s in the file's own columns in [[files]], or give its rate_hz",
        )  # fmt: skip
    raw = source_columns(path, replace(reading, joins=()), {"time_s": place}, frozenset())
    values, _ = canonical(raw["time_s"], _TIME, place, 1.0, path)
    return values.astype(np.float64)


def stem_of(path: Path) -> str:
    """A log's name without its ending."""
    return path.name.removesuffix(".gz").rsplit(".", 1)[0]
