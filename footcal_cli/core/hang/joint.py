"""Joint maximum likelihood over all hanging logs of one leg ([Wu], section III-A, mended)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.hang.effect import HangResidual
from footcal_cli.core.hang.levels import fit_reduced, times_of, with_levels
from footcal_cli.core.hang.model import HangModel, HangValues, Tilt, leg_com_t_m
from footcal_cli.core.hang.runs import MOST_RUNS, HangRun, hang_runs
from footcal_cli.core.hang.words import hang_gaps
from footcal_cli.core.inference.autoregression import MAX_LAGS, ChannelNoise, fit_noise
from footcal_cli.core.inference.fit import Fit
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.reduction import SEEN, Reduced, triangle
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import Estimates, FloatArray
from footcal_cli.errors import DataError, FitError

MAX_ORDER = 3
_MIN_NOISE_DOF, _VARIES = 60, 1e-14
_NOISE_ROUNDS = 4
_INERTIAL_ROUNDS = 2
_FEWEST_ROWS = 10
"""More orientations than this, shorter than so many rows, are no log in which a robot hangs."""
_TYPICAL_SD = np.array([1.0] * 3 + [0.1] * 3)
_LEAST_NOISE = 1e-9  # of the weight: logs without any noise


_STEPS_KEPT, _OF_A_GAUSSIAN = 0.9, 0.623
"""Share of the steps that count, and of a Gaussian's variance what so much of it has."""


@dataclass(frozen=True)
class HangOptions:
    """What may be asked of a hanging fit.

    Parameters
    ----------
    order
        Harmonics of ``r(φ)``; None: the lowest BIC up to `max_order` decides.
    tilt, tilt_sd_rad
        See `HangModel`.
    temperature, drift
        Whether the offsets follow temperature and time.
    white
        True: take every sample as independent (for comparison; too short intervals).
    noise_sd
        Noise per channel, shape (6,), for records too short to show it; None: estimated.
    gravity_mps2
        Turns the weight of a leg into the mass that a turning leg accelerates.
    """

    order: int | None = None
    max_order: int = MAX_ORDER
    tilt: Tilt = "per_log"
    tilt_sd_rad: float = 0.2
    temperature: bool = False
    drift: bool = False
    white: bool = False
    noise_sd: FloatArray | None = None
    gravity_mps2: float = 9.80665


