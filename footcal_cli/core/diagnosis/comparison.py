"""The named cause against its look-alikes, each in its own full refit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.diagnosis.aliases import aliases
from footcal_cli.core.diagnosis.answer import Cause, Compared, Diagnosis
from footcal_cli.core.diagnosis.bends import open_curves
from footcal_cli.core.diagnosis.by_cell import in_each_cell
from footcal_cli.core.diagnosis.change_points import onset_moved
from footcal_cli.core.diagnosis.contenders import KNEES, fit
from footcal_cli.core.diagnosis.field import field_of, inside, white_loss, without_its_edge
from footcal_cli.core.diagnosis.rivals import (
    Tried,
    adding_p,
    adds_more,
    excess_of,
    level_of,
    likelier,
    odds_of,
    of_two_classes,
    outdone,
    partners_of,
    said_alike,
    share_for_form,
)
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.sized import all_are_something
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.two_kinds import surer
from footcal_cli.core.diagnosis.unnamed import CURVES
from footcal_cli.core.diagnosis.weighing import has_few_blocks
from footcal_cli.core.effects import having
from footcal_cli.core.effects.contract import Effect, Scope, Trait
from footcal_cli.core.inference.case import channels_of
from footcal_cli.core.inference.evidence import (
    Interval,
    effective_blocks,
    sign_flip_mean,
    sign_patterns,
)
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.shapes import shapes_of
from footcal_cli.core.inference.signatures import SWITCHES
from footcal_cli.core.parameters import FloatArray

OF_ANY_ORDER = having(Trait.LOW_PASS)
"""Low-passes that the table knows in their first order only. A steeper one (a Butterworth) is
nearer to a delay than to that, so that no comparison of losses speaks against it: here
`Rules.alias` alone counts. A delay has one form: where a low-pass is surely nearer, it is out."""


def decided(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit | None,
    answer: Diagnosis,
    seed: int,
    failed: frozenset[str] = frozenset(),
) -> tuple[Cause, Refit]:
    """The named cause against its look-alikes, each in its own full non-linear refit.

    A linear proxy may prefer the wrong one of two look-alikes when the effect is large.

    Parameters
    ----------
    subject
        What is diagnosed.
    causes, model
        All other causes, and the model with them; None without any.
    answer
        Of the round that found the cause.
    seed
        Of sign patterns.
    failed
        Effects that did not stand their refit: no contenders.
    """
    first, rules = answer.causes[0], _stricter(answer.rules, subject.problem)
    signs = sign_patterns(subject.problem.blocks, seed)
    field, tried, best = field_of(subject, causes, model, answer, signs, rules, failed)
    family, noise = field.family, field.noise
    best = next((t for t in tried if surer(subject, t, best, noise, signs, rules)), best)
    for form in _in_other_forms(subject, best.cause):
        best = min(best, field.judged_anew(form), key=lambda t: float(t.loss.sum()))
    chosen, fitted, loss = in_each_cell(field, best, rules)
    blank = subject.problem if model is None else subject.bare(model, causes)
    gain = max(float((white_loss(blank, noise) - loss).sum()), 0.0)
    mine = best.cause.signature

    def bends_as_well(other: Tried) -> bool:
        if not of_two_classes(best.cause, other.cause):
            return False
        joined = _joined_by_its_class(subject, causes, other)
        left = other.loss if joined is None else white_loss(joined, noise)
        return float((left - loss).sum()) < share_for_form(best, rules.other_form, rules) * gain

    def significant(other: Tried) -> bool:
        if sign_flip_mean(other.loss - loss, signs) < rules.alpha_rival:
            return True
        if subject.problem.pieces and likelier(loss, other.loss, noise, rules.alpha_name):
            return True
        if subject.problem.turned:
            return adds_more(subject, best, other, family, noise, signs, rules)
        # signs of a few sessions of one cell reach no level
        apart = effective_blocks(abs(other.loss - loss)[:, None])
        few = has_few_blocks(best.bare, float(apart[0]))
        return few and adding_p(subject, best, other, family, [], noise, signs)[0] < (
            rules.alpha_beside
        )

    losses = {t.cause.signature.effect: t.loss for t in tried}
    lost = {effect: float((other - loss).sum()) for effect, other in losses.items()}
    others = {t.cause.signature.effect: t for t in tried if t.cause.signature.effect != mine.effect}
    surely = {effect for effect, other in others.items() if significant(other)}
    worse = {
        effect
        for effect, other in others.items()
        if (
            _worse(subject.table, other, best, loss, gain, effect in surely, rules)
            or (lost[effect] > 0.0 and outdone(subject, other, best, family, noise, signs, rules))
            or surer(subject, best, other, noise, signs, rules)
        )
        and not bends_as_well(other)
    }
    stopped = {t.cause.signature.effect for t in tried} - {
        t.cause.signature.effect for t in inside(subject, tried)
    }
    most = share_for_form(best, rules.rival_loss, rules) * gain
    knees = {effect for effect in KNEES & lost.keys() if lost[effect] < most}
    if chosen.signature.effect in KNEES or knees - worse:
        worse -= knees
    alike = _aliases_of(answer, best.cause, best.fitted, rules.alias)
    near = {s.effect: (s, cos) for s, cos in alike}
    taken = {chosen.signature.effect, *(c.signature.effect for c in causes)}
    mirrored = _from_the_other_side(subject, chosen, fitted)
    mirrored += open_curves(subject, best, noise, rules)
    same = never_distinguished(
        chosen.signature.effect, {name: cos for name, (_, cos) in near.items()}, rules.same
    ) | {s.effect for s in mirrored}
    if _gains_of_all(subject.table[mine.effect], best.cause):
        same |= {t.cause.signature.effect for t in tried
                 if Trait.ALL_ALIKE in subject.table[t.cause.signature.effect].traits}  # fmt: skip
    # in a noise that has the cause in it the two look less alike than their refits are
    same |= {
        name for name, more in lost.items()
        if more < (1.0 - rules.same**2) * gain and not {name, mine.effect} <= CURVES
    }  # fmt: skip
    # of two that are so much alike none leaves a good part of what the other one explains
    left = {name for name in same if lost.get(name, 0.0) > rules.wrong_form * gain}
    same -= left - OF_ANY_ORDER
    smooth = without_its_edge(field, best, rules, gain)
    same |= {s.effect for s in smooth}
    # what only its bound stops is something else; that something may be what the best one copies
    worse = (worse - same) | (stopped & surely)
    late = onset_moved(subject.table[mine.effect], mine, best.fitted)
    known = _as_good(answer, gain) if late else first.rivals
    rivals = [*known, first.signature, *(other.cause.signature for other in tried)]
    rivals += [s for s, _ in near.values()]
    rivals += mirrored + smooth
    by_effect = {s.effect: s for s in rivals if s.effect not in worse | taken}
    compared = {
        other.cause.signature.effect: Compared(excess_of(other.loss, loss), other.p, best.p)
        for other in tried
        if other.cause.signature.effect != mine.effect
    }
    unfitted = _unfitted_losses(answer)

    def odds(effect: str) -> float:
        """Of what no comparison of losses rules out, or has no loss of its own, even ones."""
        bent = rules.rival_loss * gain
        if effect in same:
            return 1.0
        if effect in losses:
            return odds_of(loss, losses[effect], noise, bent)
        if effect in near or not {effect, mine.effect} <= unfitted.keys():
            return 1.0
        return odds_of(unfitted[mine.effect], unfitted[effect], noise, bent)

    return replace(
        chosen, rivals=tuple(by_effect.values()), compared=compared,
        odds={effect: odds(effect) for effect in by_effect},
    ), fitted  # fmt: skip


def _gains_of_all(effect: Effect, cause: Cause) -> bool:
    """Whether a cause gives several sensors the same gains: what scales all forces does nearly.

    Gains of three axes also follow accelerations that an estimator smooths, and so seem surer.
    """
    shared = any(len(units) > 1 for _, units in cause.signature.owners)
    return shared and Trait.AXIS_GAIN in effect.traits and Trait.SWITCH not in effect.traits


def _stricter(rules: Rules, problem: Problem) -> Rules:
    """Rules for rivals: where a few hangings tell them apart, however many turns each has."""
    return replace(rules, alpha_rival=rules.alpha_beside) if problem.turned else rules


def never_distinguished(chosen: str, alike: Mapping[str, float], same: float) -> set[str]:
    """Aliases of an effect that no comparison of losses rules out.

    Parameters
    ----------
    alike
        |cos| of effects that count as one with the chosen one.
    same
        |cos| from which two are the same whatever they are.
    """
    return {
        name for name, cos in alike.items()
        if cos > same or name in OF_ANY_ORDER or {name, chosen} <= KNEES
    }  # fmt: skip


def decided_again(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit,
    rounds: Sequence[Diagnosis],
    seed: int,
) -> tuple[list[Cause], Refit]:
    """Earlier causes against their look-alikes once more, with what was found later in the model.

    What another cause leaves hides which of two look-alikes fits, or makes the wrong one sure.
    """
    causes = list(causes)
    for i, answer in enumerate(rounds[: len(causes) - 1]):
        others = [*causes[:i], *causes[i + 1 :]]
        if _began_as(answer, others):
            continue
        start = {n: v for n, v in model.values.items() if n not in subject.case.values}
        alone = subject.refitted(others, start)
        if not all_are_something(others, subject.table, alone):
            # what is something beside the cause only begins there: at zero its shape has no slope
            values = {name: start.get(name, value) for name, value in alone.values.items()}
            alone = replace(alone, values=values)
        causes[i], model = decided(subject, others, alone, answer, seed)
    return causes, model


def _began_as(answer: Diagnosis, others: Sequence[Cause]) -> bool:
    """Whether the effect that a cause was first named as is another cause by now."""
    return answer.causes[0].signature.effect in {cause.signature.effect for cause in others}


def _from_the_other_side(subject: Subject, chosen: Cause, fitted: Refit) -> list[Signature]:
    """Readings that all lag by a low-pass are a body stream that leads by one, and no other thing.

    The stream carries the size, below zero: it is known without noise that undoing a lag of the
    readings makes large.
    """
    effect, mine = subject.table[chosen.signature.effect], chosen.signature
    slow = Trait.LOW_PASS in effect.traits and effect.scope is Scope.ROBOT
    if not slow or fitted.values[f"{mine.owners[0][0]}.{mine.parameter}"] >= 0.0:
        return []
    every = set(channels_of(subject.case.logs))
    return [
        s for s in subject.problem.signatures
        if s.effect in OF_ANY_ORDER and s.effect != effect.name
        and {unit for _, units in s.owners for unit in units} == every
    ]  # fmt: skip


def _as_good(answer: Diagnosis, gain: float) -> list[Signature]:
    """Rivals that explain a good share of what the best one does, now that its moment is known."""
    evidence = answer.search.first
    total, causes = evidence.gain.sum(axis=0), answer.library.causes
    return [
        signature for signature in answer.causes[0].rivals
        if any(
            total[c] >= answer.rules.rival_share * gain
            for c, (effect, *_) in enumerate(causes) if effect == signature.effect
        )
    ]  # fmt: skip


def _unfitted_losses(answer: Diagnosis) -> dict[str, FloatArray]:
    """Loss of each effect by its signature where it explains most, but for what all leave, (B,)."""
    gain = answer.search.first.gain
    found: dict[str, FloatArray] = {}
    for c in np.argsort(-gain.sum(axis=0), kind="stable"):
        found.setdefault(answer.library.causes[c][0], -gain[:, c])
    return found


def _in_other_forms(subject: Subject, cause: Cause) -> list[Cause]:
    """The cause with each other cell that its cells may hear: no step leads from one to the next.

    Cells of a foot share every load nearly in a plane, so that the search counts the mean of all
    others and a neighbour of the other sign as one. Only the best cause has a choice of them: among
    so many forms a rival would find one that fits.
    """
    effect, mine = subject.table[cause.signature.effect], cause.signature.shape
    if effect.name in SWITCHES or [p.unit for p in effect.shapes] != ["channel"]:
        return []
    shapes = [tuple(shape.items()) for shape in shapes_of(subject.case, effect)]
    nothing = Interval(0.0, 0.0, 0.0)
    return [
        replace(cause, signature=replace(cause.signature, shape=shape), size=nothing)
        for shape in shapes if shape != mine
    ]  # fmt: skip


def _joined_by_its_class(subject: Subject, causes: Sequence[Cause], other: Tried) -> Problem | None:
    """What a smooth curve leaves together with the other one of its class in the same place."""
    partner = next(iter(partners_of(other.cause, subject.problem.signatures)), None)
    if partner is None:
        return None
    beside = replace(other.cause, signature=partner, size=Interval(0.0, 0.0, 0.0), places=())
    _, fitted, bare = fit(subject, [*causes, other.cause], other.fitted, beside)
    return subject.without_credit(bare, fitted)


def _worse(
    table: Mapping[str, Effect],
    other: Tried,
    best: Tried,
    loss: FloatArray,
    gain: float,
    significant: bool,
    rules: Rules,
) -> bool:
    """Whether a contender is out; `significant` that its loss is larger.

    What looks like the best by its nature must leave something where the best leaves nothing, or
    lose a good part of the gain: a table's curve is never quite the cell's, and where none of a
    kind leaves nothing, the next best may be the nearer one. What predicts left-out blocks better
    than the best is not out for what it leaves.
    """
    lost = float((other.loss - loss).sum())
    if not said_alike(table, best.cause, other.cause):
        return significant
    if (
        lost > 0.0
        and best.p >= rules.alpha_whole
        and other.p < level_of(best.cause, other.cause, rules)
    ):
        return True
    return significant and lost >= rules.rival_loss * gain


def _aliases_of(
    answer: Diagnosis, chosen: Cause, fitted: Refit, least: float
) -> list[tuple[Signature, float]]:
    """Effects that can copy the chosen one as it was fitted, with |cos|."""
    owner = chosen.signature.owners[0][0]
    sizes = {
        name.rsplit(".", 1)[1]: fitted.values[name]
        for name in fitted.names
        if name.rsplit(".", 1)[0] == owner
    }
    found = aliases(answer.library, chosen.signature, sizes)
    return [(signature, cos) for signature, _, cos in found if cos > least]
