"""Which sessions there are: from globs, or from a table of sessions."""

from __future__ import annotations

import glob
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from footcal_cli.errors import UsageError, nearest
from footcal_cli.tables.logfiles import column_names, raw_columns
from footcal_cli.tables.rawcolumn import RawColumn

if TYPE_CHECKING:
    from footcal_cli.records.batch import SessionRecord

LOG_ENDINGS = (".parquet", ".csv", ".csv.gz")
TABLE_COLUMNS = ("session", "robot", "date", "operator", "logs", "recipe", "parameters")
_DATE = re.compile(r"(20\d\d)-?([01]\d)-?([0-3]\d)(?:[T_ -]?([0-2]\d)[:h-]?([0-5]\d))?")
_UNSAFE = re.compile(r"[^\w.+-]+")


@dataclass(frozen=True)
class Job:
    """One session to run.

    Parameters
    ----------
    name
        Of the session and of its run folder.
    robot, date, operator
        Who was measured, when (ISO 8601) and by whom; empty or None where it is not said.
    logs
        In the order in which the command takes them; empty: those of the recipe.
    recipe, parameters
        Files, None where the session has none.
    command, seed
        What is run.
    again
        Run even if the same session is done.
    pictures
        Whether the sessions' own reports have figures.
    """

    name: str
    robot: str
    date: str | None
    operator: str
    logs: tuple[Path, ...]
    recipe: Path | None
    parameters: Path | None
    command: str
    seed: int
    out: Path
    again: bool
    pictures: bool = True

    @property
    def folder(self) -> Path:
        """Its run folder."""
        return self.out / "sessions" / self.name

    @property
    def record(self) -> Path:
        """Where its row is kept."""
        return self.out / "rows" / f"{self.name}.json"

    def anywhere(self) -> Job:
        """The same job with whole paths."""

        def whole(path: Path | None) -> Path | None:
            return None if path is None else path.absolute()

        return replace(
            self, logs=tuple(p.absolute() for p in self.logs), recipe=whole(self.recipe),
            parameters=whole(self.parameters),
        )  # fmt: skip


Work = Callable[[Job], "SessionRecord"]
Died = Callable[[Job, int], "SessionRecord"]
"""The row of a session over which so many workers died."""


def plan(given: Sequence[str], common: Job) -> list[Job]:
    """The sessions that globs and tables name; `common` holds what they do not say themselves.

    A folder that a glob matches is one session with all logs in it, a file is one of one log. A
    table has the columns `TABLE_COLUMNS`, all but ``logs`` optional.

    Raises
    ------
    UsageError
        Nothing matches, a table has an unknown column, or two sessions have one name.
    """
    jobs: list[Job] = []
    for text in given:
        path = Path(text)
        if path.suffix == ".toml" or (path.is_file() and _is_table(path)):
            jobs += _from_table(path, common)
        else:
            jobs += _from_glob(text, common)
    seen: dict[str, Job] = {}
    for job in jobs:
        if job.name in seen:
            raise UsageError(
                f"two sessions are called '{job.name}'", value=", ".join(map(str, job.logs)),
                remedy="name them in a table with a column 'session'",
            )  # fmt: skip
        seen[job.name] = job
    return jobs


def _is_table(path: Path) -> bool:
    """Whether a CSV or Parquet file lists sessions: it has a column ``logs``."""
    return path.name.endswith(LOG_ENDINGS) and "logs" in column_names(path)


def _from_glob(pattern: str, common: Job) -> list[Job]:
    found = [Path(name) for name in sorted(glob.glob(pattern, recursive=True))]
    jobs = []
    for path in found:
        if path.is_dir():
            logs = tuple(sorted(p for p in path.iterdir() if p.name.endswith(LOG_ENDINGS)))
            name = path.name
        else:
            logs = (path,) if path.name.endswith(LOG_ENDINGS) else ()
            name = path.name.split(".")[0]
        if logs:
            jobs.append(replace(common, name=_safe(name), logs=logs, date=_date_in(str(path))))
    if not jobs:
        raise UsageError(
            f"'{pattern}' matches no log and no folder with logs",
            remedy="quote the pattern, or give a table with the columns session, date, logs",
        )
    return _distinctly_named(jobs)


def _distinctly_named(jobs: list[Job]) -> list[Job]:
    """Sessions of one name get the name of the folder above in front."""
    names = [job.name for job in jobs]
    return [
        replace(job, name=_safe(f"{_above(job)}-{job.name}")) if names.count(job.name) > 1 else job
        for job in jobs
    ]


