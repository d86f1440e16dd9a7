"""The cost of a mounting on the Gram matrix of the poses, and its derivatives.

With ``S = Σ x xᵀ`` the cost is ``½ tr(W M S Mᵀ)`` plus priors, its gradient ``⟨dM, W M S Fᵀ⟩``
with ``F = I − N Mᵀ W M``; everything has the size of M, whatever the number of poses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.inference.descent import Descent, descend
from footcal_cli.core.inference.linear import inverse_root, regressed
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import Geometry, PoseSummary
from footcal_cli.core.pose.hanging import HangRows, LegKnowledge
from footcal_cli.core.pose.model import (
    Mounting,
    Structure,
    balance_derivative,
    free_columns,
    moved,
    transforms,
)
from footcal_cli.core.pose.residual import StandingResidual
from footcal_cli.core.spatial import rotation_log

_STEPS_LEFT = 30.0


@dataclass(frozen=True)
class PoseOptions:
    """What may be asked of a standing fit.

    Parameters
    ----------
    errors_in_variables
        False: plain least squares with the weights of the nominal mounting, for comparison.
    translation_sd_m
        Prior sd of each hip's own translation; ``inf``: none.
    com_sd_m
        Prior sd of the chassis CoM (shared by all hips).
    rotation_sd_rad
        Prior sd of each mounting rotation; ``inf``: none.
    robot_weight_sd_n
        Of the scale that weighed the robot.
    noise_known
        False: the sensors' noise is only known up to a factor, which the fit estimates.
    attitude_sd_rad
        Of the logged attitude of a pose; the factor is its own, too.
    """

    structure: Structure = Structure.FULL
    errors_in_variables: bool = True
    translation_sd_m: float = np.inf
    com_sd_m: float = np.inf
    rotation_sd_rad: float = np.inf
    robot_weight_sd_n: float = 0.05
    noise_known: bool = True
    attitude_sd_rad: float = 0.0


def feature_noise(noise_sd: FloatArray, attitude_sd_rad: float) -> FloatArray:
    """Variances of the features ``[w_1 … w_K, ĝ, 1]`` of a pose, shape (6K + 4,)."""
    gravity = [attitude_sd_rad**2] * 3
    return np.concatenate([np.square(noise_sd).ravel(), gravity, [0.0]])


def start_mounting(
    geometry: Geometry, legs: tuple[LegKnowledge, ...], robot_weight_n: float
) -> tuple[Mounting, HangRows]:
    """Nominal mounting with the offsets and weights of the hanging logs, and their rows."""
    rows, directions = HangRows.of(geometry, legs)
    count = len(legs)
    return Mounting(
        np.broadcast_to(np.eye(3), (count, 3, 3)).copy(),
        np.zeros((count, 3)),
        np.stack([leg.offset for leg in legs]),
        np.array([leg.weight_n for leg in legs]),
        robot_weight_n,
        directions,
    ), rows


@dataclass(frozen=True)
class PoseState:
    """Cost and gradient by the free unknowns at one mounting, and what curvature is made of.

    Parameters
    ----------
    slopes
        ``W^½ dM/dθ`` of the free unknowns that move the balance, which are the first of the n,
        shape (≤ n, 6, 6K + 4).
    seen, own
        Gram matrix of the wrenches closest to the measured ones that balance, with and without
        the part that is noise.
    prior
        Curvature of priors and hanging rows.
    """

    cost: float
    chi2_poses: float
    chi2_hang: float
    gradient: FloatArray
    slopes: FloatArray
    seen: FloatArray
    own: FloatArray
    prior: FloatArray

    def score(self) -> FloatArray:
        """Covariance of the gradient's noise."""
        return self._metric(self.seen) + self.prior

    def hessian(self) -> FloatArray:
        """Expected curvature; that of the noisy wrenches where noise leaves it indefinite."""
        wanted = self._metric(self.own) + self.prior
        try:
            np.linalg.cholesky(wanted)
        except np.linalg.LinAlgError:
            return self.score()
        return wanted

    def _metric(self, middle: FloatArray) -> FloatArray:
        count = self.slopes.shape[0]
        right = (self.slopes.reshape(-1, middle.shape[0]) @ middle).reshape(count, -1)
        metric = np.zeros_like(self.prior)
        metric[:count, :count] = self.slopes.reshape(count, -1) @ right.T
        return metric


