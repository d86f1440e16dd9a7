"""Joint maximum likelihood over all hanging logs of one leg (seed 2, section III-A, mended).

Each log is reduced once to the triangular factor of its regressors; from then on the fit works on
a few hundred numbers, however long the logs are, and loses nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.fit import Fit, fit_map
from footcal_cli.core.hang.model import HangModel, HangValues, Tilt, leg_com_t_m
from footcal_cli.core.hang.noise import MAX_LAGS, ChannelNoise, fit_noise
from footcal_cli.core.hang.runs import HangRun, hang_runs
from footcal_cli.core.hang.words import hang_gaps, with_unseen
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import Estimates, FloatArray

MAX_ORDER = 3
_MIN_NOISE_DOF = 60
_PHASE_CONDITION = 1e-4
_NOISE_ROUNDS = 4
_MAX_STEPS = 30
_FIRST_DAMPING = 1e-4
_STEP_SD = 1e-3
_SEEN = 1e-7


@dataclass(frozen=True)
class HangOptions:
    """What may be asked of a hanging fit.

    Parameters
    ----------
    order
        Harmonics of ``r(φ)``; None: the lowest BIC up to `max_order` decides.
    max_order
        Highest order tried.
    tilt, tilt_sd_rad
        See `HangModel`.
    temperature, drift
        Whether the offsets follow temperature and time.
    white
        True: take every sample as independent (for comparison; too short intervals).
    noise_sd
        Noise per channel, shape (6,), for records too short to show it; None: estimated.
    """

    order: int | None = None
    max_order: int = MAX_ORDER
    tilt: Tilt = "per_log"
    tilt_sd_rad: float = 0.2
    temperature: bool = False
    drift: bool = False
    white: bool = False
    noise_sd: FloatArray | None = None


@dataclass(frozen=True)
class HangFit:
    """A calibrated hanging leg.

    Parameters
    ----------
    model
        The terms of the fit; `model.order` was chosen by evidence unless it was asked for.
    fit
        Estimates, covariance and health.
    noise
        Per channel.
    evidence
        Order -> BIC (lower is better).
    effective_samples
        Independent samples per channel, shape (6,), of `samples`.
    reference_temperature_degc, reference_time_s
        Where the offsets hold when temperature or drift terms are fitted.
    gaps
        What these logs cannot tell, in words, and what would show it; empty if all is seen.
    """

    model: HangModel
    fit: Fit
    noise: tuple[ChannelNoise, ...]
    evidence: dict[int, float]
    samples: int
    effective_samples: FloatArray
    reference_temperature_degc: float
    reference_time_s: float
    gaps: tuple[str, ...]

    @property
    def estimates(self) -> Estimates:
        """Values with joint covariance."""
        return self.fit.estimates

    @property
    def values(self) -> HangValues:
        """The estimates by their meaning."""
        return self.model.split(self.estimates.values)

    @property
    def gravity_dir_t(self) -> FloatArray:
        """Direction of gravity per log in the true transducer frame, shape (L, 3)."""
        return self.model.gravity_dir_t(self.estimates.values)

    def residuals(self, runs: Sequence[HangRun]) -> list[FloatArray]:
        """Measured − model per run, shape (n, 6), N and Nm."""
        tables = self.model.coefficients(self.estimates.values)
        return [
            run.wrench
            - self.model.regressors(
                run.phase_rad,
                run.temperature_degc - self.reference_temperature_degc,
                run.time_s - self.reference_time_s,
            )
            @ table.T
            for run, table in zip(runs, tables, strict=True)
        ]

    def com_t_m(self, phase_rad: FloatArray) -> FloatArray:
        """Leg CoM at shaft angles (...,), shape (..., 3)."""
        return leg_com_t_m(self.values.com_m, phase_rad)

    def com_sd_m(self, phase_rad: FloatArray) -> FloatArray:
        """Standard deviation of `com_t_m`, shape (..., 3)."""
        columns = self.model.com_columns
        start = self.estimates.values.size - self.model.tilt_design.shape[2] - 3 * columns
        z = leg_com_t_m(np.eye(columns), phase_rad)
        variance = [
            np.einsum("...i,ij,...j->...", z, self.estimates.covariance[at, at], z)
            for at in (slice(start + a * columns, start + (a + 1) * columns) for a in range(3))
        ]
        return np.asarray(np.sqrt(np.stack(variance, axis=-1)))


def fit_hang(logs: Sequence[Log], options: HangOptions | None = None) -> HangFit:
    """Fit one leg's offsets, weight, CoM and tilts to all its hanging logs at once.

    Minimises ``Σ_logs Σ_channels ‖n_lc‖²`` with n the whitened noise of
    ``w = offset + [m g u; r(φ) × m g u]`` (seed 2, eqs. (4)-(7), all at once).

    Parameters
    ----------
    logs
        Hanging logs of one leg (experiment ``hang``), in any orientations.
    options
        What to fit.
    """
    asked = options or HangOptions()
    runs, leg = hang_runs(logs)
    model = HangModel(
        leg,
        np.stack([run.nominal_dir_t for run in runs]),
        asked.max_order if asked.order is None else asked.order,
        asked.tilt,
        asked.tilt_sd_rad,
        asked.temperature,
        asked.drift,
    )
    samples = sum(run.wrench.shape[0] for run in runs)
    references = (
        sum(float(run.temperature_degc.sum()) for run in runs) / samples,
        sum(float(run.time_s.sum()) for run in runs) / samples,
    )
    designs = [
        model.regressors(
            run.phase_rad, run.temperature_degc - references[0], run.time_s - references[1]
        )
        for run in runs
    ]
    model, designs = _seen_harmonics(model, designs)
    wrenches = [run.wrench for run in runs]
    weight_n = runs[0].leg_weight_n
    triangles = [_triangle(z, w) for z, w in zip(designs, wrenches, strict=True)]
    if asked.noise_sd is None and samples - sum(z.shape[1] for z in designs) >= _MIN_NOISE_DOF:
        residuals = [
            w - z @ np.linalg.lstsq(*triangle, rcond=_SEEN)[0]
            for z, w, triangle in zip(designs, wrenches, triangles, strict=True)
        ]
        noise = fit_noise(residuals, designs, 0 if asked.white else MAX_LAGS)
    else:
        noise = _noise_from_fit(model, designs, wrenches, weight_n, asked.noise_sd)
    summary = Summary.of(designs, wrenches, noise, triangles)
    effective = samples / np.array([channel.samples_per_effective for channel in noise])
    start = summary.solve(model, weight_n)
    evidence = summary.order_evidence(model, start, effective.sum())
    if asked.order is None:
        chosen = replace(model, order=min(evidence, key=evidence.__getitem__))
        start = _of_order(model, chosen, start)
        model = chosen
    fit = summary.fit(model, start, weight_n)
    return HangFit(
        model, fit, noise, evidence, samples, effective, *references, hang_gaps(model, fit)
    )


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
        """Reduce logs with regressors (n, d) and wrenches (n, 6), and their `_triangle`."""
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
                factor[i, channel], own = _triangle(seen[:, :-1], seen[:, -1:])
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
            step = scale * np.linalg.lstsq(damped, scale * gradient, rcond=_SEEN**2)[0]
            tried = self._left(model, factor, theta + step)
            tried_cost = tried @ tried + weight @ (theta + step - centre) ** 2
            if not tried_cost <= cost:
                damping = max(10.0 * damping, _FIRST_DAMPING)
                continue
            theta, left, cost, damping = theta + step, tried, tried_cost, 0.1 * damping
            if np.abs(step / scale).max() < _STEP_SD:
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


def _triangle(z: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R (d, d) and y (d, c) with ``‖R c − y‖²`` equal to ``‖z c − w‖²`` but for a constant."""
    eigenvalues, vectors = np.linalg.eigh(z.T @ z)
    root = np.sqrt(np.clip(eigenvalues, 0.0, None))
    seen = root > _SEEN * root[-1]
    factor = np.where(seen, root, 0.0)[:, None] * vectors.T
    inverse = np.where(seen, 1.0 / np.where(seen, root, 1.0), 0.0)
    return factor, inverse[:, None] * (vectors.T @ (z.T @ w))


