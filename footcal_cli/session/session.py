"""A run: what a command was asked, what it read, and the folder it leaves behind.

The run folder is written under a temporary name and renamed at the end, so that an interrupted run
leaves nothing half-written.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Collection, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import replace
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

from rich.console import Console

from footcal_cli.core.quality import Finding
from footcal_cli.errors import DataError, FitError
from footcal_cli.recipe import CommandOptions, Recipe, read_recipe
from footcal_cli.records.results import ParametersRecord, RunRecord
from footcal_cli.report import Drawn, history_sheet, read_aloud, read_as_sheet
from footcal_cli.report.outcome import Outcome
from footcal_cli.report.text import WIDTH, print_text
from footcal_cli.session.answer import answer_of, as_json, print_answer
from footcal_cli.session.gates import DOUBTFUL, gated, merged, trusted
from footcal_cli.session.logs import SessionLogs, in_units_of_readings
from footcal_cli.session.request import Request, inspect_record, read_calibration
from footcal_cli.session.run_files import write_run
from footcal_cli.session.run_folder import (
    claim,
    claims,
    grown_folder,
    refuse_folder,
    refuse_grown,
    whole_folder,
)
from footcal_cli.tables.table import digest, refuse_wrong_units
from footcal_cli.tables.textfiles import shown

if TYPE_CHECKING:
    from footcal_cli.core.diagnosis.subject import Advance
    from footcal_cli.core.effects.contract import Effect


@contextmanager
def bar(console: Console, step: str, unit: str, total: float | None) -> Iterator[Advance]:
    """Show a step's progress while it runs.

    Parameters
    ----------
    console
        Only a terminal shows anything.
    step, unit
        What is done, and what is counted where `step` does not say it.
    total
        How many there are; None where nobody knows, and then no time left is shown.

    Yields
    ------
    A function to be called with how many more are done
    """
    if not console.is_terminal or console.quiet:
        yield lambda _: None
        return
    from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn
    from rich.progress import TimeRemainingColumn as TimeLeft
    from rich.text import Text

    class Count(ProgressColumn):
        """Done, of how many, and how many per second."""

        def render(self, task: Task) -> Text:
            known = "" if task.total is None else f" of {task.total:,.0f}"
            rate = "" if not task.speed else f", {task.speed:,.3g} per second"
            return Text(" ".join(f"{task.completed:,.0f}{known} {unit}".split()) + rate)

    columns = [TextColumn("{task.description}"), BarColumn(bar_width=30), Count()]
    left = [TextColumn("left"), TimeLeft()] if total is not None else []
    with Progress(*columns, *left, console=console, transient=True) as shown:
        task = shown.add_task(step, total=total)
        yield lambda done: shown.advance(task, done)


_PIPE_WIDTH = 160  # columns of a table that neither a terminal nor COLUMNS limits

Options = TypeVar("Options", bound=CommandOptions)
Item = TypeVar("Item")


class Session(SessionLogs, Generic[Options]):
    """One run of one command: recipe, options, inputs read so far, timings.

    Parameters
    ----------
    options_model
        The command's table in a recipe.
    commands
        Names of all option tables a recipe may hold.
    """

    def __init__(
        self, request: Request, options_model: type[Options], commands: Collection[str]
    ) -> None:
        self.started = datetime.now(UTC)
        self.console = Console(stderr=True, quiet=request.quiet)
        refuse = refuse_grown if request.goes_on else refuse_folder
        refuse(request.out, request.overwrite, request.inputs)
        super().__init__(
            request,
            read_recipe(request.recipe, commands) if request.recipe is not None else Recipe(),
        )
        refuse_wrong_units(
            self.recipe.every_place(), self.recipe.robot.gravity_mps2, request.recipe
        )
        table = request.command.replace("-", "_")
        gates = merged(self.recipe.gates, self.recipe.options.get(table, {}).get("gates", {}))
        if request.reference is not None:
            gates["reference"] = str(request.reference)
        self.options: Options = self.recipe.options_for(
            options_model, table, {**request.overrides, "gates": gates or None}
        )
        refuse(request.out, request.overwrite, self.input_paths())
        claim(request.out)
        if (stack := claims.get()) is not None:
            stack.push(self._suspect)
        self.timings_s: dict[str, float] = {}
        if request.parameters is not None:
            self.parameters = self._calibration(request.parameters)
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
        other.begin_with(replace(self.request, logs=tuple(logs)))
        other.options = self.options.model_copy(update=options)
        if parameters is not None:
            other.parameters = self._calibration(parameters)
            self.inputs[shown(parameters)] = digest(parameters)
        return other

    @cached_property
    def table(self) -> Mapping[str, Effect]:
        """Effects by name: the table, those of installed packages and the recipe's own."""
        from footcal_cli.records.effects import table_with

        return table_with(self.recipe.effect, self.recipe.path)

    def _calibration(self, path: Path) -> ParametersRecord:
        return read_calibration(path, rejected=self.options.takes_rejected)

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

    def progress(self, items: Iterable[Item], description: str, total: int) -> Generator[Item]:
        """Iterate with a progress bar on a terminal, quietly in a pipe."""
        with bar(self.console, description, "", total) as advance:
            for item in items:
                yield item
                advance(1)

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
        outcome = _with_findings(outcome, self._noted)
        if self.read_as:
            outcome = replace(outcome, sheets=(*outcome.sheets, read_as_sheet(self.read_as)))
        if outcome.parameters is not None:
            record = in_units_of_readings(outcome.parameters, self.read_as)
            outcome = replace(outcome, parameters=record)
        outcome = gated(trusted(outcome), self.options, self.recipe.gates, self.reference)
        outcome = _with_next_step(outcome)
        images: dict[str, Drawn] = {}
        with self.step("draw"):
            if self.options.pictures:
                images = {picture.name: picture.drawn() for picture in outcome.pictures}
            else:
                outcome = replace(outcome, pictures=())
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
            verdict=outcome.verdict,
            findings=outcome.findings,
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
        for gate in outcome.gates_missed:
            print(f"GATE NOT MET  {gate}", file=sys.stderr)  # noqa: T201 - the command's answer
        if as_json():
            print_answer(answer_of(run, outcome, out))
            return exit_code
        answer = _Answer(quiet=self.request.quiet, highlight=False)
        if not answer.is_terminal and WIDTH not in os.environ:
            answer = _Answer(quiet=self.request.quiet, highlight=False, width=_PIPE_WIDTH)
        print_text(outcome, answer)
        for line in read_aloud(self.read_as):
            answer.print(line, soft_wrap=True, markup=False)
        answer.print(f"report: {self.request.out / 'report.html'}", soft_wrap=True)
        return exit_code

    def _with_history(self, outcome: Outcome) -> Outcome:
        """The report with what changed since the calibration that the run started from."""
        start = self.request.parameters
        shown_above = any(sheet.title.startswith("Changes since") for sheet in outcome.lead_sheets)
        if start is None or shown_above:
            return outcome
        sheet = history_sheet(self.parameters, outcome.parameters, shown(start))
        if sheet is None:
            return outcome
        return replace(outcome, sheets=(*outcome.sheets, sheet))


