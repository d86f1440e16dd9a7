"""What the command line asked, and the calibrations that it names."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from footcal_cli.core.plausibility import check_scale
from footcal_cli.core.quality import Finding
from footcal_cli.errors import UsageError
from footcal_cli.recipe import Robot
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord

REJECTED = "parameters_rejected.json"
"""Name of a calibration that was not accepted: make and scripts must not take it for one."""
_SAME_GRAVITY = 0.006
"""Largest share by which gravity differs between places on Earth."""
_CONVENTIONS = (
    "force = scale * counts + bias", "reading = applied + offset",
    "reading = applied wrench + offset", "applied wrench = (1 + scale) * reading - offset",
)  # fmt: skip
"""How every sign convention that footcal writes begins."""
_UNNAMED = Robot().name


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


def read_calibration(path: Path, *, rejected: bool = False) -> ParametersRecord:
    """Read a calibration that may be used.

    Parameters
    ----------
    path
        Its file.
    rejected
        Whether a rejected one may be used too: of a command that asks what is wrong with it.

    Raises
    ------
    UsageError
        It cannot be read, or it was rejected.
    """
    beside = path.with_name(REJECTED)
    if not path.exists() and beside.is_file():
        raise _refused(beside, read_record(ParametersRecord, beside))
    record = read_record(ParametersRecord, path)
    if record.rejected_because and not rejected:
        raise _refused(path, record)
    return record


def _refused(path: Path, record: ParametersRecord) -> UsageError:
    why = record.rejected_because[0].rstrip(".") if record.rejected_because else "no reason given"
    return UsageError(
        f"this calibration was rejected: {why}", file=path,
        remedy="calibrate again, change the gate that rejected it, or ask what is wrong: footcal "
        f"diagnose --parameters {path.as_posix()}",
    )  # fmt: skip


def inspect_record(record: ParametersRecord, robot: Robot, path: str) -> Iterator[Finding]:
    """What a calibration to start from states against the recipe, and why it was rejected."""
    if record.rejected_because:
        yield Finding(
            "calibration_rejected", "warning", path,
            f"this calibration was rejected: {record.rejected_because[0].rstrip('.')}",
            "correct what the diagnosis names, then calibrate again",
        )  # fmt: skip
    if _UNNAMED not in (record.robot, robot.name) and record.robot != robot.name:
        yield Finding(
            "calibration_of_another_robot", "warning", path,
            f"the calibration is of '{record.robot}', the recipe of '{robot.name}'",
            "give the calibration of this robot, or correct name in [robot]",
        )  # fmt: skip
    off = record.gravity_mps2 / robot.gravity_mps2 - 1.0
    if abs(off) > 1e-6:
        yield Finding(
            "gravity_differs", "alarm" if abs(off) > _SAME_GRAVITY else "note", path,
            f"the calibration was made with g = {record.gravity_mps2:g} m/s², the recipe says "
            f"{robot.gravity_mps2:g} m/s²",
            "correct gravity_mps2 in [robot]"
            + (", or calibrate again" if abs(off) > _SAME_GRAVITY else "")
            + "; it differs by up to 0.5 % between places",
        )  # fmt: skip
    if not record.sign_convention.startswith(_CONVENTIONS):
        yield Finding(
            "unknown_sign_convention", "warning", path,
            f"the calibration means its values so: '{record.sign_convention[:80]}'; this "
            f"program takes {' or '.join(_CONVENTIONS)}",
            "convert it to this convention",
        )  # fmt: skip
    plate = robot.nameplate.scale_n_per_count
    for cell in robot.cell_names:
        if f"{cell}.scale" in record.parameters:
            yield from check_scale(cell, record.parameters[f"{cell}.scale"].value, plate)
