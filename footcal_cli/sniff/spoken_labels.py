"""Words between the numbers of lines without a header: ``L: 812 790 R: 401 377``.

Room: sniff; asked by columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.names import name_guess


def said_between(columns: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Nameless numbers of the foot that the same word before them names in every row.

    They are as they were unless both feet are named so.
    """
    side, found = "", []
    for column in columns:
        if len(column.words) == 1 and column.column.startswith("column_"):
            side = name_guess(column.words[0]).side
        plain = column.values is not None and column.column.startswith("column_") and side
        found.append(replace(column, name=replace(column.name, side=side)) if plain else column)
    named = {c.name.side for c in found if c.column.startswith("column_")}
    return found if {"left", "right"} <= named else list(columns)
