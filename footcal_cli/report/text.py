"""A report for a terminal: result, findings and the leading table, in lines that fit.

A pipe gets one line per sentence and per row, for programs that read lines, unless COLUMNS says how
wide it is.
"""

from __future__ import annotations

import os
import textwrap
from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table as RichTable

from footcal_cli.core.quality import Finding
from footcal_cli.report import Report, Sheet, plural
from footcal_cli.report.causes import one_per_cause
from footcal_cli.report.columns import laid_out

_MARKS = {"good": "green", "warning": "yellow", "bad": "red"}
_SEVERITY = {"alarm": "red", "warning": "yellow", "note": "cyan"}
WIDTH = "COLUMNS"
"""The environment variable that says how wide an output is."""
_MOST_COLUMNS = 5
_MOST_ROWS = 24
_WIDEST_CELL = 44


def print_text(report: Report, console: Console) -> None:
    """Print verdict, actions, findings and the leading table."""
    mark = _MARKS[report.verdict.level]
    _say(console, "VERDICT  ", report.verdict.sentence, style=f"bold {mark}")
    for line in report.verdict.actions:
        _say(console, "  → ", line, style="bold")
    for line in report.verdict.details:
        _say(console, "  • ", line)
    for finding in one_per_cause(report.findings):
        _say_finding(console, finding)
    for sheet in report.leading[:1]:
        console.print(_drawn(sheet, console.width))


def _say_finding(console: Console, finding: Finding) -> None:
    lead = f"{finding.severity.upper()} "
    text = f"{finding.where}: {finding.sentence}. → {finding.remedy}"
    _say(console, lead, text, style=_SEVERITY[finding.severity])


def _say(console: Console, lead: str, text: str, style: str = "") -> None:
    """One sentence: wrapped under itself where the width is known, else one line."""
    lines = [text]
    if console.is_terminal or WIDTH in os.environ:
        room = max(console.width - len(lead), 30)
        lines = textwrap.wrap(text, room, break_on_hyphens=False) or [""]
    for i, line in enumerate(lines):
        head = (f"[{style}]{lead}[/]" if style else lead) if i == 0 else " " * len(lead)
        console.print(f"{head}{_plain(line)}", soft_wrap=True)


def _drawn(sheet: Sheet, width: int) -> RichTable:
    """The columns and rows of a sheet that a terminal has room for."""
    sheet, numeric = laid_out(sheet)
    shown = sheet.rows[: sheet.folded_after or _MOST_ROWS]
    columns = _columns(sheet, shown, width)
    drawn = RichTable(title=_plain(sheet.title), box=box.SIMPLE_HEAD, title_justify="left")
    for k in columns:
        drawn.add_column(_plain(sheet.columns[k]), overflow="fold",
                         justify="right" if numeric[k] else "left")  # fmt: skip
    for i, row in enumerate(shown):
        grey = "dim" if i in sheet.greyed else None
        drawn.add_row(*[_plain(row[k]) for k in columns], style=grey)
    missing = []
    if len(shown) < len(sheet.rows):
        missing.append(plural(len(sheet.rows) - len(shown), "more row"))
    if len(columns) < len(sheet.columns):
        missing.append(plural(len(sheet.columns) - len(columns), "more column"))
    if missing:
        drawn.caption = f"{' and '.join(missing)} in the report"
        drawn.caption_justify = "left"
    return drawn


def _columns(sheet: Sheet, rows: Sequence[Sequence[str]], width: int) -> list[int]:
    """Numbers of the columns to show: those the sheet names, else the first; all that fit."""
    wanted = [sheet.columns.index(name) for name in sheet.brief] or range(len(sheet.columns))
    chosen: list[int] = []
    used = 0
    for k in wanted:
        longest_word = max(len(word) for word in f"{sheet.columns[k]} ".split(" "))
        cells = max((len(row[k]) for row in rows), default=0)
        needed = max(longest_word, min(cells, _WIDEST_CELL)) + 2
        if chosen and (used + needed > width or len(chosen) == _MOST_COLUMNS):
            break
        chosen.append(k)
        used += needed
    return chosen


def _plain(text: str) -> str:
    """Text whose square brackets are not markup."""
    return text.replace("[", r"\[")
