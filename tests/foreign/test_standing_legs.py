"""`pose-calib` after hanging, in a world that it does not know."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.pose.data import Geometry, PoseData
from footcal_cli.core.pose.departures import Disagreement, disagreements
from footcal_cli.core.pose.hanging import leg_knowledge
from footcal_cli.core.pose.joint import PoseFit, directions_agree
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.pose.slow_noise import SlowNoise, fit_pose_slowly
from footcal_cli.core.pose.study import study_mounting
from tests.foreign import draw_hexapod, poses
from tests.foreign.biped import GRAVITY_MPS2
from tests.foreign.legs import AXES, LEGS
from tests.foreign.noise import Array
from tests.foreign.test_hanging import fits_of

_USUAL = PoseOptions(com_sd_m=0.05, translation_sd_m=0.005)


def posed(
    seed: int, too_heavy_n: float = 0.0, slow_share: float = 0.3, count: int = 120
) -> PoseData:
    """The poses of a seed as a recipe has them, the robot's weight stated wrong by so much."""
    recorded, robot = poses(seed, count=count, slow_share=slow_share), draw_hexapod(seed)
    frame = recorded.logs["poses"]
    wrench = frame[list(AXES)].to_numpy().reshape(count, 6, 6)
    quat = frame[[f"body_q{a}" for a in "xyzw"]].to_numpy().reshape(count, 6, 4)[:, 0]
    rot_wb = Rotation.from_quat(quat).as_matrix()
    geometry = Geometry(LEGS, robot.nominal_rot_bt, robot.nominal_hip_m, np.zeros(3))
    return PoseData(
        geometry, wrench, frame["phase_rad"].to_numpy().reshape(count, 6), -rot_wb[:, 2, :],
        rot_wb, frame["contact"].to_numpy(dtype=float).reshape(count, 6),
        robot.mass_kg * GRAVITY_MPS2 + too_heavy_n, robot.leg_kg * GRAVITY_MPS2,
        np.zeros(count, dtype=np.int64),
    )  # fmt: skip


def fitted(
    seed: int, turn_s: float, too_heavy_n: float = 0.0, slow_share: float = 0.3
) -> tuple[PoseFit, dict[str, Disagreement], bool]:
    """The fit, on what poses and earlier experiments disagree, and whether directions agree."""
    legs = tuple(leg_knowledge(fit) for fit in fits_of(seed, turn_s).values())
    data = posed(seed, too_heavy_n, slow_share)
    noise = np.tile([0.05] * 3 + [0.003] * 3, (6, 1))
    fit, _ = fit_pose_slowly(data, legs, noise, _USUAL)
    without, _ = fit_pose_slowly(
        data, tuple(leg.without_directions() for leg in legs), noise, _USUAL
    )
    found = disagreements(fit, legs, data.robot_weight_n)
    return fit, {one.name: one for one in found}, directions_agree(fit, without, legs)[1]


def mounting_errors(fit: PoseFit, seed: int) -> tuple[Array, Array]:
    """Errors of turns (rad), arms (m) and robot weight (N) over their sd, (6, 3), (6, 3), ()."""
    robot = draw_hexapod(seed)
    left = np.einsum("kij,klj->kil", fit.rot_bt, robot.rot_bt)
    turn = -Rotation.from_matrix(left).as_rotvec()
    arm = fit.arm_b_m - (robot.hip_m - robot.chassis_com_m)
    sd = np.sqrt(np.diag(fit.covariance))
    weight = fit.mounting.robot_weight_n - robot.mass_kg * GRAVITY_MPS2
    error = np.concatenate([turn.ravel(), arm.ravel(), [weight]])
    return error, np.concatenate([sd[:36], sd[-1:]])


@pytest.mark.slow
def test_a_robot_stated_too_heavy_is_told_and_a_right_one_is_not() -> None:
    _, clean, agree = fitted(31, 20.0)
    assert agree
    assert not clean
    _, told, _ = fitted(31, 20.0, too_heavy_n=2.4)
    one = told["robot.weight"]
    assert one.found - one.believed == pytest.approx(-2.4, abs=4.0 * one.found_sd)
    assert one.found_sd < 0.1


