"""What a diagnosis answers: verdict, named causes, and one row per effect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from footcal_cli.core.diagnosis.detection import Detection
from footcal_cli.core.diagnosis.features import Features
from footcal_cli.core.diagnosis.form import Form
from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.search import Search
from footcal_cli.core.inference.evidence import Interval, smallest_p
from footcal_cli.core.inference.grams import Grams
from footcal_cli.core.inference.problem import Signature


class Verdict(StrEnum):
    """What a diagnosis ends with; exactly one."""

    NONE = "none"
    NAMED = "named"
    AMBIGUOUS = "ambiguous"
    NAMED_UNKNOWN = "named+unknown"
    UNKNOWN = "unknown"
    UNDERPOWERED = "underpowered"
    BAD_DATA = "bad-data"


class EffectStatus(StrEnum):
    """What can be said about one effect."""

    PRESENT = "present"
    ABSENT = "absent"
    UNDECIDED = "undecided"
    NOT_TESTABLE = "not_testable"


@dataclass(frozen=True)
class Compared:
    """Another effect, refitted in the place of the named one.

    Parameters
    ----------
    excess
        By what share the held-out RMS error, in the metric of the noise, is larger than with the
        named one, with the interval over blocks.
    left, left_by_named
        The p that the forms of both effects and their like explain nothing of what the other one
        leaves, and of what the named one does.
    """

    excess: Interval
    left: float
    left_by_named: float


@dataclass(frozen=True)
class Cause:
    """A named effect.

    Parameters
    ----------
    signature
        Effect, place, parameter, shape.
    size
        With its 95 % interval over blocks.
    p
        Family-wise p when it was accepted.
    gain
        Held-out reduction of the RMS error when it was accepted, as a share of the RMS before,
        with the interval over blocks.
    blocks_better
        Number of held-out blocks it improves.
    heterogeneity
        I²: share of the scatter of its size over blocks that is not noise.
    rivals, places
        Other effects that do as well; the same effect elsewhere.
    compared
        Other effects that were refitted in its place.
    odds
        How many times as probable the data are under each rival as under this one.
    """

    signature: Signature
    size: Interval
    p: float
    gain: Interval
    blocks_better: int
    heterogeneity: float
    rivals: tuple[Signature, ...]
    places: tuple[Signature, ...]
    compared: Mapping[str, Compared] = field(default_factory=dict)
    odds: Mapping[str, float] = field(default_factory=dict)

    @property
    def probability(self) -> dict[str, float]:
        """Of each effect of the set, itself first, all as likely beforehand; empty for a name."""
        names = dict.fromkeys([self.signature.effect, *(s.effect for s in self.rivals)])
        if len(names) == 1:
            return {}
        odds = {name: self.odds.get(name, 1.0) for name in names}
        return {name: of_it / sum(odds.values()) for name, of_it in odds.items()}

    @property
    def effects(self) -> frozenset[str]:
        """Itself and the others of its set."""
        return frozenset(s.effect for s in (self.signature, *self.rivals))

    @property
    def begun_by(self) -> frozenset[str]:
        """Effects from which the search comes to this one: itself, its rivals, and look-alikes.

        A look-alike that the linear search prefers, and a full refit refuses, begins the same
        comparison: beside a clock that runs fast a delay is nearer to linear.
        """
        return self.effects | set(self.compared)


@dataclass(frozen=True)
class MovedGain:
    """The gain of one cell against what its calibration allows.

    Parameters
    ----------
    cell
        Its channel.
    change
        Share by which the gain differs from the calibration, with its 95 % interval.
    mounting_sd
        Share by which a mounting moves a gain.
    certain
        Whether it has moved for certain.
    """

    cell: str
    change: Interval
    mounting_sd: float
    certain: bool


@dataclass(frozen=True)
class EffectRow:
    """One line of the evidence table.

    Parameters
    ----------
    signature
        The effect where and in the shape in which it explains most.
    size
        With its 95 % interval; on top of what was named.
    smallest
        Smallest size that matters, in the effect's unit.
    detectable
        Size that would have been found with the wanted power, in the effect's unit.
    visible
        Share of the effect that calibration cannot absorb.
    p, gain
        Family-wise p, and held-out reduction of the squared error as a share.
    informative
        Effective number of informative blocks.
    blocks_better
        Held-out blocks it improves.
    status, reason
        What can be said and why.
    """

    signature: Signature
    size: Interval
    smallest: float
    detectable: float
    visible: float
    p: float
    gain: float
    informative: float
    blocks_better: int
    status: EffectStatus
    reason: str


@dataclass(frozen=True)
class Diagnosis:
    """The answer of the engine.

    Parameters
    ----------
    verdict
        One word.
    causes
        Named effects in the order in which they were accepted.
    effects
        One row per effect of the library, by gain.
    before, after
        Library-free evidence on the baseline and on the extended model.
    form
        Whether the named sizes are the same everywhere; None without a name.
    share
        Named gain over named gain plus what could still be explained.
    search, library, grams, features
        The working, for figures.
    rules
        Thresholds.
    """

    verdict: Verdict
    causes: tuple[Cause, ...]
    effects: tuple[EffectRow, ...]
    before: Detection
    after: Detection
    form: Form | None
    share: float
    search: Search
    library: Library
    grams: Grams
    features: Features
    rules: Rules

    @property
    def smallest_p(self) -> float:
        """Smallest p that so many blocks can reach."""
        return float(smallest_p(float(self.grams.blocks)))