def _of_order(full: HangModel, lower: HangModel, theta: FloatArray) -> FloatArray:
    """The parameters of a model with fewer harmonics, those left out dropped."""
    tilts = full.tilt_design.shape[2]
    values = full.split(theta)
    fewer = replace(values, com_m=values.com_m[:, : lower.com_columns])
    return lower.join(fewer, theta[theta.size - tilts :])


def _seen_harmonics(
    model: HangModel, designs: Sequence[FloatArray]
) -> tuple[HangModel, list[FloatArray]]:
    """Drop the harmonics that the shaft angles cannot tell apart (a leg that does not turn)."""
    columns = model.com_columns
    gram = np.zeros((columns, columns))
    for z in designs:
        gram += z[:, :columns].T @ z[:, :columns]
    order = model.order
    while order > 0:
        kept = 1 + 2 * order
        if np.linalg.eigvalsh(gram[:kept, :kept] / gram[0, 0])[0] > _PHASE_CONDITION:
            break
        order -= 1
    if order == model.order:
        return model, list(designs)
    others = np.r_[: 1 + 2 * order, columns : designs[0].shape[1]]
    return replace(model, order=order), [z[:, others] for z in designs]


def _noise_from_fit(
    model: HangModel,
    designs: Sequence[FloatArray],
    wrenches: Sequence[FloatArray],
    weight_n: float,
    noise_sd: FloatArray | None,
) -> tuple[ChannelNoise, ...]:
    """Noise of records too short to show their own: one sd for forces, one for torques.

    Alternates fit and residual; the fitted parameters are taken off the degrees of freedom in
    proportion.
    """
    sd = np.array([1.0] * 3 + [0.1] * 3) if noise_sd is None else np.asarray(noise_sd, dtype=float)
    triangles = [_triangle(z, w) for z, w in zip(designs, wrenches, strict=True)]
    for _ in range(_NOISE_ROUNDS if noise_sd is None else 0):
        theta = Summary.of(designs, wrenches, _white(sd), triangles).solve(model, weight_n)
        table = model.coefficients(theta)
        left = np.concatenate(
            [w - z @ c.T for z, w, c in zip(designs, wrenches, table, strict=True)]
        )
        share = 1.0 - min(theta.size / left.size, 0.9)
        force, torque = (float(np.sqrt(np.mean(part**2) / share)) for part in np.split(left, 2, 1))
        sd = np.maximum([force] * 3 + [torque] * 3, np.finfo(float).tiny ** 0.25)
    return _white(sd)


def _white(sd: FloatArray) -> tuple[ChannelNoise, ...]:
    return tuple(ChannelNoise(np.empty(0), float(s), float(s)) for s in sd)
