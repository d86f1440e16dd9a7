"""Noise as it is: autocorrelated within a sequence of rows, and whitened."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse
from scipy.linalg import solve_toeplitz

from footcal_cli.core.inference.linear import orthogonal, orthonormal
from footcal_cli.core.inference.settled import Settled, settled
from footcal_cli.core.inference.tracking import Tracking, Walk, stretches_of, walk_variance
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.signals import autocorrelation_time, begins, means_of, starts_of

if TYPE_CHECKING:
    from footcal_cli.core.inference.problem import Problem

AR_ORDER = 5
"""Autoregressive order of the noise model; AR(1) plus white noise needs more than one."""
_ROWS_PER_ORDER = 20
_COMPONENT_STEPS = 8
_FAR = 6.0  # sd, beyond which normal noise has no row
_MIDDLE = 0.6745  # median of |z|
_LEAST_FREEDOM = 1.0  # an output that the calibration can follow at will tells of no noise
_LEAST_RATIO = 1e-6  # by which a variance shrinks in one step at most
_RANK = 1e-8
_REWEIGHTED = 2
"""Times that the units of outputs are taken from what a fit in those before leaves."""
_LEAST = 1e-3  # of the largest of them
_MUCH, _LIKELY = 0.3, 32
"""Share of the squared error of an output that shapes its filter; so many candidates are asked."""
PIECE = 1024  # rows that are squared at once


@dataclass(frozen=True)
class RowWhitener:
    """An autoregressive filter per output, applied within each sequence.

    Parameters
    ----------
    coefficients
        ``e_t = (x_t − Σ a_i x_{t−i}) / s``, shape (outputs, order).
    sd
        Innovation sd s of each output, shape (outputs,).
    output, sequence
        Of the rows.
    kept
        Rows that have a full past in their sequence, from the others.
    """

    coefficients: FloatArray
    sd: FloatArray
    output: IntArray
    sequence: IntArray
    kept: IntArray = field(init=False)

    def __post_init__(self) -> None:
        used = self.coefficients != 0
        order = np.where(used.any(axis=1), used.shape[1] - np.argmax(used[:, ::-1], axis=1), 0)
        kept = np.flatnonzero(_age(self.sequence) >= order[self.output])
        object.__setattr__(self, "kept", kept)

    def __call__(self, columns: FloatArray) -> FloatArray:
        """Whitened columns at the kept rows, shape (kept, k)."""
        filtered = self._filter @ np.ascontiguousarray(columns)
        return np.asarray(filtered / self.sd[self.output[self.kept]][:, None])

    @cached_property
    def _filter(self) -> sparse.csr_array:
        """Each row's own filter, shape (kept, m)."""
        of = self.output[self.kept]
        taps = np.column_stack([np.ones(len(self.sd)), -self.coefficients])
        number, lag = np.nonzero(taps[of])
        entries = taps[of][number, lag], (number, self.kept[number] - lag)
        return sparse.csr_array(entries, shape=(self.kept.size, self.output.size))


@dataclass(frozen=True)
class Noise:
    """What the noise of a problem is like; losses are comparable in one and the same noise only.

    Parameters
    ----------
    walk
        How the calibration wanders where it is tracked.
    settled
        What differs between settings, where there are any.
    """

    whitener: RowWhitener
    walk: Walk | None = None
    settled: Settled | None = None

    @property
    def level(self) -> float:
        """Sum of the log innovation sd over all rows: what a likelihood charges for noise."""
        kept = self.whitener.kept
        rows = float(np.sum(np.log(self.whitener.sd[self.whitener.output[kept]])))
        return rows + (self.settled.log_sd if self.settled else 0.0)


