"""Rotations as URDF writes them."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import FloatArray


def rpy_of(rotation: FloatArray) -> FloatArray:
    """Roll, pitch, yaw (3,) in rad of ``Rz(yaw) Ry(pitch) Rx(roll)``; roll 0 in gimbal lock."""
    level = np.hypot(rotation[0, 0], rotation[1, 0])
    pitch = np.arctan2(-rotation[2, 0], level)
    if level < 1e-9:
        return np.array([0.0, pitch, np.arctan2(-rotation[0, 1], rotation[1, 1])])
    roll = np.arctan2(rotation[2, 1], rotation[2, 2])
    return np.array([roll, pitch, np.arctan2(rotation[1, 0], rotation[0, 0])])
