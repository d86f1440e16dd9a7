"""Sizes that only a bound stops; of single cells, at zero, as no cause could have the other sign.

A cell may lag and cannot lead. What makes one cell lead (a loose mass that swings after each
impact) looks like a lag of the others, and with a size for every cell the one that leads is held
at zero. The linear model beside it knows no such end: there the held size takes its wrong sign, and
nothing seems to be left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.unnamed import Unnamed, left_beside
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.signatures import SWITCHES
from footcal_cli.core.parameters import BoolArray, FloatArray

_AT = 1e-3
"""Distance from zero, in prior sd, below which a size stands there."""


def held_at_zero(model: Refit, effects: Sequence[Effect], causes: Sequence[Cause]) -> BoolArray:
    """Which fitted parameters are sizes of one of several cells held at zero, shape (k,).

    Parameters
    ----------
    model
        The refit of all causes.
    effects
        Of the causes, one each.
    causes
        The named causes.
    """
    held = np.zeros(len(model.names), dtype=bool)
    for cause, effect in zip(causes, effects, strict=True):
        owners = cause.signature.owners
        size = next(p for p in effect.sizes if p.name == cause.signature.parameter)
        if len(owners) < 2 or size.neutral not in (size.lower, size.upper):
            continue
        for owner, _ in owners:
            name = f"{owner}.{size.name}"
            if abs(model.values[name] - size.neutral) < _AT * size.prior_sd:
                held[model.names.index(name)] = True
    return held


def against_other_sign(
    after: Problem, columns: FloatArray, held: BoolArray, signs: FloatArray
) -> Unnamed:
    """Judge the named causes by what sizes held at zero would explain with the other sign.

    A small share may be what the form of the others gets wrong.

    Parameters
    ----------
    after
        The problem on the extended model.
    columns
        What each fitted parameter adds, shape (m, k).
    held
        From `held_at_zero`.
    signs
        Sign patterns of the blocks.
    """
    free = unit_columns(columns[:, ~held])
    rivals = after.fitted[:, after.calibration.shape[1] + unit_columns(columns).shape[1] :]
    bound = replace(after, accepted=np.hstack([free, rivals]))
    left = left_beside(bound, (unit_columns(columns[:, held]),), signs)
    return Unnamed(left, rival=False)


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
            least, most = effect.least(size, shape), effect.largest(size, shape)
            if effect.name not in SWITCHES and not least < value < most:
                return True
    return False
