"""Intervals of jointly fitted sizes: what leaving out blocks moves, and what all blocks share.

Room: inference; imported by its refits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.inference.evidence import Interval, effective_blocks, jackknife_interval
from footcal_cli.core.inference.grams import Grams
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.scores import joint_sizes, scores
from footcal_cli.core.parameters import FloatArray, IntArray

_RCOND = 1e-9
MODEL_ERROR = 0.05
"""Sd of a size fitted to a walk beyond the scatter of its blocks, as a share of the size: the
low-pass does not commute with a curve, and transitions are not quite balanced. Measured on
development walks."""


@dataclass(frozen=True)
class Scatter:
    """What leaving out single blocks does to jointly fitted numbers.

    Parameters
    ----------
    apart
        Change of each number without each block, shape (B, k).
    informative
        Effective number of blocks that inform each, shape (k,).
    shared
        Sd of what no block can show because all share it, as a share of a size.
    known
        Covariance of the numbers from what was known of the calibration before, which errs in all
        blocks alike, shape (k, k).
    """

    apart: FloatArray
    informative: FloatArray
    shared: float
    known: FloatArray

    def interval(self, value: float, turn: FloatArray, beyond: float = 0.0) -> Interval:
        """95 % interval of a number that follows from the fitted ones.

        Parameters
        ----------
        turn
            Its derivative by the fitted numbers, shape (k,).
        beyond
            Sd of what no block can show because all share it, in the number's unit.
        """
        weight = np.sum(self.apart**2, axis=0) * turn**2
        known = float(np.sum(weight * self.informative) / max(float(weight.sum()), 1e-300))
        found = jackknife_interval(value, value + self.apart @ turn, informative=known)
        beyond = float(
            np.sqrt(max(beyond**2 + float(turn @ self.known @ turn), 0.0))
        )  # but for rounding
        if not beyond:
            return found
        half = float(np.hypot(found.high - value, 2.0 * beyond))
        return Interval(value, value - half, value + half)


def scatter_of(
    grams: Grams, live: IntArray, scale: FloatArray, *, moving: bool, known: FloatArray | None
) -> Scatter:
    """Leave out every block in turn.

    A calibration known with precision K before has a mean with the covariance K⁻¹, so that numbers
    have ``(H⁻¹)_sc K (H⁻¹)_cs`` from it: H their information together, c the calibration.

    Parameters
    ----------
    grams
        Of calibration and candidates at the optimum.
    live
        Candidates that change anything there.
    scale
        What each candidate was divided by, shape (k,).
    moving
        Whether the log is a walk.
    known
        Precision of the calibration, its first columns, shape (p, p).
    """
    columns = grams.candidates[live]
    sizes, without = joint_sizes(grams, grams.calibration, columns)
    apart = np.zeros((grams.blocks, scale.size))
    apart[:, live] = (without - sizes) / scale[live]
    informative = np.zeros(scale.size)
    for i, column in zip(live, columns, strict=True):
        base = np.concatenate([grams.calibration, columns[columns != column]])
        information = scores(grams.inner, base, np.array([column])).information
        informative[i] = effective_blocks(information)[0]
    return Scatter(
        apart, informative, MODEL_ERROR if moving else 0.0, _of_known(grams, live, scale, known)
    )


def _of_known(
    grams: Grams, live: IntArray, scale: FloatArray, known: FloatArray | None
) -> FloatArray:
    """Covariance of the numbers from the error of a calibration known before, shape (k, k)."""
    shared = np.zeros((scale.size, scale.size))
    if known is None or not live.size:
        return shared
    columns = np.concatenate([grams.calibration, grams.candidates[live]])
    inverse = scaled_inverse(grams.inner.summed(columns), _RCOND)
    first = grams.calibration.size
    by_calibration = inverse[first:, : len(known)] / scale[live, None]
    shared[np.ix_(live, live)] = by_calibration @ known @ by_calibration.T
    return shared
