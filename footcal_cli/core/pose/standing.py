"""Transducer offsets again, from standing alone ([Wu], section V, with its gap closed).

With all feet on the ground the chassis balance sees only ``Σ_k T_k o_k``: rank 6 of 6K however
many poses there are, and a residual that looks perfect while each leg is newtons off. A lifted
leg shows its own six offsets, because only its known weight hangs on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.inference.linear import inverse_root, solve_information
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData
from footcal_cli.core.spatial import wrench_transform

_SEEN = 1e-8


@dataclass(frozen=True)
class OffsetFit:
    """Offsets from standing, and whether they may be believed.

    Parameters
    ----------
    offset, offset_sd
        Shape (K, 6), N and Nm; nan where not seen.
    change, change_sd
        Against the last calibration, shape (K, 6).
    covariance
        Of the offsets, shape (6K, 6K); nan where refused.
    rank, unknowns
        Directions seen, of 6K.
    accepted
        False: do not use `offset`.
    poses, lifted
        Number of poses, and per leg how many lifted it, shape (K,).
    poses_needed
        Poses of the same kind for the asked precision; None where no number would do.
    noise_factor
        Residual over assumed noise.
    words
        What was found, in sentences.
    """

    offset: FloatArray
    offset_sd: FloatArray
    change: FloatArray
    change_sd: FloatArray
    covariance: FloatArray
    rank: int
    unknowns: int
    accepted: bool
    poses: int
    lifted: FloatArray
    poses_needed: int | None
    noise_factor: float
    words: tuple[str, ...]


@dataclass(frozen=True)
class StandingRobot:
    """What the last calibration knows, the offsets aside.

    Parameters
    ----------
    rot_bt, arm_b_m
        Transducer to body (K, 3, 3), and chassis CoM to hip (K, 3), m.
    leg_weight_n, chassis_weight_n
        Shape (K,), and a number.
    leg_com_t_m
        Leg CoM at the poses' shaft angles, shape (P, K, 3), m.
    offset, offset_sd
        Of the last calibration, shape (K, 6).
    """

    rot_bt: FloatArray
    arm_b_m: FloatArray
    leg_weight_n: FloatArray
    chassis_weight_n: float
    leg_com_t_m: FloatArray
    offset: FloatArray
    offset_sd: FloatArray


def fit_offsets(
    data: PoseData,
    robot: StandingRobot,
    noise_sd: FloatArray,
    wanted_sd: tuple[float, float] = (0.1, 0.01),
) -> OffsetFit:
    """Offsets of all transducers from standing poses, mounting and weights kept.

    Rows: the chassis balance of every pose, ``Σ T_k o_k = Σ T_k w_k + m_c g ĝ``, and for every
    lifted leg ``o_k = w_k − [m g ĝ_t; r × m g ĝ_t]``.

    Parameters
    ----------
    data
        Poses; `contact` says which legs were lifted (0).
    noise_sd
        Noise of one pose's wrench, shape (K, 6).
    wanted_sd
        Asked precision of force and torque offsets, N and Nm.
    """
    poses, legs = data.wrench_t.shape[:2]
    unknowns = 6 * legs
    lifted = data.contact == 0.0
    hanging = _hanging_wrench(data, robot)
    information, vector, squares = _balance_products(data, robot, noise_sd, hanging)
    own = (data.wrench_t - hanging) * lifted[..., None]
    weights = 1.0 / np.square(noise_sd)
    count = lifted.sum(axis=0).astype(float)
    information += np.diag((count[:, None] * weights).ravel())
    vector += (own.sum(axis=0) * weights).ravel()
    squares += float(np.sum(own**2 * weights))

    estimate, covariance, rank = solve_information(information, vector, noise_sd.ravel(), _SEEN)
    accepted = rank == unknowns
    left = max(6 * poses + 6 * int(count.sum()) - rank, 1)
    noise_factor = float(np.sqrt(max(squares - vector @ estimate, 0.0) / left))
    if not accepted:
        estimate = np.full(unknowns, np.nan)
        covariance = np.full((unknowns, unknowns), np.nan)
    sd = np.sqrt(np.diag(covariance)).reshape(legs, 6)
    offset = estimate.reshape(legs, 6)
    needed = _poses_needed(sd, poses, wanted_sd) if accepted else None
    return OffsetFit(
        offset,
        sd,
        offset - robot.offset,
        np.hypot(sd, robot.offset_sd),
        covariance,
        rank,
        unknowns,
        accepted,
        poses,
        count,
        needed,
        noise_factor,
        _words(data.geometry.legs, count, rank, unknowns, poses, needed, wanted_sd),
    )


def _hanging_wrench(data: PoseData, robot: StandingRobot) -> FloatArray:
    """What each leg's own weight does to its transducer in every pose, shape (P, K, 6)."""
    gravity_t = np.einsum("kji,pj->pki", robot.rot_bt, data.gravity_b)
    weight_t = robot.leg_weight_n[:, None] * gravity_t
    return np.concatenate([weight_t, np.cross(robot.leg_com_t_m, weight_t)], axis=-1)


