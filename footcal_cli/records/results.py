"""Calibrations, errors, findings and runs as they are written."""

from __future__ import annotations

from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from footcal_cli.core.parameters import Estimates, FloatArray, Status
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import root_mean_square
from footcal_cli.errors import UsageError, nearest
from footcal_cli.records.files import Record, Versioned
from footcal_cli.records.own_effects import OwnEffect

LARGEST = 1e30
"""Larger values and sds overflow when they are squared."""
Split = Literal["all", "train", "held_out"]
_ROUNDING = 1e-6
"""Of correlations."""


class ParameterRecord(Record):
    """One calibrated number."""

    value: float
    sd: float | None = Field(ge=0)
    unit: str
    status: Status


class CovarianceBlock(Record):
    """Joint covariance of parameters, in products of their units."""

    names: tuple[str, ...]
    matrix: tuple[tuple[float, ...], ...]

    @model_validator(mode="after")
    def _is_a_covariance(self) -> Self:
        n = len(self.names)
        if len(set(self.names)) != n:
            raise ValueError("a covariance names a parameter twice")
        if [len(row) for row in self.matrix] != [n] * n:
            raise ValueError(f"a covariance of {n} parameters has {n} rows of {n} numbers")
        matrix = np.array(self.matrix).reshape(n, n)
        sd = np.sqrt(np.maximum(np.diag(matrix), 0.0))
        scaled = matrix / np.outer(np.where(sd > 0, sd, 1.0), np.where(sd > 0, sd, 1.0))
        symmetric = np.allclose(scaled, scaled.T, atol=_ROUNDING)
        if not symmetric or (n and np.linalg.eigvalsh(scaled)[0] < -_ROUNDING):
            raise ValueError("a covariance is symmetric, with no negative variance")
        return self


class Range(Record):
    """Lowest and highest value met in the fitted data."""

    lowest: float
    highest: float
    unit: str

    @classmethod
    def of(cls, values: FloatArray, unit: str) -> Self:
        """Of an array."""
        return cls(lowest=float(values.min()), highest=float(values.max()), unit=unit)


class EffectRecord(Record):
    """An effect that the calibration contains: its name and who shares its values.

    `row` says what it is where it is an effect of the user's own.
    """

    effect: str
    owners: dict[str, tuple[str, ...]]
    row: OwnEffect | None = None


class ParametersRecord(Versioned):
    """``parameters.json``: a calibration.

    `sign_convention`, `frame` and `expressed_at` say how the values are meant; `fitted_range` where
    they hold; `effects` what a chain contains beyond scale, bias and offset; `rejected_because` the
    gates that were not met: such a calibration is written as ``parameters_rejected.json``, and only
    ``diagnose`` starts from it.
    """

    schema_name: Literal["footcal.parameters"] = Field(default="footcal.parameters", alias="schema")
    command: str
    created: str
    robot: str
    gravity_mps2: float = Field(gt=0)
    sign_convention: str
    frame: str
    expressed_at: str
    parameters: dict[str, ParameterRecord]
    covariance: tuple[CovarianceBlock, ...] = ()
    fitted_range: dict[str, dict[str, Range]] = Field(default_factory=dict)
    effects: tuple[EffectRecord, ...] = ()
    inputs: dict[str, str] = Field(default_factory=dict)
    rejected_because: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _makes_sense(self) -> Self:
        for block in self.covariance:
            unknown = sorted(set(block.names) - self.parameters.keys())
            if unknown:
                raise ValueError(f"covariance of '{unknown[0]}', which is no parameter here")
        for name, parameter in self.parameters.items():
            if max(abs(parameter.value), parameter.sd or 0.0) > LARGEST:
                raise ValueError(f"{name} is too large to be a parameter ({parameter.value:g})")
            if name.endswith(".scale") and parameter.value == 0:
                raise ValueError(f"{name} is 0: no reading would tell a force")
        return self

    @property
    def values(self) -> dict[str, float]:
        """Values by name."""
        return {name: parameter.value for name, parameter in self.parameters.items()}

    @property
    def calibrated_cells(self) -> dict[str, tuple[float, float]]:
        """Scale (N/count) and bias (N) of the cells that have both, in the record's order."""
        values = self.values
        owners = [name.removesuffix(".scale") for name in values if name.endswith(".scale")]
        return {
            owner: (values[f"{owner}.scale"], values[f"{owner}.bias"])
            for owner in owners
            if f"{owner}.bias" in values
        }

    def value(self, name: str) -> float:
        """Value of one parameter; an absent name is the caller's usage error."""
        if name not in self.parameters:
            raise UsageError(
                f"the calibration has no parameter '{name}'{nearest(name, self.parameters)}",
                remedy="calibrate that channel first, or correct the channel's name",
            )
        return self.parameters[name].value

    @property
    def estimates(self) -> Estimates:
        """All parameters with their joint covariance."""
        names = tuple(self.parameters)
        return Estimates(
            names=names,
            units=tuple(p.unit for p in self.parameters.values()),
            values=np.array([p.value for p in self.parameters.values()]),
            covariance=self.covariance_of(names),
            status=tuple(Status(p.status) for p in self.parameters.values()),
        )

    def covariance_of(self, names: tuple[str, ...]) -> FloatArray:
        """Joint covariance of some parameters, shape (n, n); zero between separate blocks."""
        place = {name: i for i, name in enumerate(names)}
        matrix = np.zeros((len(names), len(names)))
        for name, i in place.items():
            matrix[i, i] = (self.parameters[name].sd or 0.0) ** 2
        for block in self.covariance:
            inside = [(place[n], k) for k, n in enumerate(block.names) if n in place]
            for i, k in inside:
                for j, m in inside:
                    matrix[i, j] = block.matrix[k][m]
        return matrix


