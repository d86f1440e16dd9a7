"""The way through the search: one more cause at a time, or two at once, each in a full refit."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.answer import Cause, Diagnosis
from footcal_cli.core.diagnosis.beyond import is_beyond
from footcal_cli.core.diagnosis.change_points import best_between
from footcal_cli.core.diagnosis.comparison import decided_again
from footcal_cli.core.diagnosis.contenders import refitted_with
from footcal_cli.core.diagnosis.ends import at_an_end
from footcal_cli.core.diagnosis.engine import diagnose
from footcal_cli.core.diagnosis.gain import losses, without_rivals
from footcal_cli.core.diagnosis.growth import grown_beyond_form, grown_by_one
from footcal_cli.core.diagnosis.jumps import Jump, once_beside
from footcal_cli.core.diagnosis.material import repeating
from footcal_cli.core.diagnosis.mixtures import LINEAR, against_mixtures, mixtures_of
from footcal_cli.core.diagnosis.rules import LEVEL_SHARE, Rules
from footcal_cli.core.diagnosis.search import beside
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.inference.evidence import Interval, sign_patterns
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.parameters import FloatArray

_RCOND = 1e-9
_CLEAR = 2.0
"""Half widths of its 95 % interval that a jump is from nothing: as sure as the jump, p 1e-4."""


@dataclass(frozen=True)
class Path:
    """What was named so far, and what is left.

    Parameters
    ----------
    causes, model
        Named effects, and the model with them; None without any.
    answers
        The diagnosis that each of them was named in.
    rounds
        Diagnoses of the models on the way, the baseline first.
    current
        The problem on the model, its rivals calibration too.
    start, removed
        Held-out squared error of the baseline in the noise of the model, None without one, and
        what of it the names remove.
    pair
        Whether it began with two causes at once.
    once
        Whether its cause happened once, which no block repeats (`jumped`).
    both_ways
        Whether each of its two causes was looked for anew beside the other, and found
        (`found_both_ways`).
    dropped
        Of causes that were needed no longer beside later ones: the effects that began with them.
    shorter
        The path before its last cause, if that has any.
    instead
        Other pairs that were refitted before this one, and left something.
    """

    causes: tuple[Cause, ...]
    model: Refit | None
    answers: tuple[Diagnosis, ...]
    rounds: tuple[Diagnosis, ...]
    current: Problem
    start: float | None = None
    removed: float = 0.0
    pair: bool = False
    once: bool = False
    both_ways: bool = False
    dropped: tuple[frozenset[str], ...] = ()
    shorter: Path | None = None
    instead: tuple[Path, ...] = ()

    @property
    def share(self) -> float:
        """Of the baseline's held-out squared error, what the names remove."""
        return self.removed / self.start if self.start else 0.0

    @property
    def effects(self) -> list[str]:
        """Names of its causes in alphabetical order."""
        return sorted(cause.signature.effect for cause in self.causes)

    @cached_property
    def repeats(self) -> FloatArray:
        """Mean square of what repeats in each output beside the names, in units of its noise."""
        last = self.rounds[-1]
        bends_with = last.before.bends_with(last.rules.alpha_unknown)
        return repeating(self.current, last.features, bends_with)


def beginning(problem: Problem, rules: Rules, seed: int, without: Collection[str] = ()) -> Path:
    """The baseline, diagnosed; no cause yet, and some effects not tried as one."""
    one = replace(rules, most_effects=1)
    first = diagnose(problem, one, seed, failed=frozenset(without))
    return Path((), None, (), (first,), problem)


