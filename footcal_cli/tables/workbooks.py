"""Sheets of Excel and LibreOffice workbooks as the text of a CSV file.

Room: tables; asked by textfiles, by sniff and by convert.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any

from footcal_cli.errors import DataError, missing_library

SUFFIXES = frozenset({".xlsx", ".xlsm", ".xlsb", ".xls", ".ods"})
_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+")
_WHOLE = 1e15
"""Below it a number without decimals is written without a point."""


def is_workbook(path: Path) -> bool:
    """Whether the name is that of a workbook."""
    return path.suffix.lower() in SUFFIXES


def sheet_text(path: Path) -> bytes:
    """The fullest sheet as CSV in UTF-8: line n is row n of the sheet.

    Raises
    ------
    UsageError
        The library that reads workbooks is not installed; gives the command that installs it.
    DataError
        No workbook, one with a password, or one without a filled sheet.
    """
    return _as_csv(max(_sheets(path).values(), key=_filled))


def sheet_texts(path: Path) -> dict[str, bytes]:
    """Every filled sheet by name, as `sheet_text`."""
    return {name: _as_csv(rows) for name, rows in _sheets(path).items()}


def other_sheets(path: Path) -> tuple[str, ...]:
    """Names of the filled sheets that `sheet_text` does not give."""
    sheets = _sheets(path)
    chosen = max(sheets, key=lambda name: _filled(sheets[name]))
    return tuple(name for name in sheets if name != chosen)


def _as_csv(rows: Sequence[Sequence[Any]]) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([_text(cell) for cell in row] for row in rows)
    return text.getvalue().encode()


def _sheets(path: Path) -> dict[str, list[list[Any]]]:
    """Rows of every visible sheet that has any, by name."""
    try:
        import python_calamine as calamine
    except ImportError as error:
        raise missing_library(
            "python_calamine", error, "a workbook needs the package python-calamine",
            "pip install 'footcal[excel]'",
        ) from None  # fmt: skip
    try:
        with calamine.CalamineWorkbook.from_path(path) as book:
            shown = [
                sheet.name for sheet in book.sheets_metadata
                if sheet.typ == calamine.SheetTypeEnum.WorkSheet
                and sheet.visible == calamine.SheetVisibleEnum.Visible
            ]  # fmt: skip
            sheets = {
                name: book.get_sheet_by_name(name).to_python(skip_empty_area=False)
                for name in shown
            }
    except (calamine.CalamineError, OSError, ValueError) as error:
        said = (str(error).splitlines() or [type(error).__name__])[0]
        raise DataError(
            f"cannot be read as a workbook: {said}", file=path,
            remedy="take off its password, or save the sheet as CSV",
        ) from None  # fmt: skip
    filled = {name: rows for name, rows in sheets.items() if _filled(rows)}
    if not filled:
        raise DataError("no sheet has any cell", file=path, remedy="save the log again")
    return filled


def _filled(rows: Sequence[Sequence[Any]]) -> int:
    """Number of cells that hold anything."""
    return sum(cell != "" for row in rows for cell in row)


def _text(cell: Any) -> str:
    """A cell as a text file would have it: points, ISO dates, hours of any number."""
    if isinstance(cell, bool):
        return str(cell).upper()
    if isinstance(cell, float):
        return f"{cell:.0f}" if cell.is_integer() and abs(cell) < _WHOLE else repr(cell)
    if isinstance(cell, datetime):
        return cell.isoformat(sep=" ")
    if isinstance(cell, date | time):
        return cell.isoformat()
    if isinstance(cell, timedelta):
        minutes, seconds = divmod(cell.total_seconds(), 60.0)
        return f"{int(minutes) // 60}:{int(minutes) % 60:02d}:{seconds:09.6f}"
    said = " ".join(str(cell).split("\n"))
    return said.replace(",", ".") if _DECIMAL_COMMA.fullmatch(said.strip()) else said
