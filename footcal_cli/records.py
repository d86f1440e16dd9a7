"""What footcal writes: versioned JSON that cannot be misread, and the strict reader.

Every record names its schema and version; an unknown key, a newer version or another schema is
refused in one line. ``footcal schema`` prints the JSON Schemas.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from footcal_cli import __version__
from footcal_cli.core.parameters import Estimates, FloatArray, Status
from footcal_cli.core.quality import Finding
from footcal_cli.errors import UsageError, nearest


class Record(BaseModel):
    """Frozen, strict about keys, and free of NaN: an absent number is null."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Versioned(Record):
    """A record that stands in a file of its own."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, serialize_by_alias=True
    )

    schema_name: str = Field(alias="schema")
    schema_version: Literal[1] = 1
    footcal_version: str = __version__


class ParameterRecord(Record):
    """One calibrated number."""

    value: float
    sd: float | None
    unit: str
    status: Status


class CovarianceBlock(Record):
    """Joint covariance of parameters, in products of their units."""

    names: tuple[str, ...]
    matrix: tuple[tuple[float, ...], ...]


class Range(Record):
    """Lowest and highest value met in the fitted data."""

    lowest: float
    highest: float
    unit: str


class EffectRecord(Record):
    """An effect that the calibration contains: its name in the table and who shares its values."""

    effect: str
    owners: dict[str, tuple[str, ...]]


class ParametersRecord(Versioned):
    """``parameters.json``: a calibration.

    `sign_convention`, `frame` and `expressed_at` say how the values are meant; `fitted_range` where
    they hold; `effects` what a chain contains beyond scale, bias and offset.
    """

    schema_name: Literal["footcal.parameters"] = Field(default="footcal.parameters", alias="schema")
    command: str
    created: str
    robot: str
    gravity_mps2: float
    sign_convention: str
    frame: str
    expressed_at: str
    parameters: dict[str, ParameterRecord]
    covariance: tuple[CovarianceBlock, ...] = ()
    fitted_range: dict[str, dict[str, Range]] = Field(default_factory=dict)
    effects: tuple[EffectRecord, ...] = ()
    inputs: dict[str, str] = Field(default_factory=dict)

    def value(self, name: str) -> float:
        """Value of one parameter; an absent name is the caller's usage error."""
        if name not in self.parameters:
            raise UsageError(
                f"the calibration has no parameter '{name}'{nearest(name, self.parameters)}",
                remedy="calibrate that channel first, or correct the channel's name",
            )
        return self.parameters[name].value

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
    split: Literal["all", "train", "held_out"]
    rmse: float
    n: int


class RmseRecord(Versioned):
    """``rmse.json``: errors before and after, and how many samples were rejected, by reason."""

    schema_name: Literal["footcal.rmse"] = Field(default="footcal.rmse", alias="schema")
    rows: tuple[RmseRow, ...]
    rejected: dict[str, int] = Field(default_factory=dict)


class FindingRecord(Record):
    """Something about the data that the user should know."""

    code: str
    severity: Literal["alarm", "warning", "note"]
    where: str
    sentence: str
    remedy: str

    @classmethod
    def of(cls, finding: Finding) -> FindingRecord:
        """The record of a finding of the core."""
        return cls(
            code=finding.code,
            severity=finding.severity,
            where=finding.where,
            sentence=finding.sentence,
            remedy=finding.remedy,
        )


class VerdictRecord(Record):
    """The first sentence of a report."""

    level: Literal["good", "warning", "bad"]
    sentence: str
    details: tuple[str, ...] = ()


