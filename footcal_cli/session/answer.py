"""The answer of a command for programs: one JSON on stdout, asked for by ``--json``."""

from __future__ import annotations

from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # `footcal --help` waits for no record
    from footcal_cli.records.results import AnswerRecord, RunRecord
    from footcal_cli.report.outcome import Outcome

answers: ContextVar[list[AnswerRecord] | None] = ContextVar("answers", default=None)
"""Answers given so far where the command line asks for JSON, else None; set by the app."""


def as_json() -> bool:
    """Whether the command line asks for JSON."""
    return answers.get() is not None


def answer_of(run: RunRecord, outcome: Outcome, folder: Path) -> AnswerRecord:
    """What a finished run says; `folder` is its run folder."""
    from footcal_cli.records.results import AnswerRecord
    from footcal_cli.tables.textfiles import shown

    files = sorted(p for p in folder.rglob("*") if p.is_file())
    parameters = folder / "parameters.json"
    rmse = outcome.rmse
    return AnswerRecord(
        command=run.command,
        exit_code=run.exit_code,
        verdict=run.verdict,
        diagnosis=outcome.diagnosis,
        findings=run.findings,
        gates_missed=run.gates_missed,
        rmse=() if rmse is None else rmse.rows,
        rejected={} if rmse is None else rmse.rejected,
        folder=shown(folder),
        report=shown(folder / "report.html"),
        parameters=shown(parameters) if parameters in files else None,
        pictures=tuple(shown(p) for p in files if p.suffix == ".png"),
        files=tuple(shown(p) for p in files),
    )


def print_refusal(command: str, exit_code: int, line: str) -> None:
    """The answer of a command that could not run."""
    from footcal_cli.records.results import AnswerRecord

    print_answer(AnswerRecord(command=command, exit_code=exit_code, error=line))


def print_answer(answer: AnswerRecord) -> None:
    """Print it as the only thing on stdout."""
    given = answers.get()
    if given is not None:
        given.append(answer)
    print(answer.model_dump_json(indent=2, by_alias=True), flush=True)  # noqa: T201 - the answer
