"""What the command line asked, and the calibrations that it names."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from footcal_cli.errors import UsageError
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord


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
