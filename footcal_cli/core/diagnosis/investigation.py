"""The whole diagnosis of real logs: name one effect, refit, look again, at most four times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause, Diagnosis, Verdict
from footcal_cli.core.diagnosis.bends import against_bends, bends_of, bent_axes
from footcal_cli.core.diagnosis.bridge import Describe, problem_from
from footcal_cli.core.diagnosis.ends import against_other_sign, held_at_zero
from footcal_cli.core.diagnosis.engine import (
    enough,
    left_apart,
    leftover,
    look_alike,
    share_of,
)
from footcal_cli.core.diagnosis.floor import is_large
from footcal_cli.core.diagnosis.form import Form, form_of
from footcal_cli.core.diagnosis.gain import Gain, bought, gains_of, without_rivals
from footcal_cli.core.diagnosis.growth import at_an_end, named_columns
from footcal_cli.core.diagnosis.material import Nameless, nameless_of
from footcal_cli.core.diagnosis.mixtures import against_mixtures, applies_to, mixtures_of
from footcal_cli.core.diagnosis.nested import nested_losses
from footcal_cli.core.diagnosis.pairs import in_other_cells, likely_pairs
from footcal_cli.core.diagnosis.path import Path, beginning, grown, together
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.stated import stated_size
from footcal_cli.core.diagnosis.subject import Advance, Subject, uncounted
from footcal_cli.core.diagnosis.unnamed import Unnamed, against_curves, applies, curves_of
from footcal_cli.core.effects.contract import Effect, GridOf
from footcal_cli.core.inference.case import Case, Rows, rows_of
from footcal_cli.core.inference.evidence import Interval, sign_patterns
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.parameters import IntArray

_CLEAR = (Verdict.NAMED, Verdict.AMBIGUOUS)
"""Verdicts that leave nothing beside the names."""
LEAST_STABLE = 0.5
"""Share of blocks without which a name is chosen again, below which it is none."""
_NAMING = (*_CLEAR, Verdict.NAMED_UNKNOWN)


@dataclass(frozen=True)
class Found:
    """One effect of the extended model.

    Parameters
    ----------
    cause, effect
        As the engine named it, its size after the refit; and its row of the table.
    answer
        The diagnosis that it was named in.
    owner
        Whose size that is: of several with one each, whose is surest not to be nothing.
    parameter_names, intervals
        Every fitted parameter of the effect with its 95 % interval.
    placed
        Shapes that were searched for, not fitted: the moment of a change.
    """

    cause: Cause
    effect: Effect
    answer: Diagnosis
    owner: str
    parameter_names: tuple[str, ...]
    intervals: tuple[Interval, ...]
    placed: Mapping[str, float] = field(default_factory=dict)


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
        The answer: named effects, in order, after the refit of all of them together; none where
        the verdict is unknown or underpowered.
    nearest
        What came nearest where the verdict is unknown.
    model
        The extended model; None if nothing was named.
    gains
        Held-out errors per output, the selection repeated without each fold.
    case, rows, problem
        The baseline.
    final
        The problem on the extended model, its rivals calibration too; the baseline where nothing
        was named.
    share
        Share of what can be explained that the names explain.
    stable
        Share of blocks without which the same effects are chosen.
    nameless
        What repeats in each output and has no sure name.
    """

    verdict: Verdict
    rounds: tuple[Diagnosis, ...]
    found: tuple[Found, ...]
    nearest: tuple[Found, ...]
    model: Refit | None
    gains: tuple[Gain, ...]
    case: Case
    rows: Rows
    problem: Problem
    final: Problem
    share: float
    stable: float
    nameless: tuple[Nameless, ...] = ()


def investigate(
    case: Case,
    table: Mapping[str, Effect],
    describe: Describe,
    rules: Rules | None = None,
    seed: int = 0,
    *,
    stopped: bool = False,
    advance: Advance = uncounted,
) -> Investigation:
    """Diagnose logs: baseline, then the model extended by each accepted effect in turn.

    A path that ends unknown is left for one that begins with two effects, if that leaves nothing.
    Stopped by bad data it ends with the baseline: any cause would be one of wrong readings.

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
    stopped
        Whether the readings were found to be wrong (`footcal_cli.core.quality.stopping`).
    advance
        Called with how many more refits are done.
    """
    rules = rules or Rules()
    rows = rows_of(case)
    problem = problem_from(case, rows, table.values(), describe)
    subject = Subject(case, rows, problem, table, describe, advance)
    path = beginning(problem, rules, seed)
    verdict, share = Verdict.BAD_DATA, 0.0
    if not stopped:
        path, verdict, share = _searched(subject, path, rules, seed)
        if verdict is Verdict.NONE and is_large(case, rows, problem):
            verdict = Verdict.UNKNOWN
    rounds, causes, model, current = path.rounds, path.causes, path.model, path.current
    found = _found(subject, path)
    named = verdict in _NAMING
    final, model = (current, model) if named else (problem, None)
    nested, alike = None, np.ones(problem.blocks, dtype=bool)
    if named:
        nested = nested_losses(
            problem, rounds[0].library, rules, len(causes), seed, final.law, pair=path.pair
        )
        alike = nested.alike([c.begun_by for c in causes])
    gains = gains_of(problem, without_rivals(final, model), final.law, nested, alike)
    if named and (bought(gains, problem) <= 0.0 or float(np.mean(alike)) < LEAST_STABLE):
        # what was chosen without a block does not predict it, or is chosen only with all of them
        named, final, model = False, problem, None
        large = is_large(case, rows, problem) or _matters(subject, path, beside=False)
        verdict = Verdict.UNKNOWN if large else Verdict.NONE
        gains = gains_of(problem, problem, problem.law)
    return Investigation(
        verdict=verdict,
        rounds=path.rounds,
        found=found if named else (),
        nearest=() if named else found,
        model=model,
        gains=gains,
        case=case,
        rows=rows,
        problem=problem,
        final=final,
        share=share,
        stable=float(np.mean(alike)),
        nameless=() if stopped else _nameless(subject, path, beside=named),
    )


