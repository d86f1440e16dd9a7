"""Hanging logs reduced to what their likelihood needs, and the fit on it.

Each log is reduced once to the triangular factor of its regressors; from then on the fit works on
a few hundred numbers, however long the logs are, and loses nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.hang.model import HangModel, HangValues
from footcal_cli.core.hang.noise import ChannelNoise
from footcal_cli.core.hang.words import with_unseen
from footcal_cli.core.inference.fit import Fit, fit_map
from footcal_cli.core.parameters import FloatArray

_MAX_STEPS = 30
_FIRST_DAMPING = 1e-4
_DECREMENT = 1e-6
SEEN = 1e-7
"""Singular values below this share of the largest count as none."""


@dataclass(frozen=True)
class Summary:
    """All that the likelihood needs of the logs: ``‖R c − y‖²`` per log and channel.

    Parameters
    ----------
    factor
        Triangular factor R of the whitened regressors, shape (L, 6, d, d).
    target
        ``Qᵀ w`` of the whitened wrenches, shape (L, 6, d).
    extra
        How many of the d regressors are temperature and time.
    """

    factor: FloatArray
    target: FloatArray

    @classmethod
    def of(
        cls,
        designs: Sequence[FloatArray],
        wrenches: Sequence[FloatArray],
        noise: Sequence[ChannelNoise],
        triangles: Sequence[tuple[FloatArray, FloatArray]],
    ) -> Summary:
        """Reduce logs with regressors (n, d) and wrenches (n, 6), and their `triangle`."""
        columns = designs[0].shape[1]
        factor = np.zeros((len(designs), 6, columns, columns))
        target = np.zeros((len(designs), 6, columns))
        white = [channel for channel in range(6) if noise[channel].ar.size == 0]
        coloured = [channel for channel in range(6) if noise[channel].ar.size > 0]
        sd = np.array([channel.innovation_sd for channel in noise])
        for i, (z, w, (r, y)) in enumerate(zip(designs, wrenches, triangles, strict=True)):
            factor[i, white] = r / sd[white, None, None]
            target[i, white] = y.T[white] / sd[white, None]
            both = np.column_stack([z, w]) if coloured else z
            for channel in coloured:
                seen = noise[channel].whitened(both[:, [*range(columns), columns + channel]])
                factor[i, channel], own = triangle(seen[:, :-1], seen[:, -1:])
                target[i, channel] = own[:, 0]
        return cls(factor, target)

    def solve(self, model: HangModel, weight_n: float) -> FloatArray:
        """Levenberg-Marquardt from the linear fit, shape (n,); `fit` finishes and judges."""
        factor = self._factor(model)
        theta = self._start(model, factor, weight_n)
        weight = 1.0 / model.prior_sd**2
        centre = np.zeros(theta.size)
        centre[0] = weight_n
        left = self._left(model, factor, theta)
        cost = left @ left + weight @ (theta - centre) ** 2
        damping = 0.0
        for _ in range(_MAX_STEPS):
            slope = (factor @ model.coefficient_jacobian(theta)).reshape(-1, theta.size)
            normal = slope.T @ slope + np.diag(weight)
            scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
            gradient = slope.T @ left - weight * (theta - centre)
            damped = normal * np.outer(scale, scale) + damping * np.eye(theta.size)
            step = scale * np.linalg.lstsq(damped, scale * gradient, rcond=SEEN**2)[0]
            tried = self._left(model, factor, theta + step)
            tried_cost = tried @ tried + weight @ (theta + step - centre) ** 2
            if not tried_cost <= cost:
                damping = max(10.0 * damping, _FIRST_DAMPING)
                continue
            theta, left, cost, damping = theta + step, tried, tried_cost, 0.1 * damping
            if gradient @ step < _DECREMENT:
                break
        return theta

    def order_evidence(
        self, model: HangModel, theta: FloatArray, samples: float
    ) -> dict[int, float]:
        """BIC per number of harmonics up to the model's, relative to the full model's χ².

        Leaving harmonics out costs ``cᵀ cov(c)⁻¹ c`` with c their coefficients (exact to second
        order), and saves ``ln n`` per coefficient, n the effective samples of all channels.
        """
        slope = (self._factor(model) @ model.coefficient_jacobian(theta)).reshape(-1, theta.size)
        sd = model.prior_sd
        scaled = (slope.T @ slope) * np.outer(sd, sd) + np.eye(sd.size)
        covariance = np.linalg.inv(scaled) * np.outer(sd, sd)
        first = theta.size - model.tilt_design.shape[2] - 3 * model.com_columns
        evidence = {}
        for order in range(model.order + 1):
            left_out = np.concatenate(
                [
                    first + axis * model.com_columns + np.arange(1 + 2 * order, model.com_columns)
                    for axis in range(3)
                ]
            )
            part = theta[left_out]
            cost = part @ np.linalg.pinv(covariance[np.ix_(left_out, left_out)]) @ part
            evidence[order] = float(cost + (theta.size - left_out.size) * np.log(samples))
        return evidence

    def fit(self, model: HangModel, start: FloatArray, weight_n: float) -> Fit:
        """Maximum likelihood of a model whose harmonics are among the regressors."""
        factor = self._factor(model)

        def residual(theta: FloatArray) -> FloatArray:
            return -self._left(model, factor, theta)

        def jacobian(theta: FloatArray) -> FloatArray:
            table = model.coefficient_jacobian(theta)
            return np.asarray((factor @ table).reshape(self.target.size, theta.size))

        fit = fit_map(residual, model.parameters(weight_n), jacobian=jacobian, start=start)
        return with_unseen(fit)

    def _factor(self, model: HangModel) -> FloatArray:
        """The columns of the factor that belong to the model's regressors."""
        extra = model.temperature + model.drift
        total = self.factor.shape[-1]
        return np.asarray(
            self.factor[..., [*range(model.com_columns), *range(total - extra, total)]]
        )

    def _left(self, model: HangModel, factor: FloatArray, theta: FloatArray) -> FloatArray:
        """Measured minus model in units of the noise, shape (L·6·d,)."""
        seen = (factor @ model.coefficients(theta)[..., None])[..., 0]
        return np.asarray((self.target - seen).ravel())

    def _start(self, model: HangModel, factor: FloatArray, weight_n: float) -> FloatArray:
        """The linear fit without tilt: first forces for the weight, then torques for the CoM.

        Directions that the logs do not show start at the believed weight and at a centred CoM.
        """
        tilts = model.tilt_design.shape[2]
        blank = HangValues(
            1.0,
            np.zeros(6),
            np.zeros(6 * model.temperature),
            np.zeros(6 * model.drift),
            np.zeros((3, model.com_columns)),
            np.zeros((0, 3)),
        )
        theta = model.join(replace(blank, weight_n=weight_n), np.zeros(tilts))
        axis_of = np.tile(np.arange(6), 1 + model.temperature + model.drift)
        kind = np.concatenate(
            [[0], axis_of // 3, np.ones(3 * model.com_columns), np.full(tilts, 2)]
        )
        for rows, chosen in ((slice(0, 3), kind == 0), (slice(3, 6), kind == 1)):
            slope = factor[:, rows] @ model.coefficient_jacobian(theta)[:, rows][..., chosen]
            left = self._left(model, factor, theta).reshape(self.target.shape)[:, rows].ravel()
            step, *_ = np.linalg.lstsq(slope.reshape(left.size, -1), left, rcond=1e-9)
            theta[chosen] += step
        return theta


def triangle(
    z: FloatArray, w: FloatArray, gram: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """R (d, d) and y (d, c) with ``‖R c − y‖²`` equal to ``‖z c − w‖²`` but for a constant.

    `gram` is ``zᵀ z`` where it is known already.
    """
    eigenvalues, vectors = np.linalg.eigh(z.T @ z if gram is None else gram)
    root = np.sqrt(np.clip(eigenvalues, 0.0, None))
    seen = root > SEEN * root[-1]
    factor = np.where(seen, root, 0.0)[:, None] * vectors.T
    inverse = np.where(seen, 1.0 / np.where(seen, root, 1.0), 0.0)
    return factor, inverse[:, None] * (vectors.T @ (z.T @ w))
