"""A body's stream that stands in several files: a file for the CoM, one for each foot.

Room: sniff; asked by walking. Recorders write a file for each topic. None of them is a body's
stream alone; joined at the stamps of one of them they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.bodies import BodyLog, body_of
from footcal_cli.sniff.groups import wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, seconds_of
from footcal_cli.sniff.motion import is_momentum_rate
from footcal_cli.sniff.names import NameGuess
from footcal_cli.sniff.stands import standing
from footcal_cli.sniff.triples import angles, axes_of
from footcal_cli.sniff.unnamed import unnamed
from footcal_cli.tables.sources import stem_of

_LEAST_ROWS, _OVERLAP = 50, 0.5
"""Rows of a stream, and the share of one's time that another must be there in."""
_FELT = ("force", "reading")
_NO_COLUMN = ColumnGuess("", NameGuess("other"), None, "guess", "")


def joined_body(files: Sequence[FileGuess]) -> list[FileGuess]:
    """Logs with the files of one body's stream made one; as they are where there is none.

    It stands for the file whose stamps it has, the others are its `joined`. Cells that stand beside
    the pose of each foot stay beside it.
    """
    streams = [file for file in files if _may_move(file)]
    if len(streams) < 2:
        return list(files)
    streams.sort(key=lambda file: (not file.of("com"), bool(_moments(file))))
    first, joined = streams[0], []
    columns = list(first.columns)
    for file in streams[1:]:
        own = _at_stamps(first, file)  # columns by the names that `called` gives them
        if own:
            joined.append(file)
            columns += own
    every = replace(first, columns=tuple(columns), joined=tuple(joined))
    body = body_of(every)
    found = standing(every) if body is None else body.file
    if found is every or not joined:
        return list(files)
    cells = {} if body is None else _cells_beside(first, joined, body)
    used = {c.column for c in found.of("com", "com_acc", "motion")} | {*cells}
    used |= {called(first, file, c) for file in joined for c in _moments(file)}
    theirs = [file for file in joined if used & {called(first, file, c) for c in file.columns}]
    there = {called(first, file, c) for file in theirs for c in file.columns}
    kept = {c.column for c in first.columns} | (used & there)
    columns = [cells.get(c.column, c) for c in columns if c.column in kept]
    whole = replace(first, columns=tuple(columns), joined=tuple(theirs))
    return [whole if file is first else file for file in files
            if all(file is not own for own in theirs)]  # fmt: skip


def _cells_beside(
    first: FileGuess, joined: Sequence[FileGuess], body: BodyLog
) -> dict[str, ColumnGuess]:
    """Cells that stand beside the pose of one foot in a file each, as cells of that foot."""
    taken = {c.column: c for c in body.file.columns}
    found: dict[str, ColumnGuess] = {}
    feet: dict[tuple[str, ...], list[str]] = {}
    for file in (first, *joined):
        before = f"{stem_of(file.path)}." if file is first else called(first, file, _NO_COLUMN)
        of = [foot for foot, stem in body.stems.items() if stem.startswith(before)]
        names = {c.column: c.column if file is first else called(first, file, c)
                 for c in file.of(*_FELT) if c.values is not None}  # fmt: skip
        names = {c: n for c, n in names.items() if n in taken and taken[n].quantity in _FELT}
        if len(of) == 1 and names:
            feet.setdefault(tuple(names), []).append(of[0])
            side = of[0] if of[0] in ("left", "right") else ""
            for name in names.values():
                own = replace(taken[name].name, side=side, place="" if side else of[0])
                found[name] = replace(taken[name], name=own)
    return found if [{*own} for own in feet.values()] == [{*body.stems}] else {}


def called(first: FileGuess, file: FileGuess, column: ColumnGuess) -> str:
    """The name of a joined file's column: behind its stem, or its name where stems are the same."""
    alike = stem_of(first.path) == stem_of(file.path)
    return f"{file.path.name if alike else stem_of(file.path)}.{column.column}"


def _may_move(file: FileGuess) -> bool:
    """Whether a log with stamps has places, angles or a moment of the body, and nothing felt."""
    if not file.of("time") or file.of("load") or file.rows < _LEAST_ROWS or wrenches(file):
        return False
    named = [c for c in file.columns if c.values is not None]
    return bool(axes_of(named) or angles(named) or unnamed(named[1:])[0] or _moments(file))


def _moments(file: FileGuess) -> list[ColumnGuess]:
    """Columns that are the rate of an angular momentum by the file's name and their own."""
    named = (c for c in file.columns if c.values is not None)
    return [c for c in named if is_momentum_rate(f"{stem_of(file.path)}.{c.column}")]


def _at_stamps(first: FileGuess, file: FileGuess) -> list[ColumnGuess]:
    """Columns of a file at the stamps of the first one; none where both hardly overlap."""
    ours, theirs = (seconds_of(one.of("time")[0]) for one in (first, file))
    if ours is None or theirs is None or not _together(ours, theirs):
        return []
    made = []
    for column in file.columns:
        values = column.values
        if values is None or column.quantity == "time":
            continue
        good = np.isfinite(values) & np.isfinite(theirs)
        if good.sum() < _LEAST_ROWS:
            continue
        order = np.argsort(theirs[good], kind="stable")
        read = np.interp(ours, theirs[good][order], values[good][order])
        made.append(replace(column, column=called(first, file, column), values=read))
    return made


def _together(ours: FloatArray, theirs: FloatArray) -> bool:
    low = max(np.nanmin(ours), np.nanmin(theirs))
    high = min(np.nanmax(ours), np.nanmax(theirs))
    return bool(high - low > _OVERLAP * max(np.ptp(ours), np.ptp(theirs)))
