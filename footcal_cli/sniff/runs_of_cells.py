"""Files of known weights on cells that were loaded again: which of names and columns are the runs.

Room: sniff; asked by file_names. ``A_rep1 A_rep2 B_rep1`` are two cells; and where each file is of
one cell, its columns side by side are series. What a run leaves as it was is the cell's scale.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.cells_by_files import with_channel
from footcal_cli.sniff.file_loads import Names
from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.plan import Entry, LogPlan, cell_name
from footcal_cli.sniff.units import split_unit

_BY_CHANCE = 1e-3
"""How rarely scales of files differ so much more than those of the columns in them."""
_OTHER_SCALE = 0.005
"""No remounting changes the scale of one cell by so much."""
_LESS = 0.25
"""Scales of one cell differ by so much of what those of two cells do, at most."""
_RUNS = {"repeat", "session", "sequence"}
_PART, _SIGN = r"[^_. -]+", r"[_. -]+"
_CHANGES = re.compile(r"\(.*?\)|\[.*?\]|\d+|°")
"""What may differ in the names of series: a number, and remarks in brackets."""


def cells_and_runs(plan: LogPlan, group: Sequence[FileGuess], names: Names) -> LogPlan | None:
    """Weights in files whose names say a cell and a run; None where they do not."""
    if plan.wide:
        return None
    parts = [[p for p in re.split(_SIGN, word) if p] for word in names.middle]
    if len({*map(len, parts)}) > 1 or len({bool(re.match(_SIGN, w)) for w in names.middle}) > 1:
        return None
    columns = [*zip(*parts, strict=True)]
    varying = [i for i, words in enumerate(columns) if len({*words}) > 1]
    if len(varying) != 2 or len({tuple(p) for p in parts}) < len(parts):
        return None
    before = re.search(r"[^\W\d_]*$", names.head)
    first = before[0] if before else ""
    run_words = [
        all(name_guess(first * (i == 0) + w).quantity in _RUNS for w in columns[i]) for i in varying
    ]
    if run_words.count(True) != 1:
        run_words = [_one_scale_in(plan, group, columns[i]) for i in reversed(varying)]
    if run_words.count(True) != 1:
        return None
    cell, run = (varying[run_words.index(said)] for said in (False, True))
    if len({*columns[cell]}) == len(parts):
        return None

    sign = _SIGN * bool(re.match(_SIGN, names.middle[0]))

    def expression(which: int) -> str:
        inner = _SIGN.join(f"({_PART})" if i == which else _PART for i in range(len(columns)))
        return f"^{re.escape(names.head)}{sign}{inner}{re.escape(names.tail)}$"

    called = {word: cell_name(word) for word in columns[cell]}
    why = "the files' names say a cell and a run"
    made = with_channel(plan, called, expression(cell), why)
    entries = {"session": Entry(file_name=expression(run), why=why), **made.entries}
    kind = "known weights, a file per channel and run"
    return replace(made, kind=kind, channels=tuple(dict.fromkeys(called.values())), entries=entries)


def series_of_cells(
    plan: LogPlan | None, group: Sequence[FileGuess], names: Names
) -> LogPlan | None:
    """Files of one cell each, whose columns of readings are series; None where they are none.

    The columns differ in a number alone, and scales differ from file to file but not within one.
    """
    if plan is None or plan.role != "weights" or len(plan.wide) < 2:
        return None
    if plan.wide_into != "channel" or "channel" in plan.entries:
        return None
    read = [own["counts"].column for own in plan.wide.values() if "counts" in own]
    columns = [c.column for c in read if c is not None]
    called = {_CHANGES.sub("", split_unit(c)[0]).strip(" _-.") for c in columns}
    if len(columns) < len(plan.wide) or len(called) > 1 or called == {""}:
        return None
    scales = _scales(plan, group, columns)
    if scales is None or not _of_files(scales):
        return None
    before = re.search(r"[^\W_]*$", names.head)
    word = before[0] if before else ""
    expression = f"^{re.escape(names.head[: len(names.head) - len(word)])}({word}.+)"
    why = "the scales differ from file to file, and not within one"
    cells = {word + w: cell_name(word + w) for w in names.middle}
    made = with_channel(plan, cells, f"{expression}{re.escape(names.tail)}$", why)
    kind = f"known weights, one file per channel, {len(columns)} series side by side"
    return replace(made, kind=kind, why=why, sure="likely", wide_into="session", warnings=())


def _scales(plan: LogPlan, group: Sequence[FileGuess], columns: Sequence[str]) -> FloatArray | None:
    """Slopes of readings over the load, shape (files, columns); None where some have none."""
    load = plan.entries.get("load_n")
    if load is None or load.column is None:
        return None
    found = np.zeros((len(group), len(columns)))
    for i, file in enumerate(group):
        own = {c.column: c.values for c in file.columns}
        put = own.get(load.column.column)
        for k, column in enumerate(columns):
            values = own.get(column)
            if put is None or values is None or values.size != put.size:
                return None
            good = np.isfinite(put) & np.isfinite(values)
            if np.unique(put[good]).size < 2:
                return None
            found[i, k] = np.polyfit(put[good], values[good], 1)[0]
    return found


def _of_files(scales: FloatArray) -> bool:
    """Whether scales (files, columns) differ by files, and neither by columns nor by both."""
    from footcal_cli.core import chances  # scipy, only where asked

    files, columns = scales.shape
    if files < 2 or columns < 2:
        return False
    mean = scales.mean()
    by_file, by_column = scales.mean(axis=1), scales.mean(axis=0)
    left = scales - by_file[:, None] - by_column + mean
    free = (files - 1) * (columns - 1)
    rest = max(float(np.sum(left**2)) / free, (np.finfo(np.float64).eps * mean) ** 2)
    of_files = columns * float(np.sum((by_file - mean) ** 2)) / (files - 1) / rest
    of_columns = files * float(np.sum((by_column - mean) ** 2)) / (columns - 1) / rest
    within = float(np.max(np.ptp(scales, axis=1))) / abs(float(mean))
    return bool(
        within < _OTHER_SCALE and of_files > of_columns
        and chances.f_sf(of_files, files - 1, free) < _BY_CHANCE
    )  # fmt: skip


def _one_scale_in(plan: LogPlan, group: Sequence[FileGuess], words: Sequence[str]) -> bool:
    """Whether files with one word have one scale, and those with another a scale of their own."""
    read = next((e.column for n, e in plan.entries.items() if n.endswith("counts")), None)
    scales = None if read is None else _scales(plan, group, [read.column])
    if scales is None or len({*words}) == len(words):
        return False
    own = [scales[[w == word for w in words], 0] for word in dict.fromkeys(words)]
    within = max(float(np.ptp(s)) for s in own)
    between = min(np.diff(sorted(float(s.mean()) for s in own)))
    size = abs(float(scales.mean()))
    return bool(within < _OTHER_SCALE * size and within < _LESS * between)
