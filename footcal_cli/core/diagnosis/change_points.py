"""When a change happened: between the times that are tried, the one that explains most.

The search tries a score of times. A change between two of them is found at the nearer one, and what
lies between that and the truth remains at its full size, as if something else were missing.
No derivative tells of it: a moment later changes no row until it passes one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.curves import explained_each
from footcal_cli.core.diagnosis.jumps import is_one_stream
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects.contract import Effect, GridOf
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.ideal import balanced
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.whitening import Noise
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import starts_of

_MOST_TIMES = 200
_RARE = 0.01
_ROUNDS = 4


def at_its_change_point(
    subject: Subject, signature: Signature, others: Sequence[Cause], model: Refit | None
) -> Signature:
    """A signature at the moment that explains most; one without a moment as it is.

    Parameters
    ----------
    subject
        What is diagnosed.
    signature
        At one of the times tried.
    others, model
        All other causes, and the model with them; None without any.
    """
    effect = subject.table[signature.effect]
    moment = _change_point_of(effect)
    if moment is None:
        return signature
    found = dict(signature.shape)[moment]
    # an axis that carries nothing has a signature without a shape
    known = [
        dict(s.shape)[moment] for s in subject.problem.signatures
        if s.effect == effect.name and s.shape
    ]  # fmt: skip
    log = max(subject.case.logs, key=len)
    times = _between_neighbours(log, np.unique([found, *known]), found)
    if is_one_stream(subject.problem):  # or from one attitude to the next, which are few
        times = np.append(times, _starts(log))
    left = subject.problem if model is None else subject.bare(model, others)
    ideal = balanced(subject.case, subject.case.values) if model is None else model.ideal
    tried = [_at(signature, moment, float(time)) for time in times]
    taken = _explained(left, subject.columns(ideal, tried))
    best = int(np.argmax(taken))
    # of so many moments one explains that much more of noise alone
    if taken[best] - taken[0] <= float(chances.chi2_isf(_RARE / times.size, 1)):
        return signature
    return tried[best]


def best_between(subject: Subject, after_s: float, before_s: float) -> Signature | None:
    """What explains most of all that may begin between two times, s since the start.

    First which cause, at the middle; then at which of its rows, or where attitudes change. None
    without any.
    """
    ideal, problem = balanced(subject.case, subject.case.values), subject.problem
    middle = 0.5 * (after_s + before_s)
    placed: dict[object, Signature] = {}
    for signature in problem.signatures:
        moment = _change_point_of(subject.table[signature.effect])
        if moment is not None:
            placed[signature.cause] = _at(signature, moment, middle)
    found = _best(subject, ideal, list(placed.values()))
    if found is None:
        return None
    log = max(subject.case.judged, key=len)
    times = _starts(log) if is_one_stream(problem) else log.time_s - log.time_s[0]
    times = times[(times > after_s) & (times < before_s)]
    moment = _change_point_of(subject.table[found.effect])
    if moment is None:  # only effects with a moment were placed
        return found
    return _best(subject, ideal, [found, *(_at(found, moment, float(time)) for time in times)])


def _starts(log: Log) -> FloatArray:
    """When each block begins, s since the start."""
    return np.asarray(log.time_s[starts_of(log.block)] - log.time_s[0])


def _at(signature: Signature, moment: str, time_s: float) -> Signature:
    shape = {**dict(signature.shape), moment: time_s}
    return replace(signature, shape=tuple(shape.items()))


def _best(subject: Subject, ideal: Case, tried: Sequence[Signature]) -> Signature | None:
    """The signature that explains most beside the calibration, the first of equals."""
    if not tried:
        return None
    return tried[int(np.argmax(_explained(subject.problem, subject.columns(ideal, tried))))]


def _explained(problem: Problem, columns: Sequence[FloatArray]) -> FloatArray:
    """Squared residual in units of the noise that each column explains, beside what is fitted.

    A change that puts one setting on the wrong side makes what differs between settings large: of
    these the law is estimated anew beside the column that explains most.
    """
    bare, tried = problem.without_candidates, np.stack(columns, axis=1)
    taken = _by(bare, tried, problem.law)
    for _ in range(_ROUNDS if is_one_stream(problem) else 0):
        best = int(np.argmax(taken))
        taken = _by(bare, tried, bare.holding(tried[:, [best]]).law)
        if int(np.argmax(taken)) == best:
            break
    return taken


def _by(problem: Problem, columns: FloatArray, law: Noise) -> FloatArray:
    grams, _ = whitened_grams(problem, columns, law)
    return explained_each(grams, grams.calibration, grams.features)


def onset_moved(effect: Effect, signature: Signature, model: Refit) -> bool:
    """Whether a refit stands at another moment than the one that the search tried."""
    moment = _change_point_of(effect)
    owners, tried = signature.owners, dict(signature.shape)
    return moment is not None and any(
        model.values[f"{owner}.{moment}"] != tried[moment] for owner, _ in owners
    )


def has_change_point(effect: Effect) -> bool:
    """Whether an effect begins at a time of its own."""
    return _change_point_of(effect) is not None


def _change_point_of(effect: Effect) -> str | None:
    return next((p.name for p in effect.shapes if p.grid_of is GridOf.SPAN), None)


def _between_neighbours(log: Log, known: FloatArray, found: float) -> FloatArray:
    """The time found, then every row from the time tried before to the one after, s.

    In slow noise little but the edge itself is distinguished from what drifts: a few rows off
    show nothing.
    """
    since = log.time_s - log.time_s[0]
    at = int(np.searchsorted(known, found))
    low, high = known[max(at - 1, 0)], known[min(at + 1, known.size - 1)]
    rows = np.flatnonzero((since >= low) & (since <= high))
    return np.append(found, since[rows[:: max(rows.size // _MOST_TIMES, 1)]])
