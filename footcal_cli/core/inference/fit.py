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
from scipy.linalg.lapack import dtrtrs
from scipy.optimize import least_squares

from footcal_cli.core.inference.linear import inverse_root
from footcal_cli.core.parameters import BoolArray, Estimates, FloatArray, ParameterSet, Status

Loss = Literal["linear", "soft_l1", "huber", "cauchy"]

PRIOR_KEPT_RATIO = 0.95
"""A parameter whose sd stays above this share of its prior sd has learnt nothing."""
_BOUND_TOLERANCE = 1e-9
_MOST_EVALUATIONS = 200
_MOST_STEPS, _DEPENDENT = 30, 1e-12
_LAST_STEP = 1e-14
"""Square of a step's length in sd of the parameters, up to which a next one is not taken."""


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
    start
        Where the optimiser starts, all parameters (n,), inside the bounds; the prior means where
        absent. Fixed parameters stay at their value.
    linear
        Residuals are linear in the parameters: one step from the prior means is exact.
    """
    scaled = _Scaled.of(parameters)

    def stacked(z: FloatArray) -> FloatArray:
        return np.concatenate([residual(scaled.full(z)), scaled.prior_rows @ z])

    def data_jacobian(z: FloatArray) -> FloatArray:
        if jacobian is not None:
            return np.asarray(jacobian(scaled.full(z))[:, scaled.free] * scaled.steps)
        return numeric_jacobian(lambda at: residual(scaled.full(at)), z, np.full(z.size, 1e-4))

    def stacked_jacobian(z: FloatArray) -> FloatArray:
        return np.vstack([data_jacobian(z), scaled.prior_rows])

    z: FloatArray = np.zeros(scaled.steps.size)
    converged = linear
    if linear:
        z = np.asarray(np.linalg.lstsq(stacked_jacobian(z), -stacked(z), rcond=None)[0])
    begin = np.zeros(z.size) if start is None else scaled.steps_to(start)
    if not linear and loss == "linear" and jacobian is not None and scaled.is_unbounded:
        found = _gauss_newton(stacked, stacked_jacobian, begin)
        converged = found is not None
        z = z if found is None else found
    if not converged or np.any(z < scaled.bounds[0]) or np.any(z > scaled.bounds[1]):
        solution = least_squares(
            stacked,
            begin,
            jac=stacked_jacobian,
            bounds=scaled.bounds,
            loss=loss,
            xtol=1e-12,
            ftol=1e-12,
            gtol=1e-12,
            max_nfev=_MOST_EVALUATIONS,
        )
        z, converged = solution.x, bool(solution.success)
    return _judged(parameters, scaled, z, residual(scaled.full(z)), data_jacobian(z),
                   converged=converged)  # fmt: skip


def _gauss_newton(
    residual: Callable[[FloatArray], FloatArray],
    jacobian: Callable[[FloatArray], FloatArray],
    begin: FloatArray,
) -> FloatArray | None:
    """Least squares by full steps; None where one leads uphill, or a direction is not seen.

    A tenth of what a trust region costs where residuals are nearly linear. Steps are taken by QR:
    what only a wide prior holds would be lost in normal equations.
    """
    z, left, before = begin, residual(begin), 0.0
    cost = float(left @ left)
    for _ in range(_MOST_STEPS):
        rows = np.column_stack([jacobian(z), left])
        triangle = np.asarray(np.linalg.qr(rows, mode="r"))[: z.size]
        size = np.abs(np.diag(triangle))
        if size.size < z.size or not size.min() > _DEPENDENT * size.max():
            return None
        step, _ = dtrtrs(triangle[:, :-1], triangle[:, -1])
        z = z - step
        promised = float(triangle[:, -1] @ triangle[:, -1])
        rounding = np.finfo(float).eps ** 2 * rows.size * cost
        # near the minimum each step is shorter than the one before by the same factor, or more
        ratio = min(promised / before, 1.0) if before else 1.0
        if promised * ratio <= max(_LAST_STEP, rounding):
            return np.asarray(z)
        left, cost_before = residual(z), cost
        cost, before = float(left @ left), promised
        if not cost <= cost_before:
            return None
    return None


def least_squares_alone(
    residual: Callable[[FloatArray], FloatArray], start: FloatArray, tolerance: float
) -> FloatArray:
    """Parameters of the least sum of squares, shape (n,): no prior, no weights, no covariance.

    What a paper minimises as printed; `fit_map` serves the rest.

    Parameters
    ----------
    residual
        Maps parameters (n,) to residuals (m,).
    tolerance
        Relative change of the sum of squares at which to stop.
    """
    return np.asarray(least_squares(residual, start, ftol=tolerance).x)


@dataclass(frozen=True)
class _Scaled:
    """The free parameters as z, in units of their steps about their prior means.

    Parameters
    ----------
    free
        Which parameters z stands for, shape (n,); it has n_free numbers.
    centre
        Prior means of all parameters, shape (n,).
    steps
        Of the free ones, shape (n_free,).
    has_prior
        Whether their prior is finite, shape (n_free,).
    prior_rows
        ``P₀^(−1/2)`` of those that have one, in units of the steps.
    bounds
        Lower and upper ones of z.
    """

    free: BoolArray
    centre: FloatArray
    steps: FloatArray
    has_prior: BoolArray
    prior_rows: FloatArray
    bounds: tuple[FloatArray, FloatArray]

    @classmethod
    def of(cls, parameters: ParameterSet) -> _Scaled:
        free, centre = parameters.free, parameters.values
        chosen = [p for p in parameters if p.free]
        steps, prior_sd, lower, upper = (
            np.array([getattr(p, name) for p in chosen])
            for name in ("step", "sd", "lower", "upper")
        )
        has_prior = np.isfinite(prior_sd)
        prior_rows = np.diag(steps / prior_sd)[has_prior]
        if parameters.correlation is not None:
            known = parameters.correlation[np.ix_(free, free)][np.ix_(has_prior, has_prior)]
            prior_rows = inverse_root(known) @ prior_rows
        bounds = (lower - centre[free]) / steps, (upper - centre[free]) / steps
        return cls(free, centre, steps, has_prior, prior_rows, bounds)

    @property
    def is_unbounded(self) -> bool:
        """Whether no parameter has a bound."""
        return not np.isfinite(self.bounds).any()

    def full(self, z: FloatArray) -> FloatArray:
        """All parameters, shape (n,)."""
        theta = self.centre.copy()
        theta[self.free] = self.centre[self.free] + self.steps * z
        return theta

    def steps_to(self, theta: FloatArray) -> FloatArray:
        """The z that leads to all parameters (n,)."""
        return np.asarray((theta - self.centre)[self.free] / self.steps)


def _judged(
    parameters: ParameterSet,
    scaled: _Scaled,
    z: FloatArray,
    residuals: FloatArray,
    jacobian: FloatArray,
    *,
    converged: bool,
) -> Fit:
    """The fit at its solution z with covariance, rank and status; `jacobian` is by z."""
    theta, free, steps = scaled.full(z), scaled.free, scaled.steps
    singular_values: FloatArray = np.asarray(np.linalg.svd(jacobian, compute_uv=False))
    tolerance = max(jacobian.shape) * np.finfo(float).eps * max(singular_values, default=0.0)
    rank = int(np.sum(singular_values > tolerance))
    dof = max(residuals.size - rank, 1)
    noise_factor = float(np.sqrt(residuals @ residuals / dof))

    information = jacobian.T @ jacobian
    information += scaled.prior_rows.T @ scaled.prior_rows
    free_cov = np.linalg.pinv(information, hermitian=True) * np.outer(steps, steps)
    covariance = np.zeros((len(parameters), len(parameters)))
    covariance[np.ix_(free, free)] = free_cov
    return Fit(
        estimates=Estimates(
            parameters.names,
            tuple(p.unit for p in parameters),
            theta,
            covariance,
            _status(parameters, theta, np.sqrt(np.diag(free_cov)),
                    _unseen(jacobian, scaled.has_prior)),
        ),
        residuals=residuals,
        jacobian=jacobian / steps,
        rank=rank,
        singular_values=singular_values,
        noise_factor=noise_factor,
        converged=converged,
    )  # fmt: skip


def _status(
    parameters: ParameterSet, theta: FloatArray, sd: FloatArray, unseen: BoolArray
) -> tuple[Status, ...]:
    """What became of every parameter; `sd` and `unseen` are of the free ones."""
    status = []
    of_free = iter(zip(sd, unseen, strict=True))
    for parameter, value in zip(parameters, theta, strict=True):
        if not parameter.free:
            status.append(Status.FIXED)
            continue
        own_sd, hidden = next(of_free)
        margin = min(value - parameter.lower, parameter.upper - value)
        if margin <= _BOUND_TOLERANCE * parameter.step:
            status.append(Status.AT_BOUND)
        elif hidden or not own_sd < PRIOR_KEPT_RATIO * parameter.sd:
            status.append(Status.PRIOR_KEPT)
        else:
            status.append(Status.ESTIMATED)
    return tuple(status)


def _unseen(scaled_jacobian: FloatArray, has_prior: BoolArray) -> BoolArray:
    """Parameters without a prior that take part in a direction the data cannot see."""
    if has_prior.all():
        return ~has_prior
    # The triangular factor has the same right singular vectors and no row per sample.
    triangle = np.linalg.qr(scaled_jacobian, mode="r")
    _, singular_values, right = np.linalg.svd(triangle, full_matrices=True)
    tolerance = max(scaled_jacobian.shape) * np.finfo(float).eps * max(singular_values, default=0.0)
    null = right[int(np.sum(singular_values > tolerance)) :]
    return np.asarray((np.abs(null) > 1e-6).any(axis=0) & ~has_prior)
