"""LOG arguments of ``diagnose`` that are several experiments: folders, or ``KIND=PATH``."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from footcal_cli.core.log import EXPERIMENT_NAMES
from footcal_cli.errors import UsageError
from footcal_cli.session.request import REJECTED

_OF_COMMAND = {
    "static-init": "stand", "online-replay": "walk", "hang-calib": "hang", "pose-calib": "pose",
}  # fmt: skip
_LOGS = (".parquet", ".csv", ".csv.gz", ".tsv", ".txt", ".mcap", ".c3d", ".h5", ".mat")


@dataclass(frozen=True)
class Group:
    """The logs of one experiment.

    Parameters
    ----------
    name
        What the report calls it: the folder, or the kind.
    logs
        Its files.
    parameters
        The calibration that a command fitted to them, rejected or not; None without one.
    whole_folder
        Whether `logs` are all files of a folder, some of which may be of another kind.
    """

    name: str
    kind: str
    logs: tuple[Path, ...]
    parameters: Path | None = None
    whole_folder: bool = False


def groups_of(arguments: Sequence[Path]) -> tuple[Group, ...]:
    """The experiments that LOG arguments name; empty where they are the files of a single one.

    Raises
    ------
    UsageError
        A folder without logs or without a kind, or files beside folders.
    """
    named = [_split(path) for path in arguments]
    if not any(kind or path.is_dir() for kind, path in named):
        return ()
    groups: list[Group] = []
    files: dict[str, list[Path]] = {}
    for kind, path in named:
        if path.is_dir():
            groups.append(_of_folder(path, kind))
        elif kind:
            files.setdefault(kind, []).append(path)
        else:
            raise UsageError(
                "a file among several experiments has no kind", file=path,
                remedy=f"write KIND=FILE, KIND one of {', '.join(EXPERIMENT_NAMES)}",
            )  # fmt: skip
    groups += [Group(kind, kind, tuple(paths)) for kind, paths in files.items()]
    return _named_apart(groups)


def _split(argument: Path) -> tuple[str, Path]:
    """``KIND=PATH``, or a path that names no kind."""
    head, given, rest = str(argument).partition("=")
    if given and head in EXPERIMENT_NAMES and not argument.exists():
        return head, Path(rest)
    return "", argument


def _of_folder(folder: Path, kind: str) -> Group:
    run = _read(folder / "run.json")
    command = str(run.get("command", ""))
    if command and command not in ("simulate", "convert"):
        inputs = run.get("inputs")
        paths = [Path(name) for name in inputs] if isinstance(inputs, dict) else []
        logs = tuple(path for path in paths if _is_log(path) and path.is_file())
        found = kind or _kind_of_run(command, run)
    else:
        logs = tuple(p for p in sorted(folder.iterdir()) if _is_log(p))
        found = kind or str(_read(folder / "truth.json").get("experiment", ""))
    found = found or _kind_of_name(folder.resolve().name)
    if not found:
        raise UsageError(
            "nothing says which experiment this folder holds", file=folder,
            remedy=f"write KIND={folder.as_posix()}, KIND one of {', '.join(EXPERIMENT_NAMES)}",
        )  # fmt: skip
    if not logs:
        raise UsageError(
            "no log in this folder" if not command else f"the logs of this {command} are not there",
            file=folder, remedy="name the log files: KIND=FILE",
        )  # fmt: skip
    name = folder.resolve().name
    fitted = command not in ("", "simulate", "convert", "diagnose")
    asked = [folder / file for file in ("parameters.json", REJECTED) if fitted]
    parameters = next((path for path in asked if path.is_file()), None)
    return Group(name, found, logs, parameters, whole_folder=True)


def _kind_of_run(command: str, run: dict[str, object]) -> str:
    options = run.get("options")
    if command == "diagnose" and isinstance(options, dict):
        return str(options.get("experiment", ""))
    return _OF_COMMAND.get(command, "")


def _kind_of_name(name: str) -> str:
    words = set(re.split(r"[^a-z]+", name.lower()))
    found = [k for k in EXPERIMENT_NAMES if words & {k, f"{k}s", k.removesuffix("s")}]
    return found[0] if len(found) == 1 else ""


def _is_log(path: Path) -> bool:
    return path.name.lower().endswith(_LOGS)


def _read(path: Path) -> dict[str, object]:
    try:
        found = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _named_apart(groups: Sequence[Group]) -> tuple[Group, ...]:
    """Names that occur twice get numbers."""
    names = [group.name for group in groups]
    apart = []
    for i, group in enumerate(groups):
        number = names[: i + 1].count(group.name)
        name = group.name if names.count(group.name) == 1 else f"{group.name} {number}"
        apart.append(Group(name, group.kind, group.logs, group.parameters, group.whole_folder))
    return tuple(apart)
