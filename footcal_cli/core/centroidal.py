"""Newton-Euler of the whole robot: what the ground must do for the body to move as it does.

Frames: world, x forward, y left, z up, ground at z = 0. [NAO], section 3.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray

MIN_FORCE_N = 5.0
"""Vertical force below which a centre of pressure means nothing ([NAO], section 3.2)."""
_LEAST_SHARE = 0.25
"""Of a robot lighter than 2 kg, that force is no more than this share of its weight."""


@dataclass(frozen=True)
class Reference:
    """Vertical ground reaction force and centre of pressure that a motion demands.

    Parameters
    ----------
    fz_n
        Shape (n,).
    cop_m
        Shape (n, 2).
    """

    fz_n: FloatArray
    cop_m: FloatArray


@dataclass(frozen=True)
class Pressure:
    """Total vertical force of some cells and its centre.

    Parameters
    ----------
    fz_n
        Shape (n,).
    cop_m
        Shape (n, 2), NaN where invalid.
    valid
        Shape (n,): where fz exceeds the least force.
    """

    fz_n: FloatArray
    cop_m: FloatArray
    valid: BoolArray


def least_force_n(asked_n: float, weight_n: FloatArray | float) -> FloatArray:
    """Least vertical force that counts: as asked for, less under a robot that hardly weighs it."""
    return np.minimum(asked_n, _LEAST_SHARE * np.asarray(weight_n, dtype=np.float64))


def vertical_force(
    com_acc_z_mps2: FloatArray, mass_kg: FloatArray | float, gravity_mps2: FloatArray | float
) -> FloatArray:
    """Vertical ground reaction force ``Fz = m (c̈ᶻ + g)``, shape (n,): [NAO], eq. (9)."""
    return np.asarray(mass_kg * (com_acc_z_mps2 + gravity_mps2), dtype=float)


def dynamic_reference(
    com_m: FloatArray,
    com_acc_mps2: FloatArray,
    angmom_rate_nm: FloatArray,
    mass_kg: FloatArray | float,
    gravity_mps2: FloatArray | float,
) -> Reference:
    """What the motion of the body demands of the ground: [NAO], eqs. (9)–(11).

    ``pˣ = cˣ − (cᶻ m c̈ˣ + L̇ʸ) / Fz``, ``pʸ = cʸ − (cᶻ m c̈ʸ − L̇ˣ) / Fz``.

    Parameters
    ----------
    com_m, com_acc_mps2
        Shape (n, 3), heights above the ground.
    angmom_rate_nm
        Rate of angular momentum about the CoM, x and y, shape (n, 2).
    mass_kg, gravity_mps2
        Scalars or shape (n,).
    """
    fz = vertical_force(com_acc_mps2[:, 2], mass_kg, gravity_mps2)
    with np.errstate(divide="ignore", invalid="ignore"):
        cop = (
            com_m[:, :2]
            - horizontal_moment(com_m, com_acc_mps2, angmom_rate_nm, mass_kg) / (fz[:, None])
        )
    cop[~(fz > 0)] = np.nan
    return Reference(fz, cop)


def horizontal_moment(
    com_m: FloatArray,
    com_acc_mps2: FloatArray,
    angmom_rate_nm: FloatArray,
    mass_kg: FloatArray | float,
) -> FloatArray:
    """How far the CoP is driven from below the CoM, times Fz: ``cᶻ m c̈ + (L̇ʸ, −L̇ˣ)`` (n, 2)."""
    inertial = (mass_kg * com_m[:, 2])[:, None] * com_acc_mps2[:, :2]
    turned = np.stack([angmom_rate_nm[:, 1], -angmom_rate_nm[:, 0]], axis=1)
    return np.asarray(inertial + turned, dtype=float)


def static_reference(
    com_m: FloatArray, mass_kg: FloatArray | float, gravity_mps2: FloatArray | float
) -> Reference:
    """Han's static assumption: the CoP lies below the CoM and Fz is the weight."""
    fz = vertical_force(np.zeros(len(com_m)), mass_kg, gravity_mps2)
    return Reference(fz, com_m[:, :2].copy())


def pressure(
    forces_n: FloatArray, points_m: FloatArray, min_force_n: float = MIN_FORCE_N
) -> Pressure:
    """Centre of pressure ``p = Σ pᵢ fᵢᶻ / Σ fᵢᶻ``: [NAO], eq. (8).

    Parameters
    ----------
    forces_n
        Vertical forces of cells, shape (n, c).
    points_m
        Where they act, shape (n, c, 2).
    min_force_n
        Below this total the centre is absent (NaN), never zero and never held.
    """
    fz = forces_n.sum(axis=1)
    valid = fz > min_force_n
    moment = np.einsum("nc,nck->nk", forces_n, points_m)
    cop = np.full(moment.shape, np.nan)
    cop[valid] = moment[valid] / fz[valid, None]
    return Pressure(fz, cop, valid)


def points_in_world(
    foot_m: FloatArray, foot_yaw_rad: FloatArray, points_foot_m: FloatArray
) -> FloatArray:
    """Points fixed to a flat foot, in the world: ``p = o + R(ψ) q``.

    Parameters
    ----------
    foot_m
        Origin of the foot frame, x and y, shape (n, 2).
    foot_yaw_rad
        Heading of the foot ψ, shape (n,).
    points_foot_m
        Points in the foot frame, shape (c, 2).

    Returns
    -------
    ndarray, shape (n, c, 2)
    """
    cos, sin = np.cos(foot_yaw_rad)[:, None], np.sin(foot_yaw_rad)[:, None]
    x, y = points_foot_m[:, 0], points_foot_m[:, 1]
    turned = np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
    return np.asarray(foot_m[:, None, :] + turned)
