"""One channel's model: scale, bias and what the ladder added, with covariance and predictions.

``scale·S + bias = x + Σ size_j φ_j(x; shape_j) + u_session + v_session x + ε``, x the true load: a
session has an offset and a gain of its own (re-seating, warm-up). The reading
is regressed on the load and the φ, which are known exactly; the noise is the reading's. (The other
way round a φ that resembles the load would explain the load by itself.) Linear once the shapes are
given; these are searched, then enter the covariance through their derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import special

from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.regressors import (
    SHAPE_LOG_SD,
    columns,
    invert,
    model_of,
    shape_columns,
    shape_names,
)
from footcal_cli.core.bench.terms import Term
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.fit import PRIOR_KEPT_RATIO
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.separable import Separable, SeparableFit
from footcal_cli.core.parameters import BoolArray, Estimates, FloatArray, Status
from footcal_cli.core.readings import STUCK
from footcal_cli.errors import FitError

_RCOND = 1e-14
_WIDEST_LOG = 50.0
"""An interval this wide in the logarithm of a shape says nothing at all."""


@dataclass(frozen=True)
class Prediction:
    """Loads that a model reads off, each with its uncertainty.

    Parameters
    ----------
    load_n
        Predicted true load, shape (n,).
    sd_n
        Of the load behind one reading in a new session: calibration, session offset and scatter.
    dof
        Degrees of freedom of `sd_n`, shape (n,).
    extrapolated
        Outside the loads, readings or temperatures the model was fitted on, shape (n,).
    """

    load_n: FloatArray
    sd_n: FloatArray
    dof: FloatArray
    extrapolated: BoolArray

    def half_width_n(self) -> FloatArray:
        """Half the width of the 95 % interval for the load, shape (n,)."""
        return np.asarray(special.stdtrit(self.dof, 0.975) * self.sd_n)


@dataclass(frozen=True)
class ChannelFit:
    """A fitted model of one channel.

    Parameters
    ----------
    channel, terms
        Whose, and what it has beyond scale and bias.
    estimates
        ``<channel>.scale``, ``.bias``, then size and shapes of each term, with covariance.
    ci95
        Shape (p, 2); of a shape: symmetric in its logarithm.
    dof
        Degrees of freedom behind each interval, shape (p,).
    sd_within_n, sd_between_n, sd_gain
        Scatter of a reading about the model, of the offsets of sessions, and of their relative
        gains.
    correlation_s
        How long the scatter persists; 0: rows are independent.
    load_range_n, reading_range, temperature_range_degc
        What the model was fitted on.
    rows
        Rows with a known load.
    rmse_n
        Root mean square of the residual on those rows.
    condition
        Of the design with columns scaled to unit length.
    linear, linear_covariance, centre
        Coefficients in the fit's own coordinates (reading minus centre), for predictions.
    """

    channel: str
    terms: tuple[Term, ...]
    estimates: Estimates
    ci95: FloatArray
    dof: FloatArray
    sd_within_n: float
    sd_between_n: float
    correlation_s: float
    load_range_n: tuple[float, float]
    reading_range: tuple[float, float]
    temperature_range_degc: tuple[float, float] | None
    rows: int
    rmse_n: float
    condition: float
    linear: FloatArray
    linear_covariance: FloatArray
    centre: float
    sessions: int
    sd_gain: float = 0.0

    @property
    def log_shapes(self) -> FloatArray:
        """Logarithms of the searched shapes, shape (k,)."""
        return np.log([self.estimates[n] for n in shape_names(self.channel, self.terms)])

    def _wide_range(self, target_n: FloatArray) -> tuple[float, float]:
        """The fitted loads, and those of the straight line, with as much again on either side."""
        low, high = self.load_range_n
        span = high - low
        return min(low, float(target_n.min())) - span, max(high, float(target_n.max())) + span

    def between(self, first: ChannelFit, last: ChannelFit) -> ChannelFit:
        """One fit of a family that the truth lies anywhere in: ``Δ Δᵀ / 12`` is added.

        Parameters
        ----------
        first, last
            The ends of the family, of the same terms; Δ is what they differ by.
        """
        moved = last.estimates.values - first.estimates.values
        half = 0.5 * (self.ci95[:, 1] - self.ci95[:, 0])
        wider = np.hypot(half, special.ndtri(0.975) * np.abs(moved) / np.sqrt(12.0)) - half
        line = last.linear - first.linear
        return replace(
            self,
            estimates=replace(
                self.estimates, covariance=self.estimates.covariance + np.outer(moved, moved) / 12.0
            ),
            ci95=self.ci95 + wider[:, None] * [-1.0, 1.0],
            linear_covariance=self.linear_covariance + np.outer(line, line) / 12.0,
        )

    @property
    def possible(self) -> bool:
        """Whether what the terms of each effect add up to has a sign that the effect can have."""
        sums: dict[str, float] = {}
        sizes = self.linear[2 : 2 + len(self.terms)]
        for term, size in zip(self.terms, sizes, strict=True):
            sums[term.effect] = sums.get(term.effect, 0.0) + float(size)
        one_sided = [name for name in sums if name and TABLE[name].size.lower == 0.0]
        return all(sums[name] >= 0.0 for name in one_sided)

    def p_value_of(self, terms: range) -> float:
        """Wald test that the sizes of some terms are all zero, by the F distribution.

        Parameters
        ----------
        terms
            Positions in `terms`.
        """
        at = 2 + np.array(terms, dtype=np.int64)
        sizes, covariance = self.linear[at], self.linear_covariance[np.ix_(at, at)]
        statistic = float(sizes @ scaled_inverse(covariance, _RCOND) @ sizes) / at.size
        return float(special.fdtrc(at.size, self.dof[at].min(), max(statistic, 0.0)))

    def predict(self, record: BenchRecord) -> Prediction:
        """Loads from readings alone, in order of time where the model remembers.

        Parameters
        ----------
        record
            Readings; its loads are not looked at.
        """
        missing = ~np.isfinite(record.reading)
        fill = np.where(missing, self.centre, record.reading)
        if missing.any() and not missing.all():
            at = np.arange(len(record))
            fill = np.interp(at, at[~missing], record.reading[~missing])
        centred = fill - self.centre
        shapes = self.log_shapes
        sizes = self.linear[2 : 2 + len(self.terms)]
        target = self.linear[0] * centred + self.linear[1]
        load, slope = invert(target, record, self.terms, sizes, shapes, self._wide_range(target))
        design = np.column_stack(
            [
                centred,
                np.ones_like(centred),
                -columns(load, record, self.terms, shapes),
                -shape_columns(load, record, self.terms, sizes, shapes),
            ]
        )
        calibration = np.einsum("ij,jk,ik->i", design, self.linear_covariance, design)
        parts = np.array([np.clip(calibration, 0, None), calibration * 0, calibration * 0])
        parts[1] = self.sd_between_n**2 + (self.sd_gain * load) ** 2
        parts[2] = self.sd_within_n**2
        variance = parts.sum(axis=0)
        blocks = self.sessions - 1 if self.sessions > 1 else float(self.dof.min())
        degrees = np.array([self.dof.min(), blocks, max(self.dof.max(), 1)])
        with np.errstate(divide="ignore", invalid="ignore"):
            dof = variance**2 / np.sum(parts**2 / degrees[:, None], axis=0)
        outside = _outside(load, self.load_range_n) | _outside(fill, self.reading_range)
        if self.temperature_range_degc is not None and record.temperature_degc is not None:
            outside |= _outside(record.temperature_degc, self.temperature_range_degc, 0.0)
        load = np.where(missing, np.nan, load)
        return Prediction(load, np.sqrt(variance) / np.abs(slope), dof, outside & ~missing)


def fit_channel(
    record: BenchRecord,
    terms: tuple[Term, ...] = (),
    start: FloatArray | None = None,
    correlation_s: float | None = None,
) -> ChannelFit:
    """Fit scale, bias and the sizes and shapes of the terms.

    Parameters
    ----------
    record
        Rows with unknown load only carry memory.
    terms
        Distortions beyond the affine model.
    start
        Logarithms of the searched shapes to start from, shape (k,); a grid search where absent.
    correlation_s
        Known persistence of the noise; estimated from the residuals where absent.

    Raises
    ------
    FitError
        Fewer distinct loads than the model has coefficients, or a reading that never changes.
    """
    known = record.known
    distinct = np.unique(record.load_n[known])
    searched = sum(len(term.shapes) for term in terms if term.free)
    if known.sum() < 2 + len(terms) + searched or distinct.size < 2:
        raise FitError(
            f"{int(known.sum())} rows at {distinct.size} distinct loads cannot carry a model with "
            f"{2 + len(terms) + searched} coefficients",
            column=record.channel,
        )
    if np.ptp(record.reading[known]) == 0:
        raise FitError("the reading never changes", column=record.channel, remedy=STUCK)
    model = model_of(record, record.drive(), terms)
    found = model.fit(start, correlation_s if record.timed else 0.0)
    return finish_channel(record, terms, model, found)


def finish_channel(
    record: BenchRecord, terms: tuple[Term, ...], model: Separable, found: SeparableFit
) -> ChannelFit:
    """From counts to newtons, and everything a report needs.

    Parameters
    ----------
    record, terms
        What was fitted.
    model, found
        From `model_of`, and its fit.
    """
    known = record.known
    load, reading = record.load_n[known], record.reading[known]
    centre, fit, affine = float(reading.mean()), found.linear, 2 + len(terms)
    linear, covariance = _as_loads(
        np.concatenate([fit.coefficients, found.log_shapes]),
        found.covariance,
        affine,
        float(load.mean()),
    )
    estimates, ci95 = _estimates(record.channel, terms, linear, covariance, found.dof, centre)
    newtons = abs(float(linear[0]))
    residual = newtons * (model.target - model.design(found.log_shapes) @ fit.coefficients)
    warmth = record.temperature_degc
    return ChannelFit(
        channel=record.channel,
        terms=terms,
        estimates=estimates,
        ci95=ci95,
        dof=found.dof,
        sd_within_n=newtons * fit.sd_within,
        sd_between_n=newtons * fit.sd_between,
        correlation_s=found.correlation_s,
        load_range_n=_range(load),
        reading_range=_range(reading),
        temperature_range_degc=None if warmth is None else _range(warmth[known]),
        rows=int(known.sum()),
        rmse_n=float(np.sqrt(np.mean(residual**2))),
        condition=fit.condition,
        linear=linear,
        linear_covariance=covariance,
        centre=centre,
        sessions=int(np.unique(record.session[known]).size),
        sd_gain=fit.sd_gain * newtons,
    )


def _as_loads(
    counts: FloatArray, covariance: FloatArray, affine: int, mean_load_n: float
) -> tuple[FloatArray, FloatArray]:
    """From ``S − S̄ = b (x − x̄) + a + Σ g φ`` to scale, load at S̄, and sizes, with covariance.

    ``scale = 1/b``, ``load = x̄ − a/b``, ``size = g/b``; logarithms of shapes stay.
    """
    slope, level = counts[:2]
    linear, jacobian = counts.copy(), np.eye(counts.size)
    linear[0], linear[1] = 1.0 / slope, mean_load_n - level / slope
    linear[2:affine] = counts[2:affine] / slope
    jacobian[0, 0] = -1.0 / slope**2
    jacobian[1, :2] = level / slope**2, -1.0 / slope
    for i in range(2, affine):
        jacobian[i, i], jacobian[i, 0] = 1.0 / slope, -counts[i] / slope**2
    return linear, jacobian @ covariance @ jacobian.T


def _estimates(
    channel: str,
    terms: tuple[Term, ...],
    linear: FloatArray,
    covariance: FloatArray,
    dof: FloatArray,
    centre: float,
) -> tuple[Estimates, FloatArray]:
    """From centred readings and logarithms of shapes to parameters in their units.

    Few sessions leave few degrees of freedom. Who is given the estimates takes their covariance
    for Gaussian: it is that whose 95 % intervals are as wide as Student's.
    """
    count, affine = linear.size, 2 + len(terms)
    jacobian = np.eye(count)
    jacobian[1, 0] = -centre  # bias = load at the centre − scale · centre
    values = jacobian @ linear
    values[affine:] = np.exp(linear[affine:])
    jacobian[range(affine, count), range(affine, count)] = values[affine:]
    sd = np.sqrt(np.diag(jacobian @ covariance @ jacobian.T))
    log_sd, quantile = np.sqrt(np.diag(covariance)), special.stdtrit(dof, 0.975)
    wider = jacobian * (quantile / special.ndtri(0.975))
    spread = wider @ covariance @ wider.T
    ci95 = np.column_stack([values - quantile * sd, values + quantile * sd])
    reach = np.exp(np.minimum(quantile * log_sd, _WIDEST_LOG))[affine:]
    ci95[affine:] = np.column_stack([values[affine:] / reach, values[affine:] * reach])
    status = [Status.ESTIMATED] * affine + [
        Status.PRIOR_KEPT if s > PRIOR_KEPT_RATIO * SHAPE_LOG_SD else Status.ESTIMATED
        for s in log_sd[affine:]
    ]
    sizes = [f"{channel}{term.owner}.{term.size}" for term in terms]
    names = (f"{channel}.scale", f"{channel}.bias", *sizes, *shape_names(channel, terms))
    searched = [term for term in terms if term.free]
    shape_units = [unit for term in searched for unit in term.shape_units]
    units = ("N/count", "N", *(term.unit for term in terms), *shape_units)
    return Estimates(names, units, values, spread, tuple(status)), ci95


def _range(values: FloatArray) -> tuple[float, float]:
    return float(values.min()), float(values.max())


def _outside(values: FloatArray, limits: tuple[float, float], slack: float = 0.01) -> BoolArray:
    """Outside limits widened by a share of their span: noise at the edge is no extrapolation."""
    margin = slack * (limits[1] - limits[0])
    return np.asarray((values < limits[0] - margin) | (values > limits[1] + margin))
