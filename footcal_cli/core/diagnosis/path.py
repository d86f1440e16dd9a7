"""The way through the search: one more cause at a time, or two at once, each in a full refit."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.answer import Cause, Diagnosis
from footcal_cli.core.diagnosis.change_points import best_between
from footcal_cli.core.diagnosis.comparison import decided_again
from footcal_cli.core.diagnosis.contenders import refitted_with
from footcal_cli.core.diagnosis.ends import at_an_end
from footcal_cli.core.diagnosis.engine import diagnose
from footcal_cli.core.diagnosis.gain import losses, without_rivals
from footcal_cli.core.diagnosis.growth import grown_by_one
from footcal_cli.core.diagnosis.jumps import Jump, once_beside
from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.diagnosis.material import repeating
from footcal_cli.core.diagnosis.mixtures import LINEAR
from footcal_cli.core.diagnosis.rules import LEVEL_SHARE, Rules
from footcal_cli.core.diagnosis.search import beside
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.scores import scores
from footcal_cli.core.parameters import FloatArray

_RCOND = 1e-9


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

    @property
    def share(self) -> float:
        """Of the baseline's held-out squared error, what the names remove."""
        return self.removed / self.start if self.start else 0.0

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
        if before - after > (1.0 - rules.later_share) * path.removed:
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
    effects = {s.effect for c in path.causes for s in (c.signature, *c.rivals)}
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
    """
    both = [c for c in path.causes if {s.effect for s in (c.signature, *c.rivals)} <= LINEAR]
    if len(both) != 2 or len(path.causes) != 2 or len(set(_effects(path))) != 2:
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
    cause = _untested(signature, jump.p)
    model = refitted_with(subject, [cause], None)
    if problem.drifts and len(subject.table[signature.effect].sizes) > 1:
        # what jumped by many usual sizes along one axis did so along others
        model = refitted_with(subject, [cause], model)
    model = replace(model, intervals=_of_one_step(subject, cause, model, jump))
    if all(i.low <= 0.0 <= i.high for i in model.intervals):
        return None
    begun = replace(path, causes=(cause,), answers=(path.rounds[0],), once=True)
    ended = continued(subject, begun, model, seed)
    left = once_beside(ended.current, ended.current.fitted)
    form = left.is_form_of(jump, rules.second_share)
    if not problem.drifts and max(ended.share, jump.share) < rules.share_partly:
        return None  # of a zero that drifts a step is a part; of one that jumps it is all
    quiet = left.p >= rules.alpha_unknown * LEVEL_SHARE["spell"] or not left.matters
    return ended if form or quiet else None


def _of_one_step(subject: Subject, cause: Cause, model: Refit, jump: Jump) -> tuple[Interval, ...]:
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


def found_both_ways(subject: Subject, path: Path, seed: int) -> Path | None:
    """The path whose two causes are each the best name for what the other one leaves.

    Found one after the other, only the second was looked for beside the first, which may be a third
    cause's nearest name. Where the same two come back whichever is held, neither is.

    Returns
    -------
    None where other names come back, or the path has not two causes.
    """
    if len(path.causes) != 2:
        return None
    both = _both(subject, path, path.causes[0], seed)
    if both is None or _effects(both) != _effects(path):
        return None
    return replace(path, both_ways=True)


def _effects(path: Path) -> list[str]:
    return sorted(cause.signature.effect for cause in path.causes)


def together(subject: Subject, path: Path, stronger: int, seed: int) -> Path | None:
    """A path that begins with two causes, each the best name for what the other one leaves.

    The stronger of a pair is put into the model and the other one is looked for among all effects,
    with every test; then the first is taken out and looked for in the same way beside
    the second.

    Parameters
    ----------
    subject, path
        What is diagnosed, and a path whose first round is the baseline.
    stronger
        Candidate by number; its partner is looked for anew, so that pairs which share it are one.
    seed
        Of sign patterns.

    Returns
    -------
    None where one of the two does not stand beside the other.
    """
    return _both(subject, path, _cause(path.rounds[0].library, stronger), seed)


def _both(subject: Subject, path: Path, held: Cause, seed: int) -> Path | None:
    """`together`, from a cause."""
    baseline = path.rounds[0]
    least = baseline.rules.pair_share
    rules = replace(baseline.rules, later_share=least, second_share=least)
    first = _best_beside(subject, held, rules, seed)
    second = None if first is None else _best_beside(subject, first[0][-1], rules, seed)
    if first is None or second is None:
        return None
    (other, newest), model, answer = second
    model = _best_fit(subject, (newest, other), (model, first[1]))
    answers = (answer, first[2])
    begun = replace(path, causes=(newest, other), answers=answers, rounds=(baseline, answers[-1]))
    return continued(subject, replace(begun, pair=True), model, seed)


def _best_beside(
    subject: Subject, held: Cause, rules: Rules, seed: int
) -> tuple[list[Cause], Refit, Diagnosis] | None:
    """A cause and the best name for what it leaves, with their model and what found the name."""
    model = refitted_with(subject, [held], None)
    current = subject.extended(model, [held])
    start, _ = losses(subject.problem, [current], current.law)
    answer = diagnose(current, rules, seed, start)
    found, answer = grown_by_one(subject, [held], model, current, answer, start, seed)
    return None if found is None or len(found[0]) == 1 else (*found, answer)


def _best_fit(subject: Subject, causes: Sequence[Cause], models: tuple[Refit, Refit]) -> Refit:
    """Both causes refitted from the last model, or from what the second was beside the first.

    Fitted alone a cause takes on the shape of what is missing, and may not find back from there.
    """
    last, before = models
    kin = {p.name for p in subject.table[causes[-1].signature.effect].parameters}
    start = {
        n: before.values.get(n, v) if n.rsplit(".", 1)[1] in kin else v
        for n, v in last.values.items() if n not in subject.case.values
    }  # fmt: skip
    other = subject.refitted(causes, start)
    return min(last, other, key=lambda model: float(model.residual @ model.residual))


def _cause(lib: Library, number: int) -> Cause:
    """A candidate as large as its score says, before any test."""
    found = scores(lib.grams.inner, lib.grams.calibration, lib.grams.candidates[[number]])
    return _untested(lib.problem.signatures[number], 1.0, float(found.size[0]))


def _untested(signature: Signature, p: float, size: float = 0.0) -> Cause:
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
