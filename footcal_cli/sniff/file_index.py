"""Logs of known weights in many files, and an index: of each file its cell, its round or session.

Room: sniff; asked by several.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from footcal_cli.sniff.cells_by_files import with_channel
from footcal_cli.sniff.columns import as_it_stands
from footcal_cli.sniff.file_loads import Names
from footcal_cli.sniff.file_names import Part, called
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.indexed import everywhere, rows_of_files, text_at
from footcal_cli.sniff.names import name_guess, words_of
from footcal_cli.sniff.plan import Entry, cell_name
from footcal_cli.sniff.vocabulary import OF_A_ROW

_LEAST_FILES = 2
_ROLES = ("weights", "weights_stream")


def with_index(
    parts: Sequence[Part], others: Sequence[FileGuess]
) -> tuple[list[Part], list[FileGuess]]:
    """Weights whose cell and round an index says of each file, and the logs left."""
    made, left = list(parts), []
    for sheet in others:
        plain = as_it_stands(sheet)
        filled = [_by_index(part, plain) for part in made]
        if all(new is old for new, old in zip(filled, made, strict=True)):
            left.append(sheet)
        made = filled
    return made, left


def _by_index(part: Part, sheet: FileGuess) -> Part:
    """One part as an index says it; the part itself where that has no row for each of its files."""
    plan, names = part.plan, Names.of(called(part.paths))
    read = {name for name in plan.entries if name == "counts" or name.endswith("_counts")}
    if plan.role not in _ROLES or len(part.paths) < _LEAST_FILES or plan.wide or len(read) != 1:
        return part
    for key in sheet.columns:
        rows = rows_of_files(key, names, part.paths) if key.codes is not None else None
        if rows is None:
            continue
        said = [c for c in sheet.columns if c is not key and everywhere(c)]
        cell = next((c for c in said if _tells_cells(c, rows, names)), None)
        why = f"by {sheet.path.name}"
        if cell is not None:
            texts = [text_at(cell, row) for row in rows]
            named = {t: cell_name(t) for t in texts}
            by_file = dict(zip(names.middle, (named[t] for t in texts), strict=True))
            plan = with_channel(plan, by_file, names.expression, why)
            plan = replace(plan, channels=tuple(dict.fromkeys(named.values())))
        entries = dict(plan.entries)
        for quantity in ("repeat", "session"):
            for column in [c for c in said if c.quantity == quantity][:1]:
                words = [text_at(column, row) for row in rows]
                entries[quantity] = Entry(
                    file_name=names.expression, why=why,
                    names={m: w for m, w in zip(names.middle, words, strict=True) if m != w},
                )  # fmt: skip
        if entries != plan.entries or cell is not None:
            return replace(part, plan=replace(plan, entries=entries))
    return part


def _tells_cells(column: ColumnGuess, rows: Sequence[int], names: Names) -> bool:
    """Whether a column of an index says the cells: it is called so, or the files' names say it."""
    if len({text_at(column, row) for row in rows}) < _LEAST_FILES:
        return False
    if {*words_of(column.column)} & {*OF_A_ROW} or name_guess(column.column).quantity == "label":
        return True
    parts = [re.split(r"[\W_]+", word) for word in names.middle]
    each = zip(rows, parts, strict=True)
    return column.codes is not None and all(text_at(column, row) in own for row, own in each)
