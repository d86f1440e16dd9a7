"""Several trials and sessions: spread, components of variance, paired tests.

The foot paper's open points: "multiple repeated trials per walking condition, means ± standard
deviations, and statistical testing to assess the significance of performance improvements".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Paired:
    """One method against another over the same trials.

    Parameters
    ----------
    ratio, low, high
        Geometric mean of ours / theirs with its 95 % interval (t on the logarithms).
    t_p, wilcoxon_p
        Two-sided p of the paired t test on the logarithms, and of the signed-rank test.
    n
        Trials.
    """

    ratio: float
    low: float
    high: float
    t_p: float
    wilcoxon_p: float
    n: int


def paired(ours: ArrayLike, theirs: ArrayLike) -> Paired:
    """Compare errors of two methods, trial by trial; they are positive, so logarithms are."""
    change = np.log(np.asarray(ours, dtype=float)) - np.log(np.asarray(theirs, dtype=float))
    n = change.size
    mean, error = float(change.mean()), float(change.std(ddof=1) / np.sqrt(n))
    reach = float(stats.t.ppf(0.975, n - 1)) * error
    t_p = float(2.0 * stats.t.sf(abs(mean) / error, n - 1)) if error > 0 else float("nan")
    wilcoxon_p = float(stats.wilcoxon(change).pvalue) if np.any(change != 0) else 1.0
    low, high = np.exp(mean - reach), np.exp(mean + reach)
    return Paired(float(np.exp(mean)), float(low), float(high), t_p, wilcoxon_p, n)


def holm(p: ArrayLike) -> Array:
    """p values corrected for how many were looked at (Holm), in the given order."""
    values = np.asarray(p, dtype=float)
    order = np.argsort(values)
    stepped = values[order] * (values.size - np.arange(values.size))
    corrected = np.empty(values.size)
    corrected[order] = np.minimum(np.maximum.accumulate(stepped), 1.0)
    return corrected


@dataclass(frozen=True)
class Spread:
    """Mean and spread of a figure over sessions with several trials each.

    Parameters
    ----------
    mean, sd
        Over all trials.
    within_sd, between_sd
        Components: trial to trial of one session, and session to session (0 where none is seen).
    trials, sessions
        How many.
    """

    mean: float
    sd: float
    within_sd: float
    between_sd: float
    trials: int
    sessions: int


def spread(values: ArrayLike, session: ArrayLike) -> Spread:
    """One-way components of variance by the ANOVA estimator, sessions of equal size."""
    x, group = np.asarray(values, dtype=float), np.asarray(session)
    names = np.unique(group)
    per = x.size // names.size
    means = np.array([x[group == name].mean() for name in names])
    left = x - means[np.searchsorted(names, group)]
    within = float(left @ left) / max(x.size - names.size, 1)
    between = max(float(means.var(ddof=1)) - within / per, 0.0) if names.size > 1 else 0.0
    return Spread(
        float(x.mean()), float(x.std(ddof=1)), float(np.sqrt(within)), float(np.sqrt(between)),
        x.size, names.size,
    )  # fmt: skip


def converged_after(per_cycle: Array, time_s: Array) -> float:
    """First gait cycle from which the error stays in the band of the last third, s; else NaN.

    Band: mean + 2 sd of the cycles of the last third.

    Parameters
    ----------
    per_cycle, time_s
        RMS error and start of each gait cycle, shape (cycles,).
    """
    known = np.isfinite(per_cycle)
    errors, start = per_cycle[known], time_s[known]
    tail = errors[2 * errors.size // 3 :]
    if tail.size < 3:
        return float("nan")
    outside = np.flatnonzero(errors > tail.mean() + 2.0 * tail.std(ddof=1))
    first = int(outside[-1]) + 1 if outside.size else 0
    return float(start[first] - start[0]) if first < 2 * errors.size // 3 else float("nan")
