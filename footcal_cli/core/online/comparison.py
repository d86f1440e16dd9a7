"""All methods on one walk, judged alike: against the truth, a baseline, or the body's motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N, Reference
from footcal_cli.core.contact import Reason, Validity, gait_cycles, judge
from footcal_cli.core.effects.contract import Scope, columns_of
from footcal_cli.core.effects.memory_effects import BIAS_JUMP
from footcal_cli.core.experiments.walk import channel_contact, reference_of
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.evidence import (
    SETTLING_S,
    Consistency,
    LeftInterval,
    OverCycles,
    Settling,
    check_consistency,
    departures,
    settle,
)
from footcal_cli.core.online.judged import (
    Judged,
    References,
    by_estimates,
    by_truth,
    in_band,
    judge_method,
    over_cycles,
)
from footcal_cli.core.online.live import run_live
from footcal_cli.core.online.memory import (
    INADEQUATE,
    Memory,
    MemoryOptions,
    memory_reference,
    replay_track,
    run_memory,
)
from footcal_cli.core.online.replay import (
    Replayed,
    corrected,
)
from footcal_cli.core.online.streams import Merged
from footcal_cli.core.online.weighed import Weighed, weighed_by_each_foot, weighed_walking
from footcal_cli.core.parameters import BoolArray, Estimates, FloatArray, IntArray
from footcal_cli.core.plausibility import check_gains
from footcal_cli.core.quality import Finding

_OUTLIER_SD = 6.0

_TAUGHT = 0.25
"""Share of the variance of a common gain that a walk must leave at most, to ask for a mass."""


@dataclass(frozen=True)
class ReplaySettings:
    """How a walk is replayed.

    Parameters
    ----------
    min_force_n
        Below this total force there is no CoP.
    causal
        Memory learns from the past alone, as a live run must.
    """

    memory: MemoryOptions = field(default_factory=MemoryOptions)
    min_force_n: float = MIN_FORCE_N
    causal: bool = False


@dataclass(frozen=True)
class InParts:
    """How a long walk was run.

    Parameters
    ----------
    part_s, ahead_s
        Their length, and what their smoother sees beyond their end.
    taught_from_s
        Start of the part that delay, noise and states were learnt from.
    every
        One of so many updates is kept for tables and figures.
    """

    parts: int
    part_s: float
    ahead_s: float
    taught_from_s: float
    every: int


@dataclass(frozen=True)
class ReplayedWalk:
    """What came out of a walk.

    Parameters
    ----------
    merged, belief
        What went in.
    memory
        The estimator that remembers.
    min_force_n
        Below this total force there is no CoP.
    replayed
        Method -> forces and CoP: ``before memory smoother``, other methods that ran, where there is
        a truth ``true``, and ``baseline`` where one was given.
    reference
        What the motion demands once the delay and offsets that memory found are taken out.
    judged
        Every method against every reference.
    ratios
        (method, reference, quantity) -> ratio of memory to that method over paired cycles, and p.
    per_cycle
        (method, reference, quantity) -> mean over cycles.
    validity
        Samples used for calibration, with reasons for the others.
    rejected
        How many are not used, by reason.
    taught
        Updates that changed anything, and all.
    consistency, settling, departures
        Of the filter.
    causal
        Whether memory learnt from the past alone.
    in_parts
        How the walk was run in parts; `replayed` and all else per sample are of the last one.
    """

    merged: Merged
    belief: Belief
    memory: Memory
    min_force_n: float
    replayed: Mapping[str, Replayed]
    reference: Reference
    cycle: IntArray
    judged: tuple[Judged, ...]
    ratios: Mapping[tuple[str, str, str], tuple[OverCycles, float]]
    per_cycle: Mapping[tuple[str, str, str], OverCycles]
    validity: Validity
    rejected: Mapping[str, int]
    taught: tuple[int, int]
    consistency: Consistency
    settling: tuple[Settling, ...]
    departures: tuple[LeftInterval, ...]
    causal: bool
    in_parts: InParts | None = None

    @property
    def best_reference(self) -> str:
        """The reference that deserves most trust."""
        have = {j.reference for j in self.judged}
        return next(r for r in ("truth", "baseline", "motion") if r in have)

    def of(self, method: str, reference: str) -> Judged:
        """One method against one reference."""
        return next(j for j in self.judged if (j.method, j.reference) == (method, reference))

    @property
    def weighed(self) -> Weighed:
        """The robot on its own cells, against its stated mass."""
        track, c = self.memory.track, len(self.belief.channels)
        mass_kg = float(self.merged.log.known["mass_kg"][0])
        gain, covariance = track.values[-1, :c], track.covariance[:c, :c]
        walked = weighed_walking(self.belief, gain, covariance, self.memory.repeated, mass_kg)
        if covariance.sum() < _TAUGHT * self.belief.covariance[:c, :c].sum():
            return walked
        log = self.merged.log  # gains that were held ask for no mass
        by_foot = weighed_by_each_foot(
            self.belief.forces(log.readings), channel_contact(log),
            columns_of(Scope.FOOT, log.channels), reference_of(log).fz_n, self.belief.gain_sd,
            mass_kg,
        )  # fmt: skip
        return walked if by_foot is None else by_foot

    def findings(self) -> Iterator[Finding]:
        """Jumps, wrong masses, scales and innovations, parameters that left their interval."""
        for jump in self.memory.jumps:
            yield Finding(
                BIAS_JUMP.name, "alarm" if jump.sure else "note", jump.name.removesuffix(".bias"),
                f"the bias jumped by {jump.size:.2f} ± {jump.sd:.2f} N at {jump.onset_s:.2f} s "
                f"(proved {jump.found_s - jump.onset_s:.2f} s later)",
                "check the cell's cable and seat; the bias is fitted before and after the jump"
                if jump.sure else "nothing, unless it comes again: its size is not sure",
            )  # fmt: skip
        yield from self.weighed.findings()
        channels = self.belief.channels
        yield from check_gains(channels, self.memory.track.values[-1, : len(channels)])
        yield from map(left_interval, self.departures)
        if self.memory.repeated > INADEQUATE:
            yield Finding(
                "repeated_errors", "warning", "filter",
                "the residual repeats in every gait cycle: "
                f"{self.memory.repeated:.1f} times the variance that chance would leave",
                "run diagnose on this log: it says whether an effect of the table is behind it",
            )  # fmt: skip
        yield from self.consistency.findings()


def compare(
    merged: Merged,
    belief: Belief,
    settings: ReplaySettings,
    *,
    truth_n: FloatArray | None = None,
    baseline: Estimates | None = None,
    others: Mapping[str, Replayed] | None = None,
    rng: np.random.Generator,
) -> ReplayedWalk:
    """Run the estimator on a walk and judge it, and other methods that ran.

    Parameters
    ----------
    truth_n
        True cell forces, shape (n, c), NaN where unknown; low-passed here as the cells are.
    baseline
        An offline calibration to compare with, as [NAO] does.
    others
        Forces and CoP of other methods on the same walk.
    """
    log = merged.log
    memory = (run_live if settings.causal else run_memory)(log, belief, settings.memory)
    if truth_n is not None:
        truth_n = in_band(truth_n, merged.rate_hz, causal=settings.causal)
    settled = log.time_s - log.time_s[0] > SETTLING_S
    found = judged_walk(
        memory, merged, belief, settings, References(truth_n, baseline),
        gait_cycles(log.known["contact"]), settled, others=others,
    )  # fmt: skip
    return with_statistics(found, rng)


def judged_walk(
    memory: Memory,
    merged: Merged,
    belief: Belief,
    settings: ReplaySettings,
    against: References,
    cycle: IntArray,
    settled: BoolArray,
    *,
    others: Mapping[str, Replayed] | None = None,
    skip_s: float = 2.0,
) -> ReplayedWalk:
    """Replay a walk, or a part of it, and judge it; without statistics over cycles and time.

    Parameters
    ----------
    cycle
        Gait cycle of each sample, shape (n,).
    settled
        Samples that are judged, shape (n,).
    skip_s
        Left out of the consistency at the start.
    """
    log = merged.log
    n, c = log.readings.shape
    reference = memory_reference(memory)
    nothing, least_n = np.zeros((n, c)), settings.min_force_n
    replayed = {"before": corrected("before", log, belief, nothing, nothing, min_force_n=least_n)}
    replayed |= others or {}
    replayed |= {
        "memory": replay_track("memory", memory, memory.track, belief, least_n),
        "smoother": replay_track("smoother", memory, memory.smoothed, belief, least_n),
    }
    references: dict[str, Replayed | Reference] = {}
    if against.truth_n is not None:
        replayed["true"] = by_truth(memory.log, belief, against.truth_n, least_n)
        references["truth"] = replayed["true"]
    if against.baseline is not None:
        replayed["baseline"] = by_estimates(log, belief, against.baseline, least_n)
        references["baseline"] = replayed["baseline"]
    references["motion"] = reference
    judged = tuple(
        judge_method(method, name, one, other, cycle, settled)
        for name, other in references.items()
        for method, one in replayed.items()
        if one is not other
    )
    validity = _used(merged, memory)
    used = memory.track.used
    return ReplayedWalk(
        merged, belief, memory, least_n, replayed, reference, cycle, judged, {}, {},
        validity, validity.counts,
        (int(used.sum()), used.size), check_consistency(memory.track, skip_s=skip_s), (), (),
        settings.causal,
    )  # fmt: skip


def with_statistics(found: ReplayedWalk, rng: np.random.Generator) -> ReplayedWalk:
    """The same with means and ratios over gait cycles, and how the parameters behave in time."""
    per_cycle, ratios = over_cycles(found.judged, rng)
    track, channels = found.memory.track, found.belief.channels
    names = [f"{channel}.{kind}" for kind in ("gain", "bias") for channel in channels]
    return replace(
        found,
        per_cycle=per_cycle,
        ratios=ratios,
        settling=tuple(settle(track, names)),
        departures=tuple(departures(track, found.memory.rows.prior_sd)),
    )


def _used(merged: Merged, memory: Memory) -> Validity:
    """Validity of the samples, outliers of the filter added."""
    track = memory.track
    with np.errstate(invalid="ignore"):
        far = np.asarray(np.abs(track.innovation) > _OUTLIER_SD * track.innovation_sd)
    block = np.searchsorted(memory.rows.last_sample, np.arange(len(merged.log)))
    inside = block < len(memory.rows)
    outlier = np.zeros(len(merged.log), dtype=bool)
    outlier[inside] = np.asarray(far.any(axis=1))[block[inside]]
    failures = {
        reason: merged.validity.reason == i for i, reason in enumerate(merged.validity.reasons)
    }
    failures[Reason.OUTLIER] = outlier
    return judge(failures, len(merged.log))


def left_interval(found: LeftInterval) -> Finding:
    """What a parameter outside its interval says: of a cell, or of the motion that all rest on."""
    of_body = found.name.startswith("robot.")
    return Finding(
        "body_left_interval" if of_body else "left_interval", "warning", found.name,
        f"since {found.time_s:.1f} s outside [{found.low:.3g}, {found.high:.3g}] {found.unit}, "
        f"now {found.value:.3g}",
        "compare the body's stream with an IMU, the model's CoM with the robot: the motion is "
        "wrong by more than was thought possible, and scales and biases rest on it"
        if of_body else "calibrate offline again, or widen the prior if the data sheet allows it; "
        "cells with hysteresis (force-sensing resistors) have another slope in small changes of "
        "load and another zero after them: then no scale is right, and sd do not hold that",
    )  # fmt: skip
