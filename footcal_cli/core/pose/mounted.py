"""A calibrated mounting, and with it all that turns readings into foot wrenches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import Geometry, PoseData
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import PoseFit
from footcal_cli.core.pose.model import Structure
from footcal_cli.core.pose.problem import start_mounting
from footcal_cli.core.pose.residual import StandingResidual
from footcal_cli.core.pose.wrenches import (
    FootCalibration,
    floating_from_body,
    reference_com_b_m,
    tare_in_the_air,
)
from footcal_cli.core.spatial import rotation_exp


def error_of(data: PoseData, fit: PoseFit) -> FloatArray:
    """Chassis balance error of a fit, body frame about the chassis CoM, shape (P, 6)."""
    return data.features() @ fit.matrix.T


def offset_error(data: PoseData, legs: tuple[LegKnowledge, ...]) -> FloatArray:
    """The same with offsets and weights from hanging and the nominal mounting."""
    mounting, _ = start_mounting(data.geometry, legs, data.robot_weight_n)
    return data.features() @ StandingResidual.of(data.geometry).matrix(mounting, Structure.FULL).T


def naive_error(data: PoseData, legs: tuple[LegKnowledge, ...]) -> FloatArray:
    """The same with a tare taken in the air and the nominal mounting ([Wu], I-B and Fig. 2).

    The tare holds the legs' weight, so that the feet carry the whole robot.
    """
    mounting, _ = start_mounting(data.geometry, legs, data.robot_weight_n)
    tare = tare_in_the_air(
        data.geometry.rot_bt,
        mounting.offset,
        mounting.leg_weight_n,
        tuple(leg.com_m for leg in legs),
    )
    tared = replace(mounting, offset=tare, leg_weight_n=np.zeros(len(legs)))
    return data.features() @ StandingResidual.of(data.geometry).matrix(tared, Structure.FULL).T


def in_floating_base(data: PoseData, error: FloatArray, com_b_m: FloatArray) -> FloatArray:
    """A balance error as the sum of the ground's wrenches less the robot's weight, (P, 6).

    What the chassis lacks is what the ground's wrenches lack, carried from the chassis CoM to the
    robot's and turned into the floating base: z up, x along the heading ([Wu], Figs. 2 and 6).

    Parameters
    ----------
    error
        Body frame about the chassis CoM, shape (P, 6).
    com_b_m
        CoM of the robot in every pose, shape (P, 3).
    """
    turn = floating_from_body(data.rot_wb)
    arm = data.geometry.chassis_com_b_m - com_b_m
    moment = error[:, 3:] + np.cross(arm, error[:, :3])
    return np.concatenate(
        [(turn @ part[..., None])[..., 0] for part in (error[:, :3], moment)], axis=1
    )


@dataclass(frozen=True)
class Mounted:
    """How the transducers sit on the chassis.

    Parameters
    ----------
    rot_bt
        Transducer to body, shape (K, 3, 3).
    arm_b_m
        Chassis CoM to hip, shape (K, 3), m.
    """

    rot_bt: FloatArray
    arm_b_m: FloatArray

    @classmethod
    def of(cls, values: Mapping[str, float], geometry: Geometry) -> Mounted:
        """The mounting of a calibration, nominal for what it does not hold.

        ``R = R₀ exp[mount_rot]``, ``arm = hip₀ − CoM + R₀ mount_pos``.
        """
        rot, arm = [], []
        for k, leg in enumerate(geometry.legs):
            turn, shift = (
                np.array([values.get(f"{leg}.{kind}_{axis}", 0.0) for axis in "xyz"])
                for kind in ("mount_rot", "mount_pos")
            )
            nominal = geometry.rot_bt[k]
            rot.append(nominal @ rotation_exp(turn))
            arm.append(geometry.hip_b_m[k] - geometry.chassis_com_b_m + nominal @ shift)
        return cls(np.stack(rot), np.stack(arm))

    def feet(
        self, data: PoseData, offset: FloatArray, legs: Sequence[LegKnowledge]
    ) -> FootCalibration:
        """With the offsets (K, 6) and what hanging knows of the legs."""
        geometry = data.geometry
        hip = geometry.chassis_com_b_m + self.arm_b_m
        weight = np.array([leg.weight_n for leg in legs])
        com = tuple(leg.com_m for leg in legs)
        origin = reference_com_b_m(
            self.rot_bt, hip, weight, data.robot_weight_n, com, geometry.chassis_com_b_m
        )
        return FootCalibration(self.rot_bt, hip, offset, weight, com, origin)
