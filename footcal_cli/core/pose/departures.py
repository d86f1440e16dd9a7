"""What the poses say against the experiments before them: a scale, and the hanging robot.

A prior that is pulled away by many of its own sd is no detail of the fit: one of the two
experiments is wrong, and a fit that gives way hides it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import PoseFit

_SIGMAS = 4.0


@dataclass(frozen=True)
class Departure:
    """One quantity on which poses and earlier experiments disagree.

    Parameters
    ----------
    name, unit
        As in ``parameters.json``.
    believed, believed_sd
        Before the poses.
    found, found_sd
        With them.
    sigmas
        The change over the sd believed before; chance makes no more of it than one or two.
    """

    name: str
    unit: str
    believed: float
    believed_sd: float
    found: float
    found_sd: float
    sigmas: float


def departures(
    fit: PoseFit, legs: tuple[LegKnowledge, ...], robot_weight_n: float
) -> tuple[Departure, ...]:
    """Offsets, leg weights and robot weight that moved further than chance, the surest first.

    Parameters
    ----------
    fit
        Of poses and priors together.
    legs
        What hanging said.
    robot_weight_n
        What the scale said.
    """
    found = fit.estimates()
    count = len(legs)
    at = np.arange(6 * count, 13 * count + 1)
    believed = np.concatenate(
        [*(leg.offset for leg in legs), [leg.weight_n for leg in legs], [robot_weight_n]]
    )
    prior_sd, sd, value = fit.prior_sd[at], found.sd[at], found.values[at]
    sigmas = np.abs(value - believed) / prior_sd
    order = np.argsort(-sigmas, kind="stable")
    return tuple(
        Departure(
            found.names[at[i]], found.units[at[i]], float(believed[i]), float(prior_sd[i]),
            float(value[i]), float(sd[i]), float(sigmas[i]),
        )
        for i in order
        if sigmas[i] > _SIGMAS
    )  # fmt: skip
