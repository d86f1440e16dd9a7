"""Corrections of the CoP: the paper's polynomial with forces, and the physics it stands for.

Empirical ([NAO], eqs. (3)–(5)): ``Δ = Σ a_k φ_k(x, y) + Σ b_i F_i`` per axis, linear in a and b.
Physical: a cell stands δ_i from where it is believed, and passes the share s_i of its reading to
the total (crosstalk, gain): ``load = Σ s_i F_i + f``, ``load · hole = Σ q_i F_i + m``, linear too;
the cell's effective position is ``q_i / s_i``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footcal_cli.core.bench.cop_kinds import NONE, TERMS, CopModel
from footcal_cli.core.bench.placement_rows import PlacementRows
from footcal_cli.core.inference.linear import about_usual, rank_of
from footcal_cli.core.parameters import FloatArray
from footcal_cli.errors import FitError

_WEIGHINGS = 3
USUAL_SHARE = 0.05
"""Sd of what a cell passes on beyond its reading, and of its place as a share of the foot's size:
the cells of a rigid sole move together, and what differs from that is noise alone."""
_MOST_SHARE = 0.25
"""A cell that passes on a quarter more or less than it reads, or that sits a quarter of the foot's
size elsewhere, is no calibrated cell where the drawing has it: the model found something else."""


@dataclass(frozen=True)
class CopFit:
    """A fitted correction.

    Parameters
    ----------
    weights
        Empirical: coefficients of the standardised features, shape (k, 2). Physical: shape
        (c + 1, 3), what each cell (last row: the offset) adds to load, load·x, load·y.
    origin_m
        The middle of the cells, from where the polynomial counts x and y, shape (2,).
    centre, width
        Standardisation of the empirical features, shape (k,); one width for all of a degree.
    ridge
        Penalty on the standardised coefficients other than the constant's.
    rank, condition
        Of the standardised design (physical: of the forces).
    loose
        Physical: covariance of the weights that their usual sizes leave, of load, load·x and
        load·y, shape (3, c + 1, c + 1).
    """

    model: CopModel
    weights: FloatArray
    origin_m: FloatArray
    centre: FloatArray
    width: FloatArray
    ridge: float
    rank: int
    condition: float
    loose: FloatArray = field(default_factory=lambda: np.zeros((3, 0, 0)))

    def is_of_the_foot(self, cell_pos_m: FloatArray) -> bool:
        """Whether shares and places are those of cells, not of what else moves their readings."""
        if not self.model.physical:
            return True
        off = self.weights[:-1] - np.column_stack([np.ones(len(cell_pos_m)), cell_pos_m])
        off = np.abs(off - off[:, :1] * np.array([0.0, *self.origin_m]))
        return bool(np.all(off < _MOST_SHARE * np.array([1.0, *[_extent_m(cell_pos_m)] * 2])))

    def moved_within_usual(self) -> list[CopFit]:
        """The fit with its weights moved by one sd along each direction of `loose`."""
        moved = []
        for column, covariance in enumerate(self.loose):
            size, direction = np.linalg.eigh(covariance)
            for sd, along in zip(np.sqrt(np.maximum(size, 0.0)), direction.T, strict=True):
                weights = self.weights.copy()
                weights[:, column] += sd * along
                if column == 0:  # arms are counted from the origin of the frame
                    weights[:, 1:] += np.outer(sd * along, self.origin_m)
                moved.append(replace(self, weights=weights))
        return moved

    def cop_m(self, rows: PlacementRows) -> FloatArray:
        """Corrected CoP, shape (n, 2); NaN where the total force is too small."""
        raw = rows.raw_cop_m
        if self.model.physical:
            wrench = _with_offset(rows.forces_n) @ self.weights
            corrected = np.full_like(raw, np.nan)
            at = rows.valid & (wrench[:, 0] > 0.5 * rows.min_force_n)
            corrected[at] = wrench[at, 1:] / wrench[at, :1]
            return corrected
        if self.model == NONE:
            return raw
        features = _features(self.model, raw - self.origin_m, rows.forces_n)
        features = (features - self.centre) / self.width
        return np.asarray(raw + features @ self.weights)

    def total_n(self, rows: PlacementRows) -> FloatArray:
        """Vertical force, shape (n,)."""
        if self.model.physical:
            return np.asarray(_with_offset(rows.forces_n) @ self.weights[:, 0])
        return rows.total_n

    def coefficients(self) -> FloatArray:
        """Empirical: coefficients of the terms as they are, not standardised, shape (k, 2)."""
        found = self.weights / self.width[:, None]
        found[0] -= self.centre[1:] @ found[1:]
        x, y = self.origin_m
        # what each feature is of 1, x, y, x², xy, y²
        back = np.array(
            [
                [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                [-x, 1.0, 0.0, 0.0, 0.0, 0.0],
                [-y, 0.0, 1.0, 0.0, 0.0, 0.0],
                [x * x, -2.0 * x, 0.0, 1.0, 0.0, 0.0],
                [_MIXED * x * y, -_MIXED * y, -_MIXED * x, 0.0, _MIXED, 0.0],
                [y * y, 0.0, -2.0 * y, 0.0, 0.0, 1.0],
            ]
        )
        count = TERMS[self.model.name]
        return np.concatenate([back[:count, :count].T @ found[:count], found[count:]])

    @property
    def shares(self) -> FloatArray:
        """s_i, what a newton read by each cell adds to the load, shape (c,)."""
        return np.asarray(self.weights[:-1, 0])

    @property
    def crosstalk(self) -> FloatArray:
        """κ_i of the table of effects that explains the shares of cells of known scale.

        ``y_i = x_i + κ_i mean_{j≠i} x_j`` makes the total ``Σ s_i y_i`` with ``sᵀ M(κ) = 1ᵀ``,
        linear in κ: ``s_j + Σ_{i≠j} s_i κ_i / (c − 1) = 1``. Shape (c,); zero of shares that are
        gains.
        """
        if self.model.with_gains:
            return np.zeros(self.shares.size)
        mixing = _others(self.shares.size) * self.shares
        try:
            return np.asarray(np.linalg.solve(mixing, 1 - self.shares))
        except np.linalg.LinAlgError:
            raise FitError(
                "no crosstalk explains what the cells read at the placements",
                remedy="check the cells' calibration and the loads (footcal check)",
            ) from None

    @property
    def bias_corrections_n(self) -> FloatArray:
        """Smallest changes of the cells' biases that add the offsets f and m, shape (c,).

        Three offsets for c cells: the combination of biases that moves neither load nor moments
        is not seen and stays as it was.
        """
        cells, offsets = self.weights[:-1], self.weights[-1]
        if not offsets.any():
            return np.zeros(len(cells))
        return np.asarray(np.linalg.lstsq(cells.T, offsets, rcond=None)[0])

    def corrections_m(self, cell_pos_m: FloatArray) -> FloatArray:
        """True minus believed cell positions, shape (c, 2).

        Lever arms q of the readings belong to the positions ``p = M(κ)ᵀ q``, under gains s to
        ``p = q / s``.
        """
        if self.model.with_gains:
            return np.asarray(self.weights[:-1, 1:] / self.shares[:, None] - cell_pos_m)
        mixing = np.eye(self.shares.size) + self.crosstalk[:, None] * _others(self.shares.size)
        return np.asarray(mixing.T @ self.weights[:-1, 1:] - cell_pos_m)


def _others(cells: int) -> FloatArray:
    """Each cell's mean over the other cells of the foot, shape (c, c)."""
    return (1.0 - np.eye(cells)) / max(cells - 1, 1)


