"""Angles of a body by their letters: phi, theta and psi, as textbooks of flight write them.

Room: sniff; asked by columns. One letter alone may be the angle of a shaft or of a joint.
"""

from __future__ import annotations

from dataclasses import replace

from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.names import words_of
from footcal_cli.sniff.units import split_unit

_LETTERS = {"phi": "roll", "theta": "pitch", "psi": "yaw"}
_OF_A_BODY = {"imu", "body", "base", "torso", "trunk", "euler", "angle", "attitude", "ahrs"}


def with_flight_angles(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """Columns of which phi and theta, or all three letters, are roll, pitch and yaw.

    Left as they are next to another attitude.
    """
    named = {letter: c for c in columns if (letter := _letter(c))}
    known = {"quaternion", "angle", "matrix", "gravity"} & {c.quantity for c in columns}
    if known or not {"phi", "theta"} <= named.keys():
        return columns
    axes = {id(c): _LETTERS[letter] for letter, c in named.items()}
    return [_as_angle(c, axes[id(c)]) if id(c) in axes else c for c in columns]


def _letter(column: ColumnGuess) -> str | None:
    """The letter that a column of numbers is called by; None for any other."""
    if column.values is None or column.unit not in ("rad", "deg", None):
        return None
    words = [w for w in words_of(split_unit(column.column)[0]) if w not in _OF_A_BODY]
    return words[0] if len(words) == 1 and words[0] in _LETTERS else None


def _as_angle(column: ColumnGuess, axis: str) -> ColumnGuess:
    name = replace(column.name, quantity="angle", axis=axis, owner="")
    return replace(column, name=name, sure="likely", why="its letter, next to the others")
