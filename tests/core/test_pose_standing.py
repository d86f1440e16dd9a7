"""Offsets from standing: refusal with all feet down, truth and intervals on tripods."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.pose.data import PoseData, pose_data
from footcal_cli.core.pose.standing import OffsetFit, StandingRobot, fit_offsets
from tests.core.six_axis_data import (
    HIP_POS_M,
    LEGS,
    ROBOT_WEIGHT_N,
    TABLE_2,
    WEIGHT_N,
    Array,
    com_m,
    draw_robot,
    stand,
)

LEFT_TRIPOD = np.array([leg in ("fl", "mr", "hl") for leg in LEGS], dtype=float)


def tripods(poses: int) -> Array:
    """Contacts of alternating tripods."""
    return np.array([LEFT_TRIPOD if i % 2 else 1.0 - LEFT_TRIPOD for i in range(poses)])


def run(
    seed: int, contact: Array, noise: tuple[float, float] = (0.02, 0.002)
) -> tuple[OffsetFit, Array, PoseData]:
    rng = np.random.default_rng([50, seed])
    robot = draw_robot(rng)
    true = TABLE_2 + rng.normal(size=(6, 6)) * np.array([2.0] * 3 + [0.1] * 3)
    standing = stand(
        rng,
        robot,
        len(contact),
        contact=contact,
        force_sd=noise[0],
        torque_sd=noise[1],
        offset=true,
    )
    data = pose_data(standing.log)
    known = StandingRobot(
        robot.rot_bt,
        HIP_POS_M + robot.shift_b_m - robot.chassis_com_b_m,
        WEIGHT_N,
        ROBOT_WEIGHT_N - WEIGHT_N.sum(),
        com_m(data.phase_rad),
        TABLE_2,
        np.full((6, 6), 0.001),
    )
    noise_sd = np.tile([noise[0]] * 3 + [noise[1]] * 3, (6, 1))
    return fit_offsets(data, known, noise_sd), true, data


@pytest.mark.parametrize("poses", [10, 300])
def test_all_feet_down_is_refused_with_rank_6_of_36(poses: int) -> None:
    fit, _, _ = run(1, np.ones((poses, 6)))
    assert (fit.rank, fit.unknowns, fit.accepted) == (6, 36, False)
    assert np.isnan(fit.offset).all()
    assert "6 of 36" in fit.words[0]
    assert "tripod" in fit.words[1]
    assert fit.noise_factor == pytest.approx(1.0, abs=0.25), "the residual looks perfect"


def test_one_tripod_alone_is_refused_and_names_the_legs() -> None:
    fit, _, _ = run(2, np.tile(LEFT_TRIPOD, (20, 1)))
    assert not fit.accepted
    assert fit.rank == 24
    assert "hl" in fit.words[1]
    assert "ml" not in fit.words[1].split(";")[0]


def test_two_tripod_stances_show_all_offsets() -> None:
    standard, force = [], []
    for seed in range(25):
        fit, true, _ = run(seed, tripods(2))
        assert fit.accepted
        assert fit.rank == 36
        standard.append((fit.offset - true) / fit.offset_sd)
        force.append((fit.offset - true)[:, :3])
        np.testing.assert_allclose(fit.change, fit.offset - TABLE_2)
    assert 0.92 < np.mean(np.abs(standard) < 1.96) < 0.98
    assert np.sqrt(np.mean(np.square(force))) < 0.1


def test_says_how_many_more_poses_reach_the_asked_precision() -> None:
    noise = (0.5, 0.05)
    few, _, _ = run(3, tripods(6), noise)
    assert few.poses_needed is not None
    assert few.poses_needed > 6
    assert "more poses" in few.words[1]
    enough, _, _ = run(3, tripods(2 * (few.poses_needed // 2) + 2), noise)
    assert enough.offset_sd[:, :3].max() <= 0.1 * 1.05
    assert enough.poses_needed is not None
    assert enough.poses_needed <= enough.poses * 1.1


def test_offset_change_has_an_honest_sd() -> None:
    standard = []
    for seed in range(25):
        fit, true, _ = run(100 + seed, tripods(10), (0.1, 0.01))
        standard.append((fit.change - (true - TABLE_2)) / fit.change_sd)
    assert 0.92 < np.mean(np.abs(standard) < 1.96) < 0.98


def test_one_robot_standing_on_all_feet_among_tripods_helps() -> None:
    contact = np.vstack([tripods(10), np.ones((30, 6))])
    mixed, _, _ = run(4, contact)
    plain, _, _ = run(4, tripods(10))
    assert mixed.accepted
    assert mixed.offset_sd.mean() < plain.offset_sd.mean()