@dataclass(frozen=True)
class HangFit:
    """A calibrated hanging leg.

    Parameters
    ----------
    model
        The terms of the fit; `model.order` was chosen by evidence unless it was asked for.
    evidence
        Order -> BIC (lower is better).
    effective_samples
        Independent samples per channel, shape (6,), of `samples`.
    reference_temperature_degc, reference_time_s
        Where the offsets hold when temperature or drift terms are fitted.
    gaps
        What these logs cannot tell, in words, and what would show it; empty if all is seen.
    level_sd
        Sd of each channel's level from orientation to orientation beyond its noise within one, N
        and Nm, shape (6,); it is in the intervals.
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
    level_sd: FloatArray

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
        return self.model.gravity_dir_t(self.values.tilt)

    def misfit(self, runs: Sequence[HangRun]) -> float:
        """RMS residual over the scatter from sample to sample, of the worst channel.

        The largest tenth of the steps is left out: from hold to hold they are no scatter. 0 where
        no run has two samples: nothing says how much they scatter.
        """
        left = self.residuals(runs)
        size = np.sqrt(np.mean(np.concatenate(left) ** 2, axis=0))
        steps = np.concatenate([np.diff(part, axis=0) for part in left])
        if not len(steps):
            return 0.0
        squares = steps**2
        small = np.where(squares <= np.quantile(squares, _STEPS_KEPT, axis=0), squares, np.nan)
        kept = np.nanmean(small, axis=0) / _OF_A_GAUSSIAN
        scatter = np.sqrt(np.where(kept > 0.0, kept, np.mean(squares, axis=0)) / 2.0)
        return float(np.max(size / np.maximum(scatter, 1e-300)))

    def residuals(self, runs: Sequence[HangRun]) -> list[FloatArray]:
        """What the experiment's balance leaves of each run, shape (n, 6), N and Nm."""
        balance = HangResidual.of(self.model)
        return [balance.errors(log, self.estimates.values) for log in self._logs(runs)]

    def at_rest(self, runs: Sequence[HangRun]) -> list[FloatArray]:
        """Readings of each run without what the turning of the leg adds, shape (n, 6)."""
        balance = HangResidual.of(self.model)
        return [balance.at_rest(log, self.estimates.values) for log in self._logs(runs)]

    def _logs(self, runs: Sequence[HangRun]) -> list[Log]:
        since = self.reference_temperature_degc, self.reference_time_s
        return [run.log(self.model.leg, number, *since) for number, run in enumerate(runs)]

    def com_t_m(self, phase_rad: FloatArray) -> FloatArray:
        """Leg CoM at shaft angles (...,), shape (..., 3)."""
        return leg_com_t_m(self.values.com_m, phase_rad)

    def com_sd_m(self, phase_rad: FloatArray) -> FloatArray:
        """Standard deviation of `com_t_m`, shape (..., 3)."""
        columns = self.model.com_columns
        start = self.estimates.values.size - len(self.model.tilt_names()) - 3 * columns
        z = leg_com_t_m(np.eye(columns), phase_rad)
        variance = [
            np.einsum("...i,ij,...j->...", z, self.estimates.covariance[at, at], z)
            for at in (slice(start + a * columns, start + (a + 1) * columns) for a in range(3))
        ]
        return np.asarray(np.sqrt(np.stack(variance, axis=-1)))


def fit_hang(logs: Sequence[Log], options: HangOptions | None = None) -> HangFit:
    """Fit one leg's offsets, weight, CoM and tilts to all its hanging logs at once.

    Minimises ``Σ_logs Σ_channels ‖n_lc‖²`` with n the whitened noise of
    ``w = offset + [m (g u − r̈); r × m (g u − r̈)]`` ([Wu], eqs. (4)-(7), all at once, and the
    acceleration of a leg that turns): the residual of the experiment. The part of r̈ is taken off
    as a first fit gives it.

    Parameters
    ----------
    logs
        Hanging logs of one leg (experiment ``hang``), in any orientations.
    """
    asked = options or HangOptions()
    hung = Hung.of(logs, asked)
    runs, model, designs, grams = hung.runs, hung.model, hung.designs, hung.grams
    references, weight_n = hung.references, hung.weight_n
    samples = sum(len(z) for z in designs)
    balance = HangResidual.of(model)
    wrenches = [run.wrench for run in runs]
    triangles = [triangle(*each) for each in zip(designs, wrenches, grams, strict=True)]
    for _ in range(_INERTIAL_ROUNDS if any(run.shaft_radps.any() for run in runs) else 0):
        first = Reduced.of(designs, wrenches, white_noise(_TYPICAL_SD), triangles)
        theta = fit_reduced(first, balance, weight_n).estimates.values
        wrenches = [
            balance.at_rest(run.log(model.leg, number, *references), theta)
            for number, run in enumerate(runs)
        ]
        triangles = [triangle(*each) for each in zip(designs, wrenches, grams, strict=True)]
    freedom = samples - sum(z.shape[1] for z in designs)
    if asked.noise_sd is None and freedom >= _MIN_NOISE_DOF:
        residuals = _residuals(hung, wrenches, triangles)
        noise = fit_noise(residuals, designs, 0 if asked.white else MAX_LAGS)
    else:
        noise = _noise_from_fit(balance, designs, wrenches, weight_n, asked.noise_sd)
    reduced = Reduced.of(designs, wrenches, noise, triangles)
    effective = samples / np.array([channel.samples_per_effective for channel in noise])
    fit = fit_reduced(reduced, balance, weight_n)
    evidence = _order_evidence(model, fit, effective.sum())
    if asked.order is None:
        chosen = replace(model, order=min(evidence, key=evidence.__getitem__))
        if chosen.order < model.order:
            start = _of_order(model, chosen, fit.estimates.values)
            reduced = reduced.only(chosen.among(model))
            balance = HangResidual.of(chosen)
            fit = fit_reduced(reduced, balance, weight_n, start)
        model = chosen
    fit, level_sd = with_levels(reduced, balance, weight_n, fit, times_of(runs))
    return HangFit(
        model,
        fit,
        noise,
        evidence,
        samples,
        effective,
        *references,
        hang_gaps(model, fit),
        level_sd,
    )


