"""One reading of one leg whose gain, or share in another reading, explains what a fit leaves.

A leg's 36 slopes (`leg_map`) ask for more poses than most robots record. One slope is one number:
a score test (Rao 1948) of each, beside everything that the fit leaves free and its priors,

    γ̂ = xᵀe / I,   I = xᵀx − xᵀJ (JᵀJ + P)⁻¹ Jᵀx,   F = γ̂² I / (e'ᵀe' / (n − 1)),

e the whitened balance, e' what is left of it when γ̂ and the unknowns that follow it have moved, J
its slopes by the fit's unknowns, P their precision beforehand, and x what an axis makes of the
reading closest to the measured one that balances, of which e is independent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution

from footcal_cli.core.inference.linear import inverse_root, scaled_inverse
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import FEWEST_LEFT, PoseFit
from footcal_cli.core.pose.problem import Problem
from footcal_cli.core.pose.slow_noise import SlowNoise

SHOWN_OF = tuple((i, j) for i in range(6) for j in range(6) if i // 3 == j // 3)
"""Forces show in forces and torques in torques; across, it is a place of the hip."""


@dataclass(frozen=True)
class ReadingError:
    """What explains most of all slopes that were tried.

    Parameters
    ----------
    leg
        Number of the leg.
    shown, of
        Reading that is off, and the reading that it follows: the same one for a gain.
    size, sd
        ``w_shown = w + size · w_of``, no unit.
    share
        Of the residual's square that it removes.
    p
        Chance of so much in any of the slopes without a fault; 1 where nothing is left to judge by.
    """

    leg: int
    shown: int
    of: int
    size: float
    sd: float
    share: float
    p: float


def likeliest_reading_error(
    data: PoseData,
    legs: tuple[LegKnowledge, ...],
    noise_sd: FloatArray,
    fit: PoseFit,
    slow: SlowNoise | None = None,
) -> ReadingError | None:
    """The slope that explains most of what a fit leaves; None where nothing is left to judge by.

    Parameters
    ----------
    legs, noise_sd
        The fit was made with.
    slow
        How its noise lasts from pose to pose.
    """
    if fit.left <= FEWEST_LEFT:
        return None
    law = slow or SlowNoise()
    factor = 1.0 if fit.options.noise_known else fit.noise_factor
    problem = Problem.of(law.summarise(data), legs, noise_sd, fit.options)
    state, matrix = problem.at(fit.mounting, factor), fit.matrix
    noise = factor**2 * problem.noise
    root = inverse_root((matrix * noise) @ matrix.T)
    features, _ = law.whitened(data.features())
    error = features @ matrix.T @ root.T
    clean = features - (error @ root @ matrix) * noise
    free = np.einsum("nef,pf->npe", state.slopes, clean).reshape(len(state.slopes), -1)
    inverse = scaled_inverse(free @ free.T + state.prior, 1e-14)
    tried = [(k, i, j) for k in range(len(legs)) for i, j in SHOWN_OF]
    columns = np.stack(
        [
            np.outer(
                clean[:, 6 * k + j] - fit.mounting.offset[k, j] * clean[:, -1],
                root @ matrix[:, 6 * k + i],
            ).ravel()
            for k, i, j in tried
        ]
    )
    across = columns @ free.T
    own = np.sum(columns**2, axis=1)
    information = own - np.einsum("ij,jk,ik->i", across, inverse, across)
    seen = information > 1e-9 * own
    information = np.where(seen, information, 1.0)
    size = np.where(seen, columns @ error.ravel() / information, 0.0)
    gain = size**2 * information
    best, left = int(np.argmax(gain)), error.ravel()
    total = float(left @ left)
    if not total > 0.0:
        return None
    left = left - size[best] * (columns[best] - across[best] @ inverse @ free)
    scale = max(float(left @ left), np.finfo(float).eps * total) / (fit.left - 1)
    p = len(tried) * float(f_distribution.sf(gain[best] / scale, 1, fit.left - 1))
    share = max(1.0 - float(left @ left) / total, 0.0)
    sd = float(np.sqrt(scale / information[best]))
    return ReadingError(*tried[best], float(size[best]), sd, share, min(p, 1.0))
