"""What each column of a log is taken for, by its name and by its numbers."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.readings import lost_sign, lost_sign_by_load, signed, straightness
from footcal_cli.sniff.behind_axes import without_words_behind
from footcal_cli.sniff.clocks import (
    TICKS,
    even,
    first_in_time,
    increases,
    nearly_increases,
    noted_in_seconds,
    one_clock,
    one_time,
    rate_of,
    restarts,
    seconds_apart,
    since_1970,
    ticks,
    unwrapped_counter,
    without_orders,
)
from footcal_cli.sniff.derived import one_statistic, without_derived
from footcal_cli.sniff.flight import with_flight_angles
from footcal_cli.sniff.frames import in_frames
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, Sure, numbers_of
from footcal_cli.sniff.lettered import with_lettered_cells
from footcal_cli.sniff.motors import without_supply
from footcal_cli.sniff.names import NameGuess, name_guess, words_of
from footcal_cli.sniff.pivots import pivot_of, said_once
from footcal_cli.sniff.registers import joined_registers
from footcal_cli.sniff.rounds import only_numbers, with_rounds, with_stances
from footcal_cli.sniff.silent import MEASURED, no_reading
from footcal_cli.sniff.spoken_labels import said_between
from footcal_cli.sniff.text import TextGuess, guess_text
from footcal_cli.sniff.texts import (
    FEW,
    numbers_as_labels,
    one_after_the_other,
    part_of_the_words,
    taking_turns,
    text_column,
    units_beside,
)
from footcal_cli.sniff.titles import said_by_names
from footcal_cli.sniff.topics import stamps_of, topic
from footcal_cli.sniff.units import LOADS, NO_READING, SHARES, degrees, known_unit
from footcal_cli.sniff.units_first import with_units_first
from footcal_cli.sniff.vocabulary import COUNTED, NUMBERS, OF_A_ROW
from footcal_cli.sniff.warmth import with_temperatures
from footcal_cli.tables.carried import ADDED, REMOVED
from footcal_cli.tables.logfiles import column_names, is_parquet, raw_columns
from footcal_cli.tables.pivot import labels_of, own_names, pivoted_names
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.reading import Layout
from footcal_cli.tables.sources import at_rows
from footcal_cli.tables.units import TIMES

_NICE_STEPS, _OFTEN = 1e-6, 0.5
_LEAST_ROWS, _LARGEST, _STRAIGHT = 5, 1e5, 0.99
_COUNTS_UP_TO = 100
"""How far a column that numbers rows or poses may count, in rows."""


def guess_file(path: Path) -> FileGuess:
    """Look at one log.

    Raises
    ------
    DataError
        It is no table of numbers.
    """
    text = TextGuess(Layout()) if is_parquet(path) else guess_text(path)
    found = _looked_at(path, text)
    if ADDED not in text.layout.carried or REMOVED in text.layout.carried:
        return found
    # what was only ever added may have been each time what lay there then: the readings say which
    instead = replace(text.layout, carried=text.layout.carried.replace(f"(?P<{ADDED}", "(?P<"))
    other = _looked_at(path, replace(text, layout=instead))
    return other if _straight(other) > _straight(found) else found


def as_it_stands(file: FileGuess) -> FileGuess:
    """A table whose rows were turned into one per sample, row by row."""
    whole = file.layout.pivot is None
    return file if whole else _looked_at(file.path, guess_text(file.path), turn=False)


def _straight(file: FileGuess) -> float:
    """How much of a reading's variance a load explains at most."""
    most = 0.0
    for load in file.of("load"):
        for cell in file.of("reading", "unknown"):
            x, y = load.values, cell.values
            if x is None or y is None or x.shape != y.shape:
                continue
            most = max(most, straightness(x, y))
    return most