class RmseRow(Record):
    """One error figure.

    `stage` is ``before``, ``after`` or a method's name; `split` is ``all``, ``train`` or
    ``held_out``; `n` the samples behind it.
    """

    quantity: str
    unit: str
    stage: str
    reference: str
    split: Split
    rmse: float
    n: int

    @classmethod
    def of(
        cls, quantity: str, unit: str, stage: str, reference: str, error: FloatArray,
        split: Split = "all",
    ) -> Self:  # fmt: skip
        """Of the finite ones of some errors."""
        return cls(
            quantity=quantity, unit=unit, stage=stage, reference=reference, split=split,
            rmse=root_mean_square(error), n=int(np.isfinite(error).sum()),
        )  # fmt: skip


class RmseRecord(Versioned):
    """``rmse.json``: errors before and after, and how many samples were rejected, by reason."""

    schema_name: Literal["footcal.rmse"] = Field(default="footcal.rmse", alias="schema")
    rows: tuple[RmseRow, ...]
    rejected: dict[str, int] = Field(default_factory=dict)


class VerdictRecord(Record):
    """The first sentence of a report, what to do next, and what it rests on."""

    level: Literal["good", "warning", "bad"]
    sentence: str
    actions: tuple[str, ...] = ()
    details: tuple[str, ...] = ()


def _written(value: float) -> str:
    """Seven digits; counts of eight and more in full, thousands set apart."""
    text = f"{value:.7g}"
    return f"{value:,.0f}" if "e+" in text and abs(value) < 1e15 else text


class ReadColumnRecord(Record):
    """How a column that stands under another name or in another unit was read.

    `unit` is what its numbers were taken for, in full; the ranges are in that unit and in
    `canonical_unit`.
    """

    name: str
    source: str
    unit: str
    canonical_unit: str
    as_written: tuple[float, float] | None
    as_read: tuple[float, float] | None

    @property
    def sentence(self) -> str:
        """In one line: ``'weight_g' read as gram: 0 … 3000 = 0 … 29.41995 N (load_n)``."""
        said = f"'{self.source}' read as {self.unit or 'a bare number'}"
        shown = " = ".join(f"{_written(low)} … {_written(high)}" for low, high in self.ranges)
        return f"{said}: {shown} {self.canonical_unit}".rstrip(": ") + f" ({self.name})"

    @property
    def ranges(self) -> list[tuple[float, float]]:
        """Smallest and largest value as written and, where that is another, as read."""
        both = [pair for pair in (self.as_written, self.as_read) if pair is not None]
        return both[:1] if len(both) == 2 and both[0] == both[1] else both


