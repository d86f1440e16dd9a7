"""A run: what a command was asked, what it read, and the folder it leaves behind.

The run folder is written under a temporary name and renamed at the end, so that an interrupted run
leaves nothing half-written.
"""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

from rich.console import Console

from footcal_cli.core.quality import Finding
from footcal_cli.errors import DataError, FitError, FootcalError, UsageError
from footcal_cli.recipe import CommandOptions, Recipe, read_recipe, validated
from footcal_cli.records.files import read_record
from footcal_cli.records.results import FindingRecord, ParametersRecord, ReadColumnRecord, RunRecord
from footcal_cli.report import Drawn, Report, history_sheet, read_aloud, read_as_sheet
from footcal_cli.report.outcome import Outcome
from footcal_cli.report.text import print_text
from footcal_cli.session.gates import gated, merged
from footcal_cli.session.inspection import inspect, inspect_record, over_pieces
from footcal_cli.session.progress import Advance, bar
from footcal_cli.session.read_as import in_units_of_readings, record_of
from footcal_cli.session.run_files import write_run
from footcal_cli.session.run_folder import (
    claim,
    claims,
    grown_folder,
    refuse_folder,
    refuse_grown,
    whole_folder,
)
from footcal_cli.session.trust import DOUBTFUL, trusted
from footcal_cli.tables.columns import TableType
from footcal_cli.tables.copies import without_copies
from footcal_cli.tables.longfiles import is_long
from footcal_cli.tables.table import (
    Table,
    digest,
    read_pieces,
    read_table,
    refusal_of,
    refuse_wrong_units,
)
from footcal_cli.tables.textfiles import regular_file, shown

if TYPE_CHECKING:
    from footcal_cli.core.effects.contract import Effect

