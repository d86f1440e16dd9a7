"""Contenders that look like each other: what each leaves, and which is out beside the best."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.curves import explained
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.unnamed import CURVES
from footcal_cli.core.diagnosis.weighing import has_few_blocks, of_one_form_p, single_rows_p
from footcal_cli.core.effects import having
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.core.inference.evidence import (
    Interval,
    effective_blocks,
    jackknife_interval,
    largest_excess,
    local_max_t,
    sign_flip_group,
    sign_flip_max_t,
)
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.scores import scores
from footcal_cli.core.inference.whitening import Noise, has_single_rows
from footcal_cli.core.parameters import FloatArray

SMOOTH = having(Trait.SMOOTH)
"""Curves of one number. Against a knee, which has its place too, they count together: only where
the sharp knee adds something beside both is a smooth curve out."""
_MOST = 500.0  # exponent of odds
_OUT = 0.01  # odds at which a cause is out


@dataclass(frozen=True)
class Tried:
    """One contender in its own full refit.

    Parameters
    ----------
    cause, fitted
        The contender and the model with it.
    loss
        Held-out squared error of each block in the metric of the common noise, shape (B,).
    bare
        The problem that it leaves.
    p
        That nothing of the family of look-alikes is left beside it.
    misfit
        How much of the squared error that family could take from it at most.
    """

    cause: Cause
    fitted: Refit
    loss: FloatArray
    bare: Problem
    p: float
    misfit: float


def left_of(
    bare: Problem, family: FloatArray, noise: Noise, signs: FloatArray
) -> tuple[float, float]:
    """The p that a refitted model leaves nothing of its family, and how much it may leave."""
    grams, _ = whitened_grams(bare, family, noise)
    found = scores(grams.inner, grams.calibration, grams.features)
    taken, freedom = explained(grams, grams.calibration, grams.features)
    return sign_flip_group(found.score, signs), largest_excess(taken, freedom)


def excess_of(other: FloatArray, best: FloatArray) -> Interval:
    """``√(Σ other / Σ best) − 1``, the relative excess of an RMS error, with its interval.

    Parameters
    ----------
    other, best
        Squared held-out error of each block, shape (B,).
    """

    def excess(of_other: float, of_best: float) -> float:
        return float(np.sqrt(max(of_other, 1e-300) / max(of_best, 1e-300))) - 1.0

    others, bests = other.sum() - other, best.sum() - best
    without = np.array([excess(a, b) for a, b in zip(others, bests, strict=True)])
    return jackknife_interval(excess(other.sum(), best.sum()), without)


def likelier(best: FloatArray, other: FloatArray, noise: Noise, odds: float) -> bool:
    """Whether blocks that had no say are so many times as probable under the best.

    ``exp(−(L − L₀)/2s) < odds`` with s the larger of two scales, and no less than one: the mean
    square that the best leaves per row, since a law of noise that is too small makes nothing surer,
    and how much more the blocks' differences d scatter than those of two models of which one is
    right, whose variance is ``4 s Σ d``: ``Σ (d − d̄)² B/(B − 1) / (4 Σ d)``. No single block may
    decide.

    Parameters
    ----------
    best, other
        Held-out squared error of each block in the metric of the noise, L₀ and L, shape (B,).
    odds
        Below which the other one is out.
    """
    lost = other - best
    scale = _scale(best, noise)
    total = float(lost.sum())
    least = total - max(float(lost.max(initial=0.0)), 0.0)
    if not least > 0.0:
        return False
    scatter = float(np.var(lost, ddof=1)) * lost.size / (4.0 * total)
    return total > float(-2.0 * np.log(odds)) * max(scale, scatter)


def _scale(best: FloatArray, noise: Noise) -> float:
    """Mean square that a model leaves per row, and no less than one."""
    return max(float(best.sum()) / noise.whitener.kept.size, 1.0)


def odds_of(best: FloatArray, other: FloatArray, noise: Noise, form: float = 0.0) -> float:
    """How many times as probable blocks that had no say are under another model as under the best.

    ``exp(−Σ d/2s)`` of the blocks' differences ``d = L − L₀``, in noise of the mean square s that
    the best leaves per row, and no less than one; but no surer than their scatter lets the sign of
    their mean be, ``F(−t)/F(t)`` with Student's distribution F and ``t = √B d̄/sd(d)``, and no surer
    than ``0.01^(Σ d/form)``, since the form of a true cause is never quite the table's.

    Parameters
    ----------
    best, other
        Held-out squared error of each block in the metric of the noise, L₀ and L, shape (B,).
    form
        Squared error that a wrong form may cost a true cause; 0 where forms are exact.
    """
    lost = other - best
    spread = float(np.std(lost, ddof=1)) if lost.size > 1 else 0.0
    if not spread > 0.0:
        return 1.0
    t = float(lost.mean()) / spread * np.sqrt(lost.size)
    freedom = lost.size - 1
    by_sign = float(chances.t_logcdf(-t, freedom) - chances.t_logcdf(t, freedom))
    total = float(lost.sum())
    by_form = float(np.log(_OUT)) * total / form if form > 0.0 else -np.inf
    surest = min(by_sign, -0.5 * total / _scale(best, noise), by_form, key=abs)
    return float(np.exp(np.clip(surest, -_MOST, _MOST)))


def said_alike(table: Mapping[str, Effect], one: Cause, other: Cause) -> bool:
    """Whether the table says that one looks like the other."""
    a, b = table[one.signature.effect], table[other.signature.effect]
    return b.name in a.mimics or a.name in b.mimics


def level_of(one: Cause, other: Cause, rules: Rules) -> float:
    """Level at which one of two look-alikes is out: curves have their own."""
    curves = {one.signature.effect, other.signature.effect} <= CURVES
    return rules.alpha_curve if curves else rules.alpha_left


def of_two_classes(one: Cause, other: Cause) -> bool:
    """Whether both are curves, a smooth one and one with a knee."""
    both = {one.signature.effect, other.signature.effect}
    return both <= CURVES and len(both & SMOOTH) == 1


def share_for_form(best: Tried, fitting: float, rules: Rules) -> float:
    """Share of the gain that its form may cost a curve more than the best one's.

    Where the best one's form is wrong as well, the truth is neither.

    Parameters
    ----------
    fitting
        That share where the best one's form fits: `Rules.other_form` for a curve of the other
        class. Of two knees `Rules.rival_loss`: they are one curve where loads are of one sign,
        and where these pull too they are not at all alike.
    """
    return rules.wrong_form if best.p < rules.alpha_left else fitting


def outdone(
    subject: Subject,
    other: Tried,
    best: Tried,
    family: Sequence[Signature],
    noise: Noise,
    signs: FloatArray,
    rules: Rules,
) -> bool:
    """Whether a contender like the best is out, since the best still adds something beside it.

    If the other one were the truth, the score of the best one's signature beside it would be
    noise: one direction, where all that its kind could explain has many. But of two wrong curves
    the nearer one adds something beside the other too. So the best must leave nothing, with power:
    what its kind could still explain, at most, must be less than a share of what it adds.
    """
    if best.p < rules.alpha_whole or not said_alike(subject.table, best.cause, other.cause):
        return False
    smooth = best.cause.signature.effect in SMOOTH
    beside = [] if smooth else partners_of(other.cause, family)
    p, added = adding_p(subject, best, other, family, beside, noise, signs)
    return p < level_of(best.cause, other.cause, rules) and best.misfit < rules.misfit_share * added


def adds_more(
    subject: Subject,
    best: Tried,
    other: Tried,
    family: Sequence[Signature],
    noise: Noise,
    signs: FloatArray,
    rules: Rules,
) -> bool:
    """Whether the best adds something beside a contender that adds little or nothing beside it.

    A loss difference holds the same evidence with twice the noise, and the turns of one leg have
    few signs. Of two wrong causes each adds something beside the other: the most that the other
    one may add (95 %) must be less than a share of what the best one adds.
    """
    p, added = adding_p(subject, best, other, family, [], noise, signs)
    if p >= rules.alpha_left:
        return False
    _, back = adding_p(subject, other, best, family, [], noise, signs)
    return largest_excess(back, 1) < rules.misfit_share * added


def adding_p(
    subject: Subject,
    best: Tried,
    other: Tried,
    family: Sequence[Signature],
    beside: Sequence[Signature],
    noise: Noise,
    signs: FloatArray,
) -> tuple[float, float]:
    """The p that the best adds nothing beside another one, and the squared error that it takes.

    Parameters
    ----------
    family
        Signatures of all look-alikes.
    beside
        What stands by the other one.
    """
    mine = as_fitted(best)
    taken = subject.beside(other.fitted, beside)
    columns = subject.beside(other.fitted, [mine])
    if not columns.size:
        return 1.0, 0.0
    alike = subject.beside(other.fitted, _elsewhere(mine, subject.problem.signatures))
    wide = np.hstack([alike, subject.beside(other.fitted, family)])
    bare = other.bare.holding(taken) if taken.size else other.bare
    grams, _ = whitened_grams(bare, np.hstack([columns, wide]), noise)
    found = scores(grams.inner, grams.calibration, grams.features)
    if found.inside[0]:
        return 1.0, 0.0
    p = float(sign_flip_max_t(found.score[:, :1], signs).p[0])
    if bare.turned:
        # white between turns and hangings: how far they scatter all legs tell together
        legs = 1 + alike.shape[1]
        p = float(local_max_t(found.score[:, :legs], found.information[:, :legs], 1.0)[1][0])
    elif has_single_rows(bare):
        single = single_rows_p(bare, found, grams.calibration.size)[0]
        p = min(2.0 * min(p, float(single)), 1.0)
    elif has_few_blocks(bare, float(effective_blocks(found.information[:, :1])[0])):
        one = np.zeros(1 + alike.shape[1], dtype=np.int64)
        p = float(
            of_one_form_p(found.score[:, : one.size], found.information[:, : one.size], one)[0]
        )
    added = float(found.score[:, 0].sum() ** 2 / found.information[:, 0].sum())
    return p, added


def _elsewhere(mine: Signature, signatures: Iterable[Signature]) -> list[Signature]:
    """The same size, in the same shape, of other sensors."""
    many = [len(units) for _, units in mine.owners]
    places = {
        s.where: replace(s, shape=mine.shape)
        for s in signatures
        if (s.effect, s.parameter) == (mine.effect, mine.parameter)
        and [len(units) for _, units in s.owners] == many
    }
    return [s for where, s in places.items() if where != mine.where]


def as_fitted(tried: Tried) -> Signature:
    """The signature of a contender in the shape that its refit found."""
    signature = tried.cause.signature
    owner = signature.owners[0][0]
    shape = ((name, tried.fitted.values.get(f"{owner}.{name}", value))
             for name, value in signature.shape)  # fmt: skip
    return replace(signature, shape=tuple(shape))


def partners_of(cause: Cause, signatures: Iterable[Signature]) -> list[Signature]:
    """The other smooth curve in the place of a smooth one, which it stands by against a knee."""
    mine = cause.signature
    others = SMOOTH - {mine.effect} if mine.effect in SMOOTH else frozenset()
    return [s for s in signatures if s.effect in others and s.where == mine.where]