def law_of_noise(problem: Problem, within: Within | None = None) -> Noise:
    """Estimate the noise from the residual; `Problem.law` keeps it.

    Of series beside the candidate that explains most of the residual, where that is much of one
    output: a filter fitted to a cause makes that cause small in every test that follows.

    Parameters
    ----------
    within
        Of the problem, where it was made before: it does not depend on the residual.
    """
    if problem.rate_hz > 0 and problem.signatures:
        within = within or problem.within
        problem = replace(problem, residual=_beside_the_largest(problem, within))
    whitener = fit_row_whitener(problem, within)
    if problem.tracking is None:
        return Noise(whitener, settled=settled(problem, whitener, whitener.kept))
    white = whitener(np.column_stack([problem.calibration, problem.residual]))
    calibration = np.arange(problem.calibration.shape[1])
    there = kept_tracking(problem.tracking, whitener.kept)
    stretches = stretches_of(there, problem.block[whitener.kept])
    variance = walk_variance(white, calibration, stretches, there.kind)
    return Noise(whitener, Walk(variance, stretches))


def kept_tracking(tracking: Tracking, kept: IntArray) -> Tracking:
    """Times and recordings of the rows that have a whitened value."""
    return Tracking(tracking.time_s[kept], tracking.recording[kept], tracking.kind)


def longest_memory(problem: Problem) -> float:
    """Integrated autocorrelation time of the residual of the output that remembers longest, rows.

    Of what a calibration of each block's own leaves; 1 where rows are no series.
    """
    if _has_few_rows(problem):
        return 1.0
    inside = residual_within_blocks(problem)
    outputs = [np.flatnonzero(problem.output == o) for o in range(len(problem.outputs))]
    times = [autocorrelation_time(inside[o], problem.sequence[o]) for o in outputs if o.size]
    return max(times, default=1.0)


def _beside_the_largest(problem: Problem, within: Within) -> FloatArray:
    """The residual without the one candidate that explains most of it, shape (m,).

    ``s_k = (x_k · r)² / |x_k|²``, in units of what the calibration leaves of each output on
    average. The residual itself where no candidate of a possible size takes `_MUCH` of the squared
    error of an output.
    """
    r = within(problem.residual)
    outputs = len(problem.outputs)
    square = means_of(r**2, problem.output, outputs)
    rms = np.sqrt(square)
    unit = np.maximum(rms, _LEAST * rms.max(initial=0.0) + 1e-300)[problem.output, None]
    # r is what the calibration leaves, so that only few candidates need be freed of it
    along = np.abs(problem.columns.T @ (r / unit[:, 0] ** 2))
    size = np.linalg.norm(problem.columns / unit, axis=0)
    likely = np.argsort(-along / np.maximum(size, 1e-300))[:_LIKELY]
    left = within(problem.columns[:, likely])
    own = np.sum((left / unit) ** 2, axis=0)
    found = (left / unit).T @ (r / unit[:, 0])
    taken = found / np.maximum(own, 1e-300)
    possible = np.array([
        problem.signatures[k].lower <= b <= problem.signatures[k].upper
        for k, b in zip(likely, taken, strict=True)
    ], dtype=bool) & (own > _LEAST * size[likely] ** 2)  # fmt: skip
    if not possible.any():
        return problem.residual
    best = int(np.argmax(np.where(possible, found * taken, 0.0)))
    rest = means_of((r - taken[best] * left[:, best]) ** 2, problem.output, outputs)
    # of recordings without noise nothing is left, and that is no noise either
    if not np.any(rest < (1.0 - _MUCH) * square) or np.any(rest < _LEAST**2 * square):
        return problem.residual
    return np.asarray(problem.residual - taken[best] * problem.columns[:, likely[best]])


