"""The row of a session: made of its run folder or of what went wrong, and kept."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path

from footcal_cli import __version__
from footcal_cli.batch.plan import Job
from footcal_cli.errors import UsageError
from footcal_cli.records.batch import SessionRecord
from footcal_cli.records.files import read_record, write_record
from footcal_cli.records.results import ParametersRecord, RmseRecord, RunRecord
from footcal_cli.tables.logfiles import digest

EXIT_DIED = 137


def digest_of(job: Job, recipe_logs: Callable[[Path], list[Path]]) -> str:
    """SHA-256 of all that a session's result depends on; `recipe_logs` where it names no logs."""
    parts = [__version__, job.command, str(job.seed)]
    for path in (job.recipe, job.parameters, *job.logs):
        parts.append("" if path is None else digest(path))
    if not job.logs and job.recipe is not None:
        parts += [digest(path) for path in recipe_logs(job.recipe)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def done(job: Job, fingerprint: str) -> SessionRecord | None:
    """The row of an earlier run of the same session."""
    if not job.record.is_file() or not (job.folder / "run.json").is_file():
        return None
    try:
        row = read_record(SessionRecord, job.record)
    except UsageError:
        return None
    if row.digest != fingerprint or row.outcome == "refused":
        return None
    # what is said about a session may have been corrected in the table
    said = {"robot": job.robot or row.robot, "date": job.date, "operator": job.operator}
    return row.model_copy(update=said)


def row(job: Job, fingerprint: str, seconds: float) -> SessionRecord:
    """The row of a session from its run folder."""
    run = read_record(RunRecord, job.folder / "run.json")
    parameters, rmse = {}, {}
    for name in ("parameters.json", "parameters_rejected.json"):
        if (job.folder / name).is_file():
            parameters = read_record(ParametersRecord, job.folder / name).parameters
    if (job.folder / "rmse.json").is_file():
        rmse = {
            f"{r.quantity}.{r.stage}.{r.reference}": r.rmse
            for r in read_record(RmseRecord, job.folder / "rmse.json").rows
            if r.split != "train"
        }
    robot = job.robot or str(run.recipe.get("robot", {}).get("name", ""))
    return SessionRecord(
        session=job.name, robot=robot, date=job.date, operator=job.operator, command=job.command,
        logs=tuple(map(str, job.logs)), outcome="gate not met" if run.exit_code else "done",
        exit_code=run.exit_code, reason="; ".join(run.gates_missed), digest=fingerprint,
        attempts=1, seconds=seconds, rows=sum(run.rows.values()), verdict=run.verdict,
        findings=tuple(sorted({f.code for f in run.findings if f.severity != "note"})),
        parameters=parameters, rmse=rmse,
    )  # fmt: skip


def refused(
    job: Job, fingerprint: str, reason: str, exit_code: int, seconds: float = 0.0
) -> SessionRecord:
    """The row of a session that came to nothing."""
    return SessionRecord(
        session=job.name, robot=job.robot, date=job.date, operator=job.operator,
        command=job.command, logs=tuple(map(str, job.logs)), outcome="refused",
        exit_code=exit_code, reason=reason or "the command ended without a reason",
        digest=fingerprint, attempts=1, seconds=seconds, rows=0,
    )  # fmt: skip


def died(job: Job, attempts: int) -> SessionRecord:
    """The row of a session over which the worker died each time."""
    row = refused(
        job, "", f"the worker process died {attempts} times over this session (out of memory?)",
        EXIT_DIED,
    )  # fmt: skip
    return kept(job, row.model_copy(update={"attempts": attempts}))


def kept(job: Job, row: SessionRecord) -> SessionRecord:
    """Write a row whole or not at all."""
    job.record.parent.mkdir(parents=True, exist_ok=True)
    partial = job.record.with_name(f".{job.name}.partial-row")
    write_record(row, partial)
    os.replace(partial, job.record)
    return row
