"""Noise of the logged attitudes: gravity turns with them, and the balance of forces is off by it.

No transducer reads it, and a hundredth of the chassis' weight per ten milliradians is soon more
than their noise. It moves horizontal forces alone: taken for noise of all channels it would leave
the rotations of the mountings too sure, and the places of the hips too unsure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData, summarise
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import fit_pose
from footcal_cli.core.pose.problem import PoseOptions, feature_noise

_GRID_RAD: FloatArray = np.geomspace(1e-4, 0.02, 24)
"""From motion capture at its best to an inertial unit at its worst."""
_FEWEST_LEFT = 30
"""Equations beyond the mounting that tell two kinds of noise from each other."""


@dataclass(frozen=True)
class Attitudes:
    """How much the logged attitudes scatter.

    Parameters
    ----------
    sd_rad
        Of a pose, on the scale on which the transducers' noise was given.
    misfit
        −2 log of the poses' likelihood with it, but for a constant.
    """

    sd_rad: float
    misfit: float


def find_attitudes(
    data: PoseData, legs: tuple[LegKnowledge, ...], noise_sd: FloatArray, options: PoseOptions
) -> Attitudes:
    r"""Sd of a pose's attitude.

    Of the balance's errors e with covariance ``S(σ) = M (N + σ² G) Mᵀ``, the σ that minimises

    .. math:: \sum_p e_p^T S^{-1} e_p + (n / 6) \log \det S

    with n equations left, or its profile where the level of the noise is not known; 0 where it
    gains no more than one parameter costs (Bayesian information criterion).
    """
    fit = fit_pose(summarise(data), legs, noise_sd, options)
    if fit.left < _FEWEST_LEFT or not fit.converged:
        return Attitudes(0.0, np.inf)
    matrix, error = fit.matrix, data.features() @ fit.matrix.T

    def cost(sd_rad: float) -> float:
        spread = (matrix * feature_noise(noise_sd, sd_rad)) @ matrix.T
        chi2 = float(np.sum(error.T * np.linalg.solve(spread, error.T)))
        misfit = chi2 if options.noise_known else fit.left * np.log(chi2)
        return float(misfit + fit.left / 6.0 * np.linalg.slogdet(spread)[1])

    costs = [cost(sd) for sd in _GRID_RAD]
    best = int(np.argmin(costs))
    still = cost(0.0)
    if still - costs[best] > np.log(6.0 * len(data)):
        return Attitudes(float(_GRID_RAD[best]), costs[best])
    return Attitudes(0.0, still)
