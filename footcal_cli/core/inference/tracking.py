"""A calibration that drifts: tracked by a Kalman filter that every column passes through.

The residual and every signature go through the same random-walk filter; what the filter could not
predict (the whitened innovation) is what evidence is made of. The speed of the walk is estimated
from the innovations of the residual, never assumed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.inference.kalman import correct_by_products, standardised
from footcal_cli.core.parameters import FloatArray, IntArray

PART_S = 2.0
"""Length over which the calibration is taken as constant."""
GAIN_SD, BIAS_SD_N = 0.2, 3.0
"""What is believed of a calibration before the walk: ten times a nameplate's promise (METHODS: gain
± 2 %, bias ± 0.3 N), so that evidence comes from the walk and not from that promise."""
WALK_VARIANCES = 10.0 ** np.arange(-8.0, 0.1, 0.5)
"""Variances of the random walk per second that are tried, in units of the prior variance."""
COMMON_GAIN = "common gain"
"""Direction, and kind of direction, in which all cells differ alike."""
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

    @property
    def channel(self) -> str:
        """Whose gain or bias it is."""
        return self.name.rpartition(".")[0]


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
        found.append(Direction(COMMON_GAIN, COMMON_GAIN, common))
    return tuple(found)


def block_starts(tracking: Tracking, block: IntArray) -> FloatArray:
    """First stamp of each block, shape (B,)."""
    start = np.full(int(block.max()) + 1, np.inf)
    np.minimum.at(start, block, tracking.time_s)
    return start


@dataclass(frozen=True)
class Stretch:
    """Rows over which the calibration is taken as constant.

    Parameters
    ----------
    rows
        Their numbers.
    gap_s
        From the middle of the stretch before; None for the first one of a recording.
    """

    rows: IntArray
    gap_s: float | None


@dataclass(frozen=True)
class Walk:
    """How a tracked calibration wanders.

    Parameters
    ----------
    variance
        Per second, of each calibration column, shape (p,).
    stretches
        Of the whitened rows.
    """

    variance: FloatArray
    stretches: tuple[Stretch, ...]


def stretches_of(tracking: Tracking, block: IntArray) -> tuple[Stretch, ...]:
    """Stretches of rows that `tracking` and `block` belong to, in the order of time."""
    found: list[Stretch] = []
    before, middle = -1, 0.0
    for rows in tracked_parts(tracking, block):
        recording, now = int(tracking.recording[rows[0]]), float(tracking.time_s[rows].mean())
        found.append(Stretch(rows, now - middle if found and recording == before else None))
        before, middle = recording, now
    return tuple(found)


def tracked_parts(tracking: Tracking, block: IntArray) -> list[IntArray]:
    """Rows of each stretch of at most `PART_S` within a block, in the order of time."""
    part = np.floor((tracking.time_s - block_starts(tracking, block)[block]) / PART_S)
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
    gap_s: float | None


def walk_variance(
    white: FloatArray, calibration: IntArray, stretches: Sequence[Stretch], kind: IntArray
) -> FloatArray:
    """Variance of the walk per second of each calibration column that makes the data likeliest.

    Parameters
    ----------
    white
        Whitened columns, the residual last, shape (m, n).
    calibration
        Column numbers.
    stretches
        From `stretches_of`.
    kind
        As in `Tracking`.
    """
    used = np.ascontiguousarray(white[:, np.append(calibration, white.shape[1] - 1)])
    small = []
    for stretch in stretches:
        part = used[stretch.rows]
        gram = part.T @ part
        small.append(_Part(gram[:-1, :-1], gram[:-1, -1], float(gram[-1, -1]), stretch.gap_s))
    kinds = np.unique(kind)
    best = np.full(kinds.size, 1e-4)

    def scores(variances: FloatArray) -> FloatArray:
        return _log_likelihood(small, variances[:, np.searchsorted(kinds, kind)])

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
    return np.asarray(best[np.searchsorted(kinds, kind)])


def _log_likelihood(parts: Sequence[_Part], variance: FloatArray) -> FloatArray:
    """Of the residual's innovations under several random walks, shape (t,).

    `variance` per second, shape (t, p). All walks in one pass: the parameters are few, so that
    calls cost more than arithmetic.
    """
    t, p = variance.shape
    start, at = np.broadcast_to(np.eye(p), (t, p, p)), np.arange(p)
    mean, cov = np.zeros((t, p)), start.copy()
    whole = np.empty((len(parts), t, p, p))
    means, surprises, moves = np.empty((3, len(parts), t, p))
    for k, part in enumerate(parts):
        if part.gap_s is None:
            mean, cov = np.zeros((t, p)), start.copy()
        else:
            cov[:, at, at] += variance * part.gap_s
        means[k] = mean
        surprise = np.subtract(part.jr, mean @ part.jj, out=surprises[k])
        cov = correct_by_products(cov, part.jj, whole[k])
        moved = np.matmul(cov, surprise[..., None], out=moves[k][..., None])[..., 0]
        mean = mean + moved
    jr = np.array([part.jr for part in parts])[:, None]
    squares = sum(part.rr for part in parts) - np.einsum("kti,kti->t", means, jr + surprises)
    explained = np.einsum("kti,kti->t", surprises, moves)
    return np.asarray(-0.5 * (squares - explained + np.linalg.slogdet(whole)[1].sum(axis=0)))


@dataclass(frozen=True)
class Tracked:
    """A stretch of rows against what was predicted of it.

    Parameters
    ----------
    left
        Innovations of all columns, shape (k, n).
    calibration, seen
        Columns J of the calibration, shape (k, p), and ``Jᵀ left``.
    before, after
        Covariance of the calibration before and after the stretch, shape (p, p).
    """

    left: FloatArray
    calibration: FloatArray
    seen: FloatArray
    before: FloatArray
    after: FloatArray

    def products(self) -> FloatArray:
        """Of the whitened innovations, ``leftᵀ (1 + J P Jᵀ)⁻¹ left``, shape (n, n)."""
        return np.asarray(self.left.T @ self.left - self.seen.T @ self.after @ self.seen)

    def whitened(self) -> FloatArray:
        """The innovations, independent with variance 1, shape (k, n)."""
        return standardised(self.left, self.calibration, self.before)


def innovations(
    white: FloatArray, calibration: IntArray, walk: Walk
) -> Iterator[tuple[FloatArray, Tracked]]:
    """Pass all columns through the filter, stretch by stretch.

    Parameters
    ----------
    white
        Whitened columns, shape (m, n).
    calibration
        Column numbers of what is tracked.
    walk
        Its variance, and the stretches of `white`.

    Yields
    ------
    predicted
        Coefficients of the calibration in every column before the stretch was seen, shape (p, n).
    tracked
        What of the stretch was not predicted.
    """
    p, n = calibration.size, white.shape[1]
    mean, cov = np.zeros((p, n)), np.eye(p)
    for stretch in walk.stretches:
        if stretch.gap_s is None:
            mean, cov = np.zeros((p, n)), np.eye(p)
        else:
            cov[np.diag_indices(p)] += walk.variance * stretch.gap_s
        part = white[stretch.rows]
        j = part[:, calibration]
        left = part - j @ mean
        seen = j.T @ left
        after = correct_by_products(cov, j.T @ j)
        yield mean, Tracked(left, j, seen, cov, after)
        cov = after
        mean = mean + cov @ seen
