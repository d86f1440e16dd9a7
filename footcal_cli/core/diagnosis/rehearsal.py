"""A planned experiment played through: what effects would show there beside the calibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.chain import Chain, Link
from footcal_cli.core.diagnosis.plans import Plan
from footcal_cli.core.diagnosis.rig import Rig
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect, units_of
from footcal_cli.core.experiments.contract import Experiment
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.ideal import balanced
from footcal_cli.core.inference.linear import orthonormal
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.signals import CUTOFF_HZ

Basis = tuple[BoolArray, FloatArray]
"""Rows, and orthonormal columns on them."""

_RIVAL_SIZES = np.array([-2.0, -1.0, -0.3, 0.3, 0.6, 0.8, 0.9, 1.0, 1.1, 1.25, 1.6, 2.5])
"""Sizes of a rival tried, as shares of its fitted one."""
_SEEN = 0.02
"""Share of an effect that the calibration must leave for it to be visible in a plan."""
DRIFT_S = 12.0
"""A drifting calibration is known anew after this time."""
_RANK = 1e-6
_STEP = 0.1  # of a calibration parameter, in its prior sd


def usual(effect: Effect, where: str = "") -> Signature:
    """An effect in its usual shape, of which no log has said more."""
    shape = tuple((p.name, p.neutral) for p in effect.shapes)
    return Signature(effect.name, effect.size.name, where, effect.size.unit, shape)


@dataclass(frozen=True)
class Contender:
    """An effect with the values that explain the present data.

    Parameters
    ----------
    signature
        Effect and who carries it.
    values
        Its parameters by short name; what is missing stays neutral.
    copies
        Whether they are those with which it copies what was named.
    """

    signature: Signature
    values: Mapping[str, float]
    copies: bool = False

    def scaled(self, effect: Effect, share: float) -> Mapping[str, float]:
        """Its values with another size."""
        moved = dict(self.values)
        for size in effect.sizes:
            if size.name in moved:
                value = size.neutral + share * (moved[size.name] - size.neutral)
                moved[size.name] = float(np.clip(value, size.lower, size.upper))
        return moved


@dataclass(frozen=True)
class Comparison:
    """How far an experiment keeps two contenders apart.

    Parameters
    ----------
    cosine
        |cos| of what the calibration leaves visible of them; 0 where only one is visible.
    separation
        What no size of the second absorbs of the first, in noise sd.
    """

    cosine: float
    separation: float


class Rehearsal:
    """Recordings on which effects are shown, beside what calibration absorbs.

    Parameters
    ----------
    experiment
        Its balance judges the recordings.
    logs
        True loads, nothing wrong.
    rig
        Noise.
    settled
        Effects that the experimenter takes out of the question there.
    judged
        Which rows of each log count, shape (n,) each; all where absent.
    free_in_blocks
        Whether every block has a calibration of its own.
    """

    def __init__(
        self,
        experiment: Experiment,
        logs: Sequence[Log],
        rig: Rig,
        *,
        settled: Sequence[str] = (),
        judged: Sequence[BoolArray] | None = None,
        free_in_blocks: bool = False,
    ) -> None:
        self._experiment, self._logs, self._settled = experiment, tuple(logs), frozenset(settled)
        balances = [experiment.balance(log) for log in self._logs]
        self._errors = [b.error for b in balances]
        self._valid = [b.valid for b in balances]
        if judged is not None:
            self._valid = [v & rows[:, None] for v, rows in zip(self._valid, judged, strict=True)]
        self._noise = [
            np.array(
                [rig.noise_of(o, u, self.kind) for o, u in zip(b.outputs, b.units, strict=True)]
            )
            for b in balances
        ]
        # what a low-pass has smoothed does not renew itself faster than that
        fastest = 2.0 * CUTOFF_HZ if self.kind == "walk" else np.inf
        self._weight = np.sqrt(min(min(rig.independent_hz, fastest) / self._rate_hz(), 1.0))
        block = self._blocks() if free_in_blocks else np.zeros(self._size(), dtype=np.int64)
        self._bases = self._calibration(experiment.calibration, block)

    @property
    def kind(self) -> str:
        """Name of the experiment."""
        return self._experiment.name

    def with_settled(self, names: Sequence[str]) -> Rehearsal:
        """The same recordings once some effects are out of the question."""
        other = copy(self)
        other._settled = self._settled | frozenset(names)
        return other

    def compared(
        self, first: Contender, second: Contender, table: Mapping[str, Effect]
    ) -> Comparison:
        """How far apart two contenders are here."""
        one, two = table[first.signature.effect], table[second.signature.effect]
        target = self.shown(one, first.signature, first.values)
        size = float(np.sqrt(target @ target))
        if len(two.sizes) > 1:
            axes = self._axes(second, two)
            if size == 0.0 or not axes.any():
                return _seen_or_not(size, float(np.sqrt(np.sum(axes**2))))
            inside = orthonormal(axes, _RANK)
            copied = float(np.sqrt(np.sum((inside.T @ target) ** 2)))
            return Comparison(copied / size, float(np.sqrt(max(size**2 - copied**2, 0.0))))
        other = self.shown(two, second.signature, second.values)
        other_size = float(np.sqrt(other @ other))
        if size == 0.0 or other_size == 0.0:
            return _seen_or_not(size, other_size)
        cosine = float(abs(target @ other)) / (size * other_size)
        return Comparison(cosine, min(size, self._distance(target, second, two)))

    def shown(
        self, effect: Effect, signature: Signature, values: Mapping[str, float]
    ) -> FloatArray:
        """What an effect adds beside the calibration, in noise sd; zero where it hides.

        Where one planned cell stands for `n` that carry it, each is weighed: ``√n`` of that.
        """
        owners, stands_for = self._owners(signature, effect)
        whole = self._response(effect, owners, values)
        left = self._left(whole)
        if left @ left <= _SEEN**2 * (whole @ whole):
            return np.zeros_like(left)
        return np.asarray(left * self._weight * np.sqrt(stands_for))

    def _axes(self, rival: Contender, effect: Effect) -> FloatArray:
        """What each size of an effect adds at its usual value, shape (m, sizes)."""
        shapes = {p.name: rival.values[p.name] for p in effect.shapes if p.name in rival.values}
        return np.stack(
            [
                self.shown(effect, rival.signature, {**shapes, s.name: s.neutral + s.prior_sd})
                for s in effect.sizes
            ],
            axis=1,
        )

    def _distance(self, target: FloatArray, rival: Contender, effect: Effect) -> float:
        """Smallest distance of a target from a rival of any size."""
        squared = np.array(
            [
                np.sum((target - self.shown(effect, rival.signature, scaled)) ** 2)
                for scaled in (rival.scaled(effect, share) for share in _RIVAL_SIZES)
            ]
        )
        at = int(np.clip(np.argmin(squared), 1, squared.size - 2))
        near = slice(at - 1, at + 2)
        a, b, c = np.polyfit(_RIVAL_SIZES[near], squared[near], 2)
        lowest = c - b * b / (4.0 * a) if a > 0 else np.inf
        return float(np.sqrt(max(min(lowest, squared.min()), 0.0)))

    def _left(self, columns: FloatArray) -> FloatArray:
        left = columns.copy()
        for rows, basis in self._bases:
            left[rows] -= basis @ (basis.T @ columns[rows])
        return left

    def _owners(
        self, signature: Signature, effect: Effect
    ) -> tuple[dict[str, tuple[str, ...]], int]:
        """Who carries an effect on the planned channels; how many one planned cell stands for."""
        units = self._units(effect)
        owners = {
            owner: tuple(m for m in members if m in units) for owner, members in signature.owners
        }
        owners = {owner: members for owner, members in owners.items() if members}
        if owners:
            return owners, 1
        members = {m for _, carried in signature.owners for m in carried}
        return {"all": units}, max(len(members), 1)

    def _units(self, effect: Effect) -> tuple[str, ...]:
        return tuple(
            dict.fromkeys(u for g in self._logs for u in units_of(effect.scope, g.channels))
        )

    def _response(
        self, effect: Effect, owners: Mapping[str, tuple[str, ...]], values: Mapping[str, float]
    ) -> FloatArray:
        """What an effect adds to the balance of the planned logs, in noise sd, shape (m,)."""
        parts = []
        named = {f"{owner}.{name}": value for owner in owners for name, value in values.items()}
        acts = self._experiment.name in effect.experiments and effect.name not in self._settled
        for log, error, valid, noise in zip(
            self._logs, self._errors, self._valid, self._noise, strict=True
        ):
            change = np.zeros_like(error)
            if acts and all(name in log.known for name in effect.needs):
                shown, _ = Chain((Link(effect, owners),)).apply(log, named)
                balance = self._experiment.balance(shown)
                change = np.where(balance.valid, balance.error - error, 0.0)
            parts.append((np.nan_to_num(change) / noise)[valid])
        return np.concatenate(parts)

    def _calibration(self, names: Sequence[str], block: IntArray) -> list[Basis]:
        """Orthonormal columns of everything the user of this experiment calibrates, by block."""
        columns = [np.zeros((block.size, 0))]
        for name in names:
            effect = TABLE[name]
            for unit in self._units(effect):
                for size in effect.sizes:
                    value = {size.name: size.neutral + _STEP * size.prior_sd}
                    columns.append(self._response(effect, {unit: (unit,)}, value)[:, None])
        raw = np.hstack(columns)
        return [(block == b, orthonormal(raw[block == b], _RANK)) for b in np.unique(block)]

    def _size(self) -> int:
        return int(sum(valid.sum() for valid in self._valid))

    def _blocks(self) -> IntArray:
        """Block of each judged entry, shape (m,)."""
        parts = [
            np.broadcast_to(log.block[:, None], valid.shape)[valid] + 10**6 * i
            for i, (log, valid) in enumerate(zip(self._logs, self._valid, strict=True))
        ]
        return np.concatenate(parts)

    def _rate_hz(self) -> float:
        """Judged rows per second."""
        steps = [
            np.diff(log.time_s[valid.any(axis=1)])
            for log, valid in zip(self._logs, self._valid, strict=True)
        ]
        every = np.concatenate(steps)
        return 1.0 / max(float(np.median(every[every > 0])), 1e-9) if (every > 0).any() else 1.0


def _seen_or_not(first: float, second: float) -> Comparison:
    """Whether an effect is seen is the whole answer; one that is there has its present size."""
    return Comparison(0.0 if first or second else 1.0, max(first, second))


def rehearsed(plan: Plan, rig: Rig) -> Rehearsal:
    """A plan played through; a walk's calibration drifts and is free every `DRIFT_S`."""
    logs = plan.make(rig)
    drifts = plan.experiment.name == "walk"
    if drifts:
        logs = tuple(replace(log, block=(log.time_s // DRIFT_S).astype(np.int64)) for log in logs)
    return Rehearsal(plan.experiment, logs, rig, settled=plan.settles, free_in_blocks=drifts)


def present(case: Case, rig: Rig) -> Rehearsal:
    """The recordings at hand, as they would be had nothing been wrong and no noise been there."""
    ideal = balanced(case, case.values)
    logs = [case.chain.remove(log, case.values)[0] for log in ideal.logs]
    judged = [(log.block >= 0) & (np.arange(len(log)) % case.stride == 0) for log in logs]
    return Rehearsal(case.experiment, logs, rig, judged=judged, free_in_blocks=case.drifts)
