"""Hanging logs as one log per leg, cut into blocks of whole turns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.hang.runs import RUN, run_edges
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray

MOST_BLOCKS = 48
"""A sign-flip statistic cannot exceed the root of the number of blocks: 24 ask twice as much."""


def blocked(legs: Mapping[str, Sequence[Log]]) -> tuple[tuple[Log, ...], bool]:
    """One log per leg with its runs in order of time, and whether their clocks go on.

    A block is a number of whole turns in one run, the same for all legs: what shakes one hanging
    leg shakes the others too. Runs without turns are blocks of their own.
    """
    joined = {leg: _joined(logs) for leg, logs in legs.items()}
    runs = max(int(log.known[RUN].max()) + 1 for log in joined.values())
    each = max(MOST_BLOCKS // runs, 1)
    logs = tuple(_cut(log, each) for log in joined.values())
    return logs, all(bool(np.all(np.diff(log.time_s) > 0)) for log in logs)


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


def _cut(log: Log, each: int) -> Log:
    """At most `each` blocks of whole turns per run, numbered run by run."""
    run = log.known[RUN].astype(np.int64)
    block = run * each
    for number in range(int(run.max()) + 1):
        rows = np.flatnonzero(run == number)
        block[rows] += _pieces(log.known["phase_rad"][rows], each)
    return Log(log.experiment, log.channels, log.time_s, log.readings, log.known, block)


def _pieces(phase_rad: FloatArray, each: int) -> IntArray:
    """Piece of each row: whole turns dealt out evenly, what is left goes with the last."""
    turned = np.abs(np.unwrap(phase_rad) - phase_rad[0]) / (2.0 * np.pi)
    turns = int(turned.max(initial=0.0) + 1e-6)
    if turns < 2:
        return np.zeros(phase_rad.size, dtype=np.int64)
    pieces = min(each, turns)
    turn = np.minimum(turned.astype(np.int64), turns - 1)
    return np.asarray(turn * pieces // turns)
