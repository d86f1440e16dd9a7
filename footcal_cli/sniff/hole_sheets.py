"""A sheet that says where the holes of placements are: a name or number, x and y in each row.

Room: sniff; asked by several and placed_files.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.groups import readings
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.names import words_of
from footcal_cli.sniff.placed import ASKED, HOLES
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.sniff.shared_weight import LEAST_CELLS, LEAST_PLACES, loaded_places
from footcal_cli.sniff.units import LENGTHS, split_unit
from footcal_cli.sniff.which_cell import as_label

_LARGEST_FOOT_M = 0.5
"""Places without a unit that lie further out are in mm."""


def with_holes(
    parts: Sequence[Part], others: Sequence[FileGuess]
) -> tuple[list[Part], list[FileGuess]]:
    """Placements whose holes a sheet places (a name, x and y in each row), and the logs left."""
    left, made = [], list(parts)
    for sheet in others:
        filled = [replace(part, plan=with_sheet(part.plan, sheet)) for part in made]
        if all(new.plan is old.plan for new, old in zip(filled, made, strict=True)):
            left.append(sheet)
        made = filled
    return made, left


def with_holes_named(files: Sequence[FileGuess]) -> list[FileGuess]:
    """Logs of several cells in which a column says holes by the names that a sheet gives them."""
    sheets = [file for file in files if called_in(file)]
    return [_holes_named(file, [s for s in sheets if s is not file]) for file in files]


def _holes_named(file: FileGuess, sheets: Sequence[FileGuess]) -> FileGuess:
    if not sheets or file.of("placement", "com") or len(readings(file)) < LEAST_CELLS:
        return file
    known = [words for sheet in sheets for words in called_in(sheet)]
    for column in file.columns:
        named = column.quantity in ("label", "unknown", "other", "position", "sequence")
        label = as_label(column) if named else None
        if label is None or len(label.words) < LEAST_PLACES:
            continue
        said = {w for w in label.words if w not in loaded_places(label)[1]}
        if any(said <= words for words in known):
            hole = column.as_quantity("placement", "likely", "holes of a sheet next to it")
            return replace(file, columns=tuple(hole if c is column else c for c in file.columns))
    return file


def with_sheet(plan: LogPlan, sheet: FileGuess) -> LogPlan:
    """Placements whose holes one sheet places; the plan as it is where it does not say them all."""
    asked = plan.entries.get("hole_x_m")
    if plan.role != "placements" or asked is None or ASKED not in asked.names.values():
        return plan
    wanted = {word for word, place in asked.names.items() if place == ASKED}
    columns = {axis: along(sheet, axis) for axis in "xy"}
    for named in sheet.columns:
        rows = {text: at for at, text in enumerate(texts_of(named))}
        if not wanted <= set(rows) or len(rows) < sheet.rows:
            continue
        entries = dict(plan.entries)
        for axis, column in columns.items():
            if column is None or column is named:
                return plan
            far = float(np.nanmax(np.abs(numbers_of(column))))
            unit = column.unit or ("m" if far < _LARGEST_FOOT_M else "mm")
            names = {word: f"{numbers_of(column)[rows[word]]:.10g}" if word in wanted else place
                     for word, place in asked.names.items()}  # fmt: skip
            entries[f"hole_{axis}_m"] = replace(
                asked, unit=unit, names=names, sure="likely", why=f"by {sheet.path.name}"
            )
        return replace(plan, entries=entries, blanks=tuple(b for b in plan.blanks if b != HOLES))
    return plan


def called_in(sheet: FileGuess) -> list[set[str]]:
    """What the rows of a sheet of places are called, by each column that may say it."""
    if any(along(sheet, axis) is None for axis in "xy"):
        return []
    named = [texts_of(c) for c in sheet.columns]
    return [{*texts} for texts in named if len({*texts} - {""}) == sheet.rows]


def along(sheet: FileGuess, axis: str) -> ColumnGuess | None:
    """The one column of a sheet that is a length along an axis; None without."""
    found = [
        c for c in sheet.columns
        if c.values is not None and axis in words_of(split_unit(c.column)[0])
        and (c.unit is None or c.unit in LENGTHS)
    ]  # fmt: skip
    return found[0] if len(found) == 1 else None


def texts_of(column: ColumnGuess) -> list[str]:
    """Names or whole numbers of a sheet's rows, as they stand in a log; empty for other numbers."""
    if column.codes is not None:
        return [column.words[i] if i >= 0 else "" for i in column.codes]
    values = column.values
    if values is None or not np.array_equal(values, np.round(values)):
        return []
    return [f"{value:.0f}" for value in values]