def fit_row_whitener(problem: Problem, within: Within | None = None) -> RowWhitener:
    """Fit the filter of each output to the residual that no calibration of any block explains.

    `within` as in `law_of_noise`.
    """
    outputs = len(problem.outputs)
    if _has_few_rows(problem):
        return _whitener_of_single_rows(problem, outputs)
    inside = (within or problem.within)(problem.residual)
    age = _age(problem.sequence)
    lengths = _lengths(problem.sequence)
    coefficients = np.zeros((outputs, AR_ORDER))
    sd = np.ones(outputs)
    for o in range(outputs):
        rows = np.flatnonzero(problem.output == o)
        if not rows.size:
            continue
        typical = float(np.median(lengths[rows]))
        order = int(min(AR_ORDER, typical // _ROWS_PER_ORDER)) if problem.rate_hz > 0 else 0
        covariance = _autocovariance(inside, rows, age, order)
        if order and covariance[0] > 0:
            covariance[0] *= 1.0 + 1e-6
            coefficients[o, :order] = solve_toeplitz(covariance[:-1], covariance[1:])
        innovation = covariance[0] - coefficients[o, :order] @ covariance[1:]
        sd[o] = np.sqrt(max(innovation, 1e-12 * max(covariance[0], 1e-300)))
        if problem.least is not None:
            # a reading that never leaves its level is no better known than to the next one
            sd[o] = max(sd[o], problem.least[o])
    return RowWhitener(coefficients, sd, problem.output, problem.sequence)


def has_single_rows(problem: Problem) -> bool:
    """Whether rows are no time series and no block has enough of them for a calibration of its own.

    Such are stances; where they are repeated in settings, these tell what repeats.
    """
    return problem.settings is None and _has_few_rows(problem)


def _has_few_rows(problem: Problem) -> bool:
    """Whether most blocks have too few rows for a calibration of their own, and are no series."""
    if problem.rate_hz > 0:
        return False
    usual = float(np.median(np.bincount(problem.block))) if problem.block.size else 0.0
    return bool(usual <= 2 * (problem.calibration.shape[1] + len(problem.outputs)))


def _whitener_of_single_rows(problem: Problem, outputs: int) -> RowWhitener:
    """Scatter of each output about one calibration of all blocks.

    Without the calibration the residual is an error of the calibration, not noise, and outputs
    would weigh by how far off it was. ``σ_o² = Σ_o r² / (n_o − Σ_o h)``, r what weighted least
    squares leave, h the leverage of each row, iterated: Helmert's estimate of variance components
    in the simplified form of Förstner, Z. Vermessungswesen 104 (1979).
    """
    sd, share = np.ones(outputs), np.ones(problem.residual.size)
    own = _means_of_sequences(problem) if problem.pieces else problem.fitted[:, :0]
    for _ in range(_COMPONENT_STEPS):
        weight = share / sd[problem.output]
        fitted = np.hstack([problem.fitted, own]) * weight[:, None]
        basis = orthonormal(fitted, _RANK)
        left = problem.residual * weight
        left = left - basis @ (basis.T @ left)
        # a row with another label is no noise: rows beyond `_FAR` count as far as that
        usual = _middle_size(left / share, problem.output, outputs)
        share = np.minimum(1.0, _FAR * usual / np.maximum(np.abs(left / share), 1e-300))
        squares = np.bincount(problem.output, left**2, minlength=outputs)
        freedom = np.bincount(problem.output, 1.0 - np.sum(basis**2, axis=1), minlength=outputs)
        known = freedom > _LEAST_FREEDOM
        ratio = np.divide(squares, freedom, out=np.ones(outputs), where=known)
        sd = sd * np.sqrt(np.maximum(ratio, _LEAST_RATIO))
        if problem.least is not None:
            sd = np.maximum(sd, problem.least)
    return RowWhitener(np.zeros((outputs, AR_ORDER)), sd, problem.output, problem.sequence)


def _middle_size(values: FloatArray, output: IntArray, outputs: int) -> FloatArray:
    """Sd of the output of each row as the middle of its rows has it, shape (m,)."""
    sd = np.full(outputs, np.inf)
    for o in np.unique(output):
        middle = float(np.median(np.abs(values[output == o]))) / _MIDDLE
        sd[o] = middle if middle > 0.0 else np.inf
    return np.asarray(sd[output])


def _means_of_sequences(problem: Problem) -> FloatArray:
    """One column per sequence of several rows, shape (m, k)."""
    numbers, place, count = np.unique(problem.sequence, return_inverse=True, return_counts=True)
    return np.eye(numbers.size)[place][:, count > 1]


@dataclass(frozen=True)
class Within:
    """What is fitted to a residual before its noise is looked at.

    Parameters
    ----------
    lasting
        Orthonormal basis of what all blocks share, shape (m, k); None where nothing is.
    own
        Rows of each block that can show a calibration of its own, and a basis of that.
    unit
        In which rows are fitted, shape (m,).
    """

    lasting: FloatArray | None
    own: tuple[tuple[IntArray, FloatArray], ...]
    unit: FloatArray

    def __call__(self, residual: FloatArray) -> FloatArray:
        """What is left of a residual, or of columns, shape (m,) or (m, k)."""
        unit = self.unit.reshape(-1, *(1,) * (residual.ndim - 1))
        left = residual / unit
        if self.lasting is not None:
            left -= self.lasting @ (self.lasting.T @ left)
        for rows, basis in self.own:
            mine = left[rows]
            left[rows] = mine - basis @ (basis.T @ mine)
        return np.asarray(left * unit)


def within_blocks(problem: Problem) -> Within:
    """A calibration and output offsets of each block's own, beside what all blocks share.

    What all blocks share is fitted in units of what the fit before left of each output: in those
    that were assumed, the inertia of a foot of which a transducer in the air knows all would be
    that which makes the moments of the whole robot small.
    """
    unit = np.ones(problem.residual.size)
    if problem.usual is None or problem.rate_hz <= 0:
        return _within(problem, unit)
    for _ in range(_REWEIGHTED):
        left = _within(problem, unit)(problem.residual)
        outputs = len(problem.outputs)
        rms = np.sqrt(means_of(left**2, problem.output, outputs))
        unit = np.maximum(rms, _LEAST * rms.max(initial=0.0) + 1e-300)[problem.output]
    return _within(problem, unit)


def _within(problem: Problem, unit: FloatArray) -> Within:
    scale = 1.0 / unit[:, None]
    lasting = [part for part in (problem.held, problem.usual) if part is not None]
    shared = None
    if lasting:
        shared = orthogonal(np.hstack([problem.calibration, *lasting]) * scale, _RANK)
    basis = np.hstack([problem.calibration, np.eye(len(problem.outputs))[problem.output]]) * scale
    own = []
    for b in range(problem.blocks):
        rows = np.flatnonzero(problem.block == b)
        mine = basis[rows]
        if rows.size > 2 * int(np.count_nonzero(np.any(mine != 0.0, axis=0))):
            own.append((rows, orthogonal(mine, _RANK)))
    return Within(shared, tuple(own), unit)


def residual_within_blocks(problem: Problem, residual: FloatArray | None = None) -> FloatArray:
    """Residual after a calibration and output offsets of each block's own, shape (m,)."""
    return problem.within(problem.residual if residual is None else residual)


def _age(sequence: IntArray) -> IntArray:
    """Rows since the start of the sequence, shape (m,)."""
    index = np.arange(sequence.size)
    fresh = begins(sequence)
    return np.asarray(index - np.maximum.accumulate(np.where(fresh, index, 0)))


def _lengths(sequence: IntArray) -> IntArray:
    """Length of the sequence that each row belongs to, shape (m,)."""
    starts = starts_of(sequence)
    sizes = np.diff(np.append(starts, sequence.size))
    return np.asarray(np.repeat(sizes, sizes))


def _autocovariance(values: FloatArray, rows: IntArray, age: IntArray, lags: int) -> FloatArray:
    """Autocovariance at lags 0 … `lags` within sequences, shape (lags + 1,)."""
    covariance = np.empty(lags + 1)
    for lag in range(lags + 1):
        late = rows[age[rows] >= lag]
        # the biased estimate keeps the Toeplitz matrix positive definite
        covariance[lag] = values[late] @ values[late - lag] / max(rows.size, 1)
    return covariance
