"""What does not repeat between settings: its law, estimated once for all models of a log.

A model that explains less leaves more that differs between hangings. Judged by variances of its
own it would fit as well as any; all models are compared by the same law.

Few blocks tell of the variance between them: an effect would pass for poor repeatability for most
of its size. A candidate that stands out even so, the variance estimated beside it as in a t-test,
is fitted while the variance is estimated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.inference.between_settings import variance_between
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.settings import (
    RCOND,
    Parts,
    beside_settings,
    half_log_det,
    part_variances,
    repeated,
    row_levels,
    whiten_parts,
)
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    from footcal_cli.core.inference.problem import Problem

MOST_SUSPECTS = 3
"""Candidates that may be taken for effects while variances are estimated."""
RARE = 0.05
"""Probability with which the best of all candidates explains that much of noise."""
SHARES = (1.0, 0.05)
"""Shares of the variances at which the strongest candidate is looked for: a cause that made a
variance large is hidden by it, and another one stands out in its place."""
_INSIDE = 1e-8  # share of a column's square that a base leaves, below which it leaves none


def strongest(score: FloatArray, own: FloatArray, whole: FloatArray) -> tuple[int, float]:
    """Which candidate has the largest ``|z| = |g̃·r̃| / |g̃|``, and that.

    Parameters
    ----------
    score, own, whole
        ``g̃·r̃``, ``|g̃|²`` and ``|g|²`` of each, g̃ what a base leaves of g.
    """
    z = np.abs(score) / np.sqrt(np.where(own > _INSIDE * whole, own, np.inf))
    best = int(np.argmax(z))
    return best, float(z[best])


def outstanding(tested: Mapping[int, float], among: int) -> int | None:
    """The suspect with the largest |z| if the best of so many candidates rarely has it by chance.

    Parameters
    ----------
    tested
        Suspect -> |z|, the variance estimated beside it.
    among
        Of how many candidates the suspects were the strongest.
    """
    best = max(sorted(tested), key=lambda suspect: tested[suspect])
    return best if tested[best] > float(chances.norm_isf(0.5 * RARE / among)) else None


Whiten = Callable[[FloatArray], FloatArray]
"""Columns of all rows, shape (m, k), as columns that are white within a part, shape (n, k)."""


@dataclass(frozen=True)
class WithinSetting:
    """The law of what differs between the parts of a setting.

    Parameters
    ----------
    level
        Sd of each row as against its output's, shape (n,).
    loose
        Z, in units of `level`, shape (n, q).
    parts, variances
        Each sensor's parts, and the variances between them.
    """

    level: FloatArray
    loose: FloatArray
    parts: list[Parts]
    variances: list[FloatArray]

    def __call__(self, columns: FloatArray) -> FloatArray:
        """Columns white within a setting, shape (n, k)."""
        if not self.parts:
            return columns
        scaled = columns / self.level[:, None]
        whiten_parts(scaled, self.loose, self.parts, self.variances)
        return scaled

    @property
    def log_sd(self) -> float:
        """``½ log det`` of its covariance."""
        charged = (
            half_log_det(self.loose[np.ix_(rows, part.columns)] * np.sqrt(variance))
            for part, variance in zip(self.parts, self.variances, strict=True)
            for rows in part.groups
        )
        return float(np.sum(np.log(self.level))) + sum(charged)


@dataclass(frozen=True)
class Settled:
    """The law of what differs between settings, and between their parts.

    Parameters
    ----------
    within
        Between parts.
    loose
        Z, white within a setting, shape (n, q).
    variance
        Of each column of Z between settings, shape (q,).
    """

    within: WithinSetting
    loose: FloatArray
    groups: list[IntArray]
    variance: FloatArray

    def __call__(self, columns: FloatArray) -> FloatArray:
        """Columns white across settings, shape (n, k)."""
        return repeated(self.within(columns), self.loose, self.groups, self.variance)

    @property
    def log_sd(self) -> float:
        """``½ log det`` of its covariance, beyond that of the rows' noise."""
        spread = np.sqrt(self.variance)
        charged = (half_log_det(self.loose[rows] * spread) for rows in self.groups if rows.size)
        return self.within.log_sd + sum(charged)


def settled(problem: Problem, whiten: Whiten, kept: IntArray) -> Settled | None:
    """Estimate the law from the residual, beside candidates that stand out.

    Parameters
    ----------
    problem
        Rows, candidates, and what may differ.
    whiten, kept
        Makes rows white within a part; the rows that it keeps.

    Returns
    -------
    None where nothing was set up anew.
    """
    settings = problem.settings
    if settings is None:
        return None
    parts, groups = settings.parts(problem.output, kept), settings.rows(kept)
    loose = whiten(settings.columns)
    white = whiten(np.column_stack([problem.fitted, problem.columns, problem.residual]))
    beside = np.arange(problem.fitted.shape[1])
    most = beside.size + MOST_SUSPECTS
    candidates = np.arange(beside.size, white.shape[1] - 1)
    while True:
        within = _within(white, beside, loose, parts, groups, settings.shown[: len(groups)])
        inside, free = np.split(within(np.hstack([white, loose])), [white.shape[1]], axis=1)
        left = inside[:, -1]
        law = Settled(
            within, free, groups,
            variance_between(inside[:, beside], free, left, groups, settings.kind),
        )  # fmt: skip
        if not candidates.size or beside.size == most:
            return law
        suspects = {
            _strongest(repeated(inside, free, groups, law.variance * part), beside, candidates)[0]
            for part in SHARES
        }
        tested, at = {}, np.arange(beside.size + 1)
        for suspect in suspects:
            of_it = inside[:, [*beside, suspect, -1]]
            less = variance_between(of_it[:, :-1], free, left, groups, settings.kind)
            freed = repeated(of_it, free, groups, less)
            tested[suspect] = _strongest(freed, at[:-1], at[-1:])[1]
        best = outstanding(tested, candidates.size)
        if best is None:
            return law
        beside = np.append(beside, best)


def _within(
    white: FloatArray,
    common: IntArray,
    loose: FloatArray,
    parts: list[Parts],
    groups: list[IntArray],
    shown: BoolArray,
) -> WithinSetting:
    """The law between parts, where a setting has any.

    Parameters
    ----------
    white
        The residual last.
    common
        Which columns are fitted in common.
    loose, parts
        Z, and the parts of the settings.
    groups, shown
        Rows of each setting, and which columns of Z it shows.
    """
    if not parts:
        return WithinSetting(np.ones(white.shape[0]), loose, [], [])
    level = row_levels(white[:, -1], loose, parts)
    scaled, own = loose / level[:, None], white[:, [*common, -1]] / level[:, None]
    left = beside_settings(own[:, :-1], own[:, -1], scaled, groups, shown)
    return WithinSetting(level, scaled, parts, part_variances(left, scaled, parts))


def _strongest(white: FloatArray, base: IntArray, candidates: IntArray) -> tuple[int, float]:
    """The candidate with the largest |z| beside a base, and that."""
    # products with all columns as they stand: of a long log a choice of them is as large again
    products = white[:, np.append(base, white.shape[1] - 1)].T @ white
    cross = products[:-1, np.append(candidates, -1)]
    inside = scaled_inverse(products[:-1, base], RCOND) @ cross
    whole = np.einsum("ij,ij->j", white, white)[candidates]
    own = whole - np.sum(cross * inside, axis=0)[:-1]
    score = products[-1, candidates] - cross[:, :-1].T @ inside[:, -1]
    best, z = strongest(score, own, whole)
    return int(candidates[best]), z
