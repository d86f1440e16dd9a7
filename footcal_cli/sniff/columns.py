"""What each column of a log is taken for, by its name and by its numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, Sure
from footcal_cli.sniff.names import NameGuess, name_guess
from footcal_cli.sniff.text import TextGuess, guess_text
from footcal_cli.sniff.tokens import HEXADECIMAL, date_format, with_unit
from footcal_cli.sniff.units import MASSES, WEIGHTS, known_unit
from footcal_cli.tables.canonical import unwrapped
from footcal_cli.tables.logfiles import RawColumn, column_names, is_parquet, raw_columns
from footcal_cli.tables.reading import Layout
from footcal_cli.tables.sources import at_rows

_FEW = 25
"""A load takes no more than so many values."""
_EPOCHS = {"s": 1e9, "ms": 1e12, "us": 1e15, "ns": 1e18}
_SECONDS = re.compile(r"(?:^|[._ ])(?:sec|secs|seconds)$", re.IGNORECASE)
_NANOSECONDS = re.compile(r"(?:^|[._ ])(?:nano|n)(?:sec|secs|seconds)$", re.IGNORECASE)
_UNIT_COLUMN = re.compile(r"(?i)(.*?)[\W_]*(?:unit|units|einheit)\W*")
_VALUE_COLUMN = re.compile(r"(?i)[\W_]*(?:value|wert|val)?\W*$")
_MOST_HZ = 20_000.0
_NICE_STEPS = 1e-6
_RUN_ROWS = 20
"""Stamps of a long table go on for so many rows before they begin again."""
_TYPED_ROWS, _HELD_S = 100, 5.0
"""Fewer rows than this, further apart than this, are readings noted one by one."""


def guess_file(path: Path) -> FileGuess:
    """Look at one log.

    Raises
    ------
    DataError
        It is no table of numbers.
    """
    text = TextGuess(Layout()) if is_parquet(path) else guess_text(path)
    names = [name for name in column_names(path, text.layout) if name]
    raw = raw_columns(path, names, (), text.layout)
    rows_of = topic(raw)
    if rows_of:
        stamps = next(c.values for c in raw.values() if _stamps(c)).astype(np.float64)
        raw = at_rows(raw, ~raw[rows_of].empty, stamps, np.inf)
    units = dict(zip(names, text.units, strict=False))
    columns = [_column(name, raw[name], units.get(name, "")) for name in names]
    if text.layout.line:
        columns = [_part_of_the_words(column) for column in columns]
    columns = _by_numbers(_seconds_apart(_units_beside(columns)))
    rows = len(next(iter(raw.values())).values)
    return FileGuess(path, text, tuple(columns), rows, _rate(columns), rows_of)


def _units_beside(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """A unit that stands as a text beside its number: ``load.value`` and ``load.unit``."""
    units = {}
    for column in columns:
        found = _UNIT_COLUMN.fullmatch(column.column)
        if found and len(column.words) == 1 and (unit := known_unit(column.words[0])):
            units[found[1]] = unit
    made = []
    for column in columns:
        stem = _VALUE_COLUMN.sub("", column.column)
        unit = units.get(stem) if column.values is not None and column.unit is None else None
        made.append(column if unit is None else replace(column, unit=unit))
    return made


def topic(raw: Mapping[str, RawColumn]) -> str:
    """A column whose rows count where several topics take turns; empty where none do.

    Topics have no row in common, and a column of stamps has a value in all rows. Of several the one
    of forces counts.
    """
    topics: dict[bytes, list[str]] = {}
    for name, column in raw.items():
        if column.empty.any() and not column.empty.all():
            topics.setdefault(column.empty.tobytes(), []).append(name)
    if len(topics) < 2 or not any(_stamps(column) for column in raw.values()):
        return ""
    there = [~raw[names[0]].empty for names in topics.values()]
    if np.any(np.sum(there, axis=0) > 1):
        return ""
    felt = ("force", "reading", "load")
    named = [name for own in topics.values() for name in own if name_guess(name).quantity in felt]
    return named[0] if named else next(iter(topics.values()))[0]


def _stamps(column: RawColumn) -> bool:
    """Whether a column can be the time of all rows."""
    if column.kind != "number" or column.empty.any() or len(column.values) < 3:
        return False
    return bool(np.all(np.diff(column.values) >= 0) and column.values[0] != column.values[-1])


def _column(column: str, raw: RawColumn, unit_row: str) -> ColumnGuess:
    name = name_guess(column)
    unit = known_unit(unit_row) or name.unit
    said = "its name" + (" and its row of units" if known_unit(unit_row) else "")
    if raw.kind in ("stamp", "duration"):
        return ColumnGuess(column, replace(name, quantity="time"), None, "sure", "dates")
    if raw.kind == "text":
        return _text_column(column, name, unit, raw)
    values = np.asarray(raw.values, dtype=np.float64)
    if raw.kind == "truth" or not np.isfinite(values).any():
        name = replace(name, quantity="other")
        return ColumnGuess(column, name, None, "likely", "empty, or true and false", values)
    if name.quantity in ("label", "orientation", "placement") and raw.values.dtype.kind == "f":
        name = replace(name, quantity="reading")
    sure: Sure = "guess" if name.quantity == "unknown" else "likely"
    made = ColumnGuess(column, name, unit, sure, said, values)
    return _unwrapped(made) if name.quantity in ("time", "unknown", "sequence") else made


def _unwrapped(column: ColumnGuess) -> ColumnGuess:
    """A counter of 16, 24 or 32 bits that began again from zero, as if it had gone on."""
    values = column.values
    if values is None or not _whole(column) or _increases(values, strictly=False):
        return column
    for bits in (16, 24, 32):
        onward = unwrapped(values, 2.0**bits)
        drops = np.sum(np.diff(values) < 0)
        # it goes on through the zero with the same steps as before
        if values.max() < 2**bits and values.max() > 0.98 * 2**bits and (
            _increases(onward) and _even(onward) and drops < values.size / 8
        ):  # fmt: skip
            made = column.as_quantity("time", "likely", f"a counter of {bits} bits, unwrapped")
            return replace(made, values=onward, wraps_at=2.0**bits)
    return column


def _text_column(column: str, name: NameGuess, unit: str | None, raw: RawColumn) -> ColumnGuess:
    """Dates, numbers with a unit beside them, or labels."""
    words = [str(v).strip() for v, e in zip(raw.values, raw.empty, strict=True) if not e]
    some = words[:: max(1, len(words) // 40)]
    iso = bool(some) and all(re.match(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d", word) for word in some)
    if iso:
        return ColumnGuess(column, replace(name, quantity="time"), None, "sure", "ISO 8601 dates")
    form = date_format(some) if some else None
    if form is not None:
        name = replace(name, quantity="time")
        return ColumnGuess(column, name, None, "sure", f"dates {form}", format=form)
    if words and all(HEXADECIMAL.fullmatch(word) for word in words):
        values = np.array([float(int(word, 16)) for word in words])
        name = replace(name, quantity="reading" if np.ptp(values) > 0 else "other")
        return ColumnGuess(column, name, None, "likely", "hexadecimal numbers", values)
    weighed = _with_units(column, name, words)
    if weighed is not None:
        return weighed
    different = tuple(dict.fromkeys(words))
    if name.quantity not in ("label", "orientation", "placement", "session", "direction"):
        kind = "label" if 1 < len(different) <= _FEW and len(words) > len(different) else "other"
        if name.quantity in ("reading", "unknown", "load") and kind == "label":
            name = replace(name, quantity="label")
        else:
            name = replace(name, quantity="other")
    codes = np.full(len(raw.values), -1)
    codes[~raw.empty] = [different.index(word) for word in words] if len(different) <= 99 else -1
    return ColumnGuess(column, name, None, "likely", "texts", words=different, codes=codes)


def _part_of_the_words(column: ColumnGuess) -> ColumnGuess:
    """In lines of words a number that never changes is one of the words."""
    if column.values is None or np.ptp(column.values[np.isfinite(column.values)]) > 0:
        return column
    return column.as_quantity("other", "likely", "never changes")


def _seconds_apart(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Stamps in two columns: whole seconds, then nanoseconds, as ROS 2 writes them."""
    for whole, rest in pairwise(columns):
        if whole.values is None or rest.values is None or not _whole(whole) or not _whole(rest):
            continue
        named = bool(_SECONDS.search(whole.column) and _NANOSECONDS.search(rest.column))
        since_1970 = 1e9 < whole.values[0] < 5e9 and _increases(whole.values, strictly=False)
        inside = rest.values.min() >= 0 and 1e6 < rest.values.max() < 1e9
        if not (inside and (named or since_1970)):
            continue
        time = whole.as_quantity("time", "sure" if named else "likely", "seconds and nanoseconds")
        time = replace(
            time, unit=None, values=whole.values + 1e-9 * rest.values, nanoseconds=rest.column
        )
        other = rest.as_quantity("other", "likely", f"nanoseconds of {whole.column}")
        return [{id(whole): time, id(rest): other}.get(id(c), c) for c in columns]
    return columns


