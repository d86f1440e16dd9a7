"""What a worker does with one session: run the command, keep a row, whatever happens."""

from __future__ import annotations

import contextlib
import hashlib
import inspect
import io
import os
import time
from contextlib import ExitStack
from importlib import import_module
from pathlib import Path

from footcal_cli import __version__
from footcal_cli.batch.plan import Job
from footcal_cli.errors import FootcalError, UsageError, lacks_memory, of_machine
from footcal_cli.records.batch import SessionRecord
from footcal_cli.records.files import read_record, write_record
from footcal_cli.records.results import ParametersRecord, RmseRecord, RunRecord
from footcal_cli.session.answer import answers
from footcal_cli.session.run_folder import claims
from footcal_cli.tables.logfiles import digest

EXIT_BUG = 70
EXIT_DIED = 137


def run_session(job: Job) -> SessionRecord:
    """Run one session unless it is done, and keep its row.

    Every error becomes a row; only the death of the process does not come back.
    """
    began = time.perf_counter()
    try:
        fingerprint = digest_of(job)
    except (OSError, FootcalError) as error:
        refusal = of_machine(error) if isinstance(error, OSError) else error
        return _kept(job, _refused(job, "", refusal.line(), refusal.exit_code))
    done = None if job.again else _done(job, fingerprint)
    if done is not None:
        return done
    exit_code, reason = _run(job)
    seconds = round(time.perf_counter() - began, 3)
    if exit_code not in (0, 1) or not (job.folder / "run.json").is_file():
        return _kept(job, _refused(job, fingerprint, reason, exit_code or EXIT_BUG, seconds))
    return _kept(job, _row(job, fingerprint, seconds))


def digest_of(job: Job) -> str:
    """SHA-256 of all that a session's result depends on."""
    parts = [__version__, job.command, str(job.seed)]
    for path in (job.recipe, job.parameters, *job.logs):
        parts.append("" if path is None else digest(path))
    if not job.logs and job.recipe is not None:
        parts += [digest(path) for path in _recipe_logs(job.recipe)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _recipe_logs(path: Path) -> list[Path]:
    from footcal_cli.commands import option_tables
    from footcal_cli.recipe import read_recipe

    recipe = read_recipe(path, option_tables())
    return [p for role in sorted(recipe.data) for p in recipe.data_paths(role)]


def _done(job: Job, fingerprint: str) -> SessionRecord | None:
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


def _run(job: Job) -> tuple[int, str]:
    """Exit code and, unless it is 0, the one line of a command."""
    import typer

    module = job.command.replace("-", "_")
    command = getattr(import_module(f"footcal_cli.commands.{module}"), module)
    given = {
        "logs": list(job.logs) or None, "recipe": job.recipe, "parameters": job.parameters,
        "out": job.folder, "overwrite": True, "quiet": True, "seed": job.seed,
        "no_pictures": not job.pictures,
    }  # fmt: skip
    known = inspect.signature(command).parameters
    with ExitStack() as stack:
        token = claims.set(stack)
        answered = answers.set(None)  # the batch answers, not its sessions
        try:
            with contextlib.redirect_stderr(io.StringIO()):
                command(**{name: value for name, value in given.items() if name in known})
        except typer.Exit as end:
            return end.exit_code, ""
        except FootcalError as error:
            return error.exit_code, error.line()
        except (OSError, MemoryError) as error:
            machine = of_machine(error)
            return machine.exit_code, machine.line()
        except Exception as error:
            if lacks_memory(error):
                return of_machine(error).exit_code, of_machine(error).line()
            return EXIT_BUG, f"internal error: {type(error).__name__}: {error}"
        finally:
            claims.reset(token)
            answers.reset(answered)
    return 0, ""


def _row(job: Job, fingerprint: str, seconds: float) -> SessionRecord:
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


def _refused(
    job: Job, fingerprint: str, reason: str, exit_code: int, seconds: float = 0.0
) -> SessionRecord:
    return SessionRecord(
        session=job.name, robot=job.robot, date=job.date, operator=job.operator,
        command=job.command, logs=tuple(map(str, job.logs)), outcome="refused",
        exit_code=exit_code, reason=reason or "the command ended without a reason",
        digest=fingerprint, attempts=1, seconds=seconds, rows=0,
    )  # fmt: skip


def died(job: Job, attempts: int) -> SessionRecord:
    """The row of a session over which the worker died each time."""
    row = _refused(
        job, "", f"the worker process died {attempts} times over this session (out of memory?)",
        EXIT_DIED,
    )  # fmt: skip
    return _kept(job, row.model_copy(update={"attempts": attempts}))


def _kept(job: Job, row: SessionRecord) -> SessionRecord:
    """Write a row whole or not at all."""
    job.record.parent.mkdir(parents=True, exist_ok=True)
    partial = job.record.with_suffix(".partial")
    write_record(row, partial)
    os.replace(partial, job.record)
    return row
