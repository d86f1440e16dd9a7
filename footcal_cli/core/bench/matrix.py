"""Sensors whose channels are loaded together: a full matrix from readings to loads.

``y = M S + b + ε``: crosstalk among the cells of a foot (y: load on each cell), or a sensor of c
bridges against a known wrench (y: six axes). Linear in M and b; rows of one session or placement
share an offset.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.inference.blocks import BlockFit, fit_blocks
from footcal_cli.core.inference.held_out import HeldOut, choose, hold_out
from footcal_cli.core.parameters import BoolArray, Estimates, FloatArray, IntArray, Status
from footcal_cli.core.readings import STUCK
from footcal_cli.errors import FitError

_OF_ONE_LINE = 2  # coefficients


@dataclass(frozen=True)
class MatrixFit:
    """A matrix with everything's uncertainty.

    Parameters
    ----------
    matrix, bias
        M (k, c) and b (k,).
    estimates
        ``<output>.scale`` (its own reading, where outputs and channels have the same names),
        ``<output>.scale_from_<channel>`` and ``<output>.bias``, row by row, joint covariance.
    ci95
        Shape (p, 2).
    sd_within, sd_between
        Scatter of rows and of the offsets of blocks per output, shape (k,).
    noise
        Correlation of the outputs' errors, shape (k, k).
    rank, condition
        Of the centred readings with columns scaled to unit sd: loads in too few directions show.
    reading_low, reading_high
        Range of the fitted readings, shape (c,).
    diagonal
        Whether off-diagonal elements were left at zero.
    """

    matrix: FloatArray
    bias: FloatArray
    estimates: Estimates
    ci95: FloatArray
    sd_within: FloatArray
    sd_between: FloatArray
    noise: FloatArray
    rank: int
    condition: float
    reading_low: FloatArray
    reading_high: FloatArray
    diagonal: bool

    def predict(self, readings: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Loads (n, k), their sd (n, k), and whether any reading is beyond the fit, (n,)."""
        values = readings @ self.matrix.T + self.bias
        outputs, channels = self.matrix.shape
        design = np.column_stack([readings, np.ones(len(readings))])
        sd = np.empty_like(values)
        for i in range(outputs):
            at = slice(i * (channels + 1), (i + 1) * (channels + 1))
            block = self.estimates.covariance[at, at]
            calibration = np.einsum("ij,jk,ik->i", design, block, design)
            own = self.sd_within[i] ** 2 + self.sd_between[i] ** 2
            sd[:, i] = np.sqrt(np.clip(calibration, 0.0, None) + own)
        slack = 0.01 * (self.reading_high - self.reading_low)
        low, high = self.reading_low - slack, self.reading_high + slack
        return values, sd, np.any((readings < low) | (readings > high), axis=1)


@dataclass(frozen=True)
class MatrixStudy:
    """Diagonal against full matrix on left-out groups.

    Parameters
    ----------
    diagonal, full
        The two fits; `diagonal` is None where outputs and channels are different things, and `full`
        is the diagonal one where the loads keep one proportion.
    chosen
        The one the evidence supports, by the one-standard-error rule over groups.
    held_out_rmse
        Per candidate and output, shape (m, k), in the outputs' units.
    rows
        Rows behind it.
    """

    diagonal: MatrixFit | None
    full: MatrixFit
    chosen: MatrixFit
    held_out_rmse: FloatArray
    rows: int


