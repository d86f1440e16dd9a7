"""Squared errors as sums, so that those of parts of a walk add up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import FloatArray, IntArray


@dataclass(frozen=True)
class Squares:
    """Sums of squared errors, from which those of parts of a walk add up.

    Parameters
    ----------
    total
        Sum of the squares, a number or of each gait cycle, shape (cycles,).
    count
        How many errors stand behind it, of the same shape.
    """

    total: FloatArray
    count: FloatArray

    @property
    def rms(self) -> FloatArray:
        """``√(total / count)``, NaN where nothing counts."""
        with np.errstate(invalid="ignore"):
            return np.asarray(np.sqrt(self.total / np.where(self.count > 0, self.count, np.nan)))

    def __add__(self, other: Squares) -> Squares:
        return Squares(self.total + other.total, self.count + other.count)

    def widened(self, cycles: int) -> Squares:
        """The same with room for so many gait cycles."""
        more = (0, cycles - self.count.size)
        return Squares(np.pad(self.total, more), np.pad(self.count, more))


def squares(values: FloatArray) -> Squares:
    """Of the finite errors, shape (n,), or of vectors, shape (n, k)."""
    squared = values**2 if values.ndim == 1 else np.sum(values**2, axis=1)
    finite = squared[np.isfinite(squared)]
    return Squares(np.asarray(finite.sum()), np.asarray(float(finite.size)))


def squares_per_cycle(errors: FloatArray, cycle: IntArray) -> Squares:
    """Of each gait cycle.

    Parameters
    ----------
    errors
        Shape (n,) or (n, k); not finite ones do not count.
    cycle
        Number of the cycle of each sample, negative for none, shape (n,).
    """
    squared = errors**2 if errors.ndim == 1 else np.sum(errors**2, axis=1)
    use = (cycle >= 0) & np.isfinite(squared)
    count = int(cycle.max(initial=-1)) + 1
    return Squares(
        np.bincount(cycle[use], weights=squared[use], minlength=count).astype(float),
        np.bincount(cycle[use], minlength=count).astype(float),
    )
