"""Places of cells, holes or hips that a text lists: ``- FL: 60, 35`` or ``| FL | 60 | 35 |``.

Room: sniff; asked by notes.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.names import NameGuess
from footcal_cli.sniff.text import TextGuess
from footcal_cli.sniff.units import LENGTHS, known_unit
from footcal_cli.tables.reading import Layout

_NUMBER = r"[-+−]?\d+(?:[.,]\d+)?"
_BETWEEN = r"\s*(?:mm|cm|m|in)?\s*[,;|/ \t]\s*(?:[xyz]\s*[=:]\s*)?"
_NAME = r"(?P<name>[^\W_][\w./-]*(?:[ _][\w./-]+){0,2}?)"
_THREE = (
    rf"(?:[xX]\s*[=:]\s*)?(?P<x>{_NUMBER}){_BETWEEN}(?P<y>{_NUMBER})(?:{_BETWEEN}(?P<z>{_NUMBER}))?"
)
_ROW = re.compile(
    rf"^[\s|*+-]*`?{_NAME}`?\s*(?:[:|=]|\bat\b)[\s|(\[]*{_THREE}\s*(?:mm|cm|m|in)?[\s|)\].;,]*$"
)
"""A line for each place: its name, then two or three numbers and nothing else."""
_INLINE = re.compile(
    rf"(?:{_NAME}|(?P<index>\[\d+\]))\s*[:=]?\s*\(\s*{_THREE}\s*(?:mm|cm|m|in)?\s*\)"
)
"""Places in a sentence: ``A (60, 35), B (60, -35)``, or of a list's: ``[0] (60, 35), [1] …``."""
_UNIT = re.compile(r"(?<![\w/])(mm|cm|m|inch|inches|[\[(]in[\])])(?![\w/²^])")
"""Units of lengths; ``in`` without brackets is a word."""
_HEADING_LINES = 4
_LEAST = 3


def places_in(path: Path, text: str) -> FileGuess | None:
    """A sheet of the places that a text lists, each under a name of its own; None without three.

    Parameters
    ----------
    path, text
        The notes, and what stands in them.
    """
    lines = text.splitlines()
    rows = [(i, found) for i, line in enumerate(lines) if (found := _ROW.match(line))]
    if len(rows) < _LEAST:
        inline = [[(i, found) for found in _INLINE.finditer(line)] for i, line in enumerate(lines)]
        most = max(map(len, inline), default=0)
        # of a list in one sentence, a pair of numbers in another is none
        rows = [row for own in inline if most < _LEAST or len(own) > 1 for row in own]
        counted = [row for row in rows if row[1]["index"]]
        rows = counted if len(counted) >= _LEAST else rows
    names = tuple((found["name"] or found.groupdict()["index"]).strip() for _, found in rows)
    if len(names) < _LEAST or len({*names}) < len(names):
        return None
    axes = "xyz" if all(found["z"] for _, found in rows) else "xy"
    about = lines[max(rows[0][0] - _HEADING_LINES, 0) : rows[-1][0] + 1]
    units = {known_unit(u) for line in about for u in _UNIT.findall(line)} & {*LENGTHS}
    unit = units.pop() if len(units) == 1 else None
    why = f"listed in {path.name}"
    columns = [ColumnGuess("name", NameGuess("label"), None, "likely", why, words=names,
                           codes=np.arange(len(names)))]  # fmt: skip
    for axis in axes:
        numbers = [float(f[axis].replace(",", ".").replace("−", "-")) for _, f in rows]
        columns.append(ColumnGuess(axis, NameGuess("hole", axis), unit, "likely", why,
                                   values=np.array(numbers)))  # fmt: skip
    return FileGuess(path, TextGuess(Layout()), tuple(columns), len(names))
