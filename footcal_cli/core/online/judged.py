"""Errors of every method against every reference, over the walk and per gait cycle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.centroidal import Reference
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.evidence import (
    OverCycles,
    bootstrap_mean,
    bootstrap_ratio,
    paired_p,
)
from footcal_cli.core.online.replay import Replayed, corrected, errors_against
from footcal_cli.core.parameters import BoolArray, Estimates, FloatArray, IntArray
from footcal_cli.core.signals import low_pass_stretches


@dataclass(frozen=True)
class References:
    """What a walk is compared with besides its own motion.

    Parameters
    ----------
    truth_n
        True cell forces in the band of the cells, shape (n, c).
    """

    truth_n: FloatArray | None = None
    baseline: Estimates | None = None


def in_band(truth_n: FloatArray, rate_hz: float, *, causal: bool) -> FloatArray:
    """True forces, low-pass filtered like the cells, shape (n, c)."""
    good = np.asarray(np.isfinite(truth_n).all(axis=1))
    return low_pass_stretches(truth_n, good, rate_hz, causal=causal)


def by_truth(log: Log, belief: Belief, truth_n: FloatArray, min_force_n: float) -> Replayed:
    """The true forces as if a calibration had produced them."""
    change = truth_n - belief.forces(log.readings)
    nothing = np.zeros(truth_n.shape)
    return corrected("true", log, belief, nothing, change, min_force_n=min_force_n)


def by_estimates(log: Log, belief: Belief, estimates: Estimates, min_force_n: float) -> Replayed:
    """What an offline calibration makes of the walk."""
    scale = np.array([estimates[f"{name}.scale"] for name in belief.channels])
    bias = np.array([estimates[f"{name}.bias"] for name in belief.channels])
    gain = scale / belief.scale_n_per_count - 1.0
    shape = log.readings.shape
    return corrected(
        "baseline", log, belief, np.broadcast_to(gain, shape),
        np.broadcast_to(bias - belief.bias_n * (1.0 + gain), shape), min_force_n=min_force_n,
    )  # fmt: skip


@dataclass(frozen=True)
class Squares:
    """Sums of squared errors, from which those of parts of a walk add up.

    Parameters
    ----------
    total
        Sum of the squares, a number or of each gait cycle, shape (cycles,).
    count
        How many errors stand behind it, of the same shape.
    """

    total: FloatArray
    count: FloatArray

    @property
    def rms(self) -> FloatArray:
        """``√(total / count)``, NaN where nothing counts."""
        with np.errstate(invalid="ignore"):
            return np.asarray(np.sqrt(self.total / np.where(self.count > 0, self.count, np.nan)))

    def __add__(self, other: Squares) -> Squares:
        return Squares(self.total + other.total, self.count + other.count)

    def widened(self, cycles: int) -> Squares:
        """The same with room for so many gait cycles."""
        more = (0, cycles - self.count.size)
        return Squares(np.pad(self.total, more), np.pad(self.count, more))


def squares(values: FloatArray) -> Squares:
    """Of the finite errors, shape (n,), or of vectors, shape (n, k)."""
    squared = values**2 if values.ndim == 1 else np.sum(values**2, axis=1)
    finite = squared[np.isfinite(squared)]
    return Squares(np.asarray(finite.sum()), np.asarray(float(finite.size)))


def squares_per_cycle(errors: FloatArray, cycle: IntArray) -> Squares:
    """Of each gait cycle.

    Parameters
    ----------
    errors
        Shape (n,) or (n, k); not finite ones do not count.
    cycle
        Number of the cycle of each sample, negative for none, shape (n,).
    """
    squared = errors**2 if errors.ndim == 1 else np.sum(errors**2, axis=1)
    use = (cycle >= 0) & np.isfinite(squared)
    count = int(cycle.max(initial=-1)) + 1
    return Squares(
        np.bincount(cycle[use], weights=squared[use], minlength=count).astype(float),
        np.bincount(cycle[use], minlength=count).astype(float),
    )


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

    def followed_by(self, later: Judged) -> Judged:
        """Of a part of a walk and the next one together; cycles are numbered over both."""
        cycles = max(
            one.count.size for one in (*self.per_cycle.values(), *later.per_cycle.values())
        )
        return replace(
            self,
            whole={name: own + later.whole[name] for name, own in self.whole.items()},
            per_cycle={
                name: own.widened(cycles) + later.per_cycle[name].widened(cycles)
                for name, own in self.per_cycle.items()
            },
        )


def judge_method(
    method: str, name: str, ours: Replayed, against: Replayed | Reference, cycle: IntArray,
    settled: BoolArray,
) -> Judged:  # fmt: skip
    """Errors of one method against one reference.

    Parameters
    ----------
    method, name
        Of the method and of the reference.
    cycle
        Gait cycle of each sample, negative for none, shape (n,).
    settled
        Samples that are judged, shape (n,).
    """
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


def over_cycles(
    judged: Sequence[Judged], rng: np.random.Generator
) -> tuple[
    dict[tuple[str, str, str], OverCycles], dict[tuple[str, str, str], tuple[OverCycles, float]]
]:
    """Means over gait cycles, and ratios of memory to the other methods, by what was compared."""
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
