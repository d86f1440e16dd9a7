"""The joint standing fit: derivatives, truth, coverage, errors in variables, convergence, gauge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.experiments.pose import EXPERIMENT
from footcal_cli.core.parameters import FloatArray, Status
from footcal_cli.core.pose.data import pose_data, summarise
from footcal_cli.core.pose.hanging import HangRows
from footcal_cli.core.pose.joint import fit_pose
from footcal_cli.core.pose.model import (
    Mounting,
    Structure,
    balance_derivative,
    free_columns,
    moved,
    transforms,
)
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.pose.residual import StandingResidual
from footcal_cli.core.pose.wrenches import FootCalibration, foot_wrenches, naive_wrenches
from footcal_cli.core.spatial import tangent_basis
from footcal_cli.core.study.alternating import fit_alternating
from tests.core.pose_cases import HIGH, LOW, Case, case, rms
from tests.core.six_axis_data import (
    COM_M,
    TABLE_2,
    WEIGHT_N,
    Array,
    Robot,
    com_m,
    draw_robot,
    stand,
)


def angle_between_rad(first: FloatArray, second: FloatArray) -> FloatArray:
    """Angle of the rotations from the first to the second: (n, 3, 3) twice to (n,)."""
    return np.asarray(Rotation.from_matrix(np.swapaxes(first, -1, -2) @ second).magnitude())


def random_mounting(seed: int, logs: int = 4) -> Mounting:
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=(logs, 3))
    return Mounting(
        Rotation.random(6, rng=seed).as_matrix(),
        0.05 * rng.normal(size=(6, 3)),
        rng.normal(size=(6, 6)),
        rng.uniform(5, 7, size=6),
        80.0,
        direction / np.linalg.norm(direction, axis=1, keepdims=True),
    )


@pytest.mark.parametrize("structure", list(Structure))
def test_the_balance_of_a_mounting_is_the_papers(structure: Structure) -> None:
    """Σ_k T_k (w_k − o_k) + (G − Σ_k m_k g) [ĝ; 0], [Wu], eqs. (8) and (9)."""
    geometry = case(0, poses=3).data.geometry
    mounting = random_mounting(4)
    each = transforms(geometry, mounting, structure)
    wrench, down = np.random.default_rng(5).normal(size=(6, 6)), np.array([0.6, 0.0, -0.8])
    wanted = np.einsum("kij,kj->i", each, wrench - mounting.offset)
    wanted[:3] += (mounting.robot_weight_n - mounting.leg_weight_n.sum()) * down
    matrix = StandingResidual.of(geometry).matrix(mounting, structure)
    found = matrix @ np.concatenate([wrench.ravel(), down, [1.0]])
    np.testing.assert_allclose(found, wanted, atol=1e-12)


@pytest.mark.parametrize("structure", list(Structure))
def test_balance_derivative_is_that_of_the_experiments_residual(structure: Structure) -> None:
    geometry = case(0, poses=3).data.geometry
    mounting, balance = random_mounting(1), StandingResidual.of(geometry)
    derivative = balance_derivative(geometry, mounting, structure)
    tangent = tangent_basis(mounting.hang_dir_b)
    total = derivative.shape[0] + 8
    for i in range(derivative.shape[0]):
        step = np.zeros(total)
        step[i] = 1e-6
        up = balance.matrix(moved(mounting, step, tangent), structure)
        down = balance.matrix(moved(mounting, -step, tangent), structure)
        np.testing.assert_allclose(derivative[i], (up - down) / 2e-6, atol=1e-7)


def test_hanging_rows_derivative_matches_finite_differences() -> None:
    one = case(1, poses=3)
    hang, _ = HangRows.of(one.data.geometry, one.legs)
    mounting = random_mounting(2)
    tangent = tangent_basis(mounting.hang_dir_b)
    _, slope = hang.rows(one.data.geometry, mounting, tangent)
    for i in range(slope.shape[1]):
        step = np.zeros(slope.shape[1])
        step[i] = 1e-6
        up, _ = hang.rows(one.data.geometry, moved(mounting, step, tangent), tangent)
        down, _ = hang.rows(one.data.geometry, moved(mounting, -step, tangent), tangent)
        scale = max(np.abs(slope[:, i]).max(), 1.0)
        np.testing.assert_allclose(slope[:, i] / scale, (up - down) / 2e-6 / scale, atol=1e-6)


def test_a_turn_of_the_whole_robot_leaves_the_hanging_rows_alone() -> None:
    one = case(2, poses=3)
    hang, _ = HangRows.of(one.data.geometry, one.legs)
    mounting = random_mounting(3)
    tangent = tangent_basis(mounting.hang_dir_b)
    step = np.zeros(13 * 6 + 1 + 8)
    step[:18] = np.tile([0.3, -0.2, 0.5], 6)
    before, _ = hang.rows(one.data.geometry, mounting, tangent)
    after, _ = hang.rows(one.data.geometry, moved(mounting, step, tangent), tangent)
    np.testing.assert_allclose(after, before, atol=1e-6 * np.abs(before).max())


def test_structures_have_the_papers_degrees_of_freedom() -> None:
    assert [s.freedom(6) for s in Structure] == [36, 21, 21, 18, 3]
    for structure in Structure:
        assert free_columns(structure, 6, 8).shape == (87, structure.freedom(6) + 43 + 8)


def test_without_noise_the_mounting_is_exact_though_the_legs_com_moves() -> None:
    one = case(3, (1e-7, 1e-8), poses=40, hung=False)
    fit = one.fit()
    assert fit.converged
    assert np.rad2deg(angle_between_rad(fit.mounting.turn_b, one.robot.turn_b)).max() < 1e-3
    np.testing.assert_allclose(fit.arm_b_m, one.arm_b_m, atol=1e-4)


def foot_force_rmse(one: Case, fit_rot: Array, offset: Array, weight: Array) -> float:
    """Error of the ground force that the calibration alone makes, per axis, N."""
    readings = one.standing.wrench_t[..., :3] + TABLE_2[:, :3]
    force = np.einsum("kij,pkj->pki", fit_rot, readings - offset[:, :3])
    ground = force - weight[:, None] * one.data.gravity_b[:, None]
    return rms(ground - one.standing.ground_b)


@pytest.mark.slow
def test_low_noise_accuracy_and_coverage() -> None:
    angle, hip, force, standard = [], [], [], []
    for seed in range(24):
        one = case(seed)
        fit = one.fit()
        assert fit.converged
        angle.append(angle_between_rad(fit.mounting.turn_b, one.robot.turn_b))
        hip.append(np.linalg.norm(fit.arm_b_m - one.arm_b_m, axis=1))
        mounting = fit.mounting
        force.append(foot_force_rmse(one, fit.rot_bt, mounting.offset, mounting.leg_weight_n))
        estimates = fit.estimates()
        standard.append((estimates.values - one.truth) / estimates.sd)
    assert np.rad2deg(rms(np.array(angle))) <= 0.08
    assert rms(np.array(hip)) <= 0.8e-3
    assert rms(np.array(force)) <= 0.01
    covered = np.abs(np.array(standard)) < 1.96
    assert 0.90 <= covered[:, :36].mean() <= 0.98
    assert 0.90 <= covered.mean() <= 0.98


@pytest.mark.parametrize("seeds", [5, pytest.param(20, marks=pytest.mark.slow)])
def test_high_noise_errors_in_variables(seeds: int) -> None:
    plain, compensated, standard = [], [], []
    for seed in range(seeds):
        one = case(seed, HIGH)
        fit = one.fit(PoseOptions(translation_sd_m=0.005))
        compensated.append(np.linalg.norm(fit.arm_b_m - one.arm_b_m, axis=1))
        estimates = fit.estimates()
        standard.append((estimates.values - one.truth) / estimates.sd)
        bare = case(seed, HIGH, hung=False).fit(PoseOptions(errors_in_variables=False))
        plain.append(np.linalg.norm(bare.arm_b_m - case(seed, HIGH, hung=False).arm_b_m, axis=1))
    assert rms(np.array(compensated)) <= 0.25 * rms(np.array(plain))
    assert np.mean(np.abs(np.array(standard)[:, :36]) < 1.96) >= 0.88


@pytest.mark.parametrize("seeds", [10, pytest.param(20, marks=pytest.mark.slow)])
def test_high_noise_without_any_prior_is_unbiased_and_covers(seeds: int) -> None:
    along_y, covered = [], []
    for seed in range(seeds):
        one = case(seed, HIGH, friction_n=3.0)
        fit = one.fit()
        error = fit.arm_b_m - one.arm_b_m
        along_y.append(error[:, 1] * np.sign(one.arm_b_m[:, 1]))
        estimates = fit.estimates()
        covered.append(np.abs((estimates.values - one.truth) / estimates.sd)[:36] < 1.96)
    mean = np.array(along_y).mean(axis=1)
    assert abs(mean.mean()) < 3.5 * mean.std(ddof=1) / np.sqrt(len(mean))
    assert 0.88 <= np.mean(covered) <= 0.99


def test_converges_from_quarter_turns() -> None:
    for seed in range(20):
        rng = np.random.default_rng([30, seed])
        axis = rng.normal(size=(6, 3))
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        drawn = draw_robot(rng)
        robot = Robot(
            Rotation.from_rotvec(np.pi / 2 * axis).as_matrix(),
            drawn.shift_b_m,
            drawn.chassis_com_b_m,
        )
        one = case(seed, robot=robot, hung=False)
        fit = one.fit()
        assert fit.converged
        assert np.rad2deg(angle_between_rad(fit.mounting.turn_b, robot.turn_b)).max() < 0.5


def test_hanging_directions_give_relative_rotations_that_poses_alone_do_not() -> None:
    hung: list[Array] = []
    alone: list[Array] = []
    for seed in range(6):
        with_logs, without = case(seed, HIGH), case(seed, HIGH, hung=False)
        for one, out in ((with_logs, hung), (without, alone)):
            turn = one.fit().mounting.turn_b
            error = np.swapaxes(one.robot.turn_b, 1, 2) @ turn
            out.append(angle_between_rad(error[:1], error[1:]))
    assert np.rad2deg(rms(np.array(hung))) < 0.1
    assert rms(np.array(alone)) > 5 * rms(np.array(hung))


def test_gauge_only_the_sum_of_hip_and_com_shift_matters() -> None:
    one = case(4)
    shifted = replace(one.data.geometry, chassis_com_b_m=np.array([0.02, 0.01, -0.03]))
    summary = summarise(one.data)
    first = fit_pose(summary, one.legs, one.noise_sd)
    second = fit_pose(replace(summary, geometry=shifted), one.legs, one.noise_sd)
    np.testing.assert_allclose(first.arm_b_m, second.arm_b_m, atol=2e-6)
    names = first.estimates().names
    at = names.index("hl.mount_pos_x")
    moved_by = second.estimates().values[at : at + 3] - first.estimates().values[at : at + 3]
    np.testing.assert_allclose(moved_by, shifted.chassis_com_b_m, atol=2e-6)


def test_few_poses_have_full_rank_from_eight_on() -> None:
    assert case(5, poses=8, hung=False).fit().rank == 36
    assert case(5, poses=4, hung=False).fit().rank < 36


def test_twenty_poses_keep_honest_intervals() -> None:
    standard = []
    for seed in range(20):
        one = case(seed, poses=20)
        estimates = one.fit().estimates()
        standard.append((estimates.values - one.truth)[:36] / estimates.sd[:36])
    assert 0.88 <= np.mean(np.abs(standard) < 1.96) <= 0.99


def test_unknown_noise_level_is_estimated() -> None:
    one = case(6, (0.05, 0.005))
    wrong = one.noise_sd / 2.5
    fit = fit_pose(summarise(one.data), one.legs, wrong, PoseOptions(noise_known=False))
    assert fit.noise_factor == pytest.approx(2.5, rel=0.05)
    right = one.fit()
    ratio = np.sqrt(np.diag(fit.covariance) / np.diag(right.covariance))
    np.testing.assert_allclose(ratio[:36], 1.0, atol=0.05)
    assert one.fit().noise_factor == pytest.approx(1.0, abs=0.05)


def test_a_prior_that_learns_nothing_is_reported_as_such() -> None:
    one = case(7, HIGH)
    fit = one.fit(PoseOptions(translation_sd_m=1e-6, com_sd_m=1e-6, rotation_sd_rad=1e-6))
    estimates = fit.estimates()
    assert estimates.status[estimates.names.index("fl.mount_pos_x")] is Status.PRIOR_KEPT
    assert one.fit().estimates().status[0] is Status.ESTIMATED


@pytest.mark.slow
def test_the_alternating_scheme_is_right_but_stops_early_and_as_printed_is_biased() -> None:
    one = case(8, friction_n=3.0)
    com = np.stack([com_m(one.data.phase_rad[:, k]) for k in range(6)], axis=1)
    joint = rms(one.fit().arm_b_m - one.arm_b_m)
    exact = fit_alternating(one.data, TABLE_2, WEIGHT_N, com)
    printed = fit_alternating(one.data, TABLE_2, WEIGHT_N, com, printed=True)
    assert rms(exact.arm_b_m - one.arm_b_m) > 2 * joint
    assert rms(printed.arm_b_m - one.arm_b_m) > 3 * rms(exact.arm_b_m - one.arm_b_m)


def test_the_experiments_balance_is_the_estimators_residual() -> None:
    one = case(9, poses=30)
    fit = one.fit()
    error = one.data.features() @ fit.matrix.T
    log = one.standing.log
    mounting, poses = fit.mounting, len(log)
    corrected = log.with_readings(log.readings - mounting.offset.ravel()).with_known(
        hip_rot_bt=np.broadcast_to(fit.rot_bt, (poses, 6, 3, 3)),
        hip_pos_b_m=np.broadcast_to(fit.arm_b_m, (poses, 6, 3)),
        chassis_com_b_m=np.zeros((poses, 3)),
        robot_weight_n=np.full(poses, mounting.robot_weight_n),
        leg_weight_n=np.broadcast_to(mounting.leg_weight_n, (poses, 6)),
    )
    balance = EXPERIMENT.balance(corrected)
    np.testing.assert_allclose(balance.error, error, atol=1e-10)
    assert balance.valid.all()
    assert rms(balance.error[:, :3]) < 0.1


def test_true_calibration_gives_the_ground_wrenches_of_the_simulator() -> None:
    rng = np.random.default_rng(11)
    robot = draw_robot(rng)
    standing = stand(rng, robot, 20, force_sd=0.0, torque_sd=0.0)
    data = pose_data(standing.log)
    hip = data.geometry.hip_b_m + robot.shift_b_m
    calibration = FootCalibration(
        robot.rot_bt, hip, TABLE_2, WEIGHT_N, (COM_M,) * 6, robot.chassis_com_b_m
    )
    wrench = foot_wrenches(data, calibration)
    up = wrench.sum(axis=1)
    np.testing.assert_allclose(up[:, :2], 0.0, atol=1e-9)
    np.testing.assert_allclose(up[:, 2], data.robot_weight_n, atol=1e-9)
    norms = np.linalg.norm(standing.ground_b, axis=-1)
    np.testing.assert_allclose(np.linalg.norm(wrench[..., :3], axis=-1), norms, atol=1e-9)
    # The ground makes no torque about a foot: force and torque are at right angles.
    np.testing.assert_allclose(np.sum(wrench[..., :3] * wrench[..., 3:], axis=-1), 0.0, atol=1e-9)
    turned = naive_wrenches(data, TABLE_2, robot.chassis_com_b_m)
    assert np.abs(turned.sum(axis=1)[:, 2] - data.robot_weight_n).max() > 1.0


def test_changing_geometry_and_broken_readings_are_refused() -> None:
    log = stand(np.random.default_rng(12), draw_robot(np.random.default_rng(12)), 5).log
    broken = log.readings.copy()
    broken[2, 3] = np.nan
    with pytest.raises(ValueError, match="not numbers"):
        pose_data(log.with_readings(broken))
    weights = log.known["robot_weight_n"].copy()
    weights[1] += 1.0
    with pytest.raises(ValueError, match="robot_weight_n"):
        pose_data(log.with_known(robot_weight_n=weights))
    assert LOW < HIGH
