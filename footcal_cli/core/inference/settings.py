"""What does not repeat from one setting-up to the next: a robot hung anew, a plate put on again.

Within one hanging every sensor has an offset and a gain that the next hanging does not repeat.
Turns of one hanging share them, so that turns alone would count the same evidence many times.
Their variance is estimated from the differences between settings, taken at the upper end of its
own uncertainty, and rows are whitened for it: ``V = I + Z D Zᵀ`` in each setting, Z the offsets and
gains of the outputs. Where a setting has parts (turns of a hanging leg) what differs between these
comes first: counted as poor repeatability of the settings it would hide all that shows between
them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from scipy.sparse.csgraph import connected_components

from footcal_cli.core.inference.linear import inverse_beside
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

STEPS = 40
STOP = 0.02
_CAUTION = 0.7  # share of a step taken: the median jumps
_NORMAL_MEDIAN = 0.6745  # of |x| of a standard normal variable
_ALIKE = 1e-6  # a load that stands still is an offset
_QUIETEST = 0.1  # share of its usual noise that an axis has at least
_SHOWN = 0.05  # share of its largest influence from which a setting shows a column
RCOND = 1e-9
_PART_START, _PART_LEAST = 0.05, 1e-5  # variance of one part against that of one row


@dataclass(frozen=True)
class Settings:
    """What may differ between settings.

    Parameters
    ----------
    number
        Setting of each row, shape (m,), from 0.
    columns
        What one unit of each difference adds to the residual, shape (m, q).
    kind
        Columns of one kind share a variance, shape (q,), from 0.
    sensor, part
        Sensor of each row and the part of a setting it lies in (a turn of a leg), shape (m,), where
        offsets and gains differ from part to part too; absent where a setting has no parts.
    """

    number: IntArray
    columns: FloatArray
    kind: IntArray
    sensor: IntArray | None = None
    part: IntArray | None = None

    def parts(self, output: IntArray, kept: IntArray) -> list[Parts]:
        """What differs from part to part, per output of each sensor; positions within `kept`."""
        if self.sensor is None or self.part is None:
            return []
        found = []
        for sensor, o in product(np.unique(self.sensor[kept]), np.unique(output[kept])):
            rows = np.flatnonzero((self.sensor[kept] == sensor) & (output[kept] == o))
            if not rows.size:
                continue
            acting = np.flatnonzero(np.any(self.columns[kept[rows]] != 0.0, axis=0))
            own = np.stack([self.number[kept[rows]], self.part[kept[rows]]])
            pairs, number = np.unique(own, axis=1, return_inverse=True)
            groups = [rows[number.ravel() == n] for n in range(pairs.shape[1])]
            found.append(Parts(acting, groups, pairs[0]))
        return found

    def rows(self, kept: IntArray) -> list[IntArray]:
        """Positions within `kept` of each setting's rows."""
        own = self.number[kept]
        return [np.flatnonzero(own == s) for s in range(int(own.max(initial=-1)) + 1)]

    @cached_property
    def shown(self) -> BoolArray:
        """Which columns each setting shows beside what others show of them, shape (settings, q)."""
        squares = np.zeros((int(self.number.max(initial=0)) + 1, self.columns.shape[1]))
        np.add.at(squares, self.number, self.columns**2)
        size = np.sqrt(squares)
        return np.asarray(size >= _SHOWN * size.max(axis=0))


@dataclass(frozen=True)
class Parts:
    """One output of one sensor in the parts of its settings.

    Parameters
    ----------
    columns
        Which of `Settings.columns` act on it.
    groups
        Its rows in each part.
    setting
        In which each part lies.
    """

    columns: IntArray
    groups: list[IntArray]
    setting: IntArray


def row_levels(residual: FloatArray, loose: FloatArray, parts: list[Parts]) -> FloatArray:
    """Sd of single rows of every output of every sensor in each setting, shape (n,).

    What loads an axis makes it noisier: the axis along gravity is another one in every hanging.
    Each part has its own offset and gain first, and the freedom that these take is no noise.
    """
    level = np.ones(residual.size)
    for part in parts:
        squares, freedom = (np.zeros(int(part.setting.max()) + 1) for _ in range(2))
        for rows, setting in zip(part.groups, part.setting, strict=True):
            z = loose[np.ix_(rows, part.columns)]
            u = _basis(z, _ALIKE**2)
            squares[setting] += np.sum((residual[rows] - u @ (u.T @ residual[rows])) ** 2)
            freedom[setting] += rows.size - u.shape[1]
        sd = np.sqrt(squares / np.maximum(freedom, 1.0))
        typical = float(np.median(sd[sd > 0])) if np.any(sd > 0) else 1.0
        for rows, setting in zip(part.groups, part.setting, strict=True):
            level[rows] = max(sd[setting], _QUIETEST * typical)
    return level


def beside_settings(
    common: FloatArray,
    residual: FloatArray,
    loose: FloatArray,
    groups: Sequence[IntArray],
    shown: BoolArray,
) -> FloatArray:
    """Residuals beside common columns and what each setting has of its own, shape (n,) or (n, k).

    Least squares in two steps (Frisch and Waugh 1933): a setting's own columns touch its rows only,
    so that they are taken out of each setting's rows, and what is left is fitted in common.

    Parameters
    ----------
    common, residual
        Columns that all settings share, and one residual or several, white within a part.
    loose
        Z, likewise.
    groups, shown
        Rows of each setting, and which columns of Z it shows.
    """
    both = np.column_stack([common, residual])
    for rows, seen in zip(groups, shown, strict=True):
        for at, own in _apart(loose[np.ix_(rows, np.flatnonzero(seen))]):
            basis, mine = _basis(own / np.linalg.norm(own, axis=0), RCOND), rows[at]
            both[mine] -= basis @ (basis.T @ both[mine])
    columns, left = both[:, : common.shape[1]], both[:, common.shape[1] :].reshape(residual.shape)
    inverse = inverse_beside(columns.T @ columns, np.linalg.norm(common, axis=0), RCOND)
    return np.asarray(left - columns @ (inverse @ (columns.T @ left)))


