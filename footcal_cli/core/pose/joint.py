"""Joint fit of the mounting from standing poses, errors in the wrenches themselves included.

The regressors are noisy wrenches. Least squares then pulls the hips inward (59 mm at 0.5 N of
noise), because a shorter lever makes noise cost less. Here each balance error is weighed by the
noise that the *present* mounting makes of the sensors' noise,

    minimise  ½ Σ_p (M x_p)ᵀ W(θ) (M x_p) + ½ priors,   W(θ)⁻¹ = Σ_k T_k(θ) N_k T_k(θ)ᵀ,

the maximum likelihood over mounting *and* true wrenches. With ``S = Σ x xᵀ`` the cost is
``½ tr(W M S Mᵀ)``, its gradient ``⟨dM, W M S Fᵀ⟩`` with ``F = I − N Mᵀ W M``, and everything the
fit needs has the size of M.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.parameters import Estimates, FloatArray, Status
from footcal_cli.core.pose.data import Geometry, PoseSummary
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.model import (
    Mounting,
    Structure,
    arms_b_m,
)
from footcal_cli.core.pose.problem import PoseCost, PoseOptions
from footcal_cli.core.pose.residual import StandingResidual, standing_names, standing_values
from footcal_cli.core.spatial import left_jacobian, rotation_log, skew

PAPER_NORM: FloatArray = np.array([1.0, 1.0, 1.0, 10.0, 10.0, 10.0])
"""The paper's K: squared errors in N and, ten times, in Nm."""
_LEARNT = 0.95
_DISAGREEING = 6.0
FEWEST_LEFT = 6
"""Equations beyond the unknowns (those of one pose) from which a misfit shows the noise's level."""


@dataclass(frozen=True)
class PoseFit:
    """Mounting of all transducers, with covariance.

    Parameters
    ----------
    geometry, options
        As asked.
    covariance
        Of rotations (body axes, left perturbation), shifts, offsets, leg weights, robot weight,
        in this order, shape (13K + 1, 13K + 1).
    prior_sd
        Sd before the poses, shape (13K + 1,).
    chi2_poses, chi2_hang
        Squared residuals in units of the (assumed) noise.
    noise_factor
        Estimated noise over assumed noise; at least 1 where it is not known and fewer than
        `FEWEST_LEFT` equations are left to estimate it from.
    poses, iterations, converged
        Health of the fit.
    rank, free
        Directions the poses alone determine, of how many free ones (offsets and weights, known
        from hanging, not counted).
    """

    geometry: Geometry
    options: PoseOptions
    mounting: Mounting
    covariance: FloatArray
    prior_sd: FloatArray
    chi2_poses: float
    chi2_hang: float
    noise_factor: float
    poses: int
    iterations: int
    converged: bool
    rank: int
    free: int

    @property
    def left(self) -> int:
        """Equations beyond the free mounting errors: what the poses can be checked by."""
        return 6 * self.poses - self.options.structure.freedom(len(self.geometry.legs))

    @property
    def matrix(self) -> FloatArray:
        """The balance matrix M at the solution, shape (6, 6K + 4)."""
        balance = StandingResidual.of(self.geometry)
        return balance.matrix(self.mounting, self.options.structure)

    @property
    def rot_bt(self) -> FloatArray:
        """Calibrated rotation transducer to body, shape (K, 3, 3)."""
        return self.mounting.turn_b @ self.geometry.rot_bt

    @property
    def arm_b_m(self) -> FloatArray:
        """Calibrated chassis CoM to hip, shape (K, 3): what the balance sees, free of gauge."""
        return arms_b_m(self.geometry, self.mounting, self.options.structure)

    def estimates(self) -> Estimates:
        """Named parameters with covariance.

        Both mounting errors are given along the *nominal transducer's* axes, as the effects
        ``mount_rotation`` and ``mount_translation`` have them: ``R_bt = R_nominal exp[mount_rot]``.
        ``<leg>.mount_pos_*`` is the hip's translation *minus* that of the chassis CoM: their sum
        with p_BC is all that standing can show ([Wu]: p̃ + p_BC).
        """
        geometry, mounting = self.geometry, self.mounting
        legs = len(geometry.legs)
        rotvec = rotation_log(mounting.turn_b)
        carry = np.eye(13 * legs + 1)
        for k in range(legs):
            at = slice(3 * k, 3 * k + 3)
            back = geometry.rot_bt[k].T
            carry[at, at] = np.linalg.solve(left_jacobian(rotvec[k]).T, back.T).T
            own = slice(3 * legs + 3 * k, 3 * legs + 3 * k + 3)
            carry[own, own] = back
            if self.options.structure is Structure.BODY_ROTATIONS:
                hip = mounting.turn_b[k] @ geometry.hip_b_m[k]
                carry[own, at] = -back @ skew(hip)
        values = standing_values(geometry, mounting, self.options.structure)
        names = list(standing_names(geometry.legs)[: 12 * legs])
        names += [f"{owner}.weight" for owner in (*geometry.legs, "robot")]
        units = ["rad"] * 3 * legs + ["m"] * 3 * legs + (["N"] * 3 + ["Nm"] * 3) * legs
        units += ["N"] * (legs + 1)
        covariance = carry @ self.covariance @ carry.T
        sd = np.sqrt(np.clip(np.diag(covariance), 0.0, None))
        status = tuple(self._status(s, p) for s, p in zip(sd, self.prior_sd, strict=True))
        return Estimates(tuple(names), tuple(units), values, covariance, status)

    @staticmethod
    def _status(sd: float, prior_sd: float) -> Status:
        if sd == 0.0:
            return Status.FIXED
        return Status.ESTIMATED if sd < _LEARNT * prior_sd else Status.PRIOR_KEPT


