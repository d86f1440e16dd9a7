"""Attitudes as logs have them (quaternion, angles, rotation vector, matrix) as rotations."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from footcal_cli.core.parameters import BoolArray, FloatArray

_WHOLE_MATRIX = 0.02
"""How far ``R Rᵀ`` of a logged matrix may be from I, from few digits."""


def _whole(values: FloatArray) -> BoolArray:
    """Which rows hold numbers alone, shape (n,)."""
    return np.asarray(np.isfinite(values).reshape(len(values), -1).all(axis=1), dtype=np.bool_)


def rotations_of_rpy(rpy_rad: FloatArray) -> FloatArray:
    """``Rz(yaw) Ry(pitch) Rx(roll)``: (n, 3) to (n, 3, 3); NaN where an angle is not a number."""
    good = _whole(rpy_rad)
    rotations = np.full((len(rpy_rad), 3, 3), np.nan)
    if good.any():
        rotations[good, :, :] = Rotation.from_euler("xyz", rpy_rad[good]).as_matrix()
    return rotations


def rotations_of_rotvec(rotvec_rad: FloatArray) -> FloatArray:
    """``exp([v]×)``: (n, 3) to (n, 3, 3); NaN where a component is not a number."""
    good = _whole(rotvec_rad)
    rotations = np.full((len(rotvec_rad), 3, 3), np.nan)
    if good.any():
        rotations[good, :, :] = Rotation.from_rotvec(rotvec_rad[good]).as_matrix()
    return rotations


def nearest_rotations(matrices: FloatArray) -> FloatArray:
    """The rotations nearest to logged matrices (n, 3, 3).

    NaN where one is no rotation: a row is missing, or it mirrors or stretches.
    """
    good = _whole(matrices)
    filled = np.where(good[:, None, None], matrices, np.eye(3))
    away = np.abs(filled @ filled.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    good &= (away < _WHOLE_MATRIX) & (np.linalg.det(filled) > 0)
    u, _, vt = np.linalg.svd(filled)
    return np.where(good[:, None, None], u @ vt, np.nan)


def rotations_of_quaternions(quaternions: FloatArray) -> FloatArray:
    """Quaternions x y z w of any length as rotations: (n, 4) to (n, 3, 3), NaN for none."""
    good = _whole(quaternions) & (np.linalg.norm(np.nan_to_num(quaternions), axis=1) > 0)
    rotations = np.full((len(quaternions), 3, 3), np.nan)
    if good.any():
        rotations[good, :, :] = Rotation.from_quat(quaternions[good]).as_matrix()
    return rotations


def quaternions_of(rotations: FloatArray) -> FloatArray:
    """Quaternions x y z w of rotations: (n, 3, 3) to (n, 4), NaN where there is none."""
    good = _whole(rotations)
    found = np.full((len(rotations), 4), np.nan)
    if good.any():
        found[good] = Rotation.from_matrix(rotations[good]).as_quat()
    return found


def turned_up(rotations: FloatArray, up: str) -> FloatArray:
    """Rotations to a world whose axis `up` (``+y``, ``-z``) points up, as those to one with z up.

    Parameters
    ----------
    rotations
        Body to world, shape (n, 3, 3).
    up
        Sign and axis. The components of a left-handed world are turned as those of a right-handed
        one: gravity in the body is the same.
    """
    axis = np.eye(3)["xyz".index(up[1])] * (1.0 if up[0] == "+" else -1.0)
    # a half turn about the bisector takes `up` to z; where they are opposite, about x
    half = axis + np.array([0.0, 0.0, 1.0])
    half = half if half.any() else np.array([1.0, 0.0, 0.0])
    turn = Rotation.from_rotvec(np.pi * half / np.linalg.norm(half)).as_matrix()
    return np.asarray(np.round(turn) @ rotations)


def gravity_in(rotations: FloatArray) -> FloatArray:
    """Direction of gravity in a frame, ``Rᵀ [0 0 −1]``: rotations to world (n, 3, 3) to (n, 3)."""
    return np.asarray(-rotations[:, 2, :])
