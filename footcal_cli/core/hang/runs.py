"""Hanging logs cut into runs of one orientation each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray

RUN = "hanging"
"""Key of `Log.known`: number of the run of each row, an index of `HangModel.nominal_dir_t`."""


@dataclass(frozen=True)
class HangRun:
    """Rows of one leg in one nominal orientation.

    Parameters
    ----------
    nominal_dir_t
        Nominal unit direction of gravity in the transducer frame, shape (3,).
    wrench
        Readings, shape (n, 6), N and Nm.
    phase_rad, time_s, temperature_degc
        Shape (n,); temperature is 0 where the log has none.
    leg_weight_n
        Believed weight of the leg.
    shaft_radps, shaft_radps2
        Speed and acceleration of the shaft, shape (n,); zero where the log does not say.
    """

    nominal_dir_t: FloatArray
    wrench: FloatArray
    phase_rad: FloatArray
    time_s: FloatArray
    temperature_degc: FloatArray
    leg_weight_n: float
    shaft_radps: FloatArray
    shaft_radps2: FloatArray

    def log(self, leg: str, number: int, since_degc: float, since_s: float) -> Log:
        """The run as a log again, numbered as in a `HangModel`, since a temperature and a time."""
        rows = self.time_s.size
        known = {
            "phase_rad": self.phase_rad,
            "temperature_degc": self.temperature_degc - since_degc,
            "shaft_radps": self.shaft_radps,
            "shaft_radps2": self.shaft_radps2,
            RUN: np.full(rows, float(number)),
        }
        channels = tuple(f"{leg}.{axis}" for axis in AXES)
        block = np.full(rows, number, dtype=np.int64)
        return Log("hang", channels, self.time_s - since_s, self.wrench, known, block)


def hang_runs(logs: Sequence[Log]) -> tuple[tuple[HangRun, ...], str]:
    """Consecutive rows of equal nominal direction, and the leg they all belong to.

    Raises
    ------
    ValueError
        Where the logs are of different legs, empty, or hold readings that are not numbers.
    """
    legs = {channel.split(".")[0] for log in logs for channel in log.channels}
    if len(legs) != 1:
        raise ValueError(f"hanging logs of one leg are needed, got {sorted(legs) or 'none'}")
    runs = []
    for log in logs:
        if len(log) == 0:
            continue
        # One sum instead of a mask: it is a number only if every reading is.
        if not np.isfinite(log.readings.sum()):
            raise ValueError("readings that are not numbers: drop those rows first")
        direction = log.known["gravity_dir"]
        for start, stop in pairwise(run_edges(log)):
            part = slice(start, stop)
            first = direction[start]
            runs.append(
                HangRun(
                    first / np.linalg.norm(first),
                    log.readings[part],
                    log.known["phase_rad"][part],
                    log.time_s[part],
                    log.known.get("temperature_degc", np.zeros(len(log)))[part],
                    float(log.known["leg_weight_n"][start]),
                    log.known.get("shaft_radps", np.zeros(len(log)))[part],
                    log.known.get("shaft_radps2", np.zeros(len(log)))[part],
                )
            )
    if not runs:
        raise ValueError("no rows")
    return tuple(runs), legs.pop()


def run_edges(log: Log) -> IntArray:
    """First row of each run of equal nominal direction, and the number of rows, (runs + 1,)."""
    x, y, z = log.known["gravity_dir"].T
    turned = (x[1:] != x[:-1]) | (y[1:] != y[:-1]) | (z[1:] != z[:-1])
    return np.concatenate([[0], np.flatnonzero(turned) + 1, [len(log)]]).astype(np.int64)
