"""Texts in which each pose has a rotation matrix of three lines, and maybe a wrench below it.

Room: tables; called by foreign and by the reader of records.
"""

from __future__ import annotations

import re
from itertools import islice

import numpy as np
from numpy.typing import NDArray

_SEPARATED = re.compile(r"[\s,;|\[\]()]+")
_LEAST, _LONGEST = 3, 8
"""So many poses at least, of so many lines at most."""
_FIRST = 120
"""So many number lines of a text say what it is."""
_ORTHONORMAL = 0.02
"""How far a rotation matrix that is written with few digits may be from one."""
_NAMES = tuple(f"r{i}{j}" for i in "123" for j in "123")


def begins_with_poses(text: str) -> bool:
    """Whether the first lines of a text are poses in blocks."""
    return bool(pose_blocks(text, _FIRST))


def pose_blocks(text: str, at_most: int = 0) -> dict[str, NDArray[np.float64]]:
    """The poses of a text as columns r11 … r33, x y z and wrench_0 …; empty for other texts.

    All number lines are poses of one length. In each, three lines of three or four numbers begin
    with a rotation matrix R, ``|R Rᵀ − 1| < 0.02`` and ``det R > 0``; a fourth number is a place;
    a line ``0 0 0 1`` below belongs to the matrix; all other numbers are the wrench. `at_most`
    number lines are looked at, 0 for all.
    """
    numbers = (line for line in map(_numbers, text.splitlines()) if line)
    lines = list(islice(numbers, at_most or None))
    for length in range(3, _LONGEST + 1):
        whole = len(lines) - len(lines) % length
        if (whole < len(lines) and len(lines) != at_most) or whole < _LEAST * length:
            continue
        blocks = [lines[i : i + length] for i in range(0, whole, length)]
        for first in range(length - 2):
            if found := _columns(blocks, first):
                return found
    return {}


def _columns(blocks: list[list[list[float]]], first: int) -> dict[str, NDArray[np.float64]]:
    """Columns of poses whose matrices begin at line `first`; empty where one is none."""
    if len({tuple(map(len, block)) for block in blocks}) != 1:
        return {}
    width = len(blocks[0][first])
    if width not in (3, 4) or any(len(line) != width for line in blocks[0][first : first + 3]):
        return {}
    top = np.array([block[first : first + 3] for block in blocks])
    rotation = top[:, :, :3]
    far = np.abs(rotation @ rotation.transpose(0, 2, 1) - np.eye(3)).max()
    if not far < _ORTHONORMAL or np.linalg.det(rotation).min() < 0 or np.ptp(rotation) == 0:
        return {}
    found = dict(zip(_NAMES, rotation.reshape(len(blocks), 9).T, strict=True))
    if width == 4:
        found |= dict(zip("xyz", top[:, :, 3].T, strict=True))
    rest = [
        [x for i, line in enumerate(block) if not first <= i < first + 3
         and line != [0.0, 0.0, 0.0, 1.0] for x in line]
        for block in blocks
    ]  # fmt: skip
    if len({len(one) for one in rest}) != 1:
        return {}
    return found | {f"wrench_{i}": column for i, column in enumerate(np.array(rest).T)}


def _numbers(line: str) -> list[float]:
    """The numbers of a line; empty where a word is among them."""
    try:
        return [float(word) for word in _SEPARATED.split(line.strip()) if word]
    except ValueError:
        return []
