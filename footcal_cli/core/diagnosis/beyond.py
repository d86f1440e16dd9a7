"""Whether a further cause is more than an error in the form of the others.

A curve of a cell's own load, of whatever form, shows nothing of the past; what a cell remembers of
its loads is more than that, however little of the error it is. So a loop or a creep beside a curve,
or a curve beside one of these, is judged by what it explains beside the other one in every form of
its kind: knees, parabola and cubic add up to any curve, plays of several reaches to any loop,
several time constants to any linear memory. Forms may still copy most of a cause, since sensors
share their drivers: what counts is that the rest, which no form can copy, asks for the same size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.dictionary import (
    COMPLETE,
    CURVED,
    cells_of,
    kinds_at,
    kinds_named,
)
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.unnamed import knees_of
from footcal_cli.core.effects.contract import Stage, Trait
from footcal_cli.core.inference.evidence import sign_flip_max_t, sign_patterns
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.scores import scores
from footcal_cli.core.parameters import FloatArray

Pairs: TypeAlias = Sequence[tuple[int, int]]
_NEARLY = 0.25
"""Of 15 causes hidden in pairs, table's and foreign ones, 14 agree within 0.11 (a Preisach loop
next to creep: 0.68); what a soft bypass leaves to a hinge asks for 1.6 times its size. What a
Bouc-Wen loop leaves to a curve agrees within 0.11 too: of two causes too much is a third."""


@dataclass(frozen=True)
class Beyond:
    """What a cause explains beside others, and beside every form of theirs.

    Parameters
    ----------
    agreement
        Its size beside every form of the others over the one beside them as they were fitted: 1
        where no form does what it does, 0 where it only stands in for one.
    p
        That it adds nothing beside every form of the others, by signs of the blocks.
    """

    agreement: float
    p: float

    def is_no_form(self, rules: Rules) -> bool:
        """Whether it is surely something there, and of nearly the same size."""
        return self.p < rules.alpha_left and abs(self.agreement - 1.0) < _NEARLY


def are_distinct(
    subject: Subject, model: Refit | None, causes: Sequence[Cause], pairs: Pairs, rules: Rules,
    seed: int,
) -> bool:  # fmt: skip
    """Whether of each two causes, by their numbers, neither is a form of the other."""
    return model is not None and all(
        is_beyond(subject, model, causes, which, [of], rules, seed)
        for one, other in pairs for which, of in ((one, other), (other, one))
    )  # fmt: skip


def is_beyond(
    subject: Subject,
    model: Refit,
    causes: Sequence[Cause],
    which: int,
    of: Sequence[int],
    rules: Rules,
    seed: int,
) -> bool:
    """Whether one of several causes is more than the form of some others.

    Only of causes all of whose forms are known (`footcal_cli.core.diagnosis.dictionary`), of other
    kinds than its own. What the body and its clocks do is usual in small amounts, and a lag of
    sensors may be one of the noise: none of these is named for so little.

    Parameters
    ----------
    model
        All causes refitted together.
    which, of
        Number of the cause, and of those whose form it may be.
    rules, seed
        Thresholds; of sign patterns.
    """
    effect = subject.table[causes[which].signature.effect]
    mine = kinds_named(causes[which])
    theirs = frozenset[str]().union(*(kinds_named(causes[i]) for i in of))
    usual = effect.stage not in {Stage.CELL, Stage.FOOT} or Trait.LOW_PASS in effect.traits
    if mine & theirs or not theirs <= COMPLETE or (usual and not mine <= COMPLETE):
        return False
    return beyond(subject, model, causes, which, of, seed).is_no_form(rules)


def beyond(
    subject: Subject,
    model: Refit,
    causes: Sequence[Cause],
    which: int,
    of: Sequence[int],
    seed: int,
) -> Beyond:
    """What one of several causes explains beside the others, and beside every form of some.

    With v what the cause does at its size, the residual without it is ``r − v``. Its score beside
    calibration and the other causes, ``s_b = ṽ_b · r̃_b`` block by block, gives its size
    ``Σ s/Σ |ṽ_b|²``; the same with the forms of the others fitted too, as columns at the loads of
    the model.
    """
    cause = causes[which]
    owners = {owner for owner, _ in cause.signature.owners}
    neutral = {p.name: p.neutral for p in subject.table[cause.signature.effect].parameters}
    sizes = {p.name for p in subject.table[cause.signature.effect].sizes}
    does, rest = np.zeros(model.residual.size), []
    for column, name in zip(model.columns.T, model.names, strict=True):
        owner, _, parameter = name.rpartition(".")
        if owner not in owners or parameter not in neutral:
            rest.append(column)
        elif parameter in sizes:
            does += column * (model.values[name] - neutral[parameter])
    bare = subject.bare(model, causes)
    without = replace(
        bare,
        residual=bare.residual - does,
        accepted=unit_columns(np.stack(rest, axis=1)),
    )
    forms = np.hstack([_forms_of(subject, model, causes[i]) for i in of])
    signs, column = sign_patterns(bare.blocks, seed), unit_columns(does[:, None])
    score, information, _ = _scored(without, bare, column, signs)
    left, visible, p = _scored(without.holding(forms), bare, column, signs)
    if not visible > 0.0 or score == 0.0:
        return Beyond(0.0, 1.0)
    return Beyond((left / visible) / (score / information), p)


def _scored(
    problem: Problem, law_of: Problem, column: FloatArray, signs: FloatArray
) -> tuple[float, float, float]:
    """Score of a column, its information, and the p that it explains nothing."""
    grams, _ = whitened_grams(problem, column, law_of.law)
    found = scores(grams.inner, grams.calibration, grams.features)
    score, information = float(found.score.sum()), float(found.information.sum())
    p = float(sign_flip_max_t(found.score, signs).p[0]) if information > 0.0 else 1.0
    return score, information, p


def _forms_of(subject: Subject, model: Refit, cause: Cause) -> FloatArray:
    """Columns of the kind of a cause where it acts, shape (m, k)."""
    mine = kinds_named(cause)
    columns = list(kinds_at(subject, model.ideal, [cause], mine).values())
    if CURVED in mine:
        knees = knees_of(model.ideal, subject.problem, cells_of(subject, cause))
        columns += [cell.T for cell in knees]
    return unit_columns(np.hstack(columns))
