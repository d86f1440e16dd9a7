"""Scales and biases from quiet standing: [NAO], section 3.3.1, eqs. (12)(13).

The unknowns are gains and biases on top of a belief (`footcal_cli.core.online.rows`), found as
maximum a posteriori: total force and CoP of quiet stances never show all of them, and what they do
not show keeps the prior and says so. Plain least squares of (13) is there for comparison.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from footcal_cli.core.inference.fit import Fit, fit_map
from footcal_cli.core.inference.observability import Observability, observability
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.rows import Rows, cell_rows
from footcal_cli.core.online.six_axis import six_axis_rows
from footcal_cli.core.parameters import (
    BoolArray,
    Estimates,
    FloatArray,
    IntArray,
    Parameter,
    ParameterSet,
    learnt_status,
)
from footcal_cli.core.quiet import QuietSet
from footcal_cli.core.signals import autocorrelation_time

FORCE_SHARE, MOMENT_SHARE_M, SWING_SHARE = 0.0015, 5e-4, 0.003
"""What a stance's mean is worth at best, by the robot's weight: force and moment about the CoM, as
cells that were calibrated hole by hole are left with ([NAO], Table 3: 0.08 N and 0.5 mm of 53 N); a
lifted cell, on which cables and a loose sole pull."""
COM_SHARE = 0.004
"""Sd of where the model has the CoM, as a share of its height, the same in every stance: masses of
links are some per cent off, and an inertial unit leans by milliradians."""


@dataclass(frozen=True)
class StanceRows:
    """Means of the linear rows over each stance.

    Parameters
    ----------
    h
        Shape (rows, p), columns in prior sd.
    error
        With the believed calibration, shape (rows,).
    sd
        Noise of each row's mean, shape (rows,).
    output
        Name of each row's balance.
    stance
        Shape (rows,).
    names, units, prior_sd, prior_correlation
        Of the unknowns.
    effective_samples
        Independent samples behind each stance's mean force, shape (stances,).
    shared
        Errors of one sd that all stances have in common (the model's CoM ahead, and to the left),
        shape (rows, m).
    """

    h: FloatArray
    error: FloatArray
    sd: FloatArray
    output: tuple[str, ...]
    stance: IntArray
    names: tuple[str, ...]
    units: tuple[str, ...]
    prior_sd: FloatArray
    prior_correlation: FloatArray
    effective_samples: FloatArray
    shared: FloatArray

    @property
    def whitened(self) -> FloatArray:
        """Rows in units of their noise."""
        return self.h / self.sd[:, None]

    def only(self, keep: BoolArray) -> StanceRows:
        """Some of the rows."""
        return replace(
            self,
            h=self.h[keep],
            error=self.error[keep],
            sd=self.sd[keep],
            output=tuple(name for name, kept in zip(self.output, keep, strict=True) if kept),
            stance=self.stance[keep],
            shared=self.shared[keep],
        )


def stance_rows(
    log: Log,
    quiet: QuietSet,
    belief: Belief,
    *,
    force_sd_n: float | None = None,
    moment_sd_nm: float | None = None,
    swing_sd_n: float | None = None,
    com_sd_m: float | None = None,
) -> StanceRows:
    """Average the static balance over each stance.

    The scatter of the mean counts by its effective sample size; the errors that a stance does not
    average out (posture, creep) are the given floors. A CoM that the model puts in a wrong place
    is wrong in every stance alike: no number of them averages it out.

    Parameters
    ----------
    log
        Raw counts.
    quiet
        From `select_quiet`.
    force_sd_n, moment_sd_nm, swing_sd_n
        Floors of total force, moments and lifted cells; `FORCE_SHARE`, `MOMENT_SHARE_M` and
        `SWING_SHARE` of the weight where None.
    com_sd_m
        Sd of the model's CoM along each of the body's horizontal axes; `COM_SHARE` of its height
        where None.
    """
    if com_sd_m is None:
        height = log.known["com_m"][:, 2]
        com_sd_m = (
            COM_SHARE * float(height[np.isfinite(height)].mean())
            if np.isfinite(height).any()
            else 0.0
        )
    rows = cell_rows(
        log, belief, samples_per_update=1, states=_COM, plate=False, static=True,
        state_sd=dict.fromkeys(_COM, com_sd_m),
    )  # fmt: skip
    force, moment, swing = (
        own if given is None else given
        for own, given in zip(
            floors_of(weight_of(log)), (force_sd_n, moment_sd_nm, swing_sd_n), strict=True
        )
    )
    floors = [force, moment, moment] + [swing] * len(log.channels)
    means = stance_means(rows, quiet, np.array(floors))
    return _shared_out(means, np.array([name in _COM for name in rows.names]))


_FALSE_LIFT_SIGMAS = 4.0


def without_false_lifts(rows: StanceRows) -> StanceRows:
    """The rows without those of feet that were taken for lifted and bear load.

    Whether a foot stands is judged by readings whose zeros are still to be found: one whose zero
    is far too low seems to be in the air. Where the other rows of all stances show, by more than
    4 sd, that it carries something, its cells are not taken to read nothing.
    """
    owner = [name.rpartition("_")[0] for name in rows.output]
    lifted = np.array(owner) != ""
    if not lifted.any() or lifted.all():
        return rows
    found = _fit(rows.only(~lifted)).estimates
    keep = np.ones(lifted.size, dtype=bool)
    for number, foot in {(int(rows.stance[i]), owner[i]) for i in np.flatnonzero(lifted)}:
        own = (rows.stance == number) & (np.array(owner) == foot)
        slope = rows.h[own].sum(axis=0) / rows.prior_sd
        load = float(rows.error[own].sum() + slope @ found.values)
        variance = float(slope @ found.covariance @ slope + np.sum(rows.sd[own] ** 2))
        keep[own] = load < _FALSE_LIFT_SIGMAS * np.sqrt(variance)
    return rows.only(keep)


def floors_of(weight_n: float) -> tuple[float, float, float]:
    """Floors of total force (N), moments (Nm) and lifted cells (N) of a robot's stances."""
    return FORCE_SHARE * weight_n, MOMENT_SHARE_M * weight_n, SWING_SHARE * weight_n


def weight_of(log: Log) -> float:
    """What the feet carry in a log, N."""
    return float(np.mean(log.known["mass_kg"] * log.known["gravity_mps2"]))


_COM = ("robot.com_correction_x", "robot.com_correction_y")


def _shared_out(rows: StanceRows, common: BoolArray) -> StanceRows:
    """Rows with some of the unknowns, shape (p,), as errors that all stances share."""
    own = ~common
    return replace(
        rows,
        h=rows.h[:, own],
        names=tuple(name for name, keep in zip(rows.names, own, strict=True) if keep),
        units=tuple(unit for unit, keep in zip(rows.units, own, strict=True) if keep),
        prior_sd=rows.prior_sd[own],
        prior_correlation=rows.prior_correlation[np.ix_(own, own)],
        shared=rows.h[:, common],
    )


def six_axis_stance_rows(log: Log, quiet: QuietSet) -> StanceRows:
    """Average the balance of six-axis feet over each stance.

    Scales are left out (one load shows none of them); floors as for cells.
    """
    rows = six_axis_rows(log, samples_per_update=1, scales=False, walking=False)
    force, moment, lifted = floors_of(weight_of(log))
    totals = [force] * 3 + [moment] * 2
    swing = lifted * rows.swing_sd_factor
    return stance_means(rows, quiet, np.concatenate([totals, swing]))


def stance_means(rows: Rows, quiet: QuietSet, floors: FloatArray) -> StanceRows:
    """Average rows, one per sample, over each stance.

    Parameters
    ----------
    floors
        What a stance does not average out of each output, shape (k,).
    """
    h, error, sd, output, stance, worth = [], [], [], [], [], []
    for number in range(quiet.stances):
        inside = quiet.stance == number
        tau = autocorrelation_time(rows.error[inside, 0])
        worth.append(float(inside.sum() / tau))
        for k, name in enumerate(rows.outputs):
            use = inside & rows.valid[:, k]
            if use.sum() < inside.sum() / 2:
                continue
            h.append(rows.h[use, k].mean(axis=0))
            error.append(rows.error[use, k].mean())
            spread = np.std(rows.error[use, k]) / np.sqrt(use.sum() / tau)
            sd.append(np.hypot(spread, floors[k]))
            output.append(name)
            stance.append(number)
    return StanceRows(
        h=np.array(h).reshape(-1, len(rows.names)),
        error=np.array(error),
        sd=np.array(sd),
        output=tuple(output),
        stance=np.array(stance, dtype=np.int64),
        names=rows.names,
        units=rows.units,
        prior_sd=rows.prior_sd,
        prior_correlation=rows.prior_correlation,
        effective_samples=np.array(worth),
        shared=np.zeros((len(error), 0)),
    )


@dataclass(frozen=True)
class StaticInit:
    """Scales and biases from quiet standing.

    Parameters
    ----------
    estimates
        ``<cell>.scale``, ``<cell>.bias``; what the stances did not show is `PRIOR_KEPT`.
    gain, bias_n
        On top of the belief, shape (c,).
    covariance
        Of (gain, bias), shape (2c, 2c).
    least_squares
        Gains and biases of plain least squares of eq. (13), minimum norm in raw units, shape (2c,).
    observability
        Of the stances alone.
    chi2, dof
        Whitened squared residual of rows and prior, and the number of rows.
    """

    estimates: Estimates
    gain: FloatArray
    bias_n: FloatArray
    covariance: FloatArray
    least_squares: FloatArray
    observability: Observability
    chi2: float
    dof: int


def fit_static(rows: StanceRows, belief: Belief) -> StaticInit:
    """Maximum a posteriori of gains and biases, and plain least squares beside it.

    ``min ‖(e + H z + G s)/σ‖² + zᵀ P₀⁻¹ z + sᵀ s``, z in prior sd, s what all stances share:
    linear, solved once.

    Parameters
    ----------
    rows
        From `stance_rows`.
    belief
        The prior that the rows were made with.
    """
    fit = _fit(rows)
    c = len(belief.channels)
    values, covariance = fit.estimates.values, fit.estimates.covariance
    return StaticInit(
        estimates=belief.estimates(values[:c], values[c:], covariance, fit.estimates.status),
        gain=values[:c],
        bias_n=values[c:],
        covariance=covariance,
        least_squares=_plain_least_squares(rows, belief),
        observability=observability(rows.whitened, rows.names),
        chi2=_chi2(rows, fit),
        dof=rows.error.size,
    )


@dataclass(frozen=True)
class SixAxisInit:
    """Offsets of six-axis feet from quiet standing.

    Parameters
    ----------
    estimates
        Offsets and what is wrong with mass, CoM and weights below the transducers.
    observability
        Of the stances alone.
    chi2, dof
        As in `StaticInit`.
    """

    estimates: Estimates
    observability: Observability
    chi2: float
    dof: int


def fit_static_six_axis(rows: StanceRows) -> SixAxisInit:
    """Maximum a posteriori of offsets, as `fit_static`."""
    fit = _fit(rows)
    return SixAxisInit(
        estimates=fit.estimates,
        observability=observability(rows.whitened, rows.names),
        chi2=_chi2(rows, fit),
        dof=rows.error.size,
    )


def _fit(rows: StanceRows) -> Fit:
    """Maximum a posteriori of the unknowns; what standing did not show says so."""
    p, m = len(rows.names), rows.shared.shape[1]
    priors = zip(rows.names, rows.units, rows.prior_sd.tolist(), strict=True)
    parameters = ParameterSet(
        (*(Parameter(name, unit, 0.0, sd) for name, unit, sd in priors),
         *(Parameter(f"shared.{i}", "-", 0.0, 1.0) for i in range(m))),
        block_diag(rows.prior_correlation, np.eye(m)),
    )  # fmt: skip
    slope = np.concatenate([rows.whitened / rows.prior_sd, rows.shared / rows.sd[:, None]], axis=1)
    error = rows.error / rows.sd
    fit = fit_map(lambda z: error + slope @ z, parameters, jacobian=lambda _: slope, linear=True)
    found = fit.estimates
    # every stance shows the sum of all cells, which shrinks every sd a little and teaches no cell
    status = learnt_status(found.sd[:p], rows.prior_sd)
    own = Estimates(rows.names, rows.units, found.values[:p], found.covariance[:p, :p], status)
    return replace(fit, estimates=own)


def _chi2(rows: StanceRows, fit: Fit) -> float:
    """Squared residual of rows and prior: ``rᵀ r(0)`` at the optimum of linear rows."""
    return float(fit.residuals @ (rows.error / rows.sd))


@dataclass(frozen=True)
class StanceErrors:
    """Error of each stance's total force and CoP against weight and CoM.

    Parameters
    ----------
    stage
        ``before``, ``after`` or ``least squares``.
    held_out
        Whether each stance was predicted from the others.
    vgrf_n
        Shape (stances,).
    cop_m
        Along the robot's own axes, shape (stances, 2).
    """

    stage: str
    held_out: bool
    vgrf_n: FloatArray
    cop_m: FloatArray


def stance_errors(rows: StanceRows, belief: Belief, weight_n: float) -> list[StanceErrors]:
    """Errors of every stance, fitted and (from two stances on) predicted from the others."""
    count = int(rows.stance.max(initial=-1)) + 1
    none = np.zeros(rows.prior_sd.size)
    found = []

    def errors(stage: str, held_out: bool, solution: Callable[[int], FloatArray]) -> None:
        vgrf, cop = np.full(count, np.nan), np.full((count, 2), np.nan)
        for number in range(count):
            values = solution(number) / rows.prior_sd
            for i in np.flatnonzero(rows.stance == number):
                left = float(rows.error[i] + rows.h[i] @ values)
                if rows.output[i] == "fz":
                    vgrf[number] = left
                elif rows.output[i] == "my":
                    cop[number, 0] = -left / weight_n
                elif rows.output[i] == "mx":
                    cop[number, 1] = left / weight_n
        found.append(StanceErrors(stage, held_out, vgrf, cop))

    fits = [fit_static(rows, belief)]
    errors("before", False, lambda _: none)
    errors("after", False, lambda _: np.concatenate([fits[0].gain, fits[0].bias_n]))
    errors("least squares", False, lambda _: fits[0].least_squares)
    if count > 1:
        fits = [fit_static(rows.only(rows.stance != number), belief) for number in range(count)]
        errors("before", True, lambda _: none)
        errors("after", True, lambda k: np.concatenate([fits[k].gain, fits[k].bias_n]))
        errors("least squares", True, lambda k: fits[k].least_squares)
    return found


def _plain_least_squares(rows: StanceRows, belief: Belief) -> FloatArray:
    """Eq. (13) as printed: c and d by least squares, no prior, each axis in its own unit.

    Solved in the nearly collinear raw unknowns (c, d) by minimum norm, as a first implementation
    would; returned as gain and bias on top of the belief.
    """
    c = len(belief.channels)
    # error = error0 + h_gain γ + h_bias β with γ = δc/c⁰ and β = δd − d⁰ γ
    physical = rows.h / rows.prior_sd
    to_scale = (physical[:, :c] - physical[:, c:] * belief.bias_n) / belief.scale_n_per_count
    raw = np.concatenate([to_scale, physical[:, c:]], axis=1)
    believed = np.concatenate([belief.scale_n_per_count, belief.bias_n])
    target = raw @ believed - rows.error
    solution = np.linalg.lstsq(raw, target, rcond=1e-12)[0]
    gain = solution[:c] / belief.scale_n_per_count - 1.0
    return np.concatenate([gain, solution[c:] - belief.bias_n * (1.0 + gain)])
