"""Offsets that moved between hanging and standing, where nobody says how noisy a pose is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.pose.departures import constant_error
from footcal_cli.core.pose.problem import PoseOptions
from tests.core.pose_cases import HIGH, LOW, Case, case

UNKNOWN = PoseOptions(noise_known=False)


def moved(one: Case, offset: np.ndarray, *, drifts: bool = False) -> Case:
    """The same poses with other offsets (6, 6) than hanging, reached slowly or at once."""
    when = np.linspace(0.0, 1.0, len(one.data))[:, None, None] if drifts else 1.0
    return replace(one, data=replace(one.data, wrench_t=one.data.wrench_t + when * offset))


@pytest.mark.parametrize("noise", [LOW, HIGH])
def test_offsets_that_stayed_leave_no_constant_error(noise: tuple[float, float]) -> None:
    for seed in range(4):
        one = case(seed, noise, poses=40)
        assert not constant_error(one.data, one.fit(UNKNOWN)).stands_out


@pytest.mark.parametrize("drifts", [False, True])
def test_offsets_that_moved_are_found_by_what_is_alike_in_all_poses(*, drifts: bool) -> None:
    """In part: mountings that turn take up what is across gravity, and some of what is along."""
    rng = np.random.default_rng(4)
    offset = rng.normal(0.0, [0.8] * 3 + [0.05] * 3, (6, 6))
    one = moved(case(1, poses=40), offset, drifts=drifts)
    found = constant_error(one.data, one.fit(UNKNOWN))
    assert found.stands_out
    in_body = np.einsum("kij,kj->i", one.robot.rot_nominal, offset[:, :3])
    assert 0.2 < found.mean[2] / in_body[2] < 1.0


def test_few_poses_say_nothing_of_it() -> None:
    one = moved(case(1, poses=8), np.full((6, 6), 1.0))
    assert constant_error(one.data, one.fit(UNKNOWN)).p == 1.0
