"""A cell of a walk whose zero moves by far more than those of all others.

Of the room of the diagnosis; `diagnose` asks where nothing else explains a walk. A calibration that
is tracked follows each zero, so that one that drifts shows in no residual: it shows in the swings.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.contenders import refitted_with
from footcal_cli.core.diagnosis.inquiry import Inquiry
from footcal_cli.core.diagnosis.investigation import Investigation, named
from footcal_cli.core.diagnosis.jumps import Jump, at_rest
from footcal_cli.core.diagnosis.path import continued, of_one_step, untested
from footcal_cli.core.diagnosis.rehearsal import usual
from footcal_cli.core.diagnosis.standing import happened
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.problem import Problem

FAR = 6.0
"""Times the usual movement of the other zeros, by which one has moved for itself."""
_FEWEST = 6  # swings of which a trend is known
_SURE = 1e-4


def with_moved_zero(
    found: Investigation, asked: Mapping[str, Effect], inquiry: Inquiry
) -> Investigation:
    """`found`, or the cell whose zero has moved, with what a walk cannot distinguish from that.

    Parameters
    ----------
    asked
        Effects by name that move the zero of one cell (`Trait.ZERO`).
    """
    nameless = found.verdict in (Verdict.NONE, Verdict.UNKNOWN) and found.odd is None
    cell, p = moved_zero(found.problem) if nameless and asked else ("", 1.0)
    if not cell:
        return found
    others = inquiry.table
    subject, begun = inquiry.about(found, found.case.directions, asked)
    for signature in subject.problem.signatures:
        if signature.where != cell:
            continue
        alike = [others[n] for n in asked[signature.effect].mimics if n in others]
        rivals = tuple(usual(effect, cell) for effect in alike)
        cause = replace(untested(signature, p), rivals=rivals)
        model = refitted_with(subject, [cause], None)
        model = replace(model, intervals=of_one_step(subject, cause, model, Jump()))
        path = replace(begun, causes=(cause,), answers=(begun.rounds[0],), once=True)
        path = continued(subject, path, model, inquiry.seed)
        verdict = Verdict.AMBIGUOUS if rivals else Verdict.NAMED
        return named(subject, happened(subject, path, verdict))
    return found


def moved_zero(problem: Problem) -> tuple[str, float]:
    """The one cell whose zero has a trend over its swings, far beyond that of any other; else "".

    With the p that it has none.

    The trend is the slope of means of swings over time; it is sure by the rank correlation of both
    (Spearman), which a zero that wanders up and down does not have.
    """
    if not problem.drifts or problem.traces is None:
        return "", 1.0
    names = problem.traces.names
    trend, p = np.zeros(len(names)), np.ones(len(names))
    for i, name in enumerate(names):
        time_s, mean, _ = at_rest(problem, name)
        if time_s.size < _FEWEST:
            continue
        trend[i] = np.polyfit(time_s, mean, 1)[0]
        p[i] = _by_chance(time_s, mean)
    most = int(np.argmax(np.abs(trend)))
    rest = np.abs(np.delete(trend, most))
    usual = float(np.median(rest[rest > 0.0])) if (rest > 0.0).any() else np.inf
    by_chance = min(1.0, float(p[most]) * len(names))
    sure = by_chance < _SURE and abs(trend[most]) > FAR * usual
    return (names[most], by_chance) if sure else ("", by_chance)


def _by_chance(time_s: np.ndarray, mean: np.ndarray) -> float:
    """P of the rank correlation of two series, by ``t = r √((n − 2) / (1 − r²))``.

    Of all orders of n values one rises throughout and one falls: no p is below 2 / n!.
    """
    n = time_s.size
    ranks = np.stack([np.argsort(np.argsort(x)) for x in (time_s, mean)])
    r = float(np.asarray(np.corrcoef(ranks))[0, 1])
    t = abs(r) * np.sqrt((n - 2) / max(1.0 - r * r, 1e-12))
    return max(2.0 * float(chances.t_sf(t, n - 2)), 2.0 / math.factorial(n))
