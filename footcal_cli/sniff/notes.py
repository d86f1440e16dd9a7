"""Units of forces and torques from notes that are given among the logs.

Room: sniff; called by init. ``FX FY FZ [kgf], MX MY MZ [kgf.cm]`` in a ``notes.md`` says what the
header does not: it is put above each table, where software of transducers writes it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.names import FORCE, TORQUE
from footcal_cli.sniff.units import WEIGHTS, known_unit

_SUFFIXES = {".md", ".markdown", ".rst", ".adoc"}
"""Endings of text that people write; a ``.txt`` may be a log."""
_TABLE = re.compile(r"^\s*\|?[ :]*-{3,}[ :]*\||^\s*\|.*\|", re.MULTILINE)
_FORCES, _TORQUES = {*WEIGHTS, "kgf", "gf", "lbf", "daN", "ozf"}, {"Nm", "mNm", "kNm", "Nmm", "Ncm"}
_IN_FULL = re.compile(r"(?i)\b(?P<kilo>kilo)?gram(?:me?)?s?[- ]forces?")
_AXIS = r"[fmtFMT][_ ]?[xyzXYZ]"
_WORDS = "|".join(w for w in sorted(FORCE | TORQUE, key=len, reverse=True) if len(w) > 1)
_NAMED = re.compile(
    rf"(?:{_AXIS}\b|(?i:\b(?:{_WORDS})s?))[^\[\](),;\n]{{0,25}}"
    r"(?:[\[(](?P<bracketed>[^\])]{1,8})[\])]|\b(?:in|en|w|v|i)\s+(?P<spoken>[A-Za-z.*·]{1,8}))"
)
"""Forces or torques, and the unit in brackets or spoken behind them."""


def is_notes(path: Path) -> bool:
    """Whether a file is text that people write, by its ending; one with a table may be a log."""
    if path.suffix.lower() not in _SUFFIXES or not path.is_file():
        return False
    return not _TABLE.search(path.read_text(encoding="utf-8", errors="replace"))


def units_in(text: str) -> dict[str, str]:
    """``force`` and ``torque`` -> their unit, where the text names one and no other.

    >>> units_in("FX FY FZ [kgf], MX MY MZ [kgf.cm]")
    {'force': 'kgf', 'torque': 'kgf*cm'}
    """
    found: dict[str, set[str]] = {"force": set(), "torque": set()}
    plain = _IN_FULL.sub(lambda full: "kgf" if full["kilo"] else "gf", text.replace("`", ""))
    for said in _NAMED.finditer(plain):
        unit = known_unit((said["bracketed"] or said["spoken"]).rstrip("."))
        if unit in _FORCES:
            found["force"].add(unit)
        elif unit is not None and ("*" in unit or unit in _TORQUES):
            found["torque"].add(unit)
    return {kind: units.pop() for kind, units in found.items() if len(units) == 1}


def with_notes(files: Sequence[FileGuess], notes: Sequence[Path]) -> list[FileGuess]:
    """Logs with the units that the notes say above each table."""
    said: dict[str, str] = {}
    for path in notes:
        said |= units_in(path.read_text(encoding="utf-8", errors="replace"))
    lines = [f"{kind} unit: {unit}" for kind, unit in said.items()]
    return [
        replace(file, text=replace(file.text, above=(*file.text.above, *lines))) for file in files
    ]
