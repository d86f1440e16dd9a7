"""Effects that chance does not explain and that are no cause all the same, and why."""

from __future__ import annotations

from collections.abc import Sequence

from footcal_cli.core.diagnosis.refusal import Refusal, Why
from footcal_cli.plots.words import capital, words
from footcal_cli.report import number
from footcal_cli.sheets.diagnosis.words import handy_unit, together


def refused_lines(refusals: Sequence[Refusal]) -> list[str]:
    """One sentence per reason, each effect of it once with its places."""
    lines = []
    for why in Why:
        named: dict[str, list[Refusal]] = {}
        for refusal in refusals:
            if refusal.why is why:
                named.setdefault(refusal.signature.effect, []).append(refusal)
        if named:
            parts = [f"{words(effect)}{_places(same, why)}" for effect, same in named.items()]
            lines.append(f"{capital('; '.join(parts))}: {_reason(why)}.")
    return lines


def _places(same: Sequence[Refusal], why: Why) -> str:
    """Where an effect was tried, each place once with its number."""
    places = {item.signature.where: _figure(item, why) for item in same}
    if set(places) <= {"", "robot"}:
        return "".join(places.values())
    return f" in {together(f'{where}{figure}' for where, figure in places.items())}"


def _figure(refusal: Refusal, why: Why) -> str:
    """The number that decides."""
    share, limit = (f"{100 * value:.1f} %" for value in (refusal.share, refusal.limit))
    match why:
        case Why.IMPOSSIBLE | Why.SMALL:
            factor, unit = handy_unit(refusal.size, refusal.signature.unit)
            return f" ({number(factor * refusal.size, 2)} {unit})"
        case Why.LITTLE:
            return f" ({share} of the squared error, {limit} are needed)"
        case Why.FORM:
            return f" ({share} of the squared error)"
        case Why.UNSURE:
            return f" (p = {number(refusal.p, 2)}, at most {refusal.limit:g} is allowed)"
        case Why.SUPERSEDED:
            return ""


def _reason(why: Why) -> str:
    return {
        Why.IMPOSSIBLE: "no such size is possible",
        Why.LITTLE: "not by chance, but it predicts too little of the blocks it was not fitted to",
        Why.FORM: "too little next to the causes before it, and it may come from their form",
        Why.UNSURE: "not by chance, but not sure to predict blocks it was not fitted to",
        Why.SMALL: "not by chance, but too small to matter",
        Why.SUPERSEDED: "not needed once the others are in the model",
    }[why]
