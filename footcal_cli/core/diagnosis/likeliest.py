"""The most probable effect of a set of rivals stands for all of them.

Of the room of the diagnosis; `footcal_cli.core.diagnosis.investigation` asks. The search names
what fits best; of a set that cannot be distinguished the extended calibration holds what blocks
that no fit had seen make most probable.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from footcal_cli.core.diagnosis.answer import Cause, Compared, Diagnosis, Verdict
from footcal_cli.core.diagnosis.contenders import refitted_with
from footcal_cli.core.diagnosis.ends import at_an_end
from footcal_cli.core.diagnosis.path import continued
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.standing import Standing, standing
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.inference.evidence import Interval

_MORE = 0.01
"""By so much of a probability another effect of the set is more probable."""


def by_the_likeliest(subject: Subject, stands: Standing, rules: Rules, seed: int) -> Standing:
    """The answer with the most probable effect of each set in front, where that stands as well."""
    path = stands.path
    if stands.verdict is not Verdict.AMBIGUOUS or path.model is None:
        return stands
    causes, model = list(path.causes), path.model
    for i, cause in enumerate(path.causes):
        other = _likeliest(cause, path.answers[i])
        if other is None:
            continue
        rest = [*causes[:i], *causes[i + 1 :]]
        model = refitted_with(
            subject, [*rest, other], subject.refitted_from(rest, model) if rest else None
        )
        causes[i] = other
    if causes == list(path.causes) or at_an_end(subject, causes, model):
        return stands
    begun = replace(path, causes=tuple(causes), rounds=path.rounds[:-1])
    swapped = continued(subject, begun, model, seed)
    again = standing(subject, swapped, stands.verdict, stands.share, rules, seed)
    return again if again.holds else stands


def _likeliest(cause: Cause, answer: Diagnosis) -> Cause | None:
    """The cause with the most probable rival in its place; None where it is that itself."""
    shares, mine = cause.probability, cause.signature.effect
    best = max(shares, key=lambda name: shares[name], default=mine)
    if best == mine or shares[best] < shares[mine] + _MORE:
        return None
    signature = next(s for s in cause.rivals if s.effect == best)
    size = next((r.size for r in answer.effects if r.signature.effect == best), cause.size)
    rivals = (cause.signature, *(s for s in cause.rivals if s.effect != best))
    of_it = cause.odds.get(best, 1.0)
    odds = {name: cause.odds.get(name, 1.0) / of_it for name in shares if name != best}
    return replace(
        cause, signature=signature, size=size, rivals=rivals, places=(), odds=odds,
        compared=_seen_from(cause.compared, mine, best),
    )  # fmt: skip


def _seen_from(compared: Mapping[str, Compared], mine: str, best: str) -> dict[str, Compared]:
    """What is known of the former first against the new one: ``1/(1 + e) − 1``; of no other."""
    found = compared.get(best)
    if found is None:
        return {}
    low, value, high = (
        1.0 / (1.0 + e) - 1.0 for e in (found.excess.high, found.excess.value, found.excess.low)
    )
    turned = Interval(value, low, high)
    return {mine: Compared(turned, found.left_by_named, found.left)}
