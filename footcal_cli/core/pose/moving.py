"""Poses in which the robot moved, or was held, while they were read: their balance stands out."""

from __future__ import annotations

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.inference.linear import inverse_root
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.pose.data import PoseData, summarise
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import fit_pose
from footcal_cli.core.pose.problem import PoseOptions, feature_noise
from footcal_cli.core.quality import Finding, some_of

_SURE = 0.75
"""Share of the poses that balance best: these say what is usual, and no more may be left out."""
_FAR = 4.0
"""Errors so many times as large as is usual are none of the noise."""
_ROUNDS = 6
_MOST_NAMED = 8


def find_moving(
    data: PoseData, legs: tuple[LegKnowledge, ...], noise_sd: FloatArray, options: PoseOptions
) -> BoolArray:
    """Poses whose balance is off by far more than that of the others, shape (P,).

    Least trimmed squares (Rousseeuw 1984): the mounting is fitted to the poses that balance best
    until these stay the same, and then to all that are not far. Where a fit has more than half as
    many unknowns as equations, or more than a quarter of the poses is far, nothing is said.
    """
    noise = feature_noise(noise_sd, options.attitude_sd_rad)
    features, poses = data.features(), len(data)
    none: BoolArray = np.zeros(poses, dtype=bool)

    def squares(chosen: IntArray) -> FloatArray | None:
        """Of the balance errors in units of the noise, by a fit to some poses."""
        fit = fit_pose(summarise(data, chosen), legs, noise_sd, options)
        if fit.left < 3 * chosen.size:
            return None
        root = inverse_root((fit.matrix * noise) @ fit.matrix.T)
        return np.asarray(np.sum((features @ fit.matrix.T @ root.T) ** 2, axis=1))

    nearest = np.arange(poses)
    for _ in range(_ROUNDS):
        found = squares(nearest)
        if found is None:
            return none
        square = found
        before, nearest = nearest, np.sort(np.argsort(square)[: int(np.ceil(_SURE * poses))])
        if np.array_equal(before, nearest):
            break
    far = none
    for _ in range(2):
        level = float(np.median(square[nearest])) / float(chances.chi2_ppf(0.5 * _SURE, 6))
        far = np.asarray(square > 6.0 * _FAR**2 * level)
        if not far.any() or far.mean() > 1.0 - _SURE:
            return none
        found = squares(np.flatnonzero(~far))
        if found is None:
            return none
        square = found
    return np.asarray(far)


def moving_finding(far: BoolArray) -> list[Finding]:
    """Which poses were left out, by their place in the log."""
    if not far.any():
        return []
    places = [str(i + 1) for i in np.flatnonzero(far)]
    return [
        Finding(
            "poses_off_balance", "warning", "poses",
            f"{len(places)} of {far.size} poses balance far worse than the others, as if the robot "
            f"moved or was held; left out (counted in the log's order): "
            f"{some_of(places, _MOST_NAMED)}",
            "stand still before a pose is read, with cables slack; record these poses again",
        )
    ]  # fmt: skip
