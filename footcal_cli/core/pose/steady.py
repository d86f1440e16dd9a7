"""Cutting a stand-still log into poses: the steady stretches ([Wu], section I-B).

Steady is where the L2 norm of the derivative of the force (second-order Savitzky-Golay) stays
below 1 N/s for more than 1.5 s; the median of the stretch represents the pose.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from footcal_cli.core.parameters import FloatArray


class StretchVerdict(StrEnum):
    """What became of a stretch."""

    KEPT = "kept"
    MOVING = "moving"
    TOO_SHORT = "too short"


@dataclass(frozen=True)
class SteadyStretch:
    """Consecutive rows with one verdict.

    Parameters
    ----------
    start, stop
        Rows ``start:stop``.
    verdict
        Why it was kept or discarded.
    """

    start: int
    stop: int
    verdict: StretchVerdict
    duration_s: float


@dataclass(frozen=True)
class SteadyRule:
    """When a robot stands still.

    Parameters
    ----------
    rate_nps
        Highest derivative of the force, L2 norm over all channels of a leg, worst leg, N/s.
    duration_s
        A pose must last longer than this.
    window_s
        Length of the Savitzky-Golay window; longer for noisier sensors.
    """

    rate_nps: float = 1.0
    duration_s: float = 1.5
    window_s: float = 0.5


def force_rate_nps(time_s: FloatArray, force_n: FloatArray, window_s: float) -> FloatArray:
    """Largest norm of the force derivative over the legs, shape (n,), N/s.

    Parameters
    ----------
    time_s
        Evenly sampled, shape (n,).
    force_n
        Shape (n, K, 3).
    window_s
        Savitzky-Golay window (second order).
    """
    from scipy.signal import savgol_filter

    step = float(np.median(np.diff(time_s)))
    window = max(2 * round(window_s / step / 2) + 1, 5)
    window = min(window, len(time_s) - (len(time_s) + 1) % 2)
    rate = savgol_filter(force_n, window, 2, deriv=1, delta=step, axis=0)
    return np.asarray(np.linalg.norm(rate, axis=-1).max(axis=-1))


def steady_stretches(
    time_s: FloatArray,
    force_n: FloatArray,
    rule: SteadyRule | None = None,
) -> tuple[SteadyStretch, ...]:
    """Every row of a log in one stretch, kept or discarded.

    Parameters
    ----------
    time_s
        Shape (n,), evenly sampled.
    force_n
        Forces of all legs, shape (n, K, 3), N.
    """
    asked = rule or SteadyRule()
    still = force_rate_nps(time_s, force_n, asked.window_s) < asked.rate_nps
    edges = np.concatenate([[0], np.flatnonzero(still[1:] != still[:-1]) + 1, [still.size]])
    stretches = []
    for start, stop in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        duration = float(time_s[stop - 1] - time_s[start])
        if not still[start]:
            verdict = StretchVerdict.MOVING
        elif duration <= asked.duration_s:
            verdict = StretchVerdict.TOO_SHORT
        else:
            verdict = StretchVerdict.KEPT
        stretches.append(SteadyStretch(start, stop, verdict, duration))
    return tuple(stretches)


def why_no_pose(time_s: FloatArray, force_n: FloatArray, rule: SteadyRule) -> tuple[str, str]:
    """Why nothing stands still long enough, and what would take the quietest part.

    Parameters
    ----------
    time_s, force_n
        As for `steady_stretches`, which kept nothing of them.
    """
    length, asked = float(np.ptp(time_s)), rule.duration_s
    quiet = [
        s for s in steady_stretches(time_s, force_n, rule) if s.verdict is StretchVerdict.TOO_SHORT
    ]
    if quiet:
        longest = max(quiet, key=lambda s: s.duration_s)
        return (
            f"the longest stretch that stands still lasts {longest.duration_s:.3g} s (from "
            f"{time_s[longest.start]:.5g} s), not more than steady_duration_s = {asked:g} s",
            f"stand still longer, or set steady_duration_s = {0.9 * longest.duration_s:.2g}",
        )
    if length <= asked:
        return (
            f"the recording lasts {length:.3g} s, not more than steady_duration_s = {asked:g} s",
            "record longer",
        )
    rate = force_rate_nps(time_s, force_n, rule.window_s)
    rows = min(int(asked / np.median(np.diff(time_s))) + 2, rate.size)
    largest = sliding_window_view(rate, rows).max(axis=1)
    at = int(np.argmin(largest))
    return (
        f"in the quietest {asked:g} s (from {time_s[at]:.5g} s) forces change by up to "
        f"{largest[at]:.3g} N/s, more than steady_rate_nps = {rule.rate_nps:g}",
        f"stand still in each pose, or set steady_rate_nps = {1.2 * largest[at]:.3g}",
    )


def medians(columns: FloatArray, stretches: tuple[SteadyStretch, ...]) -> FloatArray:
    """Median of each kept stretch, shape (P, …)."""
    kept = [s for s in stretches if s.verdict is StretchVerdict.KEPT]
    return np.array([np.median(columns[s.start : s.stop], axis=0) for s in kept]).reshape(
        len(kept), *columns.shape[1:]
    )
