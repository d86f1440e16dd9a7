"""One parameter calibrated many times: its spread, its change points, its outlying sessions.

Model of session i: ``yᵢ = level + bᵢ + eᵢ``, eᵢ with the sd that the fit claims, bᵢ what changes
from one session to the next (variance τ²). The level may change at once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core import chances
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

FEWEST_SESSIONS = 6
"""Below that neither a change point nor an outlying session can be proved."""
_SMALLEST_SEGMENT, _MOST_CHANGES = 2, 8
_DRAWS = 4000
_NEWTON_STEPS = 60
_MOST_NUMBERS = 2_000_000
"""Held at once while all places of a change are tried."""


@dataclass(frozen=True)
class Level:
    """Weighted mean of some sessions.

    Parameters
    ----------
    value, sd
        The mean; its sd after Knapp and Hartung, with `dof` degrees of freedom.
    between_sd
        τ: spread beyond what the fits claim.
    dof
        Sessions minus one.
    """

    value: float
    sd: float
    between_sd: float
    dof: int


@dataclass(frozen=True)
class Change:
    """The level changed between two sessions.

    Parameters
    ----------
    first_after
        Number of the first session behind the change.
    size, sd
        After minus before.
    p
        Of a change as large anywhere in the series without one.
    """

    first_after: int
    size: float
    sd: float
    p: float


@dataclass(frozen=True)
class Trend:
    """A steady drift.

    Parameters
    ----------
    slope, slope_sd
        Per unit of time.
    total
        Over the whole series; `total_sd` its sd.
    p
        Two-sided.
    """

    slope: float
    slope_sd: float
    total: float
    total_sd: float
    p: float


def _levels(
    member: FloatArray, values: FloatArray, sd: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Levels of groups of sessions that share one τ, for many ways of grouping at once.

    τ² after Paule and Mandel (``Σ (yᵢ − level)²/(sdᵢ² + τ²)`` equals its dof), by Newton's method
    from Hedges' estimate: the sum is convex and falls with τ², so that it converges from the left.
    The sd of a level is that of Knapp and Hartung, but never below what sdᵢ and τ allow.

    Parameters
    ----------
    member
        1 where a session belongs to a group, shape (m, g, n).
    values, sd
        Shape (n,).

    Returns
    -------
    level and its sd, shape (m, g), τ², shape (m,), and dof, shape (m,)
    """
    counted = member.sum(axis=1)
    dof = np.asarray(counted.sum(axis=1) - member.shape[1], dtype=np.int64)
    enough = np.maximum(dof, 1)
    size = max(float(np.var(values)), 1e-300)
    claimed = np.maximum(sd**2, 1e-9 * size)  # a fit may claim to be exact

    def fitted(variance: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        weight = 1.0 / (claimed + variance[:, None])
        mass = np.einsum("mgn,mn->mg", member, weight)
        level = np.einsum("mgn,mn,n->mg", member, weight, values) / np.maximum(mass, 1e-300)
        left = (values - np.einsum("mgn,mg->mn", member, level)) * counted
        return level, mass, left * np.sqrt(weight)

    plain = member.sum(axis=2)
    mean = np.einsum("mgn,n->mg", member, values) / np.maximum(plain, 1.0)
    spread = np.sum(((values - np.einsum("mgn,mg->mn", member, mean)) * counted) ** 2, axis=1)
    typical = counted @ claimed / np.maximum(counted.sum(axis=1), 1.0)
    variance = np.maximum(spread / enough - typical, 0.0)
    for _ in range(_NEWTON_STEPS):
        _, _, left = fitted(variance)
        slope = np.sum(left**2 / (claimed + variance[:, None]), axis=1)
        step = (np.sum(left**2, axis=1) - enough) / np.maximum(slope, 1e-300)
        moved = np.maximum(variance + step, 0.0)
        settled = np.abs(moved - variance) <= 1e-12 * size
        variance = moved
        if settled.all():
            break
    level, mass, left = fitted(variance)
    factor = np.maximum(np.sum(left**2, axis=1) / enough, 1.0)
    return level, np.sqrt(factor[:, None] / np.maximum(mass, 1e-300)), variance, dof


def level_of_sessions(values: FloatArray, sd: FloatArray) -> Level:
    """Weighted mean of sessions without a change among them.

    Parameters
    ----------
    values, sd
        Shape (n,).
    """
    level, error, variance, dof = _levels(np.ones((1, 1, values.size)), values, sd)
    return Level(float(level[0, 0]), float(error[0, 0]), float(np.sqrt(variance[0])), int(dof[0]))


def trend_of(time: FloatArray, values: FloatArray, sd: FloatArray) -> Trend | None:
    """Weighted line through the sessions; None below `FEWEST_SESSIONS` or at one single time."""
    if values.size < FEWEST_SESSIONS or not np.ptp(time) > 0:
        return None
    span = float(np.ptp(time))
    place = (time - time.mean()) / span
    # the spread about the line: of what the straight line leaves, with one dof more used
    design = np.column_stack([np.ones(time.size), place])
    straight = design @ np.linalg.lstsq(design, values, rcond=None)[0]
    tau = _levels(np.ones((1, 1, values.size)), values - straight, sd)[2][0]
    weight = 1.0 / np.maximum(sd**2 + tau * (values.size - 1) / (values.size - 2), 1e-300)
    normal = design.T @ (design * weight[:, None])
    covariance = np.linalg.inv(normal)
    found = covariance @ (design.T @ (weight * values))
    misfit = float(np.sum(weight * (values - design @ found) ** 2))
    error = float(np.sqrt(max(misfit / (values.size - 2), 1.0) * covariance[1, 1]))
    p = float(2.0 * chances.t_sf(abs(found[1] / error), values.size - 2))
    return Trend(float(found[1] / span), error / span, float(found[1]), error, p)


def find_changes(values: FloatArray, sd: FloatArray, *, alpha: float) -> tuple[Change, ...]:
    """Change points by binary segmentation, each tested with Student's t over all places.

    The largest ``|t|`` of two levels against one, with p by Bonferroni over the places; then the
    same in each part. τ is estimated within the parts, so that a change is not taken for spread.

    Parameters
    ----------
    values, sd
        In the order of time, shape (n,).
    alpha
        Probability of one false change in a series without any.
    """
    found: list[Change] = []
    parts = [(0, values.size)]
    while parts and len(found) < _MOST_CHANGES:
        start, stop = parts.pop()
        change = _largest_change(values[start:stop], sd[start:stop])
        if change is None or change.p > alpha:
            continue
        at = start + change.first_after
        found.append(Change(at, change.size, change.sd, change.p))
        parts += [(start, at), (at, stop)]
    return tuple(sorted(found, key=lambda change: change.first_after))


def _largest_change(values: FloatArray, sd: FloatArray) -> Change | None:
    n = values.size
    if n < FEWEST_SESSIONS:
        return None
    places = np.arange(_SMALLEST_SEGMENT, n - _SMALLEST_SEGMENT + 1)
    after = (np.arange(n) >= places[:, None]).astype(float)
    size, error = np.empty(places.size), np.empty(places.size)
    chunk = max(_MOST_NUMBERS // (2 * n), 1)
    for start in range(0, places.size, chunk):
        part = slice(start, start + chunk)
        both = np.stack([1.0 - after[part], after[part]], axis=1)
        level, level_sd, _, _ = _levels(both, values, sd)
        size[part] = level[:, 1] - level[:, 0]
        error[part] = np.hypot(level_sd[:, 0], level_sd[:, 1])
    best = int(np.argmax(np.abs(size) / error))
    p = 2.0 * float(chances.t_sf(abs(size[best]) / error[best], n - 2))
    return Change(
        int(places[best]), float(size[best]), float(error[best]), min(1.0, p * places.size)
    )


def segments_of(changes: Sequence[Change], n: int) -> IntArray:
    """Number of the segment that each session lies in, shape (n,)."""
    starts = np.array([change.first_after for change in changes], dtype=np.int64)
    return np.asarray(np.searchsorted(starts, np.arange(n), side="right"))


def outlying(values: FloatArray, sd: FloatArray, segment: IntArray, *, alpha: float) -> FloatArray:
    """Significance (p) of each session against the others of its segment, shape (n,).

    Each session is left out, level and τ of the others are estimated, its distance over
    ``√(sd² + τ² + sd of the level²)`` compared with Student's t (Bonferroni). The worst one is set
    aside and the rest looked at again, up to a quarter of them; all that were set aside until the
    last significant one lie apart, so that one does not hide another (Rosner, Technometrics 25,
    1983). 1 where nothing can be said.

    Parameters
    ----------
    values, sd, segment
        Shape (n,).
    alpha
        Of one or more false ones.
    """
    p, kept = np.ones(values.size), np.ones(values.size, dtype=bool)
    aside: list[int] = []
    last = 0
    now = _distances(values, sd, segment, kept)
    first = now
    for _ in range(max(values.size // 4, 1)):
        worst = int(np.argmin(now))
        if now[worst] >= 1.0:
            break
        p[worst] = now[worst]
        aside.append(worst)
        if now[worst] <= alpha:
            last = len(aside)
        kept[worst] = False
        now = _distances(values, sd, segment, kept)
    apart = np.array(aside[:last], dtype=np.int64)
    p[apart] = np.minimum.accumulate(p[apart][::-1])[::-1]
    rest = np.setdiff1d(np.arange(values.size), apart)
    p[rest] = np.maximum(first[rest], alpha) if last else first[rest]
    return p


def _distances(
    values: FloatArray, sd: FloatArray, segment: IntArray, kept: BoolArray
) -> FloatArray:
    """Significance of each kept session against the other kept ones, 1 for the others."""
    now = np.ones(values.size)
    left = np.flatnonzero(kept)
    chunk = max(_MOST_NUMBERS // max(values.size, 1), 1)
    for start in range(0, left.size, chunk):
        at = left[start : start + chunk]
        others = kept & (segment == segment[at, None])
        others[np.arange(at.size), at] = False
        level, level_sd, variance, dof = _levels(others[:, None].astype(float), values, sd)
        spread = np.sqrt(sd[at] ** 2 + variance + level_sd[:, 0] ** 2)
        distance = np.abs(values[at] - level[:, 0]) / np.maximum(spread, 1e-300)
        judged = 2.0 * chances.t_sf(distance, np.maximum(dof, 1))
        now[at] = np.where(dof >= FEWEST_SESSIONS - 2, judged, 1.0)
    return np.minimum(now * left.size, 1.0)


@dataclass(frozen=True)
class Component:
    """One source of spread.

    Parameters
    ----------
    name
        ``robot``, ``operator``, ``day`` or ``repeatability``.
    sd
        Its sd, 0 where the sessions do not show it.
    low, high
        95 % interval of the sd.
    dof
        Degrees of freedom behind it.
    """

    name: str
    sd: float
    low: float
    high: float
    dof: int


def components_of(
    values: FloatArray, groups: Mapping[str, NDArray[np.generic]]
) -> tuple[Component, ...]:
    """Variance components by Henderson's method III: sums of squares of one factor after another.

    Balanced tables give the analysis of variance of a gauge study (AIAG, Measurement Systems
    Analysis, 2010, without interaction); unbalanced ones are handled alike. Intervals are
    generalised confidence intervals (Weerahandi, JASA 88, 1993): each mean square is divided by a
    drawn chi-square over its dof.

    Parameters
    ----------
    values
        Shape (n,).
    groups
        Factor -> label of each session, shape (n,), in the order in which they are fitted; a nested
        factor's labels differ from parent to parent. Factors that vary nowhere are left out.

    Returns
    -------
    The factors that can be estimated, then ``repeatability``
    """
    n = values.size
    basis = np.full((n, 1), 1.0 / np.sqrt(n))
    names: list[str] = []
    steps: list[FloatArray] = []
    indicators: list[FloatArray] = []
    for name, labels in groups.items():
        _, code = np.unique(labels, return_inverse=True)
        indicator = np.eye(int(code.max()) + 1)[code.ravel()]
        added = _orthogonal(indicator - basis @ (basis.T @ indicator))
        if added.shape[1] == 0 or basis.shape[1] + added.shape[1] >= n:
            continue
        names.append(name)
        steps.append(added)
        indicators.append(indicator)
        basis = np.hstack([basis, added])
    dof = n - basis.shape[1]
    if dof < 1:
        return ()
    left = values - basis @ (basis.T @ values)
    squares = np.array([float(np.sum((q.T @ values) ** 2)) for q in steps] + [float(left @ left)])
    freedom = np.array([q.shape[1] for q in steps] + [dof])
    k = len(steps)
    expected = np.zeros((k + 1, k + 1))
    for i, q in enumerate(steps):
        for j, z in enumerate(indicators):
            expected[i, j] = float(np.sum((q.T @ z) ** 2))
    expected[:, k] = freedom
    inverse = np.linalg.pinv(expected)
    found = np.maximum(inverse @ squares, 0.0)
    draws = np.random.default_rng(0).chisquare(freedom, size=(_DRAWS, k + 1))
    drawn = np.maximum((squares * freedom / draws) @ inverse.T, 0.0)
    low, high = np.sqrt(np.quantile(drawn, [0.025, 0.975], axis=0))
    return tuple(
        Component(name, float(np.sqrt(found[i])), float(low[i]), float(high[i]), int(freedom[i]))
        for i, name in enumerate([*names, "repeatability"])
    )


def _orthogonal(columns: FloatArray) -> FloatArray:
    """Orthonormal basis of what columns span, shape (n, rank)."""
    left, size, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(left[:, size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)])
