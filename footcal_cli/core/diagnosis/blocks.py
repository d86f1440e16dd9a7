"""Cutting one recording into the blocks that are its unit of evidence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.core.contact import gait_cycles
from footcal_cli.core.inference.case import MOST_BLOCKS
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray

SHORTEST_BLOCK_S = 3.0
"""A block cut from one recording is at least this long."""
BLOCK_TAUS = 10.0
"""A block cut from one recording lasts at least this many autocorrelation times."""
GAP_TAUS = 2.0
STANCES = 10
"""From so many stances on each is one block, however long."""
PAUSE_S = 0.5
"""A longer pause of the log ends a stance: who knows what was moved meanwhile."""
SHORTEST_STANCE_S = 1.0
PIECE_S = 1.0
"""A stance is averaged over pieces at least so long: slow amplifiers and bodies are noisy for half
a second and more."""
_LEAST_CYCLES = 10
_EVEN_S = 0.5
_TAU_S = 0.3


def cut_balanced(log: Log) -> Log:
    """Stances of a few rows each; a walk in blocks of whole gait cycles, even ones if few."""
    if log.experiment == "stand":
        return piece_means(cut_stances(log))
    cycle = gait_cycles(log.known["contact"])
    if cycle.max(initial=-1) < _LEAST_CYCLES:
        cycle = even_cycles(log, _EVEN_S)
    return cut_blocks(log, cycle, _TAU_S)


def cut_blocks(log: Log, cycle: IntArray, tau_s: float, *, gap_s: float | None = None) -> Log:
    """Cut one recording into blocks of whole cycles, each at least `BLOCK_TAUS` τ long.

    Parameters
    ----------
    log
        One recording.
    cycle
        Number of the gait or leg cycle of each row, −1 outside, shape (n,).
    tau_s
        Autocorrelation time of the residual.
    gap_s
        Left out between blocks; 2 τ where None.
    """
    gap_s = GAP_TAUS * tau_s if gap_s is None else gap_s
    valid = cycle >= 0
    if not valid.any():
        return log
    count = int(cycle.max()) + 1
    starts = np.array([log.time_s[np.argmax(cycle == c)] for c in range(count)])
    span = float(log.time_s[valid][-1] - log.time_s[valid][0])
    least = max(BLOCK_TAUS * tau_s, span / MOST_BLOCKS, SHORTEST_BLOCK_S)
    block = np.full(len(log), -1, dtype=np.int64)
    number, begun = 0, starts[0]
    for c in range(count):
        if starts[c] - begun >= least:
            number, begun = number + 1, starts[c]
        block[cycle == c] = number
    for b in range(1, number + 1):
        first = log.time_s[block == b][0]
        block[(block == b) & (log.time_s < first + gap_s)] = -1
    return replace(log, block=block)


def cut_stances(log: Log) -> Log:
    """Number the stances of quiet standing; rows between them belong to no block.

    A stance ends where the log pauses or a foot is put down or lifted. What differs from one
    setting-down of the feet to the next (how a sole lies, where the CoM is believed) is alike
    within a stance: two halves of one are not two pieces of evidence. Only a recording of fewer
    than `STANCES` is cut further.
    """
    settled = np.isfinite(log.known["contact"]).all(axis=1)
    rows = np.flatnonzero(settled) if settled.any() else np.arange(len(log))
    moved = np.any(np.diff(np.nan_to_num(log.known["contact"][rows]), axis=0) != 0, axis=1)
    cuts = np.flatnonzero(moved | (np.diff(log.time_s[rows]) > PAUSE_S)) + 1
    stances = [
        part for part in np.split(rows, cuts)
        if log.time_s[part[-1]] - log.time_s[part[0]] >= SHORTEST_STANCE_S
    ] or [rows]  # fmt: skip
    seconds = [float(log.time_s[part[-1]] - log.time_s[part[0]]) for part in stances]
    least = max(SHORTEST_BLOCK_S, sum(seconds) / MOST_BLOCKS)
    whole = len(stances) >= STANCES
    block, number = np.full(len(log), -1, dtype=np.int64), 0
    for part, length in zip(stances, seconds, strict=True):
        for piece in np.array_split(part, 1 if whole else max(int(length // least), 1)):
            block[piece] = number
            number += 1
    return replace(log, block=block)


def piece_means(log: Log) -> Log:
    """A few rows per block: means over pieces of `PIECE_S`.

    Sway within a stance is evidence too, and better: what the next stance does not repeat is the
    same in all pieces of this one.
    """
    pieces = []
    for rows in [np.flatnonzero(log.block == b) for b in np.unique(log.block[log.block >= 0])]:
        length = float(log.time_s[rows[-1]] - log.time_s[rows[0]])
        pieces += np.array_split(rows, max(int(length // PIECE_S), 1))

    def mean(values: FloatArray) -> FloatArray:
        return np.stack([values[rows].mean(axis=0) for rows in pieces])

    return replace(
        log,
        time_s=mean(log.time_s),
        readings=mean(log.readings),
        known={name: mean(array) for name, array in log.known.items()},
        block=np.unique([log.block[rows[0]] for rows in pieces], return_inverse=True)[1],
    )


def even_cycles(log: Log, length_s: float) -> IntArray:
    """Stretches of equal length where there is no cycle, numbered from 0, shape (n,)."""
    return np.asarray((log.time_s - log.time_s[0]) // length_s, dtype=np.int64)
