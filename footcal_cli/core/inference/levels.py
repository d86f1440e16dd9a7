"""How long the level of a record lasts: neighbouring records of one sensor drift together.

Errors along the levels of L records and c channels that share a law are ``u = X b + e`` with
``e ~ N(0, I + s² S K S)``: S how exactly each level is known, ``K_ij = exp(−|t_i − t_j| / T)``. s
and T follow from the restricted likelihood, which no X b changes (Patterson and Thompson,
Biometrika 58, 545, 1971).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg, optimize

from footcal_cli.core.parameters import FloatArray

MOST_LEVELS = 60
"""Records in a row that are looked at: more tell a memory no better than it need be known."""
_FEWEST_FREE, _FEWEST_LEVELS = 12, 6
_MEMORIES = 8
"""Memories that are tried, from half a record to the next up to the recording."""
_RCOND = 1e-9


@dataclass(frozen=True)
class LevelLaw:
    """Covariance of levels over time, ``s² exp(−|t_i − t_j| / T)``.

    Parameters
    ----------
    sd, memory_s
        s and T; a memory of 0 is a level that every record draws anew.
    """

    sd: float
    memory_s: float

    def covariance(self, time_s: FloatArray) -> FloatArray:
        """Of records at these times, shape (L, L)."""
        return np.asarray(self.sd**2 * kernel(time_s, self.memory_s))


def kernel(time_s: FloatArray, memory_s: float) -> FloatArray:
    """``exp(−|t_i − t_j| / T)``, shape (L, L); the identity for T = 0."""
    if not memory_s > 0.0:
        return np.eye(time_s.size)
    return np.asarray(np.exp(-np.abs(time_s[:, None] - time_s) / memory_s))


def whitening(size: FloatArray, covariance: FloatArray) -> FloatArray:
    """``R⁻¹`` of ``I + S V S = R Rᵀ``, S (L,) a diagonal and V (L, L) of the levels."""
    root = np.linalg.cholesky(np.eye(size.size) + size[:, None] * covariance * size)
    return np.asarray(linalg.solve_triangular(root, np.eye(size.size), lower=True))


def lasting_levels(
    time_s: FloatArray, error: FloatArray, slope: FloatArray, size: FloatArray
) -> LevelLaw | None:
    """Law of levels that may last from record to record; None where the records cannot show it.

    Parameters
    ----------
    time_s
        Of each record, in order, shape (L,).
    error, slope, size
        u, X and the diagonal of S, shapes (L, c), (L, c, p) and (L, c).
    """
    time_s, error, slope, size = (part[:MOST_LEVELS] for part in (time_s, error, slope, size))
    levels, channels = error.shape
    if levels < _FEWEST_LEVELS or np.any(np.diff(time_s) <= 0.0):
        return None
    rows = slope.transpose(1, 0, 2).reshape(levels * channels, -1)
    turned, singular, _ = np.linalg.svd(rows, full_matrices=True)
    taken = int(np.sum(singular > _RCOND * singular.max(initial=0.0)))
    free = turned[:, taken:].T
    if len(free) < _FEWEST_FREE:
        return None
    left = free @ error.T.ravel()

    def best(memory_s: float) -> tuple[float, float, float]:
        """``−2 log L``, the sd that makes it least, and the memory."""
        shape = kernel(time_s, memory_s)
        own = [s[:, None] * shape * s for s in size.T]
        moved = free @ linalg.block_diag(*own) @ free.T
        values, axes = np.linalg.eigh(moved)
        along = (axes.T @ left) ** 2

        def cost(log_variance: float) -> float:
            variance = 1.0 + np.exp(log_variance) * np.maximum(values, 0.0)
            return float(np.sum(np.log(variance) + along / variance))

        usual = -np.log(max(float(values.max()), 1e-300))
        found = optimize.minimize_scalar(cost, bounds=(usual - 5.0, usual + 25.0), method="bounded")
        return float(found.fun), float(np.exp(0.5 * found.x)), memory_s

    apart = float(np.median(np.diff(time_s)))
    longest = max(float(np.ptp(time_s)), apart)
    tried = [best(float(m)) for m in [0.0, *np.geomspace(0.5 * apart, longest, _MEMORIES)]]
    _, sd, memory_s = min(tried)
    return LevelLaw(sd, memory_s)
