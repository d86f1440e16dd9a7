"""The logs of a run: which there are, what kind each is, what was read and what it showed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from footcal_cli.core.quality import Finding
from footcal_cli.errors import DataError, FootcalError, UsageError
from footcal_cli.recipe import Recipe
from footcal_cli.records.results import ParametersRecord, ReadColumnRecord
from footcal_cli.session.calibrated import unless_calibrated
from footcal_cli.session.inspection import inspect, over_pieces
from footcal_cli.session.request import Request
from footcal_cli.session.saturated import FITS, without_saturated
from footcal_cli.session.spells import without_spells
from footcal_cli.session.unfound import refuse_unfound
from footcal_cli.session.unloaded import over_logs
from footcal_cli.tables.columns import TableType
from footcal_cli.tables.copies import without_copies
from footcal_cli.tables.longfiles import is_long
from footcal_cli.tables.table import ReadColumn, Table, read_pieces, read_table, refusal_of
from footcal_cli.tables.textfiles import regular_file, shown

_ROW_BY_ROW = frozenset({"weights", "placements"})
"""Kinds of log in which each row is a reading of its own: no clock shows a repeated one."""


class SessionLogs:
    """The logs that a run was given, read when they are asked for.

    Parameters
    ----------
    recipe
        How logs are read; empty where none was given.
    parameters
        The calibration to start from.
    """

    def __init__(self, request: Request, recipe: Recipe) -> None:
        self.recipe = recipe
        self.parameters: ParametersRecord | None = None
        self.inputs: dict[str, str] = {}
        self.rows: dict[str, int] = {}
        self.read_as: dict[str, dict[str, ReadColumnRecord]] = {}
        self.begin_with(request)

    def begin_with(self, request: Request) -> None:
        """Take the logs of a request, none of them read yet."""
        self.request = request
        self._taken: set[Path] = set()
        self._left_aside: dict[Path, FootcalError] = {}
        self._noted: list[Finding] = []
        self._read_before: dict[str, dict[str, list[Table]]] = {}

    def every_path(self) -> list[Path]:
        """All logs: the LOG arguments where given, else those of every role in ``[data]``.

        Not the truth of a simulated log, which is the answer and no recording, nor the zeros of
        cells that carry nothing, in which no weight is to be looked for.
        """
        measured = (role for role in self.recipe.data if role not in ("truth", "zeros"))
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
        self._noted = over_logs(self._noted, tables, table, self.recipe.robot)
        if any("load_n" in read and read.number("load_n").any() for read in tables):
            # a log of the empty cell, next to others under weights
            self._noted = [finding for finding in self._noted if finding.code != "no_load"]
        return [*tables] if copies else self._once(tables, table.name, role)

    def holds(self, table: TableType, role: str) -> bool:
        """Whether every log of a role has the columns of a table."""
        return all(
            refusal_of(path, table, self.recipe.reading(path)) is None
            for path in self.paths(role)
            if path.is_file()
        )

    def _read(self, path: Path, table: TableType) -> Table:
        """One log, with all that it says."""
        self._taken.add(path)
        robot = self.recipe.robot
        refuse_unfound(self.recipe, table, path, self.every_path())
        read = read_table(path, table, self.recipe.reading(path), gravity_mps2=robot.gravity_mps2)
        self._keep(read)
        self.note(unless_calibrated(inspect(read, table, robot), self.parameters))
        return self._usable(read, table)

    def read_beside(self, table: TableType, role: str) -> list[Table]:
        """Logs of a role in ``[data]``, whatever logs are named on the command line."""
        return [self._read(path, table) for path in self.recipe.data_paths(role)]

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
        self._noted = over_logs(self._noted, tables, table, self.recipe.robot)
        kept, findings = without_copies(tables, within=table.name in _ROW_BY_ROW)
        self.note(findings)
        return [log for log in kept if log is not None]

    def _once(self, tables: list[Table], kind: str, role: str) -> list[Table | None]:
        """Logs of one kind without what they, or another role's logs, hold already."""
        before = self._read_before.setdefault(kind, {})
        others = [table for other, logs in before.items() if other != role for table in logs]
        kept, findings = without_copies(tables, others, within=kind in _ROW_BY_ROW)
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

    def lacks(self, problem: str, remedy: str) -> UsageError:
        """What no log says is missing; without a recipe, what the LOG looks like leads to one."""
        recipe, logs = self.recipe.path, self.request.logs
        foreign = recipe is None and bool(logs)
        file = logs[0] if foreign else recipe
        return UsageError(problem, file=file, remedy=remedy, foreign=foreign)

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
        refuse_unfound(self.recipe, table, path, self.every_path())
        rows, said = 0, []
        for piece in read_pieces(path, table, reading, gravity_mps2=robot.gravity_mps2):
            self._keep(piece, rows)
            said.append(unless_calibrated(inspect(piece, table, robot), self.parameters))
            rows += len(piece)
            yield piece
        self.note(over_pieces(said))

    def _usable(self, read: Table, table: TableType) -> Table:
        """What a fit may use of a log: nothing saturated or lost; other commands take all."""
        if self.request.command not in FITS:
            return read
        kept, findings = without_saturated(read, self.recipe.robot)
        self.note(findings)
        if table.name == "hang":
            kept, findings = without_spells(kept)
            self.note(findings)
        return kept

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

    def note(self, findings: Iterable[Finding]) -> None:
        """Keep findings for the report, whoever made them; `finish` merges them with its own."""
        self._noted += findings

    @property
    def noted(self) -> tuple[Finding, ...]:
        """Findings kept so far."""
        return tuple(self._noted)


Span = tuple[float, float] | None


def record_of(column: ReadColumn, earlier: ReadColumnRecord | None) -> ReadColumnRecord:
    """The record of a column; `earlier` is that of an earlier piece of the same log."""
    written, read = column.as_written, column.as_read
    if earlier is not None:
        written, read = _both(written, earlier.as_written), _both(read, earlier.as_read)
    return ReadColumnRecord(
        name=column.name,
        source=column.source,
        unit=column.unit,
        canonical_unit=column.canonical_unit,
        as_written=written,
        as_read=read,
    )


def in_units_of_readings(
    record: ParametersRecord, read_as: Mapping[str, Mapping[str, ReadColumnRecord]]
) -> ParametersRecord:
    """The calibration with the units that its readings were in: N per volt for a voltage."""
    units = {
        name.removesuffix("counts").removesuffix("_"): column.canonical_unit
        for columns in read_as.values()
        for name, column in columns.items()
        if name.endswith("counts") and column.canonical_unit not in ("", "count")
    }
    if not units:
        return record
    changed = {}
    for name, parameter in record.parameters.items():
        unit = units.get(name.rpartition(".")[0], units.get(""))
        if unit is not None and "count" in parameter.unit:
            parameter = parameter.model_copy(update={"unit": parameter.unit.replace("count", unit)})
        changed[name] = parameter
    return record.model_copy(update={"parameters": changed})


def _both(one: Span, other: Span) -> Span:
    if one is None or other is None:
        return one or other
    return min(one[0], other[0]), max(one[1], other[1])
