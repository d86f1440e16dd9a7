"""Every parameter of many sessions: over time per robot, and its spread over robots and days."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.inference.repeated import (
    FEWEST_SESSIONS,
    Change,
    Component,
    Level,
    Trend,
    components_of,
    find_changes,
    level_of_sessions,
    outlying,
    segments_of,
    trend_of,
)
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

ALPHA = 0.05
"""Probability of a false change, trend or outlying session in a whole batch."""


@dataclass(frozen=True)
class Sessions:
    """What all sessions found, in the order of time.

    Parameters
    ----------
    names, robot, operator, day
        Labels, shape (n,); empty where it is not said.
    time
        Days since the first, or the session's number where dates are missing, shape (n,).
    values, sd
        Parameter -> shape (n,), NaN where a session did not estimate it.
    units
        Parameter -> unit.
    """

    names: NDArray[np.str_]
    robot: NDArray[np.str_]
    operator: NDArray[np.str_]
    day: NDArray[np.str_]
    time: FloatArray
    values: Mapping[str, FloatArray]
    sd: Mapping[str, FloatArray]
    units: Mapping[str, str]


@dataclass(frozen=True)
class ParameterSeries:
    """One parameter of one robot over time.

    Parameters
    ----------
    at
        Numbers of the sessions that estimated it, shape (k,).
    time, values, sd
        Shape (k,).
    changes
        Change points; empty where a steady trend explains them better.
    segment
        Of each session, shape (k,).
    levels
        Of each segment, outlying sessions left out.
    trend
        A straight line through all of them; None where there are too few.
    drifting
        Whether the trend is significant and no change points explain it.
    p_outlying
        Of each session, shape (k,).
    """

    parameter: str
    unit: str
    robot: str
    at: IntArray
    time: FloatArray
    values: FloatArray
    sd: FloatArray
    changes: tuple[Change, ...]
    segment: IntArray
    levels: tuple[Level, ...]
    trend: Trend | None
    drifting: bool
    p_outlying: FloatArray
    alpha: float

    @property
    def outlying(self) -> BoolArray:
        """Sessions that belong to no level, shape (k,)."""
        return np.asarray(self.p_outlying < self.alpha)

    @property
    def drift(self) -> tuple[float, float] | None:
        """Last minus first level, or what the trend makes of the whole span, with sd."""
        if self.changes:
            first, last = self.levels[0], self.levels[-1]
            return last.value - first.value, float(np.hypot(first.sd, last.sd))
        return None if self.trend is None else (self.trend.total, self.trend.total_sd)

    @property
    def proved(self) -> bool:
        """Whether it changed at all."""
        return bool(self.changes) or self.drifting


@dataclass(frozen=True)
class Budget:
    """Where the spread of one parameter comes from.

    Parameters
    ----------
    sessions
        How many estimated it.
    claimed_sd
        Root mean square of the sds that the fits claim.
    components
        Spread by source, change points taken out, outlying sessions left out.
    """

    parameter: str
    unit: str
    sessions: int
    claimed_sd: float
    components: tuple[Component, ...]

    def sd_of(self, name: str) -> float:
        """Sd of one source; 0 where it could not be distinguished."""
        return next((c.sd for c in self.components if c.name == name), 0.0)

    @property
    def gauge_sd(self) -> float:
        """Repeatability and reproducibility (operator, day) together."""
        own = [c.sd for c in self.components if c.name != "robot"]
        return float(np.sqrt(np.sum(np.square(own))))

    @property
    def standard_uncertainty(self) -> float:
        """Of one session's value: the larger of claim and repeatability, and reproducibility."""
        repeat = max(self.claimed_sd, self.sd_of("repeatability"))
        other = [c.sd for c in self.components if c.name not in ("robot", "repeatability")]
        return float(np.sqrt(repeat**2 + np.sum(np.square(other))))

    @property
    def gauge_share(self) -> float | None:
        """GRR over total spread (AIAG's % study variation / 100); None with one robot."""
        if all(c.name != "robot" for c in self.components):
            return None
        total = float(np.hypot(self.gauge_sd, self.sd_of("robot")))
        return self.gauge_sd / total if total > 0 else None


@dataclass(frozen=True)
class Fleet:
    """What many sessions say together."""

    sessions: Sessions
    series: tuple[ParameterSeries, ...]
    budgets: tuple[Budget, ...]

    def outlying_sessions(self) -> dict[str, list[str]]:
        """Session -> parameters in which it lies apart."""
        found: dict[str, list[str]] = {}
        for series in self.series:
            for i in series.at[series.outlying]:
                found.setdefault(str(self.sessions.names[i]), []).append(series.parameter)
        return found


