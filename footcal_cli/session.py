"""A run: what a command was asked, what it read, and the folder it leaves behind.

The run folder is written under a temporary name and renamed at the end, so that an interrupted run
leaves nothing half-written.
"""

from __future__ import annotations

import csv
import json
import sys
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Generic, TypeVar

from rich.console import Console
from rich.progress import track

from footcal_cli.columns import TableType
from footcal_cli.core.quality import Finding
from footcal_cli.errors import DataError, FootcalError, UsageError
from footcal_cli.recipe import CommandOptions, Recipe, read_recipe, validated
from footcal_cli.records.files import Versioned, read_record, write_record
from footcal_cli.records.results import FindingRecord, ParametersRecord, RmseRecord, RunRecord
from footcal_cli.report import Report, print_text, render_html, rmse_sheet
from footcal_cli.run_folder import claim, refuse_folder, whole_folder
from footcal_cli.tables import Table, digest, read_table, refusal_of

_PIPE_WIDTH = 160  # columns of a table that no terminal limits

Options = TypeVar("Options", bound=CommandOptions)
Item = TypeVar("Item")


@dataclass(frozen=True)
class Request:
    """What the command line asked of any command."""

    command: str
    logs: tuple[Path, ...]
    recipe: Path | None
    parameters: Path | None
    out: Path
    overwrite: bool
    seed: int
    quiet: bool
    overrides: Mapping[str, object]

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Files that the command line names as inputs."""
        named = [self.recipe, self.parameters, *self.overrides.values()]
        return (*self.logs, *(path for path in named if isinstance(path, Path)))


@dataclass(frozen=True)
class Outcome:
    """What a command found, ready to be written.

    Parameters
    ----------
    report
        What people read.
    rmse
        Errors before and after.
    parameters
        The calibration, None for a command that makes none.
    records
        Further records by file name.
    files
        Further files by name -> a function that writes it.
    gates_missed
        Sentences of the gates that were not met; any makes the exit code 1.
    usable
        False: nothing to be trusted came out (exit code 3).
    """

    report: Report
    rmse: RmseRecord | None = None
    parameters: ParametersRecord | None = None
    records: Mapping[str, Versioned] = field(default_factory=dict)
    files: Mapping[str, Callable[[Path], None]] = field(default_factory=dict)
    gates_missed: tuple[str, ...] = ()
    usable: bool = True


class Session(Generic[Options]):
    """One run of one command: recipe, options, inputs read so far, timings.

    Parameters
    ----------
    request
        From the command line.
    options_model
        The command's table in a recipe.
    commands
        Names of all option tables a recipe may hold.
    """

    def __init__(
        self, request: Request, options_model: type[Options], commands: Collection[str]
    ) -> None:
        self.request = request
        self.started = datetime.now(UTC)
        self.console = Console(stderr=True, quiet=request.quiet)
        refuse_folder(request.out, request.overwrite, request.inputs)
        self.recipe = (
            read_recipe(request.recipe, commands) if request.recipe is not None else Recipe()
        )
        table = request.command.replace("-", "_")
        given = {k: v for k, v in request.overrides.items() if v is not None}
        self.options: Options = validated(
            options_model,
            {**self.recipe.options.get(table, {}), **given},
            file=request.recipe,
            table=table,
        )
        refuse_folder(request.out, request.overwrite, self.input_paths())
        claim(request.out)
        self.parameters: ParametersRecord | None = None
        self.inputs: dict[str, str] = {}
        self.rows: dict[str, int] = {}
        self.timings_s: dict[str, float] = {}
        self._taken: set[Path] = set()
        self._left_aside: dict[Path, FootcalError] = {}
        self._noted: list[Finding] = []
        if request.parameters is not None:
            self.parameters = read_calibration(request.parameters)
            self.inputs[_shown(request.parameters)] = digest(request.parameters)

    def input_paths(self) -> tuple[Path, ...]:
        """Every file that this run may read: of the command line, of ``[data]``, of the options."""
        data = [path for role in self.recipe.data for path in self.recipe.data_paths(role)]
        folder = self.recipe.path.parent if self.recipe.path is not None else Path()
        options = [
            folder / str(value)
            for value in self.options.model_dump().values()
            if isinstance(value, (str, Path)) and (folder / str(value)).is_file()
        ]
        return (*self.request.inputs, *([] if self.request.logs else data), *options)

    def paths(self, role: str) -> list[Path]:
        """Logs of a role: the LOG arguments where given, else the recipe's ``[data]``."""
        return list(self.request.logs) or self.recipe.data_paths(role)

    def read(self, table: TableType, role: str | None = None) -> list[Table]:
        """Read all logs of a role that have the table's columns.

        A LOG argument of another kind is left to the command's other table types; with ``[data]``
        the role says which log is which.

        Raises
        ------
        DataError
            From the first log that cannot be read.
        """
        role = role or table.name
        tables = []
        for path in self.paths(role):
            if self.request.logs and path.is_file():
                refusal = refusal_of(path, table, self.recipe.reading(path))
                if refusal is not None:
                    self._left_aside.setdefault(path, refusal)
                    continue
            self._taken.add(path)
            read = self._read(path, table)
            self.inputs[_shown(path)] = read.digest
            self.inputs |= {_shown(beside): found for beside, found in read.beside.items()}
            self.rows[_shown(path)] = len(read)
            tables.append(read)
        return tables

    def read_required(self, table: TableType, role: str | None = None) -> list[Table]:
        """As `read`, but at least one log must be there.

        Raises
        ------
        UsageError
            No log was named.
        DataError
            None of the named logs has the columns; says what the first one lacks.
        """
        tables = self.read(table, role)
        if tables:
            return tables
        named = self.paths(role or table.name)
        if not named:
            raise UsageError(
                f"no {role or table.name} log given", file=self.recipe.path,
                remedy=f"name a LOG on the command line or '{role or table.name}' in [data]",
            )  # fmt: skip
        self._read(named[0], table)
        raise DataError("no log with the needed columns", file=named[0])

    def _read(self, path: Path, table: TableType) -> Table:
        return read_table(
            path, table, self.recipe.reading(path), gravity_mps2=self.recipe.robot.gravity_mps2
        )

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Time a step of the work; shown while it runs on a terminal."""
        began = time.perf_counter()
        if self.console.is_terminal:
            with self.console.status(name):
                yield
        else:
            yield
        self.timings_s[name] = round(time.perf_counter() - began, 4)

    def progress(self, items: Iterable[Item], description: str, total: int) -> Iterable[Item]:
        """Iterate with a progress bar on a terminal, quietly in a pipe."""
        return track(
            items,
            description,
            total=total,
            console=self.console,
            disable=not self.console.is_terminal,
            transient=True,
        )

    def note(self, findings: Iterable[Finding]) -> None:
        """Keep findings for the report, whoever made them; `finish` merges them with its own."""
        self._noted += findings

    @property
    def noted(self) -> tuple[Finding, ...]:
        """Findings kept so far."""
        return tuple(self._noted)

    def created(self) -> str:
        """The run's start as ISO 8601 in UTC."""
        return self.started.isoformat(timespec="seconds")

    def finish(self, outcome: Outcome) -> int:
        """Write the run folder, print the verdict, return the exit code.

        Raises
        ------
        DataError
            A LOG was none of the kinds that the command reads.
        """
        for path, refusal in self._left_aside.items():
            if path not in self._taken:
                raise refusal
        outcome = replace(
            outcome, report=_with_findings(outcome.report, map(FindingRecord.of, self._noted))
        )
        missed = (*outcome.gates_missed, *self._strict(outcome.report))
        outcome = replace(outcome, gates_missed=missed)
        exit_code = 3 if not outcome.usable else 1 if missed else 0
        run = RunRecord(
            command=self.request.command,
            started=self.created(),
            arguments={
                "logs": [_shown(path) for path in self.request.logs],
                "recipe": _shown_or_none(self.request.recipe),
                "parameters": _shown_or_none(self.request.parameters),
            },
            recipe=self.recipe.model_dump(mode="json", exclude={"options", "path"}),
            options=self.options.model_dump(mode="json"),
            inputs=self.inputs,
            rows=self.rows,
            seed=self.request.seed,
            timings_s=self.timings_s,
            verdict=outcome.report.verdict,
            findings=outcome.report.findings,
            gates_missed=outcome.gates_missed,
            exit_code=exit_code,
        )
        with whole_folder(self.request.out, self.request.overwrite, self.input_paths()) as folder:
            _write(folder, run, outcome)
        answer = Console(quiet=self.request.quiet, highlight=False)
        if not answer.is_terminal:
            answer = Console(quiet=self.request.quiet, highlight=False, width=_PIPE_WIDTH)
        print_text(outcome.report, answer)
        for gate in outcome.gates_missed:
            print(f"GATE NOT MET  {gate}", file=sys.stderr)  # noqa: T201 - the command's answer
        answer.print(f"report: {self.request.out / 'report.html'}", soft_wrap=True)
        return exit_code

    def _strict(self, report: Report) -> tuple[str, ...]:
        """The gate of ``--strict-findings``: warnings and alarms of the data, by code."""
        if not self.options.strict_findings:
            return ()
        serious = sorted({f.code for f in report.findings if f.severity != "note"})
        return (f"strict findings: {', '.join(serious)}",) if serious else ()


