"""``footcal batch``: one command on many sessions, and what they say together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from pydantic import Field

from footcal_cli.commands.options import (
    NoPictures,
    Overwrite,
    ParametersFile,
    Quiet,
    RecipeFile,
    Seed,
    StrictFindings,
    begin,
)
from footcal_cli.recipe import CommandOptions

if TYPE_CHECKING:
    from collections.abc import Iterable

    from footcal_cli.batch.plan import Job
    from footcal_cli.core.fleet import Fleet
    from footcal_cli.records.batch import SessionRecord
    from footcal_cli.session.session import Outcome, Session

Runnable = Literal[
    "check", "apply", "offline-fit", "static-init", "online-replay", "hang-calib", "pose-calib",
    "diagnose",
]  # fmt: skip


_MOST_REFUSALS = 20


class BatchOptions(CommandOptions):
    """``[batch]`` of a recipe.

    `workers` 0 means one per processor; `max_drift` holds limits by parameter or by its last word
    (``bias = 0.3``), in the parameter's unit.
    """

    command: Runnable = "online-replay"
    workers: int = Field(default=0, ge=0, le=1024)
    scheduler: str | None = None
    max_drift: dict[str, float] = Field(default_factory=dict)


def batch(
    sessions: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SESSIONS...",
            help="Globs of logs or of folders with logs, or a table (CSV, Parquet, TOML) with the "
            "columns session, robot, date, operator, logs, recipe, parameters.",
        ),
    ] = None,
    recipe: RecipeFile = None,
    parameters: ParametersFile = None,
    command: Annotated[
        str | None, typer.Option("--command", help="What is run on each session.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option("--workers", help="Local processes; 0: one per processor.")
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="tcp://HOST:PORT", help="An existing Dask cluster."),
    ] = None,
    strict_findings: StrictFindings = None,
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Folder to write, or to go on with.")
    ] = Path("out/batch"),
    overwrite: Overwrite = False,
    seed: Seed = 0,
    no_pictures: NoPictures = False,
    quiet: Quiet = False,
) -> None:
    """Run one command on many sessions and compare them over dates and robots."""
    session = begin(
        "batch",
        BatchOptions,
        logs=None,
        recipe=recipe,
        parameters=parameters,
        out=out,
        overwrite=overwrite,
        seed=seed,
        quiet=quiet,
        no_pictures=no_pictures,
        strict_findings=strict_findings,
        goes_on=True,
        command=command,
        workers=workers,
        scheduler=scheduler,
    )
    raise typer.Exit(session.finish(_batch(session, sessions or [])))


def _batch(session: Session[BatchOptions], given: Sequence[str]) -> Outcome:
    from footcal_cli.core.fleet import study
    from footcal_cli.report import Report
    from footcal_cli.session.session import Outcome
    from footcal_cli.sheets import batch as sheets
    from footcal_cli.tables.table import write_csv, write_parquet

    jobs = _jobs(session, given)
    with session.step("sessions"):
        ended = {row.session: row for row in _rows(session, jobs)}
    rows = _in_time(ended[job.name] for job in jobs)
    session.rows |= {row.session: row.rows for row in rows}
    session.inputs |= {row.session: row.digest for row in rows}
    good = [row for row in rows if row.outcome != "refused"]
    days = _days(good)
    fleet = study(sheets.sessions_of(good, days))
    limits = session.options.max_drift
    if good:
        _known_limits(limits, fleet, session)
    missed = sheets.gates_missed(fleet, limits)
    pictures = sheets.pictures_of(fleet, days is not None)
    refused = _refused(rows)
    frame = sheets.frame_of(rows)
    return Outcome(
        report=Report(
            title=f"{len(rows)} sessions, {session.options.command}",
            verdict=sheets.verdict_of(rows, fleet, len(missed)),
            pictures=pictures,
            sheets=sheets.sheets_of(rows, fleet),
            findings=tuple(sheets.findings_of(fleet)),
            footer=(
                "Each session's own report lies in sessions/<session>/report.html.",
                "Sessions in the order of their dates." if days is not None else
                "Not every session has a date: sessions in the order of their names.",
            ),
        ),
        files={
            "sessions.parquet": lambda path: write_parquet(frame, path),
            "sessions.csv": lambda path: write_csv(frame, path),
        },
        gates_missed=(*refused, *missed),
        usable=bool(good),
    )  # fmt: skip


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


def _refused(rows: Sequence[SessionRecord]) -> list[str]:
    """A line per refused session; of many, the first ones."""
    lines = [f"session {r.session}: {r.reason}" for r in rows if r.outcome == "refused"]
    more = len(lines) - _MOST_REFUSALS
    return [
        *lines[:_MOST_REFUSALS],
        *([f"{more} more sessions: see sessions.csv"] if more > 0 else []),
    ]


def _rows(session: Session[BatchOptions], jobs: list[Job]) -> Iterable[SessionRecord]:
    import os

    from footcal_cli.batch.cluster import run_on_cluster
    from footcal_cli.batch.local import run_here
    from footcal_cli.commands.parts.batch_work import died, run_session

    options = session.options
    if options.scheduler is not None:
        # workers elsewhere have another working folder
        ended = run_on_cluster([j.anywhere() for j in jobs], options.scheduler, run_session, died)
    else:
        ended = run_here(jobs, options.workers or os.cpu_count() or 1, run_session, died)
    return session.progress(ended, "sessions", len(jobs))


def _in_time(rows: Iterable[SessionRecord]) -> list[SessionRecord]:
    """Sessions by date; by name where one has none."""
    found = sorted(rows, key=lambda row: row.session)
    if all(row.date is not None for row in found):
        found.sort(key=lambda row: _stamp(str(row.date)))
    return found


def _days(rows: Sequence[SessionRecord]) -> list[float] | None:
    """Days after the first session; None where a date is missing or all are the same."""
    if not rows or any(row.date is None for row in rows):
        return None
    stamps = [_stamp(str(row.date)) for row in rows]
    days = [(stamp - min(stamps)) / 86400.0 for stamp in stamps]
    return days if max(days) > 0 else None


def _stamp(date: str) -> float:
    """Seconds since 1970; a date without a zone counts as UTC."""
    from datetime import UTC, datetime

    stamp = datetime.fromisoformat(date)
    return (stamp if stamp.tzinfo is not None else stamp.replace(tzinfo=UTC)).timestamp()


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
