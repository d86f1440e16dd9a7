"""A name against kinds of causes that need no name: loops, memories, curves, mixtures, sums.

Names are compared with names of the table. What the table lacks is then taken for what it
resembles: a creep that it has not is a loop, a parabola a wrong weight, a bypass a crosstalk and a
curve. Columns that add up to every cause of a kind (`footcal_cli.core.diagnosis.dictionary`) stand
for it, whatever is a candidate.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.dictionary import (
    BELIEFS,
    kind_of,
    kinds_at,
    left_with,
    rival_kinds,
)
from footcal_cli.core.diagnosis.form import FORM
from footcal_cli.core.diagnosis.path import Path
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects.contract import Trait, is_six_axis
from footcal_cli.core.inference.case import channels_of
from footcal_cli.core.inference.evidence import sign_flip_group, sign_flip_mean, sign_patterns
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.scores import held_out_loss, scores
from footcal_cli.core.inference.whitening import Noise
from footcal_cli.core.parameters import FloatArray


def of_another_kind(subject: Subject, path: Path, rules: Rules, seed: int) -> bool:
    """Whether a kind that is not a name's own explains surely what the name does not.

    ``E = L(name) − L(both)`` is what a name, in every form of its own kind, leaves to a kind on
    left-out blocks, ``E′ = L(kind) − L(both)`` what that leaves to it; ``E > 2 E′`` by the signs of
    the blocks, since the form of a true cause is never quite the table's
    (`footcal_cli.core.diagnosis.two_kinds`). A number that is believed wrong has no form: there
    ``E > E′``, and what the kind adds beside the name is sure by its scores, which hold the same
    evidence with half the noise. One kind in the place of several names needs no margin either.
    Where loads are recorded beside the readings; elsewhere kinds resemble what bodies do. Turns of
    a hanging leg follow one another in time: what time or temperature does there must surely add to
    any single gain or coupling (``E′``).

    Parameters
    ----------
    path
        With its causes, their rivals in the model too; each is asked beside all others.
    rules, seed
        Thresholds; of sign patterns.
    """
    loaded = "load" in subject.problem.regressors
    known = loaded and not is_six_axis(channels_of(subject.case.logs))
    if path.model is None or not (known or subject.problem.turned):
        return False
    if len(path.causes) > 1 and _in_place_of_all(subject, path, path.model, rules, seed):
        return True
    return any(_outdoes(subject, path, path.model, cause, rules, seed) for cause in path.causes)


def _in_place_of_all(subject: Subject, path: Path, model: Refit, rules: Rules, seed: int) -> bool:
    """Whether one kind alone leaves less than several names do: ``L(names) > L(kind)``."""
    noise, signs = path.current.law, sign_patterns(subject.problem.blocks, seed)
    named, blank = subject.bare(model, path.causes), subject.problem.without_candidates
    left = left_with(named, blank.columns[:, :0], noise)
    own = {kind_of(effect) for effect in _effects(path.causes)}
    return any(
        sign_flip_mean(left - left_with(blank, columns, noise), signs) < rules.alpha_beside
        for kind, columns in kinds_at(
            subject, model.ideal, path.causes, rival_kinds(subject) - own
        ).items()
    )


def _outdoes(
    subject: Subject, path: Path, model: Refit, cause: Cause, rules: Rules, seed: int
) -> bool:
    """Whether another kind explains what one cause does not, beside all other causes."""
    others = [c for c in path.causes if c is not cause]
    effects, beside = _effects([cause]), _effects(others)
    exact, mine = effects <= BELIEFS, {kind_of(effect) for effect in effects}
    table = subject.table
    timed = any(Trait.TIMED in table[e].traits or "temperature_degc" in table[e].needs
                for e in effects)  # fmt: skip
    in_time = timed and subject.problem.turned
    kinds = kinds_at(subject, model.ideal, [cause], rival_kinds(subject))
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
        if kind in mine or kind in {kind_of(effect) for effect in beside}:
            continue
        both = left_with(named, np.hstack([form, columns]), noise)
        left, its = mine_left - both, left_with(blank, columns, noise) - both
        if exact:
            better = float((left - its).sum()) > 0.0
            if better and _adds_p(named, columns, noise, signs) < rules.alpha_left:
                return True
        elif sign_flip_mean(left - FORM * its, signs) < rules.alpha_left:
            return True
        if in_time and not _adds_to_each(blank, named, columns, noise, signs, rules):
            return True
    return False


def _effects(causes: Sequence[Cause]) -> set[str]:
    return {effect for cause in causes for effect in cause.effects}


def _adds_p(named: Problem, columns: FloatArray, noise: Noise, signs: FloatArray) -> float:
    """The p, by the signs of the blocks, that columns add nothing beside a name."""
    grams, _ = whitened_grams(named, columns, noise)
    return sign_flip_group(scores(grams.inner, grams.calibration, grams.features).score, signs)


def _adds_to_each(
    blank: Problem,
    named: Problem,
    columns: FloatArray,
    noise: Noise,
    signs: FloatArray,
    rules: Rules,
) -> bool:
    """Whether a name surely adds something beside each of some columns, one at a time."""
    without, beside = (_losses_with_each(one, columns, noise) for one in (blank, named))
    p = [sign_flip_mean(a - b, signs) for a, b in zip(without, beside, strict=True)]
    return max(p, default=0.0) < rules.alpha_rival


def _losses_with_each(problem: Problem, columns: FloatArray, noise: Noise) -> list[FloatArray]:
    grams, _ = whitened_grams(problem, columns, noise, counted=False)
    return [
        held_out_loss(grams.inner, np.append(grams.calibration, column))
        for column in grams.features
    ]
