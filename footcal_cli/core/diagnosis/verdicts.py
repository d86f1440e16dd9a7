"""The verdict on a path: whether its names explain enough, and nothing without a name does.

Of the room of the diagnosis; `footcal_cli.core.diagnosis.investigation` asks.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.answer import Cause, Diagnosis, Verdict
from footcal_cli.core.diagnosis.bends import against_bends, bend_left, bends_of, bent_axes
from footcal_cli.core.diagnosis.beyond import are_distinct
from footcal_cli.core.diagnosis.change_points import has_change_point
from footcal_cli.core.diagnosis.ends import against_other_sign, at_an_end, held_at_zero
from footcal_cli.core.diagnosis.engine import (
    enough,
    left_apart,
    leftover,
    look_alike,
    share_of,
)
from footcal_cli.core.diagnosis.form import Form, form_of
from footcal_cli.core.diagnosis.growth import named_columns
from footcal_cli.core.diagnosis.jumps import means_of_blocks, step_beside
from footcal_cli.core.diagnosis.kinds import of_another_kind
from footcal_cli.core.diagnosis.mixtures import against_mixtures, applies_to, mixtures_of
from footcal_cli.core.diagnosis.pairs import in_same_cells
from footcal_cli.core.diagnosis.path import Path
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.sized import is_nothing
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.unnamed import Unnamed, against_curves, applies, curves_of
from footcal_cli.core.effects.contract import OF_THE_LOGS, Trait, is_six_axis
from footcal_cli.core.inference.case import channels_of
from footcal_cli.core.inference.evidence import sign_patterns
from footcal_cli.core.inference.linear import left_by
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.signals import means_of

CLEAR = (Verdict.NAMED, Verdict.AMBIGUOUS)
"""Verdicts that leave nothing beside the names."""
_RCOND = 1e-9
_CANCELS = 0.5
NAMING = (*CLEAR, Verdict.NAMED_UNKNOWN)


def judged(subject: Subject, path: Path, rules: Rules, seed: int) -> tuple[Verdict, float]:
    """The verdict on a path, and the share of what can be explained that its names explain."""
    form = _form(path.current, path.model, path.causes, seed)
    unnamed = _unnamed(subject, path.current, path.model, path.causes, rules, seed)
    verdict, share = _verdict(path.rounds, path.causes, form, unnamed, rules, path.removed)
    last = path.rounds[-1]
    copied = (
        at_an_end(subject, path.causes, path.model)
        or is_nothing(subject, path.causes, path.model)
        or bend_left(last, path.causes, path.model)
        or (subject.case.drifts and last.before.spell_p < rules.alpha_small)
        or _outdone(subject, path, rules)
        or (verdict in NAMING and of_another_kind(subject, path, rules, seed))
        or subject.zero_is_named(path.causes)
    )
    bent = any(item.as_form and item.left.p < rules.alpha_form for item in unnamed)
    if verdict is Verdict.NAMED_UNKNOWN and bent:
        return Verdict.UNKNOWN, share  # what is left may be the form of the name
    if verdict in NAMING and copied:
        # a size that only its bound stops is the size of something else, as is a curve's mean gain,
        # and what others are in a walk in which a cell still jumps; one that may be none is no size
        return Verdict.UNKNOWN, share
    if (
        verdict in NAMING
        and len(path.causes) > 1
        and (_trifles(subject, path) or _alike(subject, path, rules, seed))
    ):
        # it stands in for the form of a larger one, or for where a refit of that one ended, or both
        # copy a third
        return Verdict.UNKNOWN, share
    loose = subject.case.drifts or subject.case.experiment.name == "stand"
    if (
        verdict in NAMING
        and loose
        and len(path.causes) > 1
        and not _two_sure(subject, path, rules, seed)
    ):
        # beside a calibration that drifts two causes copy a third that neither of them is, and in
        # a stand, whose loads follow the two coordinates of its CoM
        return Verdict.UNKNOWN, share
    return verdict, share


def _two_sure(subject: Subject, path: Path, rules: Rules, seed: int) -> bool:
    """Whether several causes are each found beside the others, and none is the form of another."""
    same = in_same_cells(subject.table, path.causes, at_once=path.pair)
    if not are_distinct(subject, path.model, path.causes, same, rules, seed):
        return False
    each = len(same) == 1 and len(path.causes) == 2  # beside every form of the other one
    return each or path.pair or path.both_ways or all(cause.rivals for cause in path.causes)


def _alike(subject: Subject, path: Path, rules: Rules, seed: int) -> bool:
    """Whether two of several causes look alike, and one may be a form of the other."""
    first, causes = path.rounds[0], path.causes
    if not look_alike(first.library, _columns_of(first, causes), rules):
        return False
    pairs = list(itertools.combinations(range(len(causes)), 2))
    return not are_distinct(subject, path.model, causes, pairs, rules, seed)


def form_matters(subject: Subject, path: Path, rules: Rules, seed: int) -> bool:
    """Whether what a named curve leaves to other curves of its axis spoils it, and matters."""
    if not bent_axes(subject.case, path.causes):
        return False
    found = _unnamed(subject, path.current, path.model, path.causes, rules, seed)
    return any(
        item.left.bought > item.smallest and item.spoils(path.removed, rules) for item in found
    )


def may_be_a_curve(subject: Subject, path: Path, rules: Rules, seed: int) -> bool:
    """Whether a curve of the cells without a name explains as much as the causes do."""
    found = _unnamed(subject, path.current, path.model, path.causes, rules, seed)
    return any(item.rival for item in found)


def usual_beside(subject: Subject, path: Path) -> list[Cause]:
    """Gains of axes, and zeros that move, next to a larger cause, that change nothing that matters.

    Every transducer has gains within a per cent, every amplifier warms up, and nobody hides them:
    they stay in the model and are no answer.
    """
    if len(path.causes) < 2:
        return []
    small = _small(subject, path, _changes(subject, path))
    return small if _are_usual(subject, path, small) else []


def _are_usual(subject: Subject, path: Path, small: Sequence[Cause]) -> bool:
    """Whether small causes, of which a path has more, are gains of axes and zeros that move."""
    rows = (subject.table[cause.signature.effect] for cause in small)
    usual = all({Trait.AXIS_GAIN, Trait.ZERO} & set(row.traits) for row in rows)
    return usual and 0 < len(small) < len(path.causes)


def _small(subject: Subject, path: Path, changes: Sequence[FloatArray]) -> list[Cause]:
    """Causes that change no output by what matters; `changes` of each as from `_changes`."""
    found = zip(path.causes, changes, strict=path.model is not None)
    return [cause for cause, change in found if _is_trifle(subject, path, cause, change)]


def _trifles(subject: Subject, path: Path) -> bool:
    """Whether one of several causes changes no output by what matters, at its refitted size.

    Or all of them together nearly none: a delay and a lag of the opposite sign leave what either
    of them gets wrong, and neither is there.
    """
    changes = _changes(subject, path)
    small = _small(subject, path, changes)
    if not changes or _are_usual(subject, path, small):
        return False
    if small:
        return True
    each = [float(np.linalg.norm(change)) for change in changes]
    return float(np.linalg.norm(np.sum(changes, axis=0))) < _CANCELS * min(each)


def _changes(subject: Subject, path: Path) -> list[FloatArray]:
    """What each cause changes in each row at its refitted size, in units of the noise, (m,)."""
    model, problem = path.model, path.current
    changes = list[FloatArray]()
    if model is None:
        return changes
    for cause in path.causes:
        sizes = {p.name: p.neutral for p in subject.table[cause.signature.effect].sizes}
        change = np.zeros(problem.residual.size)
        for column, name in zip(model.columns.T, model.names, strict=True):
            owner, _, parameter = name.rpartition(".")
            if parameter in sizes and owner in dict(cause.signature.owners):
                change += column * (model.values[name] - sizes[parameter])
        changes.append(change)
    return changes


def _is_trifle(subject: Subject, path: Path, cause: Cause, change: FloatArray) -> bool:
    """Whether a cause changes no output by what matters (RMS); a label where it stands."""
    problem, shapes = path.current, subject.table[cause.signature.effect].shapes
    there = np.ones(change.size, dtype=bool)
    if any(shape.grid_of in OF_THE_LOGS for shape in shapes):
        there = change != 0.0
    squares = means_of((change * problem.noise)[there] ** 2, problem.output[there],
                       len(problem.outputs), np.inf)  # fmt: skip
    return bool(np.all(squares < problem.tolerance**2))


def _outdone(subject: Subject, path: Path, rules: Rules) -> bool:
    """Whether a cause of one sensor that was not named explains surely more than the only name.

    Too few blocks may inform of it to name it, and it is not excluded. With the variance estimated
    beside each of the two, ``2 ln L`` of the B means of blocks differs by ``B ln(S / S')``, S and
    S' what they leave. A step from one block to the next is one of them, whatever its moment.
    """
    lib = path.rounds[0].library
    problem = lib.problem
    mine = [c for cause in path.causes for c, one in enumerate(lib.causes)
            if one == cause.signature.cause]  # fmt: skip
    said = {s.cause for cause in path.causes
            for s in (cause.signature, *cause.rivals, *cause.places)}  # fmt: skip
    others = [c for c, one in enumerate(lib.causes) if one not in said]
    channels = channels_of(subject.case.logs)
    alone = len(channels) == 1 or (is_six_axis(channels) and len(channels) == len(problem.outputs))
    if len(mine) != 1 or not others or problem.drifts or not alone:
        return False
    asked = [[lib.index(int(k)) for k in lib.columns[c]] for c in (*mine, *others)]
    columns = problem.columns[:, [k for own in asked for k in own]]
    mean = means_of_blocks(problem, np.column_stack([problem.residual, columns]))
    left = left_by(means_of_blocks(problem, problem.fitted), mean, _RCOND)
    whole = float(left[:, 0] @ left[:, 0])
    along = (left[:, 1:].T @ left[:, 0]) ** 2 / np.maximum(np.sum(left[:, 1:] ** 2, axis=0), 1e-300)
    rest = np.maximum(whole - along, 1e-9 * whole)
    ends = np.cumsum([len(own) for own in asked])
    least = [float(part.min()) for part in np.split(rest, ends[:-1])]
    steps = has_change_point(subject.table[path.causes[0].signature.effect])  # it is a step itself
    best = min([*least[1:], *([] if steps else [step_beside(problem, problem.fitted).left])])
    more = problem.blocks * np.log(least[0] / best)
    return bool(more > chances.chi2_isf(rules.alpha_small / (len(others) + problem.blocks), 1))


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
        curves = curves_of(model.ideal, subject.problem)
        found.append(against_curves(subject.problem, current, named, curves, signs, rules))
    axes = bent_axes(subject.case, causes)
    if axes:
        bends = bends_of(model.ideal, subject.problem, axes)
        found.append(against_bends(current, bends, signs))
    held = held_at_zero(model, [subject.table[c.signature.effect] for c in causes], causes)
    if held.any():
        found.append(against_other_sign(current, model.columns, held, signs))
    if applies_to(subject.case, causes):
        mixtures = mixtures_of(model.ideal, subject.problem)
        found.append(against_mixtures(current, mixtures, signs))
    return tuple(found)


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
    if not enough(removed, last.before, form, rules, between=between, several=several):
        return Verdict.UNKNOWN, share
    if several:
        # neither which one it is nor what else is there: a set would hide the rest
        hidden = share < rules.share_apart and left_apart(last.before, rules)
        return Verdict.UNKNOWN if hidden else Verdict.AMBIGUOUS, share
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
