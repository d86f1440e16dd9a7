"""Columns of numbers as a reader compares them: one minus sign, as many digits in every row."""

from __future__ import annotations

import re
from collections.abc import Sequence

_DECIMAL = re.compile(r"^−?(\d{1,3}(?:,\d{3})*|\d+)\.(\d+)$")
_MINUS = re.compile(r"^-(?=[\d.])")
_ZERO = re.compile(r"^[−+](?=0(?:\.0+)?(?: ?%)?$)")
_MOST_DIGITS = 6
"""More significant digits than any fit supports are not asked of a row that has fewer."""


def aligned(rows: Sequence[Sequence[str]], numeric: Sequence[bool]) -> tuple[tuple[str, ...], ...]:
    """The rows with trailing zeros where a number of a column has fewer digits than the others.

    ``1.31, 1.3`` becomes ``1.31, 1.30``. Columns with a fixed number of decimals, whole numbers
    and cells that hold more than a number stay as they are.

    Parameters
    ----------
    rows
        Cells as text.
    numeric
        Which columns hold numbers.
    """
    if not rows:
        return ()
    columns = [
        _with_digits([_ZERO.sub("", _MINUS.sub("−", str(cell))) for cell in column]) if is_number
        else [str(cell) for cell in column]
        for column, is_number in zip(zip(*rows, strict=True), numeric, strict=True)
    ]  # fmt: skip
    return tuple(zip(*columns, strict=True))


def _with_digits(cells: list[str]) -> list[str]:
    """One column."""
    found = {cell: _DECIMAL.match(cell) for cell in cells}
    decimals = {len(match[2]) for match in found.values() if match}
    if len(decimals) < 2:
        return cells
    digits = {cell: _significant(match) for cell, match in found.items() if match}
    most = min(max(digits.values()), _MOST_DIGITS)
    return [
        cell + "0" * max(most - digits[cell], 0) if digits.get(cell) else cell for cell in cells
    ]


def _significant(match: re.Match[str]) -> int:
    """Significant digits of a decimal number; none of zero."""
    return len((match[1].replace(",", "") + match[2]).lstrip("0"))
