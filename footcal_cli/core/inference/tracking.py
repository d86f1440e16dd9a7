"""A calibration that drifts: tracked by a Kalman filter that every column passes through.

The residual and every signature go through the same random-walk filter; what the filter could not
predict (the whitened innovation) is what evidence is made of. The speed of the walk is estimated
from the innovations of the residual, never assumed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.inference.kalman import correct_by_products, log_det_by_products
from footcal_cli.core.parameters import FloatArray, IntArray

PART_S = 2.0
"""Length over which the calibration is taken as constant."""
GAIN_SD, BIAS_SD_N = 0.2, 3.0
"""What is believed of a calibration before the walk: ten times a nameplate's promise (METHODS: gain
± 2 %, bias ± 0.3 N), so that evidence comes from the walk and not from that promise."""
WALK_VARIANCES = 10.0 ** np.arange(-8.0, 0.1, 0.5)
"""Variances of the random walk per second that are tried, in units of the prior variance."""
_SWEEPS = 2


@dataclass(frozen=True)
class Direction:
    """One way in which a calibration may differ: parameter changes per prior sd.

    Parameters
    ----------
    name, kind
        Those of one kind wander alike.
    changes
        By parameter.
    lasting
        Whether it differs from what was known, and stays so: the gain of a cell moves with its
        mounting, not within a walk.
    """

    name: str
    kind: str
    changes: Mapping[str, float]
    lasting: bool = False


@dataclass(frozen=True)
class Tracking:
    """How the calibration columns of a problem may wander; columns are in units of their prior sd.

    Parameters
    ----------
    time_s, recording
        Of each row, shape (m,).
    kind
        Which columns share a speed of the walk, shape (p,).
    """

    time_s: FloatArray
    recording: IntArray
    kind: IntArray


def gain_and_bias(
    channels: Sequence[str], values: Mapping[str, float], held_to: float | None = None
) -> tuple[Direction, ...]:
    """Relative gain and bias of each cell: ``F = (1 + γ) F⁰ + β``.

    Parameters
    ----------
    held_to
        Sd of γ, in which a cell then differs from a gain that all have in common, where weights
        have determined the gains: cells know nothing of a mass that is off. Free where None.
    """
    found: list[Direction] = []
    common: dict[str, float] = {}
    lasting = held_to is not None
    for channel in channels:
        scale, bias = values[f"{channel}.scale"], values[f"{channel}.bias"]
        gain = {f"{channel}.scale": scale, f"{channel}.bias": bias}
        common |= gain
        sd = GAIN_SD if held_to is None else held_to
        gain = {name: sd * value for name, value in gain.items()}
        found.append(Direction(f"{channel}.gain", "gain", gain, lasting))
        found.append(Direction(f"{channel}.bias", "bias", {f"{channel}.bias": BIAS_SD_N}))
    if lasting:
        common = {name: GAIN_SD * value for name, value in common.items()}
        found.append(Direction("common gain", "common gain", common))
    return tuple(found)


def starts_of(tracking: Tracking, block: IntArray) -> FloatArray:
    """First stamp of each block, shape (B,)."""
    start = np.full(int(block.max()) + 1, np.inf)
    np.minimum.at(start, block, tracking.time_s)
    return start


def parts_of(tracking: Tracking, block: IntArray) -> list[IntArray]:
    """Rows of each stretch of at most `PART_S` within a block, in the order of time."""
    part = np.floor((tracking.time_s - starts_of(tracking, block)[block]) / PART_S)
    order = np.lexsort((part, block))
    keys = np.stack([block[order], part[order]], axis=1)
    cuts = np.flatnonzero(np.any(np.diff(keys, axis=0) != 0, axis=1)) + 1
    parts = np.split(order, cuts)
    return sorted(
        parts, key=lambda rows: (tracking.recording[rows[0]], tracking.time_s[rows].min())
    )


@dataclass(frozen=True)
class _Part:
    """Inner products of the calibration columns and the residual over one stretch."""

    jj: FloatArray
    jr: FloatArray
    rr: float
    interval_s: float
    fresh: bool


def walk_variance(
    white: FloatArray, calibration: IntArray, parts: Sequence[IntArray], tracking: Tracking
) -> FloatArray:
    """Variance of the walk per second of each calibration column that makes the data likeliest.

    Parameters
    ----------
    white
        Whitened columns, the residual last, shape (m, n).
    calibration
        Column numbers.
    parts
        From `parts_of`.
    """
    last = white.shape[1] - 1
    small = []
    before: IntArray | None = None
    for rows in parts:
        j, r = white[np.ix_(rows, calibration)], white[rows, last]
        fresh = before is None or tracking.recording[before[0]] != tracking.recording[rows[0]]
        gap = 0.0 if fresh or before is None else _middle(tracking, rows) - _middle(
            tracking, before
        )  # fmt: skip
        small.append(_Part(j.T @ j, j.T @ r, float(r @ r), gap, fresh))
        before = rows
    kinds = np.unique(tracking.kind)
    best = np.full(kinds.size, 1e-4)

    def scores(variances: FloatArray) -> FloatArray:
        return _log_likelihood(small, variances[:, np.searchsorted(kinds, tracking.kind)])

    settled: set[tuple[int, bytes]] = set()
    for _ in range(_SWEEPS):
        for k in range(kinds.size):
            given = (k, np.delete(best, k).tobytes())
            if given in settled:  # the others have not moved since
                continue
            settled.add(given)
            tried = np.tile(best, (WALK_VARIANCES.size, 1))
            tried[:, k] = WALK_VARIANCES
            best = tried[int(np.argmax(scores(tried)))]
    return np.asarray(best[np.searchsorted(kinds, tracking.kind)])


def _middle(tracking: Tracking, rows: IntArray) -> float:
    return float(np.mean(tracking.time_s[rows]))


def _log_likelihood(parts: Sequence[_Part], variance: FloatArray) -> FloatArray:
    """Of the residual's innovations under several random walks, shape (t,).

    `variance` per second, shape (t, p). All walks in one pass: the parameters are few, so that
    calls cost more than arithmetic.
    """
    t, p = variance.shape
    start, unit = np.broadcast_to(np.eye(p), (t, p, p)), np.eye(p)
    mean, cov = np.zeros((t, p)), start
    total = np.zeros(t)
    for part in parts:
        if part.fresh:
            mean, cov = np.zeros((t, p)), start
        cov = cov + (variance * part.interval_s)[:, None, :] * unit
        j_d = part.jr - mean @ part.jj
        d_d = part.rr - np.einsum("ti,ti->t", mean, part.jr + j_d)
        log_det = log_det_by_products(cov, part.jj)
        cov = correct_by_products(cov, part.jj)
        moved = np.einsum("tij,tj->ti", cov, j_d)
        total -= 0.5 * (d_d - np.einsum("ti,ti->t", j_d, moved) + log_det)
        mean = mean + moved
    return total


def innovations(
    white: FloatArray,
    calibration: IntArray,
    parts: Sequence[IntArray],
    variance: FloatArray,
    tracking: Tracking,
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Pass all columns through the filter, stretch by stretch.

    Parameters
    ----------
    white
        Whitened columns, shape (m, n).
    calibration
        Column numbers of what is tracked.
    parts
        Rows of `white` of each stretch.
    variance
        Of the walk, per second, shape (p,).

    Yields
    ------
    predicted
        Coefficients of the calibration in every column before the stretch was seen, shape (p, n).
    gram
        ``X' S⁻¹ X`` of its innovations, shape (n, n).
    """
    p, n = calibration.size, white.shape[1]
    mean, cov = np.zeros((p, n)), np.eye(p)
    before: IntArray | None = None
    for rows in parts:
        fresh = before is None or tracking.recording[before[0]] != tracking.recording[rows[0]]
        if fresh or before is None:
            mean, cov = np.zeros((p, n)), np.eye(p)
        else:
            gap = _middle(tracking, rows) - _middle(tracking, before)
            cov = cov + np.diag(variance * gap)
        before = rows
        part = white[rows]
        j = part[:, calibration]
        left = part - j @ mean
        j_left = j.T @ left
        cov = correct_by_products(cov, j.T @ j)
        yield mean, left.T @ left - j_left.T @ cov @ j_left
        mean = mean + cov @ j_left
