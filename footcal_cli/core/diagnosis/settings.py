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

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy import stats

from footcal_cli.core.parameters import FloatArray, IntArray

_STEPS = 40
_STOP = 0.02
_CAUTION = 0.7  # share of a step taken: the median jumps
_NORMAL_MEDIAN = 0.6745  # of |x| of a standard normal variable
_MEDIAN_EFFICIENCY = 0.37  # of a median-based variance against the mean square
_UPPER = 0.2
"""The variance is taken so large that a larger one would have shown less with this probability."""
_RCOND = 1e-9
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
            number = np.unique(own, axis=1, return_inverse=True)[1].ravel()
            groups = [rows[number == n] for n in range(int(number.max()) + 1)]
            found.append(Parts(acting, groups))
        return found

    def rows(self, kept: IntArray) -> list[IntArray]:
        """Positions within `kept` of each setting's rows."""
        own = self.number[kept]
        return [np.flatnonzero(own == s) for s in range(int(own.max(initial=-1)) + 1)]

    def spread(self) -> FloatArray:
        """The columns of each setting on its own rows, shape (m, settings q)."""
        one = np.eye(int(self.number.max(initial=0)) + 1)[self.number]
        whole = one[:, :, None] * self.columns[:, None, :]
        return np.asarray(whole.reshape(len(self.number), -1))


@dataclass(frozen=True)
class Parts:
    """One output of one sensor in the parts of its settings.

    Parameters
    ----------
    columns
        Which of `Settings.columns` act on it.
    groups
        Its rows in each part.
    """

    columns: IntArray
    groups: list[IntArray]


def within_settings(
    white: FloatArray, common: FloatArray, loose: FloatArray, residual: FloatArray,
    parts: list[Parts],
) -> FloatArray:  # fmt: skip
    """Columns whitened for what differs from part to part of a setting, shape (n, k).

    Every output of every sensor has its own variances: one axis of one leg has dozens of turns to
    show them, and what it carries beside the load is not what the others carry.

    Parameters
    ----------
    white
        What is to be whitened, rows already white within a part, shape (n, k).
    common
        What parts of one setting share: calibration, and each setting's own offsets and gains.
    loose, residual
        Z and the residual, likewise whitened.
    parts
        From `Settings.parts`.
    """
    left = residual - common @ _fitted(common, residual)
    out = white.copy()
    for part in parts:
        products = [
            (z.T @ z, z.T @ left[rows])
            for rows in part.groups
            for z in [loose[np.ix_(rows, part.columns)]]
        ]
        variance = _variance_of_parts(products)
        for rows in part.groups:
            _shrink(out, white, rows, loose[np.ix_(rows, part.columns)] * np.sqrt(variance))
    return out


def _fitted(basis: FloatArray, target: FloatArray) -> FloatArray:
    scale = np.sqrt(np.sum(basis**2, axis=0))
    scale = np.where(scale > 0, scale, np.inf)
    normed = basis / scale
    inverse = np.linalg.pinv(normed.T @ normed, rcond=_RCOND, hermitian=True)
    return np.asarray((inverse @ (normed.T @ target)) / scale)


def _shrink(out: FloatArray, white: FloatArray, rows: IntArray, loose: FloatArray) -> None:
    """``(I + Z Zᵀ)^(−1/2)`` times some rows, in place."""
    u, s, _ = np.linalg.svd(loose, full_matrices=False)
    out[rows] -= u @ ((1.0 - 1.0 / np.sqrt(1.0 + s**2))[:, None] * (u.T @ white[rows]))


def _variance_of_parts(products: list[tuple[FloatArray, FloatArray]]) -> FloatArray:
    """Variance of each column over parts, from the median as in `_variance`, shape (q,)."""
    own = np.stack([square for square, _ in products])
    right = np.stack([cross for _, cross in products])
    size = own.shape[1]
    variance = np.full(size, _PART_START)
    for _ in range(_STEPS):
        inverse = np.linalg.inv(own + np.diag(1.0 / variance))
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
        if change < _STOP:
            break
    return variance


