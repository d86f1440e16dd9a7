"""Rotations, rigid transforms and wrenches; every function takes stacks of vectors or matrices.

``rot_ab`` turns a vector in frame b into frame a. Wrenches are ``[force; torque]``.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations, product

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray

_LEVEL = 0.5
"""Horizontal part of a unit axis that has a heading: it leans by less than 60°."""

_WHOLE_MATRIX = 0.02
"""How far ``R Rᵀ`` of a logged matrix may be from I, from few digits."""


def whole_rows(values: FloatArray) -> BoolArray:
    """Which rows hold numbers alone, shape (n,)."""
    return np.asarray(np.isfinite(values).all(axis=tuple(range(1, values.ndim))), dtype=np.bool_)


def in_heading(
    error: FloatArray, valid: BoolArray, h: FloatArray, pairs: Sequence[tuple[int, int]],
    yaw_rad: FloatArray,
) -> tuple[FloatArray, BoolArray, FloatArray]:  # fmt: skip
    """The rows with horizontal pairs along and across the heading instead of the world's axes.

    Guards look at one row at a time, and scatter differs from axis to axis: along axes of the world
    estimates would depend on the direction in which the robot happens to stand or walk.

    Parameters
    ----------
    error, valid, h
        Of rows, shapes (n, k), (n, k), (n, k, p).
    pairs
        Rows that hold the x and the y component of a vector.
    yaw_rad
        Heading, shape (n,).
    """
    error, valid, h = error.copy(), valid.copy(), h.copy()
    cos, sin = np.cos(yaw_rad), np.sin(yaw_rad)
    for x, y in pairs:
        both = valid[:, x] & valid[:, y] & np.isfinite(yaw_rad)
        valid[:, x], valid[:, y] = both, both
        for rows, c, s in ((error, cos, sin), (h, cos[:, None], sin[:, None])):
            along, across = c * rows[:, x] + s * rows[:, y], c * rows[:, y] - s * rows[:, x]
            rows[:, x], rows[:, y] = along, across
    return error, valid, h


def rotations_of_rpy(rpy_rad: FloatArray) -> FloatArray:
    """``Rz(yaw) Ry(pitch) Rx(roll)``: (n, 3) to (n, 3, 3); NaN where an angle is not a number."""
    good = whole_rows(rpy_rad)
    rotations = np.full((len(rpy_rad), 3, 3), np.nan)
    if good.any():
        from scipy.spatial.transform import Rotation

        rotations[good, :, :] = Rotation.from_euler("xyz", rpy_rad[good]).as_matrix()
    return rotations


def rotations_of_euler(order: str, angles_rad: FloatArray) -> FloatArray:
    """Turns about axes that turn along: ``ZYZ`` is ``Rz(a1) Ry(a2) Rz(a3)``.

    Parameters
    ----------
    order
        Three axes in capitals.
    angles_rad
        Shape (n, 3); the rotation (n, 3, 3) is NaN where one is not a number.
    """
    good = whole_rows(angles_rad)
    rotations = np.full((len(angles_rad), 3, 3), np.nan)
    if good.any():
        from scipy.spatial.transform import Rotation

        rotations[good, :, :] = Rotation.from_euler(order, angles_rad[good]).as_matrix()
    return rotations


def about_axes(axes_and_angles: FloatArray) -> FloatArray:
    """Rotation vectors of axes of any length and the angles in rad about them: (n, 4) to (n, 3)."""
    axis, angle = axes_and_angles[:, :3], axes_and_angles[:, 3:]
    size = np.linalg.norm(axis, axis=1, keepdims=True)
    vector: FloatArray = np.where(
        angle == 0.0, 0.0, angle * axis / np.where(size > 0, size, np.nan)
    )
    return vector


def rotations_of_rotvec(rotvec_rad: FloatArray) -> FloatArray:
    """``exp([v]×)``: (n, 3) to (n, 3, 3); NaN where a component is not a number."""
    good = whole_rows(rotvec_rad)
    rotations = np.full((len(rotvec_rad), 3, 3), np.nan)
    if good.any():
        from scipy.spatial.transform import Rotation

        rotations[good, :, :] = Rotation.from_rotvec(rotvec_rad[good]).as_matrix()
    return rotations


def rotations_of_gravity(gravity_b: FloatArray) -> FloatArray:
    """Attitudes without a heading, from the direction of gravity in the body, of any length.

    ``Rz(0) Ry(pitch) Rx(roll)``: (n, 3) to (n, 3, 3); NaN where there is no direction.
    """
    up = -gravity_b
    roll = np.arctan2(up[:, 1], up[:, 2])
    pitch = np.arctan2(-up[:, 0], np.hypot(up[:, 1], up[:, 2]))
    angles = np.stack([roll, pitch, np.zeros(len(up))], axis=1)
    some = np.linalg.norm(up, axis=1, keepdims=True) > 0
    return rotations_of_rpy(np.where(some, angles, np.nan))


def nearest_rotations(matrices: FloatArray) -> FloatArray:
    """The rotations nearest to logged matrices (n, 3, 3).

    NaN where one is no rotation: a row is missing, or it mirrors or stretches.
    """
    good = whole_rows(matrices)
    filled = np.where(good[:, None, None], matrices, np.eye(3))
    away = np.abs(filled @ filled.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    good &= (away < _WHOLE_MATRIX) & (np.linalg.det(filled) > 0)
    u, _, vt = np.linalg.svd(filled)
    return np.where(good[:, None, None], u @ vt, np.nan)


def quaternions_of(rotations: FloatArray) -> FloatArray:
    """Quaternions x y z w of rotations: (n, 3, 3) to (n, 4), NaN where there is none."""
    good = whole_rows(rotations)
    found = np.full((len(rotations), 4), np.nan)
    if good.any():
        from scipy.spatial.transform import Rotation

        found[good] = Rotation.from_matrix(rotations[good]).as_quat()
    return found


def gravity_in(rotations: FloatArray) -> FloatArray:
    """Direction of gravity in a frame, ``Rᵀ [0 0 −1]``: rotations to world (n, 3, 3) to (n, 3)."""
    return np.asarray(-rotations[:, 2, :])


_SMALL_ANGLE_RAD = 1e-4
_EYE = np.eye(3)


def axis_rotations() -> list[FloatArray]:
    """The 24 rotations that turn axes into axes, shape (3, 3) each, none first."""
    found = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            turn = np.eye(3)[list(order)] * np.array(signs)[:, None]
            if np.linalg.det(turn) > 0:
                found.append(turn)
    return found


def skew(vector: FloatArray) -> FloatArray:
    """Matrix of the cross product, ``[v] a = v × a``: (..., 3) to (..., 3, 3)."""
    matrix = np.zeros((*vector.shape, 3))
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -z, y, -x
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = z, -y, x
    return matrix


def cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """``a × b`` of vectors that broadcast, shape (..., 3): as NumPy's, which takes 90 µs more."""
    a, b = ([v[..., 0], v[..., 1], v[..., 2]] for v in (first, second))
    product = np.empty(np.broadcast_shapes(first.shape, second.shape))
    product[..., 0] = a[1] * b[2] - a[2] * b[1]
    product[..., 1] = a[2] * b[0] - a[0] * b[2]
    product[..., 2] = a[0] * b[1] - a[1] * b[0]
    return product