def _with_offset(forces_n: FloatArray) -> FloatArray:
    return np.column_stack([forces_n, np.ones(len(forces_n))])


_MIXED = np.sqrt(2.0)
"""Of the term xy: with it, a turned foot frame turns the quadratic terms without stretching them,
and a ridge on their coefficients means the same along all axes."""


def _features(model: CopModel, at_m: FloatArray, forces_n: FloatArray) -> FloatArray:
    """Columns 1, x, y, x², √2 xy, y², then the cell forces, shape (n, k)."""
    x, y = at_m.T
    columns = [np.ones_like(x), x, y, x * x, _MIXED * x * y, y * y][: TERMS[model.name]]
    return np.column_stack([*columns, forces_n] if model.with_forces else columns)


def _width(features: FloatArray, terms: int) -> FloatArray:
    """Scatter of the features, shape (k,), one for all terms of a degree."""
    width = features.std(axis=0)
    for degree in (slice(1, min(3, terms)), slice(3, terms)):
        if width[degree].size:
            width[degree] = np.sqrt(np.mean(width[degree] ** 2))
    width[0] = 1.0
    return np.asarray(np.where(width > 1e-12, width, 1.0))


def corrected_cop_m(
    terms: Sequence[str],
    coefficients: FloatArray,
    raw_cop_m: FloatArray,
    forces_n: FloatArray,
    cells: Sequence[str],
) -> FloatArray:
    """``CoP + Σ a_k φ_k(x, y) + Σ b_i F_i`` with the terms named ([NAO], eqs. (3)–(5)).

    Parameters
    ----------
    terms
        Of ``1, x, y, x², xy, y²`` and names of cells.
    coefficients
        Of each term for x and y, as `CopFit.coefficients` gives them, shape (k, 2).
    raw_cop_m, forces_n, cells
        CoP (n, 2), forces (n, c) and the names of their columns.

    Returns
    -------
    FloatArray
        Corrected CoP, shape (n, 2).
    """
    x, y = raw_cop_m.T
    columns = {"1": np.ones_like(x), "x": x, "y": y, "x²": x * x, "xy": x * y, "y²": y * y}
    columns |= {cell: forces_n[:, i] for i, cell in enumerate(cells)}
    return np.asarray(raw_cop_m + np.column_stack([columns[t] for t in terms]) @ coefficients)


