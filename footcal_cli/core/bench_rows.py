"""Rows of a bench log: stuck, taken after a tare, or after a pause of hours."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.quality import Finding

STUCK_SHARE = 0.1
"""Share of the loads' range that a reading may ignore while it stays the same."""
_STUCK_COUNTS, _STUCK_ROWS = 5.0, 3
TARED = 0.1
"""Residual with a second zero over the residual with one, below which the log was tared."""
_TARED_SD, _TARED_ROWS = 20.0, 4

UNEVEN = "uneven_scatter"
_FEWEST_LOADS, _FEWEST_CELLS = 3, 3
_SURELY_UNEVEN, _UNEVEN = 1e-6, 3.0
"""By chance, and RMS error of a cell over that of all others, from which it is one of its own."""
_ROWS_OF_A_HOLD = 20
_OF_THE_RANGE = 0.25
"""How far a level lies from the lightest, of the farthest; how much that may scatter, of this."""
_EMPTY = 0.1
"""So many readings under a load that are of the unloaded cell are no glitches."""
_PAUSE_S, _PAUSE_STEPS = 3600.0, 50.0
"""A pause between sessions, at least, and in usual steps from row to row."""


def check_stuck_reading(load_n: FloatArray, counts: FloatArray, channel: str) -> list[Finding]:
    """Find a cell whose reading stays exactly the same while its known load changes.

    Parameters
    ----------
    load_n, counts
        In the order they were taken, shape (n,).
    """
    good = np.isfinite(load_n) & np.isfinite(counts)
    load, count = load_n[good], counts[good]
    span, moved = float(np.ptp(load)) if load.size else 0.0, np.ptp(count) if load.size else 0.0
    if load.size < 2 * _STUCK_ROWS or span == 0.0 or not moved > 0:
        return []
    ignored, start, stop = 0.0, 0, 0
    edges = np.flatnonzero(np.concatenate([[True], np.diff(count) != 0, [True]]))
    for first, end in pairwise(edges.tolist()):
        if end - first >= _STUCK_ROWS and np.ptp(load[first:end]) > ignored:
            ignored, start, stop = float(np.ptp(load[first:end])), first, end
    held = _held_load(load, count)
    if held is not None:
        start, stop = held
        return [
            Finding(
                "stuck_load", "alarm", channel,
                f"the load stays at {load[start]:.4g} N for {stop - start} rows while the readings "
                f"change by {_most_of(count[start:stop]) / moved:.0%} of their range",
                "correct the loads of these rows, or leave them out",
            )
        ]  # fmt: skip
    if ignored < STUCK_SHARE * span or ignored / span * moved < _STUCK_COUNTS:
        return []
    return [
        Finding(
            "stuck", "alarm", channel,
            f"the reading stays at {count[start]:.10g} for {stop - start} rows while the load "
            f"changes by {ignored:.3g} N",
            "check the converter's connection; leave these rows out",
        )
    ]  # fmt: skip


def _held_load(load: FloatArray, count: FloatArray) -> tuple[int, int] | None:
    """Rows of one load in which the readings change as if it were several; None without any."""
    edges = np.flatnonzero(np.concatenate([[True], np.diff(load) != 0, [True]]))
    span = float(np.ptp(count))
    for start, stop in pairwise(edges):
        moved = _most_of(count[start:stop])
        others = np.concatenate([np.arange(start), np.arange(stop, load.size)])
        few = np.unique(load[others]).size < 3
        if stop - start < _STUCK_ROWS or moved < STUCK_SHARE * span or few:
            continue
        off = count[others] - np.polyval(np.polyfit(load[others], count[others], 1), load[others])
        if moved > _TARED_SD * off.std():
            return int(start), int(stop)
    return None


def _most_of(values: FloatArray) -> float:
    """Range of values (n,) without the tenth at each end of many: hands touch a weight there."""
    if values.size < _ROWS_OF_A_HOLD:
        return float(np.ptp(values))
    return float(np.subtract(*np.percentile(values, [90, 10])))


def check_tare(load_n: FloatArray, counts: FloatArray, channel: str) -> list[Finding]:
    """Find a zero that moves between two rows: ``counts = a (+ jump) + b load``.

    Parameters
    ----------
    load_n, counts
        Of one session, in the order they were taken, shape (n,).
    """
    good = np.isfinite(load_n) & np.isfinite(counts)
    load, count = load_n[good], counts[good]
    n = load.size
    if n < 3 * _TARED_ROWS or np.unique(load).size < 3:
        return []
    basis, _ = np.linalg.qr(np.column_stack([np.ones(n), load]))
    rest = count - basis @ (basis.T @ count)
    before = float(rest @ rest)
    # a step from each row on, without what a bias and a load explain of it
    row = np.arange(_TARED_ROWS, n - _TARED_ROWS + 1)
    known = np.cumsum(basis[::-1], axis=0)[::-1][row]
    energy = n - row - np.einsum("ij,ij->i", known, known)
    seen = energy > 1e-9 * n  # a step that follows the load is none
    along = np.where(seen, np.cumsum(rest[::-1])[::-1][row], 0.0)
    size = along / np.where(seen, energy, 1.0)
    best = int(np.argmax(size * along))
    jump, at = float(size[best]), int(row[best])
    two = max(before - float(size[best] * along[best]), 0.0)
    shared = np.intersect1d(load[:at], load[at:])
    moves = [
        float(count[at:][load[at:] == one].mean() - count[:at][load[:at] == one].mean())
        for one in shared
    ]
    both = bool(moves) and np.unique(load[:at]).size > 1 and np.unique(load[at:]).size > 1
    both &= all(0.5 * abs(jump) < move * np.sign(jump) < 2.0 * abs(jump) for move in moves)
    sd = np.sqrt(two / (n - 3))
    if not both or two > TARED**2 * before or abs(jump) < _TARED_SD * sd:
        return []
    return [
        Finding(
            "tared", "warning", channel,
            f"from row {at + 1} of {n} on, the readings differ by {jump:+.4g} counts from those "
            "under the same loads before: it looks tared or mounted anew",
            "say which rows belong together in a column `session`, or give two logs",
        )
    ]  # fmt: skip


