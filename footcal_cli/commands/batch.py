"""``footcal batch``: one command on many sessions, and what they say together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from pydantic import Field

from footcal_cli.commands.options import command
from footcal_cli.recipe import CommandOptions
from footcal_cli.recipe.options import Flag

if TYPE_CHECKING:
    from collections.abc import Generator

    from footcal_cli.batch.plan import Job
    from footcal_cli.core.fleet import Fleet
    from footcal_cli.records.batch import SessionRecord
    from footcal_cli.report.outcome import Outcome
    from footcal_cli.session.session import Session

EXIT_BUG = 70
Runnable = Literal[
    "check", "apply", "offline-fit", "static-init", "online-replay", "hang-calib", "pose-calib",
    "diagnose",
]  # fmt: skip


class BatchOptions(CommandOptions):
    """``[batch]`` of a recipe.

    `workers` 0 means one per processor; `max_drift` holds limits by parameter or by its last word
    (``bias = 0.3``), in the parameter's unit.
    """

    command: Annotated[Runnable, Flag("What is run on each session.")] = "online-replay"
    workers: Annotated[int, Flag("Local processes; 0: one per processor.")] = Field(
        default=0, ge=0, le=1024
    )
    scheduler: Annotated[
        str | None, Flag("An existing Dask cluster.", metavar="tcp://HOST:PORT")
    ] = None
    max_drift: dict[str, float] = Field(default_factory=dict)


_SHARED: dict[str, Any] = {
    "out": Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Folder to write, or to continue in.")
    ]
}
_EXTRA: dict[str, Any] = {
    "sessions": Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SESSIONS",
            help="Globs of logs or of folders with logs, or a table (CSV, Parquet, TOML) with the "
            "columns session, robot, date, operator, logs, recipe, parameters.",
        ),
    ]
}


@command(BatchOptions, lacks=("logs", "reference"), shared=_SHARED, extra=_EXTRA, goes_on=True)
def batch(session: Session[BatchOptions], sessions: list[str] | None) -> Outcome:
    """Run one command on many sessions and compare them over dates and robots."""
    from contextlib import closing

    from footcal_cli.core.fleet import study
    from footcal_cli.errors import MachineError
    from footcal_cli.sheets.batch import days, in_time, outcome_of, sessions_of

    options = session.options
    jobs = _jobs(session, sessions or [])
    with session.step("sessions"), closing(_rows(session, jobs)) as rows:
        ended = {row.session: row for row in rows}
    found = in_time(ended[job.name] for job in jobs)
    session.rows |= {row.session: row.rows for row in found}
    session.inputs |= {row.session: row.digest for row in found}
    good = [row for row in found if row.outcome != "refused"]
    failed = [row for row in found if row.exit_code == MachineError.exit_code]
    if failed and not good:  # what lies there is gone on with when the machine can
        raise MachineError(f"session {failed[0].session}: {failed[0].reason}")
    fleet = study(sessions_of(good, days(good)))
    if good:
        _known_limits(options.max_drift, fleet, session)
    return outcome_of(options.command, found, options.max_drift, fleet)


def _jobs(session: Session[BatchOptions], given: Sequence[str]) -> list[Job]:
    from footcal_cli.batch.plan import Job, plan
    from footcal_cli.errors import UsageError

    if not given:
        raise UsageError(
            "no sessions given", remedy="give a quoted glob ('logs/*') or a table of sessions"
        )
    request, robot = session.request, session.recipe.robot
    common = Job(
        name="", robot=robot.name if "name" in robot.model_fields_set else "", date=None,
        operator="", logs=(), recipe=request.recipe,
        parameters=request.parameters, command=session.options.command,
        seed=request.seed, out=request.out.resolve(), again=request.overwrite,
        pictures=session.options.pictures,
    )  # fmt: skip
    return plan(given, common)


def _rows(session: Session[BatchOptions], jobs: list[Job]) -> Generator[SessionRecord]:
    import os

    from footcal_cli.batch.cluster import run_on_cluster
    from footcal_cli.batch.local import run_here
    from footcal_cli.batch.rows import died
    from footcal_cli.session.run_folder import GROWN_ROWS

    options = session.options
    # from here on the folder may be gone on with, whatever happens
    (session.request.out / GROWN_ROWS).mkdir(parents=True, exist_ok=True)
    if options.scheduler is not None:
        # workers elsewhere have another working folder
        ended = run_on_cluster([j.anywhere() for j in jobs], options.scheduler, run_session, died)
    else:
        ended = run_here(jobs, options.workers or os.cpu_count() or 1, run_session, died)
    return session.progress(ended, "sessions", len(jobs))


def run_session(job: Job) -> SessionRecord:
    """Run one session unless it is done, and keep its row.

    Every error becomes a row; only the death of the process does not come back. A process that is
    asked to end first cleans up what is half done.
    """
    from footcal_cli.session.interruption import Interrupted, watched

    with watched() as interruption:
        try:
            return _row_of(job)
        except Interrupted:
            raise SystemExit(interruption.exit_code) from None


def _row_of(job: Job) -> SessionRecord:
    import time

    from footcal_cli.batch import rows
    from footcal_cli.errors import FootcalError, of_machine

    began = time.perf_counter()
    try:
        fingerprint = rows.digest_of(job, recipe_logs)
    except (OSError, FootcalError) as error:
        refusal = of_machine(error) if isinstance(error, OSError) else error
        return rows.kept(job, rows.refused(job, "", refusal.line(), refusal.exit_code))
    done = None if job.again else rows.done(job, fingerprint)
    if done is not None:
        return done
    job.record.unlink(missing_ok=True)  # a row never stands beside the folder of another run
    exit_code, reason = _run(job)
    seconds = round(time.perf_counter() - began, 3)
    if exit_code not in (0, 1) or not (job.folder / "run.json").is_file():
        return rows.kept(
            job, rows.refused(job, fingerprint, reason, exit_code or EXIT_BUG, seconds)
        )
    return rows.kept(job, rows.row(job, fingerprint, seconds))


def recipe_logs(path: Path) -> list[Path]:
    """Logs that a recipe names."""
    from footcal_cli.commands import option_tables
    from footcal_cli.recipe import read_recipe

    recipe = read_recipe(path, option_tables())
    return [p for role in sorted(recipe.data) for p in recipe.data_paths(role)]


def _run(job: Job) -> tuple[int, str]:
    """Exit code and, unless it is 0, the one line of a command."""
    import contextlib
    import inspect
    import io
    from importlib import import_module

    from footcal_cli.errors import FootcalError, lacks_memory, of_machine
    from footcal_cli.session.answer import answers
    from footcal_cli.session.run_folder import claims

    module = job.command.replace("-", "_")
    command = getattr(import_module(f"footcal_cli.commands.{module}"), module)
    given = {
        "logs": list(job.logs) or None, "recipe": job.recipe, "parameters": job.parameters,
        "out": job.folder, "overwrite": True, "quiet": True, "seed": job.seed,
        "no_pictures": not job.pictures,
    }  # fmt: skip
    known = inspect.signature(command).parameters
    with contextlib.ExitStack() as stack:
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


def _known_limits(
    limits: Mapping[str, float], fleet: Fleet, session: Session[BatchOptions]
) -> None:
    """Refuse a limit that no parameter has: it would let everything pass."""
    from footcal_cli.errors import UsageError, nearest

    names = {one.parameter for one in fleet.series}
    known = sorted(names | {name.rsplit(".", 1)[-1] for name in names})
    for name in limits:
        if name not in known:
            raise UsageError(
                f"[batch] max_drift: no session estimated '{name}'{nearest(name, known)}",
                file=session.recipe.path, remedy="name a parameter, or its last word",
            )  # fmt: skip
