"""The whole diagnosis of real logs: name one effect, refit, look again, at most four times."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause, Diagnosis, MovedGain, Verdict
from footcal_cli.core.diagnosis.bridge import Describe, problem_from
from footcal_cli.core.diagnosis.engine import leftover
from footcal_cli.core.diagnosis.floor import is_large
from footcal_cli.core.diagnosis.gain import Gain, gains_of, main_gain
from footcal_cli.core.diagnosis.kinds import of_another_kind
from footcal_cli.core.diagnosis.likeliest import by_the_likeliest
from footcal_cli.core.diagnosis.material import Nameless
from footcal_cli.core.diagnosis.odd_spell import OddSpell, odd_spell
from footcal_cli.core.diagnosis.path import Path, as_one_mixture, beginning, grown, jumped
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.sized import is_sized
from footcal_cli.core.diagnosis.standing import Standing, happened, standing
from footcal_cli.core.diagnosis.stated import stated_size
from footcal_cli.core.diagnosis.subject import Advance, Subject, uncounted
from footcal_cli.core.diagnosis.verdicts import NAMING, form_matters, judged, usual_beside
from footcal_cli.core.diagnosis.ways import (
    another_way,
    as_a_curve,
    at_its_size,
    matters_of,
    nameless_beside,
    second_cause,
    shows_in_moments,
    two_of_a_set,
    unnamed_matters,
    without_first,
)
from footcal_cli.core.effects.contract import Effect, GridOf, unit_of
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.refit import Refit


@dataclass(frozen=True)
class Found:
    """One effect of the extended model.

    Parameters
    ----------
    cause, effect, answer
        As the engine named it, its size after the refit; its row; the diagnosis it was named in.
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

    @property
    def units(self) -> dict[str, str]:
        """Unit of each parameter where it acts."""
        members = [m for _, own in self.cause.signature.owners for m in own]
        return {p.name: unit_of(p.unit, members) for p in self.effect.parameters}


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
    case, problem
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
    once
        Whether the cause happened once (`footcal_cli.core.diagnosis.path.jumped`).
    odd
        The spell of a walk that is unlike all others.
    gains_moved
        Every gain against its calibration, where one of them has moved for certain.
    """

    verdict: Verdict
    rounds: tuple[Diagnosis, ...]
    found: tuple[Found, ...]
    nearest: tuple[Found, ...]
    model: Refit | None
    gains: tuple[Gain, ...]
    case: Case
    problem: Problem
    final: Problem
    share: float
    stable: float
    nameless: tuple[Nameless, ...] = ()
    once: bool = False
    odd: OddSpell | None = None
    gains_moved: tuple[MovedGain, ...] = ()

    @property
    def is_open(self) -> bool:
        """Whether nothing was named, and no single spell is why."""
        return self.verdict in (Verdict.NONE, Verdict.UNKNOWN) and self.odd is None


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
    problem = problem_from(case, rows_of(case), table.values(), describe)
    subject = Subject(case, problem, table, describe, advance)
    baseline = beginning(problem, rules, seed)
    odd = odd_spell(case, problem)
    if stopped or (odd is not None and odd.silent):
        return replace(_without_name(subject, baseline, Verdict.BAD_DATA, 0.0), odd=odd)
    large = odd is not None or is_large(case, problem)
    answer = _answered(subject, baseline, rules, seed, large=large)
    # what a name explains is odd no more: a clock that drifts is furthest off at the end
    return replace(answer, odd=odd_spell(case, answer.final) if odd and answer.found else odd)


def _answered(
    subject: Subject, baseline: Path, rules: Rules, seed: int, *, large: bool
) -> Investigation:
    """The first answer that stands; `large` is a residual that is never nothing."""
    problem, last = subject.problem, None
    for way, verdict, share in _searched(subject, baseline, rules, seed, large=large):
        if verdict not in NAMING:
            none = Verdict.UNKNOWN if verdict is Verdict.NONE and large else verdict
            last = last or _without_name(subject, way, none, share)
            continue
        if way.once:
            return named(subject, happened(subject, way, verdict))
        stands = standing(subject, way, verdict, share, rules, seed)
        if stands.holds:
            answer = named(subject, by_the_likeliest(subject, stands, rules, seed))
            sure = _sized(problem, stands.path, answer.found) and _confirmed(answer, stands)
            if verdict is not Verdict.NAMED or sure:
                return answer
        # what was chosen without a block does not predict it, or is chosen only with all of them
        matters = large or unnamed_matters(subject, way, baseline)
        none = Verdict.UNKNOWN if matters else Verdict.NONE
        last = last or replace(_without_name(subject, way, none, share), stable=stands.stable)
    return last or _without_name(subject, baseline, Verdict.NONE, 0.0)


def _confirmed(answer: Investigation, stands: Standing) -> bool:
    """Whether blocks without a say become better with a certain name where it shows most.

    Where a known calibration could take it up, its way says so instead.
    """
    gain, model = main_gain(answer.gains, answer.problem), stands.path.model
    alpha = stands.path.rounds[0].rules.alpha_name
    if gain is None or model is None or (stands.departure and stands.departure.p < alpha):
        return True
    acts = np.any(model.columns != 0.0, axis=1)
    return gain.is_confirmed(np.unique(answer.problem.block[acts]).size)


def _sized(problem: Problem, path: Path, found: Sequence[Found]) -> bool:
    rules, model = path.rounds[0].rules, path.model
    return all(
        is_sized(f.effect, f.cause, dict(zip(f.parameter_names, f.intervals, strict=True)), model,
                 problem.blocks, rules.alpha_name)
        for f in found
    )  # fmt: skip


def named(subject: Subject, stands: Standing) -> Investigation:
    """An answer with names; small gains and drifts next to them are in its model only."""
    path, found = stands.path, _found(subject, stands.path)
    if usual := usual_beside(subject, path):
        found = tuple(f for f, c in zip(found, path.causes, strict=True) if c not in usual)
    certain = stands.verdict is Verdict.AMBIGUOUS and not any(f.cause.rivals for f in found)
    return Investigation(
        verdict=Verdict.NAMED if usual and certain else stands.verdict,
        rounds=path.rounds,
        found=found,
        nearest=(),
        model=path.model,
        gains=stands.gains,
        case=subject.case,
        problem=subject.problem,
        final=path.current,
        share=stands.share,
        stable=stands.stable,
        nameless=nameless_beside(subject, path, beside=True),
        once=path.once,
    )


def _without_name(subject: Subject, path: Path, verdict: Verdict, share: float) -> Investigation:
    """An answer that names nothing; what came nearest stands beside it.

    What surely repeats, by as much as matters, is not nothing, whatever it does to left-out blocks.
    """
    problem, found = subject.problem, tuple[Nameless, ...]()
    if verdict is not Verdict.BAD_DATA:
        found = nameless_beside(subject, path, beside=False)
    last = path.rounds[-1]
    repeats = last.before.p < last.rules.alpha_unknown and any(i.repeats_much for i in found)
    return Investigation(
        verdict=Verdict.UNKNOWN if verdict is Verdict.NONE and repeats else verdict,
        rounds=path.rounds,
        found=(),
        nearest=_found(subject, path),
        model=None,
        gains=gains_of(problem, problem, problem.law),
        case=subject.case,
        problem=problem,
        final=problem,
        share=share,
        stable=1.0,
        nameless=found,
    )


def _searched(
    subject: Subject, path: Path, rules: Rules, seed: int, *, large: bool
) -> Iterator[tuple[Path, Verdict, float]]:
    """Answers: each a path from the baseline, its verdict and the share that it explains.

    The next one counts where the one before does not hold without single blocks. What explains a
    large residual is never nothing, however little it leaves.
    """
    once = jumped(subject, path, seed)
    if once:
        more = leftover(once.rounds[-1].before, rules)
        if more and not subject.problem.drifts:
            more = matters_of(subject, once, beside=True)
        first = max((c.gain.value for c in path.rounds[0].causes), default=0.0)
        if not more or (subject.problem.drifts and first <= once.share):
            yield once, Verdict.NAMED_UNKNOWN if more else Verdict.NAMED, 1.0
            return
    path = grown(subject, path, rules, seed)
    yield from _answers_of(subject, path, rules, seed, large=large)
    if once and subject.problem.drifts and not path.causes:
        yield once, Verdict.NAMED_UNKNOWN, 1.0


def _answers_of(
    subject: Subject, path: Path, rules: Rules, seed: int, *, large: bool
) -> Iterator[tuple[Path, Verdict, float]]:
    """`_searched`, from a path that grows no more."""
    strict, path = replace(rules, share_set=1.0), as_one_mixture(subject, path, seed)
    sized = at_its_size(subject, path)
    verdict, share = judged(subject, sized, strict, seed)

    matters = cache(partial(matters_of, subject, path))
    small = path.causes and not large and subject.case.finding_nm > 0.0
    if small and not matters(beside=False) and shows_in_moments(subject, path, rules):
        # of a log without L̇ whose moments are off by no more than that, no lever has a sure name
        yield path, Verdict.NONE, share
        return
    if verdict is Verdict.NAMED_UNKNOWN and not matters(beside=True):
        yield path, Verdict.NAMED, share
        return
    alone = len(path.causes) == 1 and verdict is Verdict.UNKNOWN
    explains = alone and matters(beside=False)
    much = explains or path.share >= rules.later_share
    loose = alone and much and not matters(beside=True)
    if loose and not form_matters(subject, path, strict, seed):
        # what one name leaves of its form does not matter: it need not explain all of that, and
        # none of it where it is next to nothing, or where all that mattered is explained
        little = explains or path.share >= rules.share_form
        part, whole = (0.0, 0.0) if little else (rules.share_set, strict.share_set)
        least = replace(rules, share_partly=part, share_form=part, share_set=whole)
        kind = judged(subject, sized, least, seed)[0]
        if kind in NAMING:
            if second := second_cause(subject, path, strict, seed):
                yield second
            yield path, kind if kind is Verdict.AMBIGUOUS else Verdict.NAMED, share
            return
    weak = subject.problem.pieces and any(c.p > rules.alpha_small for c in path.causes)
    unsure = verdict is Verdict.UNKNOWN or (weak and verdict is Verdict.AMBIGUOUS)
    looser = as_a_curve(path, rules)
    if unsure and not large and not matters(beside=False):
        if alone and looser is not rules:
            yield (path, *judged(subject, sized, looser, seed))
        yield path, Verdict.NONE, share
        return
    if verdict is Verdict.AMBIGUOUS and (two := two_of_a_set(subject, path, strict, seed)):
        yield two
    if verdict is not Verdict.UNKNOWN:
        yield path, verdict, share
        if path.shorter is not None:  # its last cause may be found with all blocks only
            yield from _answers_of(subject, path.shorter, rules, seed, large=large)
        return
    # what a set of rivals leaves may be a second cause, before it is their form
    another = another_way(subject, path, strict, seed)
    if another := another or without_first(subject, path, strict, seed):
        yield another
    if path.shorter is not None and of_another_kind(subject, path, rules, seed):
        # what has no name takes the place of the last cause, but perhaps not of the others
        yield from _answers_of(subject, path.shorter, rules, seed, large=large)
        return
    yield (path, *judged(subject, sized, looser if alone else rules, seed))


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
