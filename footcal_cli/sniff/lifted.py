"""Logs of a robot in the air or of an empty plate, next to one under load: zeros of its cells.

Room: sniff; asked by several.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.bench_cells import cells_of, named_as
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import Names, escaped, loads_named
from footcal_cli.sniff.file_names import Part, called
from footcal_cli.sniff.groups import readings
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.hole_sheets import texts_of
from footcal_cli.sniff.names import name_guess, words_of
from footcal_cli.sniff.plan import Entry, LogPlan
from footcal_cli.sniff.which_cell import named_alike
from footcal_cli.tables.reading import Pivot

IN_THE_AIR = re.compile(
    "air|lift|lifted|raised|hängt|haengt|hänger|henger|wisi|висит|uitgehangen|pendu|pendue|suspendida|hang|hanging|hung|crane|hoist|suspended|zeros?|zeroes|offsets?|tare|unloaded|"
    "empty|luft|hängend|haengend|kran|leer|null|nullpunkt|unbelastet|aire|colgado|cero|grúa|grua|"
    "vacío|vacio|suspendu|levé|leve|grue|vide|zéros?|sospeso|aria|vuoto|suspenso|levantado"
)
"""Words of a log's name in which nothing lies on the cells, though it has stamps."""
_IDLE = 0.1
"""How far readings of an empty plate may spread, as a share of what they do under a weight."""

_NOTHING = 0.05
"""Share of what cells read under a robot that they read at most in the air, if they are tared."""
_NEAR_AN_END = 0.2
_AT_AN_END = 0.1
"""How far a zero may lie from the end of a cell's readings, as a share of their range."""


def with_lifted(
    parts: Sequence[Part], others: Sequence[FileGuess]
) -> tuple[list[Part], list[FileGuess]]:
    """Logs of the same cells without stamps or a body as zeros, and the logs that fit nothing."""
    cells = [part for part in parts if part.plan.role == "cells"]
    standing = [part for part in parts if part.plan.role == "placements"]
    standing = standing or [part for part in cells if _stands(part)]
    if len(standing) > 1:  # one that hangs may have the body's motion, too
        standing = [p for p in standing if not _spoken(p.plan.file) and not any(
            carries_nothing(p.plan.file, other.plan.file) for other in standing)]  # fmt: skip
        most = max((_carried(part.plan.file) for part in standing), default=0.0)
        standing = [part for part in standing if _carried(part.plan.file) > _NOTHING * most]
    if len(standing) != 1:
        return list(parts), list(others)
    made = [
        replace(part, plan=zeros)
        if part.plan.role in ("cells", "weights_stream")
        and (zeros := _zeros_in(part.plan.file, standing[0], part.plan))
        else part
        for part in parts
    ]
    left = []
    for file in others:
        zeros = _zeros_in(file, standing[0])
        if zeros is None:
            left.append(file)
        else:
            made.append(Part(zeros, (file.path,), escaped(file.path.name)))
    return made, left


def _zeros_in(file: FileGuess, standing: Part, own: LogPlan | None = None) -> LogPlan | None:
    """The plan for zeros side by side, below each other, or with a row for each foot."""
    return _zeros(file, standing, own) or _listed(file, standing) or _by_foot(file, standing)


def in_the_air_apart(group: list[FileGuess]) -> list[list[FileGuess]]:
    """Stands with the same columns in two groups where some are called after a robot in the air."""
    weighed = len(group) > 1 and loads_named(Names.of(called([file.path for file in group])))
    least = 0.0 if weighed else _NOTHING * max(map(_carried, group))  # of weights one may be 0 kg
    most = max(group, key=_moved)
    hung = [
        file for file in group
        if _spoken(file) or _carried(file) < least or carries_nothing(file, most)
    ]  # fmt: skip
    if not hung or len(hung) == len(group) or not group[0].of("time"):
        return [group]
    own = (file for file in group if all(file is not one for one in hung))
    plan = plan_of(next(own))
    if plan is None or plan.role != "cells":
        return [group]
    return [[file for file in group if all(file is not own for own in hung)], hung]


