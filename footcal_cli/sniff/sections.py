"""Texts of several blocks of rows: a block for each cell, or for each frame of a pressure mat."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from footcal_cli.errors import DataError
from footcal_cli.sniff.ends import once_named
from footcal_cli.sniff.names import common_start, is_label, words_of
from footcal_cli.sniff.rows import Body

_MOST = 25
_FRAMES = 5
"""So many numbered blocks of as many rows each are frames."""
_NUMBERED = re.compile(r"^\W*([^\W\d][\w .-]*?)\W*(\d+)\W*$")


def sections(lines: Sequence[str], body: Body) -> str:
    """A regular expression for lines that name the block below them; empty without such blocks.

    The header stands below each of these lines again, or they begin with the same word for a
    sensor (``Cell FL``, ``Cell FR``).

    Parameters
    ----------
    lines
        Of the whole text.
    body
        Its rows.
    """
    titles, again = _titles(lines, body)
    if not 1 < len(titles) <= _MOST or len(set(titles)) < len(titles):
        return ""
    head = re.sub(r"\w+$", "", common_start(titles))
    if not again and not any(map(is_label, words_of(head))):
        return ""
    names = [title[len(head) :].strip(" \t:;,=*#[]()-") for title in titles]
    if not all(names) or len(set(names)) < len(names):
        return ""
    called = "|".join(map(re.escape, sorted(names, key=len, reverse=True)))
    return rf"^\s*{re.escape(head)}\W*(?P<channel>{called})\W*$"


def _titles(lines: Sequence[str], body: Body) -> tuple[list[str], bool]:
    """Lines just above blocks of rows, a line of names between left out; whether it is repeated."""
    written = [line.strip() for line in lines if line.strip()]
    rows = [body.is_row(line) for line in written]
    starts = [i for i, row in enumerate(rows) if row and (i == 0 or not rows[i - 1])]
    if len(starts) < 2 or not starts[0]:
        return [], False
    header = written[starts[0] - 1]
    again = all(written[i - 1] == header for i in starts)
    at = [i - 1 - again for i in starts]
    if any(i < 0 or rows[i] for i in at):
        return [], False
    if any(not rows[i - 1] for i in at[1:]):
        return [], False  # more than a title between the blocks
    return [written[i] for i in at], again


def refuse_frames(path: Path, lines: Sequence[str], body: Body) -> None:
    """Refuse a matrix of numbers per frame, as pressure mats write them: its rows are no samples.

    Raises
    ------
    DataError
        It is one.
    """
    if once_named(lines, body) != list(lines):
        return  # its columns are named above each block
    numbered, rows = [], 0
    sizes: list[int] = []
    for line in lines:
        found = _NUMBERED.match(line)
        if body.is_row(line):
            rows += 1
        elif found:
            sizes.append(rows)
            numbered.append((found[1], int(found[2])))
            rows = 0
    frames = [n for word, n in numbered if numbered and word == numbered[-1][0]]
    inside = sizes[len(numbered) - len(frames) + 1 :]
    if (
        len(frames) < _FRAMES or len(set(inside)) != 1 or inside[0] < 2
        or any(b - a != 1 for a, b in pairwise(frames))
    ):  # fmt: skip
        return
    raise DataError(
        f"a matrix of {inside[0]} lines for each of {len(frames)} frames, not a table", file=path,
        remedy="export the force and the centre of force of each frame (time, force, x, y for each "
        "foot) as one table",
    )  # fmt: skip