def fit_cop(model: CopModel, rows: PlacementRows, ridge: float = 0.0) -> CopFit:
    """Fit one correction by (ridge) least squares.

    Parameters
    ----------
    rows
        Placements; the empirical models use rows with a CoP, the physical ones all rows with a
        known load, because moments are defined at the smallest weight.
    ridge
        Penalty relative to the number of rows; empirical models only.
    """
    if model.places_known:
        return _fit_gains(model, rows)
    if model.physical:
        return _fit_physical(model, rows)
    if model == NONE:
        return CopFit(model, np.zeros((0, 2)), np.zeros(2), np.zeros(0), np.zeros(0), 0.0, 0, 1.0)
    used = rows.valid
    raw = rows.raw_cop_m[used]
    origin = rows.cell_pos_m.mean(axis=0) if rows.cells else raw.mean(axis=0)
    features = _features(model, raw - origin, rows.forces_n[used])
    centre, width = features.mean(axis=0), _width(features, TERMS[model.name])
    centre[0] = 0.0
    design = (features - centre) / width
    left, singular, right = np.linalg.svd(design, full_matrices=False)
    rank, condition = rank_of(singular, design.shape)
    target = rows.hole_m[used] - raw
    if ridge == 0.0:
        inverse = np.where(np.arange(singular.size) < rank, 1.0 / np.maximum(singular, 1e-300), 0)
        weights = right.T @ (inverse[:, None] * (left.T @ target))
    else:
        penalty = ridge * len(design) * np.eye(design.shape[1])
        penalty[0, 0] = 0.0
        weights = np.linalg.solve(design.T @ design + penalty, design.T @ target)
    return CopFit(model, np.asarray(weights), origin, centre, width, ridge, rank, condition)


