"""Which mounting errors are there: five candidate models on the same poses ([Wu], IV-2).

Two yardsticks side by side. The paper's: mean held-out squared error in its K-norm, and
``BIC = P ln(RSS/P) + DOF ln P``, which counts P residuals although there are 6 P. And the one used
here to choose: ``χ² + DOF ln(6 P)`` with each pose's error in units of the noise that the fitted
mounting makes of the sensors' noise, and the hanging logs counted too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.inference.held_out import folds
from footcal_cli.core.inference.linear import inverse_root
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData, PoseSummary, summarise
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import FEWEST_LEFT, PAPER_NORM, PoseFit, fit_pose
from footcal_cli.core.pose.model import Structure
from footcal_cli.core.pose.problem import PoseOptions, feature_noise

FOLDS = 5


@dataclass(frozen=True)
class Candidate:
    """One model of the mounting errors, and what the evidence says of it.

    Parameters
    ----------
    fit
        On all poses.
    freedom
        Degrees of freedom (36, 21, 21, 18 or 3 for six legs).
    cv_square
        Mean held-out squared error per pose by axis, body frame, shape (6,), N² and (Nm)².
    cv_chi2
        Mean held-out squared error per pose in units of the noise; 6 if all is explained.
    bic_paper
        From `cv_error`, as Table I of [Wu].
    bic
        With the right counts; the lowest is chosen.
    """

    fit: PoseFit
    freedom: int
    cv_square: FloatArray
    cv_chi2: float
    bic_paper: float
    bic: float

    @property
    def cv_error(self) -> float:
        """Mean held-out squared error per pose in the paper's K-norm."""
        return float(PAPER_NORM @ self.cv_square)

    @property
    def structure(self) -> Structure:
        """Which errors were free."""
        return self.fit.options.structure


def bic_paper(mean_squared_error: float, freedom: int, poses: int) -> float:
    """``P ln(RSS/P) + DOF ln P`` ([Wu], section IV-2)."""
    return float(poses * np.log(mean_squared_error) + freedom * np.log(poses))


def compare_structures(
    data: PoseData,
    legs: tuple[LegKnowledge, ...],
    noise_sd: FloatArray,
    options: PoseOptions | None = None,
    most: int = FOLDS,
) -> tuple[Candidate, ...]:
    """All five candidates, the chosen one first, then by evidence.

    Parameters
    ----------
    legs, noise_sd
        As for `fit_pose`.
    options
        Priors and method; the structure is replaced by each candidate's.
    most
        Number of held-out parts; poses of one block stay together.
    """
    asked = options or PoseOptions()
    whole, parts = _parts(data, most)
    fits = [
        fit_pose(whole, legs, noise_sd, replace(asked, structure=structure))
        for structure in Structure
    ]
    richest = fits[list(Structure).index(Structure.FULL)]
    scale = _level(richest)
    candidates = [_judged(fit, whole, parts, legs, noise_sd, scale) for fit in fits]
    return tuple(sorted(candidates, key=lambda candidate: candidate.bic))


def cross_validated(
    data: PoseData,
    legs: tuple[LegKnowledge, ...],
    noise_sd: FloatArray,
    fit: PoseFit,
    most: int = FOLDS,
) -> Candidate:
    """One fit, with the priors it was made with, judged like the candidates."""
    whole, parts = _parts(data, most)
    return _judged(fit, whole, parts, legs, noise_sd, _level(fit))


def _parts(data: PoseData, most: int) -> tuple[PoseSummary, list[PoseSummary]]:
    """All poses, and the held-out parts."""
    whole = summarise(data)
    parts = [summarise(data, np.flatnonzero(out)) for out in folds(data.block, most)]
    return whole, [part for part in parts if part.poses < whole.poses]


def _misfit(fit: PoseFit) -> float:
    """Squared pose residuals in units of the assumed noise, the same for every candidate.

    Where the noise level is estimated, `chi2_poses` is in units of each candidate's own estimate,
    by which every candidate fits alike and the poorest one would win.
    """
    return fit.chi2_poses * (1.0 if fit.options.noise_known else fit.noise_factor**2)


def _level(fit: PoseFit) -> float:
    """Variance of the noise by the misfit, in units of the assumed; 1 where too little is left."""
    return _misfit(fit) / fit.left if fit.left >= FEWEST_LEFT else 1.0


def _judged(
    fit: PoseFit,
    whole: PoseSummary,
    parts: list[PoseSummary],
    legs: tuple[LegKnowledge, ...],
    noise_sd: FloatArray,
    scale: float,
) -> Candidate:
    cv_square, cv_chi2 = _held_out(whole, parts, legs, noise_sd, fit.options)
    freedom = fit.options.structure.freedom(len(legs))
    evidence = _misfit(fit) / max(scale, np.finfo(float).tiny) + fit.chi2_hang
    return Candidate(
        fit,
        freedom,
        cv_square,
        cv_chi2,
        bic_paper(float(PAPER_NORM @ cv_square), freedom, whole.poses),
        float(evidence + freedom * np.log(6 * whole.poses)),
    )


def in_noise(error: FloatArray, noise: FloatArray) -> float:
    """Trace of ``N⁻¹ E``, also where a hip ran away so far that N is singular in floats.

    Parameters
    ----------
    error, noise
        Summed squares of balance errors, and the covariance of one, shape (6, 6).
    """
    root = inverse_root(noise)
    return float(np.trace(root @ error @ root.T))


def _held_out(
    whole: PoseSummary,
    parts: list[PoseSummary],
    legs: tuple[LegKnowledge, ...],
    noise_sd: FloatArray,
    options: PoseOptions,
) -> tuple[FloatArray, float]:
    """Held-out squared error per pose, by axis (6,) and summed in units of the noise."""
    square, chi2 = np.zeros(6), 0.0
    noise = feature_noise(noise_sd, options.attitude_sd_rad)
    for part in parts:
        matrix = fit_pose(whole.without(part), legs, noise_sd, options).matrix
        error = matrix @ part.gram @ matrix.T
        square += np.diag(error)
        chi2 += in_noise(error, (matrix * noise) @ matrix.T)
    tested = max(sum(part.poses for part in parts), 1)
    return square / tested, chi2 / tested
