"""The whole diagnosis of real logs: name one effect, refit, look again, at most four times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause, Diagnosis, Verdict
from footcal_cli.core.diagnosis.bridge import Describe, problem_from
from footcal_cli.core.diagnosis.case import Case, Rows, rows_of
from footcal_cli.core.diagnosis.contest import decided, extended_problem
from footcal_cli.core.diagnosis.engine import diagnose, leftover
from footcal_cli.core.diagnosis.gain import Gain, gains_of
from footcal_cli.core.diagnosis.problem import Problem
from footcal_cli.core.diagnosis.refit import Refit
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.scores import held_out_loss
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.evidence import Interval


@dataclass(frozen=True)
class Found:
    """One effect of the extended model.

    Parameters
    ----------
    cause
        As the engine named it; its size after the refit.
    parameter_names, intervals
        Every fitted parameter of the effect with its 95 % interval.
    """

    cause: Cause
    parameter_names: tuple[str, ...]
    intervals: tuple[Interval, ...]


@dataclass(frozen=True)
class Investigation:
    """The answer about real logs.

    Parameters
    ----------
    verdict
        One word.
    rounds
        The engine's diagnosis of each model in turn: baseline first, extended last.
    found
        Named effects, in order, after the refit of all of them together.
    model
        The extended model; None if nothing was named.
    gains
        Held-out errors per output.
    case, rows, problem
        The baseline.
    final
        The problem on the extended model.
    stable
        Share of folds in which the selection, repeated without the fold, chose the same effect.
    """

    verdict: Verdict
    rounds: tuple[Diagnosis, ...]
    found: tuple[Found, ...]
    model: Refit | None
    gains: tuple[Gain, ...]
    case: Case
    rows: Rows
    problem: Problem
    final: Problem
    stable: float


def investigate(
    case: Case,
    table: Mapping[str, Effect],
    describe: Describe,
    rules: Rules | None = None,
    seed: int = 0,
) -> Investigation:
    """Diagnose logs: baseline, then the model extended by each accepted effect in turn.

    Parameters
    ----------
    case
        Logs, chain and calibration.
    table
        Effects by name.
    describe
        Gives the recorded signals of a case.
    rules, seed
        Thresholds; of sign patterns.
    """
    rules = rules or Rules()
    one = replace(rules, most_effects=1)
    rows = rows_of(case)
    problem = problem_from(case, rows, table.values(), describe)
    current, model = problem, None
    rounds: list[Diagnosis] = []
    causes: list[Cause] = []
    while True:
        answer = diagnose(current, one, seed)
        rounds.append(answer)
        if not answer.causes or len(causes) == rules.most_effects:
            break
        cause, model = decided(case, rows, problem, table, causes, model, answer, seed)
        causes.append(cause)
        current = extended_problem(problem, model, causes)
    found, stable = _found(causes, model), _stability(rounds)
    return Investigation(
        verdict=_verdict(rounds, causes, rules),
        rounds=tuple(rounds),
        found=found,
        model=model,
        gains=gains_of(problem, current if model else problem),
        case=case,
        rows=rows,
        problem=problem,
        final=current,
        stable=stable,
    )


def _found(causes: Sequence[Cause], model: Refit | None) -> tuple[Found, ...]:
    if model is None:
        return ()
    found = []
    for cause in causes:
        owners = [owner for owner, _ in cause.signature.owners]
        mine = [
            i for i, name in enumerate(model.names) if name.rsplit(".", 1)[0] in owners
            and name.rsplit(".", 1)[1] in _parameters(cause, model)
        ]  # fmt: skip
        size = next(
            model.intervals[i] for i in mine if model.names[i].endswith(cause.signature.parameter)
        )
        found.append(
            Found(
                replace(cause, size=size),
                tuple(model.names[i] for i in mine),
                tuple(model.intervals[i] for i in mine),
            )
        )
    return tuple(found)


def _parameters(cause: Cause, model: Refit) -> set[str]:
    effects = [item.effect for item in model.chain.links]
    mine = next(e for e in effects if e.name == cause.signature.effect)
    return {p.name for p in mine.parameters}


def _stability(rounds: Sequence[Diagnosis]) -> float:
    """Share of blocks whose leaving out leaves the first choice the same."""
    first = rounds[0]
    if not first.causes:
        return 1.0
    gain = first.search.first.gain
    lib = first.library
    chosen = lib.causes.index(first.causes[0].signature.cause)
    effects = [c[0] for c in lib.causes]
    without = gain.sum(axis=0, keepdims=True) - gain
    best = np.argmax(without, axis=1)
    return float(np.mean([effects[b] == effects[chosen] for b in best]))


def _verdict(rounds: Sequence[Diagnosis], causes: Sequence[Cause], rules: Rules) -> Verdict:
    """The engine's verdict on the first round, corrected by what the refits left."""
    first, last = rounds[0], rounds[-1]
    if first.verdict is Verdict.UNDERPOWERED or not causes:
        return first.verdict
    start = held_out_loss(first.grams.inner, first.grams.calibration, first.grams.plain).sum()
    end = held_out_loss(last.grams.inner, last.grams.calibration, last.grams.plain).sum()
    named = max(float(start - end), 0.0)
    left = max(float(last.before.flexible_gain.sum()), 0.0)
    share = named / max(named + left, 1e-300)
    more = leftover(last.before, rules)
    if share < rules.share_named or (more and share < rules.share_partly):
        return Verdict.UNKNOWN
    if any(cause.rivals for cause in causes):
        return Verdict.AMBIGUOUS
    return Verdict.NAMED_UNKNOWN if more else Verdict.NAMED