def _searched(subject: Subject, path: Path, rules: Rules, seed: int) -> tuple[Path, Verdict, float]:
    """The path from the baseline to an answer, the verdict on it and the share that it explains."""
    path = grown(subject, path, rules, seed)
    strict = replace(rules, share_set=1.0)
    verdict, share = _judged(subject, path, strict, seed)
    if verdict is Verdict.NAMED_UNKNOWN and not _matters(subject, path, beside=True):
        return path, Verdict.NAMED, share
    alone = len(path.causes) == 1 and path.share >= rules.later_share
    if verdict is Verdict.UNKNOWN and alone and not _matters(subject, path, beside=True):
        # what one name leaves of its form does not matter: it need not explain all of it
        least = replace(strict, share_partly=rules.share_set, share_form=rules.share_set)
        if _judged(subject, path, least, seed)[0] in (Verdict.NAMED, Verdict.NAMED_UNKNOWN):
            return path, Verdict.NAMED, share
    if verdict is Verdict.UNKNOWN and not _matters(subject, path, beside=False):
        return path, Verdict.NONE, share
    if verdict is not Verdict.UNKNOWN:
        return path, verdict, share
    # what a set of rivals leaves may be a second cause, before it is their form
    another = _another_way(subject, path, strict, seed)
    return another or (path, *_judged(subject, path, rules, seed))


def _matters(subject: Subject, path: Path, *, beside: bool) -> bool:
    """Whether what has no sure name is a finding; what follows no signal has no size here."""
    last = path.rounds[-1]
    found = _nameless(subject, path, beside=beside)
    return left_apart(last.before, last.rules) or any(item.matters for item in found)


def _nameless(subject: Subject, path: Path, *, beside: bool) -> tuple[Nameless, ...]:
    """What has no name beside those of a path; without `beside` they are no names either."""
    model = None if beside else path.model
    return nameless_of(subject.case, subject.problem, path.current, model, path.repeats)


def _another_way(
    subject: Subject, path: Path, rules: Rules, seed: int
) -> tuple[Path, Verdict, float] | None:
    """A path that begins with two causes at once and leaves nothing; None where none does.

    One that removes less than a path that left something is not what is wrong.
    """
    most = path.removed
    for first in dict.fromkeys(pair[0] for pair in likely_pairs(path.rounds[0].library, rules)):
        both = together(subject, path, first, seed)
        if both is not None:
            both = grown(subject, both, rules, seed)
            verdict, share = _judged(subject, both, rules, seed)
            if verdict in _CLEAR and share >= rules.share_pair and both.removed >= most:
                return both, verdict, share
            most = max(most, both.removed)
    return None


def _judged(subject: Subject, path: Path, rules: Rules, seed: int) -> tuple[Verdict, float]:
    """The verdict on a path, and the share of what can be explained that its names explain."""
    form = _form(path.current, path.model, path.causes, seed)
    unnamed = _unnamed(subject, path.current, path.model, path.causes, rules, seed)
    verdict, share = _verdict(path.rounds, path.causes, form, unnamed, rules, path.removed)
    if verdict in _NAMING and at_an_end(subject, path.causes, path.model):
        # a size that only its bound stops is the size of something else
        return Verdict.UNKNOWN, share
    sure = path.pair or all(cause.rivals for cause in path.causes)
    sure &= in_other_cells(subject.table, path.causes)
    if verdict in _NAMING and subject.case.drifts and len(path.causes) > 1 and not sure:
        # beside a calibration that drifts two causes copy a third that neither of them is
        return Verdict.UNKNOWN, share
    return verdict, share


def _form(current: Problem, model: Refit | None, causes: Sequence[Cause], seed: int) -> Form | None:
    """Whether the named sizes are the same everywhere, on the extended model."""
    named = named_columns(model, causes)
    if not named.size:
        return None
    signs = sign_patterns(current.blocks, seed)
    return form_of(current, named, signs)


