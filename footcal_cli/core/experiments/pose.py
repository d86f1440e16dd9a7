"""Standing pose: the transducers together hold up the chassis, and nothing turns it."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.calibration import AXIS_UNITS, OFFSET
from footcal_cli.core.effects.six_axis import MOUNT_ROTATION, MOUNT_TRANSLATION
from footcal_cli.core.experiments.contract import Balance, Experiment
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import cross

OUTPUTS = ("fx", "fy", "fz", "mx", "my", "mz")


def pose_balance(log: Log) -> Balance:
    """Sum of the wrenches on the chassis in the body frame about its CoM, shape (n, 6).

    ``Σ_k R_k f_k + (G − Σ_k m_k g) ĝ`` and ``Σ_k [R_k τ_k + (p_k − c) × R_k f_k]``: [Wu], eqs.
    (8) and (9), in the exact form in which no leg CoM enters.
    """
    known = log.known
    legs = len(log.channels) // 6
    wrench = log.readings.reshape(len(log), legs, 6)
    force = np.einsum("nkij,nkj->nki", known["hip_rot_bt"], wrench[..., :3])
    torque = np.einsum("nkij,nkj->nki", known["hip_rot_bt"], wrench[..., 3:])
    arm = known["hip_pos_b_m"] - known["chassis_com_b_m"][:, None]
    error = np.concatenate(
        [force.sum(axis=1) + log.of_known(_chassis), (torque + cross(arm, force)).sum(axis=1)],
        axis=1,
    )
    return Balance(OUTPUTS, AXIS_UNITS, error, np.isfinite(error))


def _chassis(log: Log) -> FloatArray:
    """Weight of the chassis without legs, in the body frame, shape (n, 3)."""
    known = log.known
    chassis_n = known["robot_weight_n"] - known["leg_weight_n"].sum(axis=1)
    return np.asarray(chassis_n[:, None] * -known["rot_wb"][:, 2, :])


EXPERIMENT = Experiment(
    name="pose",
    known={
        "phase_rad": "shaft angles, (n, K), rad",
        "rot_wb": "rotation body to world, (n, 3, 3)",
        "hip_rot_bt": "nominal rotation transducer to body, (n, K, 3, 3)",
        "hip_pos_b_m": "nominal transducer origins in the body frame, (n, K, 3), m",
        "chassis_com_b_m": "CoM of the robot without legs, body frame, (n, 3), m",
        "robot_weight_n": "weight of the whole robot, (n,), N",
        "leg_weight_n": "weight of each leg, (n, K), N",
        "contact": "1 on the ground, 0 lifted, (n, K)",
    },
    balance=pose_balance,
    calibration=(OFFSET.name, MOUNT_ROTATION.name, MOUNT_TRANSLATION.name),
)
