"""Refit of the whole non-linear model with a named effect in it, iterated to convergence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footcal_cli.core.chain import Chain, Seen
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.case import Case, residual
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.freed import Freed, acts, around, bounded, freed_of, seen
from footcal_cli.core.inference.grams import Grams, whitened_grams
from footcal_cli.core.inference.ideal import balanced
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.scatter import Scatter, scatter_of
from footcal_cli.core.inference.scores import joint_sizes, sizes_together
from footcal_cli.core.inference.signatures import extended_chain
from footcal_cli.core.inference.whitening import Noise, Within, law_of_noise
from footcal_cli.core.parameters import FloatArray, IntArray

MOST_ITERATIONS = 10
CONVERGED = 0.02
"""A step below this share of its own standard error ends the iteration."""
SETTLED = 0.3
"""A step below this share at its last round leaves the iteration converged: it adds less than 5 %
to an RMS error in standard errors, and noise that is estimated anew may swing for ever."""
_SHARES = (1.0, 0.3, 0.09, 0.027)
"""Of a step, tried until less is left to go."""
_ALIKE = 0.6  # |cos| between two steps from which they creep along one line, or swing
_RELAXED = (0.1, 10.0)  # share of a step that may be taken along such a line
_LEAST_SPREAD = 1e-6  # of the step of a derivative: logs without noise have no scatter
_LARGER = 1.5  # factor by which a shape that does nothing at the start is enlarged
_MOST_ENLARGED = 4


@dataclass(frozen=True)
class Refit:
    """The extended model at its optimum.

    Parameters
    ----------
    chain, values
        With the effects in.
    names
        Effect parameters that were fitted.
    intervals
        95 % intervals over blocks, one per name.
    scatter
        What they are made of.
    columns
        Derivative of the residual by the fitted parameters, sign such that they add to the
        calibration columns, shape (m, len(names)).
    residual
        At the optimum, with the calibration refitted by the caller's columns, shape (m,).
    judged
        As `ideal`; the judged rows alone where the model has no memory.
    converged
        Whether the way that is left is short (`SETTLED`).
    baseline
        The case that was fitted, without the model.
    """

    chain: Chain
    values: Mapping[str, float]
    names: tuple[str, ...]
    intervals: tuple[Interval, ...]
    scatter: Scatter
    columns: FloatArray
    residual: FloatArray
    judged: Case
    converged: bool
    baseline: Case

    @cached_property
    def ideal(self) -> Case:
        """The recordings as they would be had nothing but the model been wrong, without noise."""
        if self.judged.stride == self.baseline.stride:
            return self.judged
        whole = balanced(self.baseline, self.values, self.chain)
        return whole.extended(self.chain, self.values)


def refit(
    case: Case,
    problem: Problem,
    accepted: Sequence[tuple[Effect, Signature]],
    start: Mapping[str, float],
) -> Refit:
    """Sizes and shapes from which no Gauss–Newton step leads away, calibration refitted in each.

    Each step solves the generalised least squares of the diagnosis itself, so that slow noise and
    wandering calibration weigh as they did when the effect was named. Columns are taken where there
    is no noise, and the noise is estimated anew: the step s(θ) is not that of any squared error,
    and steps alone creep or swing. Where two are along one line, the secant through both says how
    far to go; else what the step promises does. The point with the shortest step is kept.

    Parameters
    ----------
    case
        The baseline (without the accepted effects).
    problem
        Built on the baseline; its residual and columns are replaced.
    accepted
        Effects with their places, in order.
    start
        Values of their parameters to start from.
    """
    chain = case.chain
    freed: list[Freed] = []
    for effect, signature in accepted:
        chain = extended_chain(chain, effect, signature)
        freed += freed_of(effect, signature, drifts=problem.drifts)
    values = {**case.values, **start}
    memory = case.memory()
    left = residual(case, problem, values, chain, seen=memory)
    ideal = balanced(case, values, chain, judged=True, seen=memory)
    columns = _columns(ideal, problem, chain, values, freed)
    kept = seen(freed, problem, columns, values)
    fit = _Fit(case, problem, problem.within, chain, tuple(kept), memory)
    columns = columns[:, [f in kept for f in freed]]
    at = fit.awake(fit.linearised(values, left, ideal, columns))
    way, share = _step(at, fit.freed), 1.0
    best, before = (at, way), way
    for iteration in range(MOST_ITERATIONS):
        if way.furthest() < CONVERGED:
            break
        alike = iteration > 0 and abs(way.cosine(before)) > _ALIKE
        share = way.relaxed(before, share) if alike else fit.nearer(at, way)
        at, before = fit.at(_moved(at, share * way.size, fit.freed)), way
        way = _step(at, fit.freed)
        if way.length(best[1]) < best[1].length():
            best = at, way
    at, way = best
    scale = _rms(at.columns)
    live = [i for i, f in enumerate(fit.freed) if acts(f, at.values[f.name], scale[i])]
    moving = problem.tracking is not None
    scatter = scatter_of(
        at.grams, np.array(live, dtype=np.int64), scale, moving=moving, known=problem.known
    )
    intervals = tuple(
        scatter.interval(
            v, one, 0.0 if f.is_shape else scatter.shared * abs(v - f.parameter.neutral)
        )
        for f, v, one in zip(
            fit.freed, (at.values[f.name] for f in fit.freed), np.eye(len(fit.freed)), strict=True
        )
    )
    names = tuple(f.name for f in fit.freed)
    return Refit(
        chain, at.values, names, intervals, scatter, at.columns, at.residual,
        at.ideal.extended(chain, at.values), way.furthest() < SETTLED, case,
    )  # fmt: skip


@dataclass(frozen=True)
class _Point:
    """The extended model at some values, linearised.

    Parameters
    ----------
    values, ideal, noise
        Of the model; the logs without noise at which columns are taken; the noise.
    residual, columns
        Shapes (m,) and (m, freed).
    grams
        In the metric of the noise; its candidates are the columns, scaled to unit size.
    """

    values: dict[str, float]
    ideal: Case
    noise: Noise
    residual: FloatArray
    columns: FloatArray
    grams: Grams


@dataclass(frozen=True)
class _Fit:
    """What is fitted to what.

    Parameters
    ----------
    within
        Of the problem, whatever its residual.
    memory
        What the chain was removed from, for values that come again.
    """

    case: Case
    problem: Problem
    within: Within
    chain: Chain
    freed: tuple[Freed, ...]
    memory: Sequence[Seen]

    def at(self, values: Mapping[str, float]) -> _Point:
        """The model at some values."""
        left = self.left(values)
        ideal = balanced(self.case, values, self.chain, judged=True, seen=self.memory)
        columns = _columns(ideal, self.problem, self.chain, values, self.freed)
        return self.linearised(values, left, ideal, columns)

    def left(self, values: Mapping[str, float]) -> FloatArray:
        """The residual at some values, shape (m,)."""
        return residual(self.case, self.problem, values, self.chain, seen=self.memory)

    def linearised(
        self,
        values: Mapping[str, float],
        left: FloatArray,
        ideal: Case,
        columns: FloatArray,
    ) -> _Point:
        """The model with its residual and given columns, taken at its ideal recordings."""
        local = _local(self.problem, left, columns)
        noise = law_of_noise(local, self.within)
        grams, _ = whitened_grams(local, np.empty((left.size, 0)), noise, counted=False)
        return _Point(dict(values), ideal, noise, left, columns, grams)

    def awake(self, start: _Point) -> _Point:
        """The start, its shapes enlarged until they act: from a standstill no step leads away.

        The reach of a play that is less than the smallest step of load changes nothing.
        """
        at = start
        for _ in range(_MOST_ENLARGED):
            scale = _rms(at.columns)
            idle = [f.name for f, s in zip(self.freed, scale, strict=True)
                    if not acts(f, at.values[f.name], s)]  # fmt: skip
            if not idle:
                return at
            at = self.at({k: _LARGER * v if k in idle else v for k, v in at.values.items()})
        return start

    def nearer(self, at: _Point, way: _Step) -> float:
        """The largest part of a step that leaves less to go; the least one if none does.

        What is left to go is measured with the old columns and noise: Deuflhard's natural
        monotonicity test, Newton Methods for Nonlinear Problems (2004). A squared error would not
        do: columns are taken where there is no noise, so the fit does not minimise it.
        """
        scale, spread = _rms(at.columns)[way.free], way.spread[way.free]
        before = way.size[way.free] / spread
        for share in _SHARES:
            left = self.left(_moved(at, share * way.size, self.freed))
            local = _local(self.problem, left, at.columns)
            grams, _ = whitened_grams(local, np.empty((left.size, 0)), at.noise, counted=False)
            to_go = sizes_together(grams, grams.calibration, grams.candidates[way.free])
            after = to_go / scale / spread
            if after @ after <= before @ before:
                break
        return share


@dataclass(frozen=True)
class _Step:
    """Change of each number, its scatter over blocks, and which are free to move; (freed,)."""

    size: FloatArray
    spread: FloatArray
    free: IntArray

    def furthest(self) -> float:
        """The largest change, in standard errors."""
        return float(np.max(np.abs(self.size) / self.spread, initial=0.0))

    def length(self, other: _Step | None = None) -> float:
        """Length in standard errors, its own or those of another step."""
        return float(np.linalg.norm(self.size / (other or self).spread))

    def cosine(self, before: _Step) -> float:
        """Of the angle to the step before, in standard errors."""
        product = (self.size / self.spread) @ (before.size / self.spread)
        return float(product / max(self.length() * before.length(self), 1e-300))

    def relaxed(self, before: _Step, share: float) -> float:
        """Share of this step to take, where that share of the one before was taken.

        ``ω = ω₀ s₀·(s₀ − s) / |s₀ − s|²``: a secant of the one number along which both are (Irons
        and Tuck, Int. J. Numer. Methods Eng. 1, 1969).
        """
        old = before.size / self.spread
        less = old - self.size / self.spread
        return float(np.clip(share * (old @ less) / max(float(less @ less), 1e-300), *_RELAXED))


def _step(at: _Point, freed: Sequence[Freed]) -> _Step:
    """Generalised least squares within the bounds.

    What would leave its bounds stops there, and the others are fitted to that.
    """
    scale = _rms(at.columns)
    step, spread = np.zeros(len(freed)), np.full(len(freed), np.inf)
    least = np.array([_LEAST_SPREAD * f.step for f in freed])
    free = np.array(
        [i for i, f in enumerate(freed) if acts(f, at.values[f.name], scale[i])], dtype=int
    )
    while free.size:
        held = np.setdiff1d(np.arange(len(freed)), free)
        less = at.grams.inner.less(at.grams.candidates[held], (step * scale)[held])
        grams = replace(at.grams, inner=less)
        sizes, without = joint_sizes(grams, grams.calibration, grams.candidates[free])
        step[free] = sizes / scale[free]
        blocks = len(without)
        scatter = np.sqrt((blocks - 1) / blocks * np.sum((without - sizes) ** 2, axis=0))
        spread[free] = np.maximum(scatter / scale[free], least[free])
        allowed = np.array(
            [bounded(at.values[f.name], s, f) for f, s in zip(freed, step, strict=True)]
        )
        allowed -= np.array([at.values[f.name] for f in freed])
        out = free[np.abs(allowed - step)[free] > 1e-9 * np.abs(step)[free]]
        step[out] = allowed[out]
        free = np.setdiff1d(free, out)
        if not out.size:
            break
    return _Step(step, spread, free)


def _moved(at: _Point, by: FloatArray, freed: Sequence[Freed]) -> dict[str, float]:
    """Values after a change of the freed numbers (freed,), within what is allowed."""
    after = {
        f.name: bounded(at.values[f.name], float(d), f) for f, d in zip(freed, by, strict=True)
    }
    return {**at.values, **after}


def _columns(
    ideal: Case, rows: Problem, chain: Chain, values: Mapping[str, float], freed: Sequence[Freed]
) -> FloatArray:
    """What a change of each freed parameter adds to the residual, shape (m, freed)."""
    columns, seen = [], ideal.memory()
    for item in freed:
        value = values[item.name]
        low, high = around(value, item)
        up = residual(ideal, rows, {**values, item.name: high}, chain, seen=seen)
        down = residual(ideal, rows, {**values, item.name: low}, chain, seen=seen)
        columns.append(-(up - down) / max(high - low, 1e-300))
    return np.stack(columns, axis=1)


def _local(problem: Problem, at: FloatArray, columns: FloatArray) -> Problem:
    """The problem at a point, with columns of unit size as its candidates."""
    return replace(
        problem, residual=at, columns=columns / _rms(columns), signatures=_numbered(columns)
    )


def _rms(columns: FloatArray) -> FloatArray:
    scale = np.sqrt(np.mean(columns**2, axis=0))
    return np.asarray(np.where(scale > 0, scale, 1.0))


def _numbered(columns: FloatArray) -> tuple[Signature, ...]:
    return tuple(Signature("", "", str(i), "") for i in range(columns.shape[1]))