def grown(subject: Subject, path: Path, rules: Rules, seed: int) -> Path:
    """The path with one more cause at a time, until none is left or the most are reached.

    As it began where refitted causes predict no block better: the linear proxy was wrong there.
    """
    baseline = path
    while len(path.causes) < rules.most_effects and not at_an_end(subject, path.causes, path.model):
        found, answer = grown_by_one(
            subject, path.causes, path.model, path.current, path.rounds[-1], path.start, seed
        )
        if found is None and path.model is not None:
            more = grown_beyond_form(
                subject, path.causes, path.model, path.current, answer, path.start, seed
            )
            found, answer = more or (None, answer)
        path = replace(path, rounds=(*path.rounds[:-1], answer))
        if found is None:
            break
        answers = (*path.answers, answer)
        causes, model = decided_again(subject, *found, answers, seed)
        begun = replace(path, causes=tuple(causes), answers=answers)
        longer = continued(subject, begun, model, seed)
        if path.causes and longer.share <= path.share:
            break  # a further cause that predicts no block better is the form of those before it
        before = path if path.causes else None
        path = replace(_needed_alone(subject, longer, seed), shorter=before)
    return baseline if path.causes and path.removed <= 0.0 else path


def _needed_alone(subject: Subject, path: Path, seed: int) -> Path:
    """The path without the first cause that removes too little beside those found after it.

    What another one did was first seen as an error of its own; so little would not have been named
    after the others (`Rules.later_share`).
    """
    rules, noise = path.rounds[0].rules, path.current.law
    if path.model is None or path.removed <= 0.0:
        return path
    for i in range(len(path.causes) - 1):
        others = path.causes[:i] + path.causes[i + 1 :]
        model = subject.refitted_from(others, path.model)
        before, after = losses(subject.problem, [subject.bare(model, others)], noise)
        little = before - after > (1.0 - rules.later_share) * path.removed
        of = [k for k in range(len(path.causes)) if k != i]
        if little and not is_beyond(subject, path.model, path.causes, i, of, rules, seed):
            answers = path.answers[:i] + path.answers[i + 1 :]
            dropped = (*path.dropped, path.causes[i].begun_by)
            begun = replace(path, causes=others, answers=answers, dropped=dropped)
            return continued(subject, begun, model, seed)
    return path


def continued(subject: Subject, path: Path, model: Refit, seed: int) -> Path:
    """The path with the model of its causes, diagnosed once more."""
    model = subject.beside_usual(model, path.causes)
    current = subject.extended(model, path.causes)
    # a curve that is neither of two rivals is both of them
    either = (without_rivals(current, model), current)
    start, end = losses(subject.problem, either, current.law)
    effects = {e for c in path.causes for e in c.effects}
    last = diagnose(current, beside(path.rounds[0].rules, effects), seed, start)
    return replace(
        path,
        model=model,
        rounds=(*path.rounds, last),
        current=current,
        start=start,
        removed=start - end,
    )


def as_one_mixture(subject: Subject, path: Path, seed: int) -> Path:
    """The path with a set in the place of two patterns of linear mixtures, if two are all it has.

    Together they copy further mixtures, as a shift of each cell of its own, that no single pattern
    does: the data then say that it is a mixture, and neither that it is these two nor which one.
    Two that were looked for together and leave nothing to any other mixture stay two causes.
    """
    both = [c for c in path.causes if c.effects <= LINEAR]
    if len(both) != 2 or len(path.causes) != 2 or len(set(path.effects)) != 2:
        return path
    if path.pair and path.model is not None:
        mixtures = mixtures_of(path.model.ideal, subject.problem)
        left = against_mixtures(path.current, mixtures, sign_patterns(path.current.blocks, seed))
        if left.left.p >= path.rounds[0].rules.alpha_form:
            return path
    alone = [refitted_with(subject, [cause], None) for cause in both]
    at = int(np.argmin([float(model.residual @ model.residual) for model in alone]))
    rivals = (*both[at].rivals, both[1 - at].signature, *both[1 - at].rivals)
    one = replace(both[at], rivals=tuple({s.effect: s for s in rivals}.values()))
    answer = path.answers[path.causes.index(both[at])]
    begun = replace(
        path, causes=(one,), answers=(answer,), rounds=path.rounds[:1], pair=False, both_ways=False,
        dropped=(), shorter=None,
    )  # fmt: skip
    return continued(subject, begun, alone[at], seed)


