"""Logs of known weights with the same columns, a file for each cell: by their lines and names.

Room: sniff; asked by file_names.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.bench.split_lines import split_lines
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.sniff.file_loads import Names
from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.names import NameGuess, name_guess, without_side
from footcal_cli.sniff.plan import Entry, LogPlan, cell_name
from footcal_cli.sniff.tokens import DAY

_BY_CHANCE = 1e-6
"""How rarely files of one cell are so far apart by chance."""
_OTHER_SCALE = 0.005
"""No remounting changes the scale of one cell by so much; cells of one make differ by more."""
_RUNS = {"repeat", "session", "sequence"}
_NAME = re.compile(r"(?!.*\d{4})[\w-]{1,20}")
_NAMED = re.compile(r"[\w-]{1,20}")
"""A name of a cell; four digits are of a date."""


def cells_of_files(group: Sequence[FileGuess], words: Sequence[str]) -> list[NameGuess]:
    """The cell that each file is of: one under a foot of a walk, else what the file's name says."""
    cells = [file.of("reading", "unknown")[:1] for file in group]
    if all(own and own[0].name.side and own[0].name.place for own in cells):
        both = [(own[0].name.side, word) for own, word in zip(cells, words, strict=True)]
        found = [(s, without_side(word.lower(), s).strip("_- ")) for s, word in both]
        if len({*found}) < len(found):
            return [own[0].name for own in cells]
        return [NameGuess("reading", side=side, place=place) for side, place in found]
    called = [name_guess(word).address or word.strip("_- ") for word in words]
    return [replace(name_guess(c), owner=name_guess(c).owner or c) for c in called]


def weights_per_channel(plan: LogPlan, names: Names) -> LogPlan:
    """Known weights in every file, and a file for each channel."""
    called = {word: cell_name(word) for word in names.middle}
    return with_channel(plan, called, names.expression, "the files' names differ so")


def files_of_cells(
    plan: LogPlan | None, group: Sequence[FileGuess], names: Names
) -> LogPlan | None:
    r"""Files of which each is of another cell, though their names differ by numbers alone.

    Runs of one cell are numbered as cells are: the lines :math:`y = a_g + b_g F` of the files must
    differ in zero and scale, the scales by 0.5 % or more; where a line above each table repeats the
    name (``specimen: Z1``), different lines are enough. Words for runs keep the files together.
    """
    channel = None if plan is None else plan.entries.get("channel")
    if plan is None or plan.role != "weights" or channel is None or channel.value is None:
        return None
    letters = re.search(r"[^\W\d_]*$", names.head)
    before = letters[0] if letters else ""
    words = [before + word for word in names.middle]
    said = all(_said_above(file, word) for file, word in zip(group, words, strict=True))
    # a number of so many digits is a date, unless a line above calls the cell so
    named = _NAMED if said else _NAME
    if name_guess(before).quantity in _RUNS or not all(map(named.fullmatch, words)):
        return None
    if any(DAY.fullmatch(word) for word in words):
        return None
    if not _other_lines(plan, group, named=said):
        return None
    expression = f"^{re.escape(names.head[: len(names.head) - len(before)])}({before}.+)"
    why = "a line above each table says it too" if said else "each file has a line of its own"
    called = {word: cell_name(word) for word in words}
    return with_channel(plan, called, f"{expression}{re.escape(names.tail)}$", why)


def with_channel(plan: LogPlan, called: dict[str, str], expression: str, why: str) -> LogPlan:
    """A plan for weights with the channels that the files' names say, word -> channel."""
    channel = Entry(
        file_name=expression, why=why,
        names={word: name for word, name in called.items() if word != name},
    )  # fmt: skip
    entries = {
        "repeat" if k == "session" and v.column and v.column.quantity == "repeat" else k: v
        for k, v in plan.entries.items() if not k.endswith("_counts")
    }  # fmt: skip
    if "counts" not in entries and not plan.wide:
        entries["counts"] = next(v for k, v in plan.entries.items() if k.endswith("_counts"))
    return replace(
        plan, kind="known weights, one file per channel", role="weights",
        channels=tuple(called.values()), entries={**entries, "channel": channel},
    )  # fmt: skip


def _said_above(file: FileGuess, word: str) -> bool:
    """Whether a line above the table of a file is of a word, behind a separator or alone."""
    end = re.compile(rf"(?:^|[\s:=;,\t]){re.escape(word)}[\s;,\"]*$", re.IGNORECASE)
    return any(end.search(line) for line in file.text.above)


def _other_lines(plan: LogPlan, group: Sequence[FileGuess], *, named: bool) -> bool:
    """Whether the readings of each file lie on a line of their own."""
    every = {**next(iter(plan.wide.values()), {}), **plan.entries}  # of several, the first reading
    columns = [every[name].column for name in ("load_n", "counts") if name in every]
    found = [c.column for c in columns if c is not None]
    if len(found) < 2:
        return False
    pairs = []
    for file in group:
        own = {c.column: c.values for c in file.columns}
        force, read = (own.get(name) for name in found)
        if force is None or read is None or np.unique(force[np.isfinite(force)]).size < 2:
            return False
        pairs.append((force, read))
    codes = np.repeat(np.arange(len(pairs)), [force.size for force, _ in pairs])
    force, read = (np.concatenate(each) for each in zip(*pairs, strict=True))
    test = split_lines(force, _straightened(force, read, codes), codes)
    if test is None or test.one_line > _BY_CHANCE:
        return False
    good = np.isfinite(force) & np.isfinite(read)
    scales = [
        np.polyfit(force[good & (codes == k)], read[good & (codes == k)], 1)[0]
        for k in range(len(pairs))
    ]  # fmt: skip
    apart = np.ptp(scales) > _OTHER_SCALE * float(np.max(np.abs(scales)))
    return named or bool(apart and max(test.one_zero, test.one_slope) < _BY_CHANCE)


def _straightened(force: FloatArray, read: FloatArray, codes: IntArray) -> FloatArray:
    """Readings (n,) without the bend that all files share: cells of one make, one press.

    The bend at a load is the mean, over all files, of what lines of their own leave there; it is
    none of what tells cells apart, but hides it.
    """
    good = np.isfinite(force) & np.isfinite(read)
    left = np.zeros_like(read)
    for code in np.unique(codes):
        own = good & (codes == code)
        line = np.polynomial.Polynomial.fit(force[own], read[own], 1)
        left[own] = read[own] - line(force[own])
    loads, at = np.unique(force[good], return_inverse=True)
    files = np.array([np.unique(codes[good][at == k]).size for k in range(loads.size)])
    if files.min() < np.unique(codes).size:
        return read
    bend = np.bincount(at, left[good]) / np.bincount(at)
    straight = read.copy()
    straight[good] -= bend[at]
    return straight
