"""Standing poses as features of a linear balance, and their Gram matrix.

The chassis is held up by K transducers and pulled down by its own weight. In the body frame and
about the chassis CoM that is ``M x = 0`` with features ``x = [w_1 … w_K, ĝ, 1]`` (ĝ the direction
of gravity in the body) and a 6 × (6K + 4) matrix M of the unknowns. The cost of any M is then a
function of ``S = Σ_p x xᵀ`` alone: no iteration ever sees the poses again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Geometry:
    """The design file: where the transducers should be.

    Parameters
    ----------
    rot_bt
        Nominal rotation transducer to body, shape (K, 3, 3).
    hip_b_m
        Nominal transducer origins in the body frame, shape (K, 3), m.
    chassis_com_b_m
        Believed CoM of the chassis (robot without legs) in the body frame, shape (3,), m.
    """

    legs: tuple[str, ...]
    rot_bt: FloatArray
    hip_b_m: FloatArray
    chassis_com_b_m: FloatArray


@dataclass(frozen=True)
class PoseData:
    """Poses ready to be balanced.

    Parameters
    ----------
    wrench_t
        Readings, shape (P, K, 6), N and Nm.
    phase_rad
        Shaft angles, shape (P, K).
    gravity_b
        Unit direction of gravity in the body frame, shape (P, 3).
    rot_wb
        Body to world, shape (P, 3, 3).
    contact
        1 on the ground, 0 lifted, nan unknown, shape (P, K).
    leg_weight_n
        Believed weight of each leg, shape (K,).
    block
        Group of each pose, shape (P,); poses of one block stay together in cross-validation.
    """

    geometry: Geometry
    wrench_t: FloatArray
    phase_rad: FloatArray
    gravity_b: FloatArray
    rot_wb: FloatArray
    contact: FloatArray
    robot_weight_n: float
    leg_weight_n: FloatArray
    block: IntArray

    def __len__(self) -> int:
        return int(self.wrench_t.shape[0])

    def only(self, keep: BoolArray) -> PoseData:
        """Some of the poses."""
        return replace(
            self, wrench_t=self.wrench_t[keep], phase_rad=self.phase_rad[keep],
            gravity_b=self.gravity_b[keep], rot_wb=self.rot_wb[keep], contact=self.contact[keep],
            block=self.block[keep],
        )  # fmt: skip

    def features(self) -> FloatArray:
        """``x = [w_1 … w_K, ĝ, 1]`` per pose, shape (P, 6K + 4)."""
        poses, legs, _ = self.wrench_t.shape
        x = np.empty((poses, 6 * legs + 4))
        x[:, : 6 * legs] = self.wrench_t.reshape(poses, 6 * legs)
        x[:, 6 * legs : -1] = self.gravity_b
        x[:, -1] = 1.0
        return x


def pose_data(log: Log) -> PoseData:
    """Arrays of a pose log.

    Raises
    ------
    ValueError
        Where readings are not numbers, or the nominal mounting changes from pose to pose.
    """
    legs = tuple(dict.fromkeys(channel.split(".")[0] for channel in log.channels))
    known = log.known
    if not np.isfinite(log.readings).all():
        raise ValueError("readings that are not numbers: drop those poses first")
    for name in ("hip_rot_bt", "hip_pos_b_m", "chassis_com_b_m", "robot_weight_n", "leg_weight_n"):
        if not np.array_equal(known[name], np.broadcast_to(known[name][:1], known[name].shape)):
            raise ValueError(f"{name} changes from pose to pose; one robot, one geometry")
    return PoseData(
        Geometry(
            legs,
            known["hip_rot_bt"][0],
            known["hip_pos_b_m"][0],
            known["chassis_com_b_m"][0],
        ),
        log.readings.reshape(len(log), len(legs), 6),
        known["phase_rad"],
        -known["rot_wb"][:, 2, :],
        known["rot_wb"],
        known.get("contact", np.full((len(log), len(legs)), np.nan)),
        float(known["robot_weight_n"][0]),
        known["leg_weight_n"][0],
        log.block,
    )


@dataclass(frozen=True)
class PoseSummary:
    """All that a fit needs of the poses.

    Parameters
    ----------
    gram
        ``Σ_p x xᵀ``, shape (6K + 4, 6K + 4).
    robot_weight_n, leg_weight_n
        As in `PoseData`.
    """

    geometry: Geometry
    gram: FloatArray
    poses: int
    robot_weight_n: float
    leg_weight_n: FloatArray

    def without(self, other: PoseSummary) -> PoseSummary:
        """The poses that are not in `other`."""
        return PoseSummary(
            self.geometry,
            self.gram - other.gram,
            self.poses - other.poses,
            self.robot_weight_n,
            self.leg_weight_n,
        )


def summarise(data: PoseData, chosen: IntArray | None = None) -> PoseSummary:
    """Gram matrix of all poses, or of the chosen ones."""
    x = data.features()
    if chosen is not None:
        x = x[chosen]
    return PoseSummary(data.geometry, x.T @ x, x.shape[0], data.robot_weight_n, data.leg_weight_n)