def jumped(subject: Subject, path: Path, seed: int) -> Path | None:
    """The path whose cause is a jump, of a channel at rest or from one load to the next.

    What happens once repeats in no block, and a calibration that drifts follows it soon: the
    evidence is the jump itself, against how channels usually move from swing to swing, or readings
    about their line from load to load.

    Parameters
    ----------
    subject, path
        What is diagnosed, and a path without a cause.
    seed
        Of sign patterns.

    Returns
    -------
    None where nothing surely jumps by what matters, nothing of the table jumps there, or something
    else jumps too.
    """
    problem, rules = subject.problem, path.rounds[0].rules
    if len(subject.case.logs) > 1:
        return None
    jump = once_beside(problem, problem.fitted)
    if jump.p >= rules.alpha_small or not jump.matters:
        return None
    start = float(subject.case.logs[0].time_s[0])
    signature = best_between(subject, jump.after_s - start, jump.before_s - start)
    if signature is None:
        return None
    cause = untested(signature, jump.p)
    model = refitted_with(subject, [cause], None)
    if problem.drifts and len(subject.table[signature.effect].sizes) > 1:
        # what jumped by many usual sizes along one axis did so along others
        model = refitted_with(subject, [cause], model)
    model = replace(model, intervals=of_one_step(subject, cause, model, jump))
    if all(abs(i.value) < _CLEAR * 0.5 * (i.high - i.low) for i in model.intervals):
        return None
    begun = replace(path, causes=(cause,), answers=(path.rounds[0],), once=True)
    ended = continued(subject, begun, model, seed)
    left = once_beside(ended.current, ended.current.fitted)
    small = left.is_small_beside(jump, rules.second_share)
    if not problem.drifts and max(ended.share, jump.share) < rules.share_partly:
        return None  # of a zero that drifts a step is a part; of one that jumps it is all
    quiet = left.p >= rules.alpha_unknown * LEVEL_SHARE["spell"] or not left.matters
    return ended if small or quiet else None


def of_one_step(subject: Subject, cause: Cause, model: Refit, jump: Jump) -> tuple[Interval, ...]:
    """95 % intervals of sizes of which one block knows all, so that blocks cannot show a scatter.

    ``sd² = (H⁻¹)_ii`` with H the information of the whitened innovations; all of them larger by
    what the channel that jumped differs from one swing to the next, if that is more.
    """
    bare, scale = subject.bare(model, [cause]), np.linalg.norm(model.columns, axis=0)
    only = replace(bare.without_candidates, accepted=None)
    grams, _ = whitened_grams(only, model.columns / scale, bare.law, counted=False)
    columns = np.append(grams.calibration, grams.features)
    total = grams.inner.part(columns, columns).sum(axis=0)
    sd = np.sqrt(np.diag(scaled_inverse(total, _RCOND))[grams.calibration.size :]) / scale
    units = {p.name: p.unit for p in subject.table[cause.signature.effect].parameters}
    alike = [units[name.rsplit(".", 1)[1]] == jump.unit for name in model.names]
    half = chances.norm_isf(0.025) * sd * max([1.0, *(jump.usual / sd[alike])])
    values = [model.values[name] for name in model.names]
    return tuple(Interval(v, v - h, v + h) for v, h in zip(values, half.tolist(), strict=True))


def untested(signature: Signature, p: float, size: float = 0.0) -> Cause:
    """A cause that no test was made of but the one of a p, as large as was guessed."""
    nothing = Interval(0.0, 0.0, 0.0)
    return Cause(
        signature=signature,
        size=Interval(size, size, size),
        p=p,
        gain=nothing,
        blocks_better=0,
        heterogeneity=0.0,
        rivals=(),
        places=(),
    )