def _stands(part: Part) -> bool:
    """Whether a log is one of standing: the body's motion is in it, or it has stamps and a name."""
    stamped = "time_s" in part.plan.entries and not _spoken(part.plan.file)
    return stamped or "com_x_m" in part.plan.entries or bool(part.beside)


def _spoken(file: FileGuess, *names: str) -> bool:
    words = words_of(" ".join((file.path.stem, *names)))
    return any(IN_THE_AIR.fullmatch(word) for word in words)


def _carried(file: FileGuess) -> float:
    """What the cells of a log read, the sum of their medians: of a robot in the air next to none.

    Counts that nobody tared are far from zero either way.
    """
    return float(sum(abs(np.nanmedian(numbers_of(c))) for c in readings(file)))


def _moved(file: FileGuess) -> float:
    """How far the cells of a log move, the sum of their spreads."""
    return float(sum(np.nanstd(numbers_of(c)) for c in readings(file)))


def carries_nothing(file: FileGuess, other: FileGuess) -> bool:
    """Whether all cells of a log stand still where another log of them ends, all at the same end.

    Feet that walk carry nothing now and then; a robot that stands carries something.
    """
    at: list[float] = []
    theirs = {c.column: c for c in readings(other)}
    for cell in readings(file) if file is not other else ():
        if cell.column not in theirs:
            return False
        low, high = np.nanquantile(numbers_of(theirs[cell.column]), [0.01, 0.99])
        own = numbers_of(cell)
        if not np.isfinite(own).any() or not high - low > 0:
            return False
        if np.nanstd(own) > _IDLE * (high - low):
            return False
        at.append(float((np.nanmedian(own) - low) / (high - low)))
    ends = np.abs(np.subtract.outer([0.0, 1.0], at))
    return len(at) > 1 and bool(np.any(np.all(ends < _NEAR_AN_END, axis=1)))


def _idle(empty: ColumnGuess, loaded: ColumnGuess) -> bool:
    """Whether a cell carries nothing in one log, by how far it moves in another."""
    spans = [float(np.nanmax(v) - np.nanmin(v)) for v in map(numbers_of, (empty, loaded))]
    return spans[0] < _IDLE * spans[1]


def _zeros(file: FileGuess, standing: Part, plan: LogPlan | None) -> LogPlan | None:
    """The plan for a log of a robot in the air; None where it is of other cells, or stands.

    `plan` is what the log would be by itself: its cells may have other names than where they stand.
    """
    read = {n: e for n, e in standing.plan.entries.items() if n.endswith("_counts")}
    columns = {c.column: c for c in file.columns if c.values is not None}
    own = {n: columns.get(e.column.column) for n, e in read.items() if e.column is not None}
    if None in own.values() and plan is not None:
        alike = named_as(plan, cells_of(standing.plan))
        own |= {f"{cell}_counts": plan.entries[f"{channel}_counts"].column
                for channel, cell in alike.items()}  # fmt: skip
    found = {n: c for n, c in own.items() if c is not None}
    if file is standing.plan.file or not found or len(found) < len(own):
        return None
    plate = standing.plan.role == "placements"
    if plate and not all(_idle(found[n], e.column) for n, e in read.items() if e.column):
        return None
    bare = not file.of("load") and _carried(file) < _NOTHING * _carried(standing.plan.file)
    stamped = bool(file.of("time")) and not plate and not bare
    hangs = _spoken(file) or carries_nothing(file, standing.plan.file)
    if not hangs and (file.of("com") or stamped):
        return None
    foot = standing.plan.channels[0].partition("_")[0] if plate else ""
    entries: dict[str, Entry] = {
        f"{foot}_{name}" if plate else name: replace(read[name], column=column)
        for name, column in found.items()
    }
    where = "nothing on the plate" if plate else "the robot in the air"
    return LogPlan(
        file, f"the same cells with {where}: their zeros",
        f"the cells of {standing.paths[0].name}, without "
        + ("a body" if file.of("time") else "stamps"),
        "likely", standing.plan.command, "zeros", entries, standing.plan.channels,
    )  # fmt: skip


