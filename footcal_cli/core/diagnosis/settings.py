"""What does not repeat from one setting-up to the next: a robot hung anew, a plate put on again.

Within one hanging every sensor has an offset and a gain that the next hanging does not repeat.
Turns of one hanging share them, so that turns alone would count the same evidence many times.
Their variance is estimated from the differences between settings, taken at the upper end of its
own uncertainty, and rows are whitened for it: ``V = I + Z D Zᵀ`` in each setting, Z the offsets and
gains of the outputs.
"""

from __future__ import annotations

from dataclasses import dataclass

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
    """

    number: IntArray
    columns: FloatArray
    kind: IntArray

    def rows(self, kept: IntArray) -> list[IntArray]:
        """Positions within `kept` of each setting's rows."""
        own = self.number[kept]
        return [np.flatnonzero(own == s) for s in range(int(own.max(initial=-1)) + 1)]

    def spread(self) -> FloatArray:
        """The columns of each setting on its own rows, shape (m, settings q)."""
        one = np.eye(int(self.number.max(initial=0)) + 1)[self.number]
        whole = one[:, :, None] * self.columns[:, None, :]
        return np.asarray(whole.reshape(len(self.number), -1))


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
        u, s, _ = np.linalg.svd(loose[rows] * np.sqrt(variance), full_matrices=False)
        shrink = 1.0 - 1.0 / np.sqrt(1.0 + s**2)
        out[rows] -= u @ (shrink[:, None] * (u.T @ white[rows]))
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