def fit_pose(
    summary: PoseSummary,
    legs: tuple[LegKnowledge, ...],
    noise_sd: FloatArray,
    options: PoseOptions | None = None,
) -> PoseFit:
    """Fit the mounting to standing poses and hanging logs together.

    Parameters
    ----------
    summary
        Poses, reduced by `summarise`.
    legs
        What hanging says of each leg, K of them.
    noise_sd
        Noise of one pose's wrench per leg and channel, shape (K, 6), N and Nm.
    """
    asked = options or PoseOptions()
    problem = PoseCost.of(summary, legs, noise_sd, asked)
    begin = _aligned(problem, summary, asked)
    factor = 1.0
    left = 6 * summary.poses - asked.structure.freedom(len(legs))
    least = 0.0 if left >= FEWEST_LEFT else 1.0
    for _ in range(1 if asked.noise_known else 3):
        found = problem.solve(begin, factor)
        mounting, state = found.point, found.state
        fewest = 1 if asked.noise_known else FEWEST_LEFT
        ratio = float(np.sqrt(max(state.chi2_poses, 0.0) / max(left, fewest)))
        if not asked.noise_known:
            factor = max(factor * ratio, least)
            state = problem.at(mounting, factor)
    covariance, rank, free = problem.covariance(mounting, state)
    return PoseFit(
        summary.geometry,
        asked,
        mounting,
        covariance,
        problem.prior_sd(),
        state.chi2_poses,
        state.chi2_hang,
        ratio if asked.noise_known else factor,
        summary.poses,
        found.steps,
        found.converged,
        rank,
        free,
    )


def misfits_of_poses(
    summary: PoseSummary,
    legs: tuple[LegKnowledge, ...],
    noise_sd: FloatArray,
    options: PoseOptions,
) -> Callable[[FloatArray, float, int], float]:
    """Squared residuals of other poses of the same robot after so many steps of `fit_pose` at most.

    Returns
    -------
    misfit
        Of the Gram matrix of the poses, `PoseSummary.gram`; of what nobody asks how much it is
        beyond: infinity there, as soon as that is clear; and of the steps.
    """
    problem = PoseCost.of(summary, legs, noise_sd, options)
    begin = _aligned(problem, summary, options)

    def misfit(gram: FloatArray, beyond: float, most_steps: int) -> float:
        other = replace(problem, summary=replace(summary, gram=gram))
        found = other.solve(begin, 1.0, most_steps, beyond)
        return np.inf if found.given_up else found.state.chi2_poses

    return misfit


def _aligned(problem: PoseCost, summary: PoseSummary, options: PoseOptions) -> Mounting:
    """Where the fit starts: transducers turned so that all legs felt one gravity when hanging."""
    begin = problem.start
    if not options.structure.rotates:
        return begin
    turn, direction = problem.hang.aligned(summary.geometry, begin.hang_dir_b)
    return replace(begin, turn_b=turn, hang_dir_b=direction)


def directions_agree(
    fit: PoseFit, without: PoseFit, legs: tuple[LegKnowledge, ...]
) -> tuple[float, bool]:
    """Whether gravity's directions from hanging are those of one rigid robot that stood so.

    They cost ``χ²_hang + 2 ln L(without) − 2 ln L(with)``, L the likelihood of the poses: where the
    level of the noise is estimated, directions that contradict the poses raise it instead of χ².
    That is for two equations per leg and log, less the robot's attitude in each log.

    Parameters
    ----------
    fit, without
        Of the same poses, with the directions and without.

    Returns
    -------
    misfit, agree
        What they cost, χ², and whether that is little.
    """
    freedom = sum(2 * leg.gravity_dir_t.shape[0] for leg in legs)
    freedom -= 2 * fit.mounting.hang_dir_b.shape[0]
    dearer = fit.chi2_poses - without.chi2_poses
    if not fit.options.noise_known:
        dearer = 2.0 * fit.left * float(np.log(fit.noise_factor / without.noise_factor))
    misfit = fit.chi2_hang + dearer
    return misfit, freedom <= 0 or misfit < freedom * _DISAGREEING
