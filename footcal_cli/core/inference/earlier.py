"""An earlier calibration as the prior of a new one, joint covariance included."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from footcal_cli.core import chances
from footcal_cli.core.inference.fit import fit_map
from footcal_cli.core.inference.linear import inverse_root
from footcal_cli.core.parameters import Estimates, Parameter, ParameterSet

LEAST_P = 1e-3
"""Calibrations that differ by more than this chance explains are not counted together."""


@dataclass(frozen=True)
class Together:
    """A new and an earlier calibration counted together.

    Parameters
    ----------
    estimates
        Groups, names and order of the new one.
    shared
        Parameters of which both speak.
    p
        Chance that both differ by as much where nothing has changed; 1 where nothing is shared.
    """

    estimates: tuple[Estimates, ...]
    shared: tuple[str, ...]
    p: float


def with_earlier(
    groups: Sequence[Estimates], earlier: Estimates, apart: Collection[str] = ()
) -> Together:
    """Maximum a posteriori of independent fits with an earlier calibration as their joint prior.

    ``min ‖C^(−1/2) (θ − θ̂)‖² + (θ − θ₀)ᵀ P₀⁻¹ (θ − θ₀)``, θ̂ and C the fits alone. What is
    correlated with something that the earlier calibration knows is corrected too.

    Parameters
    ----------
    groups
        Fits without that prior, each with its covariance.
    earlier
        What is shared by name and unit counts, unless it was fixed.
    apart
        Names that mean something else every time: the tilts of a hanging.
    """
    if not groups:
        return Together((), (), 1.0)
    names = tuple(name for group in groups for name in group.names)
    units = tuple(unit for group in groups for unit in group.units)
    values = np.concatenate([group.values for group in groups])
    covariance = linalg.block_diag(*(group.covariance for group in groups))
    unit_of, known_sd = dict(zip(names, units, strict=True)), earlier.sd
    there = {
        name: i
        for i, (name, unit) in enumerate(zip(earlier.names, earlier.units, strict=True))
        if known_sd[i] > 0.0 and name not in apart and unit_of.get(name) == unit
    }
    free = np.diag(covariance) > 0.0
    shared = [i for i, name in enumerate(names) if free[i] and name in there]
    if not shared or not np.isfinite(covariance).all():
        return Together(tuple(groups), (), 1.0)
    at = [there[names[i]] for i in shared]
    prior, known = earlier.values[at], earlier.covariance[np.ix_(at, at)]
    differ = inverse_root(covariance[np.ix_(shared, shared)] + known)
    distance = float(np.sum((differ @ (values[shared] - prior)) ** 2))

    mean, sd, correlation = values.copy(), np.full(len(names), np.inf), np.eye(len(names))
    mean[shared], sd[shared] = prior, np.sqrt(np.diag(known))
    correlation[np.ix_(shared, shared)] = known / np.outer(sd[shared], sd[shared])
    parameters = tuple(
        Parameter(name, unit, float(mean[i]), float(sd[i]), free=bool(free[i]),
                  scale=float(np.sqrt(covariance[i, i])) if free[i] else 1.0)
        for i, (name, unit) in enumerate(zip(names, units, strict=True))
    )  # fmt: skip
    slope = np.zeros((int(free.sum()), len(names)))
    slope[:, free] = inverse_root(covariance[np.ix_(free, free)])
    fit = fit_map(
        lambda theta: slope @ (theta - values),
        ParameterSet(parameters, correlation),
        jacobian=lambda _: slope,
        linear=True,
    )
    found, parts, first = fit.estimates, [], 0
    for group in groups:
        own = slice(first, first + len(group.names))
        parts.append(
            replace(group, values=found.values[own], covariance=found.covariance[own, own])
        )
        first = own.stop
    p = float(chances.chi2_sf(distance, len(shared)))
    return Together(tuple(parts), tuple(names[i] for i in shared), p)
