"""Refit of the whole non-linear model with a named effect in it, iterated to convergence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.chain import Chain
from footcal_cli.core.diagnosis.case import Case, Rows, balanced, residual
from footcal_cli.core.diagnosis.problem import Problem, Signature
from footcal_cli.core.diagnosis.scores import joint_sizes
from footcal_cli.core.diagnosis.signatures import extended_chain
from footcal_cli.core.diagnosis.whitening import Noise, noise_of, whitened_grams
from footcal_cli.core.effects.contract import OF_THE_LOGS, Effect, EffectParameter
from footcal_cli.core.evidence import Interval, jackknife_interval
from footcal_cli.core.parameters import FloatArray

MOST_ITERATIONS = 10
CONVERGED = 0.02
"""A step below this share of its own standard error ends the iteration."""
MODEL_ERROR = 0.05
"""Sd of a size fitted to a walk beyond the scatter of its blocks, as a share of the size: the
low-pass does not commute with a curve, and transitions are not quite balanced. Measured on
development walks."""
_SHAPE_SEEN = 0.2  # share of a shape's visible influence that no size can take over
_AXIS_SEEN = 0.05  # visible fraction from which a component that was not named is fitted too
_AXIS_TOLD = 2.0  # and sd of the noise by which its usual size must change the residual
_NEAR = 0.5  # step, in standard errors, below which all but sizes and shapes stays as it is
_SHAPE_REACH = 2.0  # a shape moves at most by this factor per iteration


@dataclass(frozen=True)
class Freed:
    """One number of the extended model that the refit moves; `named` is what was accepted."""

    name: str
    parameter: EffectParameter
    step: float
    named: bool

    @property
    def is_shape(self) -> bool:
        """Whether it only shapes the effect."""
        return self.parameter.shape


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
    columns
        Derivative of the residual by the fitted parameters, sign such that they add to the
        calibration columns, shape (m, len(names)).
    residual
        At the optimum, with the calibration refitted by the caller's columns, shape (m,).
    converged
        Whether the iteration ended by itself.
    """

    chain: Chain
    values: Mapping[str, float]
    names: tuple[str, ...]
    intervals: tuple[Interval, ...]
    columns: FloatArray
    residual: FloatArray
    converged: bool


def freed_of(effect: Effect, signature: Signature) -> list[Freed]:
    """Sizes and shapes of an accepted effect, by owner.

    An offset has no reason to lie along one axis: all its components are freed.
    """
    freed = []
    for owner, _ in signature.owners:
        for p in effect.parameters:
            if p.unit not in ("channel", "block") and p.grid_of not in OF_THE_LOGS:
                step = 0.02 * p.prior_sd if not p.shape else 0.02 * abs(p.neutral)
                named = p.name == signature.parameter
                freed.append(Freed(f"{owner}.{p.name}", p, step, named))
    return freed


def refit(
    case: Case,
    rows: Rows,
    problem: Problem,
    accepted: Sequence[tuple[Effect, Signature]],
    start: Mapping[str, float],
) -> Refit:
    """Gauss–Newton on sizes and shapes, calibration refitted in every step.

    Each step solves the generalised least squares of the diagnosis itself, so that slow noise and
    wandering calibration weigh as they did when the effect was named.

    Parameters
    ----------
    case, rows
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
        freed += freed_of(effect, signature)
    values = {**case.values, **start}
    ideal = balanced(case, values, chain)
    freed = _seen(freed, problem, _columns(ideal, rows, chain, values, freed))
    names = tuple(f.name for f in freed)
    converged, noise, moved = False, None, np.inf
    for _ in range(MOST_ITERATIONS):
        at = residual(case, rows, values, chain)
        if moved > _NEAR:
            # close to the optimum neither noise nor linearisation point moves any more
            ideal, noise = balanced(case, values, chain), None
        columns = _columns(ideal, rows, chain, values, freed)
        local = _local(problem, at, columns)
        noise = noise or noise_of(local)
        sizes, without = _solve(local, columns, noise)
        spread = np.sqrt((len(without) - 1) / len(without) * np.sum((without - sizes) ** 2, 0))
        moved = 0.0
        for i, item in enumerate(freed):
            before = values[item.name]
            values[item.name] = _bounded(before, float(sizes[i]), item)
            if not item.is_shape:
                moved = max(moved, abs(values[item.name] - before) / max(float(spread[i]), 1e-300))
        if moved < CONVERGED:
            converged = True
            break
    at = residual(case, rows, values, chain)
    columns = _columns(balanced(case, values, chain), rows, chain, values, freed)
    local = _local(problem, at, columns)
    sizes, without = _solve(local, columns, noise_of(local))
    moving = problem.tracking is not None
    intervals = tuple(
        _interval(f, values[f.name], without[:, i] - sizes[i], moving=moving)
        for i, f in enumerate(freed)
    )
    return Refit(chain, values, names, intervals, columns, at, converged)


def _interval(item: Freed, value: float, apart: FloatArray, *, moving: bool) -> Interval:
    """Scatter over blocks, and in a walk what no block can show: all share the model's error."""
    scatter = jackknife_interval(value, value + apart)
    if not moving or item.is_shape:
        return scatter
    model = 2.0 * MODEL_ERROR * abs(value - item.parameter.neutral)
    half = float(np.hypot(scatter.high - value, model))
    return Interval(value, value - half, value + half)


