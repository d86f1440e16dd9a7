"""Notes that are given among the logs: what they say stands above each table then.

Room: sniff; called by init. ``FX FY FZ [kgf], MX MY MZ [kgf.cm]``, a mass, a rate or a weight in a
``notes.md`` say what the header does not; places that it lists are a sheet of their own.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from footcal_cli.errors import DataError
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.listed_places import (
    circle_in,
    corners_in,
    grid_in,
    pieces_in,
    places_in,
)
from footcal_cli.sniff.names import FORCE, TORQUE
from footcal_cli.sniff.units import WEIGHTS, known_unit

WRITTEN = {".md", ".markdown", ".rst", ".adoc"}
"""Endings of text that people write; a ``.txt`` may be a log."""
_MAY_BE = {".txt", ".text", ""}
_LONGEST = 2**17
"""Characters of the longest notes."""
_WORD = re.compile(r"[^\W\d_]{2,}")
_SENTENCE, _PROSE = 5, 0.3
"""Words of a line that is written, and the share of such lines in notes."""
_TABLE = re.compile(r"^\s*\|?[ :]*-{3,}[ :]*\||^\s*\|.*\|", re.MULTILINE)
_PAIR = re.compile(r"^\s*\|\s*([^|]*[^\W\d][^|]*?)\s*\|\s*([^|]*\w[^|]*?)\s*\|\s*$")
"""A row of two: what is meant, and what is said of it."""
_AXES = re.compile(r"(?im)^\s*\|.*\|\s*x\b[^|]*\|\s*y\b[^|]*\|")
_MARKED = re.compile(r"^[\s#>*+-]+|[*`]+")
"""Signs of headings, lists and emphasis."""
_ENDS = re.compile(r"(?<=[;!])\s+|(?<=[^.]\.)\s+(?=[^a-z])")
"""Ends of sentences; behind ``incl.`` one goes on."""
_FORCES, _TORQUES = {*WEIGHTS, "kgf", "gf", "lbf", "daN", "ozf"}, {"Nm", "mNm", "kNm", "Nmm", "Ncm"}
_IN_FULL = re.compile(r"(?i)\b(?P<kilo>kilo)?gram(?:me?)?s?[- ]forces?")
_AXIS = r"[fmtFMT][_ ]?[xyzXYZ]"
_WORDS = "|".join(w for w in sorted(FORCE | TORQUE, key=len, reverse=True) if len(w) > 1)
_NAMED = re.compile(
    rf"(?:{_AXIS}\b|(?<!\w)[FMT](?=\s*(?:[\[(]|in\b|en\b|em\b))|(?i:\b(?:{_WORDS})s?))[^\[\](),;\n]{{0,25}}"
    r"(?:[\[(](?P<bracketed>[^\])]{1,8})[\])]|\b(?:in|en|em|ve|w|v|i)\s+(?P<spoken>[A-Za-z.*·]{1,8}))"
)
"""Forces or torques, and the unit in brackets or spoken behind them."""
_BEHIND = re.compile(
    rf"(?P<bracketed>){_AXIS}\s+(?P<spoken>(?:[A-Za-z]{{1,4}}[*·.-])?[A-Za-z]{{1,3}})(?=[\s,;.)]|$)"
)
"""A unit right behind the last axis: ``L_Fx.._Fz lbf; L_Tx.._Tz in-lbf``."""


def notes_among(paths: Sequence[Path]) -> list[Path]:
    """Files of text that people write, by their ending or sentences; one that is a log is none.

    A log alone is a log, whatever it is called.
    """
    tables = any(path.suffix.lower() not in _MAY_BE | WRITTEN for path in paths)
    found = [path for path in paths if path.is_file() and _is_written(path, tables=tables)]
    return found if len(found) < len(paths) else []


def _is_written(path: Path, *, tables: bool) -> bool:
    """Whether a file is notes; a text with sentences next to `tables` is, whatever it lists."""
    suffix = path.suffix.lower()
    if suffix in _MAY_BE:
        short = path.stat().st_size < _LONGEST and _is_prose(_text(path))
        return short and (tables or not _is_log(path))
    if suffix not in WRITTEN:
        return False
    text = _text(path)
    return not _TABLE.search(text) or _places_under_axes(path, text) or not _is_log(path)


def _is_prose(text: str) -> bool:
    """Whether many lines are sentences."""
    lines = [line for line in text.splitlines() if line.strip()]
    said = sum(len(_WORD.findall(line)) >= _SENTENCE for line in lines)
    return said >= max(_PROSE * len(lines), 2)


def _places_under_axes(path: Path, text: str) -> bool:
    """Whether the table of a text lists places, below x and y in its heading."""
    return _AXES.search(text) is not None and places_in(path, text) is not None


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace")


def _is_log(path: Path) -> bool:
    try:
        return plan_of(guess_file(path)) is not None
    except DataError:
        return False


def units_in(text: str) -> dict[str, str]:
    """``force`` and ``torque`` -> their unit, where the text names one and no other.

    >>> units_in("FX FY FZ [kgf], MX MY MZ [kgf.cm]")
    {'force': 'kgf', 'torque': 'kgf*cm'}
    """
    found: dict[str, set[str]] = {"force": set(), "torque": set()}
    plain = _IN_FULL.sub(lambda full: "kgf" if full["kilo"] else "gf", text.replace("`", ""))
    for said in (*_NAMED.finditer(plain), *_BEHIND.finditer(plain)):
        unit = known_unit((said["bracketed"] or said["spoken"]).rstrip("."))
        if unit in _FORCES:
            found["force"].add(unit)
        elif unit is not None and ("*" in unit or unit in _TORQUES):
            found["torque"].add(unit)
    return {kind: units.pop() for kind, units in found.items() if len(units) == 1}


def with_notes(files: Sequence[FileGuess], notes: Sequence[Path]) -> list[FileGuess]:
    """Logs with what the notes say above each table, and the places that these list as a sheet."""
    lines: list[str] = []
    units: dict[str, str] = {}
    texts = {path: _text(path) for path in notes}
    for text in texts.values():
        units |= units_in(text)
        said = (_PAIR.sub(r"\1: \2", line) for line in text.splitlines())
        prose = [_MARKED.sub("", x) for x in said if x.strip() and "|" not in x]
        lines += [part for line in prose for part in _ENDS.split(line) if part.strip()]
    lines += [f"{kind} unit: {unit}" for kind, unit in units.items()]
    made = [
        replace(file, text=replace(file.text, above=(*file.text.above, *lines))) for file in files
    ]
    looks = (places_in, grid_in, corners_in, circle_in, pieces_in)
    sheets = (look(path, text) for path, text in texts.items() for look in looks)
    return [*made, *(sheet for sheet in sheets if sheet is not None)]