def fit_matrix(
    channels: Sequence[str],
    readings: FloatArray,
    outputs: Sequence[str],
    loads: FloatArray,
    block: IntArray,
    *,
    units: Sequence[str] | None = None,
    diagonal: bool = False,
) -> MatrixFit:
    """Regress all loads on all readings.

    Parameters
    ----------
    channels, readings
        Names and raw readings, shape (n, c).
    outputs, loads
        Names and known loads, shape (n, k).
    block
        Session of each row, shape (n,).
    units
        Of the outputs; N where absent.
    diagonal
        Each output depends on the reading of its own place alone; needs k = c.

    Raises
    ------
    FitError
        Fewer rows than coefficients, or loads that leave a combination of readings unmoved.
    """
    count, wide = len(outputs), len(channels)
    units = tuple(units) if units is not None else ("N",) * count
    centre = readings.mean(axis=0)
    width = readings.std(axis=0)
    if np.any(width == 0):
        stuck = channels[int(np.argmin(width))]
        raise FitError("the reading never changes", column=stuck, remedy=STUCK)
    scaled = (readings - centre) / width
    rank, condition = _checked_rank(scaled, loads, diagonal=diagonal)
    fits, residuals = [], np.empty_like(loads)
    for i in range(count):
        columns = scaled[:, [i]] if diagonal else scaled
        design = np.column_stack([columns, np.ones(len(columns))])
        fits.append(fit_blocks(design, loads[:, i], block))
        residuals[:, i] = loads[:, i] - design @ fits[-1].coefficients
    noise = _correlation(residuals)
    values, covariance, quantile = _joint(fits, centre, width, noise, diagonal=diagonal)
    size = wide + 1
    estimates = Estimates(
        tuple(name for output in outputs for name in _names(output, channels)),
        tuple(unit for u in units for unit in (*(f"{u}/count",) * wide, u)),
        values,
        covariance,
        tuple(
            Status.ESTIMATED if not diagonal or j in (i, wide) else Status.FIXED
            for i in range(count)
            for j in range(size)
        ),
    )
    half_width = quantile * estimates.sd
    table = values.reshape(count, size)
    return MatrixFit(
        matrix=table[:, :wide],
        bias=table[:, wide],
        estimates=estimates,
        ci95=np.column_stack([values - half_width, values + half_width]),
        sd_within=np.array([fit.sd_within for fit in fits]),
        sd_between=np.array([fit.sd_between for fit in fits]),
        noise=noise,
        rank=rank,
        condition=condition,
        reading_low=readings.min(axis=0),
        reading_high=readings.max(axis=0),
        diagonal=diagonal,
    )


def _checked_rank(scaled: FloatArray, loads: FloatArray, *, diagonal: bool) -> tuple[int, float]:
    """Combinations of readings (n, c) that the loads (n, k) move, and the readings' condition.

    Raises
    ------
    FitError
        As `fit_matrix`.
    """
    rows, wide = scaled.shape
    singular = np.linalg.svd(scaled, compute_uv=False)
    rank = int(np.sum(singular > 1e-9 * singular[0]))
    if loads.shape[1] >= wide:  # no other load moves the readings: beyond these they show noise
        rank = min(rank, directions(loads))
    if not diagonal and (rank < wide or rows <= wide + 1):
        raise FitError(
            f"the loads move only {rank} of {wide} combinations of readings",
            remedy="load the channels one by one, or in as many combinations as there are channels",
        )
    if rows <= _OF_ONE_LINE:
        raise FitError(
            f"{rows} rows leave none over for the uncertainty of a line",
            remedy="read at least three loads per cell",
        )
    return rank, float(singular[0] / singular[-1]) if singular[-1] > 0 else np.inf


def _correlation(residuals: FloatArray) -> FloatArray:
    """Correlation of columns (n, k), shape (k, k); none with a column that does not vary."""
    away = residuals - residuals.mean(axis=0)
    size = np.sqrt(np.sum(away**2, axis=0))
    unit = away / np.where(size > 0.0, size, np.inf)
    found = unit.T @ unit
    np.fill_diagonal(found, 1.0)
    return np.asarray(found)


def directions(loads: FloatArray) -> int:
    """How many combinations of loads (n, k) change: 1 where they keep one proportion."""
    singular = np.linalg.svd(loads - loads.mean(axis=0), compute_uv=False)
    return int(np.sum(singular > 1e-6 * singular[0])) if singular[0] > 0 else 0