def _seen(freed: Sequence[Freed], problem: Problem, columns: FloatArray) -> list[Freed]:
    """Named sizes, their other axes where visible, and shapes that data tell from the sizes."""
    freed = list(freed)
    sizes = _sizes_seen(freed, problem, columns)
    basis = np.hstack([problem.calibration, columns[:, sizes]])
    norm = np.sqrt(np.sum(basis**2, axis=0))
    basis = basis[:, norm > 0] / norm[norm > 0]
    kept = []
    for i, item in enumerate(freed):
        if not item.is_shape and not sizes[i]:
            continue
        if item.is_shape:
            whole = columns[:, i]
            calibrated = problem.calibration
            alone = whole - calibrated @ np.linalg.lstsq(calibrated, whole, rcond=1e-9)[0]
            left = whole - basis @ np.linalg.lstsq(basis, whole, rcond=1e-9)[0]
            if left @ left < _SHAPE_SEEN**2 * (alone @ alone):
                continue
        kept.append(item)
    return kept


def _sizes_seen(freed: Sequence[Freed], problem: Problem, columns: FloatArray) -> list[bool]:
    """Named sizes, and other axes that these data tell from the named ones and from each other.

    An axis that carries nothing but noise would be given the gain that makes its noise small; one
    that differs from the rest only by what does not repeat between settings would be given any.
    """
    named = [f.named and not f.is_shape for f in freed]
    fitted = [problem.calibration, columns[:, named]]
    if problem.settings is not None:
        fitted.append(problem.settings.spread())
    basis = _orthonormal(np.hstack(fitted))
    usual = np.array([f.parameter.prior_sd for f in freed])
    left = columns - basis @ (basis.T @ columns)
    size = np.sqrt(np.sum(columns**2, axis=0))
    seen = list(named)
    for i in np.argsort(-usual * np.sqrt(np.sum(left**2, axis=0)), kind="stable"):
        shown = float(np.sqrt(left[:, i] @ left[:, i]))
        if freed[i].is_shape or named[i]:
            continue
        if shown > _AXIS_SEEN * size[i] and shown * usual[i] > _AXIS_TOLD:
            seen[i] = True
            unit = left[:, i] / shown
            left = left - np.outer(unit, unit @ left)
    return seen


def _orthonormal(columns: FloatArray) -> FloatArray:
    """Basis of what columns span, shape (m, rank)."""
    norm = np.sqrt(np.sum(columns**2, axis=0))
    u, s, _ = np.linalg.svd(columns[:, norm > 0] / norm[norm > 0], full_matrices=False)
    return np.asarray(u[:, s > 1e-8 * s.max(initial=0.0)])


def _columns(
    ideal: Case, rows: Rows, chain: Chain, values: Mapping[str, float], freed: Sequence[Freed]
) -> FloatArray:
    """What a change of each freed parameter adds to the residual, shape (m, freed)."""
    columns = []
    for item in freed:
        value = values[item.name]
        low = max(value - item.step, item.parameter.lower)
        high = min(value + item.step, item.parameter.upper)
        up = residual(ideal, rows, {**values, item.name: high}, chain)
        down = residual(ideal, rows, {**values, item.name: low}, chain)
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


def _solve(local: Problem, columns: FloatArray, noise: Noise) -> tuple[FloatArray, FloatArray]:
    """Generalised least squares on calibration and columns, and without each block."""
    grams, _ = whitened_grams(local, np.empty((local.residual.size, 0)), noise)
    sizes, without = joint_sizes(grams, grams.calibration, grams.candidates)
    scale = _rms(columns)
    return sizes / scale, without / scale


def _numbered(columns: FloatArray) -> tuple[Signature, ...]:
    return tuple(Signature("", "", str(i), "") for i in range(columns.shape[1]))


def _bounded(before: float, step: float, item: Freed) -> float:
    after = before + step
    if item.is_shape:
        low, high = sorted((before / _SHAPE_REACH, before * _SHAPE_REACH))
        after = float(np.clip(after, low, high))
    margin = item.step if np.isfinite(item.parameter.lower) else 0.0
    low = item.parameter.lower + (margin if item.is_shape else 0.0)
    return float(np.clip(after, low, item.parameter.upper))
