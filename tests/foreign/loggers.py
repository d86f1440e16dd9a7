"""What sensors and loggers add: loops, drift, steps of converters, stamps, lost packets."""

from __future__ import annotations

import numpy as np
import pandas as pd

from tests.foreign.biped import Biped
from tests.foreign.kinds import Kind
from tests.foreign.noise import Array, Rng

DRIFT_MEMORY_S = 600.0
_LOOP_REACH = 0.1
"""Of the load range: how far the load turns back before a reading follows."""


def looped(load_n: Array, share: float, weight_n: float) -> Array:
    """Loads (n, c) as cells with hysteresis show them: a play behind a spring.

    Half the width of the loop is `share` of the range, which is the robot's weight.
    """
    if share == 0.0:
        return load_n
    reach = _LOOP_REACH * weight_n
    part = share / _LOOP_REACH
    play, out = load_n[0].copy(), np.empty_like(load_n)
    for i, row in enumerate(load_n):
        play = np.clip(play, row - reach, row + reach)
        out[i] = (1.0 - part) * row + part * play
    return out


class Drift:
    """Zeros of cells that wander with the temperature: an autoregression of ten minutes."""

    def __init__(self, robot: Biped, rng: Rng) -> None:
        """Begin; nothing is drawn for a robot that does not warm."""
        self.sd_n = robot.kind.warming * robot.weight_n
        self.rng, self.time_s, self.count = rng, 0.0, 0
        self.now, self.total = np.zeros((2, len(robot.channels)))
        if self.sd_n:
            self.now = rng.normal(size=len(robot.channels))

    def last(self, mean: bool) -> Array:
        """Drift at the end, or on the mean of all that was asked for, (c,)."""
        return np.asarray(self.total / max(self.count, 1) if mean else self.sd_n * self.now)

    def at(self, time_s: Array) -> Array:
        """Drift in newtons at rising times, (n, c); later than what was asked before."""
        if not self.sd_n:
            return np.zeros((len(time_s), 1))
        out = np.empty((len(time_s), len(self.now)))
        for i, t in enumerate(time_s):
            keep = np.exp(-max(t - self.time_s, 0.0) / DRIFT_MEMORY_S)
            fresh = np.sqrt(1.0 - keep**2) * self.rng.normal(size=len(self.now))
            self.now, self.time_s = keep * self.now + fresh, float(t)
            out[i] = self.sd_n * self.now
        self.count, self.total = self.count + len(out), self.total + out.sum(axis=0)
        return out


def converted(robot: Biped, counts: Array) -> Array:
    """Whole counts within the converter's range."""
    rounded = np.round(counts)
    return np.clip(rounded, 0, 2**robot.kind.bits - 1) if robot.kind.bits else rounded


def transported(kind: Kind, table: pd.DataFrame, rng: Rng) -> pd.DataFrame:
    """Stamps with jitter and steps, without the packets that were lost."""
    if kind.jitter_s:
        table["time_s"] += kind.jitter_s * rng.normal(size=len(table))
    table["time_s"] = np.round(np.round(table["time_s"] / kind.stamp_s) * kind.stamp_s, 6)
    if kind.lost:
        table = table[rng.random(len(table)) >= kind.lost]
    return table.drop_duplicates("time_s").sort_values("time_s").reset_index(drop=True)


def smoothed(values: Array, span: int) -> Array:
    """Means over `span` samples about each one."""
    if span < 2:
        return values
    padded = np.pad(values, ((span // 2, span // 2), (0, 0)), mode="edge")
    window = np.ones(span) / span
    return np.stack([np.convolve(c, window, "valid") for c in padded.T], axis=1)


def turned(values: Array, angle: Array) -> Array:
    """Vectors of two or three components (n, 2 or 3) turned by angles (n,) about z."""
    c, s = np.cos(angle), np.sin(angle)
    out = values.copy()
    out[:, 0], out[:, 1] = c * values[:, 0] - s * values[:, 1], s * values[:, 0] + c * values[:, 1]
    return out
