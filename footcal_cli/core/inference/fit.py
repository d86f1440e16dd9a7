"""Residuals to a maximum a posteriori fit with covariance.

Every fit minimises ``½ ‖r(θ)‖² + ½ (θ − θ₀)ᵀ P₀⁻¹ (θ − θ₀)`` with r in units of its own noise and
P₀ the joint covariance of an earlier calibration, so that the inverse of the normal matrix at the
solution is the covariance of θ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import least_squares

from footcal_cli.core.inference.linear import inverse_root
from footcal_cli.core.parameters import Estimates, FloatArray, ParameterSet, Status

Loss = Literal["linear", "soft_l1", "huber", "cauchy"]

PRIOR_KEPT_RATIO = 0.95
"""A parameter whose sd stays above this share of its prior sd has learnt nothing."""
_BOUND_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Fit:
    """A fit and its health.

    Parameters
    ----------
    estimates
        Values, covariance and status per parameter.
    residuals
        ``r(θ̂)`` without the prior rows, shape (m,), in units of the noise.
    jacobian
        ``dr/dθ`` of the free parameters at the solution, shape (m, n_free).
    rank
        Directions the data alone determine.
    singular_values
        Of the Jacobian with columns in units of `Parameter.step`, largest first.
    noise_factor
        Estimated noise over assumed noise, ``sqrt(‖r‖² / dof)``.
    converged
        Whether the optimiser met its tolerances.
    """

    estimates: Estimates
    residuals: FloatArray
    jacobian: FloatArray
    rank: int
    singular_values: FloatArray
    noise_factor: float
    converged: bool


def numeric_jacobian(
    function: Callable[[FloatArray], FloatArray], theta: FloatArray, steps: FloatArray
) -> FloatArray:
    """Central differences ``(f(θ + h) − f(θ − h)) / 2h``, shape (m, n), error O(h²)."""
    columns = []
    for i, step in enumerate(steps):
        up, down = theta.copy(), theta.copy()
        up[i] += step
        down[i] -= step
        columns.append((function(up) - function(down)) / (2.0 * step))
    return np.stack(columns, axis=-1) if columns else np.empty((function(theta).size, 0))


def fit_map(
    residual: Callable[[FloatArray], FloatArray],
    parameters: ParameterSet,
    *,
    jacobian: Callable[[FloatArray], FloatArray] | None = None,
    loss: Loss = "linear",
    noise_known: bool = True,
    max_evaluations: int = 200,
    start: FloatArray | None = None,
    linear: bool = False,
) -> Fit:
    """Fit the free parameters to residuals, keeping to their priors and bounds.

    Parameters
    ----------
    residual
        Maps all parameters (n,) to residuals (m,) in units of their noise.
    parameters
        Start, prior, bounds and freedom of each parameter.
    jacobian
        ``dr/dθ`` of all parameters, shape (m, n); central differences where absent.
    loss
        SciPy's robust losses act on the data rows *and* the prior rows alike.
    noise_known
        False: scale the covariance by the estimated noise (no absolute noise level is known).
    start
        Where the optimiser starts, all parameters (n,), inside the bounds; the prior means where
        absent. Fixed parameters stay at their value.
    linear
        Residuals are linear in the parameters: one step from the prior means is exact.
    """
    free = parameters.free
    centre = parameters.values
    chosen = [p for p in parameters if p.free]
    steps = np.array([p.step for p in chosen])
    prior_sd = np.array([p.sd for p in chosen])
    has_prior = np.isfinite(prior_sd)
    lower = np.array([p.lower for p in chosen])
    upper = np.array([p.upper for p in chosen])

    def full(z: FloatArray) -> FloatArray:
        theta = centre.copy()
        theta[free] = centre[free] + steps * z
        return theta

    def in_steps(z: FloatArray) -> FloatArray:
        return residual(full(z))

    prior_rows = np.diag(steps / prior_sd)[has_prior]
    if parameters.correlation is not None:
        known = parameters.correlation[np.ix_(free, free)][np.ix_(has_prior, has_prior)]
        prior_rows = inverse_root(known) @ prior_rows

    def stacked(z: FloatArray) -> FloatArray:
        return np.concatenate([residual(full(z)), prior_rows @ z])

    def data_jacobian(z: FloatArray) -> FloatArray:
        if jacobian is not None:
            return np.asarray(jacobian(full(z))[:, free] * steps)
        return numeric_jacobian(in_steps, z, np.full(z.size, 1e-4))

    def stacked_jacobian(z: FloatArray) -> FloatArray:
        return np.vstack([data_jacobian(z), prior_rows])

    bounds = (lower - centre[free]) / steps, (upper - centre[free]) / steps
    z: FloatArray = np.zeros(len(chosen))
    converged = linear
    if linear:
        z = np.asarray(np.linalg.lstsq(stacked_jacobian(z), -stacked(z), rcond=None)[0])
    if not linear or np.any(z < bounds[0]) or np.any(z > bounds[1]):
        solution = least_squares(
            stacked,
            np.zeros(len(chosen)) if start is None else (start - centre)[free] / steps,
            jac=stacked_jacobian,
            bounds=bounds,
            loss=loss,
            xtol=1e-12,
            ftol=1e-12,
            gtol=1e-12,
            max_nfev=max_evaluations,
        )
        z, converged = solution.x, bool(solution.success)
    theta = full(z)
    residuals = residual(theta)
    scaled = data_jacobian(z)
    singular_values: FloatArray = np.asarray(np.linalg.svd(scaled, compute_uv=False))
    tolerance = max(scaled.shape) * np.finfo(float).eps * max(singular_values, default=0.0)
    rank = int(np.sum(singular_values > tolerance))
    dof = max(residuals.size - rank, 1)
    noise_factor = float(np.sqrt(residuals @ residuals / dof))

    information = scaled.T @ scaled / (1.0 if noise_known else noise_factor**2)
    information += prior_rows.T @ prior_rows
    free_cov = np.linalg.pinv(information, hermitian=True) * np.outer(steps, steps)
    covariance = np.zeros((len(parameters), len(parameters)))
    covariance[np.ix_(free, free)] = free_cov
    unseen = _unseen(scaled, has_prior)
    status = []
    position = 0
    for parameter, value in zip(parameters, theta, strict=True):
        if not parameter.free:
            status.append(Status.FIXED)
            continue
        width = steps[position]
        learnt = np.sqrt(free_cov[position, position]) < PRIOR_KEPT_RATIO * parameter.sd
        if min(value - parameter.lower, parameter.upper - value) <= _BOUND_TOLERANCE * width:
            status.append(Status.AT_BOUND)
        elif unseen[position] or not learnt:
            status.append(Status.PRIOR_KEPT)
        else:
            status.append(Status.ESTIMATED)
        position += 1
    return Fit(
        estimates=Estimates(
            parameters.names,
            tuple(p.unit for p in parameters),
            theta,
            covariance,
            tuple(status),
        ),
        residuals=residuals,
        jacobian=scaled / steps,
        rank=rank,
        singular_values=singular_values,
        noise_factor=noise_factor,
        converged=converged,
    )


def _unseen(scaled_jacobian: FloatArray, has_prior: np.ndarray) -> np.ndarray:
    """Parameters without a prior that take part in a direction the data cannot see."""
    if has_prior.all():
        return ~has_prior
    # The triangular factor has the same right singular vectors and no row per sample.
    triangle = np.linalg.qr(scaled_jacobian, mode="r")
    _, singular_values, right = np.linalg.svd(triangle, full_matrices=True)
    tolerance = max(scaled_jacobian.shape) * np.finfo(float).eps * max(singular_values, default=0.0)
    null = right[int(np.sum(singular_values > tolerance)) :]
    return np.asarray((np.abs(null) > 1e-6).any(axis=0) & ~has_prior)
