"""Scale and bias of one load cell from known loads: [NAO], eqs. (1)(2).

``F = c·S + d`` by regression of load on counts over all weights, the unloaded reading included.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import special

from footcal_cli.core.inference.blocks import BlockFit, fit_blocks
from footcal_cli.core.inference.fit import fit_map
from footcal_cli.core.parameters import Estimates, FloatArray, Parameter, ParameterSet, Status
from footcal_cli.core.readings import STUCK
from footcal_cli.core.signals import median_sd
from footcal_cli.errors import FitError

Method = Literal["ordinary", "weighted", "robust"]
_POOLED_REPEATS = 10
_HUBER_TUNING = 1.345  # 95 % efficiency for normal errors


@dataclass(frozen=True)
class LackOfFit:
    """F-test of the affine model against the scatter of repeated loads.

    Parameters
    ----------
    f, p
        Statistic and its p-value.
    """

    f: float
    p: float


@dataclass(frozen=True)
class AffineFit:
    """One channel's scale and bias, and how well a straight line describes it.

    Parameters
    ----------
    channel, method
        Which cell, which regression.
    estimates
        ``<channel>.scale`` (N/count) and ``<channel>.bias`` (N) with their covariance.
    ci95
        95 % intervals, shape (2, 2): rows scale, bias.
    load_n, counts, predicted_n
        The data and ``c·S + d``, shape (n,).
    lack_of_fit
        None where no load repeats.
    bow
        Sagitta of the parabola through the readings at mid-load, as a signed share of the span of
        counts: positive where the sensitivity falls with load; 0 with fewer than three loads.
    centre_counts
        Mean count at which the scale and the load are uncorrelated.
    """

    channel: str
    method: Method
    estimates: Estimates
    ci95: FloatArray
    load_n: FloatArray
    counts: FloatArray
    predicted_n: FloatArray
    lack_of_fit: LackOfFit | None
    bow: float
    centre_counts: float

    @property
    def scale_n_per_count(self) -> float:
        """The scale c."""
        return float(self.estimates.values[0])

    @property
    def bias_n(self) -> float:
        """The bias d."""
        return float(self.estimates.values[1])

    @property
    def zero_counts(self) -> float:
        """The reading at which the calibrated force is zero."""
        return -self.bias_n / self.scale_n_per_count

    @property
    def centre_sd_n(self) -> float:
        """Standard deviation of the calibrated force at the mean reading, where it is smallest."""
        gradient = np.array([self.centre_counts, 1.0])
        variance = float(gradient @ self.estimates.covariance @ gradient)
        return float(np.sqrt(max(variance, 0.0))) if np.isfinite(variance) else np.nan

    @property
    def residual_n(self) -> FloatArray:
        """Measured − known: predicted minus load, shape (n,)."""
        return self.predicted_n - self.load_n

    @property
    def rmse_n(self) -> float:
        """Root mean square of the residual."""
        return float(np.sqrt(np.mean(self.residual_n**2)))

    @property
    def worst_n(self) -> float:
        """Largest absolute residual."""
        return float(np.max(np.abs(self.residual_n)))

    @property
    def resolution_n(self) -> float:
        """Force of one count."""
        return abs(self.scale_n_per_count)

    @property
    def smallest_step_n(self) -> float:
        """Force of the smallest change of reading that occurs."""
        steps = np.diff(np.unique(self.counts))
        return float(steps.min() * self.resolution_n) if steps.size else np.nan


def fit_affine(
    channel: str,
    load_n: FloatArray,
    counts: FloatArray,
    method: Method = "ordinary",
) -> AffineFit:
    """Regress load on counts.

    The counts are centred before solving: around 8·10⁶ counts, scale and bias are otherwise
    collinear to 10 digits.

    Parameters
    ----------
    load_n, counts
        Shape (n,).
    method
        ``ordinary`` least squares; ``weighted`` by the scatter of each load's repeats; ``robust``:
        SciPy's Huber loss at 1.345 robust sd.

    Raises
    ------
    FitError
        Fewer than two distinct loads, or a reading that never changes.
    """
    distinct = np.unique(load_n)
    if distinct.size < 2:
        raise FitError(
            "fewer than two distinct loads", column=channel, unit="N" if distinct.size else None,
            value=float(distinct[0]) if distinct.size else None,
            remedy="record the unloaded cell and at least one known weight",
        )  # fmt: skip
    if np.ptp(counts) == 0:
        raise FitError(
            "the reading never changes", column=channel, value=float(counts[0]), unit="counts",
            remedy=STUCK,
        )  # fmt: skip
    centre = float(np.mean(counts))
    design = np.column_stack([counts - centre, np.ones_like(counts)])
    weights = np.ones_like(load_n)
    if method == "weighted":
        weights = 1.0 / _repeat_sd(load_n, counts)
    fit = fit_blocks(design * weights[:, None], load_n * weights)
    coefficients, covariance = fit.coefficients, fit.covariance
    if method == "robust":
        coefficients, covariance = _robust(design, load_n, fit)
    # back from the centred to the raw reading: d = d₀ − c·S₀
    shift = np.array([[1.0, 0.0], [-centre, 1.0]])
    values, covariance = shift @ coefficients, shift @ covariance @ shift.T
    half = special.stdtrit(fit.dof, 0.975) * np.sqrt(np.diag(covariance))
    return AffineFit(
        channel=channel,
        method=method,
        estimates=Estimates(
            (f"{channel}.scale", f"{channel}.bias"),
            ("N/count", "N"),
            values,
            covariance,
            (Status.ESTIMATED, Status.ESTIMATED),
        ),
        ci95=np.column_stack([values - half, values + half]),
        load_n=load_n,
        counts=counts,
        predicted_n=design @ coefficients,
        lack_of_fit=_lack_of_fit(load_n, counts),
        bow=_bow(load_n, counts),
        centre_counts=centre,
    )


def _robust(
    design: FloatArray, load_n: FloatArray, start: BlockFit
) -> tuple[FloatArray, FloatArray]:
    """Huber regression; covariance of the M-estimator (Huber 1981, eq. 7.6.2)."""
    coefficients = start.coefficients
    if not start.sd_within > 0.0:
        return coefficients, start.covariance
    size = np.abs(coefficients) + 1e-12
    for _ in range(20):  # the scale of the residuals and the fit depend on each other
        residual = load_n - design @ coefficients
        sigma = median_sd(residual - np.median(residual))
        # more than half the rows fitted exactly: fall back to the rms so that the loss has a scale
        sigma = sigma or float(np.sqrt(np.mean(residual**2))) or 1.0
        found = _huber(design, load_n, coefficients, size, _HUBER_TUNING * sigma)
        moved = float(np.max(np.abs(found - coefficients) / size))
        coefficients = found
        if moved < 1e-10:
            break
    standard = (load_n - design @ coefficients) / sigma
    psi = np.clip(standard, -_HUBER_TUNING, _HUBER_TUNING)
    inside = float(np.mean(np.abs(standard) <= _HUBER_TUNING))
    variance = sigma**2 * float(psi @ psi) / float(start.dof[0]) / max(inside, 1e-3) ** 2
    return coefficients, np.asarray(variance / start.sd_within**2 * start.covariance)


def _huber(
    design: FloatArray, load_n: FloatArray, start: FloatArray, size: FloatArray, limit_n: float
) -> FloatArray:
    """Coefficients at the least Huber loss that turns linear at a residual of `limit_n`."""
    parameters = ParameterSet(
        tuple(
            Parameter(name, unit, value, scale=scale)
            for name, unit, value, scale in zip(
                ("scale", "load"), ("N/count", "N"), start.tolist(), size.tolist(), strict=True
            )
        )
    )
    slope = -design / limit_n
    fit = fit_map(
        lambda c: load_n / limit_n + slope @ c, parameters, jacobian=lambda _: slope, loss="huber"
    )
    return fit.estimates.values


def _repeat_sd(load_n: FloatArray, counts: FloatArray) -> FloatArray:
    """Relative sd of each row from the scatter of its load's repeats.

    Variances of few repeats are themselves noisy, and weighting by them makes intervals too short;
    they are pulled to their pooled value as if that were known from `_POOLED_REPEATS` readings.
    """
    levels, at = np.unique(load_n, return_inverse=True)
    spare = np.array([np.sum(load_n == level) - 1 for level in levels])
    squares = np.array(
        [np.sum((counts[load_n == u] - counts[load_n == u].mean()) ** 2) for u in levels]
    )
    if spare.sum() == 0 or squares.sum() == 0:
        return np.ones_like(load_n)
    pooled = squares.sum() / spare.sum()
    variance = (squares + _POOLED_REPEATS * pooled) / (spare + _POOLED_REPEATS)
    return np.asarray(np.sqrt(variance / pooled)[at])


def _lack_of_fit(load_n: FloatArray, counts: FloatArray) -> LackOfFit | None:
    """F-test with the reading as response: its scatter at one load is the pure error.

    Where loads were put on several times, each time counts once: readings of a load that lies still
    share what its seat and slow noise do, and differ by less than loads do.
    """
    levels = np.unique(load_n)
    new = np.diff(load_n, prepend=np.nan) != 0.0
    if new.sum() > levels.size + 1:
        hold = np.cumsum(new) - 1
        counts, load_n = np.bincount(hold, counts) / np.bincount(hold), load_n[new]
    dof_model, dof_pure = levels.size - 2, load_n.size - levels.size
    if dof_model < 1 or dof_pure < 1:
        return None
    pure = sum(
        float(np.sum((counts[load_n == u] - counts[load_n == u].mean()) ** 2)) for u in levels
    )
    line = np.polynomial.Polynomial.fit(load_n, counts, 1)
    total = float(np.sum((counts - line(load_n)) ** 2))
    if pure == 0.0:
        return None
    f = ((total - pure) / dof_model) / (pure / dof_pure)
    return LackOfFit(f, float(special.fdtrc(dof_model, dof_pure, max(f, 0.0))))


def _bow(load_n: FloatArray, counts: FloatArray) -> float:
    """Sagitta of the least-squares parabola through the mean reading of each load."""
    levels = np.unique(load_n)
    if levels.size < 3:
        return 0.0
    means = np.array([counts[load_n == level].mean() for level in levels])
    u = (levels - levels[0]) / (levels[-1] - levels[0])
    if means[-1] == means[0]:
        return 0.0  # of a reading that ends where it began there is no chord to bow from
    v = (means - means[0]) / (means[-1] - means[0])
    return float(-np.polyfit(u, v, 2)[0] / 4.0)


@dataclass(frozen=True)
class Curvature:
    """Whether all channels bend the same way: the check where no load repeats.

    Parameters
    ----------
    bows
        `AffineFit.bow` per channel, shape (k,).
    mean
        Of all channels.
    same_sign
        Number of channels with the sign of the majority.
    sign_p
        Two-sided sign test.
    """

    bows: FloatArray
    mean: float
    same_sign: int
    sign_p: float


def pooled_curvature(fits: Sequence[AffineFit]) -> Curvature | None:
    """Test a shared bow over channels; None with fewer than three channels or three loads."""
    bent = [fit for fit in fits if np.unique(fit.load_n).size > 2]
    if len(bent) < 3:
        return None
    bows = np.array([fit.bow for fit in bent])
    same = int(max(np.sum(bows > 0), np.sum(bows < 0)))
    return Curvature(
        bows=bows,
        mean=float(bows.mean()),
        same_sign=same,
        sign_p=min(1.0, 2.0 * float(special.bdtrc(same - 1, len(bows), 0.5))),
    )
