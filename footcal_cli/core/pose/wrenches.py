"""From readings to foot wrenches in the floating-base frame ([Wu], eq. (3), Figs. 8 and 9).

Floating-base frame: origin fixed in the body at the CoM of the reference shape, z up, x along the
robot's heading.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.hang.model import leg_com_t_m
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import Geometry, PoseData


@dataclass(frozen=True)
class FootCalibration:
    """All that turns one robot's readings into foot wrenches.

    Parameters
    ----------
    rot_bt, hip_b_m
        Calibrated transducer rotations (K, 3, 3) and origins in the body frame (K, 3).
    offset
        Shape (K, 6).
    leg_weight_n
        Shape (K,).
    leg_com_m
        Fourier coefficients of each leg's CoM in its transducer frame, each (3, 1 + 2 order).
    origin_b_m
        Origin of the floating-base frame in the body frame, shape (3,).
    """

    rot_bt: FloatArray
    hip_b_m: FloatArray
    offset: FloatArray
    leg_weight_n: FloatArray
    leg_com_m: tuple[FloatArray, ...]
    origin_b_m: FloatArray


def leg_coms_t_m(leg_com_m: tuple[FloatArray, ...], phase_rad: FloatArray) -> FloatArray:
    """Leg CoMs in the transducer frames at shaft angles (P, K), shape (P, K, 3), m."""
    return np.stack([leg_com_t_m(c, phase_rad[:, k]) for k, c in enumerate(leg_com_m)], axis=1)


def floating_from_body(rot_wb: FloatArray) -> FloatArray:
    """Rotation body to floating base: z up as in the world, x along the heading, (P, 3, 3)."""
    heading = np.arctan2(rot_wb[:, 1, 0], rot_wb[:, 0, 0])
    cosine, sine = np.cos(heading), np.sin(heading)
    back = np.zeros_like(rot_wb)
    back[:, 0, 0] = back[:, 1, 1] = cosine
    back[:, 0, 1], back[:, 1, 0], back[:, 2, 2] = sine, -sine, 1.0
    return np.asarray(back @ rot_wb)


def foot_wrenches(data: PoseData, calibration: FootCalibration) -> FloatArray:
    """Wrench of the ground on each foot in the floating-base frame, shape (P, K, 6), N and Nm.

    Applied wrench (measured − offset), turned into the body and carried to the origin, minus the
    leg's own weight at its CoM; then turned into the floating base.
    """
    rot, arm = calibration.rot_bt, calibration.hip_b_m - calibration.origin_b_m
    applied = data.wrench_t - calibration.offset
    force = np.einsum("kij,pkj->pki", rot, applied[..., :3])
    torque = np.einsum("kij,pkj->pki", rot, applied[..., 3:]) + np.cross(arm, force)
    weight = calibration.leg_weight_n[:, None] * data.gravity_b[:, None]
    com = arm + np.einsum("kij,pkj->pki", rot, leg_coms_t_m(calibration.leg_com_m, data.phase_rad))
    turn = floating_from_body(data.rot_wb)[:, None]
    return np.concatenate(
        [
            (turn @ (force - weight)[..., None])[..., 0],
            (turn @ (torque - np.cross(com, weight))[..., None])[..., 0],
        ],
        axis=-1,
    )


def naive_wrenches(data: PoseData, tare: FloatArray, origin_b_m: FloatArray) -> FloatArray:
    """The same with the nominal mounting and a tare (K, 6) taken once in the air ([Wu], I-B).

    The tare holds offset and leg weight together; the leg's CoM is not known.
    """
    geometry: Geometry = data.geometry
    legs = len(geometry.legs)
    calibration = FootCalibration(
        geometry.rot_bt,
        geometry.hip_b_m,
        tare,
        np.zeros(legs),
        (np.zeros((3, 1)),) * legs,
        origin_b_m,
    )
    return foot_wrenches(data, calibration)


def reference_com_b_m(
    rot_bt: FloatArray,
    hip_b_m: FloatArray,
    leg_weight_n: FloatArray,
    robot_weight_n: float,
    leg_com_m: tuple[FloatArray, ...],
    chassis_com_b_m: FloatArray,
) -> FloatArray:
    """CoM of the whole robot with every shaft at 0: origin of the floating base, shape (3,), m."""
    com_t = np.stack([leg_com_t_m(c, np.zeros(())) for c in leg_com_m])
    legs = hip_b_m + np.einsum("kij,kj->ki", rot_bt, com_t)
    chassis_n = robot_weight_n - leg_weight_n.sum()
    total = chassis_n * chassis_com_b_m + leg_weight_n @ legs
    return np.asarray(total / robot_weight_n)


def robot_com_b_m(
    calibration: FootCalibration, data: PoseData, leg_share: FloatArray
) -> FloatArray:
    """CoM of the whole robot in every pose, shape (P, 3), m in the body frame.

    Parameters
    ----------
    leg_share
        Weight of each leg over that of the robot, shape (K,).
    """
    com_t = leg_coms_t_m(calibration.leg_com_m, data.phase_rad)
    legs = calibration.hip_b_m + np.einsum("kij,pkj->pki", calibration.rot_bt, com_t)
    chassis = (1.0 - leg_share.sum()) * data.geometry.chassis_com_b_m
    return np.asarray(chassis + np.einsum("k,pki->pi", leg_share, legs))


def tare_in_the_air(
    rot_bt: FloatArray,
    offset: FloatArray,
    leg_weight_n: FloatArray,
    leg_com_m: tuple[FloatArray, ...],
) -> FloatArray:
    """What a level robot with all feet in the air and shafts at 0 would be tared with, (K, 6)."""
    down_t = leg_weight_n[:, None] * (rot_bt.swapaxes(1, 2) @ np.array([0.0, 0.0, -1.0]))
    com_t = np.stack([leg_com_t_m(c, np.zeros(())) for c in leg_com_m])
    return np.asarray(offset + np.concatenate([down_t, np.cross(com_t, down_t)], axis=1))