class RunRecord(Versioned):
    """``run.json``: what was run, on what, and how it ended."""

    schema_name: Literal["footcal.run"] = Field(default="footcal.run", alias="schema")
    command: str
    started: str
    arguments: dict[str, Any]
    recipe: dict[str, Any]
    options: dict[str, Any]
    inputs: dict[str, str]
    rows: dict[str, int]
    seed: int
    timings_s: dict[str, float]
    verdict: VerdictRecord
    findings: tuple[FindingRecord, ...] = ()
    gates_missed: tuple[str, ...] = ()
    exit_code: int


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
    """The correction of one foot's CoP, seed 1, eqs. (3)–(5): raw CoP + Σ coefficient · term.

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


class HeldOutGain(Record):
    """What an effect buys on blocks the model was not fitted to."""

    quantity: str
    unit: str
    before: float
    after: float
    ci95: tuple[float, float] | None
    """Relative reduction of the RMS error."""


class CauseRecord(Record):
    """One named effect; `rivals` explain the same as well, `places` too, elsewhere."""

    effect: str
    where: str
    parameter: str
    size: float
    sd: float | None
    unit: str
    ci95: tuple[float, float] | None
    shape: dict[str, float] = Field(default_factory=dict)
    p: float
    held_out_gain: HeldOutGain | None
    blocks_better: int
    rivals: tuple[str, ...] = ()
    places: tuple[str, ...] = ()


class EffectRowRecord(Record):
    """What can be said about one effect of the table."""

    effect: str
    where: str
    parameter: str
    unit: str
    size: float | None
    ci95: tuple[float, float] | None
    smallest_that_matters: float | None
    detectable: float | None
    visible: float | None
    p: float | None
    gain: float | None
    informative_blocks: float | None
    status: Literal["present", "absent", "undecided", "not_testable"]
    reason: str


class NextExperimentRecord(Record):
    """What to run next, and what it promises.

    `id` names a plan of the menu, empty where no log can tell; `kind` is the experiment whose log
    `diagnose` then reads. Cosines are of what the rivals leave visible beside the calibration, now
    and then; separations in noise sd of one run. `without` is what the experiment takes out of the
    question: left out of the table when its log is diagnosed (`--without`).
    """

    id: str
    kind: str
    words: str
    between: tuple[str, ...] = ()
    cosine_now: float | None = None
    cosine_after: float | None = None
    separation_now: float | None = None
    separation: float | None = None
    repeats: int | None = None
    minutes: float | None = None
    without: tuple[str, ...] = ()


class PlanRecord(Versioned):
    """``plan.json``: the experiment that tells effects apart, and the menu it was chosen from."""

    schema_name: Literal["footcal.plan"] = Field(default="footcal.plan", alias="schema")
    between: tuple[str, ...]
    next_experiment: NextExperimentRecord
    menu: tuple[NextExperimentRecord, ...] = ()


class SuspectRecord(Record):
    """One of the first rivals, with the sizes at which it explains this log."""

    effect: str
    owners: dict[str, tuple[str, ...]]
    values: dict[str, float]
    sd: float
    """Of its size, as a share of it."""


class FollowedRecord(Record):
    """A rival of the log before: the share of it that this log holds, all rivals together."""

    effect: str
    share: float | None
    ci95: tuple[float, float] | None
    says: Literal["there", "gone", "open", "unseen"]


class DiagnosisRecord(Versioned):
    """``diagnosis.json``: the verdict, its causes, rivals and the experiment to run next.

    `suspects` are the first rivals, for the log after this one. `after` and `survivors` tell what
    became of the rivals of the log before, where one was given (`--after`).
    """

    schema_name: Literal["footcal.diagnosis"] = Field(default="footcal.diagnosis", alias="schema")
    experiment_kind: str
    verdict: Literal[
        "none", "named", "ambiguous", "named+unknown", "unknown", "underpowered", "bad-data"
    ]
    sentence: str
    causes: tuple[CauseRecord, ...] = ()
    rivals: tuple[tuple[str, ...], ...] = ()
    experiment: str = ""
    next_experiment: NextExperimentRecord | None = None
    suspects: tuple[SuspectRecord, ...] = ()
    after: tuple[FollowedRecord, ...] = ()
    survivors: tuple[str, ...] = ()
    findings: tuple[FindingRecord, ...] = ()
    effects: tuple[EffectRowRecord, ...] = ()
    blocks: int
    rows: int
    smallest_p: float
    share_explained: float | None
    leftover_p: float | None
    evidence: dict[str, float] = Field(default_factory=dict)
    seed: int
    rules: str


SCHEMAS: Mapping[str, type[Versioned]] = {
    "parameters": ParametersRecord,
    "rmse": RmseRecord,
    "run": RunRecord,
    "truth": TruthRecord,
    "diagnosis": DiagnosisRecord,
    "plan": PlanRecord,
    "cop-correction": CopCorrectionsRecord,
}
"""Name on the command line -> record."""

AnyVersioned = TypeVar("AnyVersioned", bound=Versioned)


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


def write_record(record: Versioned, path: Path) -> None:
    """Write a record as indented JSON with a final newline."""
    path.write_text(record.model_dump_json(indent=2, by_alias=True) + "\n", encoding="utf-8")


def read_record(model: type[AnyVersioned], path: Path) -> AnyVersioned:
    """Read a record strictly.

    Raises
    ------
    UsageError
        No such file, not JSON, another schema, a newer version, or a key or value that does not
        belong there.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise UsageError("no such file", file=path, remedy="check the path") from None
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise UsageError(f"not valid JSON: {error}", file=path, remedy="write it again") from None
    expected = str(model.model_fields["schema_name"].default)
    found = content.get("schema") if isinstance(content, dict) else None
    if found != expected:
        raise UsageError(
            f"schema is '{found}', expected '{expected}'", file=path,
            remedy="give the file that footcal wrote",
        )  # fmt: skip
    version = content.get("schema_version")
    if isinstance(version, int) and version > 1:
        raise UsageError(
            f"schema version {version} is newer than this footcal ({__version__}) reads",
            file=path, remedy="update footcal",
        )  # fmt: skip
    try:
        return model.model_validate(content)
    except ValidationError as error:
        fault = error.errors()[0]
        key = ".".join(str(part) for part in fault["loc"])
        hint = nearest(key, [f.alias or n for n, f in model.model_fields.items()])
        raise UsageError(
            f"key '{key}': {fault['msg']}{hint}", file=path, remedy="write it with footcal"
        ) from None
