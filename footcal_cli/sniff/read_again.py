"""Sheets of cells that were read several times under each load: up and down, or twice in a row.

Room: sniff; asked by weights. A column names the cell of each row, and the readings of a row agree
far better than they move under the loads, whatever they are called.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, codes_of, numbers_of
from footcal_cli.sniff.names import common_start
from footcal_cli.sniff.one_cell import in_one_row
from footcal_cli.sniff.plan import Blank, Entry, LogPlan, of, reading_entry
from footcal_cli.sniff.texts import directions_of
from footcal_cli.sniff.units import split_unit
from footcal_cli.tables.reading import READ_AGAIN

_AGAIN = 0.02
"""How far readings of one row may be apart, by how far those of the cell move."""
_A_WORD = re.compile(r"[^\W\d_]{3,}")


def read_again(
    file: FileGuess, load: ColumnGuess, entries: Mapping[str, Entry],
    labels: Sequence[ColumnGuess], cells: Sequence[ColumnGuess], asked: tuple[Blank, ...],
) -> LogPlan | None:  # fmt: skip
    """The plan for a sheet of cells read again in each row; None where no column names the cells.

    Parameters
    ----------
    load, labels, cells
        Columns of a known load, of texts and of readings, shape (n,) each.
    entries, asked
        What the plan has besides them.
    """
    ways = directions_of([split_unit(c.column)[0] for c in cells]) if len(cells) == 2 else {}
    if not ways and not _A_WORD.search(common_start([c.column for c in cells])):
        return None
    label = next((c for c in labels if _agree(c, cells)), None)
    if label is None:
        return None
    first = codes_of(label) == 0
    own = [replace(c, values=numbers_of(c)[first]) for c in cells]
    once = in_one_row(replace(load, values=numbers_of(load)[first]), own)
    into = "direction" if ways else READ_AGAIN if once else "repeat"
    keys = [*ways.values()] if ways else [str(i) for i in range(1, len(cells) + 1)]
    wide = {key: {"counts": reading_entry(c)} for key, c in zip(keys, cells, strict=True)}
    return LogPlan(
        file, f"known weights, {len(cells)} readings of a cell in each row",
        "readings of a row that agree, and a column of cells", "likely", "offline-fit", "weights",
        {**entries, "channel": of(label)}, label.words, wide, into,
        blanks=asked,
    )  # fmt: skip


def _agree(label: ColumnGuess, cells: Sequence[ColumnGuess]) -> bool:
    """Whether the readings of each row are alike, by how far they move in the rows of each word."""
    codes = codes_of(label)
    if len(label.words) < 2 or any(numbers_of(c).size != codes.size for c in cells):
        return False
    table = np.column_stack([numbers_of(c) for c in cells])
    if not np.isfinite(table).any(axis=1).all():  # at the top of a ladder there is no way down
        return False
    apart = np.nanmax(table, axis=1) - np.nanmin(table, axis=1)
    middle = np.nanmean(table, axis=1)
    groups = [codes == i for i in range(len(label.words))]
    return all(apart[rows].max() < _AGAIN * np.ptp(middle[rows]) for rows in groups if rows.any())
