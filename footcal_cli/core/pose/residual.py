"""The experiment's residual of a standing robot, by a mounting.

Every unknown of `pose-calib` is a row of the table of effects: offset, mount_rotation,
mount_translation, leg_weight, robot_weight. What their chain and the balance make of the features
``[w_1 … w_K, ĝ, 1]`` is linear in these, and read off as many poses as there are features.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.chain import Chain, chain_of, link
from footcal_cli.core.effects.calibration import AXES, OFFSET
from footcal_cli.core.effects.six_axis import MOUNT_ROTATION, MOUNT_TRANSLATION
from footcal_cli.core.effects.six_axis_beliefs import LEG_WEIGHT, ROBOT_WEIGHT
from footcal_cli.core.experiments.pose import EXPERIMENT
from footcal_cli.core.inference.reduction import Probe
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import Geometry
from footcal_cli.core.pose.model import Mounting, Structure, arms_b_m
from footcal_cli.core.spatial import rotation_log


def standing_chain(legs: tuple[str, ...]) -> Chain:
    """All that `pose-calib` fits: offsets, mountings, and what is believed of the weights."""
    channels = tuple(f"{leg}.{axis}" for leg in legs for axis in AXES)
    every = (OFFSET, MOUNT_ROTATION, MOUNT_TRANSLATION, LEG_WEIGHT, ROBOT_WEIGHT)
    return chain_of(link(effect, channels) for effect in every)


def standing_names(legs: tuple[str, ...]) -> tuple[str, ...]:
    """Of `standing_values`: rotations, shifts, offsets, leg weights, robot weight, (13K + 1,)."""
    every = (MOUNT_ROTATION, MOUNT_TRANSLATION, OFFSET, LEG_WEIGHT)
    return (
        *(f"{leg}.{name}" for effect in every for leg in legs for name in effect.parameter_names),
        f"robot.{ROBOT_WEIGHT.parameter_names[0]}",
    )


def standing_values(geometry: Geometry, mounting: Mounting, structure: Structure) -> FloatArray:
    """A mounting along the nominal transducers' axes, and the weights, shape (13K + 1,).

    ``R_bt = R_nominal exp[mount_rot]``; a shift is the hip's *minus* that of the chassis CoM: their
    sum with p_BC is all that standing can show ([Wu]: p̃ + p_BC).
    """
    nominal = geometry.rot_bt
    shift = arms_b_m(geometry, mounting, structure) - (geometry.hip_b_m - geometry.chassis_com_b_m)
    return np.concatenate(
        [
            np.einsum("kji,kj->ki", nominal, rotation_log(mounting.turn_b)).ravel(),
            np.einsum("kji,kj->ki", nominal, shift).ravel(),
            mounting.offset.ravel(),
            mounting.leg_weight_n,
            [mounting.robot_weight_n],
        ]
    )


@dataclass(frozen=True)
class StandingResidual:
    """The balance of the chassis as a matrix M of a mounting: error ``M [w_1 … w_K, ĝ, 1]``.

    Parameters
    ----------
    probe
        Poses of a robot of which no weight is believed: all of it is correction. Its parameters
        are in the order of `standing_values`.
    """

    geometry: Geometry
    probe: Probe

    @classmethod
    def of(cls, geometry: Geometry) -> StandingResidual:
        """Of a robot with this geometry."""
        legs, features = geometry.legs, _features(len(geometry.legs))
        log = _poses(geometry, features)
        return cls(
            geometry,
            Probe.of(EXPERIMENT, standing_chain(legs), standing_names(legs), log, features),
        )

    def matrix(self, mounting: Mounting, structure: Structure) -> FloatArray:
        """M, shape (6, 6K + 4)."""
        values = standing_values(self.geometry, mounting, structure)
        return np.asarray(self.probe.coefficients(values)[0])


def _features(legs: int) -> FloatArray:
    """Each reading at 1 while the robot stands upright, then none on each side and upside down."""
    readings, size = 6 * legs, 6 * legs + 4
    features = np.eye(size)
    features[:, -1] = 1.0
    features[:readings, readings + 2] = features[-1, readings + 2] = -1.0
    return features


def _poses(geometry: Geometry, features: FloatArray) -> Log:
    """The poses of `_features`."""
    legs, poses = len(geometry.legs), len(features)
    up = -features[:, 6 * legs : -1]
    ahead = np.roll(up, 1, axis=1)
    known = {
        "hip_rot_bt": geometry.rot_bt,
        "hip_pos_b_m": geometry.hip_b_m,
        "chassis_com_b_m": geometry.chassis_com_b_m,
        "leg_weight_n": np.zeros(legs),
        "robot_weight_n": np.zeros(()),
    }
    return Log(
        EXPERIMENT.name,
        tuple(f"{leg}.{axis}" for leg in geometry.legs for axis in AXES),
        np.zeros(poses),
        features[:, : 6 * legs],
        {
            **{name: np.tile(value, (poses,) + (1,) * value.ndim) for name, value in known.items()},
            "rot_wb": np.stack([ahead, np.cross(up, ahead), up], axis=1),
        },
        np.arange(poses),
    )
