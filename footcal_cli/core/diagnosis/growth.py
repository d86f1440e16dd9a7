"""One more cause: the best that stands its refit together with all others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause, Diagnosis
from footcal_cli.core.diagnosis.beyond import is_beyond
from footcal_cli.core.diagnosis.comparison import decided
from footcal_cli.core.diagnosis.engine import diagnose
from footcal_cli.core.diagnosis.refusal import Why
from footcal_cli.core.diagnosis.sized import is_something, is_sure
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.parameters import FloatArray


def grown_by_one(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit | None,
    current: Problem,
    answer: Diagnosis,
    start: float | None,
    seed: int,
) -> tuple[tuple[list[Cause], Refit] | None, Diagnosis]:
    """The model with one more cause: the best that stands its refit, and the answer it is of.

    What the linear proxy likes best may be nothing once all is refitted; the next best in the same
    family is then tried, a few times.

    Parameters
    ----------
    subject
        What is diagnosed.
    causes, model
        What was named, and the model with it; None without any.
    current, answer
        The problem on that model, and what the engine said of it.
    start
        Held-out squared error before anything was named.
    seed
        Of sign patterns.
    """
    first, failed, tries = answer, frozenset[str](), 0
    unsettled: tuple[tuple[list[Cause], Refit], Diagnosis] | None = None
    while answer.causes and tries < answer.rules.most_tries:
        cause, fitted = decided(subject, causes, model, answer, seed, failed)
        needed, fitted = _needed(subject, [*causes, cause], fitted)
        sure = not causes or is_sure(cause, subject.table[cause.signature.effect], fitted)
        if cause in needed and len(needed) > len(causes):
            if not sure:
                break
            if fitted.converged:
                return (needed, fitted), answer
            unsettled = unsettled or ((needed, fitted), answer)
        failed |= {cause.signature.effect}
        if cause.signature.effect != answer.causes[0].signature.effect:
            continue  # a look-alike that is nothing itself says nothing of the named one
        tries += 1
        answer = diagnose(current, answer.rules, seed, start, failed)
    return unsettled or (None, first)


def grown_beyond_form(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit,
    current: Problem,
    answer: Diagnosis,
    start: float | None,
    seed: int,
) -> tuple[tuple[list[Cause], Refit], Diagnosis] | None:
    """As `grown_by_one`, of a cause that was refused as form of the others and surely is none.

    It need not remove the share of what they remove (`Rules.second_share`), since no form of them
    does what it does (`footcal_cli.core.diagnosis.beyond`). Only a second cause: of two, each with
    a form of its own, too much is a third.

    Returns
    -------
    None where none was refused for that, or it may be their form.
    """
    if len(causes) > 1 or all(one.why is not Why.FORM for one in answer.search.refused):
        return None
    rules = replace(answer.rules, second_share=answer.rules.pair_share)
    again = diagnose(current, rules, seed, start)
    found, again = grown_by_one(subject, causes, model, current, again, start, seed)
    if found is None:
        return None
    last = len(causes)
    beyond = is_beyond(subject, found[1], found[0], last, range(last), rules, seed)
    return (found, again) if beyond else None


def named_columns(model: Refit | None, causes: Sequence[Cause]) -> FloatArray:
    """What the named sizes add to the residual at the optimum, shape (m, k)."""
    if model is None:
        return np.empty((0, 0))
    sizes = {c.signature.parameter for c in causes}
    named = [i for i, name in enumerate(model.names) if name.rsplit(".", 1)[1] in sizes]
    return model.columns[:, named]


def _needed(
    subject: Subject,
    causes: Sequence[Cause],
    fitted: Refit,
) -> tuple[list[Cause], Refit]:
    """Causes whose sizes are something once all are in the model, refitted without the others."""
    kept = [c for c in causes if is_something(c, subject.table[c.signature.effect], fitted)]
    if len(kept) == len(causes) or not kept:
        return kept, fitted
    return kept, subject.refitted_from(kept, fitted)
