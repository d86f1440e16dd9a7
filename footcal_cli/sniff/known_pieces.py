"""Loads by the names of weights (``D1+D2``), and a table of what each weight has.

Room: sniff; asked by several. The readings beside such labels may be in a unit of loads: amplifiers
that somebody set to kilograms.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.readings import straightness
from footcal_cli.sniff.columns import as_it_stands
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.said_weights import says_nothing
from footcal_cli.sniff.tokens import NOTHING
from footcal_cli.sniff.units import LOADS

_BETWEEN = (
    re.compile(r"\s*[+&,;/]\s*"),
    re.compile(r"\s*(?:[+&,;/]|\b(?:and|und|et|y|e|plus)\b)\s*", re.IGNORECASE),
)
"""Signs between names of weights; then words too, though a weight may be called E."""
_TIMES = re.compile(r"(?:(\d{1,2})\s*[x×*]\s*)?(.+)")
_FOLLOWS = 0.9
"""How much of a reading's variance the loads explain at least."""
_LEAST = 2
"""Different loads that labels must say."""


def with_known_pieces(files: Sequence[FileGuess]) -> list[FileGuess]:
    """Logs whose labels of weights have their loads from a table among the files, without it."""
    for sheet in files:
        table = _pieces(sheet)
        if table is None:
            continue
        masses, unit = table
        others = [file for file in files if file is not sheet]
        made = [_by_rows(file, masses, unit, sheet.path.name) for file in others]
        if any(new is not old for new, old in zip(made, others, strict=True)):
            return _all_named(made)
    return list(files)


def _all_named(files: Sequence[FileGuess]) -> list[FileGuess]:
    """Logs whose loads know the labels of all logs: one recipe reads them."""
    said: dict[str, dict[str, str]] = {}
    for file in files:
        for column in file.of("load"):
            said.setdefault(column.column, {}).update(column.names)
    return [
        replace(file, columns=tuple(
            replace(c, names=said[c.column]) if c.quantity == "load" and c.names else c
            for c in file.columns
        )) for file in files
    ]  # fmt: skip


def _pieces(sheet: FileGuess) -> tuple[dict[str, float], str] | None:
    """Weight -> its load, and the unit; None where a file is no table of named weights."""
    loads = [c for c in sheet.columns if c.values is not None and c.unit in LOADS]
    names = [c for c in sheet.columns if c.values is None and len(c.words) == sheet.rows]
    read = [c for c in sheet.of("reading", "time") if c.values is not None and c not in loads]
    if len(loads) != 1 or not names or read or sheet.rows < 2:
        return None
    name, values = names[0], numbers_of(loads[0])
    if not np.isfinite(values).all() or name.codes is None or name.codes.min() < 0:
        return None
    said = [name.words[i].strip().lower() for i in name.codes]
    return dict(zip(said, values.tolist(), strict=True)), loads[0].unit or ""


def _by_rows(file: FileGuess, masses: Mapping[str, float], unit: str, sheet: str) -> FileGuess:
    """A log with its loads, also where its labels were taken for those of feet or cells."""
    if file.layout.pivot is None:
        return _with_loads(file, masses, unit, sheet)
    plain = as_it_stands(file)
    made = _with_loads(plain, masses, unit, sheet)
    return file if made is plain else made


def _with_loads(
    file: FileGuess, masses: Mapping[str, float], unit: str, sheet: str
) -> FileGuess:  # fmt: skip
    """A log whose one column of labels is read as loads; itself where none is."""
    for column in file.columns:
        if column.values is not None or column.codes is None or not column.words:
            continue
        sums = {word: _sum_of(word, masses) for word in column.words}
        bare = {word for word in column.words if word.strip() in NOTHING}  # they have no code
        if None in sums.values() or len({*sums.values()}) < _LEAST:
            continue
        if (column.codes < 0).any() and not bare:
            continue
        put = {word: f"{value:.10g}" for word, value in sums.items() if value is not None}
        values = np.array([float(put[column.words[i]]) if i >= 0 else 0.0 for i in column.codes])
        load = replace(
            column.as_quantity("load", "likely", f"weights of {sheet}, added up"), unit=unit,
            values=values, names=put, words=(), codes=None,
        )  # fmt: skip
        added = any(_sum_of(word, masses) not in (0.0, *masses.values()) for word in sums)
        if not _are_read(file, values, added=added):
            continue  # they name cells, and the table says what each may carry
        shown = (_as_reading(c) if c.unit else _as_counted(c) for c in file.columns)
        columns = (load if c.column == column.column else c for c in shown)
        return replace(file, columns=tuple(columns))
    return file


def _are_read(file: FileGuess, put: FloatArray, *, added: bool) -> bool:
    """Whether readings of a log follow loads by labels: each in a unit of loads, and any at all."""
    shown = [c.values for c in file.of("load") if c.values is not None and c.unit]
    others = [c.values for c in file.of("reading", "unknown", "force") if c.values is not None]
    if shown:
        return all(straightness(put, values) > _FOLLOWS for values in shown)
    alike = [values for values in others if values.size == put.size]
    together = [np.sum(alike, axis=0)] if len(alike) > 1 else []  # cells of a plate share it
    return added or any(straightness(put, values) > _FOLLOWS for values in (*others, *together))


def _sum_of(label: str, masses: Mapping[str, float]) -> float | None:
    """What a label says to lie there; None where it says anything else."""
    plain = label.strip().lower()
    if plain in masses:
        return masses[plain]
    if plain in NOTHING or plain == "0" or says_nothing(plain):
        return 0.0
    letters = plain.isalpha() and len(plain) > 1 and len({*plain}) == len(plain)
    if letters and (total := _total([*plain], masses)) is not None:
        return total  # EB are E and B
    sums = (_total(between.split(plain), masses) for between in _BETWEEN)
    return next((total for total in sums if total is not None), None)


def _total(parts: Sequence[str], masses: Mapping[str, float]) -> float | None:
    """What weights have together, some of them several times; None where one is not known."""
    total = 0.0
    for part in parts:
        found = _TIMES.fullmatch(part)
        if found is None or found[2].strip() not in masses:
            return None
        total += int(found[1] or 1) * masses[found[2].strip()]
    return total


def _as_counted(column: ColumnGuess) -> ColumnGuess:
    """Round numbers without a unit beside such labels are numbers of steps."""
    if column.quantity != "load" or column.values is None:
        return column
    return column.as_quantity("other", "likely", "round numbers, and weights next to them")


def _as_reading(column: ColumnGuess) -> ColumnGuess:
    """Numbers in a unit of loads, beside labels of what lay there, are what an amplifier gave."""
    if column.quantity != "load" or column.values is None:
        return column
    return column.as_quantity("reading", "likely", "a display in a unit of loads")