def _looked_at(path: Path, text: TextGuess, *, turn: bool = True) -> FileGuess:
    """A log under a layout; a row for each foot or cell becomes a row per sample, with `turn`."""
    names = [name for name in column_names(path, text.layout) if name]
    raw = raw_columns(path, names, (), text.layout)
    rows_of, halting = topic(raw), set[str]()
    if rows_of:
        stamps = next(at for c in raw.values() if (at := stamps_of(c)) is not None)
        own_rows = ~raw[rows_of].silent
        halting = {name for name, column in raw.items() if column.silent[~own_rows].any()}
        raw = at_rows(raw, own_rows, stamps, np.inf)
    units = dict(zip(names, text.units, strict=False))
    raw = {name: _ungrouped(column, text.layout.thousands) for name, column in raw.items()}
    empty = {name for name, column in raw.items() if column.silent.all()}
    called = said_by_names(names, path.name.split(".")[0], text.layout.pivot, empty)
    called = without_words_behind(called, names, raw)
    columns = [
        _column(name, raw[name], units.get(name, ""), own)
        for name, own in zip(names, called, strict=True)
    ]
    columns = [
        c.as_quantity("other", "likely", "the clock of one topic alone")
        if c.quantity == "time" and c.column in halting else c
        for c in with_lettered_cells(with_units_first(columns))
    ]  # fmt: skip
    if text.layout.line:
        columns = [taking_turns(part_of_the_words(column)) for column in columns]
    columns = _signs_by_load(_by_numbers(seconds_apart(units_beside(columns))))
    columns = said_between(joined_registers(columns))
    pivot = None if rows_of or text.layout.pivot or not turn else pivot_of(columns, raw)
    if pivot is not None:
        rare = sorted({*labels_of([raw[name] for name in pivot.by])} - {*pivot.labels})
        said = f"a row for each of {', '.join(pivot.labels)}, made one row per sample"
        said += f"; rows of {', '.join(rare)} are left out" * bool(rare)
        turned = pivoted_names(names, pivot, path)
        below = tuple(units.get(own_names([name], pivot)[-1], "") for name in turned)
        layout = replace(text.layout, pivot=pivot)
        text = replace(text, layout=layout, units=below, said=(*text.said, said))
        return said_once(_looked_at(path, text), columns, pivot)
    rows = len(next(iter(raw.values())).values)
    return FileGuess(path, text, tuple(columns), rows, rate_of(columns), rows_of)


def _ungrouped(column: RawColumn, sign: str) -> RawColumn:
    """Texts without the sign between groups of thousands, as the reader leaves it out too."""
    if column.kind != "text" or not sign:
        return column
    grouped = re.compile(rf"(?<=\d){re.escape(sign)}(?=\d{{3}}(?!\d))")
    words = [grouped.sub("", w) if isinstance(w, str) else w for w in column.values.tolist()]
    return replace(column, values=np.array(words, dtype=object))


def _column(column: str, raw: RawColumn, unit_row: str, called: str) -> ColumnGuess:
    """One column, by its numbers and by what of its name says what it is."""
    name = name_guess(called)
    below = known_unit(unit_row)
    if below and name.unit is None:
        name = replace(name_guess(f"{called} [{below}]"), unit=None)
    unit, said = below or name.unit, "its name" + (" and its row of units" if below else "")
    if below and name.unit and name.unit not in (below, "count"):
        unit, said = None, f"its name says {name.unit}, the row of units {below}"
    if raw.kind in ("stamp", "duration"):
        return ColumnGuess(column, replace(name, quantity="time"), None, "sure", "dates")
    if name.axis and name.quantity == "force" and unit in (*NO_READING, "m"):
        name = replace(name, quantity="other", axis="")  # TX (mm) is a place
    if name.quantity == "unknown" and unit in SHARES:
        name = replace(name, quantity="other")
    if raw.kind == "text":
        return _where_read(text_column(column, name, unit, raw))
    values = np.asarray(raw.values, dtype=np.float64)
    word = called.strip().lower()
    counts = {*words_of(called)} & NUMBERS  # cell no
    turns = word in OF_A_ROW and (word in COUNTED or np.mean(np.diff(values) != 0) > _OFTEN)
    turns |= word in OF_A_ROW - {"channel"} and one_after_the_other(values)
    turns |= bool(counts) and len(bare := {*words_of(called)} - counts) == 1 and bare <= OF_A_ROW
    counted = name.quantity == "label" or turns
    if counted and (words := numbers_as_labels(values)):
        return replace(words, column=column, name=replace(name, quantity="label"))
    if raw.kind == "truth" or not np.isfinite(values).any():
        name = replace(name, quantity="other")
        return ColumnGuess(column, name, None, "likely", "empty, or true and false", values)
    numbered = np.array_equal(values, np.round(values), equal_nan=True)
    if name.quantity in ("label", "orientation", "placement") and not numbered:
        name = replace(name, quantity="reading")
    sure: Sure = "guess" if name.quantity == "unknown" else "likely"
    made = _where_read(ColumnGuess(column, name, unit, sure, said, values))
    values = numbers_of(made)
    if name.quantity in ("reading", "unknown") and (at := lost_sign(values)):
        return replace(made, values=signed(values, at), wraps_at=at)
    return unwrapped_counter(made) if name.quantity in ("time", "unknown", "sequence") else made