def unskew(matrix: FloatArray) -> FloatArray:
    """The vector of the antisymmetric part of a matrix: (..., 3, 3) to (..., 3)."""
    return 0.5 * np.stack(
        [
            matrix[..., 2, 1] - matrix[..., 1, 2],
            matrix[..., 0, 2] - matrix[..., 2, 0],
            matrix[..., 1, 0] - matrix[..., 0, 1],
        ],
        axis=-1,
    )


def cayley(q: FloatArray) -> FloatArray:
    """Cayley rotation ``R = (I − [q])(I + [q])⁻¹``: (..., 3) to (..., 3, 3).

    With the inverse written out, ``R = ((1 − q·q) I + 2 q qᵀ − 2 [q]) / (1 + q·q)``: a turn by
    ``2 atan |q|`` about −q ([Wu], section III-B).
    """
    square = np.sum(q * q, axis=-1)[..., None, None]
    outer = q[..., :, None] * q[..., None, :]
    rotation: FloatArray = ((1.0 - square) * _EYE + 2.0 * outer - 2.0 * skew(q)) / (1.0 + square)
    return rotation


def rotation_exp(rotvec_rad: FloatArray) -> FloatArray:
    """Rotation of a rotation vector, ``exp [v]`` (Rodrigues): (..., 3) to (..., 3, 3)."""
    angle = np.linalg.norm(rotvec_rad, axis=-1)[..., None, None]
    matrix = skew(rotvec_rad)
    half = 0.5 * angle
    rotation: FloatArray = (
        _EYE
        + np.sinc(angle / np.pi) * matrix
        + 0.5 * np.sinc(half / np.pi) ** 2 * (matrix @ matrix)
    )
    return rotation


def rotation_log(rotation: FloatArray) -> FloatArray:
    """Rotation vector of a rotation, angle in [0, π]: (..., 3, 3) to (..., 3)."""
    sine_axis = unskew(rotation)
    sine = np.linalg.norm(sine_axis, axis=-1)
    cosine = 0.5 * (np.trace(rotation, axis1=-2, axis2=-1) - 1.0)
    angle = np.arctan2(sine, cosine)
    factor = np.where(sine > _SMALL_ANGLE_RAD, angle / np.where(sine > 0.0, sine, 1.0), 1.0)
    small = sine_axis * np.where(angle < 1.0, 1.0 + sine**2 / 6.0, 1.0)[..., None]
    near_pi = (sine <= _SMALL_ANGLE_RAD) & (cosine < 0.0)
    rotvec = np.where((sine > _SMALL_ANGLE_RAD)[..., None], factor[..., None] * sine_axis, small)
    if not near_pi.any():
        return rotvec
    return np.where(near_pi[..., None], angle[..., None] * _half_turn_axis(rotation), rotvec)