def _whole(column: ColumnGuess) -> bool:
    return column.values is not None and bool(np.all(column.values == np.round(column.values)))


def _with_units(column: str, name: NameGuess, words: list[str]) -> ColumnGuess | None:
    """A column of numbers with their units beside them; None where it is none."""
    pairs = [with_unit(word) for word in words]
    plain = [word for word, pair in zip(words, pairs, strict=True) if pair is None]
    if not words or not any(pairs) or any(word.strip("0., ") for word in plain):
        return None
    units = {known_unit(pair[1]) for pair in pairs if pair}
    if None in units:
        return None
    kind = "load" if name.quantity in ("unknown", "label", "other") else name.quantity
    name = replace(name, quantity=kind)
    if len(units) == 1 and not plain:
        unit = units.pop()
        numbers = np.array([float(p[0].replace(",", ".")) for p in pairs if p])
        return ColumnGuess(
            column, name, unit, "likely", "numbers with their unit", numbers,
            pattern=r"([-+]?[\d.,]+)",
        )  # fmt: skip
    if not units <= MASSES.keys() and not units <= WEIGHTS.keys():
        return None
    one, sizes = ("kg", MASSES) if units <= MASSES.keys() else ("N", WEIGHTS)
    numbers = np.array([
        float(p[0].replace(",", ".")) * sizes[known_unit(p[1]) or one] if p else 0.0 for p in pairs
    ])  # fmt: skip
    return ColumnGuess(
        column, name, one, "likely", "numbers with their units", numbers,
        pattern=r"([-+]?[\d.,]+)\s*(?P<unit>[A-Za-z]*)",
    )  # fmt: skip


