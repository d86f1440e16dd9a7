"""Errors of every method against every reference, over the walk and per gait cycle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.centroidal import Reference
from footcal_cli.core.online.evidence import (
    Interval,
    bootstrap_mean,
    bootstrap_ratio,
    paired_p,
)
from footcal_cli.core.online.replay import Replayed, errors_against
from footcal_cli.core.online.squares import Squares, squares, squares_per_cycle
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray


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
    dict[tuple[str, str, str], Interval], dict[tuple[str, str, str], tuple[Interval, float]]
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
