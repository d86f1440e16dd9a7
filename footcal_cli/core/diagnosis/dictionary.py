"""Every form of a kind of causes as columns: curves, loops, memories, mixtures, sums.

Plays of several reaches add up to any loop, several time constants to any linear memory, a parabola
and a cubic to nearly any smooth curve, what each cell hears of each other one to any linear
mixture, labels of all loads and bypasses from every load on to whatever depends on the load of a
foot.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.mixtures import LINEAR, mixtures_of
from footcal_cli.core.diagnosis.rivals import SMOOTH
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.unnamed import CURVES
from footcal_cli.core.effects import TABLE, having
from footcal_cli.core.effects.contract import Scope, Trait, units_of
from footcal_cli.core.inference.case import Case, channels_of
from footcal_cli.core.inference.grams import calibration_grams
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.scores import held_out_loss
from footcal_cli.core.inference.shapes import shapes_of
from footcal_cli.core.inference.signatures import derivative
from footcal_cli.core.inference.whitening import Noise
from footcal_cli.core.parameters import FloatArray

CURVED = "curve"
"""The kind of all curves of a cell's own load."""
SUMMED = "sum"
"""The kind of all that depends on the load of a foot."""
_MIXED, _MATRIX = "mixture", "matrix"
MEMORIES = having(Trait.SPECTRUM)
COMPLETE = frozenset({CURVED, _MIXED, SUMMED, *(TABLE[name].remedy for name in MEMORIES)})
"""Kinds whose columns add up to every form that a cause of theirs may have."""
BELIEFS = having(Trait.BELIEF)
"""Numbers that are believed wrong: they have no form."""
_OF_THE_SUM = having(Trait.OF_THE_SUM)
_OF_THE_MATRIX = sorted(having(Trait.LINEAR) & having(Trait.ZERO_TOO) - having(Trait.SWITCH))


def kinds_named(cause: Cause) -> frozenset[str]:
    """The kinds of an effect and of all its rivals; a number believed wrong is of what it does."""
    does = {**dict.fromkeys(LINEAR, _MIXED), **dict.fromkeys(_OF_THE_SUM, SUMMED)}
    effects = [s.effect for s in (cause.signature, *cause.rivals)]
    return frozenset(does.get(effect) or kind_of(effect) for effect in effects)


def kind_of(effect: str) -> str:
    """The kind of an effect: of a memory its remedy; its own name where it is of none."""
    if effect in CURVES:
        return CURVED
    if effect in LINEAR - BELIEFS:
        return _MIXED
    if effect in _OF_THE_SUM - BELIEFS:
        return SUMMED
    if effect in _OF_THE_MATRIX:
        return _MATRIX
    return TABLE[effect].remedy if effect in MEMORIES else effect


def rival_kinds(subject: Subject) -> frozenset[str]:
    """Kinds that a name is held against: where placed loads are known, mixtures and sums too.

    Of a transducer any matrix, which turns of a leg distinguish from what time does.
    """
    if subject.problem.turned:
        return frozenset({_MATRIX})
    placed = subject.case.experiment.name == "placements"
    return COMPLETE if placed else COMPLETE - {_MIXED, SUMMED}


def kinds_at(
    subject: Subject, ideal: Case, causes: Sequence[Cause], kinds: Collection[str]
) -> dict[str, FloatArray]:
    """Columns of some kinds where causes act, each in every shape, shape (m, k)."""
    channels = channels_of(subject.case.logs)
    places = [p for cause in causes for p in _places(subject, cause)]
    places = [p for i, p in enumerate(places) if p not in places[:i]]
    members = [unit for c in causes for _, own in c.signature.owners for unit in own]
    asked = [(kind_of(name), name, places) for name in sorted(MEMORIES | SMOOTH)]
    legs = _each(units_of(Scope.LEG, members))
    asked += [(_MATRIX, name, legs) for name in _OF_THE_MATRIX]
    for name in sorted(_OF_THE_SUM & having(*Trait, experiment=subject.case.experiment.name)):
        asked.append((SUMMED, name, _each(units_of(TABLE[name].scope, channels))))
    found = {_MIXED: mixtures_of(ideal, subject.problem)} if _MIXED in kinds else {}
    for kind in dict.fromkeys(kind for kind, *_ in asked if kind in kinds):
        columns = [c for k, name, where in asked if k == kind
                   for c in _columns(subject, ideal, name, where)]  # fmt: skip
        found[kind] = unit_columns(np.stack(columns, axis=1))
    return found


def cells_of(subject: Subject, cause: Cause) -> list[str]:
    """The cells where a cause acts, each once; all of them where it acts on no cell."""
    every = (cell for place in _places(subject, cause) for own in place.values() for cell in own)
    return list(dict.fromkeys(every))


def left_with(bare: Problem, columns: FloatArray, noise: Noise) -> FloatArray:
    """Held-out squared error of each block with further columns fitted, shape (B,)."""
    grams = calibration_grams(bare.holding(columns), noise, counted=False)
    return held_out_loss(grams.inner, grams.calibration)


def _columns(
    subject: Subject, ideal: Case, name: str, places: Sequence[Mapping[str, tuple[str, ...]]]
) -> list[FloatArray]:
    """What an effect adds in every shape and place, shape (m,) each."""
    effect, seen = TABLE[name], ideal.memory()
    return [
        derivative(ideal, subject.problem, effect, size, owners, shape, seen=seen)
        for owners in places
        for shape in shapes_of(ideal, effect, [unit for own in owners.values() for unit in own])
        for size in effect.sizes
    ]


def _each(units: Sequence[str]) -> list[dict[str, tuple[str, ...]]]:
    """Owners with one size each, of which each is one unit."""
    return [{unit: (unit,)} for unit in units]


def _places(subject: Subject, cause: Cause) -> list[dict[str, tuple[str, ...]]]:
    """Owners with one size each: the cells of a cause, all of them where it acts on no cell."""
    if subject.table[cause.signature.effect].scope is Scope.CHANNEL:
        return [{owner: units} for owner, units in cause.signature.owners]
    return [{"all": tuple(channels_of(subject.case.logs))}]
