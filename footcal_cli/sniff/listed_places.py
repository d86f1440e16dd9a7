"""Places of cells, holes or hips that a text lists: ``- FL: 60, 35`` or ``| FL | 60 | 35 |``.

Room: sniff; asked by notes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path

import numpy as np

from footcal_cli.sniff.file_loads import by_letters
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.names import NameGuess, name_guess
from footcal_cli.sniff.text import TextGuess
from footcal_cli.sniff.units import LENGTHS, known_unit
from footcal_cli.sniff.vocabulary import SIDES
from footcal_cli.tables.reading import Layout

_NUMBER = r"[-+−]?(?:\d+(?:[.,]\d+)?|\.\d+)"
_BETWEEN = r"\s*(?:mm|cm|m|in)?\s*[,;|/ \t]\s*(?:[xyz]\s*[=:]\s*)?"
_NAME = r"(?P<name>[^\W_][\w./-]*(?:[ _][\w./-]+){0,2}?)"
_THREE = (
    rf"(?:[xX]\s*[=:]\s*)?(?P<x>{_NUMBER}){_BETWEEN}(?P<y>{_NUMBER})(?:{_BETWEEN}(?P<z>{_NUMBER}))?"
)
_ROW = re.compile(
    rf"^[\s|*+-]*`?{_NAME}`?\s*(?:\((?P<said>[^()|\d]*|[^\W\d]+\d+)\)\s*)?"
    rf"(?:(?P<apart>[:|=]|\bat\b)(?:[^|\d]*\|)?|(?<=\s)\s|\t)"
    rf"[\s|(\[]*{_THREE}\s*(?:mm|cm|m|in)?[\s|)\].;,]*(?:\([^()|]*\)[\s|.;,]*)?$"
)
"""A line for each place: its name, then two or three numbers and nothing else.

A remark may say what the name means: ``| VF (venstre for) | 105 | 40 |``, ``| 1 | toe | 9 | 4 |``.
Blanks alone may stand between below a line that speaks of x and y, or of a length.
"""
_ANGLE = r"(?:\s+(?:[^\W\d_]{1,4}\s+)?\d+(?:[.,]\d+)?\s*(?:°|[^\W\d_]{3,})[,:]?)?"
_INLINE = re.compile(
    rf"(?:{_NAME}|(?P<index>\[\d+\])){_ANGLE}\s*[:=]?\s*\(\s*{_THREE}\s*(?:mm|cm|m|in)?\s*\)"
)
"""Places in a sentence: ``A (60, 35), B (60, -35)``, or of a list's: ``[0] (60, 35), [1] …``.

The angle of a round plate may stand before each: ``A12 a 90 gradi (x=0, y=62)``.
"""
_UNIT = re.compile(r"(?<![\w/])(mm|cm|m|inch|inches|[\[(]in[\])])(?![\w/²^])")
"""Units of lengths; ``in`` without brackets is a word."""
_PAIR = re.compile(
    rf"(?P<open>[\[(])?\s*(?P<x>{_NUMBER})\s*(?:[;/]|,(?=\s|.*[\])]))\s*(?P<y>{_NUMBER})"
    rf"(?:\s*[;/,]\s*(?P<z>{_NUMBER}))?\s*(?:mm|cm|m|in)?\s*[\])]?"
)
"""A place in one cell of a table: ``0.085, 0.042`` below ``left (x, y)``, or in brackets."""
_RUN = re.compile(
    r"(?<!\w)(?P<first>[A-Z]|\d+)(?:\s*(?:\.{2,3}|…|[-–])\s*|\s+[^\W\d_]{1,3}\s+)"
    r"(?P<last>[A-Z]|\d+)(?!\w)[^=\d]{0,25}?"
    rf"\b(?P<axis>[xyXY])\s*=\s*(?P<list>{_NUMBER}(?:\s*[,;]\s*(?:{_NUMBER}|\.{{2,3}}|…))+)"
)
_ONE = re.compile(
    rf"(?<!\w)(?P<name>[A-Z]|\d+)\s*(?::|\bat\b)\s*(?P<axis>[xyXY])\s*=\s*(?P<number>{_NUMBER})"
)
"""Rows of holes along one axis: ``1..6 at x = -80, -40 …``, or each by itself: ``A: y = 35``.

