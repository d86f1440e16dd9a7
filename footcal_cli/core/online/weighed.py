"""What the cells as they were calibrated weigh the robot at, against the recipe's mass.

A fit that takes the stated mass for granted gives it to all scales in equal parts; each of them
stays well within what it was known to, and the residual is as small as ever. All together they do
not: c independent scales know their mean √c times better than each.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.online.belief import Belief
from footcal_cli.core.parameters import Estimates, FloatArray, IntArray
from footcal_cli.core.quality import Finding

_SIGMAS = 4.0
_FEWEST = 50
"""Samples of a foot in the air, and of one that carries the robot alone."""


@dataclass(frozen=True)
class Weighed:
    """The robot on its own cells.

    Parameters
    ----------
    stated_kg
        The recipe's mass.
    mass_kg, sd_kg
        By the cells as they were known before.
    stated_sd_kg
        How well the recipe says that its mass is known; None where it does not.
    """

    stated_kg: float
    mass_kg: float
    sd_kg: float
    stated_sd_kg: float | None = None

    @property
    def sigmas(self) -> float:
        """Distance of both over its sd."""
        return abs(self.mass_kg - self.stated_kg) / self.sd_kg

    @property
    def hidden_kg(self) -> float:
        """A smaller error of the mass would not show."""
        return _SIGMAS * self.sd_kg

    def shared_sd(self, mass_sd: float) -> float:
        r"""Relative error of one sd that all scales share: they were fitted to the stated mass.

        .. math:: \sigma^2 = v + (d \, m / (m + c))^2, \quad 1 / v = 1 / m + 1 / c

        with the variances m of the stated mass and c of the cells' own, and d between both.

        Parameters
        ----------
        mass_sd
            Of the stated mass, as a share of it.
        """
        cells, mass = (self.sd_kg / self.stated_kg) ** 2, mass_sd**2
        share = mass / (mass + cells)
        apart = self.mass_kg / self.stated_kg - 1.0
        return float(np.hypot(np.sqrt(share * cells), share * apart))

    def findings(self, meaning: str = "the scales found here took that up") -> tuple[Finding, ...]:
        """Where they differ by more than chance, and what that means for what was fitted."""
        if self.sigmas < _SIGMAS:
            return ()
        return (
            Finding(
                "mass_differs",
                "warning",
                "robot.mass",
                f"the cells as calibrated weigh the robot at {self.mass_kg:.2f} ± "
                f"{self.sd_kg:.2f} kg, the recipe says {self.stated_kg:.2f} kg: "
                f"{self.sigmas:.0f} sd apart, and {meaning}",
                "weigh the robot as it stood, battery and cables included; if the recipe's mass is "
                "right, weigh known loads on the cells as mounted",
            ),
        )


def as_unsure_as_weighed(
    estimates: Estimates, shared_sd: float, per_share: FloatArray | None = None
) -> Estimates:
    """Scales and biases with the error that the mass which they were fitted to leaves.

    Parameters
    ----------
    estimates
        ``<cell>.scale`` and ``<cell>.bias``, shape (2c,).
    shared_sd
        Relative sd of that mass (`Weighed.shared_sd`).
    per_share
        Change of the estimates per share that the mass is too large by, shape (2c,). Where not
        given, all forces follow it: zeros are known otherwise, as from feet in the air.
    """
    step = shared_sd * (estimates.values if per_share is None else per_share)
    return replace(estimates, covariance=estimates.covariance + np.outer(step, step))


def weighed_walking(
    belief: Belief, gain: FloatArray, covariance: FloatArray, repeated: float, stated_kg: float
) -> Weighed:
    """From the gains that a walk asks for; swinging feet have shown the zeros.

    Parameters
    ----------
    belief
        Before the walk.
    gain, covariance
        Gains γ after it, shape (c,), and their covariance (c, c), `repeated` times as large as the
        rows alone would have it.
    """
    c = len(belief.channels)
    before = float(belief.covariance[:c, :c].sum()) / c**2
    after = min(float(covariance.sum()) / c**2 / repeated, 0.999 * before)
    # the walk alone: of variance u with 1/u = 1/after − 1/before
    asked = float(gain.mean()) / (1.0 - after / before)
    own = repeated * after / (1.0 - after / before)
    relative = 1.0 / (1.0 + asked)
    return Weighed(stated_kg, stated_kg * relative, stated_kg * relative * np.sqrt(before + own))


def weighed_by_each_foot(
    forces_n: FloatArray, contact: FloatArray, feet: Iterable[Sequence[int] | IntArray],
    demand_n: FloatArray, gain_sd: FloatArray, stated_kg: float,
) -> Weighed | None:  # fmt: skip
    r"""From the steps of a walk in which one foot carries the robot alone.

    .. math:: m_f = m \, \mathrm{median} \sum_{i \in f} (F_i - z_i) / D

    with the zero :math:`z_i` that a cell shows in the air. Of the feet the one counts that says
    least: a wrong mass shows in each of them, a faulty cell in its own.

    Parameters
    ----------
    forces_n
        By the calibration to start from, shape (n, c).
    contact
        Of the foot of each cell, 0 in the air, shape (n, c).
    feet
        Which cells are of each foot.
    demand_n
        Vertical force D that mass and motion demand, shape (n,).
    gain_sd
        Relative sd of the scales, shape (c,).
    """
    weighed = []
    for cells in feet:
        mine = np.isin(np.arange(forces_n.shape[1]), cells)
        known, others = np.isfinite(forces_n[:, mine]).all(axis=1), contact[:, ~mine]
        up = known & (contact[:, mine].max(axis=1) == 0.0)
        alone = known & (contact[:, mine].min(axis=1) == 1.0) & np.isfinite(demand_n)
        alone &= others.max(axis=1, initial=0.0) == 0.0
        if up.sum() < _FEWEST or alone.sum() < _FEWEST:
            return None
        carried = forces_n[alone][:, mine] - np.median(forces_n[up][:, mine], axis=0)
        ratio = float(np.median(carried.sum(axis=1) / demand_n[alone]))
        share = np.median(carried, axis=0) / np.median(carried.sum(axis=1))
        sd = float(np.sqrt(np.sum((share * gain_sd[mine]) ** 2)))
        weighed.append(Weighed(stated_kg, stated_kg * ratio, stated_kg * sd))
    one_way = len({np.sign(w.mass_kg - stated_kg) for w in weighed}) == 1
    return min(weighed, key=lambda w: w.sigmas) if one_way else None


def weighed_standing(
    h: FloatArray, error_n: FloatArray, sd_n: FloatArray, covariance: FloatArray, weight_n: float,
    stated_kg: float,
) -> Weighed:  # fmt: skip
    """From the total force of the stances.

    Parameters
    ----------
    h, error_n, sd_n
        Total-force rows of the stances (`footcal_cli.core.static_init.StanceRows`), (n, p), (n,).
    covariance
        Of the unknowns before the stances, in prior sd, shape (p, p).
    weight_n, stated_kg
        The robot's, as stated.
    """
    row = h.mean(axis=0)
    variance = float(row @ covariance @ row) + float(np.mean(sd_n**2)) / error_n.size
    per_n = stated_kg / weight_n
    return Weighed(
        stated_kg, stated_kg + per_n * float(error_n.mean()), per_n * float(np.sqrt(variance))
    )
