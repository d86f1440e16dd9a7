"""Balance in the floating base (Figs. 2 and 6), and which legs step together (Figs. 8 and 9)."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.pose.mounted import in_floating_base, offset_error
from footcal_cli.core.pose.wrenches import (
    FootCalibration,
    floating_from_body,
    foot_wrenches,
    reference_com_b_m,
    robot_com_b_m,
)
from footcal_cli.plots.feet import stepping_together
from tests.core.pose_cases import case


def test_the_balance_is_the_sum_of_foot_wrenches_about_the_moving_com() -> None:
    """What the chassis lacks, carried over, is what the feet's wrenches lack of the weight."""
    one = case(4, poses=40, hung=False)
    data, geometry = one.data, one.data.geometry
    weight = np.array([leg.weight_n for leg in one.legs])
    com = tuple(leg.com_m for leg in one.legs)
    origin = reference_com_b_m(
        geometry.rot_bt, geometry.hip_b_m, weight, data.robot_weight_n, com,
        geometry.chassis_com_b_m,
    )  # fmt: skip
    nominal = FootCalibration(
        geometry.rot_bt, geometry.hip_b_m, np.stack([leg.offset for leg in one.legs]), weight,
        com, origin,
    )  # fmt: skip
    robot_com = robot_com_b_m(nominal, data, weight / data.robot_weight_n)
    total = foot_wrenches(data, nominal).sum(axis=1)
    back = np.einsum("pij,pj->pi", floating_from_body(data.rot_wb), robot_com - origin)
    moment = total[:, 3:] - np.cross(back, total[:, :3])
    wanted = np.concatenate([total[:, :3] - [0.0, 0.0, data.robot_weight_n], moment], axis=1)
    found = in_floating_base(data, offset_error(data, one.legs), robot_com)
    np.testing.assert_allclose(found, wanted, atol=1e-9)
    assert np.abs(found).max() > 0.1


def test_tripods_are_the_legs_whose_shafts_agree() -> None:
    turn = np.linspace(0.0, 20.0, 400)
    late = np.array([0.0, np.pi, 0.1, np.pi + 0.1, -0.1, np.pi])
    phase = np.mod(turn[:, None] + late, 2 * np.pi)
    assert stepping_together(phase) == ((0, 2, 4), (1, 3, 5))
    wandering = np.mod(np.outer(turn, np.arange(1.0, 5.0)), 2 * np.pi)
    assert stepping_together(wandering) == ((0,), (1,), (2,), (3,))
