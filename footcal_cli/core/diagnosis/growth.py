"""One more cause: the best that stands its refit together with all others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.answer import Cause, Diagnosis
from footcal_cli.core.diagnosis.comparison import decided
from footcal_cli.core.diagnosis.engine import diagnose
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects.contract import Effect, Scope
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.signatures import SWITCHES
from footcal_cli.core.parameters import FloatArray

_HALF = 0.5  # a switch that is not even half on is off
_SURE = 2.0
_NOTHING = 0.05  # p from which sizes may all be nothing: what was named has passed harder tests
_RCOND = 1e-9


def grown_by_one(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit | None,
    current: Problem,
    answer: Diagnosis,
    start: float | None,
    seed: int,
) -> tuple[tuple[list[Cause], Refit] | None, Diagnosis]:
    """The model with one more cause: the best that stands its refit, and the answer it is of.

    What the linear proxy likes best may be nothing once all is refitted; the next best in the same
    family is then tried, a few times.

    Parameters
    ----------
    subject
        What is diagnosed.
    causes, model
        What was named, and the model with it; None without any.
    current, answer
        The problem on that model, and what the engine said of it.
    start
        Held-out squared error before anything was named.
    seed
        Of sign patterns.
    """
    first, failed, tries = answer, frozenset[str](), 0
    unsettled: tuple[tuple[list[Cause], Refit], Diagnosis] | None = None
    while answer.causes and tries < answer.rules.most_tries:
        cause, fitted = decided(subject, causes, model, answer, seed, failed)
        needed, fitted = _needed(subject, [*causes, cause], fitted)
        sure = not causes or _is_sure(cause, subject.table[cause.signature.effect], fitted)
        if cause in needed and len(needed) > len(causes):
            if not sure:
                break
            if fitted.converged:
                return (needed, fitted), answer
            unsettled = unsettled or ((needed, fitted), answer)
        failed |= {cause.signature.effect}
        if cause.signature.effect != answer.causes[0].signature.effect:
            continue  # a look-alike that is nothing itself says nothing of the named one
        tries += 1
        answer = diagnose(current, answer.rules, seed, start, failed)
    return unsettled or (None, first)


def at_an_end(subject: Subject, causes: Sequence[Cause], model: Refit | None) -> bool:
    """Whether a size stands at an end of its range: what is left then comes from the bound."""
    if model is None:
        return False
    for cause in causes:
        effect = subject.table[cause.signature.effect]
        size = next(p for p in effect.parameters if p.name == cause.signature.parameter)
        for owner, _ in cause.signature.owners:
            value = model.values[f"{owner}.{size.name}"]
            shape = {p.name: model.values[f"{owner}.{p.name}"] for p in effect.shapes}
            most = effect.largest(size, shape)
            if effect.name not in SWITCHES and not size.lower < value < most:
                return True
    return False


def is_nothing(subject: Subject, causes: Sequence[Cause], model: Refit | None) -> bool:
    """Whether the interval of one sure cause holds its neutral value, on the final model.

    What one rival of a set says of its own size the others take from it.
    """
    sure = [cause for cause in causes if not cause.rivals]
    return model is not None and any(
        not _is_something(cause, subject.table[cause.signature.effect], model) for cause in sure
    )


def named_columns(model: Refit | None, causes: Sequence[Cause]) -> FloatArray:
    """What the named sizes add to the residual at the optimum, shape (m, k)."""
    if model is None:
        return np.empty((0, 0))
    sizes = {c.signature.parameter for c in causes}
    named = [i for i, name in enumerate(model.names) if name.rsplit(".", 1)[1] in sizes]
    return model.columns[:, named]


def _needed(
    subject: Subject,
    causes: Sequence[Cause],
    fitted: Refit,
) -> tuple[list[Cause], Refit]:
    """Causes whose sizes are something once all are in the model, refitted without the others."""
    kept = [c for c in causes if _is_something(c, subject.table[c.signature.effect], fitted)]
    if len(kept) == len(causes) or not kept:
        return kept, fitted
    names = {p.name for c in kept for p in subject.table[c.signature.effect].parameters}
    start = {
        n: v for n, v in fitted.values.items()
        if n not in subject.case.values and n.rsplit(".", 1)[1] in names
    }  # fmt: skip
    return kept, subject.refitted(kept, start)


def _is_sure(cause: Cause, effect: Effect, fitted: Refit) -> bool:
    """Whether a further cause is `_SURE` times its 95 % interval away from nothing.

    Beside a foreign form of the first cause some size of some other effect always fits a little
    better; the linear proxy is family-wise sure of it, the refit of both is not.
    """
    neutral = next(p.neutral for p in effect.parameters if p.name == cause.signature.parameter)
    mine = [
        interval for name, interval in zip(fitted.names, fitted.intervals, strict=True)
        if name.rsplit(".", 1)[1] == cause.signature.parameter
    ]  # fmt: skip
    return not mine or any(abs(i.value - neutral) >= _SURE * 0.5 * (i.high - i.low) for i in mine)


def _is_something(cause: Cause, effect: Effect, fitted: Refit) -> bool:
    """Whether the interval of one of its sizes excludes the neutral value."""
    parameter = next(p for p in effect.parameters if p.name == cause.signature.parameter)
    intervals = [
        interval for name, interval in zip(fitted.names, fitted.intervals, strict=True)
        if name.rsplit(".", 1)[1] == parameter.name
    ]  # fmt: skip
    if effect.name in SWITCHES and intervals and not any(i.high >= _HALF for i in intervals):
        return False
    if effect.name in SWITCHES or not np.isfinite(parameter.neutral) or not intervals:
        return True
    if effect.scope is Scope.ROBOT and any(
        i.value <= parameter.lower or i.value >= parameter.upper for i in intervals
    ):
        # a belief driven to the end of its range only trades against a calibration that drifts
        return False
    if any(not i.low <= parameter.neutral <= i.high for i in intervals):
        return True
    return len(effect.sizes) > 1 and chance_of_nothing(effect, fitted) < _NOTHING


def chance_of_nothing(effect: Effect, fitted: Refit) -> float:
    """Probability that all sizes of an effect are neutral; 1 where too few blocks say.

    Couplings of one transducer that calibration turns into each other are each unsure. Hotelling's
    T² with the covariance that leaving out blocks shows:
    ``(B − k) T² / (k (B − 1)) ~ F(k, B − k)``.
    """
    neutral = {p.name: p.neutral for p in effect.sizes}
    mine = [i for i, name in enumerate(fitted.names) if name.rsplit(".", 1)[1] in neutral]
    off = np.array([fitted.values[fitted.names[i]] - neutral[fitted.names[i].rsplit(".", 1)[1]]
                    for i in mine])  # fmt: skip
    apart = fitted.scatter.apart[:, mine]
    blocks, count = apart.shape
    if blocks <= count:
        return 1.0
    spread = apart.T @ apart * (blocks - 1) / blocks
    squared = float(off @ scaled_inverse(spread, _RCOND) @ off)
    f = (blocks - count) * squared / (count * (blocks - 1))
    return float(chances.f_sf(f, count, blocks - count))