@dataclass(frozen=True)
class PoseCost:
    """The cost over the free unknowns.

    `noise` is the block-diagonal covariance N of the features (6K + 4,), as its diagonal;
    `precision` the prior over all unknowns (13K + 1 + 2L,) squared; `columns` ties and drops
    unknowns, None where all of them are free.
    """

    summary: PoseSummary
    balance: StandingResidual
    hang: HangRows
    start: Mounting
    noise: FloatArray
    precision: FloatArray
    columns: FloatArray | None
    options: PoseOptions

    @classmethod
    def of(
        cls,
        summary: PoseSummary,
        legs: tuple[LegKnowledge, ...],
        noise_sd: FloatArray,
        options: PoseOptions,
    ) -> PoseCost:
        """Set up priors, hanging rows and the free unknowns."""
        start, hang = start_mounting(summary.geometry, legs, summary.robot_weight_n)
        count = len(legs)
        noise = feature_noise(noise_sd, options.attitude_sd_rad)
        total = 13 * count + 1 + 2 * hang.logs
        precision = np.zeros((total, total))
        turns = np.arange(3 * count)
        precision[turns, turns] = options.rotation_sd_rad**-2
        shifts = slice(3 * count, 6 * count)
        if np.isfinite(options.translation_sd_m):
            together = np.kron(np.ones((count, count)), np.eye(3))
            # The shared CoM without a prior of its own: wide enough to say nothing.
            own, common = options.translation_sd_m**2, min(options.com_sd_m, 10.0) ** 2
            # inverse of own · 1 + common · together
            share = common / (own + count * common)
            precision[shifts, shifts] = (np.eye(3 * count) - share * together) / own
        precision[13 * count, 13 * count] = options.robot_weight_sd_n**-2
        columns = None
        if options.structure is not Structure.FULL:
            columns = free_columns(options.structure, count, 2 * hang.logs)
        balance = StandingResidual.of(summary.geometry)
        return cls(summary, balance, hang, start, noise, precision, columns, options)

    def prior_sd(self) -> FloatArray:
        """Sd of every unknown before the poses, shape (13K + 1,)."""
        count = self.start.turn_b.shape[0]
        sd = np.full(13 * count + 1, np.inf)
        sd[: 3 * count] = self.options.rotation_sd_rad
        sd[3 * count : 6 * count] = np.hypot(self.options.translation_sd_m, self.options.com_sd_m)
        for k, leg in enumerate(self.hang.legs):
            own = np.sqrt(np.diag(leg.covariance))
            sd[6 * count + 6 * k : 6 * count + 6 * k + 6] = own[:6]
            sd[12 * count + k] = own[6]
        sd[-1] = self.options.robot_weight_sd_n
        return sd

    def at(self, mounting: Mounting, factor: float) -> PoseState:
        """Everything at one mounting, the sensors' noise scaled by `factor`."""
        geometry, structure = self.summary.geometry, self.options.structure
        count = mounting.turn_b.shape[0]
        matrix = self.balance.matrix(mounting, structure)
        noise = factor**2 * self.noise
        weigh = matrix
        if not self.options.errors_in_variables:
            weigh = np.zeros_like(matrix)
            nominal = transforms(geometry, self.start, structure)
            weigh[:, : 6 * count] = np.moveaxis(nominal, 0, 1).reshape(6, -1)
        root = inverse_root((weigh * noise) @ weigh.T)
        weight = root.T @ root
        gram, poses = self.summary.gram, self.summary.poses
        weighed = weight @ matrix @ gram
        chi2_poses = float(np.sum(weighed * matrix))
        seen = own = gram
        if self.options.errors_in_variables:
            spread = matrix.T @ weight @ matrix
            clean = np.eye(noise.size) - noise[:, None] * spread
            weighed = weighed @ clean.T
            seen = clean @ gram @ clean.T
            own = seen - poses * (np.diag(noise) - noise[:, None] * spread * noise)
        derivative = balance_derivative(geometry, mounting, structure)
        unknowns, features = derivative.shape[0], derivative.shape[2]
        gradient = np.zeros(self.precision.shape[0])
        gradient[:unknowns] = derivative.reshape(unknowns, -1) @ weighed.ravel()
        free = (root @ derivative).reshape(unknowns, -1)

        rows, slope = self.hang.rows(geometry, mounting, mounting.tangent)
        away = self._away(mounting)
        gradient += slope.T @ rows + self.precision @ away
        prior = slope.T @ slope + self.precision
        if self.columns is not None:
            free, gradient = self.columns[:unknowns].T @ free, self.columns.T @ gradient
            prior = self.columns.T @ prior @ self.columns
        chi2_hang = float(rows @ rows)
        return PoseState(
            0.5 * (chi2_poses + chi2_hang + float(away @ self.precision @ away)),
            chi2_poses,
            chi2_hang,
            gradient,
            free.reshape(-1, 6, features),
            seen,
            own,
            prior,
        )

    def _away(self, mounting: Mounting) -> FloatArray:
        """Distance from the start in the prior's coordinates."""
        start = self.start
        return np.concatenate(
            [
                rotation_log(mounting.turn_b).ravel(),
                (mounting.shift_b_m - start.shift_b_m).ravel(),
                np.zeros(mounting.offset.size + mounting.leg_weight_n.size),
                [mounting.robot_weight_n - start.robot_weight_n],
                np.zeros(2 * self.hang.logs),
            ]
        )

    def solve(
        self,
        mounting: Mounting,
        factor: float,
        most_steps: int = 100,
        beyond: float = np.inf,
    ) -> Descent[Mounting, PoseState]:
        """Descend from a mounting; the work does not depend on the number of poses.

        Parameters
        ----------
        beyond
            Given up where `PoseState.chi2_poses` will stay above this. A step changes its root by
            at most the length of the step in the metric of the curvature, √(2 · what it promises):
            at a linear rate of 0.97, all further ones together are as long as 30 of that.
        """

        def move(point: Mounting, step: FloatArray) -> Mounting:
            return moved(point, self.whole(step), point.tangent)

        def hopeless(state: PoseState, promised: float) -> bool:
            left = np.sqrt(max(state.chi2_poses, 0.0)) - np.sqrt(beyond)
            return bool(left > _STEPS_LEFT * np.sqrt(2.0 * max(promised, 0.0)))

        return descend(
            lambda point: self.at(point, factor), move, mounting, most_steps,
            hopeless if np.isfinite(beyond) else None,
        )  # fmt: skip

    def whole(self, free: FloatArray) -> FloatArray:
        """All unknowns of the free ones, shape (13K + 1 + 2L,)."""
        return free if self.columns is None else np.asarray(self.columns @ free)

    def covariance(self, mounting: Mounting, state: PoseState) -> tuple[FloatArray, int, int]:
        """Sandwich ``H⁻¹ B H⁻¹``: curvature from the true wrenches, score with their noise."""
        hessian, score = state.hessian(), state.score()
        inverse = regressed(hessian, np.eye(len(hessian)), 1e-14)
        middle = inverse @ score @ inverse
        full = middle if self.columns is None else self.columns @ middle @ self.columns.T
        size = 13 * mounting.turn_b.shape[0] + 1
        free = self.options.structure.freedom(mounting.turn_b.shape[0])
        part = (score - state.prior)[:free, :free]
        unit = 1.0 / np.sqrt(np.maximum(np.diag(part), np.finfo(float).tiny))
        values = np.linalg.eigvalsh(part * np.outer(unit, unit))
        rank = int(np.sum(values > 1e-10 * values[-1]))
        return full[:size, :size], rank, free