def study(sessions: Sessions) -> Fleet:
    """Look at every parameter of every robot, then at each parameter's spread over all of them.

    Parameters
    ----------
    sessions
        In the order of time.
    """
    robots = list(dict.fromkeys(sessions.robot.tolist()))
    places = [
        (name, robot, np.flatnonzero((sessions.robot == robot) & np.isfinite(values)))
        for name, values in sessions.values.items()
        for robot in robots
    ]
    tested = sum(at.size >= FEWEST_SESSIONS for _, _, at in places)
    own = ALPHA / max(tested, 1)
    series = tuple(_series(sessions, name, robot, at, own) for name, robot, at in places if at.size)
    budgets = tuple(
        _budget(sessions, name, [s for s in series if s.parameter == name])
        for name in sessions.values
        if any(s.parameter == name for s in series)
    )
    return Fleet(sessions, series, budgets)


def _series(
    sessions: Sessions, name: str, robot: str, at: IntArray, alpha: float
) -> ParameterSeries:
    time, values, sd = sessions.time[at], sessions.values[name][at], sessions.sd[name][at]
    none = np.zeros(at.size, dtype=np.int64)
    # one outlying session must neither make a change nor hide one
    p_first = outlying(values, sd, none, alpha=alpha)
    kept = np.flatnonzero(p_first >= alpha)
    changes = tuple(
        Change(int(kept[c.first_after]), c.size, c.sd, c.p)
        for c in find_changes(values[kept], sd[kept], alpha=alpha)
    )
    trend = trend_of(time[kept], values[kept], sd[kept])
    if trend is not None and changes and _line_is_better(time, values, sd, changes, kept):
        changes = ()
    segment = segments_of(changes, at.size)
    drifting = trend is not None and not changes and trend.p < alpha
    left = values
    if drifting and trend is not None:
        left = values - trend.slope * (time - time.mean())
    p = outlying(left, sd, segment, alpha=alpha)
    good = p >= alpha
    levels = tuple(
        level_of_sessions(values[(segment == k) & good], sd[(segment == k) & good])
        for k in range(len(changes) + 1)
        if np.any((segment == k) & good)
    )
    if len(levels) <= len(changes):  # a segment of outlying sessions only is no level
        changes, segment = (), none
        levels = (level_of_sessions(values, sd),)
    return ParameterSeries(
        name, sessions.units[name], robot, at, time, values, sd, changes, segment, levels, trend,
        drifting, p, alpha,
    )  # fmt: skip


def _line_is_better(
    time: FloatArray, values: FloatArray, sd: FloatArray, changes: Sequence[Change], kept: IntArray
) -> bool:
    """Whether one straight line explains what the change points explain (Schwarz's criterion)."""
    segment = segments_of(changes, values.size)[kept]
    y, t = values[kept], time[kept]
    steps = np.eye(len(changes) + 1)[segment]
    line = np.column_stack([np.ones(t.size), t - t.mean()])
    tau = max(
        level_of_sessions(y[segment == k], sd[kept][segment == k]).between_sd for k in set(segment)
    )
    weight = 1.0 / np.sqrt(np.maximum(sd[kept] ** 2 + tau**2, 1e-300))
    scores = []
    # a change point costs two numbers: where it is, and how large
    for design, numbers in ((steps, 1 + 2 * len(changes)), (line, 2)):
        white = design * weight[:, None]
        left = y * weight - white @ np.linalg.lstsq(white, y * weight, rcond=None)[0]
        scores.append(float(left @ left) + numbers * np.log(t.size))
    return bool(scores[1] < scores[0])


def _budget(sessions: Sessions, name: str, series: Sequence[ParameterSeries]) -> Budget:
    """Components of one parameter, change points and trends taken out."""
    values, at = [], []
    for one in series:
        left = one.values.copy()
        if one.drifting and one.trend is not None:
            left -= one.trend.slope * (one.time - one.time[-1])
        elif one.changes:
            levels = np.array([level.value for level in one.levels])
            left += levels[-1] - levels[one.segment]
        good = ~one.outlying
        values.append(left[good])
        at.append(one.at[good])
    rows, flat = np.concatenate(at), np.concatenate(values)
    robot, operator, day = (
        labels[rows] for labels in (sessions.robot, sessions.operator, sessions.day)
    )
    groups: dict[str, NDArray[np.generic]] = {"robot": robot}
    if np.unique(operator).size > 1:
        groups["operator"] = operator
    elif np.unique(day).size > 1:
        groups["day"] = np.char.add(np.char.add(robot, "|"), day)
    claimed = float(np.sqrt(np.mean(sessions.sd[name][rows] ** 2))) if rows.size else 0.0
    components = components_of(flat, groups) if rows.size > 2 else ()
    return Budget(name, sessions.units[name], rows.size, claimed, components)