__all__ = ["Outcome", "Request", "Session", "read_calibration"]

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
    reference: Path | None = None
    goes_on: bool = False
    """Whether the folder is gone on with: what is done stays."""

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Files that the command line names as inputs."""
        named = [self.recipe, self.parameters, self.reference, *self.overrides.values()]
        return (*self.logs, *(path for path in named if isinstance(path, Path)))

    @property
    def command_line(self) -> str:
        """The command that asks the same."""
        words = ["footcal", self.command, *(path.as_posix() for path in self.logs)]
        for option, path in (("--recipe", self.recipe), ("--parameters", self.parameters)):
            words += [] if path is None else [option, path.as_posix()]
        for name, value in self.overrides.items():
            option = f"--{name.replace('_', '-')}"
            if value is False:
                words.append(f"--no-{name}")
            elif value is True:
                words.append(option)
            elif isinstance(value, tuple):
                words += [part for item in value for part in (option, str(item))]
            elif value is not None:
                words += [option, str(value)]
        return shlex.join([*words, "--seed", str(self.seed), "--out", self.out.as_posix()])


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
        refuse = refuse_grown if request.goes_on else refuse_folder
        refuse(request.out, request.overwrite, request.inputs)
        self.recipe = (
            read_recipe(request.recipe, commands) if request.recipe is not None else Recipe()
        )
        refuse_wrong_units(
            self.recipe.every_place(), self.recipe.robot.gravity_mps2, request.recipe
        )
        table = request.command.replace("-", "_")
        given = {k: v for k, v in request.overrides.items() if v is not None}
        own = self.recipe.options.get(table, {})
        gates = merged(self.recipe.gates, own.get("gates", {}))
        if request.reference is not None:
            gates["reference"] = str(request.reference)
        self.options: Options = validated(
            options_model,
            {**own, **given, **({"gates": gates} if gates else {})},
            file=request.recipe,
            table=table,
        )
        refuse(request.out, request.overwrite, self.input_paths())
        claim(request.out)
        if (stack := claims.get()) is not None:
            stack.push(self._suspect)
        self.parameters: ParametersRecord | None = None
        self.inputs: dict[str, str] = {}
        self.rows: dict[str, int] = {}
        self.timings_s: dict[str, float] = {}
        self._taken: set[Path] = set()
        self._left_aside: dict[Path, FootcalError] = {}
        self._noted: list[Finding] = []
        self.read_as: dict[str, dict[str, ReadColumnRecord]] = {}
        self._read_before: dict[str, dict[str, list[Table]]] = {}
        if request.parameters is not None:
            self.parameters = read_calibration(request.parameters)
            self.inputs[shown(request.parameters)] = digest(request.parameters)
            name = request.parameters.name
            self.note(inspect_record(self.parameters, self.recipe.robot, name))
        path = self._reference_path()
        self.reference = None if path is None else read_calibration(path)
        if path is not None:
            self.inputs[shown(path)] = digest(path)

    def part(
        self, logs: Sequence[Path], parameters: Path | None = None, **options: object
    ) -> Session[Options]:
        """The same run with other logs, some other options, and another calibration if given.

        What it reads counts as read by this run; its findings are its own.
        """
        other = copy(self)
        other.request = replace(self.request, logs=tuple(logs))
        other.options = self.options.model_copy(update=options)
        other._taken, other._left_aside = set(), {}
        other._noted, other._read_before = [], {}
        if parameters is not None:
            other.parameters = read_calibration(parameters)
            self.inputs[shown(parameters)] = digest(parameters)
        return other

    def refuse_unread(self) -> None:
        """Refuse a run with a LOG that was none of the kinds that the command reads.

        Raises
        ------
        DataError
            Why the first such log was not read.
        """
        for path, refusal in self._left_aside.items():
            if path not in self._taken:
                raise refusal

    @cached_property
    def table(self) -> Mapping[str, Effect]:
        """Effects by name: the table, those of installed packages and the recipe's own."""
        from footcal_cli.records.effects import table_with

        return table_with(self.recipe.effect, self.recipe.path)

    def _reference_path(self) -> Path | None:
        """The calibration that gates compare with; the recipe's lies relative to the recipe."""
        named = self.options.gates.reference
        if self.request.reference is not None or named is None:
            return self.request.reference
        folder = self.recipe.path.parent if self.recipe.path is not None else Path()
        return folder / named

    def input_paths(self) -> tuple[Path, ...]:
        """Every file that this run may read: of the command line, of ``[data]``, of the options."""
        data = [path for role in self.recipe.data for path in self.recipe.data_paths(role)]
        folder = self.recipe.path.parent if self.recipe.path is not None else Path()
        options = [
            folder / str(value)
            for value in self.options.model_dump().values()
            if isinstance(value, (str, Path)) and (folder / str(value)).is_file()
        ]
        if (reference := self._reference_path()) is not None:
            options.append(reference)
        return (*self.request.inputs, *([] if self.request.logs else data), *options)

    def every_path(self) -> list[Path]:
        """All logs: the LOG arguments where given, else those of every role in ``[data]``.

        Not the truth of a simulated log, which is the answer and no recording.
        """
        measured = (role for role in self.recipe.data if role != "truth")
        roles = (path for role in measured for path in self.recipe.data_paths(role))
        return list(self.request.logs) or list(dict.fromkeys(roles))

    def paths(self, role: str) -> list[Path]:
        """Logs of a role: the LOG arguments where given, else the recipe's ``[data]``."""
        return list(self.request.logs) or self.recipe.data_paths(role)

    def read(self, table: TableType, role: str | None = None) -> list[Table]:
        """Read all logs of a role that have the table's columns.

        A LOG argument of another kind is left to the command's other table types; with ``[data]``
        the role says which log is which. What another log of the kind holds already is taken out,
        with a finding.

        Raises
        ------
        DataError
            From the first log that cannot be read.
        """
        return [log for log in self.read_in_order(table, role) if log is not None]

    def read_in_order(
        self, table: TableType, role: str | None = None, *, copies: bool = False
    ) -> list[Table | None]:
        """As `read`, with None in the place of a log that is a copy of another one.

        With `copies`, copies stay in.
        """
        role = role or table.name
        tables: list[Table] = []
        for path in self.paths(role):
            if self.request.logs and path.is_file():
                refusal = refusal_of(path, table, self.recipe.reading(path))
                if refusal is not None:
                    self._left_aside.setdefault(path, refusal)
                    continue
            tables.append(self._read(path, table))
        return [*tables] if copies else self._once(tables, table.name, role)

    def _read(self, path: Path, table: TableType) -> Table:
        """One log, with all that it says."""
        self._taken.add(path)
        robot = self.recipe.robot
        read = read_table(path, table, self.recipe.reading(path), gravity_mps2=robot.gravity_mps2)
        self._keep(read)
        self.note(inspect(read, table, robot))
        return read

    def read_any(self, table: TableType) -> list[Table]:
        """Read every log that is of a kind, whatever its role; copies once."""
        tables: list[Table] = []
        for path in self.every_path():
            reading = self.recipe.reading(path)
            refusal = refusal_of(path, table, reading) if path.is_file() else None
            if refusal is not None:
                self._left_aside.setdefault(path, refusal)
            else:
                tables.append(self._read(path, table))
        kept, findings = without_copies(tables, [])
        self.note(findings)
        return [log for log in kept if log is not None]

    def _once(self, tables: list[Table], kind: str, role: str) -> list[Table | None]:
        """Logs of one kind without what they, or another role's logs, hold already."""
        before = self._read_before.setdefault(kind, {})
        others = [table for other, logs in before.items() if other != role for table in logs]
        kept, findings = without_copies(tables, others)
        if not self.request.logs:  # else all roles are the same files
            before[role] = tables
        self.note(findings)
        return kept

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
            raise self._no_log(role or table.name)
        self._read(named[0], table)
        raise DataError("no log with the needed columns", file=named[0])

    def refuse_missing_logs(self, role: str) -> None:
        """Refuse a run without a log, or with one that is not there, before heavy imports.

        Raises
        ------
        UsageError
            No log at all was named, or no such file.
        """
        if not self.request.logs and not self.recipe.data:
            raise self._no_log(role)
        for path in self.request.logs:
            regular_file(path)

    def _no_log(self, role: str) -> UsageError:
        return UsageError(
            f"no {role} log given", file=self.recipe.path,
            remedy=f"name a LOG on the command line or '{role}' in [data]",
        )  # fmt: skip

    def only_log(self, table: TableType, role: str | None = None) -> Path | None:
        """The one log of a role that has the table's columns; None where none or several do."""
        paths = self.paths(role or table.name)
        if self.request.logs:
            files = [path for path in paths if path.is_file()]
            refusals = {p: refusal_of(p, table, self.recipe.reading(p)) for p in files}
            paths = [path for path in files if refusals[path] is None]
        return paths[0] if len(paths) == 1 else None

    def pieces(self, table: TableType, role: str | None = None) -> Iterator[Table]:
        """As `read_required`, one log after another; a single long log some rows at a time."""
        path = self.only_log(table, role)
        if path is None or not is_long(path):
            yield from self.read_required(table, role)
            return
        self._taken.add(path)
        reading, robot = self.recipe.reading(path), self.recipe.robot
        rows, said = 0, []
        for piece in read_pieces(path, table, reading, gravity_mps2=robot.gravity_mps2):
            self._keep(piece, rows)
            said.append(inspect(piece, table, robot))
            rows += len(piece)
            yield piece
        self.note(over_pieces(said))

    def _keep(self, read: Table, before: int = 0) -> None:
        """Note what a log was read as, or a piece of one with so many rows before it."""
        name = shown(read.path)
        self.inputs[name] = read.digest
        self.inputs |= {shown(beside): found for beside, found in read.beside.items()}
        self.rows[name] = before + len(read)
        self._read_aloud(read)
        self.note(read.findings)

    def _read_aloud(self, table: Table) -> None:
        """Keep how foreign columns of a log were read, for run.json, report and terminal."""
        known = self.read_as.setdefault(shown(table.path), {}) if table.read_as else {}
        for column in table.read_as:
            known[column.name] = record_of(column, known.get(column.name))

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

    @contextmanager
    def counted(self, name: str, unit: str, total: float | None) -> Iterator[Advance]:
        """As `step`; a terminal shows how much is done, how fast, and the time left."""
        began = time.perf_counter()
        with bar(self.console, name, unit, total) as advance:
            yield advance
        self.timings_s[name] = round(time.perf_counter() - began, 4)

    def progress(self, items: Iterable[Item], description: str, total: int) -> Iterator[Item]:
        """Iterate with a progress bar on a terminal, quietly in a pipe."""
        with bar(self.console, description, "", total) as advance:
            for item in items:
                yield item
                advance(1)

    def note(self, findings: Iterable[Finding]) -> None:
        """Keep findings for the report, whoever made them; `finish` merges them with its own."""
        self._noted += findings

    @property
    def noted(self) -> tuple[Finding, ...]:
        """Findings kept so far."""
        return tuple(self._noted)

    def _suspect(self, _kind: object, error: BaseException | None, _trace: object) -> bool:
        """Where nothing usable came out of a log, say what is wrong with it as far as was seen."""
        alarm = next((f for f in self._noted if f.severity == "alarm"), None)
        if isinstance(error, DataError | FitError) and alarm is not None:
            error.suspicion = f"{alarm.where}: {alarm.sentence}. Remedy: {alarm.remedy}"
        return False

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
        self.refuse_unread()
        outcome = replace(
            outcome, report=_with_findings(outcome.report, map(FindingRecord.of, self._noted))
        )
        if self.read_as:
            report = outcome.report
            sheets = (*report.sheets, read_as_sheet(self.read_as))
            outcome = replace(outcome, report=replace(report, sheets=sheets))
        if outcome.parameters is not None:
            record = in_units_of_readings(outcome.parameters, self.read_as)
            outcome = replace(outcome, parameters=record)
        outcome = gated(trusted(outcome), self.options, self.recipe.gates, self.reference)
        images: dict[str, Drawn] = {}
        with self.step("draw"):
            if self.options.pictures:
                images = {picture.name: picture.drawn() for picture in outcome.report.pictures}
            else:
                outcome = replace(outcome, report=replace(outcome.report, pictures=()))
        exit_code = 3 if not outcome.usable else 1 if outcome.gates_missed else 0
        run = RunRecord(
            command=self.request.command,
            started=self.created(),
            arguments={
                "logs": [shown(path) for path in self.request.logs],
                "recipe": _shown_or_none(self.request.recipe),
                "parameters": _shown_or_none(self.request.parameters),
            },
            recipe=self.recipe.model_dump(mode="json", exclude={"options", "path"}),
            options=self.options.model_dump(mode="json"),
            inputs=self.inputs,
            rows=self.rows,
            read_as={path: tuple(columns.values()) for path, columns in self.read_as.items()},
            seed=self.request.seed,
            timings_s=self.timings_s,
            verdict=outcome.report.verdict,
            findings=outcome.report.findings,
            gates_missed=outcome.gates_missed,
            exit_code=exit_code,
        )
        out = self.request.out
        with (
            grown_folder(out)
            if self.request.goes_on
            else whole_folder(out, self.request.overwrite, self.input_paths())
        ) as folder:
            write_run(folder, run, self._with_history(outcome), images)
        answer = Console(quiet=self.request.quiet, highlight=False)
        if not answer.is_terminal:
            answer = Console(quiet=self.request.quiet, highlight=False, width=_PIPE_WIDTH)
        print_text(outcome.report, answer)
        for line in read_aloud(self.read_as):
            answer.print(line, soft_wrap=True, markup=False)
        for gate in outcome.gates_missed:
            print(f"GATE NOT MET  {gate}", file=sys.stderr)  # noqa: T201 - the command's answer
        answer.print(f"report: {self.request.out / 'report.html'}", soft_wrap=True)
        return exit_code

    def _with_history(self, outcome: Outcome) -> Outcome:
        """The report with what changed since the calibration that the run started from."""
        report, start = outcome.report, self.request.parameters
        told = any(sheet.title.startswith("Changes since") for sheet in report.lead_sheets)
        if start is None or told:
            return outcome
        sheet = history_sheet(self.parameters, outcome.parameters, shown(start))
        if sheet is None:
            return outcome
        return replace(outcome, report=replace(report, sheets=(*report.sheets, sheet)))


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
    """The report with all findings, gravest first, each once; its verdict no better than they."""
    once = {(f.code, f.where, f.sentence): f for f in (*report.findings, *noted)}
    findings = tuple(sorted(once.values(), key=lambda f: _SEVERITIES.index(f.severity)))
    verdict = report.verdict
    if findings and findings[0].severity == "alarm":
        verdict = verdict.model_copy(update={"level": "bad"})
    elif verdict.level == "good" and any(f.code in DOUBTFUL for f in findings):
        verdict = verdict.model_copy(update={"level": "warning"})
    return replace(report, findings=findings, verdict=verdict)


def _shown_or_none(path: Path | None) -> str | None:
    return None if path is None else shown(path)
