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
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.parameters import (
    Estimates,
    FloatArray,
    Parameter,
    ParameterSet,
    learnt_status,
)
from footcal_cli.core.stances import StanceRows

_FALSE_LIFT_SIGMAS = 4.0
_SCATTER_ROUNDS = 5
_FLOORS_WORTH = 2.0
"""Degrees of freedom that what a stance is worth at best counts as, beside those of the stances."""
MISFIT = 3.0
"""Chi² per row from which stances contradict each other or the mass, beyond noise and prior: worth
a warning."""


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
    per_newton
        Change of the estimates per newton that the demanded total force of all stances is too
        large by, as a wrong mass has it, shape (2c,).
    """

    estimates: Estimates
    gain: FloatArray
    bias_n: FloatArray
    covariance: FloatArray
    least_squares: FloatArray
    observability: Observability
    chi2: float
    dof: int
    per_newton: FloatArray


def fit_static(rows: StanceRows, belief: Belief) -> StaticInit:
    """Maximum a posteriori of gains and biases, and plain least squares beside it.

    ``min ‖(e + H z + G s)/σ‖² + zᵀ P₀⁻¹ z + sᵀ s``, z in prior sd, s what all stances share:
    linear. What each kind of row (forces, moments, lifted cells) leaves says how large its noise is
    where that is more than a stance is worth at best: ``σ² (2 + Σ r²) / (2 + Σ (1 − h))`` with h
    the leverage of a row [Birge, Phys. Rev. 40, 207 (1932); Rao, JASA 67, 112 (1972)].

    Parameters
    ----------
    rows
        From `stance_rows`.
    belief
        The prior that the rows were made with.
    """
    fit, chi2, per_newton = _as_sure_as_left(rows)
    c = len(belief.channels)
    values, covariance = fit.estimates.values, fit.estimates.covariance
    turn = belief.per_gain_and_bias()
    return StaticInit(
        estimates=belief.estimates(values[:c], values[c:], covariance, fit.estimates.status),
        gain=values[:c],
        bias_n=values[c:],
        covariance=covariance,
        least_squares=_plain_least_squares(rows, belief),
        observability=observability(rows.whitened, rows.names),
        chi2=chi2,
        dof=rows.error.size,
        per_newton=turn @ per_newton,
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
    fit, chi2, _ = _as_sure_as_left(rows)
    return SixAxisInit(
        estimates=fit.estimates,
        observability=observability(rows.whitened, rows.names),
        chi2=chi2,
        dof=rows.error.size,
    )


def _as_sure_as_left(rows: StanceRows) -> tuple[Fit, float, FloatArray]:
    """The fit, each kind of row no surer than what it leaves, and its χ² with the rows' own noise.

    A kind is judged by itself: forces that agree would hide moments that do not. Also what the
    unknowns (p,) become by a newton that is demanded too much in all stances.
    """
    fit, freedom, per_newton = _solved(rows)
    chi2 = _chi2(rows, fit)
    kinds = np.array([_kind(name) for name in rows.output])
    factor = np.ones(kinds.size)
    for _ in range(_SCATTER_ROUNDS):
        squares, before = (fit.residuals * factor) ** 2, factor.copy()
        for kind in np.unique(kinds):
            own = kinds == kind
            ratio = (_FLOORS_WORTH + squares[own].sum()) / (_FLOORS_WORTH + freedom[own].sum())
            factor[own] = np.sqrt(max(float(ratio), 1.0))
        if np.array_equal(factor, before):
            break
        fit, freedom, per_newton = _solved(replace(rows, sd=rows.sd * factor))
    return fit, chi2, per_newton


def _kind(output: str) -> str:
    """What the noise of a row goes with: forces, moments, or lifted cells and axes."""
    if output in ("fx", "fy", "fz"):
        return "force"
    if output in ("mx", "my"):
        return "moment"
    foot, _, axis = output.rpartition(".")
    return f"lifted {axis[0]}" if foot else "lifted"


def _fit(rows: StanceRows) -> Fit:
    return _solved(rows)[0]


def _solved(rows: StanceRows) -> tuple[Fit, FloatArray, FloatArray]:
    """Maximum a posteriori of the unknowns, and ``1 − h`` of each row, h its leverage.

    Also ``P Aᵀ Σ⁻¹ 1``, what they become by a newton that total forces lack. What standing did not
    show says so.
    """
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
    leverage = np.einsum("ij,jk,ik->i", slope, found.covariance, slope)
    # every stance shows the sum of all cells, which shrinks every sd a little and teaches no cell
    status = learnt_status(found.sd[:p], rows.prior_sd)
    own = Estimates(rows.names, rows.units, found.values[:p], found.covariance[:p, :p], status)
    lacking = np.array([name == "fz" for name in rows.output]) / rows.sd
    return replace(fit, estimates=own), 1.0 - leverage, (found.covariance @ slope.T @ lacking)[:p]


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
