"""Logs of a robot in the air or of an empty plate, next to one under load: zeros of its cells.

Room: sniff; asked by several.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import escaped
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.hole_sheets import texts_of
from footcal_cli.sniff.names import words_of
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


def with_lifted(
    parts: Sequence[Part], others: Sequence[FileGuess]
) -> tuple[list[Part], list[FileGuess]]:
    """Logs of the same cells without stamps or a body as zeros, and the logs that fit nothing."""
    cells = [part for part in parts if part.plan.role == "cells"]
    standing = [part for part in parts if part.plan.role == "placements"]
    standing = standing or [part for part in cells if _stands(part)]
    if len(standing) > 1:  # one that hangs may have the body's motion, too
        standing = [part for part in standing if not _spoken(part.plan.file)]
    if len(standing) != 1:
        return list(parts), list(others)
    made = [
        replace(part, plan=zeros)
        if part.plan.role in ("cells", "weights_stream")
        and (zeros := _zeros(part.plan.file, standing[0]) or _listed(part.plan.file, standing[0]))
        else part
        for part in parts
    ]
    left = []
    for file in others:
        zeros = _zeros(file, standing[0]) or _listed(file, standing[0])
        if zeros is None:
            left.append(file)
        else:
            made.append(Part(zeros, (file.path,), escaped(file.path.name)))
    return made, left


def in_the_air_apart(group: list[FileGuess]) -> list[list[FileGuess]]:
    """Stands with the same columns in two groups where some are called after a robot in the air."""
    hung = [file for file in group if _spoken(file)]
    if not hung or len(hung) == len(group) or not group[0].of("time"):
        return [group]
    plan = plan_of(next(file for file in group if not _spoken(file)))
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


def _idle(empty: ColumnGuess, loaded: ColumnGuess) -> bool:
    """Whether a cell carries nothing in one log, by how far it moves in another."""
    spans = [float(np.nanmax(v) - np.nanmin(v)) for v in map(numbers_of, (empty, loaded))]
    return spans[0] < _IDLE * spans[1]


def _zeros(file: FileGuess, standing: Part) -> LogPlan | None:
    """The plan for a log of a robot in the air; None where it is of other cells, or stands."""
    read = {n: e for n, e in standing.plan.entries.items() if n.endswith("_counts")}
    own = {c.column: c for c in file.columns if c.values is not None}
    wanted = [e.column.column for e in read.values() if e.column is not None]
    if file is standing.plan.file or not wanted or not set(wanted) <= set(own):
        return None
    plate = standing.plan.role == "placements"
    if plate and not all(_idle(own[e.column.column], e.column) for e in read.values() if e.column):
        return None
    if not _spoken(file) and (file.of("com") or (file.of("time") and not plate)):
        return None
    foot = standing.plan.channels[0].partition("_")[0] if plate else ""
    entries: dict[str, Entry] = {
        f"{foot}_{name}" if plate else name: replace(entry, column=own[entry.column.column])
        for name, entry in read.items() if entry.column is not None
    }  # fmt: skip
    where = "nothing on the plate" if plate else "the robot in the air"
    return LogPlan(
        file, f"the same cells with {where}: their zeros",
        f"the cells of {standing.paths[0].name}, without "
        + ("a body" if file.of("time") else "stamps"),
        "likely", standing.plan.command, "zeros", entries, standing.plan.channels,
    )  # fmt: skip


def _listed(file: FileGuess, standing: Part) -> LogPlan | None:
    """The plan for a table of zeros with a row for each cell, as often as each was read.

    None where it is none by its names, or names other cells.
    """
    read = {n: e for n, e in standing.plan.entries.items() if n.endswith("_counts")}
    cells = {e.column.column: n for n, e in read.items() if e.column is not None}
    columns = [e.column for e in read.values() if e.column is not None]
    said = [c for c in file.of("reading", "unknown", "other", "force") if c.values is not None]
    if file.of("time", "load", "com") or file.layout.pivot or len(said) != 1:
        return None
    if not _spoken(file, said[0].column):
        return None
    for label in file.columns:
        rows_of = Counter(texts_of(label) if label.codes is not None else [])
        if len(rows_of) != len(cells) or len({*rows_of.values()}) > 1:
            continue
        named = named_alike(tuple(rows_of), columns)
        if not named:
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
