"""The named cause and its look-alikes, each refitted with the whole model."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from footcal_cli.core.diagnosis.aliases import aliases
from footcal_cli.core.diagnosis.answer import Cause, Diagnosis
from footcal_cli.core.diagnosis.change_points import at_its_change_point, has_change_point
from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.zeros import known_zeros, with_their_zeros
from footcal_cli.core.effects import having
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.signatures import SWITCHES
from footcal_cli.core.parameters import FloatArray, IntArray

Contender: TypeAlias = tuple[Cause, Refit, Problem]
"""A cause, its refit beside all others, and the problem that it leaves."""
_RCOND = 1e-9
KNEES = having(Trait.KNEE)
"""One curve but for a gain, where the knee is the same and loads are of one sign. No real knee is
sharp, so that which of them fits a soft one a little better says nothing."""


def refitted(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit | None,
    answer: Diagnosis,
    about: Cause,
    taken: Collection[str],
) -> list[Contender]:
    """Every look-alike of a cause, itself first, with its refit and the problem that it leaves.

    Parameters
    ----------
    about
        The named cause, or one of its contenders that did better.
    taken
        Effects that are no contenders, or are refitted already.
    """
    first = answer.causes[0]
    fits = []
    for signature, size in _contenders(answer, subject.table, about):
        if signature.effect in taken:
            continue
        places = first.places if signature.effect == first.signature.effect else ()
        cause = replace(first, signature=signature, size=size, rivals=(), places=places)
        fits.append(fit(subject, causes, model, cause))
    return fits


def fit(subject: Subject, causes: Sequence[Cause], model: Refit | None, cause: Cause) -> Contender:
    """A contender, its refit together with all other causes, and the problem after it."""
    fitted = refitted_with(subject, [*causes, cause], model)
    return cause, fitted, subject.bare(fitted, [*causes, cause])


def _contenders(
    answer: Diagnosis, table: Mapping[str, Effect], first: Cause
) -> list[tuple[Signature, Interval]]:
    """A cause and the effects that look like it and explain nearly as much."""
    evidence, lib, rules = answer.search.first, answer.library, answer.rules
    signatures = lib.problem.signatures
    mine = lib.causes.index(first.signature.cause)
    gain = evidence.gain.sum(axis=0)
    near = aliases(lib, first.signature, {first.signature.parameter: first.size.value})
    alike = {signature.effect: cos for signature, _, cos in near if cos > rules.look_alike}
    found = {first.signature.effect: (first.signature, first.size)}
    mimics = table[first.signature.effect].mimics
    order = np.argsort(-gain, kind="stable")
    place = places_of(lib, table, evidence.best)
    for c in order:
        signature = signatures[lib.index(int(evidence.best[c]))]
        if place.get(signature.effect, signature.where) != signature.where:
            continue
        if len(found) == rules.most_contenders:
            break
        # off its moment a change predicts little of other blocks, however sure it is
        placed = evidence.p[c] < rules.alpha_name and has_change_point(table[signature.effect])
        effect = table[signature.effect]
        # one axis of several understates it: all of them copy the named one with a share of cos²
        copied = alike.get(effect.name, 0.0) ** 2 if len(effect.sizes) > 1 else 0.0
        if max(gain[c], copied * gain[mine]) < rules.contender_share * gain[mine] and not placed:
            continue
        possible = evidence.possible(int(c), signature, rules, as_it_is=True)
        like = signature.effect in alike or signature.effect in mimics
        if signature.effect not in found and like and possible:
            found[signature.effect] = (signature, evidence.interval(c))
    places = {found[name][0].where for name in KNEES & set(found)}
    for c in order:  # a knee never stands alone: loads of one sign tell it from the other by a gain
        signature = signatures[lib.index(int(evidence.best[c]))]
        possible = evidence.possible(int(c), signature, rules, as_it_is=True)
        if places and possible and signature.effect in KNEES and signature.where in places:
            found.setdefault(signature.effect, (signature, evidence.interval(c)))
    return list(found.values())


def places_of(lib: Library, table: Mapping[str, Effect], best: IntArray) -> dict[str, str]:
    """Where all sizes of an effect together explain most, of each effect with several.

    With scores s and their products P, calibration projected off, they explain ``s' P⁻¹ s``; one
    axis alone may do more next to where both belong.
    """
    score = lib.alone.score.sum(axis=0)
    sizes: dict[tuple[str, str], list[int]] = {}
    for (effect, _, where), column in zip(lib.causes, best, strict=True):
        if len(table[effect].sizes) > 1:
            sizes.setdefault((effect, where), []).append(lib.index(int(column)))
    explained = {
        at: float(score[own] @ scaled_inverse(lib.products[np.ix_(own, own)], _RCOND) @ score[own])
        for at, own in sizes.items()
    }
    ranked = sorted(explained, key=lambda at: explained[at])
    return dict(ranked)


def with_zeros(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit | None,
    answer: Diagnosis,
    taken: Collection[str],
    signs: FloatArray,
) -> list[Contender]:
    """What explains nearly as much as the named cause with the zero that it changes, refitted.

    One of each effect, where it explains most; parameters as of `refitted`.
    """
    lib, rules, first = answer.library, answer.rules, answer.causes[0]
    gain = answer.search.first.gain.sum(axis=0)
    least = rules.contender_share * float(gain[lib.causes.index(first.signature.cause)])
    zeros = {owner: subject.zero(owner) for owner in known_zeros(subject.case)}
    best: dict[str, tuple[float, Signature, Interval]] = {}
    for signature, size, bought in with_their_zeros(
        lib, zeros, subject.table, signs, rules.alpha_name
    ):
        most = best[signature.effect][0] if signature.effect in best else least
        if signature.effect not in taken and bought > most:
            best[signature.effect] = bought, signature, size
    return [
        fit(subject, causes, model, replace(first, signature=s, size=size, rivals=(), places=()))
        for _, s, size in best.values()
    ]


def refitted_with(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit | None,
) -> Refit:
    """All causes refitted together, the newest from its size, the others from the last model."""
    start: dict[str, float] = {}
    if model is not None:
        start = {n: v for n, v in model.values.items() if n not in subject.case.values}
    newest = causes[-1]
    effect = subject.table[newest.signature.effect]
    shapes = dict(at_its_change_point(subject, newest.signature, causes[:-1], model).shape)
    for owner, _ in newest.signature.owners:
        for parameter in effect.parameters:
            value = shapes.get(parameter.name, parameter.neutral)
            if parameter.name == newest.signature.parameter:
                # the linear size may overshoot a bent effect; begin inside its range
                most = max(3 * parameter.prior_sd, *np.abs(parameter.far), 0.0)
                inside = np.clip(newest.size.value, -most, most)
                value = float(np.clip(parameter.neutral + inside, parameter.lower, parameter.upper))
                value = 1.0 if effect.name in SWITCHES else value
            start.setdefault(f"{owner}.{parameter.name}", value)
    return subject.refitted(causes, start)
