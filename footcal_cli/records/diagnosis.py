"""What `diagnose` writes: the verdict with its evidence, and the experiment to run next."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from footcal_cli.core.quality import Finding
from footcal_cli.records.files import Record, Versioned


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
    matters: bool = True
    """Whether its size is one that matters; a small cause may be as certain as a large one."""
    remedy: str = ""
    probability: dict[str, float] = Field(default_factory=dict)
    """Of each effect of a set of rivals, all of them taken as equally likely beforehand."""
    agreement_p: float | None = None
    """p of its sizes being the same in all experiments that know of it."""
    written: str = ""
    """The hole or the weight that it is about, as the log calls it."""


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
    written: str = ""
    """The hole or the weight that it is about, as the log calls it."""


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
    """``plan.json``: the experiment that distinguishes effects, and the menu it was chosen from."""

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


class HeldRecord(Record):
    """An effect that the calibration in use corrects already, and whose it is."""

    effect: str
    owners: tuple[str, ...]


class RangeRecord(Record):
    """What is known of one parameter of the extended model, to draw it from in a simulation.

    Normal with `mean` and `sd`, kept within `low` and `high`, its 95 % interval.
    """

    mean: float
    sd: float
    low: float
    high: float
    unit: str


class SizeInExperimentRecord(Record):
    """A cause of a joint diagnosis in one of its experiments."""

    effect: str
    size: float | None
    sd: float | None
    unit: str
    named: bool
    """Whether this experiment's own diagnosis has it among its names."""
    not_testable: str = ""
    """Why this experiment says nothing of it; empty where it does."""


class ExperimentRecord(Record):
    """One experiment of a joint diagnosis: what it says by itself, and of each common cause."""

    name: str
    kind: str
    verdict: str
    names: tuple[tuple[str, ...], ...]
    sizes: tuple[SizeInExperimentRecord, ...]


class DiagnosisRecord(Versioned):
    """``diagnosis.json``: the verdict, its causes, rivals and the experiment to run next.

    `ranges` are the named causes' parameters by full name, to randomise a simulation with.
    `experiments` are those of a joint diagnosis, empty for a single one.

    `suspects` are the first rivals, for the log after this one. `after` and `survivors` tell what
    became of the rivals of the log before, where one was given (`--after`). `holds` are the effects
    of the calibration that the diagnosis started from: what it corrects already is not found.
    """

    schema_name: Literal["footcal.diagnosis"] = Field(default="footcal.diagnosis", alias="schema")
    experiment_kind: str
    verdict: Literal[
        "none", "named", "ambiguous", "named+unknown", "unknown", "underpowered", "bad-data"
    ]
    sentence: str
    holds: tuple[HeldRecord, ...] = ()
    causes: tuple[CauseRecord, ...] = ()
    rivals: tuple[tuple[str, ...], ...] = ()
    experiment: str = ""
    next_experiment: NextExperimentRecord | None = None
    suspects: tuple[SuspectRecord, ...] = ()
    after: tuple[FollowedRecord, ...] = ()
    survivors: tuple[str, ...] = ()
    ranges: dict[str, RangeRecord] = Field(default_factory=dict)
    experiments: tuple[ExperimentRecord, ...] = ()
    findings: tuple[Finding, ...] = ()
    effects: tuple[EffectRowRecord, ...] = ()
    blocks: int
    rows: int
    smallest_p: float
    share_explained: float | None
    leftover_p: float | None
    evidence: dict[str, float] = Field(default_factory=dict)
    seed: int
    rules: str
