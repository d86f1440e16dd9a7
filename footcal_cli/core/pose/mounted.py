"""A calibrated mounting, and with it all that turns readings into foot wrenches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import Geometry, PoseData
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.wrenches import FootCalibration, reference_com_b_m
from footcal_cli.core.spatial import rotation_exp


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
