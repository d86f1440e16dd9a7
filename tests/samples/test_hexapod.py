"""The physics hexapod obeys statics, and says the truth about itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")

import hexapod as hx
from hexapod_model import GRAVITY_MPS2, LEG_WEIGHT_N, LEGS, TOTAL_MASS_KG, draw_hexapod

SEED = 3


@pytest.mark.parametrize("orientation", list(hx.ORIENTATIONS))
def test_hanging_leg_reads_its_own_weight_along_gravity(orientation: str) -> None:
    robot = draw_hexapod(SEED, mount_rotation_sd_rad=0.0, mount_offset_sd_m=0.0)
    log = hx.hang(robot, orientation, SEED, cycles=1, tilt_sd_rad=0.0)
    column = "fx_n" if orientation.endswith("x") else "fz_n"
    sign = 1.0 if orientation.startswith("+") else -1.0
    for leg, force in log.table.groupby("leg")[column].mean().items():
        turned = -1.0 if column == "fx_n" and str(leg).endswith("r") else 1.0
        assert force == pytest.approx(sign * turned * LEG_WEIGHT_N[str(leg)], abs=0.003)


def test_hanging_torque_is_leg_com_cross_weight() -> None:
    robot = draw_hexapod(SEED)
    log = hx.hang(robot, "-z", SEED, cycles=1)
    residual = hx.hang_residual(robot, log)
    assert np.abs(residual[..., :3]).max() < 0.005
    assert np.abs(residual[..., 3:]).max() < 0.0005
    swing = log.table.groupby("leg")["ty_nm"].agg(np.ptp)
    assert swing.min() > 2 * 0.025 * 6.0, "the leg's CoM moves by some 3 cm"


@pytest.mark.slow
def test_tilts_differ_between_logs_and_keep_the_axis() -> None:
    robot = draw_hexapod(SEED)
    logs = {name: hx.hang(robot, name, SEED, cycles=1) for name in hx.ORIENTATIONS}
    tilts = np.array([log.tilt_rotvec_rad for log in logs.values()])
    assert len(np.unique(tilts.round(6), axis=0)) == 4
    for name, log in logs.items():
        for leg, direction in zip(robot.legs, log.gravity_dir_t, strict=True):
            nominal = leg.rot_nominal.T @ np.array(hx.ORIENTATIONS[name])
            assert np.rad2deg(np.arccos(direction @ nominal)) < 12.0


def test_chassis_and_feet_balance_in_standing_poses() -> None:
    robot = draw_hexapod(SEED)
    for table in (hx.stand(robot, 12, SEED), hx.stand_tripod(robot, 4, SEED)):
        assert np.abs(hx.chassis_residual(robot, table)[:, :3]).max() < 0.05
        assert np.abs(hx.chassis_residual(robot, table)[:, 3:]).max() < 0.005
        assert np.abs(hx.foot_residual(robot, table)).max() < 0.02
        weight = table["ground_fz_w_n"].groupby(table["pose"]).sum()
        assert weight.to_numpy() == pytest.approx(TOTAL_MASS_KG * GRAVITY_MPS2, abs=0.05)


def test_tripods_lift_three_feet_and_friction_holds_internal_forces() -> None:
    robot = draw_hexapod(SEED)
    tripod = hx.stand_tripod(robot, 4, SEED)
    lifted = ~tripod["contact"].to_numpy().reshape(-1, len(LEGS))
    assert (lifted[:2] == ~hx.LEFT_TRIPOD).all()
    assert (lifted[2:] == hx.LEFT_TRIPOD).all()
    poses = hx.stand(robot, 12, SEED)
    assert poses["ground_fx_w_n"].std() > 1.0
    assert poses["ground_fx_w_n"].groupby(poses["pose"]).sum().abs().max() < 0.05


def test_wrong_mounting_breaks_the_balance() -> None:
    robot = draw_hexapod(SEED)
    nominal = draw_hexapod(SEED, mount_rotation_sd_rad=0.0, mount_offset_sd_m=0.0)
    table = hx.stand(robot, 6, SEED)
    assert np.abs(hx.chassis_residual(nominal, table)[:, :3]).max() > 0.2


@pytest.mark.slow
def test_walk_turns_right_and_repeats() -> None:
    robot = draw_hexapod(SEED)
    table = hx.walk(robot, 1)
    error = np.linalg.norm(hx.chassis_residual(robot, table), axis=1)
    assert np.median(error) < 0.05
    assert table["contact"].groupby(table["leg"]).mean().between(0.4, 0.7).all()
    yaw = 2 * np.rad2deg(np.arctan2(table["body_qz"].to_numpy(), table["body_qw"].to_numpy()))
    assert -15.0 < yaw[-1] - yaw[0] < -4.0


def test_same_seed_same_bytes(tmp_path: Path) -> None:
    for name in ("first", "second"):
        table = hx.stand_still(draw_hexapod(SEED), 2, SEED, dwell_s=1.0)
        hx.write_parquet(table, tmp_path / name)
    assert (tmp_path / "first").read_bytes() == (tmp_path / "second").read_bytes()
    other = hx.stand_still(draw_hexapod(SEED), 2, SEED + 1, dwell_s=1.0)
    assert not other.equals(table)
