"""Files of one reading each whose names say a cell and a load, or whose first lines say the load.

Room: sniff; asked by file_names. The readings say whether the words are cells.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.readings import straightness
from footcal_cli.sniff.groups import readings
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.names import NameGuess
from footcal_cli.sniff.plan import Entry, LogPlan, of, reading_entry
from footcal_cli.sniff.units import MASSES, WEIGHTS, known_unit
from footcal_cli.sniff.which_cell import followers

_WEIGHT = re.compile(
    r"(?<![A-Za-z0-9.])(\d+(?:[.,p]\d+)?)[ _]?(kg|g|N|kN|mN|lbs?|oz|mg)(?![A-Za-z0-9])",
    re.IGNORECASE,
)
_NOTHING = re.compile(
    r"(?<![A-Za-z])(?:tare|zero|empty|no[ _]?load|unloaded|leer|null)(?![A-Za-z])"
)
_NO_CELL = re.compile(
    r"(?<![^\W\d_])(?:run|trial|rep|copy|kopie|lauf|up|down|upwards?|downwards?|loading|unloading|"
    r"increasing|decreasing|auf|ab|aufwärts|abwärts|belastung|entlastung|subida|bajada|sube|baja|"
    r"montée|montee|descente|charge|décharge|salita|discesa|carico|scarico)(?![^\W\d_])|[\W\d_]+",
    re.IGNORECASE,
)
"""What the name of a file says beside a cell and a load: runs, and which way loads went."""
_ONE_LINE = 0.999
"""How much of the readings one line explains if they are of one cell."""


def cell_and_load(
    group: Sequence[FileGuess], words: Sequence[str], expression: str
) -> LogPlan | None:
    """The plan for files whose names say a cell and a load; None without.

    Where all cells are read in each file, the readings say which of them a name is of.

    Parameters
    ----------
    group
        The logs.
    words, expression
        What tells their names apart, with its unit where all have one, and the regular expression
        that finds it.
    """
    several = len(readings(group[0])) > 1
    said = [_said(word, numbered=several) for word in words]
    found = [one for one in said if one is not None]
    if len(found) < len(said):
        return None
    loads, units, cells = (list(part) for part in zip(*found, strict=True))
    spelled = {unit for unit in units if unit}
    sizes = next((s for s in (MASSES, WEIGHTS) if spelled and spelled <= s.keys()), None)
    if sizes is None or len({*cells}) < 2 or not all(cells):
        return None
    load = np.array(
        [n * sizes[u or next(iter(spelled))] for n, u in zip(loads, units, strict=True)]
    )
    each = {cell: np.array([c == cell for c in cells]) for cell in dict.fromkeys(cells)}
    if any(np.unique(load[own]).size < 2 for own in each.values()):
        return None
    unit = "kg" if sizes is MASSES else "N"
    if several:
        return _all_read(group, dict(zip(words, zip(cells, load, strict=True), strict=True)), unit,
                         expression)  # fmt: skip
    read = np.array([np.nanmedian(numbers_of(readings(file)[0])) for file in group])
    if straightness(load, read) > _ONE_LINE:
        return None  # the words are of runs
    channels = dict(zip(words, cells, strict=True))
    put = {word: f"{n:.10g}" for word, n in zip(words, load, strict=True)}
    return LogPlan(
        group[0], "known weights, a file for each cell and weight", "the files' names say both",
        "likely", "offline-fit", "weights", {
            "load_n": _by_name(expression, put, unit),
            "channel": _by_name(expression, channels),
            "counts": reading_entry(readings(group[0])[0]),
        }, tuple(each),
    )  # fmt: skip


def _all_read(
    group: Sequence[FileGuess], said: Mapping[str, tuple[str, float]], unit: str, expression: str
) -> LogPlan | None:
    """A file for each cell and weight in which all cells are read; None where none alone moves."""
    names = tuple(dict.fromkeys(cell for cell, _ in said.values()))
    codes = np.array([names.index(cell) for cell, _ in said.values()])
    load = np.array([put for _, put in said.values()])
    first = readings(group[0])
    medians = np.array([[np.nanmedian(numbers_of(c)) for c in readings(f)] for f in group])
    table = [replace(c, values=medians[:, i]) for i, c in enumerate(first)]
    put = ColumnGuess("load", NameGuess("load"), unit, "likely", "the files' names", values=load)
    on = followers(put, replace(put, values=None, words=names, codes=codes), table)
    if len(on) < len(names):
        return None
    columns = {c.column: c for c in first}
    wide = {
        cell: {
            "load_n": _by_name(
                expression, {w: f"{n if c == cell else 0:.10g}" for w, (c, n) in said.items()}, unit
            ),
            "counts": reading_entry(columns[column.column]),
        }
        for cell, column in on.items()
    }
    return LogPlan(
        group[0], "known weights, a file for each cell and weight, all cells read",
        "the files' names say both", "likely", "offline-fit", "weights", {}, tuple(on), wide,
    )  # fmt: skip


def _by_name(expression: str, names: Mapping[str, str], unit: str | None = None) -> Entry:
    return Entry(file_name=expression, unit=unit, names=names, why="the files' names")


def _said(word: str, *, numbered: bool = False) -> tuple[float, str, str] | None:
    """Load, its unit and the cell of a name; None where it does not say one load.

    `numbered`: a number that is no load may be that of the cell.
    """
    found = list(_WEIGHT.finditer(word))
    nothing = _NOTHING.search(word.lower())
    if len(found) > 1 or not (found or nothing):
        return None
    rest = _WEIGHT.sub(" ", word) if found else _NOTHING.sub(" ", word.lower())
    cell = "_".join(_NO_CELL.sub(" ", rest).lower().split())
    if numbered and (digits := re.search(r"\d+", rest)):
        cell = f"{cell}{digits[0]}"
    if not found:
        return 0.0, "", cell
    number = float(found[0][1].lower().replace("p", ".").replace(",", "."))
    return number, known_unit(found[0][2]) or "", cell


_WORDS = (
    r"(?:known |applied |test )?(?:mass|load|weight|gewicht|masse|last|poids|charge|peso|carga)"
)
_UNIT = "|".join(sorted(({*MASSES, *WEIGHTS, "lbs"}), key=len, reverse=True))
_HEAD = (
    rf"^[\s#%;/]*(?i:{_WORDS})[^\d\n:=]{{0,20}}[:=]\s*(?P<load>\d+(?:[.,]\d+)?\s?(?:{_UNIT}))\s*$"
)
"""``# mass: 500 g`` above the rows of a file."""


