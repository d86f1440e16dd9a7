"""Which numbers of an extended model a refit moves, and how far at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.effects.contract import (
    OF_THE_LOGS,
    Effect,
    EffectParameter,
    GridOf,
    is_six_axis,
)
from footcal_cli.core.inference.linear import left_by, orthonormal
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.settings import beside_settings
from footcal_cli.core.parameters import FloatArray

_RCOND, _RANK = 1e-9, 1e-8
_PLACED = (*OF_THE_LOGS, GridOf.SPAN)
"""Grids of shapes that no step moves: the logs bring them, or a search beforehand finds them."""
_OF_ONE_ROBOT = ("N", "Nm")
"""Units whose usual size is that of a robot of some kilograms; a share is one of any robot's."""
_OF_ZEROS = (*_OF_ONE_ROBOT, "N/s", "Nm/s")
_SHAPE_SEEN = 0.2  # share of a shape's visible influence that no size can take over
_AXIS_SEEN = 0.05  # visible fraction from which a component that was not named is fitted too
_AXIS_TOLD = 2.0  # and sd of the noise by which its usual size must change the residual
_AXIS_SURE = 5.0  # or of the residual, which tells of it whatever is usual
_SHAPE_REACH = 2.0  # a shape moves at most by this factor per iteration
_SHAPE_ACTS = (
    1e-3  # change of the residual, in noise, below which a shape that doubles does nothing
)


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


def freed_of(effect: Effect, signature: Signature, *, drifts: bool = False) -> list[Freed]:
    """Sizes and shapes of an accepted effect, by owner.

    An offset has no reason to lie along one axis: all its components are freed. The reach of an
    axis stays on its grid: beyond, a play hardly gives way to loads of both signs, and is a gain.
    How a drift settles stays as it is where the calibration `drifts` too and takes that up.
    """
    freed = []
    for owner, units in signature.owners:
        placed = (*_PLACED, GridOf.LOAD) if is_six_axis(units) else _PLACED
        placed = (*placed, GridOf.RATE) if drifts else placed
        for p in effect.parameters:
            if p.unit not in ("channel", "block", "form") and p.grid_of not in placed:
                step = 0.02 * (abs(p.neutral) if p.shape and p.neutral else p.prior_sd)
                named = p.name == signature.parameter
                freed.append(Freed(f"{owner}.{p.name}", p, step, named))
    return freed


def seen(
    freed: Sequence[Freed], problem: Problem, columns: FloatArray, values: Mapping[str, float]
) -> list[Freed]:
    """Named sizes, their other axes where visible, and shapes that data tell from the sizes.

    Parameters
    ----------
    values
        Where the refit begins: what is forty usual sizes along one axis may be so along another.
    """
    freed = list(freed)
    calibration, columns = _beside_what_is_known(problem, columns)
    times = [
        abs(values[f.name] - f.parameter.neutral) / f.parameter.prior_sd
        for f in freed if f.named and not f.is_shape and f.parameter.unit in _OF_ONE_ROBOT
    ]  # fmt: skip
    usual = max(1.0, *times) if times else 1.0
    sizes = _sizes_seen(freed, problem, calibration, columns, usual)
    basis = np.hstack([calibration, columns[:, sizes]])
    kept = []
    for i, item in enumerate(freed):
        if not item.is_shape and not sizes[i]:
            continue
        if item.is_shape:
            whole = columns[:, i]
            alone = left_by(calibration, whole, _RCOND)
            left = left_by(basis, whole, _RCOND)
            if left @ left < _SHAPE_SEEN**2 * (alone @ alone):
                continue
        kept.append(item)
    return kept


def _beside_what_is_known(problem: Problem, columns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Calibration and columns with a row for each thing that was known of the calibration."""
    if problem.known is None:
        return problem.calibration, columns
    values, vectors = np.linalg.eigh(problem.known)
    known = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    nothing = np.zeros((len(known), columns.shape[1]))
    return np.vstack([problem.calibration, known]), np.vstack([columns, nothing])


def _sizes_seen(
    freed: Sequence[Freed],
    problem: Problem,
    calibration: FloatArray,
    columns: FloatArray,
    times: float,
) -> list[bool]:
    """Named sizes, and other axes that these data tell from the named ones and from each other.

    Those whose size, so many `times` the usual one, changes the residual; of zeros that move, also
    those that the residual surely shows.

    An axis that carries nothing but noise would be given the gain that makes its noise small; one
    that differs from the rest only by what does not repeat between settings would be given any.
    """
    named = [f.named and not f.is_shape for f in freed]
    fitted, settings = np.hstack([calibration, columns[:, named]]), problem.settings
    residual = np.pad(problem.residual, (0, len(columns) - len(problem.residual)))
    both = np.column_stack([columns, residual])
    if settings is None:
        basis = orthonormal(fitted, _RANK)
        both = both - basis @ (basis.T @ both)
    else:
        own = np.pad(settings.columns, ((0, len(columns) - len(settings.columns)), (0, 0)))
        groups = settings.rows(np.arange(len(settings.columns)))
        both = beside_settings(fitted, both, own, groups, settings.shown)
    left, rest = both[:, :-1], both[:, -1]
    sure = _AXIS_SURE * max(1.0, float(np.sqrt(np.mean(rest**2))))
    usual = times * np.array([f.parameter.prior_sd for f in freed])
    size = np.sqrt(np.sum(columns**2, axis=0))
    seen = list(named)
    for i in np.argsort(-usual * np.sqrt(np.sum(left**2, axis=0)), kind="stable"):
        shown = float(np.sqrt(left[:, i] @ left[:, i]))
        if freed[i].is_shape or named[i]:
            continue
        tells = shown * usual[i] > _AXIS_TOLD
        if freed[i].parameter.unit in _OF_ZEROS:  # of mixtures a gain would tell that is in none
            tells = tells or abs(left[:, i] @ rest) > sure * shown
        if shown > _AXIS_SEEN * size[i] and tells:
            seen[i] = True
            unit = left[:, i] / shown
            left = left - np.outer(unit, unit @ left)
    return seen


def around(value: float, item: Freed) -> tuple[float, float]:
    """A step down and up from a value, within what is allowed.

    A share of a large load may be a shape beyond its range: there only one way leads back.
    """
    low = max(value - item.step, min(item.parameter.lower, value))
    return low, min(value + item.step, max(item.parameter.upper, value))


def bounded(before: float, step: float, item: Freed) -> float:
    """A value after a step, within what is allowed; a shape moves by a factor at most."""
    after = before + step
    if item.is_shape:
        low, high = sorted((before / _SHAPE_REACH, before * _SHAPE_REACH))
        after = float(np.clip(after, low, high))
    margin = item.step if np.isfinite(item.parameter.lower) else 0.0
    low = item.parameter.lower + (margin if item.is_shape else 0.0)
    return float(np.clip(after, low, item.parameter.upper))


def acts(item: Freed, value: float, rms: float) -> bool:
    """Whether a shape that doubles would change anything at all; sizes always do.

    Parameters
    ----------
    rms
        Of its derivative, in units of the noise.
    """
    return not item.is_shape or rms * abs(value) > _SHAPE_ACTS