def _half_turn_axis(rotation: FloatArray) -> FloatArray:
    """Axis of a rotation by (nearly) π, from the largest column of ``(R + Rᵀ)/2 + I``."""
    symmetric = 0.5 * (rotation + np.swapaxes(rotation, -1, -2)) + _EYE
    largest = np.argmax(np.diagonal(symmetric, axis1=-2, axis2=-1), axis=-1)
    column = np.take_along_axis(symmetric, largest[..., None, None], axis=-1)[..., 0]
    axis: FloatArray = column / np.linalg.norm(column, axis=-1, keepdims=True)
    towards = np.sum(axis * unskew(rotation), axis=-1, keepdims=True)
    return np.where(towards < 0.0, -axis, axis)


def left_jacobian(rotvec_rad: FloatArray) -> FloatArray:
    """``J_l`` with ``exp[v + δ] ≈ exp[J_l δ] exp[v]``: (..., 3) to (..., 3, 3)."""
    angle = np.linalg.norm(rotvec_rad, axis=-1)[..., None, None]
    matrix = skew(rotvec_rad)
    safe = np.where(angle > _SMALL_ANGLE_RAD, angle, 1.0)
    third = np.where(angle > _SMALL_ANGLE_RAD, (safe - np.sin(safe)) / safe**3, 1.0 / 6.0)
    jacobian: FloatArray = (
        _EYE + 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * matrix + third * (matrix @ matrix)
    )
    return jacobian


def tangent_basis(direction: FloatArray) -> FloatArray:
    """Two unit vectors at right angles to each unit direction: (..., 3) to (..., 3, 2).

    Along a coordinate axis these are the two other coordinate axes.
    """
    least = np.argsort(np.abs(direction), axis=-1, kind="stable")[..., :1]
    first = np.take(_EYE, np.sort(least, axis=-1)[..., 0], axis=0)
    first = first - np.sum(first * direction, axis=-1, keepdims=True) * direction
    first = first / np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack([first, cross(direction, first)], axis=-1)


def wrench_transform(rot_ab: FloatArray, pos_a_m: FloatArray) -> FloatArray:
    """Carry wrenches from frame b to frame a, ``Ad(T_ba)ᵀ``: (..., 6, 6).

    ``f_a = R_ab f_b``, ``τ_a = R_ab τ_b + p × R_ab f_b`` ([Wu], section II-A).

    Parameters
    ----------
    rot_ab
        Rotation b to a, shape (..., 3, 3).
    pos_a_m
        Origin of b in a, shape (..., 3), m.
    """
    transform = np.zeros((*rot_ab.shape[:-2], 6, 6))
    transform[..., :3, :3] = rot_ab
    transform[..., 3:, 3:] = rot_ab
    transform[..., 3:, :3] = skew(pos_a_m) @ rot_ab
    return transform


def rotation_of_quaternion(quaternion: FloatArray) -> FloatArray:
    """Rotation of quaternions x y z w of any length: (..., 4) to (..., 3, 3)."""
    x, y, z, w = np.moveaxis(quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def rotations_logged(quaternion: FloatArray) -> FloatArray:
    """Rotations of logged quaternions x y z w, NaN where one is lost, shape (n, 3, 3)."""
    good = np.isfinite(quaternion).all(axis=1) & (np.linalg.norm(quaternion, axis=1) > 0.5)
    matrices = np.full((len(quaternion), 3, 3), np.nan)
    matrices[good] = rotation_of_quaternion(quaternion[good])
    return matrices


def rotation_of_rpy(rpy_rad: Sequence[float]) -> FloatArray:
    """``Rz(yaw) Ry(pitch) Rx(roll)``, shape (3, 3)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy_rad), np.sin(rpy_rad)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rpy_of_rotation(rotation: FloatArray) -> FloatArray:
    """Roll, pitch, yaw (3,) in rad of ``Rz(yaw) Ry(pitch) Rx(roll)``; roll 0 in gimbal lock."""
    level = np.hypot(rotation[0, 0], rotation[1, 0])
    pitch = np.arctan2(-rotation[2, 0], level)
    if level < 1e-9:
        return np.array([0.0, pitch, np.arctan2(-rotation[0, 1], rotation[1, 1])])
    roll = np.arctan2(rotation[2, 1], rotation[2, 2])
    return np.array([roll, pitch, np.arctan2(rotation[1, 0], rotation[0, 0])])


def headings(rotations: FloatArray) -> FloatArray:
    """Yaw of frames that turn and lean, rad, shape (n,) from (n, 3, 3).

    The direction of the x axis where that is level; of the y axis, less a quarter turn, where x
    points up or down, as it does in links of a leg: seen from above it has no direction there.
    """
    ahead, left = rotations[:, :2, 0], rotations[:, :2, 1]
    level = np.hypot(ahead[:, 0], ahead[:, 1])
    seen = level[np.isfinite(level)]
    if seen.size == 0 or np.median(seen) > _LEVEL:
        return np.asarray(np.arctan2(ahead[:, 1], ahead[:, 0]))
    return np.asarray(np.arctan2(-left[:, 0], left[:, 1]))