def _where_read(column: ColumnGuess) -> ColumnGuess:
    """A column without the numbers that stand for no reading in it."""
    if column.values is None or column.quantity not in MEASURED:
        return column
    nothing = no_reading(column.values)
    if not nothing:
        return column
    values = np.where(np.isin(column.values, [float(m) for m in nothing]), np.nan, column.values)
    return replace(column, values=values, missing=(*column.missing, *nothing))


def _by_numbers(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Columns whose names say little, by their numbers; time by how it increases."""
    found = without_derived(with_flight_angles(without_supply(one_statistic(columns))))
    found = _without_silent(one_clock([_numbered(c) for c in without_orders(found)], found))
    found = noted_in_seconds(_newtons(only_numbers(in_frames(one_time(first_in_time(found))))))
    found = with_stances(with_rounds(with_temperatures(found)))
    if not any(column.quantity in ("load", "com") for column in found):
        counted = [_counted(c) for c in found]
        loads = [c for c in counted if c.quantity == "load"]
        others = [c for c in counted if c.quantity in ("reading", "unknown")]
        if not others and len(loads) == 1 and loads[0].unit in LOADS:
            # a force that something calibrated before has read, and one alone
            forces = [c for c in counted if c.quantity == "force"]
            others = forces if len(forces) == 1 and forces[0].name.axis in ("", "fz") else []
        like = {c.column.partition(".")[2] for c in others} - {""}  # of a turned table
        alone = len(loads) == 1 and loads[0].column.partition(".")[2] not in like
        if alone and any(c.values is not None for c in others):
            return counted
        return _straightest(found)
    return found


def _newtons(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """A column that is called ``N`` and counts no rows is a load in newtons, where no other is."""
    others = any(c.quantity in ("load", "force") for c in columns)
    named = [c for c in columns if c.column.strip() == "N" and c.quantity == "sequence"]
    if others or len(named) != 1 or named[0].values is None or increases(named[0].values):
        return columns
    load = named[0].as_quantity("load", "guess", "newtons: it counts no rows")
    return [replace(load, unit="N") if c is named[0] else c for c in columns]


def _straightest(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """In a table without names, the round column that all others are straight in is the load.

    It takes fewer values than any of them: weights come again, noisy readings do not.
    """
    plain = [c for c in columns if c.quantity == "unknown" and c.values is not None]
    nameless = all(c.column.startswith("column_") for c in plain)
    if not nameless or len(plain) < 2 or numbers_of(plain[0]).size < _LEAST_ROWS:
        return columns
    sizes = [np.unique(numbers_of(c)).size for c in plain]
    fewest = int(np.argmin(sizes))
    load, others = plain[fewest], [c for c in plain if c is not plain[fewest]]
    values = numbers_of(load)
    whole = np.all(np.abs(values * 1000 - np.round(values * 1000)) < _NICE_STEPS)
    if sizes.count(min(sizes)) > 1 or not whole or np.abs(values).max(initial=0.0) > _LARGEST:
        return columns
    if min(straightness(values, numbers_of(c)) for c in others) < _STRAIGHT:
        return columns
    taken = load.as_quantity("load", "guess", "round values that all others are straight in")
    return [taken if c is load else c for c in columns]


def _signs_by_load(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Readings whose lost sign a known load beside them shows, or shows never to have been lost."""
    loads = [c for c in columns if c.quantity == "load" and c.values is not None]
    loads = loads or [
        c for c in columns
        if c.quantity == "force" and c.name.axis in ("", "fz") and c.values is not None
    ]  # fmt: skip
    if len(loads) != 1:
        return columns
    load = numbers_of(loads[0])
    return [
        _sign_by_load(c, load)
        if c.quantity in ("reading", "unknown") and c.values is not None
        and c.values.shape == load.shape and not c.format else c
        for c in columns
    ]  # fmt: skip


def _sign_by_load(column: ColumnGuess, load: FloatArray) -> ColumnGuess:
    read = numbers_of(column)
    if column.wraps_at is not None:
        read = np.where(read < 0, read + column.wraps_at, read)
    at = lost_sign_by_load(read, load)
    if at:
        return replace(column, values=signed(read, at), wraps_at=at)
    if column.wraps_at is not None and straightness(load, read) > straightness(
        load, numbers_of(column)
    ):
        return replace(column, values=read, wraps_at=None)
    return column


def _without_silent(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Readings of a group of which others change are not there if they are zero throughout."""
    quiet = [
        c.quantity in ("reading", "force", "unknown") and c.values is not None
        and not np.any(np.nan_to_num(c.values)) and not c.name.axis for c in columns
    ]  # fmt: skip
    speaking = sum(
        c.quantity in ("reading", "force", "unknown") and c.values is not None and not silent
        for c, silent in zip(columns, quiet, strict=True)
    )
    if not speaking or sum(quiet) < 2:
        return columns
    return [
        c.as_quantity("other", "likely", "zero in every row") if silent else c
        for c, silent in zip(columns, quiet, strict=True)
    ]


def _numbered(column: ColumnGuess) -> ColumnGuess:
    values = column.values
    if values is None:
        return column
    if column.quantity == "contact" and np.isin(values, (0.0, 1.0)).all():
        return column
    if column.quantity == "contact" and np.isin(np.diff(values), (0.0, 1.0)).all():
        return column.as_quantity("sequence", "likely", "counts up: the number of a stance")
    if column.quantity in ("label", "contact"):
        return column.as_quantity("reading", "guess", "a number among labels")
    if column.quantity == "unknown" and column.unit in ("uV", "mV/V"):
        return column.as_quantity("reading", "likely", "its unit is that of a bridge")
    if column.quantity == "unknown" and column.unit in ("N", "kN", "mN", "kgf", "lbf", "gf"):
        return column.as_quantity("force", "likely", "its unit is that of a force")
    far = np.nan_to_num(np.abs(values)).max(initial=0.0) > _COUNTS_UP_TO * values.size
    if column.quantity == "sequence" and far and not increases(values, strictly=False):
        return column.as_quantity("unknown", "guess", "called a number, but counts no rows")
    whole_seconds = "s" if np.all(values == np.round(values)) else ""  # may be counts
    if column.quantity in ("unknown", "reading") and since_1970(values) not in ("", whole_seconds):
        return column.as_quantity("time", "likely", "counts from 1970")
    if column.quantity == "reading" and column.unit is None and _counts_rows(column.name, values):
        return column.as_quantity("sequence", "likely", "counts its rows")
    if column.unit is not None and column.unit not in TIMES:
        return column  # whatever has another unit is no time
    # X_Value of LabVIEW: nothing that is read goes up evenly for so long
    stamps = column.quantity == "reading" and not whole_seconds and values.size > _COUNTS_UP_TO
    if (column.quantity == "unknown" or stamps) and increases(values) and even(values):
        step = float(np.median(np.diff(values)))
        if step == 1.0 and abs(values[0]) <= 1:
            return column.as_quantity("sequence", "likely", "counts its rows")
        return column.as_quantity("time", "likely", "increases evenly")
    if column.quantity == "unknown" and column.column == "column_1" and nearly_increases(values):
        back = int(np.sum(np.diff(values) < 0))
        return column.as_quantity("time", "guess", f"increases but for {back} rows that go back")
    if column.quantity == "unknown" and column.column == "column_1" and ticks(values):
        return column.as_quantity("other", "likely", "whole numbers that only ever increase")
    if column.quantity == "time" and not increases(values, strictly=False):
        if restarts(values):
            return column
        words = words_of(column.column)
        if warm := degrees(words, column.unit):
            return replace(column.as_quantity("temperature", "likely", "its name"), unit=warm)
        if column.unit is None and len(words) > 1 and words[-1].isdigit():
            return column.as_quantity("unknown", "guess", "numbered as cells are, and no clock")
        return column.as_quantity("other", "guess", "called time, but does not increase")
    return column


_MOSTLY_UP = 0.5


def _counts_rows(name: NameGuess, values: FloatArray) -> bool:
    """Whether readings go up by one from row to row: numbers of rows, as ``Reading No.`` is."""
    ends = name.owner.rpartition("_")[2] in ("no", "nr", "nummer", "number")
    if values.size < 2 or abs(values[0]) > 1 or not (ends or values.size >= TICKS):
        return False
    up = np.diff(values) == 1
    goes_on = up | (values[1:] == values[0])  # in each series anew
    return bool(goes_on.all()) and float(np.mean(up)) > _MOSTLY_UP


def _counted(column: ColumnGuess) -> ColumnGuess:
    """A column of few, round values is a load, where no other is."""
    values = column.values
    if values is None or column.quantity not in ("unknown", "reading") or values.size < 3:
        return column
    if column.unit not in (None, "count", *LOADS):
        return column  # of bars or degrees no load
    different = np.unique(values[np.isfinite(values)])
    largest = float(np.abs(different).max()) if different.size else 0.0
    round_ones = np.all(np.abs(different * 1000 - np.round(different * 1000)) < _NICE_STEPS)
    flag = np.array_equal(different, (0.0, 1.0)) and column.unit is None
    if flag and not column.column.startswith("column_"):
        return column
    few = 2 <= different.size <= max(FEW, 1) and different.size < values.size / 2
    if column.quantity == "unknown" and few and round_ones and largest < 1e5:
        return column.as_quantity("load", "guess", f"{different.size} round values")
    return column
