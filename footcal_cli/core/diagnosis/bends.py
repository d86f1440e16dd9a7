"""A named curve of one axis against any other curve of that axis.

Among load cells the table has several curves, and each is held against the others. Transducers and
poses leave one of them, which then wins against nothing: a foot that folds loses force on both
sides, nearly as a parabola does. Whether a size is the same everywhere (`form_of`) is asked of
every recorded signal at once, where what one axis tells drowns. Asked of its own readings alone,
piecewise straight between knees, a curve that is not the named one shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.linalg import norm

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.answer import Cause, Diagnosis
from footcal_cli.core.diagnosis.curves import explained_p
from footcal_cli.core.diagnosis.form import Form
from footcal_cli.core.diagnosis.rivals import Tried
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.unnamed import (
    CURVES,
    KNEES,
    Unnamed,
    knees_at,
    left_beside,
    loads_of,
)
from footcal_cli.core.effects import having
from footcal_cli.core.effects.contract import Trait, is_six_axis
from footcal_cli.core.inference.case import Case, channels_of
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.scores import scores
from footcal_cli.core.inference.whitening import Noise, has_single_rows
from footcal_cli.core.parameters import FloatArray

GAINS = having(Trait.AXIS_GAIN)
"""Names of a straight curve of each axis."""


@dataclass(frozen=True)
class Bends:
    """Piecewise straight curves of some axes.

    Parameters
    ----------
    straight
        Gain and offset of each axis: a curve about another zero differs by these, and who finds
        them left finds no other curve. Shape (m, 2 axes).
    bent
        What a knee in each axis adds, at unit RMS, shape (m, knees).
    """

    straight: FloatArray
    bent: FloatArray


def bent_axes(case: Case, causes: Sequence[Cause]) -> tuple[str, ...]:
    """Axes of transducers that a curve or a gain is named for; cells have other curves as rivals.

    A gain of all legs is asked for no curve: several transducers do not bend alike.
    """
    if not is_six_axis(channels_of(case.logs)):
        return ()
    named = [c.signature for c in causes if c.signature.effect in CURVES]
    axes = [axis for s in named for _, own in s.owners for axis in own]
    axes += [axis for cause in causes if (axis := _straight_axis(cause.signature))]
    return tuple(dict.fromkeys(axes))


def _straight_axis(mine: Signature) -> str:
    """The axis whose gain is named, of one transducer alone; empty for all else."""
    if mine.effect not in GAINS or [len(legs) for _, legs in mine.owners] != [1]:
        return ""
    return f"{mine.owners[0][1][0]}.{mine.parameter.rsplit('_', 1)[1]}"


def bends_of(ideal: Case, rows: Problem, axes: Sequence[str]) -> Bends:
    """What a line and a knee in each of some axes add to the residual.

    Parameters
    ----------
    ideal
        The model's recordings, without noise.
    rows
        Which errors count.
    axes
        From `bent_axes`.
    """
    straight, bent = [], []
    for axis, force in loads_of(ideal, axes).items():
        # forces of a transducer have both signs, so that its knees stand among all readings
        start, span = float(force.min()), float(np.ptp(force))
        # two knees below all readings span every line
        knees = [start, start - span, *np.quantile(force, KNEES)]
        found = knees_at(ideal, rows, axis, knees)
        straight += found[:2]
        bent += found[2:]
    return Bends(unit_columns(np.stack(straight, axis=1)), unit_columns(np.stack(bent, axis=1)))


def against_bends(after: Problem, bends: Bends, signs: FloatArray) -> Unnamed:
    """Judge the named curves by what knees of their own axes explain beside them.

    Where rows are single observations the F test sees a bend that few blocks carry, which no signs
    of theirs can show. An error of ``m · min (t/s)²`` changes some output by what matters, were it
    all in that one.

    Parameters
    ----------
    after
        The problem on the extended model.
    bends
        From `bends_of`.
    signs
        Sign patterns of the blocks.
    """
    held = after.holding(bends.straight)
    left = left_beside(held, (bends.bent,), signs)
    if has_single_rows(held):
        grams, _ = whitened_grams(held.without_candidates, bends.bent)
        single = explained_p(grams, grams.calibration, grams.features, held.residual.size)
        left = Form(min(2.0 * min(left.p, single), 1.0), left.gain)
    unit = after.tolerance[after.output] / after.noise
    smallest = after.residual.size * float(np.min(unit**2, initial=np.inf))
    return Unnamed(left, rival=False, as_form=True, smallest=smallest)


def open_curves(subject: Subject, best: Tried, noise: Noise, rules: Rules) -> list[Signature]:
    """Curves of the axis that a gain is named for, where they may bend by a good part of it.

    Loads of three levels, as hangings have them, tell a gain g from a curve by its even part alone.
    With loads that span 2 F the curve ``q x²`` is open while the 95 % bound of |q| F beside the
    gain exceeds `Rules.bend_share` · |g|: no loss can speak against what the gain so resembles.

    Parameters
    ----------
    best
        The named cause in its refit.
    noise
        In which contenders are judged.
    """
    mine, effect = best.cause.signature, subject.table[best.cause.signature.effect]
    if mine.effect not in GAINS or Trait.SWITCH in effect.traits:
        return []
    (owner, legs), *others = mine.owners
    if others or len(legs) > 1:  # several transducers do not bend alike
        return []
    axis, ideal = f"{legs[0]}.{mine.parameter.rsplit('_', 1)[1]}", best.fitted.ideal
    curves = [
        s for s in subject.problem.signatures
        if s.effect in CURVES and [axes for _, axes in s.owners] == [(axis,)]
    ]  # fmt: skip
    gain = abs(best.fitted.values[f"{owner}.{mine.parameter}"])
    reach = 0.5 * float(np.ptp(loads_of(ideal, [axis])[axis]))
    return [
        curve for curve in curves
        if largest(best.bare, subject.columns(ideal, [curve])[0], noise) * reach
        > rules.bend_share * gain
    ]  # fmt: skip


def largest(bare: Problem, column: FloatArray, noise: Noise | None = None) -> float:
    """95 % bound of the absolute size of a row column beside what is fitted; infinite unseen.

    Parameters
    ----------
    bare, column
        A problem, and what size one adds to its residual, shape (m,).
    noise
        The problem's own where absent.
    """
    grams, _ = whitened_grams(bare, column[:, None], noise)
    seen = scores(grams.inner, grams.calibration, grams.features)
    if seen.inside[0]:
        return float(np.inf)
    sd = 1.0 / float(np.sqrt(seen.information.sum()))
    return abs(float(seen.size[0])) + float(chances.norm_isf(0.025)) * sd


def bend_left(last: Diagnosis, causes: Sequence[Cause], model: Refit | None) -> bool:
    """Whether a curve of the axis is surely left beside a gain that is named for it.

    A gain is the straight one of an axis's curves, and what explains most of one that bends: how
    little the curve then removes says nothing for the gain. Several transducers do not bend alike,
    and a curve below `Rules.bend_share` of what the gain does to the rows is none of its.

    Parameters
    ----------
    last
        Of the model with all causes.
    causes, model
        What was named, and the model with it.
    """
    if model is None:
        return False
    lib, found = last.library, last.search.first
    for cause in causes:
        mine, axis = cause.signature, _straight_axis(cause.signature)
        if not axis:
            continue
        at = model.names.index(f"{mine.owners[0][0]}.{mine.parameter}")
        least = last.rules.bend_share * norm(model.columns[:, at]) * abs(model.intervals[at].value)
        for c, (effect, *_) in enumerate(lib.causes):
            if effect not in CURVES or found.p[c] >= last.rules.alpha_name:
                continue
            column = lib.index(int(found.best[c]))
            curve = lib.problem.signatures[column]
            bent = norm(lib.problem.columns[:, column]) * abs(found.interval(c).value)
            if [axes for _, axes in curve.owners] == [(axis,)] and bent > least:
                return True
    return False