def test_slow_noise_is_whitened_exactly() -> None:
    columns, count = np.random.default_rng(3).normal(size=(300, 4)), np.arange(300)
    for share, memory in ((0.3, 8.0), (0.95, 60.0), (0.05, 1.0), (0.0, 1.0)):
        apart = np.abs(count[:, None] - count)
        law = (1.0 - share) * np.eye(300) + share * np.exp(-apart / memory)
        white, logarithm = SlowNoise(share, memory).whitened(columns)
        expected = columns.T @ np.linalg.solve(law, columns)
        assert white.T @ white == pytest.approx(expected, rel=1e-7, abs=1e-6)
        assert logarithm == pytest.approx(np.linalg.slogdet(law)[1], abs=1e-6)


def test_noise_that_lasts_from_pose_to_pose_widens_what_it_blurs() -> None:
    legs = tuple(leg_knowledge(fit) for fit in fits_of(32, 20.0).values())
    noise = np.tile([0.05] * 3 + [0.003] * 3, (6, 1))
    fresh, none = fit_pose_slowly(posed(32, slow_share=0.0), legs, noise, _USUAL)
    lasting, law = fit_pose_slowly(posed(32, slow_share=0.3), legs, noise, _USUAL)
    assert none.share == 0.0
    assert law.share == pytest.approx(0.3, abs=0.2)
    assert 3.0 < law.memory_poses < 25.0  # 8, and the grid is coarse
    # the mean of 120 errors: 0.7 / 120 + 0.3 / 120 (1 + e^-⅛)/(1 − e^-⅛) against 1 / 120
    wider = np.sqrt(np.diag(lasting.covariance)[-1] / np.diag(fresh.covariance)[-1])
    assert 1.2 < wider < 2.5


def test_legs_that_hung_one_by_one_do_not_bend_the_mounting() -> None:
    """Each leg hung 0.3° off: the joint fit blamed the noise of the poses, and was 15 sd off."""
    seed, rng = 32, np.random.default_rng(5)
    legs = tuple(leg_knowledge(fit) for fit in fits_of(seed, 20.0).values())
    tilts = Rotation.from_rotvec(rng.normal(0.0, 0.005, (len(legs), 3))).as_matrix()
    apart = tuple(
        replace(leg, gravity_dir_t=leg.gravity_dir_t @ tilt.T)
        for leg, tilt in zip(legs, tilts, strict=True)
    )
    data = replace(posed(seed, slow_share=0.0), block=np.arange(120) // 10)
    noise = np.tile([0.05] * 3 + [0.003] * 3, (6, 1))
    together, study = (
        study_mounting(
            data, some, noise, _USUAL,
            structure="auto", translation_sd_m=0.005, directions="auto", folds=2,
        )
        for some in (legs, apart)
    )  # fmt: skip
    assert together.dropped is None
    assert study.dropped is not None
    for found in (together, study):
        error, sd = mounting_errors(found.fit, seed)
        assert np.sqrt(np.mean((error / sd) ** 2)) < 2.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("turn_s", "slow_share"), [(6.0, 0.0), (20.0, 0.0), (20.0, 0.3), (20.0, 0.7)]
)
def test_mountings_are_held_by_their_intervals(turn_s: float, slow_share: float) -> None:
    errors, sds, agreed, told = [], [], 0, 0
    for seed in range(200, 210):
        fit, names, agree = fitted(seed, turn_s, slow_share=slow_share)
        error, sd = mounting_errors(fit, seed)
        errors.append(error)
        sds.append(sd)
        agreed += agree
        told += bool(names)
    ratio = np.abs(np.array(errors) / np.array(sds)) < 1.96
    parts = {"turns": slice(0, 18), "arms": slice(18, 36), "weight": slice(36, 37)}
    shares = {name: float(ratio[:, part].mean()) for name, part in parts.items()}
    case = f"pose, {turn_s:g} s/turn, slow noise {slow_share:g}"
    sys.stdout.write(f"{case}: {shares}, {agreed} agree, {told} told\n")
    assert agreed == 10
    assert min(shares["turns"], shares["arms"]) > 0.88
    assert shares["weight"] > 0.7  # of ten
