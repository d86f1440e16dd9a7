"""A tilt of the marker body and a turn of all mountings: one in every pose, and said so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.pose.common import (
    COMMON_P,
    MACHINED_SD_M,
    ODD_P,
    common_shift,
    common_turn,
    odd_hip,
)
from footcal_cli.core.pose.data import pose_data, summarise
from footcal_cli.core.pose.joint import fit_pose
from footcal_cli.core.pose.leg_map import leg_map
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.spatial import rotation_log
from footcal_cli.sheets.pose.findings import findings
from tests.core.pose_cases import Case, case
from tests.core.six_axis_data import draw_robot

TILT = np.deg2rad([1.5, -2.0])


def _believed(found: Case, tilt_rad: np.ndarray) -> Case:
    """The same poses with a body frame that the markers tilt: true R_wb = believed R_wb R."""
    log = found.standing.log
    turn = Rotation.from_rotvec([*tilt_rad, 0.0]).as_matrix()
    known = {**log.known, "rot_wb": log.known["rot_wb"] @ turn.T}
    return replace(found, data=pose_data(replace(log, known=known)))


def _turns(found: Case) -> np.ndarray:
    free = PoseOptions(com_sd_m=0.05)
    fit = fit_pose(summarise(found.data), found.legs, found.noise_sd, free)
    return rotation_log(fit.mounting.turn_b)


def test_a_tilt_of_the_markers_is_the_common_turn_of_the_mountings() -> None:
    straight = case(3, hung=False)
    before, after = (common_turn(_turns(c)) for c in (straight, _believed(straight, TILT)))
    assert before is not None
    assert after is not None
    # to second order in the mountings' own turns, 35 mrad
    assert after.turn_rad - before.turn_rad == pytest.approx(TILT, abs=0.05 * np.abs(TILT).max())


def test_it_stands_out_from_mountings_that_scatter_less_and_the_report_names_both() -> None:
    robot = draw_robot(np.random.default_rng(5), rotation_sd_rad=0.003)
    for tilt, expected in ((np.zeros(2), False), (TILT, True)):
        found = _believed(case(5, robot=robot, hung=False), tilt)
        fit = fit_pose(summarise(found.data), found.legs, found.noise_sd, PoseOptions())
        said = findings(fit, leg_map(found.data, fit, found.noise_sd))
        mine = [f for f in said if f.code == "mountings_turned_alike"]
        assert bool(mine) is expected
        assert all("body_tilt" in f.sentence and "mount_rotation" in f.sentence for f in mine)


def test_mountings_that_only_scatter_are_told_of_as_often_as_the_level_says() -> None:
    rng = np.random.default_rng(7)
    mixed = np.array([[0.02, 0.01, 0.0], [0.0, 0.015, 0.0], [0.0, 0.0, 0.03]])
    found = [common_turn(rng.standard_normal((6, 3)) @ mixed) for _ in range(6000)]
    alarms = sum(c is not None and c.stands_out for c in found)
    assert alarms == pytest.approx(6000 * COMMON_P, abs=4 * np.sqrt(6000 * COMMON_P))
    covered = np.mean([np.abs(c.turn_rad) < c.half_rad for c in found if c is not None])
    assert covered == pytest.approx(0.95, abs=0.01)


def test_too_few_legs_and_a_turn_shared_by_design_say_nothing() -> None:
    assert common_turn(np.full((3, 3), 0.01)) is None
    assert common_turn(np.full((6, 3), 0.01)) is None


def test_a_shared_shift_is_the_chassis_com_with_honest_sd_and_few_false_alarms() -> None:
    rng, hip, com = np.random.default_rng(4), 0.005, 0.05
    error, alarms = [], 0
    seen = np.array([1e-4, 1e-4, 5e-4])
    for _ in range(2000):
        where = rng.normal(0, com, 3)
        noise = rng.normal(0.0, seen)
        found = common_shift(rng.normal(0, hip, (6, 3)) - where + noise, seen, hip, com)
        error.append((found.com_b_m - where) / found.sd_m)
        alarms += common_shift(rng.normal(0, hip, (6, 3)) + noise, seen, hip, com).stands_out
    assert np.std(error) == pytest.approx(1.0, abs=0.03)
    assert alarms <= 8  # 2 expected of 2000


def test_a_com_elsewhere_is_named_with_its_place() -> None:
    found = case(7, hung=False)
    geometry = found.data.geometry
    fit = found.fit(PoseOptions(translation_sd_m=0.005, com_sd_m=0.05))
    shift = fit.arm_b_m - (geometry.hip_b_m - geometry.chassis_com_b_m)
    shared = common_shift(shift, np.zeros(3), 0.005, 0.05)
    truth = found.robot.chassis_com_b_m - geometry.chassis_com_b_m
    assert np.linalg.norm(truth) > 0.01
    assert np.abs((shared.com_b_m - truth) / shared.sd_m).max() < 3.5
    mapped = leg_map(found.data, fit, found.noise_sd)
    for com_given, severity in ((True, "note"), (False, "warning")):
        said = {one.code: one.severity for one in findings(fit, mapped, com_given=com_given)}
        assert said["chassis_com_elsewhere"] == severity


def _hips(seed: int, off_m: np.ndarray, odd: int) -> tuple[np.ndarray, np.ndarray]:
    """Shifts of four hips that share a CoM's, machined to a millimetre, one of them elsewhere."""
    rng = np.random.default_rng([seed, 31])
    sd = rng.uniform(0.5e-3, 1.5e-3, 12)
    shift = rng.normal(0.0, 0.01, 3) + rng.normal(0.0, MACHINED_SD_M, (4, 3))
    shift[odd] += off_m
    return shift + rng.normal(0.0, 1.0, (4, 3)) * sd.reshape(4, 3), np.diag(sd**2)


def test_a_hip_that_lies_elsewhere_is_said_with_its_shift_and_honest_sd() -> None:
    off, errors, said = np.array([0.007, 0.0, -0.005]), [], 0
    for seed in range(200):
        found = odd_hip(*_hips(seed, off, odd=2))
        if found is not None:
            assert found.leg == 2
            errors.append((found.shift_b_m - off) / found.sd_m)
            said += 1
    assert said > 150
    assert np.std(errors) == pytest.approx(1.0, abs=0.15)


def test_hips_that_only_scatter_are_rarely_called_odd() -> None:
    said = sum(odd_hip(*_hips(seed, np.zeros(3), odd=0)) is not None for seed in range(600))
    assert said <= 600 * ODD_P + 3.0 * np.sqrt(600 * ODD_P)
    assert odd_hip(np.zeros((3, 3)), np.eye(9)) is None