def _basis(columns: FloatArray, rcond: float) -> FloatArray:
    """Orthonormal basis of what few columns span, by the eigenvalues of their products."""
    values, vectors = np.linalg.eigh(columns.T @ columns)
    seen = values > rcond * values.max(initial=0.0)
    return np.asarray(columns @ (vectors[:, seen] / np.sqrt(values[seen])))


def _apart(columns: FloatArray) -> Iterator[tuple[IntArray, FloatArray]]:
    """Columns that have no row in common with others, each set on its rows: one per output."""
    acts = columns != 0.0
    count, kin = connected_components(acts.T.astype(float) @ acts)
    for k in range(count):
        at = np.flatnonzero(np.any(acts[:, kin == k], axis=1))
        if at.size:
            yield at, columns[np.ix_(at, np.flatnonzero(kin == k))]


def part_variances(left: FloatArray, loose: FloatArray, parts: list[Parts]) -> list[FloatArray]:
    """Variances of each sensor's columns over its parts, shape (q of the sensor,) each.

    Every output of every sensor has its own variances: one axis of one leg has dozens of turns to
    show them, and what it carries beside the load is not what the others carry.

    Parameters
    ----------
    left
        Residual beside what parts of one setting share, from `beside_settings`.
    loose
        Z, likewise white within a part.
    parts
        From `Settings.parts`.
    """
    return [
        _variance_of_parts(
            [
                (z.T @ z, z.T @ left[rows])
                for rows in part.groups
                for z in [loose[np.ix_(rows, part.columns)]]
            ]
        )
        for part in parts
    ]


def whiten_parts(
    white: FloatArray, loose: FloatArray, parts: list[Parts], variances: list[FloatArray]
) -> None:
    """Whiten columns, in place, for what differs from part to part of a setting.

    Parameters
    ----------
    white, loose
        What is to be whitened, shape (n, k), and Z, rows already white within a part.
    parts, variances
        From `Settings.parts` and `part_variances`.
    """
    for part, variance in zip(parts, variances, strict=True):
        _shrink(white, part.groups, loose[:, part.columns] * np.sqrt(variance))


def _shrink(out: FloatArray, groups: Sequence[IntArray], loose: FloatArray) -> None:
    """``(I + Z Zᵀ)^(−1/2)`` times the rows of each group, in place.

    With ``ZᵀZ = W diag(λ) Wᵀ`` that is ``I − Z W diag((1 − (1 + λ)^(−1/2)) / λ) Wᵀ Zᵀ``.
    """
    z = [loose[rows] for rows in groups]
    values, vectors = np.linalg.eigh(np.stack([one.T @ one for one in z]))
    values = np.maximum(values, 0.0)
    # (1 − 1/√(1 + λ)) / λ without the difference of what is nearly equal
    root = np.sqrt(1.0 + values)
    middle = (vectors / (root * (1.0 + root))[:, None, :]) @ vectors.swapaxes(1, 2)
    for rows, one, inner in zip(groups, z, middle, strict=True):
        mine = out[rows]
        out[rows] = mine - (one @ inner) @ (one.T @ mine)


def half_log_det(loose: FloatArray) -> float:
    """``½ log det(I + Z Zᵀ)``, what a likelihood charges for that covariance."""
    return float(0.5 * np.linalg.slogdet(np.eye(loose.shape[1]) + loose.T @ loose)[1])


def _variance_of_parts(products: list[tuple[FloatArray, FloatArray]]) -> FloatArray:
    """Variance of each column over parts, from the median, shape (q,)."""
    own = np.stack([square for square, _ in products])
    right = np.stack([cross for _, cross in products])
    size = own.shape[1]
    variance = np.full(size, _PART_START)
    for _ in range(STEPS):
        unit = np.sqrt(variance)
        scaled = np.eye(size) + own * np.outer(unit, unit)  # never singular, whatever nobody shows
        inverse = np.linalg.inv(scaled) * np.outer(unit, unit)
        known = np.clip(1.0 - np.einsum("gii->gi", inverse) / variance, 1e-9, 1.0)
        effect = np.einsum("gij,gj->gi", inverse, right)
        standard = np.abs(effect) / np.sqrt(known * variance)
        factor = np.array(
            [(_weighted_median(standard[:, c], known[:, c]) / _NORMAL_MEDIAN) ** 2
             for c in range(size)]
        )  # fmt: skip
        updated = np.maximum(variance * np.clip(factor, 0.1, 10.0) ** _CAUTION, _PART_LEAST)
        change = float(np.abs(np.log(updated / variance)).max())
        variance = updated
        if change < STOP:
            break
    return variance


def repeated(
    white: FloatArray, loose: FloatArray, groups: list[IntArray], variance: FloatArray
) -> FloatArray:
    """Columns whitened for what does not repeat between settings, shape (n, k).

    Parameters
    ----------
    white
        What is to be whitened, rows already white within a setting, shape (n, k).
    loose
        Z, likewise whitened.
    variance
        Variance of each column of Z, shape (q,).
    """
    out = white.copy()
    _shrink(out, groups, loose * np.sqrt(variance))
    return out


def _weighted_median(values: FloatArray, weights: FloatArray) -> float:
    """Value below which half of the weight lies; 0 of none."""
    if not values.size:
        return 0.0
    order = np.argsort(values)
    running = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(running, 0.5 * running[-1])])