@dataclass(frozen=True)
class Hung:
    """The logs of one leg as runs, and what predicts them.

    Parameters
    ----------
    model
        With as many harmonics as are asked for or may be tried, and the shaft angles tell apart.
    designs, grams
        Regressors z (n, d) of each run, and ``zᵀ z``.
    references
        Temperature in degC and time in s that the regressors count from.
    weight_n
        Believed weight of the leg.
    room
        Memory for what is left of all readings, shape (6, n).
    """

    runs: tuple[HangRun, ...]
    model: HangModel
    designs: list[FloatArray]
    grams: list[FloatArray]
    references: tuple[float, float]
    weight_n: float
    room: FloatArray

    @classmethod
    def of(cls, logs: Sequence[Log], asked: HangOptions) -> Hung:
        """Of hanging logs of one leg."""
        runs, leg = hang_runs(logs)
        samples = sum(run.wrench.shape[0] for run in runs)
        model = _model_of(leg, runs, samples, asked)
        references = (
            sum(float(run.temperature_degc.sum()) for run in runs) / samples,
            sum(float(run.time_s.sum()) for run in runs) / samples,
        )
        # one piece of memory for all: the system hands out many pieces far more slowly
        count = model.regressor_count
        rows = np.empty((count + len(AXES), samples))
        ends = np.cumsum([run.time_s.size for run in runs])
        designs = [
            model.regressors_into(
                part,
                run.phase_rad,
                run.temperature_degc - references[0],
                run.time_s - references[1],
            )
            for run, part in zip(runs, np.split(rows[:count], ends[:-1], axis=1), strict=True)
        ]
        grams = [z.T @ z for z in designs]
        order = model.seen_order(grams)
        if order < model.order:
            lower = replace(model, order=order)
            kept, model = lower.among(model), lower
            designs = [z.T[kept].T for z in designs]
            grams = [gram[np.ix_(kept, kept)] for gram in grams]
        return cls(runs, model, designs, grams, references, runs[0].leg_weight_n, rows[count:])


def _residuals(
    hung: Hung, wrenches: Sequence[FloatArray], triangles: Sequence[tuple[FloatArray, FloatArray]]
) -> list[FloatArray]:
    """What the regressors leave of each record, shape (n, 6), channel by channel in memory."""
    ends = np.cumsum([len(z) for z in hung.designs])
    parts = np.split(hung.room, ends[:-1], axis=1)
    for z, w, (factor, target), part in zip(hung.designs, wrenches, triangles, parts, strict=True):
        coefficients = np.linalg.lstsq(factor, target, rcond=SEEN)[0]
        np.matmul(coefficients.T, z.T, out=part)
        np.subtract(w.T, part, out=part)
    return [part.T for part in parts]


