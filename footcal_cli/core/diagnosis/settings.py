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

_STEPS = 60
_STOP = 1e-3
_UPPER = 0.1
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
    """Upper value of each column's variance, by restricted maximum likelihood, shape (q,).

    Expectation maximisation on the mixed-model equations (Henderson): the fitted calibration's own
    uncertainty counts, as it must where a few settings determine it.
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
    kinds = int(kind.max()) + 1
    members = np.tile(kind, many)
    seen = np.diag(normal)[p:] > 0
    variance = np.ones(kinds)
    freedom = np.ones(kinds)
    for _ in range(_STEPS):
        full = normal / np.outer(scale, scale)
        full[np.arange(p, size), np.arange(p, size)] += 1.0 / variance[members]
        inverse = np.linalg.pinv(full, rcond=_RCOND, hermitian=True)
        effect = inverse[p:] @ (right / scale)
        spread = np.diag(inverse)[p:]
        updated = np.empty(kinds)
        for g in range(kinds):
            own = (members == g) & seen
            count = max(int(own.sum()), 1)
            updated[g] = max(float(np.sum(effect[own] ** 2 + spread[own])) / count, 1e-12)
            freedom[g] = float(np.sum(1.0 - spread[own] / variance[g]))
        change = float(np.abs(np.log(updated / variance)).max())
        variance = updated
        if change < _STOP:
            break
    upper = freedom / stats.chi2.ppf(_UPPER, np.maximum(freedom, 1.0))
    return np.asarray((variance * np.maximum(upper, 1.0))[kind])
