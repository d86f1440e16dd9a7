"""Other ways through the search where one cause at a time leaves something, and if that matters.

Of the room of the diagnosis; `footcal_cli.core.diagnosis.investigation` asks.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from footcal_cli.core.diagnosis.answer import Cause, Verdict
from footcal_cli.core.diagnosis.beyond import are_distinct
from footcal_cli.core.diagnosis.engine import left_apart, leftover
from footcal_cli.core.diagnosis.gain import gains_of, losses, without_rivals
from footcal_cli.core.diagnosis.material import Nameless, line_over_smallest, nameless_of
from footcal_cli.core.diagnosis.mixtures import LINEAR
from footcal_cli.core.diagnosis.pairs import in_same_cells, likely_pairs
from footcal_cli.core.diagnosis.path import Path, as_one_mixture, beginning, grown
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.two_at_once import as_proposed, found_both_ways, together
from footcal_cli.core.diagnosis.unnamed import CURVES
from footcal_cli.core.diagnosis.verdicts import CLEAR, NAMING, judged
from footcal_cli.core.inference.whitening import has_single_rows


def matters_of(subject: Subject, path: Path, *, beside: bool) -> bool:
    """Whether what has no sure name is a finding; a spell within a series has no size here."""
    last = at_its_size(subject, path).rounds[-1]
    found = nameless_beside(subject, path, beside=beside)
    return left_apart(last.before, last.rules) or any(item.matters for item in found)


def unnamed_matters(subject: Subject, path: Path, baseline: Path) -> bool:
    """Whether what a name explained that does not stand is a finding.

    Of few stances the best of all names always explains some: there a test that knows no cause must
    have seen it, too.
    """
    first = baseline.rounds[0]
    seen = not subject.problem.pieces or first.before.p < first.rules.alpha_unknown
    return seen and matters_of(subject, path, beside=False)


def shows_in_moments(subject: Subject, path: Path, rules: Rules) -> bool:
    """Whether no force is surely predicted better with what the names explain."""
    gains = gains_of(subject.problem, path.current, path.current.law)
    forces = (gain.change for gain in gains if gain.unit == "N")
    return not any(c.low > 0.0 and c.value > rules.later_share for c in forces)


def at_its_size(subject: Subject, path: Path) -> Path:
    """The path without lines, and spells of single placements, that are too small to matter.

    What makes neighbours in time alike is at most the whole error of an output.
    """
    last = path.rounds[-1]
    if not left_apart(last.before, last.rules):
        return path
    found, before = nameless_beside(subject, path, beside=True), last.before
    if line_over_smallest(path.current, before.line, found) < 1.0:
        before = replace(before, line=replace(before.line, p=1.0))
    if subject.problem.rate_hz <= 0 and all(i.whole < i.smallest for i in found):
        before = replace(before, spell_p=1.0)
    return replace(path, rounds=(*path.rounds[:-1], replace(last, before=before)))


def as_a_curve(path: Path, rules: Rules) -> Rules:
    """Rules for a set that says only that a cell bends under its own load.

    Whatever the law of that curve is, the remedy is the same, and the table has but a few: what its
    forms leave of it does not speak against all of them, nor that this is ordered in time as the
    loads are, where they explain nearly all.
    """
    said = [s.effect for c in path.causes for s in (c.signature, *c.rivals)]
    if len(path.causes) != 1 or len(said) == 1 or not CURVES.issuperset(said):
        return rules
    least = rules.share_named
    return replace(
        rules, share_partly=least, share_form=least, share_set=least, share_apart=rules.share_form
    )


def nameless_beside(subject: Subject, path: Path, *, beside: bool) -> tuple[Nameless, ...]:
    """What has no name beside those of a path; without `beside` they are no names either."""
    model = None if beside else path.model
    return nameless_of(subject.case, subject.problem, path.current, model, path.repeats)


def another_way(
    subject: Subject, path: Path, rules: Rules, seed: int
) -> tuple[Path, Verdict, float] | None:
    """A path that begins with two causes at once and leaves nothing; None where none does.

    First the two that were found one after the other, if each is found beside the other. One that
    removes less than a path that left something is not what is wrong.
    """
    again = found_both_ways(subject, path, seed)
    if again is not None:
        verdict, share = judged(subject, at_its_size(subject, again), rules, seed)
        if _explains_all(subject, again, verdict, share, rules, seed):
            return again, verdict, share
    most, left = _removed_by_names(subject, path), list[Path]()
    for both in _pairs_of(subject, path, most, rules, seed):
        grew = as_one_mixture(subject, grown(subject, both, rules, seed), seed)
        verdict, share = judged(subject, at_its_size(subject, grew), rules, seed)
        all_of_it = grew.removed >= most and _explains_all(
            subject, grew, verdict, share, rules, seed
        )
        if all_of_it:
            return replace(grew, instead=tuple(left)), verdict, share
        most = max(most, grew.removed)
        left.append(grew)
    return None


def _explains_all(
    subject: Subject, path: Path, verdict: Verdict, share: float, rules: Rules, seed: int
) -> bool:
    """Whether two causes leave nothing, or nothing but what may be the form of one of them.

    The latter where neither is the form of the other one.
    """
    least = rules.share_partly if verdict is Verdict.NAMED else rules.share_pair
    if verdict in CLEAR and share >= least:
        return True
    return (
        verdict in NAMING
        and len(path.causes) == 2
        and are_distinct(subject, path.model, path.causes, [(0, 1)], rules, seed)
    )


def _removed_by_names(subject: Subject, path: Path) -> float:
    """Held-out squared error that the causes of a path remove, their rivals not fitted.

    A set of rivals in one model would be several causes, and no measure of a pair.
    """
    if path.model is None:
        return path.removed
    alone = without_rivals(path.current, path.model)
    before, after = losses(subject.problem, [alone], path.current.law)
    return before - after


def _pairs_of(subject: Subject, path: Path, most: float, rules: Rules, seed: int) -> Iterator[Path]:
    """Paths that begin with the likeliest pairs: with the first of each, then as proposed.

    The latter only if they remove as much as any before them, and as `most`.
    """
    lib = path.rounds[0].library
    pairs, seen = likely_pairs(lib, rules), set[frozenset[tuple[str, str]]]()
    for first in dict.fromkeys(pair[0] for pair in pairs):
        both = together(subject, path, first, seed)
        if both is not None:
            seen.add(frozenset((c.signature.effect, c.signature.where) for c in both.causes))
            most = max(most, both.removed)
            yield both
    for pair in pairs:
        named = [lib.problem.signatures[number] for number in pair]
        if frozenset((s.effect, s.where) for s in named) not in seen:
            both = as_proposed(subject, path, pair, most, seed)
            if both is not None:
                yield both


def without_first(
    subject: Subject, path: Path, rules: Rules, seed: int
) -> tuple[Path, Verdict, float] | None:
    """A path that begins without the first of several causes; None where it leaves something.

    Among few stances the noise is estimated with the error in it: a small cause of many rows may
    seem to explain more than the large one of a noisy output, which then is only the second.
    """
    if len(path.causes) < 2 or not has_single_rows(subject.problem):
        return None
    first = path.causes[0].signature.effect
    other = grown(subject, beginning(subject.problem, rules, seed, {first}), rules, seed)
    verdict, share = judged(subject, at_its_size(subject, other), rules, seed)
    return (other, verdict, share) if verdict in CLEAR else None


def second_cause(
    subject: Subject, path: Path, rules: Rules, seed: int
) -> tuple[Path, Verdict, float] | None:
    """`another_way` beside a name whose form leaves something, though that does not matter.

    Where loads are known and a calibration stands still; elsewhere two causes copy a third. A
    second cause that distorts the same cells is the form of the first.
    """
    known = "load_n" in subject.case.logs[0].known
    if not known or not leftover(path.rounds[-1].before, rules):
        return None
    found = another_way(subject, path, rules, seed)
    if found is None:
        return None
    both = found[0]
    same = in_same_cells(subject.table, both.causes)
    return found if are_distinct(subject, both.model, both.causes, same, rules, seed) else None


def two_of_a_set(
    subject: Subject, path: Path, rules: Rules, seed: int
) -> tuple[Path, Verdict, float] | None:
    """`another_way` to the only answer, a set of rivals: two of them as two causes.

    Where each of the rivals surely leaves something on its own, and neither of the two is the form
    of the other one; of two mixtures, where they leave nothing to any other.
    """
    if len(path.causes) != 1 or not _each_leaves(path.causes[0], rules):
        return None
    found = another_way(subject, path, rules, seed)
    cause = path.causes[0]
    if found is None or len(found[0].causes) != 2 or not cause.effects >= {*found[0].effects}:
        return None
    both = found[0]
    mixed = LINEAR.issuperset(both.effects)
    distinct = mixed or are_distinct(subject, both.model, both.causes, [(0, 1)], rules, seed)
    return found if distinct else None


def _each_leaves(cause: Cause, rules: Rules) -> bool:
    """Whether a cause and each of its rivals, all refitted alone, surely leave something."""
    refitted = [cause.compared.get(rival.effect) for rival in cause.rivals]
    return bool(refitted) and all(
        other is not None and max(other.left, other.left_by_named) < rules.alpha_left
        for other in refitted
    )
