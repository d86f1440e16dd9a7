"""What a command found, ready to be gated, written and shown."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from footcal_cli.records.files import Versioned
from footcal_cli.records.results import ParametersRecord, RmseRecord
from footcal_cli.report import Report


@dataclass(frozen=True)
class Outcome(Report):
    """What a command has to say and what it leaves besides the report, ready to be written.

    Parameters
    ----------
    rmse
        Errors before and after.
    parameters
        The calibration, None for a command that makes none.
    records
        Further records by file name.
    tables
        Further tables by file name (Parquet, or CSV): columns (n,) by name.
    files
        Further files by name -> a function that writes it.
    gates_missed
        Sentences of gates that only this command has and that were not met; any makes the exit
        code 1.
    stage, reference
        Which rows of `rmse` the verdict quotes, and so the gates judge; every reference where None.
    reference_sd
        How well the reference of a quantity is known, in its unit; those not named: exactly.
    diagnosis
        Verdict of ``diagnosis.json``.
    usable
        False: nothing to be trusted came out (exit code 3).
    """

    rmse: RmseRecord | None = None
    parameters: ParametersRecord | None = None
    records: Mapping[str, Versioned] = field(default_factory=dict)
    tables: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    files: Mapping[str, Callable[[Path], object]] = field(default_factory=dict)
    gates_missed: tuple[str, ...] = ()
    stage: str = "after"
    reference: str | None = None
    reference_sd: Mapping[str, float] = field(default_factory=dict)
    diagnosis: str | None = None
    usable: bool = True