def _fit_physical(model: CopModel, rows: PlacementRows) -> CopFit:
    """Shares and lever arms of the cells from load and moment, all linear."""
    loaded = np.isfinite(rows.load_n)
    if not loaded.any():
        # only the place is known: the total force stands in for the load, so no share is visible
        loaded, load = np.isfinite(rows.total_n), rows.total_n
    else:
        load = rows.load_n
    forces, load, hole = rows.forces_n[loaded], load[loaded], rows.hole_m[loaded]
    cells = forces.shape[1]
    middle = rows.cell_pos_m.mean(axis=0)
    weights, loose = np.zeros((cells + 1, 3)), np.zeros((3, cells + 1, cells + 1))
    weights[:cells, 0] = 1.0
    weights[:cells, 1:] = rows.cell_pos_m - middle
    design = _with_offset(forces) if model.with_bias else forces
    count = design.shape[1]
    carried = load if model.with_forces else forces.sum(axis=1)
    rest = np.column_stack([load, carried[:, None] * (hole - middle)]) - design @ weights[:count]
    free = np.full(count - cells, float(np.abs(forces).max()))
    usual = np.concatenate([np.full(cells, USUAL_SHARE), free])
    for size, columns in ((1.0, slice(0, 1)), (_extent_m(rows.cell_pos_m), slice(1, 3))):
        if model.with_forces or columns.start:
            # under one load alone an offset would stand in for all that the cells read of it
            own = count if columns.start or np.ptp(load) > 0.0 else cells
            found, spread = about_usual(design[:, :own], rest[:, columns], size * usual[:own])
            weights[:own, columns] += found
            loose[columns, :own, :own] = spread
    weights[:, 1:] += weights[:, :1] * middle
    singular = np.linalg.svd(design / np.linalg.norm(design, axis=0), compute_uv=False)
    rank, condition = rank_of(singular, design.shape)
    return CopFit(model, weights, middle, np.zeros(0), np.zeros(0), 0.0, rank, condition, loose)


def _fit_gains(model: CopModel, rows: PlacementRows) -> CopFit:
    """Gains of cells that sit where they are believed: ``Σ s_i F_i (1, p_i) = load (1, hole)``.

    Load and moments, each in units of what is left of it.
    """
    loaded = np.isfinite(rows.load_n)
    forces, load = rows.forces_n[loaded], rows.load_n[loaded]
    middle = rows.cell_pos_m.mean(axis=0)
    arms = np.column_stack([np.ones(len(rows.cell_pos_m)), rows.cell_pos_m - middle])
    put = load[:, None] * np.column_stack([np.ones(load.size), rows.hole_m[loaded] - middle])
    columns, rest = forces[:, None, :] * arms.T, put - forces @ arms
    cells, unit = forces.shape[1], np.array([1.0, *[_extent_m(rows.cell_pos_m)] * 2])
    gains = np.zeros(cells)
    for _ in range(_WEIGHINGS):
        design = (columns / unit[:, None]).reshape(-1, cells)
        target = (rest / unit).ravel()
        if model.single:
            along, own = design.T @ target, np.maximum(np.sum(design**2, axis=0), 1e-300)
            best = int(np.argmax(along**2 / own))
            gains = np.zeros(cells)
            gains[best] = along[best] / own[best]
        else:
            gains = about_usual(design, target[:, None], np.full(cells, USUAL_SHARE))[0][:, 0]
        unit = np.maximum(np.sqrt(np.mean((rest - columns @ gains) ** 2, axis=0)), 1e-12)
    weights = np.zeros((cells + 1, 3))
    weights[:cells] = (1.0 + gains)[:, None] * np.column_stack([arms[:, 0], rows.cell_pos_m])
    singular = np.linalg.svd(design / np.linalg.norm(design, axis=0), compute_uv=False)
    rank, condition = rank_of(singular, design.shape)
    loose = np.zeros((3, cells + 1, cells + 1))
    return CopFit(model, weights, middle, np.zeros(0), np.zeros(0), 0.0, rank, condition, loose)


def _extent_m(cell_pos_m: FloatArray) -> float:
    """How far the cells sit from their middle, root mean square."""
    return float(np.sqrt(np.mean(np.sum((cell_pos_m - cell_pos_m.mean(axis=0)) ** 2, axis=1))))
