"""Samples of feet and body as they arrive, merged to rows of a walk for the live estimator.

The rows are those of `footcal_cli.core.online.streams.merge_cells` with a causal rule. They are
made anew over the last seconds; what a filter remembers of the window's beginning has died away
long before the rows that are given out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np

from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.merging import merge_cells
from footcal_cli.core.online.streams import BodyStream, MergeRule, SensorStream
from footcal_cli.core.parameters import FloatArray

WINDOW_S = 4.0
"""Of the past that is merged anew; at 1 Hz a second-order low-pass has forgotten all but 1e-9."""
_BODY_SAMPLES = 3
"""Samples of the body after a row: accelerations of the feet are second differences."""
_LEAST_S = 0.5
S = TypeVar("S", SensorStream, BodyStream)


@dataclass(frozen=True)
class RobotFacts:
    """What does not change along a walk.

    Parameters
    ----------
    belief
        Calibration by which contact is detected.
    cells_foot_m
        Cell positions in each foot's frame, shape (cells, 2) each.
    mass_kg, gravity_mps2
        Of the robot, and where it walks.
    """

    belief: Belief
    cells_foot_m: tuple[FloatArray, ...]
    mass_kg: float
    gravity_mps2: float = 9.80665


class LiveFeed:
    """Merges what arrives to rows that `LiveEstimator` takes.

    Parameters
    ----------
    robot
        Its cells and its mass.
    rule
        As of `merge_cells`; always causal.
    patience_s
        How long a row waits for the body's stream; after that it is given out without it.
    """

    def __init__(
        self, robot: RobotFacts, rule: MergeRule | None = None, patience_s: float = 0.5
    ) -> None:
        self._robot = robot
        self._rule = replace(rule or MergeRule(), causal=True)
        self._patience_s = patience_s
        self._sensors: SensorStream | None = None
        self._body: BodyStream | None = None
        self._given_s = -np.inf

    def push(self, sensors: SensorStream | None = None, body: BodyStream | None = None) -> Log:
        """Take in samples of either stream, one or more, and give the rows that are final.

        Parameters
        ----------
        sensors, body
            With increasing stamps of one clock.
        """
        if sensors is not None:
            self._sensors = _longer(self._sensors, sensors)
        if body is not None:
            self._body = _longer(self._body, body)
        none = np.zeros(0)
        both = self._sensors, self._body
        if both[0] is None or both[1] is None or not self._ready(both[0], both[1]):
            channels = self._robot.belief.channels
            return Log("walk", channels, none, np.zeros((0, len(channels))), {}, none.astype(int))
        log = merge_cells(
            both[0], both[1], self._robot.belief, self._robot.cells_foot_m,
            self._robot.mass_kg, self._robot.gravity_mps2, rule=self._rule,
        ).log  # fmt: skip
        final = (log.time_s > self._given_s) & (log.time_s <= self._final_s(both[0], both[1]))
        rows = log.at(final)
        if len(rows):
            self._given_s = float(rows.time_s[-1])
        oldest = self._given_s - WINDOW_S
        self._sensors = _shorter(both[0], oldest)
        self._body = _shorter(both[1], oldest + self._rule.delay_s)
        return rows

    def _final_s(self, sensors: SensorStream, body: BodyStream) -> float:
        """Stamp up to which no sample that is still to come changes a row."""
        covered = float(body.time_s[-1 - _BODY_SAMPLES]) - self._rule.delay_s
        return max(covered, float(sensors.time_s[-1]) - self._patience_s)

    def _ready(self, sensors: SensorStream, body: BodyStream) -> bool:
        """Whether a row is final, and both streams are long enough for their rates to be known."""
        if min(_span(sensors.time_s), _span(body.time_s)) < _LEAST_S:
            return False
        waiting = sensors.time_s > self._given_s
        return bool(np.any(waiting & (sensors.time_s <= self._final_s(sensors, body))))


def _span(time_s: FloatArray) -> float:
    return float(time_s[-1] - time_s[0])


def _longer(before: S | None, new: S) -> S:
    """A stream with samples added."""
    if before is None:
        return new
    return _each(before, [before, new], np.concatenate)


def _shorter(stream: S, oldest_s: float) -> S:
    """A stream without what is too old, cut seldom."""
    start = int(np.searchsorted(stream.time_s, oldest_s))
    if start < stream.time_s.size // 2:
        return stream
    return _each(stream, [stream], lambda parts: parts[0][start:])


def _each(like: S, streams: Sequence[S], change: Callable[[list[Any]], Any]) -> S:
    changed: dict[str, Any] = {}
    for field in fields(like):
        parts = [getattr(stream, field.name) for stream in streams]
        if isinstance(parts[0], np.ndarray):
            changed[field.name] = change(parts)
    return replace(like, **changed)