def repeated(
    white: FloatArray, calibration: FloatArray, loose: FloatArray, residual: FloatArray,
    groups: list[IntArray], kind: IntArray,
) -> FloatArray:  # fmt: skip
    """Columns whitened for what does not repeat between settings, shape (n, k).

    Parameters
    ----------
    white
        What is to be whitened, rows already white within a setting, shape (n, k).
    calibration, loose, residual
        Columns that all settings share, Z, and the residual, likewise whitened.
    groups
        Rows of each setting.
    kind
        As in `Settings`.
    """
    variance = _variance(calibration, loose, residual, groups, kind)
    out = white.copy()
    for rows in groups:
        if not rows.size:
            continue
        _shrink(out, white, rows, loose[rows] * np.sqrt(variance))
    return out


def _variance(
    calibration: FloatArray,
    loose: FloatArray,
    residual: FloatArray,
    groups: list[IntArray],
    kind: IntArray,
) -> FloatArray:
    """Upper value of each column's variance, shape (q,).

    Predictions û of what differs come from the mixed-model equations (Henderson), in which the
    fitted calibration's own uncertainty counts. The variance is the one for which the median of
    |û| over its own sd is that of a normal variable: an effect that is there and moves one axis
    of one sensor does not pass for poor repeatability of all.
    """
    p, q, many = calibration.shape[1], loose.shape[1], len(groups)
    size = p + many * q
    normal, right = np.zeros((size, size)), np.zeros(size)
    normal[:p, :p] = calibration.T @ calibration
    right[:p] = calibration.T @ residual
    for i, rows in enumerate(groups):
        at = slice(p + i * q, p + (i + 1) * q)
        z = loose[rows]
        normal[at, at] = z.T @ z
        normal[:p, at] = calibration[rows].T @ z
        normal[at, :p] = normal[:p, at].T
        right[at] = z.T @ residual[rows]
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    scale[p:] = 1.0
    information = np.diag(normal)[p:]
    members = np.where(information > 0, np.tile(kind, many), -1)
    kinds = int(kind.max()) + 1
    least = np.array([1.0 / max(_median(information[members == g]), 1e-300) for g in range(kinds)])
    variance = np.maximum(least, 1.0)
    freedom = np.ones(kinds)
    for _ in range(_STEPS):
        full = normal / np.outer(scale, scale)
        full[np.arange(p, size), np.arange(p, size)] += 1.0 / variance[np.tile(kind, many)]
        inverse = np.linalg.pinv(full, rcond=_RCOND, hermitian=True)
        effect, spread = inverse[p:] @ (right / scale), np.diag(inverse)[p:]
        factor = np.ones(kinds)
        for g in range(kinds):
            own = members == g
            known = np.clip(1.0 - spread[own] / variance[g], 1e-9, 1.0)
            freedom[g] = _MEDIAN_EFFICIENCY * float(known.sum())
            standard = np.abs(effect[own]) / np.sqrt(known * variance[g])
            factor[g] = (_weighted_median(standard, known) / _NORMAL_MEDIAN) ** 2
        updated = np.maximum(variance * np.clip(factor, 0.1, 10.0) ** _CAUTION, least)
        change = float(np.abs(np.log(updated / variance)).max())
        variance = updated
        if change < _STOP:
            break
    degrees = np.maximum(freedom, 1.0)
    return np.asarray((variance * degrees / stats.chi2.ppf(_UPPER, degrees))[kind])


def _median(values: FloatArray) -> float:
    return float(np.median(values)) if values.size else 1.0


def _weighted_median(values: FloatArray, weights: FloatArray) -> float:
    """Value below which half of the weight lies; 0 of none."""
    if not values.size:
        return 0.0
    order = np.argsort(values)
    running = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(running, 0.5 * running[-1])])
