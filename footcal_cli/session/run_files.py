"""The files of a run folder."""

from __future__ import annotations

import csv
import json
import re
import shutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from footcal_cli.records.files import write_record
from footcal_cli.records.results import RmseRecord, RunRecord
from footcal_cli.report import Drawn, rmse_sheet
from footcal_cli.report.outcome import Outcome
from footcal_cli.report.page import render_html
from footcal_cli.session.request import REJECTED
from footcal_cli.session.run_folder import scratch
from footcal_cli.tables.logfiles import write_csv, write_parquet, write_parquet_pieces

_BROKEN_LIST = re.compile(r"([\[{])\s*((?:[^\[\]{}\"]|\"[^\"\n]*\"){1,120}?)\s*([\]}])")
"""Values without further lists or tables in them, short enough for a line."""


def write_run(folder: Path, run: RunRecord, outcome: Outcome, images: Mapping[str, Drawn]) -> None:
    """Everything a run leaves, into one folder; `images` holds each picture by name, drawn."""
    if outcome.parameters is not None:
        rejected = run.gates_missed or (() if outcome.usable else (run.verdict.sentence,))
        name = REJECTED if rejected else "parameters.json"
        marked = outcome.parameters.model_copy(update={"rejected_because": rejected})
        write_record(marked, folder / name)
    if outcome.rmse is not None:
        write_record(outcome.rmse, folder / "rmse.json")
        _write_rmse_csv(outcome.rmse, folder / "rmse.csv")
        if outcome.rmse.rows:
            outcome = replace(outcome, sheets=(*outcome.sheets, rmse_sheet(outcome.rmse)))
    for name, record in outcome.records.items():
        write_record(record, folder / name)
    for name, columns in outcome.tables.items():
        (write_csv if name.endswith(".csv") else write_parquet)(columns, folder / name)
    for name, write in outcome.files.items():
        write(folder / name)
    (folder / "figures").mkdir()
    for name, image in images.items():
        (folder / "figures" / f"{name}.png").write_bytes(image.png)
    settings = {**run.recipe, run.command: run.options}
    recipe_text = _BROKEN_LIST.sub(_on_one_line, json.dumps(settings, indent=2, ensure_ascii=False))
    beside = sorted({"run.json", *(p.name for p in folder.iterdir() if p.is_file())})
    (folder / "report.html").write_text(
        render_html(outcome, run, recipe_text, images, beside), encoding="utf-8"
    )
    files = sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())
    write_record(run.model_copy(update={"files": tuple(files)}), folder / "run.json")


def _on_one_line(found: re.Match[str]) -> str:
    """A list or table of plain values, as a person would write it."""
    opening, inner, closing = found.groups()
    return f"{opening}{' '.join(inner.split())}{closing}"


def set_aside(pieces: Iterable[Mapping[str, object]], name: str) -> Callable[[Path], None]:
    """Write a long table as its pieces come; what is returned moves it into the run folder."""
    written = scratch() / name
    write_parquet_pieces(pieces, written)

    def move(path: Path) -> None:
        shutil.move(written, path)

    return move


def _write_rmse_csv(rmse: RmseRecord, path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as stream:
        names = ["quantity", "unit", "stage", "reference", "split", "rmse", "n"]
        writer = csv.DictWriter(stream, names)
        writer.writeheader()
        writer.writerows(row.model_dump() for row in rmse.rows)
