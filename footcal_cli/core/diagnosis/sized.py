"""Whether what is named has a size, as surely as who asks wants it.

A cause that joins a model is something there, a further one beside it surely, and the only name of
an answer as surely as a name is to be.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects.contract import Effect, Scope, Trait
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.signatures import SWITCHES

_HALF = 0.5  # a switch that is not even half on is off
_SURE = 2.0
_SURELY_NOTHING = 9e-5
"""Chance of a normal variable beyond `_SURE` times its 95 % interval, 3.92 sd on either side."""
_NOTHING = 0.05  # p from which sizes may all be nothing: what was named has passed harder tests
_RCOND = 1e-9


def is_nothing(subject: Subject, causes: Sequence[Cause], model: Refit | None) -> bool:
    """Whether the interval of one sure cause holds its neutral value, on the final model.

    What one rival of a set says of its own size the others take from it.
    """
    sure = [cause for cause in causes if not cause.rivals]
    return model is not None and any(
        not is_something(cause, subject.table[cause.signature.effect], model) for cause in sure
    )


def is_sure(cause: Cause, effect: Effect, fitted: Refit) -> bool:
    """Whether a further cause is `_SURE` times its 95 % interval away from nothing.

    One size of it, or all together as improbably (`_SURELY_NOTHING`) nothing. Beside a foreign form
    of the first cause some size of some other effect always fits a little better; the linear proxy
    is family-wise sure of it, the refit of both is not.
    """
    neutral = next(p.neutral for p in effect.parameters if p.name == cause.signature.parameter)
    mine = [
        interval for name, interval in zip(fitted.names, fitted.intervals, strict=True)
        if name.rsplit(".", 1)[1] == cause.signature.parameter
    ]  # fmt: skip
    if not mine or any(abs(i.value - neutral) >= _SURE * 0.5 * (i.high - i.low) for i in mine):
        return True
    return _act_together(effect) and chance_of_nothing(effect, fitted) < _SURELY_NOTHING


def _act_together(effect: Effect) -> bool:
    """Whether all sizes of an effect may be judged at once, blocks being independent.

    What changes with time is fitted to noise that drifts, whose blocks are alike.
    """
    return len(effect.sizes) > 1 and Trait.TIMED not in effect.traits


def is_something(cause: Cause, effect: Effect, fitted: Refit) -> bool:
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


def all_are_something(causes: Sequence[Cause], table: Mapping[str, Effect], fitted: Refit) -> bool:
    """Whether each of several causes has a size on the model of all of them (`is_something`)."""
    return all(is_something(c, table[c.signature.effect], fitted) for c in causes)


def is_sized(
    effect: Effect,
    cause: Cause,
    intervals: Mapping[str, Interval],
    model: Refit | None,
    blocks: int,
    alpha: float,
) -> bool:
    """Whether a size of a single name is as surely not nothing as a name is to be.

    One of them at ``1 − α``; or all together where no block follows the one before. Switches are on
    or off.

    Parameters
    ----------
    effect, cause
        With the interval of its size, which holds what a calibration known before is off by.
    intervals
        95 % intervals of all sizes and shapes, by name.
    model
        On which they were fitted.
    blocks, alpha
        Of the log; α.
    """
    size = next(p for p in effect.sizes if p.name == cause.signature.parameter)
    if effect.name in SWITCHES or size.neutral != 0.0 or model is None:
        return True
    free = max(blocks - 1, 1)
    wider = float(chances.t_ppf(1.0 - 0.5 * alpha, free) / chances.t_ppf(0.975, free))
    others = {p.name for p in effect.sizes} - {size.name}
    sure = [i.sureness for name, i in intervals.items() if name.rsplit(".", 1)[1] in others]
    if max([cause.size.sureness, *sure]) >= wider:
        return True
    return _act_together(effect) and chance_of_nothing(effect, model) < alpha


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