def _model_of(leg: str, runs: Sequence[HangRun], samples: int, asked: HangOptions) -> HangModel:
    """The model that is asked for, with as many harmonics as may be tried.

    Raises
    ------
    DataError
        The orientation changes so often that the rows are in no order.
    """
    if asked.tilt == "per_log" and len(runs) > max(MOST_RUNS, samples // _FEWEST_ROWS):
        raise DataError(
            f"the orientation of leg {leg} changes {len(runs) - 1:,} times in {samples:,} rows",
            remedy="put the rows in the order of their stamps; an orientation lasts many rows",
        )
    level = [run.level_t for run in runs if run.level_t is not None]
    return HangModel(
        leg,
        np.stack([run.nominal_dir_t for run in runs]),
        asked.max_order if asked.order is None else asked.order,
        asked.tilt,
        asked.tilt_sd_rad,
        np.stack(level) if len(level) == len(runs) else None,
        asked.temperature,
        asked.drift,
        asked.gravity_mps2,
    )


def _order_evidence(model: HangModel, fit: Fit, samples: float) -> dict[int, float]:
    """BIC per number of harmonics up to the model's, relative to the full model's χ².

    Leaving harmonics out costs ``cᵀ cov(c)⁻¹ c`` with c their coefficients (exact to second
    order), and saves ``ln n`` per coefficient, n the effective samples of all channels.
    """
    theta, covariance = fit.estimates.values, fit.estimates.covariance
    columns = model.com_columns
    first = theta.size - len(model.tilt_names()) - 3 * columns
    evidence = {}
    for order in range(model.order + 1):
        higher = np.arange(1 + 2 * order, columns)
        out = first + (columns * np.arange(3)[:, None] + higher).ravel()
        # an axis that shows nothing at all has coefficients without any variance
        cost = theta[out] @ scaled_inverse(covariance[np.ix_(out, out)], _VARIES) @ theta[out]
        evidence[order] = float(cost + (theta.size - out.size) * np.log(samples))
    return evidence


def _of_order(full: HangModel, lower: HangModel, theta: FloatArray) -> FloatArray:
    """The parameters of a model with fewer harmonics, those left out dropped."""
    values = full.split(theta)
    fewer = replace(values, com_m=values.com_m[:, : lower.com_columns])
    return lower.join(fewer)


def _noise_from_fit(
    balance: HangResidual,
    designs: Sequence[FloatArray],
    wrenches: Sequence[FloatArray],
    weight_n: float,
    noise_sd: FloatArray | None,
) -> tuple[ChannelNoise, ...]:
    """Noise of records too short to show their own: one sd for forces, one for torques.

    Alternates fit and residual; the fitted parameters are taken off the degrees of freedom in
    proportion.

    Raises
    ------
    FitError
        There are fewer readings than parameters: nothing shows the noise.
    """
    leg, sd = balance.model.leg, np.asarray(_TYPICAL_SD if noise_sd is None else noise_sd, float)
    triangles = [triangle(z, w) for z, w in zip(designs, wrenches, strict=True)]
    for _ in range(_NOISE_ROUNDS if noise_sd is None else 0):
        reduced = Reduced.of(designs, wrenches, white_noise(sd), triangles)
        theta = fit_reduced(reduced, balance, weight_n).estimates.values
        table = balance.coefficients(theta)
        left = np.concatenate(
            [w - z @ c.T for z, w, c in zip(designs, wrenches, table, strict=True)]
        )
        if left.size <= theta.size:
            raise FitError(
                f"leg {leg}: {left.size} readings cannot carry {theta.size} parameters",
                remedy="hang the leg in more orientations, or record for longer",
            )
        share = 1.0 - min(theta.size / left.size, 0.9)
        force, torque = (float(np.sqrt(np.mean(part**2) / share)) for part in np.split(left, 2, 1))
        sd = np.maximum([force] * 3 + [torque] * 3, _LEAST_NOISE * weight_n)
    return white_noise(sd)


def white_noise(sd: FloatArray) -> tuple[ChannelNoise, ...]:
    """Independent samples of these sd, one per channel."""
    return tuple(ChannelNoise(np.empty(0), float(s), float(s)) for s in sd)
