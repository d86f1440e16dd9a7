"""What the poses say against the experiments before them: a scale, and the hanging robot.

A prior that is pulled away by many of its own sd is no detail of the fit: one of the two
experiments is wrong, and a fit that gives way hides it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import PoseFit

ROBOT_WEIGHT = "robot.weight"
_SIGMAS = 4.0
_FEWEST_POSES = 10
_CONSTANT_P, _CONSTANT_SHARE = 1e-6, 0.2
_TAUGHT = 0.98
"""Share of the prior variance that may be left where poses have a say at all."""


@dataclass(frozen=True)
class Disagreement:
    """One quantity on which poses and earlier experiments disagree.

    Parameters
    ----------
    name, unit
        As in ``parameters.json``.
    found, found_sd
        What the poses alone say, all other priors kept.
    sigmas
        Their difference over its sd.
    """

    name: str
    unit: str
    believed: float
    believed_sd: float
    found: float
    found_sd: float
    sigmas: float


@dataclass(frozen=True)
class ConstantError:
    """Part of the balance's error that is the same in all poses.

    Parameters
    ----------
    mean
        In body axes about the chassis' CoM, N and Nm, shape (6,).
    share
        Of the mean square of the forces' error.
    p
        That errors without such a part have this mean (Hotelling's T²).
    """

    mean: FloatArray
    share: float
    p: float

    @property
    def stands_out(self) -> bool:
        """Whether it is no chance, and no small part of what the fit leaves."""
        return self.p < _CONSTANT_P and self.share > _CONSTANT_SHARE


def constant_error(data: PoseData, fit: PoseFit) -> ConstantError:
    """What offsets that moved since hanging leave: hanging is believed, so they go nowhere else.

    ``T² = P ēᵀ S⁻¹ ē`` with S the covariance of the poses' errors about their mean ē;
    ``(P − 6) T² / (6 (P − 1)) ~ F(6, P − 6)``.
    """
    error = data.features() @ fit.matrix.T
    poses, mean = len(error), error.mean(axis=0)
    share = float(np.sum(mean[:3] ** 2) / np.mean(np.sum(error[:, :3] ** 2, axis=1)))
    if poses < _FEWEST_POSES:
        return ConstantError(mean, share, 1.0)
    size = error.std(axis=0)
    scatter = np.cov(error / size, rowvar=False)
    t_squared = poses * float(mean / size @ np.linalg.solve(scatter, mean / size))
    p = float(chances.f_sf((poses - 6) * t_squared / (6 * (poses - 1)), 6, poses - 6))
    return ConstantError(mean, share, p)


def disagreements(
    fit: PoseFit, legs: tuple[LegKnowledge, ...], robot_weight_n: float
) -> tuple[Disagreement, ...]:
    """Offsets, leg weights and robot weight that moved further than chance, the surest first.

    With variance V before and v with the poses, these alone have ``1/u = 1/v − 1/V``, and the
    change has variance V − v.

    Parameters
    ----------
    fit
        Of poses and priors together.
    robot_weight_n
        What the scale said.
    """
    found = fit.estimates()
    count = len(legs)
    at = np.arange(6 * count, 13 * count + 1)
    believed = np.concatenate(
        [*(leg.offset for leg in legs), [leg.weight_n for leg in legs], [robot_weight_n]]
    )
    before, after = fit.prior_sd[at] ** 2, found.sd[at] ** 2
    taught = after < _TAUGHT * before
    change = found.values[at] - believed
    gain = np.where(taught, 1.0 - after / before, 1.0)
    alone, alone_sd = believed + change / gain, np.sqrt(after / gain)
    sigmas = np.where(taught, np.abs(change) / np.sqrt(before * gain), 0.0)
    order = np.argsort(-sigmas, kind="stable")
    return tuple(
        Disagreement(
            found.names[at[i]], found.units[at[i]], float(believed[i]), float(np.sqrt(before[i])),
            float(alone[i]), float(alone_sd[i]), float(sigmas[i]),
        )
        for i in order
        if sigmas[i] > _SIGMAS
    )  # fmt: skip
