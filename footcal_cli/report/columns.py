"""Columns of numbers as a reader compares them: one minus sign, as many digits in every row."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from footcal_cli.report import Sheet

_DECIMAL = re.compile(r"^−?(\d{1,3}(?:,\d{3})*|\d+)\.(\d+)$")
_MINUS = re.compile(r"^-(?=[\d.])")
_ZERO = re.compile(r"^[−+](?=0(?:\.0+)?(?: ?%)?$)")
_NUMERIC = re.compile(
    r"^[<>≤≥≈→ ]*[(]?[−+-]?[\d,]*\.?\d+([e×]\S*)?( ± \S+)?( × 10\S+)?"
    r"( ?%)?( ?\[[^]]*\]( ?%)?)?( of [\d,]+)?$"
)
_MOSTLY = 0.8
"""So large a share of a column's cells makes it one of numbers."""
EMPTY = frozenset({"", "–", "-", "no repeats"})
_MOST_DIGITS = 6
"""More significant digits than any fit supports are not asked of a row that has fewer."""


def laid_out(sheet: Sheet) -> tuple[Sheet, tuple[bool, ...]]:
    """A sheet as it is read, on a page or in a terminal: without empty columns, digits aligned.

    Returns
    -------
    sheet, numeric
        The sheet, and which of its columns hold numbers.
    """
    filled = [
        k for k in range(len(sheet.columns))
        if k == 0 or not sheet.rows or any(str(row[k]).strip() not in EMPTY for row in sheet.rows)
    ]  # fmt: skip
    columns = [sheet.columns[k] for k in filled]
    rows = [[row[k] for k in filled] for row in sheet.rows]
    judged = [row for i, row in enumerate(rows) if i not in sheet.greyed] or rows
    numeric = tuple(_holds_numbers([str(row[k]) for row in judged]) for k in range(len(columns)))
    brief = [name for name in sheet.brief if name in columns]
    return replace(sheet, columns=columns, rows=aligned(rows, numeric), brief=brief), numeric


def _holds_numbers(column: Sequence[str]) -> bool:
    filled = [cell.strip() for cell in column if cell.strip() not in EMPTY]
    numbers = sum(bool(_NUMERIC.match(cell)) for cell in filled)
    return bool(filled) and numbers >= _MOSTLY * len(filled)


def aligned(rows: Sequence[Sequence[str]], numeric: Sequence[bool]) -> tuple[tuple[str, ...], ...]:
    """The rows with trailing zeros where a number of a column has fewer digits than the others.

    ``1.31, 1.3`` becomes ``1.31, 1.30``; no row gets more decimals than the others have.
    Columns with a fixed number of decimals, whole numbers and cells that hold more than a number
    stay as they are.

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
    places = max(decimals)
    return [
        cell + "0" * max(min(most - digits[cell], places - len(match[2])), 0)
        if (match := found[cell]) and digits[cell]
        else cell
        for cell in cells
    ]


def _significant(match: re.Match[str]) -> int:
    """Significant digits of a decimal number; none of zero."""
    return len((match[1].replace(",", "") + match[2]).lstrip("0"))
