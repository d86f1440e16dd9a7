"""Cutting one recording into the blocks that are its unit of evidence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.core.contact import gait_cycles
from footcal_cli.core.inference.case import MOST_BLOCKS
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray

SHORTEST_BLOCK_S = 3.0
"""A piece cut from one stance is at least this long."""
WALKED_S = 1.5
"""Likewise the block of a walk. Its rows are whitened and its calibration is tracked, so that
neighbouring ones are independent without a gap: in 10 clean walks of 15 to 17 blocks the lag-one
correlation of block scores is −0.08, where independent ones have −1/B = −0.06."""
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


def cut_balanced(log: Log) -> Log:
    """Stances of a few rows each; a walk in blocks of whole gait cycles, even ones if few."""
    if log.experiment == "stand":
        return piece_means(cut_stances(log))
    cycle = gait_cycles(log.known["contact"])
    if cycle.max(initial=-1) < _LEAST_CYCLES:
        cycle = even_cycles(log, _EVEN_S)
    return cut_blocks(log, cycle, WALKED_S)


def cut_blocks(log: Log, cycle: IntArray, least_s: float, gap_s: float = 0.0) -> Log:
    """Cut one recording into at most `MOST_BLOCKS` blocks of whole cycles.

    Parameters
    ----------
    log
        One recording.
    cycle
        Number of the gait or leg cycle of each row, −1 outside, shape (n,).
    least_s
        Shortest block.
    gap_s
        Left out between blocks.
    """
    valid = cycle >= 0
    if not valid.any():
        return log
    count = int(cycle.max()) + 1
    starts = np.array([log.time_s[np.argmax(cycle == c)] for c in range(count)])
    span = float(log.time_s[valid][-1] - log.time_s[valid][0])
    least = max(least_s, span / MOST_BLOCKS)
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
    pieces: list[IntArray] = []
    for rows in [np.flatnonzero(log.block == b) for b in np.unique(log.block[log.block >= 0])]:
        length = float(log.time_s[rows[-1]] - log.time_s[rows[0]])
        mean_only = not np.ptp(log.readings[rows], axis=0).any()  # a stance noted as one row
        pieces += np.array_split(rows, 1 if mean_only else max(int(length // PIECE_S), 1))

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
