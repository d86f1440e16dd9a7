"""All methods on one walk, judged alike: against the truth, a baseline, or the body's motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from footcal_cli.core.centroidal import Reference
from footcal_cli.core.contact import Reason, Validity, gait_cycles, judge
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.evidence import (
    SETTLING_S,
    Consistency,
    Departure,
    Interval,
    Settling,
    Squares,
    bootstrap_mean,
    bootstrap_ratio,
    check_consistency,
    departures,
    paired_p,
    settle,
    squares,
    squares_per_cycle,
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
    errors_against,
)
from footcal_cli.core.online.sensitivity import Sensitivity, memory_sensitivity, window_sensitivity
from footcal_cli.core.online.streams import Merged
from footcal_cli.core.online.window import Weights, WindowRule
from footcal_cli.core.online.windows import QUIET_S, GivenWeights, run_windows
from footcal_cli.core.parameters import BoolArray, Estimates, FloatArray, IntArray, Status
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import low_pass_stretches

_OUTLIER_SD = 6.0


@dataclass(frozen=True)
class Settings:
    """How a walk is replayed.

    Parameters
    ----------
    memory, window
        Of the two estimators.
    others
        Which of the papers' methods run besides memory: ``window``, ``static``.
    weights
        ωF, ωP and ωS of the papers' methods, None for those that the log itself must give.
    causal
        Memory learns from the past alone, as a live run must.
    """

    memory: MemoryOptions = field(default_factory=MemoryOptions)
    window: WindowRule = field(default_factory=WindowRule)
    others: tuple[str, ...] = ("window", "static")
    weights: GivenWeights = field(default_factory=GivenWeights)
    causal: bool = False


@dataclass(frozen=True)
class Judged:
    """One method against one reference.

    Parameters
    ----------
    method, reference
        Who, against what (``truth``, ``baseline``, ``motion``).
    whole
        Quantity -> squared errors of all samples but the first seconds: those of `per_cycle`, and
        ``cop_x cop_y``.
    per_cycle
        ``cop foot_cop vgrf`` -> those of each gait cycle.
    """

    method: str
    reference: str
    whole: Mapping[str, Squares]
    per_cycle: Mapping[str, Squares]

    def rms(self, quantity: str) -> float:
        """RMS error over the walk."""
        return float(self.whole[quantity].rms)

    def cycles(self, quantity: str) -> FloatArray:
        """RMS error of each gait cycle, NaN where none of its samples counts, shape (cycles,)."""
        return self.per_cycle[quantity].rms


@dataclass(frozen=True)
class Comparison:
    """What came out of a walk.

    Parameters
    ----------
    merged, belief
        What went in.
    memory
        The estimator that remembers.
    weights
        ωF, ωP and ωS of the papers' methods that ran.
    replayed
        Method -> forces and CoP: ``before memory smoother``, those of ``window static`` that ran,
        where there is a truth ``true``, and ``baseline`` where one was given.
    reference
        What the motion demands once the delay and offsets that memory found are taken out.
    cycle
        Gait cycle of each sample.
    judged
        Every method against every reference.
    ratios
        (method, reference, quantity) -> ratio of memory to that method over paired cycles, and p.
    per_cycle
        (method, reference, quantity) -> mean over cycles.
    validity
        Samples used for calibration, with reasons for the others.
    consistency, settling, departures
        Of the filter.
    causal
        Whether memory learnt from the past alone.
    left_out
        Methods that were asked for and had no standing to take their weights from.
    """

    merged: Merged
    belief: Belief
    memory: Memory
    weights: Mapping[str, Weights]
    rule: WindowRule
    replayed: Mapping[str, Replayed]
    reference: Reference
    cycle: IntArray
    judged: tuple[Judged, ...]
    ratios: Mapping[tuple[str, str, str], tuple[Interval, float]]
    per_cycle: Mapping[tuple[str, str, str], Interval]
    validity: Validity
    consistency: Consistency
    settling: tuple[Settling, ...]
    departures: tuple[Departure, ...]
    causal: bool
    left_out: tuple[str, ...] = ()

    @property
    def best_reference(self) -> str:
        """The reference that deserves most trust."""
        have = {j.reference for j in self.judged}
        return next(r for r in ("truth", "baseline", "motion") if r in have)

    def of(self, method: str, reference: str) -> Judged:
        """One method against one reference."""
        return next(j for j in self.judged if (j.method, j.reference) == (method, reference))

    def sensitivity(self) -> list[tuple[str, Sensitivity]]:
        """RMSE of both estimators as each of their settings is scaled."""
        against: Replayed | Reference = self.reference
        if self.best_reference == "truth":
            against = self.replayed["true"]
        elif self.best_reference == "baseline":
            against = self.replayed["baseline"]
        ours = memory_sensitivity(
            self.memory, self.belief, against, min_force_n=self.rule.min_force_n
        )
        curves = [("memory", s) for s in ours]
        if "window" in self.weights:
            log, weights = self.merged.log, self.weights["window"]
            paper = window_sensitivity(log, self.belief, weights, against, self.rule)
            curves += [("window", s) for s in paper]
        return curves

    def window_estimates(self, method: str) -> Estimates:
        """The last solution of the window; it has no covariance of its own."""
        last = self.replayed[method]
        c = len(self.belief.channels)
        return self.belief.estimates(
            last.gain[-1], last.bias_n[-1], self.belief.covariance, [Status.PRIOR_KEPT] * (2 * c)
        )

    def findings(self) -> list[Finding]:
        """Jumps, parameters that left their interval, inconsistent innovations."""
        found = [
            Finding(
                "bias_jump",
                "alarm" if jump.sure else "note",
                jump.name.removesuffix(".bias"),
                f"the bias jumped by {jump.size:.2f} ± {jump.sd:.2f} N at {jump.onset_s:.2f} s "
                f"(proved {jump.found_s - jump.onset_s:.2f} s later)",
                "check the cell's cable and seat; before and after are calibrated apart",
            )
            for jump in self.memory.jumps
        ]
        found += [
            Finding(
                "left_interval",
                "warning",
                d.name,
                f"since {d.time_s:.1f} s outside [{d.low:.3g}, {d.high:.3g}] {d.unit}, now "
                f"{d.value:.3g}",
                "calibrate offline again, or widen the prior if the data sheet allows it",
            )
            for d in self.departures
        ]
        if self.left_out:
            found.append(
                Finding(
                    "no_standing_start",
                    "note",
                    " and ".join(self.left_out),
                    "not compared: their weights come from standing still, and this log starts "
                    f"with less than {QUIET_S} s of it",
                    "give force_weight and cop_weight, or record standing before the first step",
                )
            )
        if self.memory.repeated > INADEQUATE:
            found.append(
                Finding(
                    "repeated_errors",
                    "warning",
                    "filter",
                    "the residual repeats in every gait cycle: "
                    f"{self.memory.repeated:.1f} times the variance that chance would leave",
                    "run diagnose on this log: an effect is missing from the chain",
                )
            )
        ratio = self.consistency.ratio
        if not 0.8 < ratio < 1.25:
            found.append(
                Finding(
                    "inconsistent_innovations",
                    "warning",
                    "filter",
                    f"innovations are {ratio**0.5:.2f} times as large as claimed",
                    "run diagnose on this log: an effect is missing from the chain",
                )
            )
        return found


def compare(
    merged: Merged,
    belief: Belief,
    settings: Settings,
    *,
    truth_n: FloatArray | None = None,
    baseline: Estimates | None = None,
    rng: np.random.Generator,
) -> Comparison:
    """Run the methods on a walk and judge them.

    Parameters
    ----------
    merged
        Streams of the walk as one log.
    belief
        Prior of the cells.
    truth_n
        True cell forces, shape (n, c), NaN where unknown; low-passed here as the cells are.
    baseline
        An offline calibration to compare with, as seed 1 does.
    rng
        For the bootstrap.
    """
    log = merged.log
    n, c = log.readings.shape
    memory = (run_live if settings.causal else run_memory)(log, belief, settings.memory)
    reference = memory_reference(memory)
    nothing, least_n = np.zeros((n, c)), settings.window.min_force_n
    replayed = {"before": corrected("before", log, belief, nothing, nothing, min_force_n=least_n)}
    windows = run_windows(log, belief, settings.others, settings.window, settings.weights)
    replayed |= {method: one.replayed for method, one in windows.items()}
    replayed |= {
        "memory": replay_track("memory", memory, memory.track, belief, least_n),
        "smoother": replay_track("smoother", memory, memory.smoothed, belief, least_n),
    }
    references: dict[str, Replayed | Reference] = {}
    if truth_n is not None:
        replayed["true"] = _true(memory, merged, belief, truth_n, settings)
        references["truth"] = replayed["true"]
    if baseline is not None:
        replayed["baseline"] = _by_estimates(merged, belief, baseline, least_n)
        references["baseline"] = replayed["baseline"]
    references["motion"] = reference
    cycle = gait_cycles(log.known["contact"])
    settled = log.time_s - log.time_s[0] > SETTLING_S
    judged = tuple(
        _judge(method, name, one, against, cycle, settled)
        for name, against in references.items()
        for method, one in replayed.items()
        if one is not against
    )
    per_cycle, ratios = _statistics(judged, rng)
    names = [f"{channel}.{kind}" for kind in ("gain", "bias") for channel in belief.channels]
    return Comparison(
        merged, belief, memory, {method: one.weights for method, one in windows.items()},
        settings.window, replayed, reference, cycle, judged,
        ratios, per_cycle, _used(merged, memory), check_consistency(memory.track),
        tuple(settle(memory.track, names)),
        tuple(departures(memory.track, memory.rows.prior_sd)), settings.causal,
        tuple(method for method in settings.others if method not in windows),
    )  # fmt: skip


def _true(
    memory: Memory, merged: Merged, belief: Belief, truth_n: FloatArray, settings: Settings
) -> Replayed:
    """The true forces in the band of the cells, as if a calibration had produced them."""
    log = memory.log
    good = np.asarray(np.isfinite(truth_n).all(axis=1))
    filtered = low_pass_stretches(truth_n, good, merged.rate_hz, causal=settings.causal)
    believed = belief.forces(log.readings)
    return corrected(
        "true", log, belief, np.zeros(truth_n.shape), filtered - believed,
        min_force_n=settings.window.min_force_n,
    )  # fmt: skip


def _by_estimates(
    merged: Merged, belief: Belief, estimates: Estimates, min_force_n: float
) -> Replayed:
    scale = np.array([estimates[f"{name}.scale"] for name in belief.channels])
    bias = np.array([estimates[f"{name}.bias"] for name in belief.channels])
    gain = scale / belief.scale_n_per_count - 1.0
    shape = merged.log.readings.shape
    return corrected(
        "baseline", merged.log, belief, np.broadcast_to(gain, shape),
        np.broadcast_to(bias - belief.bias_n * (1.0 + gain), shape), min_force_n=min_force_n,
    )  # fmt: skip


def _judge(
    method: str, name: str, ours: Replayed, against: Replayed | Reference, cycle: IntArray,
    settled: BoolArray,
) -> Judged:  # fmt: skip
    found = errors_against(ours, against)
    blank = np.where(settled, 1.0, np.nan)
    cop, force = found.cop_m * blank[:, None], found.vgrf_n * blank
    foot_cop = found.foot_cop_m * blank[:, None, None]
    feet = foot_cop.shape[1]
    one_by_one = np.concatenate([foot_cop[:, f] for f in range(feet)])
    return Judged(
        method,
        name,
        {
            "cop": squares(cop),
            "cop_x": squares(cop[:, 0]),
            "cop_y": squares(cop[:, 1]),
            "foot_cop": squares(foot_cop.reshape(-1, 2)),
            "vgrf": squares(force),
        },
        {
            "cop": squares_per_cycle(cop, cycle),
            "foot_cop": squares_per_cycle(one_by_one, np.tile(cycle, feet)),
            "vgrf": squares_per_cycle(force, cycle),
        },
    )


def _statistics(
    judged: tuple[Judged, ...], rng: np.random.Generator
) -> tuple[
    dict[tuple[str, str, str], Interval], dict[tuple[str, str, str], tuple[Interval, float]]
]:
    per_cycle, ratios = {}, {}
    for one in judged:
        ours = next(j for j in judged if j.method == "memory" and j.reference == one.reference)
        for quantity in ("cop", "foot_cop", "vgrf"):
            series = one.cycles(quantity)
            if not np.isfinite(series).any():
                continue
            key = (one.method, one.reference, quantity)
            per_cycle[key] = bootstrap_mean(series, rng)
            if one.method != "memory":
                mine = ours.cycles(quantity)
                ratios[key] = (bootstrap_ratio(mine, series, rng), paired_p(mine, series))
    return per_cycle, ratios


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
