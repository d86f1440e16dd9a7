"""A file for each hold, leg or pose, and a sheet with a row for each, by the files' names.

Room: sniff; asked by several. The files are looked at as one log whose rows know what the sheet
says of their file; each of these is a constant of the file in the recipe.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from footcal_cli.sniff.columns import as_it_stands
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import Names
from footcal_cli.sniff.file_names import Part, called
from footcal_cli.sniff.groups import wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, as_one, numbers_of
from footcal_cli.sniff.names import NameGuess
from footcal_cli.sniff.numbered import numbered, numbered_beside
from footcal_cli.sniff.plan import Entry

ATTITUDE = ("quaternion", "angle", "matrix", "gravity", "acceleration")
_SAID = (*ATTITUDE, "label", "orientation", "phase", "temperature", "contact", "session")
"""What a sheet can say of a file."""
_LEAST_FILES = 3
_KEY = "\0key"


def indexed(group: list[FileGuess], sheet: FileGuess) -> Part | None:
    """Files of six-axis transducers, and a sheet that says by number or name what each is of.

    Parameters
    ----------
    group, sheet
        The files, and the table that has a row for each of them.
    """
    if len(group) < _LEAST_FILES or not wrenches(numbered(group[0])):
        return None
    sheet = numbered_beside(as_it_stands(sheet), group[0])
    names = Names.of(called([file.path for file in group]))
    for key in sheet.columns:
        rows = rows_of_files(key, names, [file.path for file in group])
        said = [c for c in sheet.of(*_SAID) if c is not key and everywhere(c)]
        if rows is None or not any(c.quantity in (*ATTITUDE, "orientation") for c in said):
            continue
        if any(c.quantity in ATTITUDE for c in said):  # numbers are more exact than words
            said = [c for c in said if c.quantity != "orientation"]
        part = _of_rows(group, names, key, said, rows)
        if part is not None:
            why = f"{part.plan.why}, by {sheet.path.name}"
            return replace(part, plan=replace(part.plan, why=why))
    return None


def _of_rows(
    group: list[FileGuess], names: Names, key: ColumnGuess, said: Sequence[ColumnGuess],
    rows: Sequence[int],
) -> Part | None:  # fmt: skip
    """The plan for files of which each has its row of a sheet."""
    each = [file.rows for file in group]
    texts = {
        _KEY: list(names.middle),
        **{c.column: [text_at(c, row) for row in rows] for c in said},
    }
    number = ColumnGuess(
        _KEY, NameGuess("placement"), None, "likely", "the files' names", words=names.middle,
        codes=np.repeat(np.arange(len(group)), each),
    )  # fmt: skip
    joined = [number, *(_at_files(c, rows, each) for c in said)]
    own = {c.column for c in said}
    whole = as_one([_without(file, own) for file in group], joined)
    plan = plan_of(whole)
    if plan is not None and plan.role == "still":  # each file is a pose: its clock starts anew
        clocks = {c.column for c in whole.of("time")}
        plan = plan_of(replace(_without(whole, clocks), rate_hz=None))
    if plan is None or plan.role not in ("hang", "poses"):
        return None

    def by_file(entry: Entry) -> Entry:
        if entry.column is None or entry.column.column not in texts:
            return entry
        meant = texts[entry.column.column]
        words = {n: entry.names.get(t, t) for n, t in zip(names.middle, meant, strict=True)}
        known = {n: t for n, t in words.items() if n != t}
        return replace(entry, column=None, file_name=names.expression, names=known)

    entries = {name: by_file(entry) for name, entry in plan.entries.items()}
    wide = {
        leg: {name: by_file(entry) for name, entry in own.items()} for leg, own in plan.wide.items()
    }
    plan = replace(plan, file=group[0], entries=entries, wide=wide)
    return Part(plan, tuple(file.path for file in group), names.match)


def _without(file: FileGuess, columns: set[str]) -> FileGuess:
    return replace(file, columns=tuple(c for c in file.columns if c.column not in columns))


def everywhere(column: ColumnGuess) -> bool:
    """Whether a sheet's column says something in every row."""
    if column.values is not None:
        return bool(np.isfinite(numbers_of(column)).all())
    return column.codes is not None and bool(np.all(column.codes >= 0))


def text_at(column: ColumnGuess, row: int) -> str:
    """A cell of a sheet as a recipe has it."""
    if column.codes is not None:
        return str(column.words[column.codes[row]])
    return f"{numbers_of(column)[row]:.10g}"


def _at_files(column: ColumnGuess, rows: Sequence[int], each: Sequence[int]) -> ColumnGuess:
    """A column of a sheet at the rows of files that have `each` so many."""
    at = np.repeat(np.asarray(rows), each)
    plain = replace(column, format=None, pattern=None, nanoseconds="", wraps_at=None, held=False,
                    missing=())  # fmt: skip
    if column.codes is not None:
        return replace(plain, codes=column.codes[at])
    return replace(plain, values=numbers_of(column)[at])


def rows_of_files(key: ColumnGuess, names: Names, paths: Sequence[Path]) -> tuple[int, ...] | None:
    """For each file the row of a sheet whose key means it; None where one has none."""
    if key.values is not None:
        texts = [f"{v:.0f}" if v == v and v == round(v) else "" for v in key.values.tolist()]
    elif key.codes is not None:
        texts = [key.words[i] if i >= 0 else "" for i in key.codes]
    else:
        return None
    meant = [text for text in texts if text]
    if len({*meant}) < max(len(meant), len(paths)):
        return None
    found = []
    for word, path in zip(names.middle, paths, strict=True):
        digits = re.findall(r"\d+", word)
        stem = path.name.split(".")[0]
        either = [t for t in meant if t in (path.name, stem, word)]
        either += [t for t in meant if len(digits) == 1 and t.isdecimal()
                   and int(t) == int(digits[0])]  # fmt: skip
        if not either:
            return None
        found.append(texts.index(either[0]))
    return tuple(found) if len({*found}) == len(found) else None