def _above(job: Job) -> str:
    parent = job.logs[0].parent
    return parent.parent.name if parent.name == job.name else parent.name


def _from_table(path: Path, common: Job) -> list[Job]:
    header, rows = _rows_of_toml(path) if path.suffix == ".toml" else _rows_of_file(path)
    for name in header:
        if name not in TABLE_COLUMNS:
            raise UsageError(
                f"a table of sessions has no column '{name}'{nearest(name, TABLE_COLUMNS)}",
                file=path, column=name, remedy=f"known are {', '.join(TABLE_COLUMNS)}",
            )  # fmt: skip
    if not rows:
        raise UsageError("no sessions in the table", file=path, remedy="add a row per session")
    jobs = []
    for number, row in enumerate(rows):
        logs = row.get("logs", ())
        names = [t.strip() for t in logs.split(";")] if isinstance(logs, str) else list(logs)
        paths = tuple(path.parent / name for name in names if name)
        own = str(row.get("session") or "") or (
            paths[0].name.split(".")[0] if paths else f"session_{number + 1:04d}"
        )
        jobs.append(
            replace(
                common,
                name=_safe(own),
                robot=str(row.get("robot") or common.robot),
                date=_date_of(row.get("date"), path, number) or _date_in(own),
                operator=str(row.get("operator") or ""),
                logs=paths,
                recipe=_beside(path, row.get("recipe")) or common.recipe,
                parameters=_beside(path, row.get("parameters")) or common.parameters,
            )
        )
    return jobs


def _beside(table: Path, name: object) -> Path | None:
    return table.parent / str(name) if name else None


def _rows_of_file(path: Path) -> tuple[list[str], list[Mapping[str, Any]]]:
    """Rows of a CSV or Parquet file, every cell as it is written."""
    header = column_names(path)
    columns = {n: _words(c) for n, c in raw_columns(path, header, set(header)).items()}
    count = len(next(iter(columns.values()), []))
    return header, [{name: words[i] for name, words in columns.items()} for i in range(count)]


def _words(column: RawColumn) -> list[str]:
    """Cells as text; stamps as ISO 8601, empty ones as nothing."""
    words = []
    for value, empty in zip(column.values, column.empty, strict=True):
        if empty:
            words.append("")
        elif column.kind == "stamp":
            words.append(datetime.fromtimestamp(int(value) / 1e9, UTC).isoformat())
        else:
            words.append(str(value).strip())
    return words


def _rows_of_toml(path: Path) -> tuple[list[str], list[Mapping[str, Any]]]:
    """``[[session]]`` tables of a TOML file."""
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise UsageError("no such table", file=path, remedy="check the path") from None
    except ValueError as error:
        raise UsageError(f"not valid TOML: {error}", file=path, remedy="correct the line") from None
    rows = content.get("session")
    if set(content) != {"session"} or not isinstance(rows, list):
        raise UsageError(
            "a table of sessions in TOML holds [[session]] tables and nothing else", file=path,
            remedy='[[session]] logs = ["cells.parquet", "body.parquet"] date = 2026-05-04',
        )  # fmt: skip
    return list(dict.fromkeys(name for row in rows for name in row)), rows


def _safe(name: str) -> str:
    """A name that can be a folder's."""
    return _UNSAFE.sub("_", name).strip("._") or "session"


def _date_of(value: object, path: Path, row: int) -> str | None:
    """A date as ISO 8601."""
    if value is None or value == "":
        return None
    if isinstance(value, (datetime, date)):
        return value.isoformat()
    try:
        text = str(value).strip()
        stamp = datetime.fromisoformat(text)
        return stamp.date().isoformat() if len(text) <= len("2026-05-04") else stamp.isoformat()
    except ValueError:
        raise UsageError(
            "not a date", file=path, column="date", row=f"session {row + 1}", value=value,
            remedy="write it as 2026-05-04 or 2026-05-04T09:30",
        ) from None  # fmt: skip


def _date_in(text: str) -> str | None:
    """The last date in a name, ISO 8601; None where there is none."""
    for year, month, day, hour, minute in reversed(_DATE.findall(text)):
        try:
            found = datetime(int(year), int(month), int(day), int(hour or 0), int(minute or 0))
        except ValueError:
            continue
        return found.isoformat() if hour else found.date().isoformat()
    return None
