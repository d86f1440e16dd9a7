"""Where a table of a text ends: above a remark, a second table, or a line that sums it up.

Room: sniff; asked by text.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from itertools import islice
from pathlib import Path

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.errors import DataError
from footcal_cli.sniff.rows import Body, fields_of
from footcal_cli.sniff.silent import SUMMARY
from footcal_cli.sniff.tokens import is_moment, is_number
from footcal_cli.tables.drawn import is_rule
from footcal_cli.tables.textfiles import first_bytes

_LONGEST = 2**27
"""Bytes of a text that is looked through for a second table."""
_TITLES = 20
_HEAD, _MOST_NAMED, _A_TABLE = 8, 12, 20
"""Lines below a table that may name another one, its columns, and its rows at least."""
_NOTES = ("*", "†", "‡", "¹")
"""Signs that a footnote begins with."""
_LEAST_SUMMED = 3
"""Rows whose sum in every column is no row by chance."""
_FAR = 2.5
"""How far beyond all rows a sum lies; the next load of a series (0, 1, 2, 3) does not."""
_ROUNDED = 1e-6
"""How far a printed sum may be from the sum of printed numbers, as a share of it."""


def once_named(lines: Sequence[str], body: Body) -> list[str]:
    """Lines without those that are the header again."""
    top = body.begins_at([*lines])
    header = lines[top - 1].strip() if top else ""
    return [*lines[:top], *(x for x in lines[top:] if not header or x.strip() != header)]


def ends(until: str, lines: list[str], body: Body) -> str:
    """What is said of a table that ends above a line: how many rows like its own it leaves out."""
    at = next(
        i for i, x in enumerate(lines)
        if x.lstrip(" \t").startswith(until) and i >= body.begins_at(lines)
    )  # fmt: skip
    lost = sum(body.is_row(line, whole=True) for line in lines[at:])
    return f"the table ends above '{until}'" + not_read(lines[at:], lost, body)


def not_read(below: Sequence[str], lost: int, body: Body) -> str:
    """What is said of rows below a table's end: how many, under which names, and what to do."""
    if not lost:
        return ""
    named = [fields_of(line, body.separator) for line in below[:_HEAD]]
    words = [[f for f in row if re.fullmatch(r"[^\W\d][\w .:-]*", f)] for row in named]
    most = max(words, key=lambda row: len({*row}), default=[])
    plain = f", {lost} rows below it are not read"
    if lost < _A_TABLE or not 2 < len({*most}) <= _MOST_NAMED:
        return plain
    return (
        f"{plain} ({', '.join(dict.fromkeys(most))}): a table that belongs to it goes into a file "
        "of its own, with stamps in both, and init gets both"
    )


def end(lines: list[str], body: Body, comment: str) -> tuple[str, list[str]]:
    """What the line begins with above which the table ends, and its fields; empty if it goes on.

    A remark below the rows, or a second table: two lines that are no rows, or none after it.
    """
    first = body.begins_at(lines)
    if total := _sums_up(lines[first:], body):
        return total, []
    written = [
        line for line in lines[first:]
        if line.strip(f" \t\r\n{body.separator}") and not is_rule(line)
        and not (comment and line.lstrip().startswith(comment))
    ]  # fmt: skip
    rows = [body.is_row(line) for line in written]
    for at, line in enumerate(written):
        fields = fields_of(line, body.separator)
        word = fields[0] if fields else ""
        ends = not any(rows[at : at + 2]) if at + 1 < len(rows) else not rows[at]
        noted = word[:1] in _NOTES and bool(fields[1:] or word[1:])
        said = noted or re.search(r"[^\W\d]", word) is not None
        said = said and not (is_number(word, ".") or is_moment(word))
        if not rows[at] and ends and said:
            return word, fields
        if not rows[at] and not ends:
            break
    return "", []


def far_end(path: Path, encoding: str, seen: int, body: Body) -> tuple[str, int]:
    """What a long text's table ends above, where only its begin was looked at, and rows below it.

    A motion capture's markers stand in a table of their own below ten thousand rows of its plates.
    Of the lines that begin with a letter the first is taken that two others that are no rows
    follow: a title, its rate and its names.

    Parameters
    ----------
    seen
        Bytes at the begin of the file that were looked at.
    body
        Rows of the table.
    """
    if path.stat().st_size > _LONGEST:
        return "", 0
    rest = first_bytes(path, _LONGEST)[seen:].decode(encoding, errors="replace")
    title = re.compile(r"^[\"']?([^\W\d_][^\r\n]*)", re.MULTILINE)
    for found in islice(title.finditer(rest), _TITLES):
        lines = [x for x in rest[found.start() :].splitlines() if x.strip(f" \t{body.separator}")]
        if any(map(body.is_row, lines[:3])):
            continue
        word = fields_of(lines[0], body.separator)[0]
        return word, sum(body.is_row(line, whole=True) for line in lines)
    return "", 0


def _sums_up(lines: list[str], body: Body) -> str:
    """What the first of the last lines begins with that sum up those above; empty without."""
    rows = [line for line in lines if body.is_row(line)]
    table = [fields_of(line, body.separator)[: body.width] for line in rows]
    worded = [
        next((f for i, f in enumerate(row) if i not in body.numeric and SUMMARY.fullmatch(f)), "")
        for row in table
    ]  # fmt: skip
    first = len(rows)
    while first > 0 and worded[first - 1]:
        first -= 1
    if first == len(rows) and first > _LEAST_SUMMED and _is_sum(table, body):
        first -= 1
    if not _LEAST_SUMMED <= first < len(rows) or any(worded[:first]):
        return ""
    line = rows[first].lstrip(" \t")
    begin = line[: line.index(worded[first]) + len(worded[first])] if worded[first] else line
    others = (row.lstrip(" \t").startswith(begin) for row in rows[:first])
    return "" if any(others) else begin


def _is_sum(table: list[list[str]], body: Body) -> bool:
    """Whether the last row holds the sum of all above it in every column of numbers."""
    if len(body.numeric) < 2 or body.spoken:
        return False
    try:
        first, last = _numbers(table[:: len(table) - 1], body)
        if np.any(np.abs(last) < np.abs(first)):  # most logs: their rows are many
            return False
        above = _numbers(table[:-1], body)
    except ValueError:
        return False
    total = above.sum(axis=0)
    far = np.abs(total) > _FAR * np.abs(above).max(axis=0)
    return bool(np.all(far) and np.allclose(total, last, rtol=_ROUNDED))


def _numbers(table: list[list[str]], body: Body) -> FloatArray:
    """Columns of numbers of some rows; raises ValueError where one holds none."""
    return np.array([
        [float(row[i].replace(body.thousands or "\0", "").replace(body.decimal, "."))
         for i in body.numeric] for row in table
    ])  # fmt: skip


def refuse_said_below(
    path: Path, lines: list[str], is_row: Callable[[str], object], carried: str
) -> None:
    """Refuse remarks that say a load, where the first rows have none and the last remark no rows.

    Raises
    ------
    DataError
        They are such: each seems to be of the rows above it.
    """
    said = [i for i, line in enumerate(lines) if carried and re.search(carried, line)]
    rows = [i for i, line in enumerate(lines) if i not in said and is_row(line)]
    if said and rows and rows[0] < said[0] and rows[-1] < said[-1]:
        raise DataError(
            f"'{lines[said[-1]].strip()}' stands below the last reading, and no such remark above "
            "the first: each seems to be of the readings above it",
            file=path, remedy="write what lay on the sensor above its readings, or next to each "
            "of them (load_kg), and run init again",
        )  # fmt: skip
