"""A cell, or a transducer, of a walk whose zero moves by far more than those of all others.

Of the room of the diagnosis; `diagnose` asks where nothing else explains a walk. A calibration that
is tracked follows each zero, so that one that drifts shows in no residual: it shows in the swings.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.checks.lines import moved_between_ends
from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.contenders import refitted_with
from footcal_cli.core.diagnosis.inquiry import Inquiry
from footcal_cli.core.diagnosis.investigation import Investigation, named
from footcal_cli.core.diagnosis.jumps import Jump, at_rest
from footcal_cli.core.diagnosis.path import continued, of_one_step, untested
from footcal_cli.core.diagnosis.rehearsal import usual
from footcal_cli.core.diagnosis.standing import happened
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.ideal import TORQUE_SHARE
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray

_FEWEST, _FEWEST_OTHERS = 6, 3
"""Swings of which a trend is known, and zeros of other sensors that show what is usual."""
_SURE = 1e-3
_UNITS = {"N": 1.0, "Nm": TORQUE_SHARE}
"""What matters in each unit, per newton that does."""


def with_moved_zero(
    found: Investigation, asked: Mapping[str, Effect], inquiry: Inquiry
) -> Investigation:
    """`found`, or the sensor whose zero has moved, with what a walk cannot distinguish from that.

    Parameters
    ----------
    asked
        Effects by name that move the zero of one sensor (`Trait.ZERO`).
    """
    least_n = found.case.finding_n
    name, p = moved_zero(found.problem, least_n) if found.is_open and asked else ("", 1.0)
    if not name:
        return found
    sensor, _, axis = name.partition(".")
    others = inquiry.table
    subject, begun = inquiry.about(found, found.case.directions, asked)
    for signature in subject.problem.signatures:
        if signature.where != sensor or not signature.parameter.endswith(axis):
            continue
        alike = [others[n] for n in asked[signature.effect].mimics if n in others]
        rivals = tuple(usual(effect, sensor) for effect in alike)
        cause = replace(untested(signature, p), rivals=rivals)
        model = refitted_with(subject, [cause], None)
        model = replace(model, intervals=of_one_step(subject, cause, model, Jump()))
        path = replace(begun, causes=(cause,), answers=(begun.rounds[0],), once=True)
        path = continued(subject, path, model, inquiry.seed)
        verdict = Verdict.AMBIGUOUS if rivals else Verdict.NAMED
        return named(subject, happened(subject, path, verdict))
    return found


def moved_zero(problem: Problem, least_n: float) -> tuple[str, float]:
    """The one zero with a trend over its swings that is far beyond all others'; else "".

    Zeros that wander alike have trends of one variance: with τ the slope of means of swings over
    time, ``τ_i / √(Σ_j τ_j² / m) ~ t(m)`` for the m zeros j of other sensors, Bonferroni over all.
    Of transducers the forces are looked at first, then the torques among each other; what moves one
    axis moves others of its own, too.

    Parameters
    ----------
    least_n
        By so much must it differ between the first quarter of the swings and the last to matter: a
        check of the recording warns from there on too. Of a torque by `TORQUE_SHARE` of it.

    Returns
    -------
    The cell, or axis of a transducer, and the p of the largest trend.
    """
    if not problem.drifts or problem.traces is None:
        return "", 1.0
    swings: dict[str, dict[str, tuple[FloatArray, FloatArray]]] = {unit: {} for unit in _UNITS}
    for name in problem.traces.names:
        time_s, mean, unit = at_rest(problem, name)
        if time_s.size >= _FEWEST and unit in swings:
            swings[unit][name] = time_s, mean
    for unit, share in _UNITS.items():
        name, p = _of_one_unit(swings[unit], share * least_n)
        if name:
            return name, p
    return "", 1.0


def _of_one_unit(
    swings: Mapping[str, tuple[FloatArray, FloatArray]], least: float
) -> tuple[str, float]:
    """`moved_zero` among zeros that are read in one unit: when each swing is, and what it reads."""
    trends = {n: abs(float(np.polyfit(time_s, mean, 1)[0])) for n, (time_s, mean) in swings.items()}
    if not trends:
        return "", 1.0
    most = max(trends, key=trends.__getitem__)
    sensor = most.partition(".")[0]
    others = [trend for name, trend in trends.items() if name.partition(".")[0] != sensor]
    if len(others) < _FEWEST_OTHERS:
        return "", 1.0
    usual = float(np.sqrt(np.mean(np.square(others))))
    t = trends[most] / max(usual, 1e-300)
    p = min(1.0, 2.0 * len(trends) * float(chances.t_sf(t, len(others))))
    moved = abs(float(moved_between_ends(swings[most][1])[0]))
    return (most, p) if p < _SURE and moved > least else ("", p)
