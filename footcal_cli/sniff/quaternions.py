"""Quaternions that no name calls so: four numbers whose squares add up to one.

Room: sniff; asked by numbered.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.names import NameGuess

_TURNS = 0.05
"""How much a component changes at least where a quaternion is recognised by its length."""
_MORE_THAN_ONE, _WITHIN = 3.0, 0.03
"""A length from which components are counts, and how far it may change, as a share of it."""
_NEARLY_ONE = 0.05
_LETTERED = re.compile(r"(?i)(.*?)[\W_]*(?:([xyzw])|([ijkrs])|(?<![^\W_])(re|real|scalar))")
_HAMILTON = dict(zip("ijkrs", "xyzww", strict=True))
"""Letters of a quaternion as Hamilton wrote it, and of its real part."""
_LEAST_ROWS = 3


def by_letters(file: FileGuess) -> dict[str, ColumnGuess]:
    """Columns called x, y, z and w (i, j, k and real), or behind one word, of length one."""
    stems: dict[str, dict[str, ColumnGuess]] = {}
    for column in file.columns:
        found = _LETTERED.fullmatch(column.column.strip())
        if found and column.values is not None and column.unit is None:
            letter = found[2] or _HAMILTON.get((found[3] or "").lower(), "w")
            stems.setdefault(found[1], {}).setdefault(letter.lower(), column)
    whole = [own for own in stems.values() if set(own) == set("xyzw")]
    whole = [own for own in whole if _turn([own[a] for a in "xyzw"])]
    if len(whole) != 1:
        return {}
    return {
        column.column: replace(
            column, name=NameGuess("quaternion", axis, owner="body"), unit=None, sure="likely",
            why="x, y, z and w of length one",
        )
        for axis, column in whole[0].items()
    }  # fmt: skip


def _turn(four: Sequence[ColumnGuess]) -> bool:
    """Whether four columns are of length one in all rows, though they change."""
    values = np.column_stack([numbers_of(c) for c in four])
    values = values[np.isfinite(values).all(axis=1)]
    if len(values) < _LEAST_ROWS:
        return False
    if not np.allclose(np.linalg.norm(values, axis=1), 1.0, atol=1e-3):
        return False
    return bool(np.ptp(values, axis=0).max() > _TURNS)


def in_a_row(stems: dict[str, list[ColumnGuess]]) -> dict[str, ColumnGuess]:
    """Four numbers in a row whose squares add up to one in all rows, though they change."""
    for columns in stems.values():
        for at in range(len(columns) - 3):
            four = columns[at : at + 4]
            if _turn(four):
                return {
                    c.column: replace(
                        c, name=replace(c.name, quantity="quaternion", axis=str(i), owner="body"),
                        unit=None, sure="likely", why="four numbers of length one",
                    )
                    for i, c in enumerate(four)
                }  # fmt: skip
    return {}


def of_length_one(file: FileGuess) -> tuple[ColumnGuess, ...]:
    """Columns of a log whose quaternion is in counts, a fixed number of which are one."""
    four = [c for c in file.of("quaternion") if c.values is not None]
    if len(four) != len("xyzw"):
        return file.columns
    values = np.column_stack([numbers_of(c) for c in four])
    length = np.linalg.norm(values[np.isfinite(values).all(axis=1)], axis=1)
    size = float(np.median(length)) if length.size else 0.0
    if size <= _MORE_THAN_ONE or np.ptp(length) > _WITHIN * size:
        return file.columns
    one = float(2.0 ** np.round(np.log2(size)))
    one = one if abs(size / one - 1.0) < _WITHIN else size
    own = {
        c.column: replace(c, values=numbers_of(c) / one, name=replace(c.name, factor=1.0 / one))
        for c in four
    }
    return tuple(own.get(c.column, c) for c in file.columns)


def without_other_lengths(file: FileGuess) -> FileGuess:
    """A log without quaternions by their numbers, ``q_0`` … ``q_3``, that are not of length one.

    They are joints, or the first numbers of a longer row.
    """
    four = {c.name.axis: c for c in file.of("quaternion") if c.values is not None}
    if set(four) != set("0123") or len(file.of("quaternion")) != len(four):
        return file
    length = np.linalg.norm(np.column_stack([numbers_of(c) for c in four.values()]), axis=1)
    if np.nanmedian(np.abs(length - 1.0)) < _NEARLY_ONE:
        return file
    names = {c.column for c in four.values()}
    why = "four numbers that are not of length one"
    return replace(file, columns=tuple(
        replace(c, name=NameGuess("unknown"), why=why) if c.column in names else c
        for c in file.columns
    ))  # fmt: skip