def read_calibration(path: Path) -> ParametersRecord:
    """Read a calibration that may be used.

    Raises
    ------
    UsageError
        It cannot be read, or a gate rejected it.
    """
    record = read_record(ParametersRecord, path)
    if record.rejected_because:
        raise UsageError(
            f"this calibration was rejected: {record.rejected_because[0]}", file=path,
            remedy="calibrate again, or change the gate that rejected it",
        )  # fmt: skip
    return record


_SEVERITIES = ("alarm", "warning", "note")


def _with_findings(report: Report, noted: Iterable[FindingRecord]) -> Report:
    """The report with all findings, gravest first, each once; an alarm makes its verdict bad."""
    once = {(f.code, f.where, f.sentence): f for f in (*report.findings, *noted)}
    findings = tuple(sorted(once.values(), key=lambda f: _SEVERITIES.index(f.severity)))
    verdict = report.verdict
    if findings and findings[0].severity == "alarm":
        verdict = verdict.model_copy(update={"level": "bad"})
    return replace(report, findings=findings, verdict=verdict)


def _write(folder: Path, run: RunRecord, outcome: Outcome) -> None:
    """Everything a run leaves, into one folder."""
    report = outcome.report
    if outcome.parameters is not None:
        rejected = run.gates_missed or (() if outcome.usable else (run.verdict.sentence,))
        # under another name: make and scripts must not take it for an accepted calibration
        name = "parameters_rejected.json" if rejected else "parameters.json"
        marked = outcome.parameters.model_copy(update={"rejected_because": rejected})
        write_record(marked, folder / name)
    if outcome.rmse is not None:
        write_record(outcome.rmse, folder / "rmse.json")
        _write_rmse_csv(outcome.rmse, folder / "rmse.csv")
        report = Report(
            report.title,
            report.verdict,
            report.pictures,
            (*report.sheets, rmse_sheet(outcome.rmse)),
            report.findings,
            report.footer,
            report.lead_sheets,
        )
    for name, record in outcome.records.items():
        write_record(record, folder / name)
    for name, write in outcome.files.items():
        write(folder / name)
    images = {picture.name: picture.png() for picture in report.pictures}
    (folder / "figures").mkdir()
    for name, image in images.items():
        (folder / "figures" / f"{name}.png").write_bytes(image)
    recipe_text = json.dumps({**run.recipe, run.command: run.options}, indent=2, ensure_ascii=False)
    (folder / "report.html").write_text(
        render_html(report, run, recipe_text, images), encoding="utf-8"
    )
    files = sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())
    write_record(run.model_copy(update={"files": tuple(files)}), folder / "run.json")


def _write_rmse_csv(rmse: RmseRecord, path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as stream:
        names = ["quantity", "unit", "stage", "reference", "split", "rmse", "n"]
        writer = csv.DictWriter(stream, names)
        writer.writeheader()
        writer.writerows(row.model_dump() for row in rmse.rows)


def _shown(path: Path) -> str:
    """A path as people know it: relative to the working folder where it lies below it."""
    resolved = path.resolve()
    here = Path.cwd()
    return resolved.relative_to(here).as_posix() if resolved.is_relative_to(here) else str(path)


def _shown_or_none(path: Path | None) -> str | None:
    return None if path is None else _shown(path)