def _joint(
    fits: Sequence[BlockFit],
    centre: FloatArray,
    width: FloatArray,
    noise: FloatArray,
    *,
    diagonal: bool,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Values, joint covariance and t quantiles in terms of raw readings, row by row of M and b.

    ``M = A / width, b = a₀ − M centre``. Outputs share the design and their noise is correlated:
    the blocks of the covariance are ``L_i ρ_ij L_jᵀ``, which keeps it positive.
    """
    count, wide = len(fits), centre.size
    size = wide + 1
    back = np.eye(size)
    back[:wide, :wide] = np.diag(1.0 / width)
    back[wide, :wide] = -centre / width
    values, quantiles = np.zeros((count, size)), np.zeros((count, size))
    roots = np.zeros((count, size, size))
    for i, fit in enumerate(fits):
        at = [i, wide] if diagonal else list(range(size))
        coefficients, own = np.zeros(size), np.zeros((size, size))
        coefficients[at] = fit.coefficients
        own[np.ix_(at, at)] = fit.covariance
        values[i] = back @ coefficients
        low, vectors = np.linalg.eigh(own)
        roots[i] = back @ (vectors * np.sqrt(np.clip(low, 0.0, None)))
        quantiles[i, at] = fit.half_width() / np.maximum(fit.sd, 1e-300)
    blocks = np.einsum("ij,iab,jcb->iajc", noise, roots, roots)
    total = count * size
    return values.ravel(), blocks.reshape(total, total), quantiles.ravel()


def study_matrix(
    channels: Sequence[str],
    readings: FloatArray,
    outputs: Sequence[str],
    loads: FloatArray,
    block: IntArray,
    group: IntArray,
    units: Sequence[str] | None = None,
) -> MatrixStudy:
    """Fit a full matrix and, where outputs are the channels, judge it against a diagonal one.

    Parameters
    ----------
    channels, readings, outputs, loads, block, units
        As `fit_matrix`.
    group
        Units of evidence, shape (n,): load cases or sessions, never rows.

    Raises
    ------
    FitError
        As `fit_matrix`; a load that never changes.
    """
    same = tuple(channels) == tuple(outputs)
    alone = same and directions(loads) < len(channels)  # crosstalk cannot be seen
    width = loads.std(axis=0)
    if np.any(width == 0):
        raise FitError(
            f"the known load of {outputs[int(np.argmin(width))]} never changes",
            remedy="load it too, or leave it out",
        )
    candidates, errors = [], []
    for diagonal in (True,) if alone else (True, False) if same else (False,):

        def predict(out: BoolArray, diagonal: bool = diagonal) -> FloatArray:
            part = fit_matrix(
                channels, readings[~out], outputs, loads[~out], block[~out], diagonal=diagonal
            )
            return part.predict(readings)[0]

        candidates.append(
            fit_matrix(channels, readings, outputs, loads, block, units=units, diagonal=diagonal)
        )
        errors.append(hold_out(predict, loads, group, most=30).error)
    scaled = [HeldOut(error / width, group) for error in errors]
    rmse = np.array([np.sqrt(np.mean(error**2, axis=0)) for error in errors])
    chosen = candidates[choose(scaled).chosen]
    diagonal_fit = candidates[0] if same else None
    return MatrixStudy(diagonal_fit, candidates[-1], chosen, rmse, len(readings))


def _names(output: str, channels: Sequence[str]) -> list[str]:
    own = [
        f"{output}.scale" if channel == output else f"{output}.scale_from_{channel}"
        for channel in channels
    ]
    return [*own, f"{output}.bias"]


def mixing_of(values: Mapping[str, float], channels: Sequence[str]) -> FloatArray | None:
    """The matrix of ``F = M S + b`` as named in `MatrixFit.estimates`, shape (c, c).

    None where no name speaks of one channel's share in another's load.
    """
    names = [_names(output, channels)[:-1] for output in channels]
    if not any(name in values for row in names for name in row if ".scale_from_" in name):
        return None
    return np.array([[values.get(name, 0.0) for name in row] for row in names])


def bias_of(values: Mapping[str, float], channels: Sequence[str]) -> FloatArray:
    """Biases of the channels, shape (c,)."""
    return np.array([values.get(f"{channel}.bias", 0.0) for channel in channels])
