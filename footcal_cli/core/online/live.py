"""The estimator that remembers as it runs on a robot: everything is learnt from the past alone.

After 8, 16, 32 … seconds the delay, the noise and whether plates hang on the feet are learnt from
what has been logged by then, the past is filtered again with them, and they serve until the next
time. What remains is latency: that of the low-pass, and the delay of the body's stream itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.evidence import repetition
from footcal_cli.core.online.filter import Track, WalkNoise, run_filter
from footcal_cli.core.online.memory import (
    Memory,
    MemoryOptions,
    begun_delay_s,
    believed,
    gait_phase,
    noise_learnt,
    walk_rows,
)
from footcal_cli.core.online.reference_states import HINDSIGHT_STATES, advanced
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.online.smoother import run_smoother
from footcal_cli.core.online.tuning import Tuning
from footcal_cli.core.parameters import FloatArray, IntArray

FIRST_LEARNING_S = 8.0
"""When the first learning happens; then each time the log has doubled."""


@dataclass(frozen=True)
class Learnt:
    """What the past has taught: delay, noise, and states that are not needed."""

    delay_s: float
    noise: WalkNoise
    tuning: Tuning | None
    unneeded: tuple[str, ...]


@dataclass(frozen=True)
class _Piece:
    """Updates ``start:stop`` of a track that knew only what had been learnt by `start`."""

    track: Track
    start: int
    stop: int
    delay_s: float


def of_live(options: MemoryOptions | None) -> MemoryOptions:
    """Options without hindsight, and without the states that the past alone leaves to guessing.

    What smooths the reference stands before a causal low-pass then, and its derivatives behind.
    """
    options = options or MemoryOptions()
    states = tuple(s for s in options.states if s not in HINDSIGHT_STATES)
    return replace(options, states=states, hindsight=False)


def run_live(log: Log, belief: Belief, options: MemoryOptions | None = None) -> Memory:
    """Filter a walk as a live run would have.

    Parameters
    ----------
    log
        Raw counts, filtered causally, contact detected without the future.
    options
        As `footcal_cli.core.online.memory.run_memory`.

    Returns
    -------
    The track of the live run; its smoothed track is an estimate after the fact.
    """
    options = of_live(options)
    size = options.samples_per_update
    every = walk_rows(log, belief, options)
    every.refuse_if_empty()
    updates = every.time_s
    learnt = Learnt(0.0, options.noise, None, ())
    pieces: list[_Piece] = []
    for start, stop in pairwise(_edges(updates)):
        seen = log.rows(0, stop * size)
        ahead = log.rows(0, stop * size + ahead_of(log, learnt.delay_s))
        rows = rows_by_then(ahead, stop, learnt, belief, options)
        track = run_filter(rows, learnt.noise, options.guards)
        factor = 1.0
        if start:
            known = _past(track, start)
            factor = repeated_by_then(log, rows.part(0, start), known, options)
        pieces.append(_Piece(track.inflated(factor), start, stop, learnt.delay_s))
        last = learnt
        if stop < updates.size:
            learnt = learn(seen, rows, track, learnt, belief, options)
    moved = advanced(log, last.delay_s)
    rows = _without(walk_rows(moved, belief, options), last.unneeded)
    live = _joined(pieces, rows, last.delay_s)
    past = run_smoother(rows, last.noise, options.guards, live.jumps)
    return Memory(
        rows, live, past, live.jumps, last.tuning, last.noise, factor, last.delay_s,
        live.at_end("robot.delay")[1], moved,
    )  # fmt: skip


def ahead_of(log: Log, delay_s: float) -> int:
    """Samples after a row that it looks at: for a slope, and for a body that comes late."""
    period_s = float(np.median(np.diff(log.time_s))) if len(log) > 1 else 1.0
    return 2 + int(np.ceil(max(delay_s, 0.0) / period_s))


def rows_by_then(
    log: Log, updates: int, learnt: Learnt, belief: Belief, options: MemoryOptions
) -> Rows:
    """The first rows of a log with what had been learnt."""
    moved = advanced(log, learnt.delay_s)
    return _without(walk_rows(moved, belief, options), learnt.unneeded).part(0, updates)


def repeated_by_then(log: Log, rows: Rows, track: Track, options: MemoryOptions) -> float:
    """How much the errors of these rows repeat, from the gait cycles that were whole by then."""
    seen = log.rows(0, len(rows) * options.samples_per_update)
    return repetition(track, gait_phase(seen, rows), rows.totals)


def _edges(time_s: FloatArray) -> list[int]:
    """Updates between which nothing is learnt, the first and the last included."""
    edges, after = [0], FIRST_LEARNING_S
    while after < time_s[-1] - time_s[0]:
        edges.append(int(np.searchsorted(time_s, time_s[0] + after)))
        after *= 2.0
    return [*edges, time_s.size]


def _without(rows: Rows, names: Sequence[str]) -> Rows:
    return rows.without(np.isin(rows.names, names)) if names else rows


def learn(
    seen: Log, rows: Rows, track: Track, learnt: Learnt, belief: Belief, options: MemoryOptions
) -> Learnt:
    """Delay, noise and states from the log so far."""
    delay = learnt.delay_s
    if options.align and "robot.delay" in rows.names:
        coarse = 0.0 if delay else begun_delay_s(seen, belief, options)
        delay += coarse or track.at_end("robot.delay")[0]
    moved = advanced(seen, delay)
    whole = walk_rows(moved, belief, options)
    noise, tuning = noise_learnt(whole, options, track.jumps)
    first = run_filter(whole, noise, options.guards)
    factor = repetition(first, gait_phase(moved, whole), whole.totals)
    needed = believed(whole, noise, options.guards, factor).names
    return Learnt(delay, noise, tuning, tuple(n for n in whole.names if n not in needed))


def _past(track: Track, updates: int) -> Track:
    """The innovations of the first updates."""
    return replace(
        track,
        time_s=track.time_s[:updates],
        innovation=track.innovation[:updates],
        innovation_sd=track.innovation_sd[:updates],
    )


def _joined(pieces: Sequence[_Piece], rows: Rows, delay_s: float) -> Track:
    """One track of all pieces; a state that was not believed in at the end is left out."""
    u, p = len(rows), len(rows.names)
    values, sd = np.zeros((u, p)), np.zeros((u, p))
    channels = len(rows.outputs) - rows.totals
    momentary = np.zeros((u, channels))
    nis, gain, used = np.zeros(u), np.zeros(u), np.zeros(u, dtype=bool)
    innovation = np.full(rows.error.shape, np.nan)
    innovation_sd = innovation.copy()
    jumps = []
    for piece in pieces:
        track, part = piece.track, slice(piece.start, piece.stop)
        both = [name for name in rows.names if name in track.names]
        at: IntArray = np.array([rows.names.index(name) for name in both])
        own: IntArray = np.array([track.names.index(name) for name in both])
        values[part, at] = track.values[part, own]
        sd[part, at] = track.sd[part, own]
        if "robot.delay" in track.names:
            values[part, rows.names.index("robot.delay")] += piece.delay_s - delay_s
        if track.momentary is not None:
            momentary[part] = track.momentary[part]
        nis[part], gain[part], used[part] = track.nis[part], track.gain_nats[part], track.used[part]
        innovation[part], innovation_sd[part] = track.innovation[part], track.innovation_sd[part]
        first, last = track.time_s[piece.start], track.time_s[piece.stop - 1]
        jumps += [jump for jump in track.jumps if first <= jump.found_s <= last]
    return Track(
        rows.time_s, rows.names, rows.units, values, sd, momentary, track.covariance, nis,
        rows.valid.sum(axis=1).astype(float), innovation, innovation_sd, gain, used,
        track.log_likelihood, tuple(jumps),
    )  # fmt: skip
