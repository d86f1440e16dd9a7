"""Hanging logs cut into runs of one orientation each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.effects.memory import play
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray

RUN = "hanging"
"""Key of `Log.known`: number of the run of each row, an index of `HangModel.nominal_dir_t`."""
LEVEL = "level_t"
"""Key of `Log.known`: horizontal axes of the attitude's world, shape (n, 3, 2)."""


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
    shaft_radps, shaft_radps2
        Speed and acceleration of the shaft, shape (n,); zero where the log does not say.
    level_t
        Horizontal axes of the attitude's world in the transducer frame, shape (3, 2), if known.
    """

    nominal_dir_t: FloatArray
    wrench: FloatArray
    phase_rad: FloatArray
    time_s: FloatArray
    temperature_degc: FloatArray
    leg_weight_n: float
    shaft_radps: FloatArray
    shaft_radps2: FloatArray
    level_t: FloatArray | None = None

    def log(self, leg: str, number: int, since_degc: float, since_s: float) -> Log:
        """The run as a log again, numbered as in a `HangModel`, since a temperature and a time."""
        rows = self.time_s.size
        known = {
            "phase_rad": self.phase_rad,
            "temperature_degc": self.temperature_degc - since_degc,
            "shaft_radps": self.shaft_radps,
            "shaft_radps2": self.shaft_radps2,
            **of_no_leg(np.tile(self.nominal_dir_t, (rows, 1))),
            RUN: np.full(rows, float(number)),
        }
        channels = tuple(f"{leg}.{axis}" for axis in AXES)
        block = np.full(rows, number, dtype=np.int64)
        return Log("hang", channels, self.time_s - since_s, self.wrench, known, block)


def of_no_leg(gravity_dir: FloatArray) -> dict[str, FloatArray]:
    """What neutral parameters say of each row: nothing hangs, gravity is where it nominally is."""
    nothing = np.zeros_like(gravity_dir)
    return {"gravity_dir": gravity_dir, "leg_weight_n": nothing[:, 0], "leg_com_m": nothing}


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
        direction, level = log.known["gravity_dir"], log.known.get(LEVEL)
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
                    None if level is None else level[part].mean(axis=0),
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


MOST_BLOCKS, FEWEST_BLOCKS = 48, 16
"""A sign-flip statistic cannot exceed the root of the number of blocks: 24 ask twice as much. Of
fewer than 16 no name is sure, and turns are cut into quarters."""
_QUARTER, _TREMOR = 0.5 * np.pi, 0.05
_ALMOST = 0.05  # of a unit: a tremor is lost where a shaft begins to move
MOST_RUNS = 200
"""Attitudes that somebody holds; more are a motion."""


def blocked(legs: Mapping[str, Sequence[Log]]) -> tuple[tuple[Log, ...], bool]:
    """One log per leg with its runs in order of time, and whether their clocks go on.

    A block is a number of whole turns in one run, the same for all legs: what shakes one hanging
    leg shakes the others too. Legs that make few turns, or swing to and fro, are cut where they
    have moved by a quarter of a turn. Runs without a motion are blocks of their own, and where the
    attitude changes from row to row, as many rows as make `MOST_BLOCKS`.
    """
    joined = {leg: _joined(logs) for leg, logs in legs.items()}
    runs = max(int(log.known[RUN].max()) + 1 for log in joined.values())
    each = max(MOST_BLOCKS // runs, 1)
    logs = tuple(_cut(log, each, 2.0 * np.pi) for log in joined.values())
    if max(np.unique(log.block).size for log in logs) < FEWEST_BLOCKS:
        logs = tuple(_cut(log, each, _QUARTER) for log in joined.values())
    if runs > MOST_RUNS:
        logs = tuple(replace(log, block=log.block * MOST_BLOCKS // runs) for log in logs)
    return logs, all(bool(np.all(np.diff(log.time_s) > 0)) for log in logs)


def are_held(logs: Sequence[Log]) -> bool:
    """Whether an attitude lasts: of one row each, nobody can tell its zero from its load."""
    runs = [int(log.known[RUN].max()) + 1 for log in logs]
    lasting = (len(log) >= 2 * n for log, n in zip(logs, runs, strict=True))
    return max(runs) <= MOST_RUNS and all(lasting)


def _joined(logs: Sequence[Log]) -> Log:
    """Rows of all logs of one leg, one after the other, each run numbered."""
    first = logs[0]
    edges = [run_edges(log) for log in logs]
    run, number = [], 0
    for log, edge in zip(logs, edges, strict=True):
        own = np.zeros(len(log), dtype=np.int64)
        own[edge[1:-1]] = 1
        run.append(number + np.cumsum(own))
        number += len(edge) - 1
    shared = set.intersection(*(set(log.known) for log in logs))
    known = {name: np.concatenate([log.known[name] for log in logs]) for name in shared}
    return Log(
        first.experiment,
        first.channels,
        np.concatenate([log.time_s for log in logs]),
        np.concatenate([log.readings for log in logs]),
        {**known, RUN: np.concatenate(run).astype(float)},
        np.concatenate(run),
    )


def _cut(log: Log, each: int, unit_rad: float) -> Log:
    """At most `each` blocks of so much motion per run, numbered run by run."""
    run = log.known[RUN].astype(np.int64)
    block = run * each
    for number in range(int(run.max()) + 1):
        rows = np.flatnonzero(run == number)
        block[rows] += _pieces(log.known["phase_rad"][rows], each, unit_rad)
    return Log(log.experiment, log.channels, log.time_s, log.readings, log.known, block)


def _pieces(phase_rad: FloatArray, each: int, unit_rad: float) -> IntArray:
    """Piece of each row: units of motion dealt out evenly, what is left goes with the last."""
    moved = _travel(phase_rad) / unit_rad
    units = int(moved.max(initial=0.0) + _ALMOST)
    if units < 2:
        return np.zeros(phase_rad.size, dtype=np.int64)
    pieces = min(each, units)
    unit = np.minimum(moved.astype(np.int64), units - 1)
    return np.asarray(unit * pieces // units)


def _travel(phase_rad: FloatArray) -> FloatArray:
    """How far a shaft has moved, to and fro alike, shape (n,); what trembles does not move."""
    angle = np.unwrap(phase_rad)[:, None]
    held = play(angle, np.array([_TREMOR]), angle[0], np.zeros(angle.size, dtype=bool))[:, 0]
    return np.asarray(np.cumsum(np.abs(np.diff(held, prepend=held[:1]))))