def _balance_products(
    data: PoseData, robot: StandingRobot, noise_sd: FloatArray, hanging: FloatArray
) -> tuple[FloatArray, FloatArray, float]:
    """``AᵀA, Aᵀb, bᵀb`` of all poses' chassis balances, whitened: (6 K, 6 K), (6 K,), number.

    Lifted legs' noise is in the balance too: the balance is taken over the standing legs only,
    with the lifted legs' true wrench in place of their reading.
    """
    poses, legs = data.wrench_t.shape[:2]
    unknowns = 6 * legs
    each = wrench_transform(robot.rot_bt, robot.arm_b_m)
    joined = np.moveaxis(each, 0, 1).reshape(6, unknowns)
    information, vector, squares = np.zeros((unknowns, unknowns)), np.zeros(unknowns), 0.0
    chassis = np.concatenate([robot.chassis_weight_n * data.gravity_b, np.zeros((poses, 3))], 1)
    pattern, group = np.unique(data.contact == 0.0, axis=0, return_inverse=True)
    for i, up in enumerate(pattern):
        rows = np.flatnonzero(group.ravel() == i)
        if up.all():
            continue
        block = joined * np.repeat(~up, 6)
        shown = np.where(up[:, None], hanging[rows], data.wrench_t[rows]).reshape(rows.size, -1)
        demand = shown @ joined.T + chassis[rows]
        spread = (block * np.square(noise_sd).ravel()) @ block.T
        root = inverse_root(spread)
        slope, target = root @ block, demand @ root.T
        information += rows.size * slope.T @ slope
        vector += slope.T @ target.sum(axis=0)
        squares += float(np.sum(target**2))
    return information, vector, squares


def _poses_needed(sd: FloatArray, poses: int, wanted_sd: tuple[float, float]) -> int:
    """Poses of the same kind until every offset is as exact as asked."""
    ratio = sd / np.repeat(wanted_sd, 3)
    return int(np.ceil(poses * float(ratio.max()) ** 2))


def _words(
    legs: tuple[str, ...],
    lifted: FloatArray,
    rank: int,
    unknowns: int,
    poses: int,
    needed: int | None,
    wanted_sd: tuple[float, float],
) -> tuple[str, ...]:
    never = [leg for leg, count in zip(legs, lifted, strict=True) if count == 0]
    if rank < unknowns:
        return (
            f"refused: {poses} poses show {rank} of {unknowns} directions of the offsets; the "
            "other legs can be newtons off while the sum of all wrenches balances perfectly",
            f"never lifted: {', '.join(never)}; add tripod stances that lift each leg at least "
            "once (two stances, one tripod after the other, show all offsets)",
        )
    sentences = [f"all {unknowns} offsets seen in {poses} poses"]
    if needed is not None and needed > poses:
        sentences.append(
            f"{needed - poses} more poses of this kind are needed for {wanted_sd[0]:g} N and "
            f"{wanted_sd[1]:g} Nm"
        )
    return tuple(sentences)
