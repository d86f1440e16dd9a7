"""What to run next, from what a diagnosis could not tell apart."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.diagnosis.aliases import copied
from footcal_cli.core.diagnosis.answer import Diagnosis, Verdict
from footcal_cli.core.diagnosis.investigation import Found, Investigation
from footcal_cli.core.diagnosis.leftovers import nameless
from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.diagnosis.menu import LIKE, Menu, menu_for
from footcal_cli.core.diagnosis.rehearsal import Contender, present
from footcal_cli.core.diagnosis.rig import Rig, rig_of
from footcal_cli.core.effects import having
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.inference.whitening import longest_memory

_NOT_REHEARSED = having(Trait.SWITCH, Trait.GAIN)
"""What a rehearsal, whose calibration is free, cannot show: plugs, and gains that have moved."""
_NEAREST = 3


def rig_at(found: Investigation) -> Rig:
    """Robot, loads and noise of a diagnosis."""
    return rig_of(found.case, found.problem, longest_memory(found.problem))


def ambiguity(found: Investigation, table: Mapping[str, Effect]) -> tuple[Contender, ...]:
    """The first named effect that has rivals, then these; empty where there is none."""
    for item in found.found:
        if not item.cause.rivals:
            continue
        answer = item.answer
        named = _named(item)
        rivals = {item.cause.signature.effect: named}
        for signature in item.cause.rivals:
            copy = _copying(signature, named, answer.library, table)
            rivals.setdefault(signature.effect, copy or _in_its_place(signature, answer, table))
        return tuple(rivals.values())
    return ()


def nearest_effects(found: Investigation, table: Mapping[str, Effect]) -> tuple[Contender, ...]:
    """The effects that explain most of what has no name, best first."""
    _, diagnosis = nameless(found)
    rows = [r for r in diagnosis.effects if r.size.value and r.gain > 0]
    return tuple(_sized(r.signature, r.size.value, table) for r in rows[:_NEAREST])


def next_menu(found: Investigation, table: Mapping[str, Effect]) -> Menu | None:
    """The menu for what could not be distinguished, or for what comes nearest to the unknown."""
    rivals = ambiguity(found, table) if found.verdict is Verdict.AMBIGUOUS else ()
    asked = rivals or nearest_effects(found, table)
    if found.once and found.problem.drifts:
        return None  # a walk that is rehearsed has nothing that goes one way
    if len(asked) < 2 or any(r.signature.effect in _NOT_REHEARSED for r in asked):
        return None
    rig = rig_at(found)
    return menu_for(asked, table, rig, present(found.case, rig) if rivals else None)


def _named(item: Found) -> Contender:
    signature = item.cause.signature
    values = {
        name.rsplit(".", 1)[1]: interval.value
        for name, interval in zip(item.parameter_names, item.intervals, strict=True)
    }
    return Contender(signature, {**dict(signature.shape), **values})


def _copying(
    signature: Signature, named: Contender, lib: Library, table: Mapping[str, Effect]
) -> Contender | None:
    """A rival of many sizes where it copies the named cause; None where it does not.

    The evidence knows one axis at a time, at the place where that explains most: what copies a
    wrong weight is a gain of all axes of all legs.
    """
    effect = table[signature.effect]
    if len(effect.sizes) == 1:
        return None
    cos, sizes = copied(lib, named.signature, named.values, signature)
    if cos < LIKE:
        return None
    values = {
        p.name: float(np.clip(p.neutral + sizes[p.name], p.lower, p.upper))
        for p in effect.sizes if p.name in sizes
    }  # fmt: skip
    return Contender(signature, {**dict(signature.shape), **values}, copies=True)


def _in_its_place(
    signature: Signature, answer: Diagnosis, table: Mapping[str, Effect]
) -> Contender:
    """A rival as it explains the data in the place of the named cause, not beside it."""
    evidence, lib = answer.search.first, answer.library
    alike = [
        c for c, (effect, _, where) in enumerate(lib.causes)
        if (effect, where) == (signature.effect, signature.where)
    ]  # fmt: skip
    if not alike:
        return _sized(signature, 0.0, table)
    c = alike[int(np.argmax(evidence.gain.sum(axis=0)[alike]))]
    best = lib.problem.signatures[lib.index(int(evidence.best[c]))]
    return _sized(best, float(evidence.size[c]), table)


def _sized(signature: Signature, by: float, table: Mapping[str, Effect]) -> Contender:
    """An effect of a size; of its usual one where the evidence gives none."""
    size = next(p for p in table[signature.effect].sizes if p.name == signature.parameter)
    value = min(max(size.neutral + (by or size.prior_sd), size.lower), size.upper)
    return Contender(signature, {**dict(signature.shape), signature.parameter: value})