A list may go on at its step: ``-90, -60, ..., +90``.
"""
_GOES_ON = re.compile(r"\s*[,;]\s*(?:\.{2,3}|…)\s*[,;]\s*")
_CORNER = re.compile(
    rf"(?<!\w)(?P<a>[A-Z])(?P<n>\d+)\s*[=:]\s*\(\s*\+?(?P<x>{_NUMBER})\s*[,;]\s*\+?(?P<y>{_NUMBER})"
)
_CORNERS = 2
_CIRCLE = re.compile(
    rf"(?i)\b(?:radius|rayon|radio|raggio|straal)\s+(?:of|von|de|di|van)?\s*(?P<radius>{_NUMBER})\s*"
    rf"(?P<unit>mm|cm|m)\b[^.;]{{0,25}}?(?P<angles>{_NUMBER}(?:\s*(?:,|;|and|und|et|y|e|en)\s*{_NUMBER})+)"
    r"\s*(?:°|deg\w*|grad\w*|degr[eé]s)"
)
"""Places on a circle, counter-clockwise from x: ``radius 55 mm, at 90, 210 and 330 degrees``."""
_OF_WEIGHTS = re.compile(r"(?<![\w/])(kg|g|N|lb)(?![\w/])")
_PIECE = re.compile(
    r"(?<![\w.,])(?P<name>[A-Z]{1,2}\d{0,2}|[a-z]{1,2}\d{1,2}|\d{1,3}[a-z])\s*[:=]?\s+"
    r"(?P<weight>\d+[.,]\d+)(?![\w.,]*\d)"
)
"""A hole of a grid and where it is; a weight by its name and its mass."""
_X_AND_Y = re.compile(r"(?i)\bx\b.*\by\b")
_AXES = {"x", "y"}
_HEADING_LINES = 4
_LEAST = 3


@dataclass(frozen=True)
class _Place:
    """A place in line `at`, its name, x, y (and z) as written, and what stands before it there."""

    at: int
    name: str
    numbers: Mapping[str, str | None]
    before: str = ""


def places_in(path: Path, text: str) -> FileGuess | None:
    """A sheet of the places that a text lists, each under a name of its own; None without three.

    Names that come twice are distinguished by the foot that is said before them.

    Parameters
    ----------
    path, text
        The notes, and what stands in them.
    """
    lines = text.splitlines()
    rows = [_Place(i, _called(f), f.groupdict()) for i, line in enumerate(lines)
            if (f := _ROW.match(line)) and ("|" in line) == ("|" in line[f.end("x"):f.start("y")])
            and (f["apart"] or _below_axes(lines, i))]  # fmt: skip
    rows = next((r for r in (rows, _in_cells(lines)) if len(r) >= _LEAST), _in_sentences(lines))
    names = tuple(row.name for row in rows)
    if len({*names}) < len(names):
        names = tuple(f"{_foot(row, lines)} {row.name}".strip() for row in rows)
    if len({*names}) < len(names):
        rows = _under_axes(lines)
        names = tuple(row.name for row in rows)
    if len(names) < _LEAST or len({*names}) < len(names):
        return None
    axes = "xyz" if all(row.numbers["z"] for row in rows) else "xy"
    places = [[_number(str(row.numbers[axis])) for axis in axes] for row in rows]
    return _sheet(path, names, places, lines, rows[0].at, rows[-1].at)


def _below_axes(lines: Sequence[str], at: int) -> bool:
    """Whether a line of numbers belongs to a list below one that speaks of x and y, or of a length.

    Empty lines may stand between; a line without numbers that says neither ends the list.
    """
    for line in reversed(lines[:at]):
        if _X_AND_Y.search(line) or _UNIT.search(line):
            return True
        if line.strip() and not re.search(_NUMBER, line):
            return False
    return False


def grid_in(path: Path, text: str) -> FileGuess | None:
    """A sheet of holes that letters and numbers of rows name: ``1..3 at x = 0, 40, 80; A: y = 5``.

    Which of both comes first in a name, an example in the text says; else the letter does.
    """
    at: dict[str, dict[str, dict[str, float]]] = {}
    lines = text.splitlines()
    said = [i for i, line in enumerate(lines) if _RUN.search(line) or _ONE.search(line)]
    whole = "\n".join(lines)  # a list may go on in the next line
    for found in _RUN.finditer(whole):
        names = _run(found["first"], found["last"])
        if listed := _listed(found["list"], len(names)):
            said.append(whole[: found.start()].count("\n"))
            kind = at.setdefault("1" if names[0].isdigit() else "A", {})
            kind.setdefault(found["axis"].lower(), dict(zip(names, listed, strict=True)))
    for found in (f for i in {*said} for f in _ONE.finditer(_RUN.sub("", lines[i]))):
        kind = at.setdefault("1" if found["name"].isdigit() else "A", {})
        kind.setdefault(found["axis"].lower(), {})[found["name"]] = _number(found["number"])
    axes = {kind: next(iter(own)) for kind, own in at.items() if len(own) == 1}
    if {*axes.values()} != {"x", "y"} or len(axes) != 2:
        return None
    letters, numbers = (at[kind][axes[kind]] for kind in "A1")
    first = next(iter(letters)) + next(iter(numbers))
    turned = re.search(rf"\b{first[::-1]}\b", text) and not re.search(rf"\b{first}\b", text)
    named = {(n + a if turned else a + n): {axes["A"]: v, axes["1"]: w}
             for a, v in letters.items() for n, w in numbers.items()}  # fmt: skip
    if len(named) < _LEAST:
        return None
    places = [[place["x"], place["y"]] for place in named.values()]
    return _sheet(path, tuple(named), places, lines, min(said), max(said))


def _listed(written: str, count: int) -> list[float]:
    """So many numbers of a list, with those that it leaves out; empty where it has not so many."""
    begun, *end = _GOES_ON.split(written)
    for sign in (r";", r",(?=\s)", r","):
        parts = [part.strip() for part in re.split(sign, begun)]
        if not all(re.fullmatch(_NUMBER, part) for part in (*parts, *end)):
            continue
        numbers = whole = [*map(_number, parts)]
        if end:
            whole = np.linspace(numbers[0], _number(end[-1]), count).tolist()
        if len(whole) == count and np.allclose(whole[: len(numbers)], numbers):
            return whole
    return []


def corners_in(path: Path, text: str) -> FileGuess | None:
    """A sheet of a grid's holes by two corners: ``A1 = (-135, -80), G5 = (+135, +80)``.

    The text names the steps along x and y, or one of them, so that letters are known for one axis.
    """
    lines = text.splitlines()
    said = [(i, f) for i, line in enumerate(lines) for f in _CORNER.finditer(line)]
    if len(said) != _CORNERS:
        return None
    (first, one), (last, other) = said
    letters, numbers = _run(one["a"], other["a"]), _run(one["n"], other["n"])
    ends = {axis: [_number(f[axis]) for f in (one, other)] for axis in "xy"}
    steps = {float(n.replace(",", ".")) for n in re.findall(r"\d+(?:[.,]\d+)?", text)}
    if min(len(letters), len(numbers)) < 2:
        return None
    for of_letters, of_numbers in ("xy", "yx"):
        at = {
            axis: np.linspace(ends[axis][0], ends[axis][1], len(names)).tolist()
            for axis, names in ((of_letters, letters), (of_numbers, numbers))
        }  # fmt: skip
        if any(abs(abs(row[1] - row[0]) - step) < 1e-6 for row in at.values() for step in steps):
            places = [
                {of_letters: u, of_numbers: v} for u in at[of_letters] for v in at[of_numbers]
            ]  # fmt: skip
            named = tuple(a + n for a in letters for n in numbers)
            return _sheet(path, named, [[p["x"], p["y"]] for p in places], lines, first, last)
    return None


def circle_in(path: Path, text: str) -> FileGuess | None:
    """A sheet of places on a circle by its radius and their angles; names stand in brackets.

    ``(K1, K2, K3)`` behind the angles, or numbers from 1.
    """
    whole = " ".join(text.split())
    said = _CIRCLE.search(whole)
    if said is None:
        return None
    angles = np.radians([_number(a) for a in re.findall(_NUMBER, said["angles"])])
    listed = (re.split(r"\s*[,;]\s*", inside)
              for inside in re.findall(r"\(([^()]*)\)", whole[said.end() :]))  # fmt: skip
    whole_words = (n for n in listed if len(n) == angles.size and all(w.isalnum() for w in n))
    names = next(whole_words, [str(k + 1) for k in range(angles.size)])
    if angles.size < _LEAST:
        return None
    at = _number(said["radius"]) * np.column_stack([np.cos(angles), np.sin(angles)])
    return _sheet(path, tuple(names), at.round(6).tolist(), [said[0]], 0, 0)


def pieces_in(path: Path, text: str) -> FileGuess | None:
    """A sheet of the weights that a text lists by names: ``P1 4,9987  P2 5,0012 kg``.

    Their unit stands behind one of them or in the line above.
    """
    lines = text.splitlines()
    found: dict[str, float] = {}
    units = set[str]()
    for i, line in enumerate(lines):
        own = [*_PIECE.finditer(line)]
        above = " ".join(lines[max(i - 2, 0) : i])
        near = next((f for x in (line, above) if (f := _OF_WEIGHTS.findall(x))), [])
        if len(own) < 2 or not near or "mV" in line:
            continue
        units.add(known_unit(near[0]) or "")
        found |= {f["name"]: _number(f["weight"]) for f in own}
    if len(found) < 2 or len(units) != 1:
        return None
    why, unit = f"listed in {path.name}", units.pop()
    columns = (
        ColumnGuess("name", NameGuess("other"), None, "likely", why, words=tuple(found),
                    codes=np.arange(len(found))),
        ColumnGuess("weight", NameGuess("load"), unit, "likely", why,
                    values=np.array([*found.values()])),
    )  # fmt: skip
    return FileGuess(path, TextGuess(Layout()), columns, len(found))


def _run(first: str, last: str) -> list[str]:
    """Letters or numbers from the first to the last: ``A`` … ``D``, ``1`` … ``6``."""
    if first.isdigit() and last.isdigit():
        return [str(n) for n in range(int(first), int(last) + 1)]
    return [chr(n) for n in range(ord(first[0]), ord(last[0]) + 1)]


def _number(written: str) -> float:
    return float(written.strip().replace(",", ".").replace("−", "-"))


def _sheet(
    path: Path, names: tuple[str, ...], places: Sequence[Sequence[float]],
    lines: Sequence[str], first: int, last: int,
) -> FileGuess:  # fmt: skip
    """Places (n, 2 or 3) in the unit that the lines about them name, or the whole text."""
    above = ([line] for line in reversed(lines[max(first - _HEADING_LINES, 0) : first]))
    said = ({known_unit(u) for line in some for u in _UNIT.findall(line)} & {*LENGTHS}
            for some in (lines[first : last + 1], *above, lines))  # fmt: skip
    units = next((units for units in said if units), set())
    unit = units.pop() if len(units) == 1 else None
    why = f"listed in {path.name}"
    columns = [ColumnGuess("name", NameGuess("label"), None, "likely", why, words=names,
                           codes=np.arange(len(names)))]  # fmt: skip
    for axis, numbers in zip("xyz", np.array(places).T, strict=False):
        columns.append(ColumnGuess(axis, NameGuess("hole", axis), unit, "likely", why,
                                   values=numbers))  # fmt: skip
    return FileGuess(path, TextGuess(Layout()), tuple(columns), len(names))


def _called(found: re.Match[str]) -> str:
    """The name of a place: the shorter of two, ``venstre for (VF)``, ``cell 1 (ch1)``."""
    name, said = found["name"].strip(), (found["said"] or "").strip()
    is_name = said.isupper() or said[-1:].isdigit()
    return said if is_name and " " in name and " " not in said else name


def _in_cells(lines: Sequence[str]) -> list[_Place]:
    """Places in cells of a table, under the first cell of their row and the head of their column.

    The head counts where several columns hold places: ``left (x, y)`` and ``right (x, y)``. Two
    numbers are a place in brackets, below x and y or a length, or where some are negative.
    """
    columns, head = dict[tuple[str, ...], list[tuple[int, str, re.Match[str]]]](), list[str]()
    for i, line in enumerate(lines):
        cells = [cell.strip(" `*") for cell in line.strip().strip("|").split("|")]
        if "|" not in line:  # a foot and its cells, side by side in a text without bars
            cells = re.split(r"\s{2,}|\t|(?<=\))\s+(?=\()", line.strip())
            head = ["", *head] if len(cells) == len(head) + 1 else head
        pairs = {k: f for k, cell in enumerate(cells) if k and (f := _PAIR.fullmatch(cell))}
        if len(cells) < 2 or (not pairs and not {*line} <= {*"|-: "}):
            head = cells
        for k, pair in pairs.items() if len(cells) == len(head) else ():
            columns.setdefault((*head, head[k]), []).append((i, cells[0], pair))
    columns = {
        key: own for key, own in columns.items()
        if _X_AND_Y.search(key[-1]) or _UNIT.search(key[-1])
        or any(f["open"] or {*f[0]} & {*"-−"} for _, _, f in own)
    }  # fmt: skip
    found = []
    for key, own in columns.items():
        foot = re.sub(r"\W+$", "", re.split(r"[\[(]|\bx\b", key[-1])[0])
        alone = [other[:-1] for other in columns].count(key[:-1]) == 1
        for i, name, pair in own:
            both = f"{name}_{foot}" if "|" not in lines[i] else f"{foot} {name}"
            found.append(_Place(i, name if alone else both, pair.groupdict()))
    return sorted(found, key=lambda place: place.at)


def _under_axes(lines: Sequence[str]) -> list[_Place]:
    """Places in the columns x and y (and z) of a table, named by what stands before them."""
    table = {i: [cell.strip(" `*") for cell in line.strip().strip("|").split("|")]
             for i, line in enumerate(lines) if "|" in line and re.search(r"\w", line)}  # fmt: skip
    head = next((own for own in table.values() if {*_axes_in(own)} >= _AXES), [])
    at = _axes_in(head)
    rows = {i: own for i, own in table.items() if len(own) == len(head) and
            all(re.fullmatch(_NUMBER, own[k]) for k in at.values())}  # fmt: skip
    before = [[own[k] for own in rows.values()] for k in range(min(at.values(), default=0))]
    places = [{"z": None} | {axis: own[k] for axis, k in at.items()} for own in rows.values()]
    named = zip(rows, names_of_rows(before), places, strict=False)
    return [_Place(i, name, numbers) for i, name, numbers in named]


def _axes_in(head: Sequence[str]) -> dict[str, int]:
    """Axis -> the column that is called after it: ``x``, ``y [mm]``."""
    return {f[0].lower(): k for k, cell in enumerate(head) if (f := re.match(r"[xyzXYZ]\b", cell))}


def names_of_rows(columns: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """A name of its own for each row: texts of one column, or of a foot and a cell: ``left toe``.

    Empty where no column and no two have them; numbers alone are those of holes as well.

    >>> names_of_rows([["L", "L", "R", "R"], ["toe", "heel", "toe", "heel"]])
    ('left toe', 'left heel', 'right toe', 'right heel')
    """
    for texts in columns:
        if len({*texts}) == len(texts) and re.search(r"[^\W\d_]", "".join(texts)):
            return tuple(texts)
    for one, other in permutations(columns, 2):
        words = [*dict.fromkeys(one)]
        sides = [name_guess(f"foot_{word}").side for word in words]
        sides = sides if {*sides} == {"left", "right"} else by_letters(words)
        names = [f"{sides[words.index(a)]} {b}" for a, b in zip(one, other, strict=True) if sides]
        if sides and len({*names}) == len(names):
            return tuple(names)
    return ()


def _in_sentences(lines: Sequence[str]) -> list[_Place]:
    """Places of a list in one sentence; a pair of numbers in another is none of them."""
    inline = [[*_INLINE.finditer(line)] for line in lines]
    most = max(map(len, inline), default=0)
    rows = [(i, f) for i, own in enumerate(inline) if most < _LEAST or len(own) > 1 for f in own]
    counted = [row for row in rows if row[1]["index"]]
    return [
        _Place(i, (f["name"] or f["index"]).strip(), f.groupdict(), lines[i][: f.start()])
        for i, f in (counted if len(counted) >= _LEAST else rows)
    ]


def _foot(row: _Place, lines: Sequence[str]) -> str:
    """The foot that is said last before a place, in its line or in those above."""
    before = "\n".join([*lines[max(row.at - _HEADING_LINES, 0) : row.at], row.before])
    return ["", *sides_said(before)][-1]


def sides_said(text: str) -> list[str]:
    """Left and right as a text says them, in any language; ``der`` is a word and no side."""
    words = re.findall(r"[^\W\d_]{4,}", text.lower())
    return [SIDES[word] for word in words if word in SIDES]
