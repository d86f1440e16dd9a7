"""What all mountings of a standing robot have in common: a tilt of the markers would look the same.

Poses see how each transducer is turned against the body frame that the markers define. If that
frame itself is tilted, every mounting comes out turned by the same rotation, and no pose can tell
which of the two it is. Mountings that only scatter have a common part of about their scatter over
the square root of the number of legs; more than that has one cause.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from footcal_cli.core.parameters import FloatArray

COMMON_P = 1e-3
"""A robot whose mountings only scatter is told of a common turn this often."""


@dataclass(frozen=True)
class CommonTurn:
    """The mean turn of all mountings, roll and pitch in body axes.

    Parameters
    ----------
    turn_rad
        Mean over the legs, shape (2,).
    half_rad
        Half width of the 95 % interval of each, from the scatter of the legs, shape (2,).
    scatter_rad
        Sd of the legs about the mean, both axes together.
    p
        That legs which only scatter have such a mean (Hotelling's T²).
    """

    turn_rad: FloatArray
    half_rad: FloatArray
    scatter_rad: float
    p: float

    @property
    def stands_out(self) -> bool:
        """Whether scatter alone does not explain it."""
        return self.p < COMMON_P

    @property
    def words(self) -> str:
        """Size and scatter, in degrees."""
        roll, pitch = np.rad2deg(self.turn_rad)
        wide = np.rad2deg(self.half_rad)
        return (
            f"all mountings are turned alike, roll {roll:.2f} ± {wide[0]:.2f}° and pitch "
            f"{pitch:.2f} ± {wide[1]:.2f}°, and scatter by {np.rad2deg(self.scatter_rad):.2f}°"
        )


def common_turn(turn_b_rad: FloatArray) -> CommonTurn | None:
    """Mean turn of the mountings against their scatter.

    ``T² = K m̄ᵀ S⁻¹ m̄`` with S the covariance of the legs' roll and pitch about their mean;
    ``(K − 2) T² / (2 (K − 1)) ~ F(2, K − 2)`` where legs only scatter (Hotelling 1931). Yaw is left
    out: a level shows none.

    Parameters
    ----------
    turn_b_rad
        Rotation vector of each mounting error in body axes, ``R_bt = exp[turn] R_nominal``,
        shape (K, 3).

    Returns
    -------
    None of fewer than four legs, or where all are turned exactly alike by the model.
    """
    legs, tilt = turn_b_rad.shape[0], turn_b_rad[:, :2]
    if legs < 4:
        return None
    mean = tilt.mean(axis=0)
    scatter = np.cov(tilt, rowvar=False)
    if np.linalg.matrix_rank(scatter) < 2:
        return None
    t_squared = legs * float(mean @ np.linalg.solve(scatter, mean))
    p = float(stats.f.sf((legs - 2) * t_squared / (2 * (legs - 1)), 2, legs - 2))
    half = stats.t.ppf(0.975, legs - 1) * np.sqrt(np.diag(scatter) / legs)
    return CommonTurn(mean, np.asarray(half), float(np.sqrt(np.trace(scatter) / 2.0)), p)
