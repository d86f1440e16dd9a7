"""The whole diagnosis of real logs: name one effect, refit, look again, at most four times."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.diagnosis.case import Case, Rows, balanced, residual, rows_of
from footcal_cli.core.diagnosis.engine import (
    Cause,
    Diagnosis,
    EffectStatus,
    Verdict,
    diagnose,
    leftover,
)
from footcal_cli.core.diagnosis.problem import Problem, Signature
from footcal_cli.core.diagnosis.refit import Refit, refit
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.scores import cosines, held_out_loss
from footcal_cli.core.diagnosis.signatures import (
    SWITCHES,
    calibration_columns,
    direction_columns,
    library_columns,
)
from footcal_cli.core.diagnosis.tracking import Tracking
from footcal_cli.core.diagnosis.whitening import whitened_grams
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.evidence import (
    Interval,
    jackknife_interval,
    sign_flip_mean,
    sign_patterns,
    smallest_p,
)
from footcal_cli.core.parameters import FloatArray

Describe = Callable[[Case, Rows], tuple[Mapping[str, FloatArray], Mapping[str, FloatArray]]]
"""Regressors (m,) and block-level covariates (B,) of a case."""


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
class Gain:
    """What the extended model buys on blocks it was not fitted to, per output.

    Parameters
    ----------
    output, unit
        The quantity.
    before, after
        Held-out RMS error.
    change
        Relative reduction with its 95 % interval over blocks.
    per_block
        Held-out RMS error of each block before and after, shape (B, 2).
    """

    output: str
    unit: str
    before: float
    after: float
    change: Interval
    per_block: FloatArray


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


def problem_from(case: Case, rows: Rows, effects: Iterable[Effect], describe: Describe) -> Problem:
    """Arrays of a case: residual, calibration and library by differentiating its chain."""
    ideal = balanced(case, case.values)
    library = library_columns(ideal, rows, effects)
    regressors, covariates = describe(ideal, rows)
    tracking, turn = None, None
    if case.drifts and case.directions:
        calibration = direction_columns(ideal, rows)
        _, kind = np.unique([d.kind for d in case.directions], return_inverse=True)
        tracking = Tracking(rows.time_s, rows.log, kind.astype(np.int64))
    else:
        calibration, turn = calibration_columns(ideal, rows)
    tolerance = np.array(
        [case.tolerance_nm if unit == "Nm" else case.tolerance_n for unit in rows.units]
    )
    return Problem(
        residual=residual(case, rows, case.values),
        calibration=calibration,
        calibration_names=tuple(f"direction {i + 1}" for i in range(calibration.shape[1])),
        columns=library.columns,
        signatures=library.signatures,
        block=rows.block,
        output=rows.output,
        sequence=rows.sequence,
        outputs=rows.outputs,
        units=rows.units,
        noise=rows.noise,
        tolerance=tolerance,
        regressors=regressors,
        rate_hz=rows.rate_hz,
        covariates=covariates,
        excluded=library.excluded,
        calibration_turn=turn,
        tracking=tracking,
        alike=case.alike,
        drifts=case.drifts,
    )


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
        cause, model = _decided(case, rows, problem, table, causes, model, answer, seed)
        causes.append(cause)
        current = _after(problem, model, causes)
    found, stable = _found(causes, model), _stability(rounds)
    return Investigation(
        verdict=_verdict(rounds, causes, rules),
        rounds=tuple(rounds),
        found=found,
        model=model,
        gains=_gains(problem, current if model else problem),
        case=case,
        rows=rows,
        problem=problem,
        final=current,
        stable=stable,
    )


LOOK_ALIKE = 0.6
"""|cos| from which a cause that explains nearly as much is refitted in full too."""
NEARLY = 0.5
MOST_CONTENDERS = 4


def _decided(
    case: Case,
    rows: Rows,
    problem: Problem,
    table: Mapping[str, Effect],
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
    tried: list[tuple[Cause, Refit, FloatArray]] = []
    for signature, size in _contenders(answer):
        cause = replace(first, signature=signature, size=size, rivals=(), places=first.places)
        if signature.effect != first.signature.effect:
            cause = replace(cause, places=())
        fitted = _extended(case, rows, problem, table, [*causes, cause], model)
        tried.append((cause, fitted, _white_loss(_after(problem, fitted, [*causes, cause]))))
    best = int(np.argmin([loss.sum() for _, _, loss in tried]))
    chosen, fitted, loss = tried[best]
    signs = sign_patterns(loss.size, seed)
    worse = {
        cause.signature.effect
        for cause, _, other in tried
        if sign_flip_mean(other - loss, signs) < rules.alpha_rival
    }
    rivals = [s for s in first.rivals if s.effect not in worse]
    rivals += [cause.signature for cause, _, _ in tried if cause.signature.effect not in worse]
    if first.signature.effect in worse:
        rivals = [s for s in rivals if s.effect != first.signature.effect]
    kept = tuple(dict.fromkeys(s for s in rivals if s.effect != chosen.signature.effect))
    return replace(chosen, rivals=kept), fitted


def _contenders(answer: Diagnosis) -> list[tuple[Signature, Interval]]:
    """The named cause and the effects that look like it and explain nearly as much."""
    evidence, lib = answer.search.first, answer.library
    first = answer.causes[0]
    signatures = lib.problem.signatures
    mine = lib.causes.index(first.signature.cause)
    gain = evidence.gain.sum(axis=0)
    cos = np.abs(cosines(answer.grams.inner, answer.grams.calibration, evidence.best))[mine]
    found = {first.signature.effect: (first.signature, first.size)}
    for c in np.argsort(-gain):
        signature = signatures[lib.index(int(evidence.best[c]))]
        if len(found) == MOST_CONTENDERS or gain[c] < NEARLY * gain[mine]:
            break
        possible = signature.lower <= evidence.size[c] <= signature.upper
        if signature.effect not in found and cos[c] > LOOK_ALIKE and possible:
            size = jackknife_interval(float(evidence.size[c]), evidence.size_without[:, c])
            found[signature.effect] = (signature, size)
    return list(found.values())


def _white_loss(problem: Problem) -> FloatArray:
    """Held-out squared error of each block in the metric of the noise, shape (B,)."""
    bare = replace(problem, columns=problem.columns[:, :0], signatures=())
    grams, _ = whitened_grams(bare, np.empty((problem.residual.size, 0)))
    return held_out_loss(grams.inner, grams.calibration)


def _extended(
    case: Case,
    rows: Rows,
    problem: Problem,
    table: Mapping[str, Effect],
    causes: Sequence[Cause],
    model: Refit | None,
) -> Refit:
    """All accepted effects refitted together, starting from the last model."""
    start: dict[str, float] = {} if model is None else {n: model.values[n] for n in model.names}
    newest = causes[-1]
    effect = table[newest.signature.effect]
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
    accepted = [(table[c.signature.effect], c.signature) for c in causes]
    return refit(case, rows, problem, accepted, start)


def _after(problem: Problem, model: Refit, causes: Sequence[Cause]) -> Problem:
    """The problem on the extended model: its effects and their rivals are calibration now."""
    taken = {c.signature.effect for c in causes}
    rivals = {s for c in causes for s in (*c.rivals, *c.places)}
    rival_columns = [problem.columns[:, i] for i, s in enumerate(problem.signatures) if s in rivals]
    extra = np.stack([*model.columns.T, *rival_columns], axis=1)
    norm = np.sqrt(np.mean(extra**2, axis=0))
    extra = extra[:, norm > 0] / norm[norm > 0]
    return replace(problem.without(*taken), residual=model.residual, accepted=extra)


def _found(causes: Sequence[Cause], model: Refit | None) -> tuple[Found, ...]:
    if model is None:
        return ()
    found = []
    for cause in causes:
        owners = [owner for owner, _ in cause.signature.owners]
        mine = [
            i for i, name in enumerate(model.names) if name.rsplit(".", 1)[0] in owners
            and name.rsplit(".", 1)[1] in _parameters(cause)
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


def _parameters(cause: Cause) -> set[str]:
    return {cause.signature.parameter, *(name for name, _ in cause.signature.shape)}


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


def _gains(before: Problem, after: Problem) -> tuple[Gain, ...]:
    """Held-out errors of the baseline and of the extended model, block by block."""
    losses = []
    for problem in (before, after):
        bare = replace(problem, columns=problem.columns[:, :0], signatures=())
        grams, _ = whitened_grams(bare, np.empty((problem.residual.size, 0)))
        base = grams.calibration
        losses.append(
            np.stack([held_out_loss(grams.inner, base, own) for own in grams.by_output], axis=1)
        )
    gains = []
    for o, (name, unit) in enumerate(zip(before.outputs, before.units, strict=True)):
        rows = before.output == o
        count = np.bincount(before.block[rows], minlength=before.blocks)
        used = (count > 0) & (losses[0][:, o] > 0)
        if not used.any():
            continue
        noise = float(before.noise[rows][0])
        old, new = losses[0][used, o], losses[1][used, o]
        whole = [float(np.sqrt(x.sum() / count[used].sum())) * noise for x in (old, new)]
        share = np.array(
            [
                1.0 - np.sqrt((new.sum() - n) / max(old.sum() - a, 1e-300))
                for a, n in zip(old, new, strict=True)
            ]
        )
        gains.append(
            Gain(
                name, unit, whole[0], whole[1],
                jackknife_interval(1.0 - whole[1] / max(whole[0], 1e-300), share),
                np.sqrt(np.stack([old, new], 1) / count[used, None]) * noise,
            )
        )  # fmt: skip
    return tuple(gains)


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


def reachable(problem: Problem) -> float:
    """Smallest p that so many blocks can reach."""
    return float(smallest_p(float(problem.blocks)))


__all__ = [
    "EffectStatus", "Found", "Gain", "Investigation", "investigate", "problem_from", "reachable",
]  # fmt: skip
