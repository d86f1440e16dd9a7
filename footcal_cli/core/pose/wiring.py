"""An axis that reads with the sign turned: no graded effect, but a model that cannot fit.

A turned axis drives weight, CoM and tilts far from where they are; signatures taken there say
nothing. So every axis is turned back in turn, and the whole model fitted again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.hang.joint import HangOptions, fit_hang
from footcal_cli.core.hang.model import AXES
from footcal_cli.core.hang.runs import hang_runs
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData, summarise
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import fit_pose
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.quality import Finding

SHARE_LEFT = 0.25
"""Share of the squared misfit that may be left when the right axis is turned back."""


AS_GOOD = 0.01
"""Difference of two squared misfits, as a share of the smaller, that tells no axis from another."""


@dataclass(frozen=True)
class TurnedAxis:
    """An axis that fits far better with its sign turned.

    Parameters
    ----------
    channels
        ``fl.fx``, the best first; several where turning any of them fits alike: a leg and its
        mirror image differ by two signs.
    left
        Share of the squared misfit that is left with the sign turned back.
    """

    channels: tuple[str, ...]
    left: float

    def finding(self) -> Finding:
        """As an alarm."""
        axes = " or ".join(f"{axis} of leg {leg}" for leg, axis in map(_parts, self.channels))
        legs = " or ".join(dict.fromkeys(leg for leg, _ in map(_parts, self.channels)))
        return Finding(
            "axis_turned",
            "alarm",
            " or ".join(self.channels),
            f"{axes} reads with the sign turned: turned back, {self.left:.1%} of the squared "
            "misfit remains" + ("; these data cannot tell which" if len(self.channels) > 1 else ""),
            f"correct the wiring or the axes of leg {legs}, then calibrate again",
        )


def _parts(channel: str) -> tuple[str, str]:
    leg, axis = channel.split(".")
    return leg, axis


def turned_when_hanging(logs: Sequence[Log], asked: HangOptions) -> TurnedAxis | None:
    """The axis of one hanging leg whose sign is turned, if any."""
    channels = logs[0].channels

    def misfit(signs: FloatArray) -> float:
        changed = [log.with_readings(log.readings * signs) for log in logs]
        fit = fit_hang(changed, asked)
        sd = np.array([channel.sd for channel in fit.noise])
        return float(sum(np.sum((part / sd) ** 2) for part in fit.residuals(hang_runs(changed)[0])))

    return _most_improved(misfit, channels)


def turned_when_standing(
    data: PoseData, legs: tuple[LegKnowledge, ...], noise_sd: FloatArray, options: PoseOptions
) -> TurnedAxis | None:
    """The axis of one of the standing legs whose sign is turned, if any."""
    summary = summarise(data)
    channels = [f"{leg}.{axis}" for leg in data.geometry.legs for axis in AXES]

    def misfit(signs: FloatArray) -> float:
        turned = np.append(signs, np.ones(summary.gram.shape[0] - signs.size))
        gram = summary.gram * np.outer(turned, turned)
        return fit_pose(replace(summary, gram=gram), legs, noise_sd, options).chi2_poses

    return _most_improved(misfit, channels)


def _most_improved(
    misfit: Callable[[FloatArray], float], channels: Sequence[str]
) -> TurnedAxis | None:
    before = misfit(np.ones(len(channels)))
    after = np.array([misfit(1.0 - 2.0 * row) for row in np.eye(len(channels))])
    least = float(after.min())
    share = least / max(before, np.finfo(float).tiny)
    if share >= SHARE_LEFT:
        return None
    alike = [i for i in np.argsort(after, kind="stable") if after[i] <= (1.0 + AS_GOOD) * least]
    return TurnedAxis(tuple(channels[i] for i in alike), share)
