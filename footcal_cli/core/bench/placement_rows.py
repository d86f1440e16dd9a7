"""Weights over known holes of one foot: the rows, their raw CoP, and what repeats say."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N, pressure
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

_MOST_FRAMES = 30
"""Rows to keep of each placement that was filmed."""
_FRAMES_OF_A_VISIT = 10
"""Nobody writes down so many readings of a weight that lies still."""


@dataclass(frozen=True)
class PlacementRows:
    """Placements of one foot with calibrated cell forces.

    Parameters
    ----------
    cells
        Channel names, front left to rear right as logged.
    forces_n
        Shape (n, c).
    cell_pos_m
        Believed positions in the foot frame, shape (c, 2).
    hole_m
        Where the weight acts, shape (n, 2).
    load_n
        Weight, shape (n,); NaN where only the place is known.
    placement
        Index of the hole, shape (n,): the unit of evidence.
    min_force_n
        Below this total force there is no CoP.
    given_cop_m
        CoP reported by an instrument whose cells were not logged, shape (n, 2); `cells` is empty.
    believed_scale
        Scales (N/count) that no weights measured, shape (c,): what the placements say of a cell's
        share of the load is then its gain. None of measured scales: its share is a crosstalk.
    """

    cells: tuple[str, ...]
    forces_n: FloatArray
    cell_pos_m: FloatArray
    hole_m: FloatArray
    load_n: FloatArray
    placement: IntArray
    min_force_n: float = MIN_FORCE_N
    given_cop_m: FloatArray | None = None
    believed_scale: FloatArray | None = None

    def __len__(self) -> int:
        return self.load_n.size

    @property
    def total_n(self) -> FloatArray:
        """``Σ F_i``, shape (n,); NaN where the cells were not logged."""
        if not self.cells:
            return np.full(len(self), np.nan)
        return np.asarray(self.forces_n.sum(axis=1))

    @property
    def valid(self) -> BoolArray:
        """Rows with a load and enough force for a CoP, shape (n,): drifted zeros are not a load."""
        loaded = self.load_n != 0.0
        if self.given_cop_m is not None:
            return np.asarray(loaded & np.isfinite(self.given_cop_m).all(axis=1))
        return np.asarray(loaded & (self.total_n > self.min_force_n))

    @property
    def raw_cop_m(self) -> FloatArray:
        """[NAO], eq. (8), shape (n, 2); NaN where there is none."""
        if self.given_cop_m is not None:
            return self.given_cop_m
        points = np.broadcast_to(self.cell_pos_m, (len(self), *self.cell_pos_m.shape))
        cop_m = pressure(self.forces_n, points, self.min_force_n).cop_m
        return np.where(self.valid[:, None], cop_m, np.nan)

    def select(self, rows: BoolArray) -> PlacementRows:
        """Some of the rows."""
        return replace(
            self,
            forces_n=self.forces_n[rows],
            hole_m=self.hole_m[rows],
            load_n=self.load_n[rows],
            placement=self.placement[rows],
            given_cop_m=None if self.given_cop_m is None else self.given_cop_m[rows],
        )


def holes_of(hole_m: FloatArray) -> IntArray:
    """Index of the hole of every row, shape (n,).

    Distinguished by position, so that a hole used again later is not taken for new evidence.

    Parameters
    ----------
    hole_m
        Shape (n, 2).
    """
    _, index = np.unique(np.round(hole_m, 6), axis=0, return_inverse=True)
    return np.asarray(index.reshape(-1), dtype=np.int64)


@dataclass(frozen=True)
class HoleScatter:
    """Mean and scatter of the CoP per hole and load: [NAO], section 4.2.

    Parameters
    ----------
    hole_m, load_n
        Shape (k, 2) and (k,).
    n
        Repeats with a CoP, shape (k,).
    mean_m, sd_m
        Shape (k, 2); the sd is NaN for a single reading.
    """

    hole_m: FloatArray
    load_n: FloatArray
    n: IntArray
    mean_m: FloatArray
    sd_m: FloatArray

    @property
    def error_m(self) -> FloatArray:
        """Mean minus hole, shape (k, 2)."""
        return self.mean_m - self.hole_m

    @property
    def pooled_sd_m(self) -> FloatArray:
        """Repeatability over all holes and loads per axis, shape (2,)."""
        many = self.n > 1
        dof = (self.n[many] - 1).astype(float)
        if not many.any():
            return np.full(2, np.nan)
        return np.asarray(np.sqrt(dof @ self.sd_m[many] ** 2 / dof.sum()))


def find_repeats(rows: PlacementRows, cop_m: FloatArray) -> HoleScatter:
    """Summarise repeated placements.

    Parameters
    ----------
    cop_m
        Their CoP, raw or corrected, shape (n, 2).
    """
    used = rows.valid & np.isfinite(cop_m).all(axis=1)
    load = np.where(np.isfinite(rows.load_n), rows.load_n, 0.0)[used]
    key = np.column_stack([rows.placement[used], np.round(load, 6)])
    _, index = np.unique(key, axis=0, return_inverse=True)
    index = index.reshape(-1)
    n = np.bincount(index)

    def mean_of(values: FloatArray) -> FloatArray:
        sums = [np.bincount(index, weights=column) for column in np.atleast_2d(values.T)]
        return np.asarray(np.column_stack(sums) / n[:, None])

    error = cop_m[used] - rows.hole_m[used]
    mean_error = mean_of(error)
    spread = mean_of((error - mean_error[index]) ** 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        sd = np.sqrt(spread * (n / np.where(n > 1, n - 1.0, np.nan))[:, None])
    hole = mean_of(rows.hole_m[used])
    return HoleScatter(hole, mean_of(load)[:, 0], n.astype(np.int64), hole + mean_error, sd)


def filmed_visits(readings: FloatArray, visit: IntArray) -> tuple[IntArray, FloatArray]:
    """First rows of visits to a hole and medians of their readings, where visits were filmed.

    Frames of one visit are no repeats. With few rows of each visit all rows stay as they are.

    Parameters
    ----------
    readings
        Shape (n, c).
    visit
        Number of the visit of each row, shape (n,), never decreasing.

    Returns
    -------
    Shapes (k,) and (k, c).
    """
    numbers, first = np.unique(visit, return_index=True)
    if len(readings) < _FRAMES_OF_A_VISIT * numbers.size:
        return np.arange(len(readings)), readings
    ends = np.append(first[1:], len(readings))
    each = [np.median(readings[a:b], axis=0) for a, b in zip(first, ends, strict=True)]
    return first, np.array(each)


def condense_points(rows: PlacementRows) -> PlacementRows:
    """Medians of consecutive rows, at most so many per placement: frames of a video are no repeats.

    Parameters
    ----------
    rows
        In order of time within each placement.
    """
    parts = [np.flatnonzero((rows.placement == p) & rows.valid) for p in np.unique(rows.placement)]
    pieces = [
        piece for part in parts for piece in np.array_split(part, min(_MOST_FRAMES, part.size))
    ]

    def medians(values: FloatArray) -> FloatArray:
        return np.array([np.median(values[piece], axis=0) for piece in pieces])

    first = np.array([piece[0] for piece in pieces])
    given = rows.given_cop_m
    return replace(
        rows,
        forces_n=medians(rows.forces_n) if rows.cells else np.zeros((len(pieces), 0)),
        hole_m=medians(rows.hole_m),
        load_n=rows.load_n[first],
        placement=rows.placement[first],
        given_cop_m=None if given is None else medians(given),
    )
