"""Entries of ``[columns]`` whose column no log has.

Room: session; asked when a log is read. A quantity that a log can do without is read where it is
there; one that a recipe names and no log has is a name that was mistyped.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from footcal_cli.errors import UsageError, nearest
from footcal_cli.recipe import Recipe
from footcal_cli.tables.columns import TableType
from footcal_cli.tables.places import Places, every_entry
from footcal_cli.tables.plates import with_plates
from footcal_cli.tables.sources import source_names


def refuse_unfound(recipe: Recipe, table: TableType, path: Path, logs: Sequence[Path]) -> None:
    """Refuse an optional column that the recipe names for a log, and that no log has.

    Parameters
    ----------
    path
        The log that is read.
    logs
        All logs of the run; one of them may have what others lack.

    Raises
    ------
    UsageError
        Names the entry, the column and the nearest one that is there.
    """
    if not path.is_file():
        return
    reading = recipe.reading(path)
    for places in every_entry(with_plates(table, reading.plates), reading, path):
        for name, column in places.not_there.items():
            others = (log for log in logs if log != path and log.is_file())
            if any(column in source_names(log, recipe.reading(log)) for log in others):
                continue
            header = source_names(path, reading)
            raise UsageError(
                f"{_key(recipe, places, table, name)} = '{column}': no log has that column"
                f"{nearest(column, header)}", file=recipe.path,
                remedy=f"name a column of {path.name}, or take the entry out",
            )  # fmt: skip


def _key(recipe: Recipe, places: Places, table: TableType, name: str) -> str:
    """Where an entry stands in a recipe: its table, the entry of a wide log, and its name."""
    for spec in recipe.files:
        for entry, own in spec.wide.items():
            into = places.found.get(spec.wide_into)
            if name in own and into is not None and into.value == entry:
                return f"[files.wide.{entry}] {name}"
    mine = any(name in spec.columns for spec in recipe.files)
    return f"[files.columns] {name}" if mine and name not in recipe.columns else f"[columns] {name}"