class RunRecord(Versioned):
    """``run.json``: what was run, on what, how it ended, and every file of the folder.

    `read_as` holds the columns that stand under other names or in other units in the logs.
    """

    schema_name: Literal["footcal.run"] = Field(default="footcal.run", alias="schema")
    command: str
    started: str
    arguments: dict[str, Any]
    recipe: dict[str, Any]
    options: dict[str, Any]
    inputs: dict[str, str]
    rows: dict[str, int]
    read_as: dict[str, tuple[ReadColumnRecord, ...]] = Field(default_factory=dict)
    seed: int
    timings_s: dict[str, float]
    verdict: VerdictRecord
    findings: tuple[Finding, ...] = ()
    gates_missed: tuple[str, ...] = ()
    exit_code: int
    files: tuple[str, ...] = ()


class AnswerRecord(Versioned):
    """What a command prints with ``--json``: how it ended and where everything lies.

    Paths are relative to the working folder where they lie below it. `parameters` is that of an
    accepted calibration only, `error` the one line of a command that could not run, `recipe` and
    `next_step` those of ``init``.
    """

    schema_name: Literal["footcal.answer"] = Field(default="footcal.answer", alias="schema")
    command: str
    exit_code: int
    verdict: VerdictRecord | None = None
    diagnosis: str | None = None
    error: str | None = None
    findings: tuple[Finding, ...] = ()
    gates_missed: tuple[str, ...] = ()
    rmse: tuple[RmseRow, ...] = ()
    rejected: dict[str, int] = Field(default_factory=dict)
    folder: str | None = None
    report: str | None = None
    parameters: str | None = None
    pictures: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    recipe: str | None = None
    next_step: str | None = None


class TruthRecord(Versioned):
    """``truth.json``: everything that was true of a simulated log."""

    schema_name: Literal["footcal.truth"] = Field(default="footcal.truth", alias="schema")
    experiment: str
    seed: int
    robot: dict[str, Any]
    parameters: dict[str, float]
    effects: tuple[EffectRecord, ...] = ()
    noise: dict[str, float] = Field(default_factory=dict)
    details: dict[str, Any] = Field(default_factory=dict)


class CopCorrectionRecord(Record):
    """The correction of one foot's CoP, [NAO], eqs. (3)–(5): raw CoP + Σ coefficient · term.

    `terms` are ``1 x y x² xy y²`` of the raw CoP in m and cell forces in N; the coefficients give
    metres. `left_out_rmse_m` is the error at placements left out of the fit.
    """

    model: str
    terms: tuple[str, ...]
    coefficients_x: tuple[float, ...]
    coefficients_y: tuple[float, ...]
    ridge: float
    left_out_rmse_m: float
    placements: int
    chosen: bool


class CopCorrectionsRecord(Versioned):
    """``cop_correction.json``: the best polynomial correction of every foot."""

    schema_name: Literal["footcal.cop_correction"] = Field(
        default="footcal.cop_correction", alias="schema"
    )
    feet: dict[str, CopCorrectionRecord]


def parameter_records(estimates: Estimates) -> dict[str, ParameterRecord]:
    """Estimates as they stand in ``parameters.json``; fixed parameters have no sd."""
    return {
        name: ParameterRecord(
            value=float(value),
            sd=float(sd) if status is not Status.FIXED and np.isfinite(sd) else None,
            unit=unit,
            status=status,
        )
        for name, unit, value, sd, status in zip(
            estimates.names,
            estimates.units,
            estimates.values,
            estimates.sd,
            estimates.status,
            strict=True,
        )
    }


def covariance_blocks(*groups: Estimates) -> tuple[CovarianceBlock, ...]:
    """The joint covariance of each group; a group without one (no spare rows) has no block."""
    return tuple(
        CovarianceBlock(
            names=group.names,
            matrix=tuple(tuple(float(x) for x in row) for row in group.covariance),
        )
        for group in groups
        if np.isfinite(group.covariance).all()
    )
