"""Fits of hanging records, and levels that differ from hold to hold beyond the noise within one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.hang.effect import HangResidual
from footcal_cli.core.hang.runs import HangRun
from footcal_cli.core.hang.words import with_unseen
from footcal_cli.core.inference.fit import Fit
from footcal_cli.core.inference.reduction import Reduced
from footcal_cli.core.parameters import FloatArray

_LEVEL_ROUNDS = 6
_MOST_LASTING = 300
"""Holds whose levels are whitened across; of more, each counts as drawn anew."""
_GROUPS = (slice(0, 3), slice(3, 6))
"""Channels whose levels share a law: forces, torques."""


def times_of(runs: Sequence[HangRun]) -> FloatArray:
    """Middle of each run, s, shape (L,)."""
    return np.array([float(run.time_s.mean()) for run in runs])


def fit_reduced(
    reduced: Reduced, balance: HangResidual, weight_n: float, start: FloatArray | None = None
) -> Fit:
    """Weight, offsets, CoM and tilts at maximum likelihood; the status says what stays unknown."""
    model = balance.model
    parameters = model.parameters(weight_n)
    fit = reduced.fit(parameters, balance.coefficients, model.coefficient_jacobian, start)
    return with_unseen(fit)


def with_levels(
    reduced: Reduced, balance: HangResidual, weight_n: float, fit: Fit, time_s: FloatArray
) -> tuple[Fit, FloatArray]:
    """The fit again where levels differ from hold to hold by more than the noise within one.

    A drift that lasts longer than a hold makes neighbouring levels alike: so few of them are
    independent that the sd of their mean is larger.

    Parameters
    ----------
    time_s
        Of each hold, shape (L,).

    Returns
    -------
    The fit, and the sd of levels, shape (6,).
    """

    def levels(before: FloatArray | None) -> tuple[FloatArray, FloatArray]:
        theta = fit.estimates.values
        return reduced.level_sd(
            balance.coefficients(theta), balance.model.coefficient_jacobian(theta),
            fit.estimates.covariance, _GROUPS, before,
        )  # fmt: skip

    sd, freedom = levels(None)
    if not sd.any():
        return fit, sd
    for _ in range(_LEVEL_ROUNDS - 1):
        fit = fit_reduced(reduced.with_levels(sd), balance, weight_n, fit.estimates.values)
        sd, _ = levels(sd)
    # an sd from few levels: as wide as Student's intervals
    wide = np.asarray(sd * chances.t_ppf(0.975, np.maximum(freedom, 1.0)) / chances.norm_ppf(0.975))
    start = fit.estimates.values
    lasting = _lasting(reduced, balance, start, time_s, sd, wide)
    each = reduced.with_levels(wide) if lasting is None else lasting
    return fit_reduced(each, balance, weight_n, start), wide


def _lasting(
    reduced: Reduced,
    balance: HangResidual,
    theta: FloatArray,
    time_s: FloatArray,
    sd: FloatArray,
    wide: FloatArray,
) -> Reduced | None:
    """The records with levels that last from hold to hold; None where these cannot show it."""
    if time_s.size > _MOST_LASTING:
        return None
    table = balance.coefficients(theta), balance.model.coefficient_jacobian(theta)
    covariance = np.stack([np.diag(np.full(time_s.size, v**2)) for v in wide])
    shown = False
    for group in _GROUPS:
        if not sd[group].any():
            continue
        law = reduced.level_law(time_s, *table, group)
        if law is not None:
            shown = True
            times = float(wide[group].max() / sd[group].max())
            covariance[group] = times**2 * law.covariance(time_s)
    return reduced.with_lasting_levels(covariance) if shown else None