def _by_numbers(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Columns whose names say little, by their numbers; time by how it increases."""
    found = _without_silent([_numbered(column) for column in columns])
    found = _one_time(_first_in_time(found))
    if not any(column.quantity == "load" for column in found):
        counted = [_counted(c) for c in found]
        loads = [c for c in counted if c.quantity == "load"]
        others = [c for c in counted if c.quantity in ("reading", "unknown")]
        if len(loads) == 1 and any(c.values is not None for c in others):
            return counted
    return found


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


def _first_in_time(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """A first column that increases evenly is time where no other is, whatever it is called.

    Loads and labels, which may have been carried down from lines between, do not count.
    """
    first = next((c for c in columns if c.quantity not in ("load", "label")), columns[0])
    values = first.values
    if (
        any(column.quantity == "time" for column in columns)
        or first.quantity not in ("reading", "unknown", "hole")
        or values is None
        or not (_increases(values) and _even(values))
    ):
        return columns
    taken = first.as_quantity("time", "guess", "the first column, increases evenly")
    return [taken if column is first else column for column in columns]


def _numbered(column: ColumnGuess) -> ColumnGuess:
    values = column.values
    if values is None:
        return column
    if column.quantity == "contact" and np.isin(values, (0.0, 1.0)).all():
        return column
    if column.quantity in ("label", "contact"):
        return column.as_quantity("reading", "guess", "a number among labels")
    if column.quantity == "unknown" and column.unit in ("N", "kN", "mN", "kgf", "lbf", "gf"):
        return column.as_quantity("force", "likely", "its unit is that of a force")
    if column.quantity == "unknown" and _increases(values) and _even(values):
        step = float(np.median(np.diff(values)))
        if step == 1.0 and abs(values[0]) <= 1:
            return column.as_quantity("sequence", "likely", "counts its rows")
        return column.as_quantity("time", "likely", "increases evenly")
    if column.quantity == "time" and not _increases(values, strictly=False):
        if _restarts(values):
            return column
        return column.as_quantity("other", "guess", "called time, but does not increase")
    return column


def _one_time(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """The best column of time stamps alone is time, with its unit."""
    times = [c for c in columns if c.quantity == "time"]
    if not times:
        return columns
    with_dates = [c for c in times if c.values is None]
    stamped = [c for c in times if c.nanoseconds] + [
        c for c in times if "stamp" in c.column.lower() and "header" in c.column.lower()
    ]
    named = [c for c in times if c.unit is not None]
    best = (stamped or named or with_dates or times)[0]
    if with_dates and best.values is not None and np.ptp(best.values) == 0:
        best = with_dates[0]
    made = []
    for column in columns:
        if column.quantity != "time":
            made.append(column)
        elif column is not best:
            made.append(column.as_quantity("other", "likely", "another clock"))
        else:
            made.append(_with_time_unit(column))
    return made


def _with_time_unit(column: ColumnGuess) -> ColumnGuess:
    values = column.values
    if values is None or column.nanoseconds or column.unit in ("s", "ms", "us", "ns", "min", "h"):
        return replace(column, sure="sure") if column.unit else column
    first, steps = abs(float(values[0])), np.diff(values)
    step = float(np.median(steps[steps > 0])) if np.any(steps > 0) else 0.0
    words = column.column.lower()
    for word, unit in (("milli", "ms"), ("micro", "us"), ("nano", "ns"), ("msec", "ms")):
        if word in words:
            return replace(column, unit=unit, sure="sure")
    for unit, size in reversed(_EPOCHS.items()):
        if 0.5 * size < first < 5 * size:
            return replace(column, unit=unit, sure="sure", why=f"{unit} since 1970")
    if step == 0.0 or np.any(values != np.round(values)):
        rate = 1 / step if step else 0.0
        why = f"steps of {step:.4g}: {rate:.4g} Hz if in s"
        return replace(
            column, unit="s", sure="likely" if 0.2 < rate < _MOST_HZ else "guess", why=why
        )
    if values.size < _TYPED_ROWS and _HELD_S <= step < 1e4:
        why = f"whole steps of {step:g} in {values.size} rows: typed by hand, in s"
        return replace(column, unit="s", sure="guess", why=why)
    unit = "s" if step <= 1 and float(values[-1]) < 1e5 and step == 1 else (
        "ms" if step <= 2000 else "us" if step <= 2e6 else "ns"
    )  # fmt: skip
    return replace(
        column, unit=unit, sure="guess", why=f"whole steps of {step:g}: taken for {unit}"
    )


def _counted(column: ColumnGuess) -> ColumnGuess:
    """A column of few, round values is a load, where no other is."""
    values = column.values
    if values is None or column.quantity not in ("unknown", "reading") or values.size < 3:
        return column
    different = np.unique(values[np.isfinite(values)])
    largest = float(np.abs(different).max()) if different.size else 0.0
    round_ones = np.all(np.abs(different * 1000 - np.round(different * 1000)) < _NICE_STEPS)
    few = 2 <= different.size <= max(_FEW, 1) and different.size < values.size / 2
    if column.quantity == "unknown" and few and round_ones and largest < 1e5:
        return column.as_quantity("load", "guess", f"{different.size} round values")
    return column


def _increases(values: FloatArray, strictly: bool = True) -> bool:
    good = values[np.isfinite(values)]
    steps = np.diff(good)
    return bool(good.size > 2 and (np.all(steps > 0) if strictly else np.all(steps >= 0)))


def _restarts(values: FloatArray) -> bool:
    """Stamps that begin again now and then: with each leg or orientation of a long table."""
    steps = np.diff(values[np.isfinite(values)])
    return bool(steps.size > 2 and np.mean(steps < 0) < 1.0 / _RUN_ROWS and np.median(steps) > 0)


def _even(values: FloatArray) -> bool:
    steps = np.diff(values)
    return bool(np.quantile(np.abs(steps - np.median(steps)), 0.8) <= 0.3 * np.median(steps))


def _rate(columns: list[ColumnGuess]) -> float | None:
    scale: Mapping[str | None, float] = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60, "h": 3600}
    for column in columns:
        if column.quantity == "time" and column.values is not None:
            steps = np.diff(column.values)
            steps = steps[steps > 0] * scale.get(column.unit, 1.0)
            return float(1 / np.median(steps)) if steps.size else None
    return None
