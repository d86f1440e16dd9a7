"""A log of cells, and a protocol of what lay on which of them from when on.

Room: sniff; asked by several and placement_index. The readings say how far from a stamp a load
lies still.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import Names, escaped
from footcal_cli.sniff.file_names import Beside, Part, called
from footcal_cli.sniff.groups import readings, wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, codes_of, numbers_of
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.plan import Blank, Entry, cell_name, of
from footcal_cli.sniff.texts import numbers_as_labels
from footcal_cli.sniff.vocabulary import OF_A_ROW
from footcal_cli.tables.reading import ForeignColumn, Reading
from footcal_cli.tables.sources import time_of
from footcal_cli.tables.units import TIMES

_FEWER = 4
"""A stamp of a protocol is of so many rows of the log at least."""
_LEAST_ROWS = 3
_TYPED_S = 2.0
"""Nobody notes more often what was put on; a reference that was recorded is joined otherwise."""
_HALF_HOUR_S = 1800.0
"""Time zones differ by multiples of it."""
_MARGINS = (0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4)
"""Of the shortest hold, what is left out at its two ends."""
_RESTLESS = 3.0
"""Scatters of the middles of holds beyond which a hold is not still."""


def by_protocol(
    file: FileGuess, sheet: FileGuess, only: tuple[ColumnGuess, str] | None = None
) -> Part | None:
    """A log of cells with the loads of another file, by stamps or numbers; None without these.

    Clocks that have nothing in common are taken for those of two time zones. Where the readings
    never stand still between the stamps, right stamps are asked for.

    Parameters
    ----------
    file, sheet
        The log, and the file of loads.
    only
        A column of the sheet and what it says in the rows that are of this log; None for all.
    """
    sheet = _with_spans(sheet)
    sheet = replace(sheet, columns=tuple(_cell_numbers(c) for c in sheet.columns))
    loads = [c for c in sheet.of("load") if c.values is not None]
    if len(loads) != 1 or file.of("load") or readings(sheet) or wrenches(numbered(file)):
        return None
    cells, keys = readings(file), _keys(file, sheet)
    if not cells or keys is None:
        return None
    (mine, at), (stamp, since), until = keys
    rows = np.ones(since.size, dtype=bool)
    if only is not None:
        rows = codes_of(only[0]) == only[0].words.index(only[1])
        since, until = since[rows], None if until is None else until[rows]
    timed = mine.quantity == "time"
    if since.size < _LEAST_ROWS or not np.all(np.diff(since) > 0):
        return None
    if timed and (sheet.rows * _FEWER > file.rows or np.median(np.diff(since)) < _TYPED_S):
        return None
    common = at[-1] >= since[0] and at[0] <= since[-1]
    offset = 0.0 if common else _HALF_HOUR_S * float(np.round((at[0] - since[0]) / _HALF_HOUR_S))
    since, until = since + offset, None if until is None else until + offset
    ends = np.append(since[1:], max(at[-1], since[-1] + np.median(np.diff(since))))
    ends = ends if until is None else np.minimum(ends, until)
    apart = apart_of(at, since, ends, cells) if timed else 0.0
    if apart is None or (offset and not timed):
        return _asked(file, sheet) if sheet.of("label") else None
    longest = float(np.max(ends - since)) if until is None else float(np.min(ends - since)) - apart
    on = holds(at, since, since + longest, apart)
    stem = sheet.path.name.rsplit(".", 1)[0]
    put = np.where(on < 0, np.nan, numbers_of(loads[0])[rows][on])
    why = f"by {sheet.path.name}, from there to the next"
    joined = [
        replace(loads[0], column=f"{stem}.{loads[0].column}", values=put, missing=("",), why=why)
    ]
    labels = [c for c in sheet.of("label") if len(c.words) > 1 and c.codes is not None]
    for label in labels[:1] if only is None else ():
        assert label.codes is not None
        codes = np.where(on < 0, -1, label.codes[on])
        joined.append(replace(label, column=f"{stem}.{label.column}", codes=codes))
    own = tuple(c for c in file.columns if c.quantity not in ("time", "label"))
    plan = plan_of(replace(file, columns=(*own, *joined)))
    if plan is None or plan.role != "weights":
        return None
    mine = replace(mine, nanoseconds="") if timed else replace(mine, why="what the protocol counts")
    plan = replace(
        plan, file=file, entries={**plan.entries, "time_s": of(mine)},
        why=f"{plan.why}, by {sheet.path.name}",
    )  # fmt: skip
    clock = replace(stamp.as_quantity("time", stamp.sure, stamp.why), unit=stamp.unit)
    beside = replace(sheet, columns=(clock, *(c for c in sheet.columns if c is not stamp)))
    said = (
        "what it says holds until its next row" if until is None else "what each of its rows says"
    )
    said += f"; rows closer to a stamp than apart_s = {apart:g} are left out" * bool(apart)
    meant = {} if only is None else {only[0].column: only[1]}
    join = Beside(beside, "time", offset, said, "previous", longest, apart, meant)
    if offset:
        said = f"{sheet.path.name}: its clock is taken to be {offset / 3600:+g} h off"
        plan = replace(plan, warnings=(*plan.warnings, said))
    return Part(plan, (file.path,), escaped(file.path.name), (join,))


def _cell_numbers(column: ColumnGuess) -> ColumnGuess:
    """A column of the numbers of cells, which do not take turns in a protocol, as their names."""
    if column.values is None or column.column.strip().lower() not in OF_A_ROW:
        return column
    words = numbers_as_labels(column.values)
    return column if words is None else replace(words, column=column.column)


def _with_spans(sheet: FileGuess) -> FileGuess:
    """A sheet without stamps, in which one column of times marks each row, or two its two ends."""
    spans = [c for c in sheet.of("unknown") if c.values is not None and c.unit in TIMES]
    if sheet.of("time") or not 0 < len(spans) <= 2:
        return sheet
    ends = [numbers_of(c) for c in spans]
    if len(ends) == 2 and not np.all(ends[1] > ends[0]):
        return sheet
    why = "start and end of a step" if len(ends) == 2 else "when each step began, by its unit"
    made = {c.column: c.as_quantity("time", "likely", why) for c in spans}
    return replace(sheet, columns=tuple(made.get(c.column, c) for c in sheet.columns))


def by_sheet_of_cells(group: Sequence[FileGuess], sheet: FileGuess) -> list[Part]:
    """Logs of one cell each, and a sheet that says what lay on which cell when, on their clocks.

    Empty where a log has no rows in the sheet that are of its name. ``A_run1`` of a file is ``A1``
    of the sheet: a word that all have tells nothing apart.
    """
    words = Names.of(called([file.path for file in group])).middle
    plain, of_all = _what_differs(words)
    runs = any(name_guess(word).quantity in ("repeat", "session") for word in of_all)
    for raw in sheet.columns:
        label = _cell_numbers(raw)
        named = dict(zip(_what_differs(label.words)[0], label.words, strict=True))
        if label.codes is None or len({*plain}) < len(plain) or not {*plain} <= named.keys():
            continue
        parts = [
            by_protocol(f, sheet, (label, named[w])) for f, w in zip(group, plain, strict=True)
        ]
        made = [part for part in parts if part is not None and part.plan.role == "weights"]
        if len(made) == len(group):
            runs = runs or name_guess(label.column).quantity in ("repeat", "session")
            why = f"the file's name, and {label.column} of the sheet"
            return [_of_cell(p, named[w], why, runs) for p, w in zip(made, plain, strict=True)]
    return []


def by_own_sheets(group: Sequence[FileGuess], sheets: Sequence[FileGuess]) -> list[Part]:
    """Logs of one cell each, every one with a sheet of its own: ``A_run1.csv, A_run1_steps.csv``.

    Empty unless all have one, and all are known weights then. A letter in their names is the cell,
    a number the run.
    """
    own = {}
    for file in group:
        named = [s for s in sheets if s.path.name.startswith(file.path.stem)]
        if len(named) != 1:
            return []
        own[file.path] = named[0]
    if len({id(sheet) for sheet in own.values()}) != len(sheets):
        return []
    made = [by_protocol(file, own[file.path]) for file in group]
    parts = [part for part in made if part is not None and part.plan.role == "weights"]
    if len(parts) < len(group):
        return []
    words = _what_differs(Names.of(called([file.path for file in group])).middle)[0]
    letters = [re.sub(r"[\W\d_]", "", word) for word in words]
    runs = len({*letters}) > 1 and all(letters) and len({*words}) == len(words)
    turned = [x + re.sub(r"\D", "", w) if runs else w for x, w in zip(letters, words, strict=True)]
    why = "the file's name"
    return [_of_cell(p, word, why, runs) for p, word in zip(parts, turned, strict=True)]


def _what_differs(words: Sequence[str]) -> tuple[list[str], set[str]]:
    """What of each word tells it from the others, in small letters, and what all of them have."""
    parts = [re.findall(r"[^\W\d_]+|\d+", word.lower()) for word in words]
    of_all = {*parts[0]}.intersection(*parts[1:]) if len(parts) > 1 else set()
    return ["".join(p for p in own if p not in of_all) for own in parts], of_all


def _of_cell(part: Part, word: str, why: str, runs: bool) -> Part:
    """A part whose channel is the cell that its file is called after, and whose run is a number."""
    both = re.fullmatch(r"([^\W\d_]+)[\W_]*(\d+)", word) if runs else None
    name = cell_name(both[1] if both else word)
    entries = {**part.plan.entries, "channel": Entry(value=name, why=why)}
    if both:
        entries["session"] = Entry(value=both[2], why=why)
    return replace(part, plan=replace(part.plan, entries=entries, channels=(name,)))


def _asked(file: FileGuess, sheet: FileGuess) -> Part | None:
    """The log alone, and right stamps asked for."""
    plan = plan_of(file)
    if plan is None:
        return None
    asked = Blank(
        (f"# {sheet.path.name}: correct its stamps, then footcal init of both logs again",),
        f"{sheet.path.name} does not say what lay where: between its stamps the readings do not "
        "stand still, so correct its stamps and run init again; without it",
    )  # fmt: skip
    plan = replace(plan, blanks=(asked, *plan.blanks))
    return Part(plan, (file.path,), escaped(file.path.name))


def _keys(
    file: FileGuess, sheet: FileGuess
) -> (
    tuple[tuple[ColumnGuess, FloatArray], tuple[ColumnGuess, FloatArray], FloatArray | None] | None
):
    """Stamps or numbers of both files, and where a row of the sheet says until when it holds."""
    if file.of("time") and sheet.of("time"):
        mine, stamp = file.of("time")[0], sheet.of("time")[0]
        at, since = (seconds_by(f, c) for f, c in ((file, mine), (sheet, stamp)))
        for other in sheet.of("time")[1:2]:
            if np.all((end := seconds_by(sheet, other)) > since):
                return (mine, at), (stamp, since), end
        if (lasting := lasting_s(sheet, stamp)) is not None:
            return (mine, at), (stamp, since), since + lasting
    else:
        own = [c for c in file.of("sequence") if c.values is not None]
        counted = [c for c in sheet.of("sequence") if c.values is not None]
        if not own or not counted:
            return None
        mine, stamp = own[0], counted[0]
        at, since = numbers_of(mine), numbers_of(stamp)
        if len(counted) > 1 and np.all(numbers_of(counted[1]) >= since):
            return (mine, at), (stamp, since), numbers_of(counted[1])
    return (mine, at), (stamp, since), None


def seconds_by(file: FileGuess, column: ColumnGuess) -> FloatArray:
    """Stamps of a file in s, dates as the reader has them, shape (n,)."""
    place = ForeignColumn(
        column.column, column.unit, format=column.format, nanoseconds=column.nanoseconds,
        pattern=column.pattern, wraps_at=column.wraps_at,
    )  # fmt: skip
    return time_of(file.path, Reading({"time_s": place}, file.layout))


def lasting_s(sheet: FileGuess, stamp: ColumnGuess) -> FloatArray | None:
    """How long each row of a sheet holds in s, by a column between its stamp and the next one."""
    if stamp.values is None:
        return None
    since = stamp.values
    for column in sheet.columns:
        ends = column.values
        if ends is None or column is stamp or not np.all(ends > since):
            continue
        if np.all(ends[:-1] <= since[1:]) and ends[-1] - since[-1] < 10 * np.max(np.diff(since)):
            return (ends - since) * TIMES.get(stamp.unit or "s", 1.0)
    return None


def holds(at: FloatArray, since: FloatArray, until: FloatArray, apart: float) -> IntArray:
    """Which row of the protocol each row of a log is of, −1 where none, shape (n,)."""
    on = np.searchsorted(since, at, side="right") - 1
    before, after = np.maximum(on, 0), np.minimum(on + 1, since.size - 1)
    nearest = np.minimum(np.abs(at - since[before]), np.abs(at - since[after]))
    off = (on < 0) | (at > until[before]) | (nearest < apart)
    return np.where(off, -1, on)


def apart_of(
    at: FloatArray, since: FloatArray, ends: FloatArray, cells: list[ColumnGuess]
) -> float | None:
    """How far from a stamp the loads lie still, in s; None where they never do.

    Within a hold every reading scatters no more than three times as much as in its own middle, or
    in those of all holds as a median; then the next larger margin is taken.
    """
    shortest = float(np.min(ends - since))
    read = np.column_stack([numbers_of(c) for c in cells])

    def scatters(apart: float) -> FloatArray:
        on = holds(at, since, ends - apart, apart)  # hands are early at the end of a step, too
        parts = [read[on == k] for k in range(since.size)]
        if min(len(part) for part in parts) < _LEAST_ROWS:
            return np.empty((0, read.shape[1]))
        return np.array([np.std(part, axis=0) for part in parts])

    middles = scatters(_MARGINS[-1] * shortest)
    if not len(middles):
        return None
    still = _RESTLESS * np.maximum(middles, np.median(middles, axis=0))
    for margin, safe in zip(_MARGINS, (*_MARGINS[1:], _MARGINS[-1]), strict=True):
        each = scatters(margin * shortest)
        if len(each) and np.all(each <= still):
            return round(safe * shortest, 3) if margin else 0.0
    return None
