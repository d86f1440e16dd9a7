"""A cell of a walk whose gain is no longer what weights have determined.

Of the room of the diagnosis; `diagnose` asks where nothing else explains a walk. The gains of cells
that were calibrated are known to a per cent, as far as a mounting moves them, and stay free within
that: what scales one cell by more shows in no residual, only in a gain far from the known one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.diagnosis.answer import MovedGain, Verdict
from footcal_cli.core.diagnosis.inquiry import Inquiry
from footcal_cli.core.diagnosis.investigation import Investigation, named
from footcal_cli.core.diagnosis.rehearsal import usual
from footcal_cli.core.diagnosis.standing import happened
from footcal_cli.core.diagnosis.unnamed import CURVES
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.grams import calibration_grams
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.tracking import Direction
from footcal_cli.core.parameters import FloatArray

FAR, NEAR = 5.0, 4.0
"""Prior sd by which a gain has moved for certain, and by which none of the others may have then."""
_RCOND = 1e-12
_SD_95 = 1.96


def with_moved_gain(
    found: Investigation, asked: Mapping[str, Effect], inquiry: Inquiry
) -> Investigation:
    """`found`, or the cells whose gain has moved, with what a walk cannot distinguish from that.

    Parameters
    ----------
    asked
        Effects by name that scale one cell (`Trait.GAIN`) or mix several (`Trait.MIXTURE`).
    """
    gains = gains_against(found.case, found.problem) if found.is_open and asked else ()
    moved = [gain.cell for gain in gains if gain.certain]
    if not moved:
        return found
    others = inquiry.table
    kept = [way for way in found.case.directions if not (way.lasting and way.channel in moved)]
    bent = _is_bent(found, moved)
    curves = {name: others[name] for name in CURVES if bent and name in others}
    subject, path = inquiry.one_cause(found, kept, {**asked, **curves})
    if not path.causes:
        return found
    (cause,) = path.causes
    if bent and cause.signature.effect in CURVES and _cells_of(cause.signature) == set(moved):
        # the mean gain of a curve is off too, and how much of it is gain a walk hardly shows
        gains_too = [n for n in asked if Trait.GAIN in asked[n].traits and n in others]
        same = [usual(others[name], cause.signature.where) for name in gains_too]
        cause = replace(cause, rivals=(*cause.rivals, *same))
        whole = replace(path, causes=(cause,))
        answer = named(subject, happened(subject, whole, Verdict.AMBIGUOUS))
        return replace(answer, gains_moved=gains)
    gain = next((s for s in (cause.signature, *cause.rivals) if _is_gain_of(s, moved, asked)), None)
    if gain is None:
        return found
    alike = [name for name in asked[gain.effect].mimics if name in others]
    if gain is not cause.signature:
        alike = []  # a mixture of cells explains more than their gains do
    elif cause.size.value > 0.0 or len(moved) == 1:
        # what an error of a foot's load as a whole takes, it takes from all of its cells
        alike = [name for name in alike if Trait.OF_THE_SUM not in others[name].traits]
    rivals = (usual(others[name], cause.signature.where) for name in alike)
    cause = replace(cause, rivals=(*cause.rivals, *rivals))
    verdict = Verdict.AMBIGUOUS if cause.rivals else Verdict.NAMED
    answer = named(subject, happened(subject, replace(path, causes=(cause,)), verdict))
    return replace(answer, gains_moved=gains)


def _is_bent(found: Investigation, moved: Sequence[str]) -> bool:
    """Whether a curve of these very cells came nearest, though too little for a name."""
    near = [f.cause.signature for f in found.nearest]
    return any(s.effect in CURVES and _cells_of(s) == set(moved) for s in near)


def _cells_of(signature: Signature) -> set[str]:
    return {cell for _, units in signature.owners for cell in units}


def _is_gain_of(signature: Signature, moved: Sequence[str], table: Mapping[str, Effect]) -> bool:
    """Whether it is a gain of these cells and no others."""
    return Trait.GAIN in table[signature.effect].traits and _cells_of(signature) == set(moved)


def gains_against(case: Case, problem: Problem) -> tuple[MovedGain, ...]:
    """Every gain against its calibration, where one cell's or one foot's has surely moved.

    With γ ~ N(0, I) in units of what a mounting moves, and C its covariance given the walk,
    ``a·γ̂ / √(a·(I − C) a)`` is N(0, 1) for any direction a: a single cell, all cells of a foot.
    What has moved is then free of its calibration, and no other gain may be far from its own.
    Empty where none has moved.
    """
    ways = [way for way in case.directions if way.lasting]
    if not ways or problem.held is None:
        return ()
    cells = [way.channel for way in ways]
    feet = dict.fromkeys(cell.split("_", 1)[0] for cell in cells)
    groups: list[tuple[str, ...]] = [(cell,) for cell in cells]
    groups += [tuple(c for c in cells if c.split("_", 1)[0] == foot) for foot in feet]
    along = np.array([[float(c in group) for c in cells] for group in groups])
    grams = calibration_grams(problem, problem.law, counted=False)
    base = grams.calibration
    total = grams.inner.summed(np.append(base, grams.inner.last))
    far = np.abs(_departures(*_gains(total, len(cells)), along))
    best = int(np.argmax(far))
    if far[best] < FAR:
        return ()
    free, a = total.copy(), along[best]
    free[: a.size, : a.size] -= np.outer(a, a) / (a @ a)
    gain, covariance = _gains(free, a.size)
    others = np.abs(_departures(gain, covariance, along))[along @ a == 0.0]
    if others.max(initial=0.0) >= NEAR:
        return ()
    sd = np.sqrt(np.diag(covariance))
    return tuple(
        MovedGain(c, _within(unit * g, abs(unit) * s), abs(unit), c in groups[best])
        for c, g, s, unit in zip(cells, gain, sd, _shares(case, ways), strict=True)
    )


def _shares(case: Case, ways: Sequence[Direction]) -> list[float]:
    """By which share a mounting moves each gain."""
    names = [f"{way.channel}.scale" for way in ways]
    return [way.changes[n] / case.values[n] for way, n in zip(ways, names, strict=True)]


def _within(value: float, sd: float) -> Interval:
    return Interval(value, value - _SD_95 * sd, value + _SD_95 * sd)


def _gains(total: FloatArray, size: int) -> tuple[FloatArray, FloatArray]:
    """γ̂ and its covariance from the Gram matrix of calibration and residual."""
    covariance = scaled_inverse(total[:-1, :-1], _RCOND)
    return (covariance @ total[:-1, -1])[:size], covariance[:size, :size]


def _departures(gain: FloatArray, covariance: FloatArray, along: FloatArray) -> FloatArray:
    """``a·γ̂`` of each direction in units of its sd beforehand, shape (directions,)."""
    known = np.eye(gain.size) - covariance
    spread = np.einsum("ij,jk,ik->i", along, known, along)
    return np.asarray(along @ gain / np.sqrt(np.maximum(spread, 1e-9)))