def _held_in_part(load: FloatArray, count: FloatArray) -> tuple[float, float] | None:
    """A load of whose readings many are those of the lightest, and their share; None without.

    A recording of a weight that is put on and taken off again: its readings lie nearer to those of
    the lightest load than to the tenth of them that is farthest off. Levels that noise alone could
    bring so near are not judged.
    """
    levels = np.unique(load)
    light = count[load == levels[np.argmin(np.abs(levels))]]
    if light.size < _ROWS_OF_A_HOLD:
        return None
    rest, noise = float(np.median(light)), float(np.ptp(np.percentile(light, [5, 95])))
    away = {
        float(level): np.abs(count[load == level] - rest)
        for level in levels if np.sum(load == level) >= _ROWS_OF_A_HOLD
    }  # fmt: skip
    far = {level: float(np.percentile(off, 90)) for level, off in away.items()}
    for level, off in away.items():
        if far[level] < _OF_THE_RANGE * max(far.values()) or noise > _OF_THE_RANGE * far[level]:
            continue
        share = float(np.mean(off < 0.5 * far[level]))
        if share > _EMPTY:
            return level, share
    return None


def check_held(load_n: FloatArray, counts: FloatArray, channel: str) -> list[Finding]:
    """Find a load under which many readings are of the unloaded cell.

    Parameters
    ----------
    load_n, counts
        Shape (n,).
    """
    good = np.isfinite(load_n) & np.isfinite(counts)
    part = _held_in_part(load_n[good], counts[good]) if np.unique(load_n[good]).size > 1 else None
    if part is None:
        return []
    return [
        Finding(
            "held_in_part", "alarm", channel,
            f"{part[1]:.0%} of the readings under {part[0]:.4g} N are of the unloaded cell: the "
            "weight lay there for a part of its rows",
            "keep the rows in which it lay still, or record all weights one after another in one "
            "log and say loads = \"0, …\" in [offline_fit.plateaus]",
        )
    ]  # fmt: skip


def check_uneven(
    load_n: FloatArray,
    counts: FloatArray,
    channel: FloatArray,
    session: FloatArray,
    names: Sequence[str],
) -> list[Finding]:
    """Find one cell that scatters about its line far more than all others of the bench.

    Its mean square about the line of each session over that of the others: ``F(ν, ν')``. Of few
    rows no model of a curve, a loop or a creep is sure; that something is there is.

    Parameters
    ----------
    load_n, counts, channel, session
        Of each row; channels by their number in `names`.
    """
    from footcal_cli.core import chances  # scipy, which not every log asks for

    left, free = np.zeros(len(names)), np.zeros(len(names))
    for c in range(len(names)):
        for part in np.unique(session[channel == c]):
            at = (channel == c) & (session == part) & np.isfinite(load_n) & np.isfinite(counts)
            if np.unique(load_n[at]).size < _FEWEST_LOADS or not np.ptp(counts[at]) > 0.0:
                continue
            line = np.polynomial.Polynomial.fit(counts[at], load_n[at], 1)
            left[c] += float(np.sum((load_n[at] - line(counts[at])) ** 2))
            free[c] += at.sum() - 2
    used = np.flatnonzero(free > 0.0)
    if used.size < _FEWEST_CELLS:
        return []
    most = used[int(np.argmax(left[used] / free[used]))]
    rest = used[used != most]
    own = left[most] / free[most]
    others = float(left[rest].sum() / free[rest].sum())
    p = float(chances.f_sf(own / max(others, 1e-300), free[most], free[rest].sum())) * used.size
    if p >= _SURELY_UNEVEN or own < _UNEVEN**2 * others:
        return []
    return [
        Finding(
            UNEVEN, "warning", names[most],
            f"its readings lie {np.sqrt(own):.2g} N off its line (RMS), those of the other "
            f"{rest.size} cells {np.sqrt(others):.2g} N",
            "look at its curve, at loads going up and coming down, and at how long each one lay; "
            "more rows show which effect it is",
        )
    ]  # fmt: skip


def pieces_by_pauses(time_s: FloatArray) -> IntArray:
    """Number of the piece between long pauses in which each stamp (n,) lies.

    A cell that was left for hours is loaded anew: what its zero did meanwhile is no drift.
    """
    known = np.sort(time_s[np.isfinite(time_s)])
    steps = np.diff(known)
    if known.size < time_s.size or not np.any(steps > 0):
        return np.zeros(time_s.size, dtype=np.int64)
    long = steps > max(_PAUSE_S, _PAUSE_STEPS * float(np.median(steps[steps > 0])))
    return np.searchsorted(known[1:][long], time_s, side="right").astype(np.int64)
