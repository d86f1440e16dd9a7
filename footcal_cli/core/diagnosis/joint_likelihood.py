"""Likelihoods of sizes that experiments prefer, and what they say together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import logsumexp

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.joint_sizes import SizeSeen
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.parameters import FloatArray

FORM_ERRORS = ((0.0, 0.4), (0.03, 0.2), (0.1, 0.2), (0.2, 0.2))
"""Error of an effect's form as a share of its size, and how likely it is."""
_GRID = 61
_WIDE = 6.0


def size_grid(seen: Sequence[SizeSeen], usual: float, low: float, high: float) -> FloatArray:
    """Sizes at which an integrand is looked at: dense where an experiment has its own."""
    parts = [np.linspace(-10.0, 10.0, 2 * _GRID) * usual]
    for one in seen:
        for wide in (1.0, 0.2 * abs(one.size) / one.sd):
            parts.append(one.size + np.linspace(-_WIDE, _WIDE, _GRID) * one.sd * max(wide, 0.3))
    b = np.unique(np.clip(np.concatenate(parts), low, high))
    return b if b.size > 1 else np.array([b[0] - usual, b[0]])


def trapezoids(b: FloatArray) -> FloatArray:
    """Weights of the trapezoid rule."""
    return np.asarray(np.gradient(b))


def log_likelihood(b: FloatArray, seen: SizeSeen, *, against_none: bool = False) -> FloatArray:
    """Log of Student's law of a size that an experiment prefers, were it b.

    Relative to the best size, or to no such cause.
    """
    parts = []
    for share, weight in FORM_ERRORS:
        spread = np.hypot(seen.sd, share * b)
        t = _log_student((seen.size - b) / spread, seen.freedom)
        parts.append(np.log(weight) + t - np.log(spread / seen.sd))
    found = logsumexp(np.stack(parts), axis=0)
    if against_none:
        found = found - _log_student(np.array(seen.size / seen.sd), seen.freedom)
    return np.asarray(found)


def _log_student(t: FloatArray, freedom: float) -> FloatArray:
    return np.asarray(-0.5 * (freedom + 1.0) * np.log1p(t**2 / freedom))


def common_size(seen: Sequence[SizeSeen]) -> tuple[Interval, float]:
    """The common size with its 95 % interval, and ``Σ (size − common)²/sd²``.

    Experiments that disagree by more than their sd widen the interval by what they do.
    """
    if not seen:
        return Interval(np.nan, np.nan, np.nan), 0.0
    size = np.array([s.size for s in seen])
    spread = np.array([s.sd for s in seen])
    weights = 1.0 / spread**2
    common = float(weights @ size / weights.sum())
    chi2 = float(weights @ (size - common) ** 2)
    wider = np.sqrt(max(chi2 / max(len(seen) - 1, 1), 1.0))
    freedom = float(sum(s.freedom for s in seen))
    half = float(chances.t_ppf(0.975, freedom) * wider / np.sqrt(weights.sum()))
    return Interval(common, common - half, common + half), chi2


def agreement(groups: Sequence[Sequence[SizeSeen]]) -> float | None:
    """P of the same sizes in all experiments, with the largest form error that is allowed for."""
    chi2, freedom = 0.0, 0
    largest = FORM_ERRORS[-1][0]
    for seen in groups:
        if len(seen) < 2:
            continue
        common = common_size(seen)[0].value
        wide = [SizeSeen(s.size, float(np.hypot(s.sd, largest * common)), s.freedom) for s in seen]
        chi2 += common_size(wide)[1]
        freedom += len(seen) - 1
    return float(chances.chi2_sf(chi2, freedom)) if freedom else None