def load_above(group: Sequence[FileGuess]) -> LogPlan | None:
    """The plan for files of one cell, each with its load in a line above the rows; None without."""
    found = [[m for x in file.text.above if (m := re.search(_HEAD, x))] for file in group]
    if any(len(own) != 1 for own in found):
        return None
    said = [own[0]["load"] for own in found]
    units = {known_unit(re.sub(r"[\d.,\s]+", "", text)) for text in said}
    layout, line = group[0].layout, found[0][0].string
    if len({*said}) < 2 or len(units) != 1 or layout.carried or layout.line:
        return None
    # a line that holds below is not counted among those that are left out
    counted = not (layout.comment and line.lstrip().startswith(layout.comment))
    layout = replace(layout, carried=_HEAD, skip_rows=layout.skip_rows - counted)
    file = replace(group[0], text=replace(group[0].text, layout=layout))
    load = ColumnGuess("load", NameGuess("load"), units.pop(), "likely", "a line above the rows",
                       pattern=r"([-+]?[\d.,]+)")  # fmt: skip
    return LogPlan(
        file, "known weights, a file for each", "a load in a line above the rows", "likely",
        "offline-fit", "weights", {
            "load_n": of(load), "channel": Entry(value="cell", why="one cell alone"),
            "counts": reading_entry(readings(group[0])[0]),
        }, ("cell",),
    )  # fmt: skip
