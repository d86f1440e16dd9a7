"""A name against kinds of causes that need no name: loops, memories, curves, mixtures, sums.

Names are compared with names of the table. What the table lacks is then taken for what it
resembles: a creep that it has not is a loop, a parabola a wrong weight, a bypass a crosstalk and a
curve. Plays of several reaches add up to any loop, several time constants to any linear memory, a
parabola and a cubic to nearly any smooth curve, what each cell hears of each other one to any
linear mixture, labels of all loads and bypasses from every load on to whatever depends on the load
of a foot: as columns they stand for every cause of their kind, whatever is a candidate.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.memories import FORM, MEMORIES, left_with
from footcal_cli.core.diagnosis.mixtures import LINEAR, mixtures_of
from footcal_cli.core.diagnosis.path import Path
from footcal_cli.core.diagnosis.rivals import SMOOTH
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.unnamed import CURVES
from footcal_cli.core.effects import TABLE, having
from footcal_cli.core.effects.contract import Scope, Trait, is_six_axis, units_of
from footcal_cli.core.inference.case import Case, channels_of
from footcal_cli.core.inference.evidence import sign_flip_group, sign_flip_mean, sign_patterns
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.scores import scores
from footcal_cli.core.inference.shapes import shapes_of
from footcal_cli.core.inference.signatures import derivative
from footcal_cli.core.inference.whitening import Noise
from footcal_cli.core.parameters import FloatArray

_CURVED, _MIXED, _SUMMED = "curve", "mixture", "sum"
_BELIEFS, _OF_THE_SUM = having(Trait.BELIEF), having(Trait.OF_THE_SUM)


def of_another_kind(subject: Subject, path: Path, rules: Rules, seed: int) -> bool:
    """Whether a kind that is not a name's own explains surely what the name does not.

    ``E = L(name) − L(both)`` is what a name, in every form of its own kind, leaves to a kind on
    left-out blocks, ``E′ = L(kind) − L(both)`` what that leaves to it; ``E > 2 E′`` by the signs of
    the blocks, since the form of a true cause is never quite the table's
    (`footcal_cli.core.diagnosis.memories`). A number that is believed wrong has no form: there
    ``E > E′``, and what the kind adds beside the name is sure by its scores, which hold the same
    evidence with half the noise. Where the name adds nothing sure beside the kind (``E′``), as
    beside mixtures the place of a cell never does, the kind need not be surely better. One kind in
    the place of several names needs no margin either. Where loads are recorded beside the readings;
    elsewhere kinds resemble what bodies do.

    Parameters
    ----------
    path
        With its causes, their rivals in the model too; each is asked beside all others.
    rules, seed
        Thresholds; of sign patterns.
    """
    known = "load" in subject.problem.regressors
    if path.model is None or not known or is_six_axis(channels_of(subject.case.logs)):
        return False
    if len(path.causes) > 1 and _in_place_of_all(subject, path, path.model, rules, seed):
        return True
    return any(_outdoes(subject, path, path.model, cause, rules, seed) for cause in path.causes)


def _in_place_of_all(subject: Subject, path: Path, model: Refit, rules: Rules, seed: int) -> bool:
    """Whether one kind alone leaves less than several names do: ``L(names) > L(kind)``."""
    noise, signs = path.current.law, sign_patterns(subject.problem.blocks, seed)
    named, blank = subject.bare(model, path.causes), subject.problem.without_candidates
    left = left_with(named, blank.columns[:, :0], noise)
    own = {_kind_of(effect) for effect in _effects(path.causes)}
    return any(
        sign_flip_mean(left - left_with(blank, columns, noise), signs) < rules.alpha_beside
        for kind, columns in _kinds(subject, model.ideal, path.causes)
        if kind not in own
    )


def _outdoes(
    subject: Subject, path: Path, model: Refit, cause: Cause, rules: Rules, seed: int
) -> bool:
    """Whether another kind explains what one cause does not, beside all other causes."""
    others = [c for c in path.causes if c is not cause]
    effects, beside = _effects([cause]), _effects(others)
    exact, mine = effects <= _BELIEFS, {_kind_of(effect) for effect in effects}
    kinds = dict(_kinds(subject, model.ideal, [cause]))
    noise, signs = path.current.law, sign_patterns(subject.problem.blocks, seed)
    named = subject.bare(model, path.causes)
    blank = subject.problem.without_candidates
    if others:
        alone = subject.bare(subject.refitted_from(others, model), others)
        blank = alone.without_candidates
    nothing = blank.columns[:, :0]
    form = np.hstack([nothing, *(columns for kind, columns in kinds.items() if kind in mine)])
    plain, formed = left_with(named, nothing, noise), left_with(named, form, noise)
    mine_left = formed if float(formed.sum()) < float(plain.sum()) else plain
    for kind, columns in kinds.items():
        if kind in mine or kind in {_kind_of(effect) for effect in beside}:
            continue
        both = left_with(named, np.hstack([form, columns]), noise)
        left, its = mine_left - both, left_with(blank, columns, noise) - both
        if exact:
            more = left - its
            idle = sign_flip_mean(its, signs) >= rules.alpha_beside
            better = float(more.sum()) > 0.0
            surely = better if idle else sign_flip_mean(more, signs) < rules.alpha_rival
            if surely and _adds_p(named, columns, noise, signs) < rules.alpha_left:
                return True
        elif sign_flip_mean(left - FORM * its, signs) < rules.alpha_left:
            return True
    return False


def _effects(causes: Sequence[Cause]) -> set[str]:
    return {s.effect for cause in causes for s in (cause.signature, *cause.rivals)}


def _kind_of(effect: str) -> str:
    """The kind of an effect: of a memory its remedy; its own name where it is of none."""
    if effect in CURVES:
        return _CURVED
    if effect in LINEAR - _BELIEFS:
        return _MIXED
    if effect in _OF_THE_SUM - _BELIEFS:
        return _SUMMED
    return TABLE[effect].remedy if effect in MEMORIES else effect


def _kinds(
    subject: Subject, ideal: Case, causes: Sequence[Cause]
) -> Iterator[tuple[str, FloatArray]]:
    """Columns of each kind where causes act, each in every shape, shape (m, k)."""
    found: dict[str, list[FloatArray]] = {}
    places = [p for cause in causes for p in _places(subject, cause)]
    places = [p for i, p in enumerate(places) if p not in places[:i]]
    for name in sorted(MEMORIES | SMOOTH):
        found.setdefault(_kind_of(name), []).extend(_columns(subject, ideal, name, places))
    channels = channels_of(subject.case.logs)
    if subject.case.experiment.name == "placements":
        yield _MIXED, mixtures_of(ideal, subject.problem)
        for name in sorted(_OF_THE_SUM):
            units = [{unit: (unit,)} for unit in units_of(TABLE[name].scope, channels)]
            found.setdefault(_SUMMED, []).extend(_columns(subject, ideal, name, units))
    for kind, columns in found.items():
        yield kind, unit_columns(np.stack(columns, axis=1))


def _columns(
    subject: Subject, ideal: Case, name: str, places: Sequence[Mapping[str, tuple[str, ...]]]
) -> list[FloatArray]:
    """What an effect adds in every shape and place, shape (m,) each."""
    effect, seen = TABLE[name], ideal.memory()
    return [
        derivative(ideal, subject.problem, effect, effect.size, owners, shape, seen=seen)
        for shape in shapes_of(ideal, effect)
        for owners in places
    ]


def _places(subject: Subject, cause: Cause) -> list[dict[str, tuple[str, ...]]]:
    """Owners with one size each: the cells of a cause, all of them where it acts on no cell."""
    if subject.table[cause.signature.effect].scope is Scope.CHANNEL:
        return [{owner: units} for owner, units in cause.signature.owners]
    return [{"all": tuple(channels_of(subject.case.logs))}]


def _adds_p(named: Problem, columns: FloatArray, noise: Noise, signs: FloatArray) -> float:
    """The p, by the signs of the blocks, that columns add nothing beside a name."""
    grams, _ = whitened_grams(named, columns, noise)
    return sign_flip_group(scores(grams.inner, grams.calibration, grams.features).score, signs)