class _Answer(Console):
    """What a run says when its results are written: a reader who leaves changes no exit code."""

    def on_broken_pipe(self) -> None:
        """Say the rest to nobody."""
        self.quiet = True
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _with_next_step(outcome: Outcome) -> Outcome:
    """The outcome with what to do with a calibration that is accepted."""
    verdict = outcome.verdict
    refused = outcome.parameters is None or outcome.gates_missed or not outcome.usable
    if refused or verdict.actions or verdict.level == "bad":
        return outcome
    step = "Start the next command from parameters.json, next to this report (--parameters)."
    return replace(outcome, verdict=verdict.model_copy(update={"actions": (step,)}))


_SEVERITIES = ("alarm", "warning", "note")


def _notes_merged(findings: Iterable[Finding]) -> list[Finding]:
    """Findings with one note in place of notes that say the same of several logs."""
    alike: dict[tuple[str, ...], list[Finding]] = {}
    for f in findings:
        own = () if f.severity == "note" else (f.where,)
        alike.setdefault((f.code, f.severity, f.sentence, f.remedy, *own), []).append(f)
    return [
        several[0] if len(several) == 1 else replace(several[0], where=_together(several))
        for several in alike.values()
    ]


def _together(findings: Sequence[Finding]) -> str:
    names = [f.where for f in findings]
    if len(names) <= _MOST_NAMED:
        return ", ".join(names)
    return f"{names[0]} … {names[-1]} ({len(names)})"


_MOST_NAMED = 4


def _with_findings(outcome: Outcome, noted: Iterable[Finding]) -> Outcome:
    """The outcome with all findings, gravest first, each once; its verdict no better than they."""
    once = {(f.code, f.where, f.sentence): f for f in (*outcome.findings, *noted)}
    findings = tuple(
        sorted(_notes_merged(once.values()), key=lambda f: _SEVERITIES.index(f.severity))
    )
    verdict = outcome.verdict
    if findings and findings[0].severity == "alarm":
        verdict = verdict.model_copy(update={"level": "bad"})
    elif verdict.level == "good" and any(f.code in DOUBTFUL for f in findings):
        verdict = verdict.model_copy(update={"level": "warning"})
    return replace(outcome, findings=findings, verdict=verdict)


def _shown_or_none(path: Path | None) -> str | None:
    return None if path is None else shown(path)