def _unnamed(
    subject: Subject,
    current: Problem,
    model: Refit | None,
    causes: Sequence[Cause],
    rules: Rules,
    seed: int,
) -> tuple[Unnamed, ...]:
    """The named causes against what has no name, where they could be that."""
    named = named_columns(model, causes)
    if model is None or not named.size:
        return ()
    found = []
    signs = sign_patterns(current.blocks, seed)
    if applies(current, subject.case, causes):
        curves = curves_of(model.ideal, subject.rows)
        found.append(against_curves(subject.problem, current, named, curves, signs, rules))
    axes = bent_axes(subject.case, causes)
    if axes:
        bends = bends_of(model.ideal, subject.rows, axes)
        found.append(against_bends(current, bends, signs))
    held = held_at_zero(model, [subject.table[c.signature.effect] for c in causes], causes)
    if held.any():
        found.append(against_other_sign(current, model.columns, held, signs))
    if applies_to(subject.case, causes):
        mixtures = mixtures_of(model.ideal, subject.rows)
        found.append(against_mixtures(current, mixtures, signs))
    return tuple(found)


def _found(subject: Subject, path: Path) -> tuple[Found, ...]:
    model, found = path.model, []
    if model is None:
        return ()
    for cause, answer in zip(path.causes, path.answers, strict=False):
        owners = [owner for owner, _ in cause.signature.owners]
        mine = [
            i for i, name in enumerate(model.names) if name.rsplit(".", 1)[0] in owners
            and name.rsplit(".", 1)[1] in _parameters(cause, model)
        ]  # fmt: skip
        effect = next(
            link.effect for link in model.chain.links if link.effect.name == cause.signature.effect
        )
        named = [model.names[i].rsplit(".", 1) for i in mine]
        sizes = {
            owner: stated_size(subject, model, effect, owner, name)
            for owner, name in named if name == cause.signature.parameter
        }  # fmt: skip
        surest = max(sizes, key=lambda owner: sizes[owner].sureness)
        found.append(
            Found(
                replace(cause, size=sizes[surest]),
                effect,
                answer,
                surest,
                tuple(model.names[i] for i in mine),
                tuple(model.intervals[i] for i in mine),
                {
                    p.name: model.values[f"{owners[0]}.{p.name}"]
                    for p in effect.shapes
                    if p.grid_of is GridOf.SPAN
                },
            )
        )
    return tuple(found)


def _parameters(cause: Cause, model: Refit) -> set[str]:
    effects = [item.effect for item in model.chain.links]
    mine = next(e for e in effects if e.name == cause.signature.effect)
    return {p.name for p in mine.parameters}


def _verdict(
    rounds: Sequence[Diagnosis],
    causes: Sequence[Cause],
    form: Form | None,
    unnamed: Sequence[Unnamed],
    rules: Rules,
    removed: float,
) -> tuple[Verdict, float]:
    """The engine's verdict on the first round, corrected by what the refits left."""
    first, last = rounds[0], rounds[-1]
    quiet = first.verdict is Verdict.NONE and not causes
    if first.verdict is Verdict.UNDERPOWERED or quiet:
        return first.verdict, 0.0
    if (not causes or removed <= 0.0) and not leftover(first.before, rules):
        # the linear proxy was significant, no refitted model is anything or is better on held-out
        # blocks, and no test that knows no cause finds anything
        return Verdict.NONE, 0.0
    if not causes:
        return Verdict.UNKNOWN, 0.0
    share = share_of(removed, last.before, form)
    more = leftover(last.before, rules)
    lib = first.library
    acts_between = {
        c for i, c in enumerate(lib.causes) if lib.between[lib.index(lib.columns[i][0])]
    }
    between = any(c.signature.cause in acts_between for c in causes)
    several = any(cause.rivals for cause in causes)
    if any(rival.spoils(removed, rules, several=several) for rival in unnamed):
        return Verdict.UNKNOWN, share
    if not enough(share, last.before, form, rules, between=between, several=several) or (
        len(causes) > 1 and look_alike(lib, _columns_of(first, causes), rules)
    ):
        return Verdict.UNKNOWN, share
    if several:
        # neither which one it is nor what else is there: a set would hide the rest
        return Verdict.UNKNOWN if left_apart(last.before, rules) else Verdict.AMBIGUOUS, share
    return (Verdict.NAMED_UNKNOWN if more else Verdict.NAMED), share


def _columns_of(first: Diagnosis, causes: Sequence[Cause]) -> IntArray:
    """The column of each named cause: where it was named, in the shape that explained most there.

    Where every cell has a size of its own, the place that explained most on its own.
    """
    known, evidence = first.library.causes, first.search.first
    gain = evidence.gain.sum(axis=0)
    columns = []
    for effect, parameter, where in (cause.signature.cause for cause in causes):
        mine = [i for i, cause in enumerate(known) if cause[0] == effect]
        there = [i for i in mine if known[i] == (effect, parameter, where)]
        columns += [evidence.best[max(there or mine, key=lambda i: gain[i])]] if mine else []
    return np.array(columns, dtype=np.int64)
