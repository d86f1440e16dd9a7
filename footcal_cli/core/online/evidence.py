"""Is it better, and does it last: the evidence that [NAO] asks for in its open points."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.online.filter import Track
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import autocorrelation_time

SETTLING_S = 5.0
"""Left out of every judgement: all methods start from the same belief."""
_STEADY_SHARE = 1.0 / 3.0
_LEVEL = 0.95
_PHASES, _LEAST_CYCLES = 24, 5
_HUBER = 3.0
_MOST_PICKS = 2**21
"""Resampled cycles held at once (16 MB)."""


@dataclass(frozen=True)
class OverCycles(Interval):
    """A statistic of n gait cycles (or other blocks) with its bootstrap interval."""

    n: int


@dataclass(frozen=True)
class Settling:
    """How one parameter behaves along a walk.

    Parameters
    ----------
    name, unit
        Of the parameter.
    converged_s
        Time from the start until it stays in its final band, NaN where it never does.
    steady_sd
        Scatter about a straight line over the last third.
    drift_per_hour, drift_sd
        Change per hour from the first to the last third, with the filter's sd.
    """

    name: str
    unit: str
    converged_s: float
    steady_sd: float
    drift_per_hour: float
    drift_sd: float


def settle(track: Track, names: Sequence[str]) -> list[Settling]:
    """Convergence time, steady-state scatter and drift per hour of parameters.

    A parameter has converged when it stays within ± 2 sd (as stated at the end) of its mean over
    the last third. Drift compares the means of the middle and the last third; its sd comes from
    the states' sd at the middle of both, taken as independent.
    """
    rows = []
    u = track.time_s.size
    tail = slice(int(u * (1 - _STEADY_SHARE)), u)
    middle = slice(int(u * _STEADY_SHARE), tail.start)
    time_s = track.time_s - track.time_s[0]
    for name in names:
        i = track.names.index(name)
        series, sd = track.values[:, i], track.sd[:, i]
        level = float(series[tail].mean())
        band = 2.0 * float(sd[-1])
        outside = np.flatnonzero(np.abs(series[: tail.stop] - level) > band)
        inside_from = int(outside[-1]) + 1 if outside.size else 0
        converged = float(time_s[inside_from]) if inside_from < tail.start else float("nan")
        line = np.polynomial.Polynomial.fit(time_s[tail], series[tail], 1)
        hours = float(time_s[tail].mean() - time_s[middle].mean()) / 3600.0
        change = level - float(series[middle].mean())
        change_sd = float(
            np.hypot(sd[(tail.start + tail.stop) // 2], sd[(middle.start + middle.stop) // 2])
        )
        rows.append(
            Settling(
                name=name,
                unit=track.units[i],
                converged_s=converged,
                steady_sd=float(np.std(series[tail] - line(time_s[tail]))),
                drift_per_hour=change / hours if hours > 0 else float("nan"),
                drift_sd=change_sd / hours if hours > 0 else float("nan"),
            )
        )
    return rows


def rms(values: FloatArray) -> float:
    """Root mean square of the finite values, over vectors where there are two axes."""
    squared = values**2 if values.ndim == 1 else np.sum(values**2, axis=1)
    finite = squared[np.isfinite(squared)]
    return float(np.sqrt(finite.mean())) if finite.size else float("nan")


def _ends(
    statistic: Callable[..., FloatArray],
    cycles: Sequence[FloatArray],
    resamples: int,
    rng: np.random.Generator,
) -> tuple[float, float]:
    """Percentile interval of a statistic of so many values per cycle, resampled together."""
    from scipy.stats import bootstrap

    found = bootstrap(
        cycles, statistic, n_resamples=resamples, batch=max(_MOST_PICKS // cycles[0].size, 1),
        vectorized=True, paired=True, confidence_level=_LEVEL, method="percentile",
        random_state=rng,
    ).confidence_interval  # fmt: skip
    return float(found.low), float(found.high)


def bootstrap_mean(
    values: FloatArray, rng: np.random.Generator, resamples: int = 2000
) -> OverCycles:
    """Mean over cycles with a percentile interval from resampled cycles."""
    values = values[np.isfinite(values)]
    if values.size < 2:
        value = float(values.mean()) if values.size else float("nan")
        return OverCycles(value, float("nan"), float("nan"), values.size)
    ends = _ends(np.mean, [values], resamples, rng)
    return OverCycles(float(values.mean()), *ends, values.size)


def bootstrap_ratio(
    ours: FloatArray, theirs: FloatArray, rng: np.random.Generator, resamples: int = 2000
) -> OverCycles:
    """Ratio of RMS errors over the same cycles, cycles resampled in pairs; NaN over no error.

    Parameters
    ----------
    ours, theirs
        RMS error per cycle, shape (cycles,).
    """
    both = np.isfinite(ours) & np.isfinite(theirs)
    a, b = ours[both] ** 2, theirs[both] ** 2
    if a.size < 2 or not b.any():
        return OverCycles(float("nan"), float("nan"), float("nan"), a.size)

    def ratio(ours: FloatArray, theirs: FloatArray, axis: int = -1) -> FloatArray:
        return np.asarray(np.sqrt(ours.mean(axis=axis) / theirs.mean(axis=axis)))

    return OverCycles(float(ratio(a, b)), *_ends(ratio, [a, b], resamples, rng), a.size)


def paired_p(ours: FloatArray, theirs: FloatArray) -> float:
    """Two-sided Wilcoxon signed-rank test of two methods over the same gait cycles."""
    both = np.isfinite(ours) & np.isfinite(theirs)
    difference = ours[both] - theirs[both]
    if difference.size < 6 or not difference.any():
        return float("nan")
    from scipy import stats

    return float(stats.wilcoxon(difference).pvalue)


@dataclass(frozen=True)
class Consistency:
    """Do the innovations have the size the filter claims.

    Parameters
    ----------
    ratio
        Sum of the normalised innovations squared over their degrees of freedom; 1 when consistent.
    low, high
        95 % band of the ratio, chi-squared with as many degrees of freedom as the updates are
        worth (`footcal_cli.core.signals.autocorrelation_time` of their normalised innovations
        squared).
    inside
        Share of updates whose own value lies in its 95 % band.
    whiteness
        Lag-one autocorrelation of the normalised total-force innovation.
    worth
        Degrees of freedom of the band.
    rows
        Degrees of freedom of all updates together.
    """

    ratio: float
    low: float
    high: float
    inside: float
    whiteness: float
    updates: int
    worth: float
    rows: float

    @property
    def as_claimed(self) -> bool:
        """Whether the innovations are about as large as the filter claims."""
        return 0.8 < self.ratio < 1.25

    def findings(self) -> Iterator[Finding]:
        """Innovations that are not."""
        if not self.as_claimed:
            yield Finding(
                "inconsistent_innovations", "warning", "filter",
                f"innovations are {self.ratio**0.5:.2f} times as large as claimed",
                "run diagnose on this log: it says whether an effect of the table is behind it",
            )  # fmt: skip

    @classmethod
    def joined(cls, parts: Sequence[Consistency]) -> Consistency:
        """Of parts of a walk together; correlation across their ends does not count."""
        known = [part for part in parts if part.rows]
        if not known:
            return parts[0]
        rows = np.array([part.rows for part in known])
        updates = np.array([part.updates for part in known])
        worth = sum(part.worth for part in known)
        return cls(
            float(np.average([part.ratio for part in known], weights=rows)),
            *_band(worth),
            float(np.average([part.inside for part in known], weights=updates)),
            float(np.average([part.whiteness for part in known], weights=updates)),
            int(updates.sum()),
            worth,
            float(rows.sum()),
        )


def _band(worth: float) -> tuple[float, float]:
    """95 % band of chi-squared over its degrees of freedom."""
    low, high = (float(chances.chi2_ppf(q, worth)) / worth for q in (0.025, 0.975))
    return low, high


def check_consistency(track: Track, *, skip_s: float = 2.0) -> Consistency:
    """Compare normalised innovations with chi-squared.

    Parameters
    ----------
    skip_s
        Left out at the start.
    """
    use = (track.dof > 0) & (track.time_s - track.time_s[0] >= skip_s)
    nis, dof = track.nis[use], track.dof[use]
    total = float(dof.sum())
    if total == 0:
        nan = float("nan")
        return Consistency(nan, nan, nan, nan, nan, 0, 0.0, 0.0)
    worth = total / autocorrelation_time(nis / dof - 1.0)
    low, high = _band(worth)
    lowest, highest = (np.asarray(chances.chi2_ppf(q, dof)) for q in (0.025, 0.975))
    normalised = (track.innovation / track.innovation_sd)[use, 0]
    normalised = normalised[np.isfinite(normalised)]
    moves = normalised.size > 2 and min(np.ptp(normalised[1:]), np.ptp(normalised[:-1])) > 0.0
    lagged = float(np.corrcoef(normalised[1:], normalised[:-1])[0, 1]) if moves else float("nan")
    return Consistency(
        ratio=float(nis.sum() / total),
        low=low,
        high=high,
        inside=float(np.mean((nis >= lowest) & (nis <= highest))),
        whiteness=lagged,
        updates=int(use.sum()),
        worth=worth,
        rows=total,
    )


@dataclass(frozen=True)
class Repeats:
    """What the totals' innovations add up to at each phase of the gait.

    Parameters
    ----------
    total, count
        Sum of the normalised innovations, and how many they are, shape (totals, phases).
    """

    total: FloatArray
    count: FloatArray

    def __add__(self, other: Repeats) -> Repeats:
        return Repeats(self.total + other.total, self.count + other.count)

    def factor(self, unknowns: int | None = None) -> float:
        """How much of the error comes back in every gait cycle, as a factor of variance.

        chi² over degrees of freedom of the innovations' means at each phase of the gait, all
        totals together; 1 where that is no more than chance (95 %). An error that repeats is
        counted anew by every cycle though it teaches nothing new: n cycles of it are worth one,
        which is what this factor takes back.

        Parameters
        ----------
        unknowns
            Given where errors of this walk are known to repeat: then chance is no excuse, and so
            many unknowns have taken their part of what repeats, since a walk shows no more than
            the phases of one cycle.
        """
        filled = self.count >= _LEAST_CYCLES
        if not filled.any():
            return 1.0
        cycles = self.count[filled]
        taken = 0 if unknowns is None else min(unknowns, cycles.size // 2)
        found = float(np.sum(self.total[filled] ** 2 / cycles)) / (cycles.size - taken)
        # n cycles of an error are at worst one: a larger factor would switch the rows off
        found = min(found, float(np.median(cycles)))
        by_chance = float(chances.chi2_ppf(_LEVEL, cycles.size)) / cycles.size
        return max(found, 1.0) if unknowns is not None or found > by_chance else 1.0


def repeats(track: Track, phase: FloatArray, totals: int, *, skip_s: float = 5.0) -> Repeats:
    """Sum the totals' innovations at each phase of the gait.

    Parameters
    ----------
    phase
        Share of the gait cycle of each update, NaN where unknown, shape (u,).
    totals
        Number of rows of the whole robot.
    skip_s
        Left out at the start.
    """
    use = np.isfinite(phase) & (track.time_s - track.time_s[0] > skip_s)
    total, count = np.zeros((totals, _PHASES)), np.zeros((totals, _PHASES))
    for k in range(totals):
        # one broken sample is no repetition
        normalised = np.clip(track.innovation[:, k] / track.innovation_sd[:, k], -_HUBER, _HUBER)
        good = use & np.isfinite(normalised)
        place = np.floor(phase[good] * _PHASES).astype(int)
        count[k] = np.bincount(place, minlength=_PHASES)
        total[k] = np.bincount(place, weights=normalised[good], minlength=_PHASES)
    return Repeats(total, count)


def repetition(track: Track, phase: FloatArray, totals: int, *, known: bool = False) -> float:
    """`Repeats.factor` of a track; `known`: errors of this walk do repeat."""
    return repeats(track, phase, totals).factor(len(track.names) if known else None)


@dataclass(frozen=True)
class LeftInterval:
    """A parameter that left the interval it was believed to lie in.

    Parameters
    ----------
    name, unit
        Of the parameter.
    time_s
        First update from which on it stays outside.
    value, low, high
        Its value at the end, and the interval.
    """

    name: str
    unit: str
    time_s: float
    value: float
    low: float
    high: float


def departures(track: Track, prior_sd: FloatArray) -> list[LeftInterval]:
    """Parameters that end outside ± 3 prior sd by more than their own sd, and since when.

    Parameters
    ----------
    track
        On top of a belief (prior mean 0).
    prior_sd
        Shape (p,).
    """
    found = []
    for i, name in enumerate(track.names):
        limit = 3.0 * float(prior_sd[i])
        outside = np.abs(track.values[:, i]) - track.sd[:, i] > limit
        if outside.size and outside[-1]:
            inside = np.flatnonzero(~outside)
            since = int(inside[-1]) + 1 if inside.size else 0
            found.append(
                LeftInterval(
                    name, track.units[i], float(track.time_s[since]),
                    float(track.values[-1, i]), -limit, limit,
                )
            )  # fmt: skip
    return found
