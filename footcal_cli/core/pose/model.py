"""The unknowns of the chassis balance, and the derivatives of its matrix ``M``.

``M x = Σ_k T_k (w_k − o_k) + (G − Σ_k m_k g) [ĝ; 0]`` with ``T_k`` the wrench transform from
transducer k to the chassis CoM. Rotations are moved on the manifold: ``R_k ← exp[ρ] R_k``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import Geometry
from footcal_cli.core.spatial import cross, rotation_exp, skew, tangent_basis, wrench_transform

_EYE = np.eye(3)


class Structure(StrEnum):
    """Which mounting errors are free: the paper's four models ([Wu], IV-2), and a fifth.

    The paper turns each transducer about the *body origin*, so that a hip that only turned looks
    displaced by 20 mm; `HIP_ROTATIONS` turns it about its own hip.
    """

    FULL = "rotations + translations"
    BODY_ROTATIONS = "rotations about the body origin + one translation"
    HIP_ROTATIONS = "rotations about the hips + one translation"
    TRANSLATIONS = "translations only"
    SINGLE = "one translation"

    @property
    def rotates(self) -> bool:
        """Whether each transducer may be turned."""
        return self in (Structure.FULL, Structure.BODY_ROTATIONS, Structure.HIP_ROTATIONS)

    @property
    def each_translates(self) -> bool:
        """Whether each transducer may be shifted on its own."""
        return self in (Structure.FULL, Structure.TRANSLATIONS)

    @property
    def with_translations(self) -> Structure:
        """The same rotations, every hip free to shift."""
        return Structure.FULL if self.rotates else Structure.TRANSLATIONS

    def freedom(self, legs: int) -> int:
        """Degrees of freedom (36, 21, 21, 18, 3 for six legs)."""
        return 3 * legs * self.rotates + (3 * legs if self.each_translates else 3)


@dataclass(frozen=True)
class Mounting:
    """A point in the space of the unknowns.

    Parameters
    ----------
    turn_b
        Mounting rotation per leg, left of the nominal one, shape (K, 3, 3).
    shift_b_m
        Translation per leg, shape (K, 3), m: of the hip, or of the body origin's image under
        `BODY_ROTATIONS`; always minus the shift of the chassis CoM (an exact gauge).
    offset
        Wrench without load, shape (K, 6).
    leg_weight_n
        Shape (K,).
    hang_dir_b
        Direction of gravity in the body frame in each hanging log, shape (L, 3).
    """

    turn_b: FloatArray
    shift_b_m: FloatArray
    offset: FloatArray
    leg_weight_n: FloatArray
    robot_weight_n: float
    hang_dir_b: FloatArray

    @cached_property
    def tangent(self) -> FloatArray:
        """Two directions at right angles to each of `hang_dir_b`, shape (L, 3, 2)."""
        return tangent_basis(self.hang_dir_b)


def arms_b_m(geometry: Geometry, mounting: Mounting, structure: Structure) -> FloatArray:
    """Chassis CoM to hip, shape (K, 3), m."""
    hip = geometry.hip_b_m
    if structure is Structure.BODY_ROTATIONS:
        hip = (mounting.turn_b @ hip[..., None])[..., 0]
    return np.asarray(hip - geometry.chassis_com_b_m + mounting.shift_b_m)


def transforms(geometry: Geometry, mounting: Mounting, structure: Structure) -> FloatArray:
    """``T_k``: wrench at transducer k to wrench at the chassis CoM, body axes, (K, 6, 6)."""
    rot = mounting.turn_b @ geometry.rot_bt
    return wrench_transform(rot, arms_b_m(geometry, mounting, structure))


def balance_derivative(geometry: Geometry, mounting: Mounting, structure: Structure) -> FloatArray:
    """``dM/dθ`` of rotations, shifts, offsets, leg weights, robot weight, (13K + 1, 6, 6K + 4)."""
    each = transforms(geometry, mounting, structure)
    legs = each.shape[0]
    rot = mounting.turn_b @ geometry.rot_bt
    arm = skew(arms_b_m(geometry, mounting, structure))
    turned = skew(_EYE)[None] @ rot[:, None]
    turning = np.zeros((legs, 3, 6, 6))
    turning[..., :3, :3] = turning[..., 3:, 3:] = turned
    turning[..., 3:, :3] = arm[:, None] @ turned
    if structure is Structure.BODY_ROTATIONS:
        hip = (mounting.turn_b @ geometry.hip_b_m[..., None])[..., 0]
        moved = cross(_EYE[None], hip[:, None])
        turning[..., 3:, :3] += skew(moved) @ rot[:, None]
    shifting = np.zeros((legs, 3, 6, 6))
    shifting[..., 3:, :3] = turned

    derivative = np.zeros((13 * legs + 1, 6, 6 * legs + 4))
    leg = np.arange(legs)
    for first, moves in ((0, turning), (3 * legs, shifting)):
        own = derivative[first : first + 3 * legs].reshape(legs, 3, 6, -1)
        own[..., : 6 * legs].reshape(legs, 3, 6, legs, 6)[leg, :, :, leg] = moves  # a view
        own[..., -1] = -(moves @ mounting.offset[:, None, :, None])[..., 0]
    own = derivative[6 * legs : 12 * legs].reshape(legs, 6, 6, -1)
    own[..., -1] = -np.swapaxes(each, 1, 2)
    weights = slice(12 * legs, 13 * legs)
    derivative[weights, :3, 6 * legs : -1] = -_EYE
    derivative[-1, :3, 6 * legs : -1] = _EYE
    return derivative


def moved(mounting: Mounting, step: FloatArray, tangent: FloatArray) -> Mounting:
    """Move by a step of (13K + 1 + 2L,); the last 2L along the hanging directions' tangents.

    The hanging directions also follow the mean turn of all legs: a turn of the whole robot, which
    hanging cannot see, then leaves what hanging does see exactly as it was.
    """
    legs, logs = mounting.turn_b.shape[0], mounting.hang_dir_b.shape[0]
    sizes = np.cumsum([3 * legs, 3 * legs, 6 * legs, legs, 1])
    turn, shift, offset, leg_weight, weight, lean = np.split(step, sizes)
    direction = mounting.hang_dir_b + (tangent @ lean.reshape(logs, 2, 1))[..., 0]
    direction = direction @ rotation_exp(turn.reshape(legs, 3).mean(axis=0)).T
    return replace(
        mounting,
        turn_b=rotation_exp(turn.reshape(legs, 3)) @ mounting.turn_b,
        shift_b_m=mounting.shift_b_m + shift.reshape(legs, 3),
        offset=mounting.offset + offset.reshape(legs, 6),
        leg_weight_n=mounting.leg_weight_n + leg_weight,
        robot_weight_n=mounting.robot_weight_n + float(weight[0]),
        hang_dir_b=direction / np.linalg.norm(direction, axis=1, keepdims=True),
    )


def free_columns(structure: Structure, legs: int, others: int) -> FloatArray:
    """``d(all unknowns) / d(free ones)``: ties and drops unknowns, shape (13K + 1 + 2L, n)."""
    rotations = np.eye(3 * legs) if structure.rotates else np.zeros((3 * legs, 0))
    shifts = np.eye(3 * legs) if structure.each_translates else np.tile(_EYE, (legs, 1))
    total = 13 * legs + 1 + others
    rest = np.eye(7 * legs + 1 + others)
    columns = np.zeros((total, rotations.shape[1] + shifts.shape[1] + rest.shape[1]))
    columns[: 3 * legs, : rotations.shape[1]] = rotations
    first = rotations.shape[1] + shifts.shape[1]
    columns[3 * legs : 6 * legs, rotations.shape[1] : first] = shifts
    columns[6 * legs :, first:] = rest
    return columns
