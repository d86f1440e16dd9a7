"""Vectors and orientations among columns without names, by their order in a file.

Room: sniff; asked by bodies and split_bodies. Controllers write a file for each quantity, numbers
alone behind a stamp: places, angles or quaternions in a row, as ``walk.lsole`` and ``walk.com``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.triples import (
    MATRIX,
    ROLL_PITCH_YAW,
    Axes,
    at_most_a_turn,
    is_rotation,
    of_length_one,
    upright,
)

_UNNAMED = re.compile(r"(?:(?P<file>.*)\.)?column_\d+")


def unnamed(columns: Sequence[ColumnGuess]) -> tuple[list[Axes], list[Axes]]:
    """Vectors, and what may be orientations, of each file whose columns have no names.

    Nothing of a file whose numbers are no whole vectors. Three angles stand behind a place, and are
    among the vectors as well.
    """
    files: dict[str, list[ColumnGuess]] = {}
    for column in columns:
        if found := _UNNAMED.fullmatch(column.column):
            files.setdefault(found["file"] or "", []).append(column)
    vectors, turned = [], []
    for file, own in files.items():
        plain, frames = _in_order(file, own)
        vectors += plain
        turned += frames
    return vectors, turned


def _in_order(file: str, columns: Sequence[ColumnGuess]) -> tuple[list[Axes], list[Axes]]:
    vectors, turned, at = list[Axes](), list[Axes](), 0
    while at < len(columns):
        left, before = columns[at:], f"{file}_{at}_"
        four = _keyed(before, "xyzw", left[:4])
        nine = _keyed(before, MATRIX, left[:9])
        if four is not None and vectors and of_length_one(four.values("xyzw")):
            turned.append(Axes(before, "", upright(dict(zip("0123", left, strict=False)))))
            at += 4
        elif nine is not None and vectors and is_rotation(nine):
            turned.append(nine)
            at += 9
        elif (three := _keyed(before, "xyz", left[:3])) is not None:
            vectors.append(three)
            if len(vectors) == 2 and at_most_a_turn(three):
                turned.append(Axes(before, "", dict(zip(ROLL_PITCH_YAW, left, strict=False))))
            at += 3
        else:
            return [], []
    return vectors, turned


def _keyed(before: str, keys: Sequence[str], columns: Sequence[ColumnGuess]) -> Axes | None:
    """Columns in a row as one thing; None where there are not as many, or without numbers."""
    if len(columns) < len(keys) or not all(
        c.values is not None and np.isfinite(c.values).any() for c in columns
    ):
        return None
    return Axes(before, "", dict(zip(keys, columns, strict=True)))
