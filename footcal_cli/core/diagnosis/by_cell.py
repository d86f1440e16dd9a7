"""A cause of several cells with a value of its own in each, where that predicts blocks better.

Of the room of the diagnosis; `footcal_cli.core.diagnosis.comparison` asks.
"""

from __future__ import annotations

from dataclasses import replace

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.contenders import refitted_with
from footcal_cli.core.diagnosis.field import Field, white_loss
from footcal_cli.core.diagnosis.mixtures import LINEAR
from footcal_cli.core.diagnosis.rivals import Tried, as_fitted
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.inference.evidence import sign_flip_mean
from footcal_cli.core.inference.places import Owners, own_place
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.parameters import FloatArray

_SURE_CELLS = 2  # cells whose own size is sure to be something, where each has one


def in_each_cell(field: Field, best: Tried, rules: Rules) -> tuple[Cause, Refit, FloatArray]:
    """The same effect with a value per cell, where that predicts left-out blocks better."""
    subject, cause, loss = field.subject, best.cause, best.loss
    effect = subject.table[cause.signature.effect]
    own = own_place(subject.case, effect)
    # a shift along both axes in every cell is any linear mixture of the readings in the moments,
    # and crosstalk of every cell's own nearly so: what could copy every linear cause proves none
    if own is None or len(effect.sizes) > 1 or effect.name in LINEAR:
        return cause, best.fitted, loss
    where, owners = own
    if not _differs_by_cell(field, best, owners, rules):
        return cause, best.fitted, loss
    apart = replace(cause, signature=replace(cause.signature, where=where, owners=owners))
    fitted = refitted_with(subject, [*field.causes, apart], field.model)
    if not fitted.converged:  # so many sizes and shapes at once can follow anything
        return cause, best.fitted, loss
    bare = subject.bare(fitted, [*field.causes, apart])
    less = white_loss(subject.without_credit(bare, fitted), field.noise)
    neutral = next(p.neutral for p in effect.sizes if p.name == cause.signature.parameter)
    sure = sum(
        not interval.low <= neutral <= interval.high
        for name, interval in zip(fitted.names, fitted.intervals, strict=True)
        if name.rsplit(".", 1)[1] == cause.signature.parameter
    )
    # sizes that calibration can trade against each other are not distinguished
    if sure < _SURE_CELLS or sign_flip_mean(loss - less, field.signs) >= rules.alpha_name:
        return cause, best.fitted, loss
    return replace(apart, places=()), fitted, less


def _differs_by_cell(field: Field, best: Tried, owners: Owners, rules: Rules) -> bool:
    """Whether a size for each cell surely predicts better, to first order about the fitted one.

    What is not there to first order is no reason for a refit of all cells.
    """
    mine = as_fitted(best)
    each = field.subject.beside(best.fitted, [replace(mine, owners=(own,)) for own in owners])
    apart = best.bare.holding(each)
    gain = white_loss(best.bare, field.noise) - white_loss(apart, field.noise)
    return sign_flip_mean(gain, field.signs) < rules.alpha_name
