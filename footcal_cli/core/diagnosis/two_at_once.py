"""Paths that begin with two causes at once, each in a full refit beside the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from footcal_cli.core.diagnosis.answer import Cause, Diagnosis
from footcal_cli.core.diagnosis.comparison import decided
from footcal_cli.core.diagnosis.contenders import refitted_with
from footcal_cli.core.diagnosis.engine import diagnose
from footcal_cli.core.diagnosis.gain import losses
from footcal_cli.core.diagnosis.growth import grown_by_one
from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.diagnosis.path import Path, continued, untested
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.sized import is_sure
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.inference.refit import Refit


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
    if both is None or both.effects != path.effects:
        return None
    return replace(path, both_ways=True)


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
    With one cause where the other one is nothing beside it; None where the first one found does not
    stand beside what was held.
    """
    return _both(subject, path, _cause(path.rounds[0].library, stronger), seed)


def as_proposed(
    subject: Subject, path: Path, pair: tuple[int, int], most: float, seed: int
) -> Path | None:
    """A path that begins with a pair refitted as it was proposed, each against its look-alikes.

    The shapes of candidates are few, and one cause alone takes on what the other one does: beside
    it the nearest shape of the other one may explain less than a third effect, until both are
    refitted. What a path with them has to remove is asked as of any other (`Rules.share_partly`).

    Parameters
    ----------
    pair
        Candidates by number, of two effects.
    most
        Held-out squared error that another path removes, which left something.

    Returns
    -------
    None where they remove less than that, a look-alike does better than one of them, or one is not
    surely something.
    """
    baseline = path.rounds[0]
    p = baseline.search.first.p
    causes = []
    for number in pair:
        cause = _cause(baseline.library, number)
        at = baseline.library.causes.index(cause.signature.cause)
        causes.append(replace(cause, p=float(p[at])))
    model = refitted_with(subject, causes, refitted_with(subject, causes[:1], None))
    both = subject.bare(model, causes)
    before, after = losses(subject.problem, [both], both.law)
    if before - after < most:
        return None
    for i in (1, 0):
        other, mine = [causes[1 - i]], causes[i]
        alone = subject.refitted_from(other, model)
        # alone it would take on what the other one does, and may not find back from there
        alone = replace(alone, values={n: model.values.get(n, v) for n, v in alone.values.items()})
        causes[i], model = decided(subject, other, alone, replace(baseline, causes=(mine,)), seed)
        if causes[i].signature.effect != mine.signature.effect:
            return None
    sure = all(is_sure(c, subject.table[c.signature.effect], model) for c in causes)
    begun = replace(path, causes=tuple(causes), answers=(baseline, baseline), rounds=(baseline,))
    return continued(subject, replace(begun, pair=True), model, seed) if sure else None


def _both(subject: Subject, path: Path, held: Cause, seed: int) -> Path | None:
    """`together`, from a cause."""
    baseline = path.rounds[0]
    least = baseline.rules.pair_share
    rules = replace(baseline.rules, later_share=least, second_share=least)
    first = _best_beside(subject, held, rules, seed)
    if first is None:
        return None
    second = _best_beside(subject, first[0][-1], rules, seed)
    if second is None:  # beside it there is nothing: what was held only stood in for it
        one = [first[0][-1]]
        begun = replace(path, causes=tuple(one), answers=(first[2],), rounds=(baseline, first[2]))
        return continued(subject, begun, refitted_with(subject, one, None), seed)
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
    return untested(lib.problem.signatures[number], 1.0, float(lib.alone.size[number]))
