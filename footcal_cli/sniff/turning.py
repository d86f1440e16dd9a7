"""Columns that turn a leg, by what its transducer feels: of whatever name and language.

Room: sniff; asked by shafts. A leg that turns about its shaft under gravity gives torques
``a + b cos φ + c sin φ`` in one attitude of the body, and only the angle `φ` explains them so.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of

_UNITS = {"rad": 1.0, "deg": np.pi / 180.0}
"""Units of angles in rad."""
_TENTHS = 0.1
"""Whole numbers of an angle may be tenths of a degree."""
_LEAST_ROWS = 20
_LEAST_RAD, _LARGEST_RAD = 0.3, 13.0
"""How far a leg turns at least, and two turns and more, which no angle of a leg goes."""
_EXPLAINED, _FELT = 0.9, 0.5
"""Shares of the torques' variance that an angle explains; of forces, where a leg turns alone."""
_COPIES = ("another clock", "another column less a constant")
"""What a shaft's column may have been taken for: legs that turn alike differ by a constant."""


def turning(file: FileGuess, six: Mapping[str, Mapping[str, ColumnGuess]]) -> list[ColumnGuess]:
    """Columns that explain the torques of a transducer as the angle of its leg, with their unit."""
    felt = {c.column for axes in six.values() for c in axes.values()}
    at = _attitudes(file)
    alone = len(six) == 1 and not file.of("label", "orientation")
    found = []
    for column in file.columns:
        free = column.quantity == "unknown" or column.why.startswith(_COPIES)
        if column.column in felt or not free or column.values is None:
            continue
        best, least = None, _EXPLAINED
        for one in _read(column):
            share = max(_explained(one, axes, at, "t") for axes in six.values())
            held = not alone or _explained(one, next(iter(six.values())), at, "f") < _FELT
            if share > least and held:
                best, least = one, share
        found += [best] if best is not None else []
    return found


def turned_along(
    file: FileGuess, six: Mapping[str, Mapping[str, ColumnGuess]]
) -> tuple[str, str] | None:
    """A transducer that turns with its leg, and the angle: its forces turn in one attitude."""
    at = _attitudes(file)
    for column in file.of("phase"):
        if column.values is None or column.unit not in _UNITS:
            continue
        for name, axes in six.items():
            if _explained(column, axes, at, "f") > _EXPLAINED:
                return name, column.column
    return None


def _read(column: ColumnGuess) -> Iterator[ColumnGuess]:
    """A column in each unit in which its numbers are angles of a leg."""
    units = [(column.unit, 1.0)] if column.unit else [("rad", 1.0), ("deg", 1.0), ("deg", _TENTHS)]
    for unit, factor in units:
        size = _UNITS.get(unit or "", 0.0) * factor
        good = numbers_of(column)[np.isfinite(numbers_of(column))] * size
        whole = factor == 1.0 or column.counts
        if whole and good.size and np.ptp(good) > _LEAST_RAD and abs(good).max() < _LARGEST_RAD:
            name = replace(column.name, quantity="phase", unit=unit, factor=factor)
            why = "the torques turn with it"
            yield replace(column, name=name, unit=unit, values=numbers_of(column) * factor,
                          sure="guess", why=why)  # fmt: skip


def _attitudes(file: FileGuess) -> IntArray:
    """A number for each leg, orientation and run that the rows name, shape (n,)."""
    named = [c.codes for c in file.of("label", "orientation") if c.codes is not None]
    runs = [c.values for c in file.of("repeat", "session") if c.values is not None]
    named += [np.unique(np.nan_to_num(run), return_inverse=True)[1].reshape(-1) for run in runs]
    if not named:
        return np.zeros(file.rows, dtype=np.int64)
    return np.unique(np.column_stack(named), axis=0, return_inverse=True)[1].reshape(-1)


def _explained(
    column: ColumnGuess, axes: Mapping[str, ColumnGuess], at: IntArray, kind: str
) -> float:
    """Share of the variance of forces (``f``) or torques (``t``) that an angle explains."""
    angle = numbers_of(column) * _UNITS[column.unit or "rad"]
    read = np.column_stack([numbers_of(axes[kind + a]) for a in "xyz"])
    good = np.isfinite(angle) & np.isfinite(read).all(axis=1)
    whole = left = 0.0
    for one in np.unique(at):
        rows = np.flatnonzero(good & (at == one))
        if rows.size < _LEAST_ROWS:
            continue
        swing: FloatArray = np.column_stack(
            [np.ones(rows.size), np.cos(angle[rows]), np.sin(angle[rows])]
        )
        fit = swing @ np.linalg.lstsq(swing, read[rows], rcond=None)[0]
        whole += float(((read[rows] - read[rows].mean(axis=0)) ** 2).sum())
        left += float(((read[rows] - fit) ** 2).sum())
    return 1.0 - left / whole if whole > 0.0 else 0.0
