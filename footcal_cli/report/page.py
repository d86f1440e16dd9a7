"""A report as one self-contained HTML file: result and action, evidence, details, how it was run.

Style and script stand in the page; a Content-Security-Policy allows them by their hash and nothing
else, so that text from a log cannot run.
"""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from importlib import resources
from itertools import groupby
from typing import TYPE_CHECKING

from footcal_cli.core.quality import Finding
from footcal_cli.records.results import RunRecord
from footcal_cli.report import Drawn, Picture, Report, Sheet, plural
from footcal_cli.report.causes import one_per_cause
from footcal_cli.report.columns import EMPTY, laid_out

if TYPE_CHECKING:
    import jinja2
    from markupsafe import Markup

_OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
_LEVELS = {
    "good": ("✓", "Result"),
    "warning": ("!", "Needs attention"),
    "bad": ("✕", "Not to be relied on"),
}
_TALL = 0.9
"""From this ratio of height to width on a figure keeps its size on paper."""
_SHORT = 16
"""A table of so many rows stays on one sheet of paper; what explains it may go on to the next."""
_MOST_LINES, _FEW_LINES = 5, 3
"""More lines below a result than the first number are folded, but for the second number of them."""
_SEVERITIES = {"alarm": "✕", "warning": "!", "note": "i"}
_FILES = {
    "parameters.json": "the calibration, for --parameters",
    "parameters_rejected.json": "the calibration that was not accepted, with the reason",
    "parameters_extended.json": "the calibration with the identified effects in it",
    "diagnosis.json": "the diagnosis for programs",
    "rmse.json": "errors before and after, for programs",
    "rmse.csv": "errors before and after, for a spreadsheet",
    "run.json": "what was run, on which files, how long it took",
    "predictions.parquet": "each reading with its prediction and interval",
    "placements.parquet": "each placement with raw and corrected CoP",
    "cop_correction.json": "the CoP correction, for apply --cop-correction",
    "replay.parquet": "forces, CoP and parameters, sample by sample",
    "wrenches.parquet": "foot wrenches, pose by pose",
    "body.parquet": "the body's motion",
    "cells.parquet": "the readings",
    "true_loads.parquet": "the loads without the sensors' errors",
    "models.parquet": "the candidate models and their errors",
    "sessions.parquet": "a row per session: parameters, errors, verdict",
    "sessions.csv": "a row per session, for a spreadsheet",
    "plan.json": "the experiments that would distinguish the rivals, for programs",
    "sensitivity.parquet": "errors of CoP and force with each setting scaled",
    "truth.json": "what was true of the simulated logs",
    "calibrated.parquet": "the log with its calibration applied",
}


@dataclass(frozen=True)
class _Table:
    """A table with its number, anchor and the alignment of its columns."""

    number: int
    anchor: str
    sheet: Sheet
    numeric: tuple[bool, ...]

    @property
    def folded(self) -> int:
        """How many rows are folded away."""
        sheet = self.sheet
        return max(len(sheet.rows) - sheet.folded_after, 0) if sheet.folded_after else 0

    @property
    def short(self) -> bool:
        """Whether a sheet of paper keeps it whole."""
        return len(self.sheet.rows) <= _SHORT

    @property
    def reason_only(self) -> frozenset[int]:
        """Greyed rows that hold nothing but the reason in their last cell."""
        return frozenset(
            i for i in self.sheet.greyed if all(c in EMPTY for c in self.sheet.rows[i][2:-1])
        )


@dataclass(frozen=True)
class _Figure:
    """A figure with its number, and what it shows in words."""

    number: int
    picture: Picture
    data: str
    curves: str
    result: str
    width_px: int
    tall: bool


def render_html(
    report: Report,
    run: RunRecord,
    recipe_text: str,
    images: Mapping[str, Drawn],
    files: Sequence[str] = (),
) -> str:
    """The page; `images` holds each picture by name, drawn, `files` what lies beside the page."""
    leading = [_table(sheet, i + 1) for i, sheet in enumerate(report.leading)]
    details = [_table(s, len(leading) + i + 1) for i, s in enumerate(report.details)]
    figures = [
        _Figure(
            number=i + 1,
            picture=picture,
            data=base64.b64encode(images[picture.name].png).decode("ascii"),
            curves=images[picture.name].curves,
            result=picture.sentence,
            width_px=_size_px(images[picture.name].png)[0],
            tall=_is_tall(images[picture.name].png),
        )
        for i, picture in enumerate(report.pictures)
    ]
    mark, level = _LEVELS[report.verdict.level]
    urgent = _with_one_remedy([f for f in report.findings if f.severity != "note"])
    lines, shown = report.verdict.details, len(report.verdict.details)
    if shown > _MOST_LINES:
        shown = _FEW_LINES
    style, script = _asset("report.css"), _asset("report.js")
    if any(figure.curves for figure in figures):
        style, script = _asset("uplot.css") + style, _asset("uplot.js") + script
    return _template().render(
        report=report, run=run, recipe_text=recipe_text, leading=leading, details=details,
        shown=lines[:shown], more=lines[shown:], figures=figures, mark=mark, level=level,
        severities=_SEVERITIES, urgent=urgent,
        notes=_with_one_remedy([f for f in report.findings if f.severity == "note"]),
        files=[(name, _FILES.get(name, "")) for name in files], plural=plural,
        style=style, script=script, style_hash=_hash(style), script_hash=_hash(script),
        started=_moment(run.started),
    )  # fmt: skip


def _table(sheet: Sheet, count: int) -> _Table:
    """A sheet as the template draws it."""
    sheet, numeric = laid_out(sheet)
    return _Table(count, f"table-{count}", sheet, numeric)


def _size_px(png: bytes) -> tuple[int, int]:
    """Width and height of a figure, which stand in the PNG's first chunk."""
    return int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")


def _is_tall(png: bytes) -> bool:
    """Whether a figure is about as high as it is wide."""
    width, height = _size_px(png)
    return height > _TALL * width


def _with_one_remedy(findings: Sequence[Finding]) -> list[list[Finding]]:
    """Findings that follow each other and ask for the same, those of one cause as one."""
    asks = groupby(one_per_cause(findings), lambda finding: (finding.severity, finding.remedy))
    return [list(group) for _, group in asks]


def _moment(stamp: str) -> str:
    """``2026-11-25 19:13 UTC`` of an ISO stamp."""
    moment = datetime.fromisoformat(stamp)
    return f"{moment:%Y-%m-%d %H:%M} {moment.tzname() or ''}".strip()


@cache
def _template() -> jinja2.Template:
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["options"] = _options_whole
    return environment.from_string(_asset("report.html.j2"))


def _options_whole(text: str) -> Markup:
    """A sentence in HTML whose ``--options`` no line breaks."""
    from markupsafe import Markup, escape

    return Markup(_OPTION.sub(r'<span class="whole">\g<0></span>', str(escape(text))))


@cache
def _asset(name: str) -> str:
    source = resources.files("footcal_cli.report").joinpath("templates").joinpath(name)
    return source.read_text(encoding="utf-8")


def _hash(text: str) -> str:
    """The source expression by which a Content-Security-Policy allows a text."""
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"
