"""Noise of logged attitudes: its size found, and intervals that hold it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.pose.attitude import find_attitudes
from footcal_cli.core.pose.data import PoseData
from footcal_cli.core.pose.problem import PoseOptions
from tests.core.pose_cases import Case, case

POSES = 60


def shaken(one: Case, sd_rad: float) -> Case:
    """The same poses, each attitude logged with an error of its own."""
    rng = np.random.default_rng(11)
    turned = one.data.gravity_b + np.cross(
        rng.normal(0.0, sd_rad, (len(one.data), 3)), one.data.gravity_b
    )
    return replace(one, data=replace(one.data, gravity_b=turned))


@pytest.mark.parametrize("known", [True, False])
def test_the_noise_of_attitudes_is_found_beside_that_of_transducers(known: bool) -> None:
    options = PoseOptions(noise_known=known)

    def found(data: PoseData, one: Case) -> float:
        return find_attitudes(data, one.legs, one.noise_sd, options).sd_rad

    one = case(2, poses=POSES)
    assert found(one.data, one) == 0.0
    noisy = shaken(one, 0.005)
    assert found(noisy.data, noisy) == pytest.approx(0.005, rel=0.35)


def test_intervals_of_rotations_hold_the_noise_of_attitudes() -> None:
    rotations = slice(0, 18)
    ratios: dict[float, list[float]] = {0.0: [], 0.005: []}
    for seed in range(3):
        one = shaken(case(seed, poses=POSES), 0.005)
        for sd, off in ratios.items():
            fit = one.fit(PoseOptions(noise_known=False, attitude_sd_rad=sd)).estimates()
            off += ((fit.values - one.truth) / fit.sd)[rotations].tolist()
    rms = {sd: float(np.sqrt(np.mean(np.square(off)))) for sd, off in ratios.items()}
    assert rms[0.005] < 1.35
    assert rms[0.005] < 0.85 * rms[0.0]
