"""Poses that were read while the robot moved, among poses of the same robot at rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.moving import find_moving, moving_finding
from footcal_cli.core.pose.problem import PoseOptions
from tests.core.pose_cases import HIGH, LOW, Case, case

UNKNOWN = PoseOptions(noise_known=False)


def found(one: Case, wrench: FloatArray) -> list[int]:
    """Poses found to balance worse than the others."""
    far = find_moving(replace(one.data, wrench_t=wrench), one.legs, one.noise_sd, UNKNOWN)
    return np.flatnonzero(far).tolist()


@pytest.mark.parametrize("noise", [LOW, HIGH])
def test_a_robot_at_rest_loses_no_pose(noise: tuple[float, float]) -> None:
    for seed in range(3):
        one = case(seed, noise, poses=40)
        assert found(one, one.data.wrench_t) == []


@pytest.mark.parametrize("moved", [[4], [0, 9, 17, 23, 31, 38]])
def test_poses_read_in_motion_are_found_and_no_others(moved: list[int]) -> None:
    """Each leg carries a tenth more or less than it would at rest."""
    rng = np.random.default_rng(8)
    one = case(1, poses=40)
    wrench = one.data.wrench_t.copy()
    wrench[moved] *= 1.0 + rng.choice([-0.1, 0.1], (len(moved), wrench.shape[1], 1))
    wrench[moved] *= rng.uniform(1.05, 1.1, (len(moved), 1, 1))
    assert found(one, wrench) == moved


def test_a_fault_of_all_poses_or_few_poses_are_no_reason_to_leave_any_out() -> None:
    one = case(1, poses=40)
    faulty = one.data.wrench_t.copy()
    faulty[:, 2] *= 1.1
    assert found(one, faulty) == []
    few = case(1, poses=12)
    wrench = few.data.wrench_t.copy()
    wrench[3] *= 1.2
    assert found(few, wrench) == []


def test_a_finding_counts_poses_as_the_log_does() -> None:
    far = np.zeros(20, dtype=bool)
    far[[0, 18]] = True
    (one,) = moving_finding(far)
    assert "2 of 20 poses" in one.sentence
    assert one.sentence.endswith(": 1, 19")
    assert not moving_finding(~far & False)
