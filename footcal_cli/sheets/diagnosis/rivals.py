"""How much worse the other names explain the data."""

from __future__ import annotations

from collections.abc import Set

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause, Diagnosis
from footcal_cli.core.diagnosis.comparison import OF_ANY_ORDER
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.rivals import excess_of
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.words import words
from footcal_cli.report import number
from footcal_cli.sheets.diagnosis.words import alike_by_law, share_interval, share_text

_INVISIBLE = 5e-4  # a share of which the shown digits are zeros
_NOISE = 0.05  # p above which what is left is not worth a word


def next_best(found: Investigation) -> str | None:
    """The best other name for the first cause, and by how much it is worse."""
    if not found.found or found.once:  # held-out errors say nothing of what happened once
        return None
    cause = found.found[0].cause
    mine = cause.signature.effect
    taken = {f.cause.signature.effect for f in found.found}
    if found.model is not None:
        taken |= {link.effect.name for link in found.model.chain.links}
    refitted = {name: other.excess for name, other in cause.compared.items() if name not in taken}
    others = refitted or _unfitted(found.rounds[0], mine, taken)
    if not others:
        return None
    name = min(others, key=lambda effect: others[effect].value)
    return (
        f"The next best cause, {words(name)}, leaves errors {_off(others[name])} than "
        f"{words(mine)} does{_by_form(cause, name)}."
    )


def _by_form(cause: Cause, other: str) -> str:
    """What the other one leaves of its kind's forms, where that is more than noise."""
    found = cause.compared.get(other)
    if found is None or found.left >= min(_NOISE, found.left_by_named):
        return ""
    return (
        f", and its residual is not noise (p = {number(found.left, 2)}; "
        f"with {words(cause.signature.effect)} p = {number(found.left_by_named, 2)})"
    )


def against_rivals(found: Investigation) -> list[str]:
    """Difference of held-out errors between each named effect and its rivals."""
    lines = []
    for item in found.found:
        mine = item.cause.signature.effect
        unfitted = _unfitted(item.answer, mine, {mine})
        places = {cause[::2] for cause in item.answer.library.causes}
        for rival, where in {r.effect: r.where for r in item.cause.rivals}.items():
            if (rival, where) not in places:
                lines.append(f"{alike_by_law(rival, where, mine)}.")
                continue
            other = item.cause.compared.get(rival)
            more = unfitted.get(rival) if other is None else other.excess
            if more is None:
                continue
            says = "too little to rule it out."
            if more.high < 0.0:
                says = "by blocks left out, that is the better one."
            elif more.low <= 0.0:
                says = "no difference to rely on."
            elif rival in OF_ANY_ORDER and mine not in OF_ANY_ORDER:
                says = f"of first order it does, a steeper low-pass acts as {words(mine)} does."
            lines.append(f"{words(rival)} leaves errors {_off(more)} than {words(mine)}: {says}")
    return [line[0].upper() + line[1:] for line in lines]


def _unfitted(diagnosis: Diagnosis, mine: str, taken: Set[str]) -> dict[str, Interval]:
    """Excess of the error of other effects by their signatures, where no refit compared them."""
    best = losses_with(diagnosis, mine)
    if best is None:
        return {}
    return {
        effect: excess_of(loss, best)
        for effect in dict.fromkeys(cause[0] for cause in diagnosis.library.causes)
        if effect not in taken and (loss := losses_with(diagnosis, effect)) is not None
    }


def losses_with(diagnosis: Diagnosis, effect: str) -> FloatArray | None:
    """Squared held-out error of each block with an effect where it explains most, shape (B,)."""
    evidence = diagnosis.search.first
    causes = [c for c, cause in enumerate(diagnosis.library.causes) if cause[0] == effect]
    if not causes:
        return None
    best = causes[int(np.argmax(evidence.gain.sum(axis=0)[causes]))]
    loss: FloatArray = diagnosis.before.loss - evidence.plain_gain[:, best]
    return loss


def _off(more: Interval) -> str:
    """By what share errors are larger, or smaller, with its interval."""
    if more.value >= 0.0:
        return f"{_percent(more)} larger"
    return f"{_percent(Interval(-more.value, -more.high, -more.low))} smaller"


def _percent(interval: Interval) -> str:
    if max(abs(interval.low), abs(interval.value), abs(interval.high)) < _INVISIBLE:
        return "less than 0.1 %"
    return f"{share_text(interval.value)} {share_interval(interval.low, interval.high)}"