def _least(words: Sequence[str], said: ColumnGuess, named: Mapping[str, ColumnGuess]) -> bool:
    """Whether each cell's number is where its own readings end, the same end of all.

    Feet that walk carry nothing now and then. A list of other numbers, such as sensitivities, lies
    elsewhere.
    """
    values, ends = numbers_of(said), list[float]()
    for word, cell in named.items():
        low, high = np.nanquantile(numbers_of(cell), [0.01, 0.99])
        own = np.array([v for v, at in zip(values, words, strict=True) if at == word])
        ends += [float(v) for v in (own - low) / (high - low)] if high > low else [np.nan]
    return any(bool(np.all(np.abs(np.array(ends) - end) < _AT_AN_END)) for end in (0.0, 1.0))


def _listed(file: FileGuess, standing: Part) -> LogPlan | None:
    """The plan for a table of zeros with a row for each cell, as often as each was read.

    None where neither its names nor its numbers say so, or it names other cells.
    """
    read = {n: e for n, e in standing.plan.entries.items() if n.endswith("_counts")}
    cells = {e.column.column: n for n, e in read.items() if e.column is not None}
    columns = [e.column for e in read.values() if e.column is not None]
    numbers = [c for c in file.of("reading", "unknown", "other", "force") if c.values is not None]
    if file.of("load", "com") or file.layout.pivot:
        return None
    for label in file.columns:
        rows_of, said = Counter(texts_of(label)), [c for c in numbers if c is not label]
        if len(said) != 1 or any(c is not label for c in file.of("time")):
            continue  # a number that counts the cells may look like a clock
        if len(rows_of) != len(cells) or len({*rows_of.values()}) > 1:
            continue
        named = named_alike(tuple(rows_of), columns)
        spoken = _spoken(file, said[0].column)
        if not named or not (spoken or _least(texts_of(label), said[0], named)):
            continue
        layout = replace(file.layout, pivot=Pivot((label.column,), tuple(rows_of), ""))
        entries = {
            cells[cell.column]: replace(
                read[cells[cell.column]], column=replace(
                    said[0], column=f"{word}.{said[0].column}", wraps_at=None, missing=()
                ), unit=said[0].unit or read[cells[cell.column]].unit,
            )
            for word, cell in named.items()
        }  # fmt: skip
        return LogPlan(
            replace(file, text=replace(file.text, layout=layout)),
            "the same cells with nothing on them: their zeros", "a row for each of the cells",
            "likely", standing.plan.command, "zeros",
            {name: entries[name] for name in read if name in entries}, standing.plan.channels,
        )  # fmt: skip
    return None


def _by_foot(file: FileGuess, standing: Part) -> LogPlan | None:
    """The plan for zeros with a row for each foot, its cells side by side; None for other tables.

    Cells are called within their foot as the columns of its own log: ``data_0`` of both soles.
    """
    read = {n: e for n, e in standing.plan.entries.items() if n.endswith("_counts")}
    if file.of("time", "load", "com") or file.layout.pivot or not _spoken(file):
        return None
    for label in file.columns:
        words = texts_of(label) if label.codes is not None else []
        feet = {word: name_guess(f"{word}_foot").side for word in words}
        if len(feet) != len(words) or {*feet.values()} != {"left", "right"}:
            continue
        columns = {c.column: c for c in file.columns if c.values is not None}
        entries = {
            name: replace(entry, column=replace(
                columns[own], column=f"{word}.{own}", wraps_at=None, missing=()
            ))
            for name, entry in read.items() if entry.column is not None
            for word, side in feet.items() if name.startswith(f"{side}_")
            for own in columns if own == entry.column.column.rpartition(".")[2]
        }  # fmt: skip
        if entries.keys() == read.keys():
            layout = replace(file.layout, pivot=Pivot((label.column,), tuple(words), ""))
            return LogPlan(
                replace(file, text=replace(file.text, layout=layout)),
                "the same cells with nothing on them: their zeros", "a row for each foot",
                "likely", standing.plan.command, "zeros", entries, standing.plan.channels,
            )  # fmt: skip
    return None
