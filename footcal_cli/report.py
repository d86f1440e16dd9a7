"""Record to HTML and text: verdict first, figures, tables, then how it was run."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING

from footcal_cli.records.results import FindingRecord, RmseRecord, RunRecord, VerdictRecord

if TYPE_CHECKING:
    import jinja2
    from matplotlib.figure import Figure
    from rich.console import Console

FIGURE_DPI = 130
_FIGURE_METADATA = {"Software": None}  # keeps figures the same bytes for the same data


@dataclass(frozen=True)
class Picture:
    """A figure with its file name (no ending) and what to see in it, in one sentence."""

    name: str
    figure: Figure
    caption: str

    def png(self) -> bytes:
        """The figure as PNG."""
        buffer = io.BytesIO()
        self.figure.savefig(buffer, format="png", dpi=FIGURE_DPI, metadata=_FIGURE_METADATA)
        return buffer.getvalue()


@dataclass(frozen=True)
class Sheet:
    """A table of a report; cells are ready text, greyed rows are what could not be judged.

    Parameters
    ----------
    title, columns, rows
        What it shows; every row has one text per column.
    note
        A sentence under the table.
    greyed
        Numbers of the rows to print in grey.
    folded_after
        Rows from this number on are folded away on the page and left out of the terminal; 0: none.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""
    greyed: frozenset[int] = frozenset()
    folded_after: int = 0


@dataclass(frozen=True)
class Report:
    """What a command has to say, in the order in which it is shown.

    `lead_sheets` stand before the pictures, `sheets` behind them.
    """

    title: str
    verdict: VerdictRecord
    pictures: tuple[Picture, ...] = ()
    sheets: tuple[Sheet, ...] = ()
    findings: tuple[FindingRecord, ...] = ()
    footer: tuple[str, ...] = field(default=())
    lead_sheets: tuple[Sheet, ...] = ()


def number(value: float | None, digits: int = 4) -> str:
    """A number for people: `digits` significant ones, an en dash for none."""
    if value is None or value != value:
        return "–"
    text = f"{value:.{digits}g}"
    return text.replace("-", "−", 1) if text.startswith("-") else text


def with_sd(value: float, sd: float | None) -> str:
    """``value ± sd``, both to the second digit of the sd."""
    if sd is None or not sd > 0 or sd != sd:
        return number(value, 6)
    from math import floor, log10

    decimals = 1 - floor(log10(sd))
    if -4 < decimals < 7:
        shown = max(decimals, 0)
        return f"{value:.{shown}f} ± {sd:.{shown}f}".replace("-", "−")
    digits = max(floor(log10(abs(value) / sd)) + 2, 2) if value else 2
    return f"{number(value, digits)} ± {number(sd, 2)}"


def rmse_sheet(rmse: RmseRecord) -> Sheet:
    """The error table every report has."""
    return Sheet(
        "Errors",
        ("quantity", "stage", "against", "split", "RMSE", "unit", "samples"),
        [
            (r.quantity, r.stage, r.reference, r.split.replace("_", " "), number(r.rmse),
             r.unit, str(r.n))
            for r in rmse.rows
        ],
        note="Rejected samples: "
        + (", ".join(f"{n} {why}" for why, n in rmse.rejected.items()) or "none")
        + ".",
    )  # fmt: skip


def render_html(
    report: Report, run: RunRecord, recipe_text: str, images: Mapping[str, bytes]
) -> str:
    """One self-contained HTML file; `images` holds each picture's PNG by name."""
    pictures = [
        {
            "name": p.name,
            "caption": p.caption,
            "data": base64.b64encode(images[p.name]).decode("ascii"),
        }
        for p in report.pictures
    ]
    return _template().render(report=report, run=run, pictures=pictures, recipe_text=recipe_text)


@cache
def _template() -> jinja2.Template:
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    source = resources.files("footcal_cli").joinpath("templates/report.html.j2")
    return environment.from_string(source.read_text(encoding="utf-8"))


_MARKS = {"good": "green", "warning": "yellow", "bad": "red"}
_SEVERITY = {"alarm": "red", "warning": "yellow", "note": "cyan"}


def print_text(report: Report, console: Console) -> None:
    """The report for a terminal: verdict, findings and the first table."""
    from rich.table import Table as RichTable

    mark = _MARKS[report.verdict.level]
    console.print(f"[bold {mark}]VERDICT[/]  {_plain(report.verdict.sentence)}", soft_wrap=True)
    for line in report.verdict.details:
        console.print(f"  • {_plain(line)}", soft_wrap=True)
    for finding in report.findings:
        console.print(
            f"[{_SEVERITY[finding.severity]}]{finding.severity.upper()}[/] "
            f"{_plain(finding.where)}: {_plain(finding.sentence)}. → {_plain(finding.remedy)}",
            soft_wrap=True,
        )
    for sheet in (*report.lead_sheets, *report.sheets)[:1]:
        drawn = RichTable(*[_plain(c) for c in sheet.columns], title=_plain(sheet.title))
        shown = sheet.rows[: sheet.folded_after or None]
        if len(shown) < len(sheet.rows):
            drawn.caption = f"{len(sheet.rows) - len(shown)} more rows in the report"
        for row in shown:
            drawn.add_row(*[_plain(cell) for cell in row])
        console.print(drawn)


def _plain(text: str) -> str:
    """Text whose square brackets are not markup."""
    return text.replace("[", r"\[")
