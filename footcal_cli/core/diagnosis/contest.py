"""The named cause against its look-alikes, each in its own full refit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.diagnosis.aliases import aliases
from footcal_cli.core.diagnosis.answer import Cause, Diagnosis
from footcal_cli.core.diagnosis.case import Case, Rows
from footcal_cli.core.diagnosis.noise_credit import shrinkage
from footcal_cli.core.diagnosis.problem import Problem, Signature
from footcal_cli.core.diagnosis.refit import Refit, refit
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.scores import held_out_loss
from footcal_cli.core.diagnosis.signatures import SWITCHES, own_place
from footcal_cli.core.diagnosis.whitening import Noise, noise_of, whitened_grams
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.evidence import Interval, jackknife_interval, sign_flip_mean, sign_patterns
from footcal_cli.core.parameters import FloatArray

LOOK_ALIKE = 0.6
"""|cos| from which a cause that explains nearly as much is refitted in full too."""
NEARLY = 0.5
MOST_CONTENDERS = 6
ONE_AND_THE_SAME = 0.99
"""|cos| from which no comparison of losses separates two effects: models are never so exact."""
OF_ANY_ORDER = frozenset({"lag", "sensor_lag"})
"""Low-passes that the table knows in their first order only. A steeper one (a Butterworth) is
nearer to a delay than to that, so that no comparison of losses speaks against it: here
`Rules.alias` alone counts."""
KINDRED_LOSS = 0.15
"""Share of the gain by which an effect must do worse than one that it is known to look like: a
table's curve is never quite the cell's, and the next best may be the nearer kind."""


_SURE_CELLS = 2  # cells whose own size is sure to be something, where each has one


@dataclass(frozen=True)
class Subject:
    """What every refit of a diagnosis is about.

    Parameters
    ----------
    case, rows
        The recordings with the model so far, and which errors count.
    problem
        The baseline in arrays.
    table
        Effects by name.
    """

    case: Case
    rows: Rows
    problem: Problem
    table: Mapping[str, Effect]

    def refitted(self, causes: Sequence[Cause], start: Mapping[str, float]) -> Refit:
        """The model with all of these causes, from starting values."""
        accepted = [(self.table[c.signature.effect], c.signature) for c in causes]
        return refit(self.case, self.rows, self.problem, accepted, start)

    def without_credit(self, extended: Problem, fitted: Refit) -> Problem:
        """The extended problem without credit for making noise small."""
        share = shrinkage(self.case, self.rows, fitted.chain, fitted.values)
        return replace(extended, residual=extended.residual / share)


def decided(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit | None,
    answer: Diagnosis,
    seed: int,
) -> tuple[Cause, Refit]:
    """The named cause against its look-alikes, each in its own full non-linear refit.

    A linear proxy may prefer the wrong one of two look-alikes when the effect is large.
    """
    first = answer.causes[0]
    rules = answer.rules
    fits: list[tuple[Cause, Refit, Problem]] = []
    for signature, size in _contenders(answer, subject.table):
        cause = replace(first, signature=signature, size=size, rivals=(), places=first.places)
        if signature.effect != first.signature.effect:
            cause = replace(cause, places=())
        fitted = _extended(subject, [*causes, cause], model)
        fits.append((cause, fitted, extended_problem(subject.problem, fitted, [*causes, cause])))
    # in noise of their own all models would fit alike: judged in that of the one that leaves least
    judged = [subject.without_credit(extended, fitted) for _, fitted, extended in fits]
    noise = min((noise_of(extended) for extended in judged), key=lambda n: n.level)
    tried = [
        (cause, fitted, _white_loss(extended, noise))
        for (cause, fitted, _), extended in zip(fits, judged, strict=True)
    ]
    best = int(np.argmin([loss.sum() for _, _, loss in tried]))
    signs = sign_patterns(tried[best][2].size, seed)
    chosen, fitted, loss = _where(subject, causes, model, tried[best], noise, signs, rules)
    worse = {
        cause.signature.effect
        for cause, _, other in tried
        if sign_flip_mean(other - loss, signs) < rules.alpha_rival
    }
    blank = subject.problem if model is None else extended_problem(subject.problem, model, causes)
    needed = KINDRED_LOSS * max(float((_white_loss(blank, noise) - loss).sum()), 0.0)
    worse -= {
        cause.signature.effect
        for cause, _, other in tried
        if float((other - loss).sum()) < needed and _kindred(subject.table, chosen, cause)
    }
    alike = _aliases_of(answer, tried[best][0], tried[best][1], rules.alias)
    near = {s.effect: (s, cos) for s, cos in alike}
    mine = chosen.signature.effect
    worse -= never_told(mine, {name: cos for name, (_, cos) in near.items()})
    rivals = [*first.rivals, first.signature, *(cause.signature for cause, _, _ in tried)]
    rivals += [s for s, _ in near.values()]
    by_effect = {s.effect: s for s in rivals if s.effect not in worse | {mine}}
    return replace(chosen, rivals=tuple(by_effect.values())), fitted


def never_told(chosen: str, alike: Mapping[str, float]) -> set[str]:
    """Aliases of an effect that no comparison of losses rules out.

    Parameters
    ----------
    alike
        |cos| of effects that count as one with the chosen one.
    """
    return {
        name
        for name, cos in alike.items()
        if cos > ONE_AND_THE_SAME or OF_ANY_ORDER & {name, chosen}
    }


def _where(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit | None,
    tried: tuple[Cause, Refit, FloatArray],
    noise: Noise,
    signs: FloatArray,
    rules: Rules,
) -> tuple[Cause, Refit, FloatArray]:
    """The same effect with a value per cell, where that predicts left-out blocks better."""
    cause, _, loss = tried
    own = own_place(subject.case, subject.table[cause.signature.effect])
    if own is None:
        return tried
    where, owners = own
    apart = replace(cause, signature=replace(cause.signature, where=where, owners=owners))
    fitted = _extended(subject, [*causes, apart], model)
    extended = extended_problem(subject.problem, fitted, [*causes, apart])
    less = _white_loss(subject.without_credit(extended, fitted), noise)
    neutral = next(
        p.neutral for p in subject.table[cause.signature.effect].sizes
        if p.name == cause.signature.parameter
    )  # fmt: skip
    sure = sum(
        not interval.low <= neutral <= interval.high
        for name, interval in zip(fitted.names, fitted.intervals, strict=True)
        if name.rsplit(".", 1)[1] == cause.signature.parameter
    )
    # sizes that calibration can trade against each other are not told apart
    if sure < _SURE_CELLS or sign_flip_mean(loss - less, signs) >= rules.alpha_name:
        return tried
    return replace(apart, places=()), fitted, less


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


def _kindred(table: Mapping[str, Effect], one: Cause, other: Cause) -> bool:
    """Whether the table says that one looks like the other."""
    a, b = table[one.signature.effect], table[other.signature.effect]
    return b.name in a.mimics or a.name in b.mimics


def _contenders(answer: Diagnosis, table: Mapping[str, Effect]) -> list[tuple[Signature, Interval]]:
    """The named cause and the effects that look like it and explain nearly as much."""
    evidence, lib = answer.search.first, answer.library
    first = answer.causes[0]
    signatures = lib.problem.signatures
    mine = lib.causes.index(first.signature.cause)
    gain = evidence.gain.sum(axis=0)
    near = aliases(lib, first.signature, {first.signature.parameter: first.size.value})
    alike = {signature.effect for signature, _, cos in near if cos > LOOK_ALIKE}
    found = {first.signature.effect: (first.signature, first.size)}
    for c in np.argsort(-gain, kind="stable"):
        signature = signatures[lib.index(int(evidence.best[c]))]
        if len(found) == MOST_CONTENDERS or gain[c] < NEARLY * gain[mine]:
            break
        possible = signature.lower <= evidence.size[c] <= signature.upper
        like = signature.effect in alike or signature.effect in table[first.signature.effect].mimics
        if signature.effect not in found and like and possible:
            size = jackknife_interval(float(evidence.size[c]), evidence.size_without[:, c])
            found[signature.effect] = (signature, size)
    return list(found.values())


def _white_loss(problem: Problem, noise: Noise) -> FloatArray:
    """Held-out squared error of each block in the metric of the noise, shape (B,)."""
    bare = replace(problem, columns=problem.columns[:, :0], signatures=())
    grams, _ = whitened_grams(bare, np.empty((problem.residual.size, 0)), noise)
    return held_out_loss(grams.inner, grams.calibration)


def _extended(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit | None,
) -> Refit:
    """All accepted effects refitted together, starting from the last model."""
    start: dict[str, float] = {}
    if model is not None:
        start = {n: v for n, v in model.values.items() if n not in subject.case.values}
    newest = causes[-1]
    effect = subject.table[newest.signature.effect]
    shapes = dict(newest.signature.shape)
    for owner, _ in newest.signature.owners:
        for parameter in effect.parameters:
            value = shapes.get(parameter.name, parameter.neutral)
            if parameter.name == newest.signature.parameter:
                # the linear size may overshoot a bent effect; begin inside its range
                inside = np.clip(newest.size.value, -3 * parameter.prior_sd, 3 * parameter.prior_sd)
                value = float(np.clip(parameter.neutral + inside, parameter.lower, parameter.upper))
                value = 1.0 if effect.name in SWITCHES else value
            start.setdefault(f"{owner}.{parameter.name}", value)
    return subject.refitted(causes, start)


def extended_problem(problem: Problem, model: Refit, causes: Sequence[Cause]) -> Problem:
    """The problem on the extended model: its effects and their rivals are calibration now."""
    taken = {c.signature.effect for c in causes}
    rivals = {s for c in causes for s in (*c.rivals, *c.places)}
    rival_columns = [problem.columns[:, i] for i, s in enumerate(problem.signatures) if s in rivals]
    extra = np.stack([*model.columns.T, *rival_columns], axis=1)
    norm = np.sqrt(np.mean(extra**2, axis=0))
    extra = extra[:, norm > 0] / norm[norm > 0]
    return replace(problem.without(*taken), residual=model.residual, accepted=extra)
