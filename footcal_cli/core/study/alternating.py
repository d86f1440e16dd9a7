"""The paper's own fit of the mounting: two least squares in turn ([Wu], eqs. (8) and (9)).

Rotations by Cayley vectors with the translations kept, then translations with the rotations kept,
until no parameter moves by more than 10⁻³. With `printed` the balance is the paper's: foot
wrenches about a CoM that does not move with the legs, against the whole robot's weight; without
it the exact chassis balance. Kept for comparison.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from footcal_cli.core.inference.fit import least_squares_alone
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import PAPER_NORM, PoseFit
from footcal_cli.core.pose.model import Structure, arms_b_m
from footcal_cli.core.pose.wrenches import leg_coms_t_m
from footcal_cli.core.spatial import cayley

COST_TOLERANCE = 1e-3
STEP_TOLERANCE = 1e-3
_MAX_ROUNDS = 200


@dataclass(frozen=True)
class AlternatingFit:
    """What the alternating scheme says.

    Parameters
    ----------
    turn_b
        Mounting rotations, left of the nominal ones, shape (K, 3, 3).
    arm_b_m
        CoM (of the chassis, or of the robot as printed) to hip, shape (K, 3), m.
    """

    turn_b: FloatArray
    arm_b_m: FloatArray


def fit_alternating(
    data: PoseData,
    offset: FloatArray,
    leg_weight_n: FloatArray,
    leg_com_t_m: FloatArray,
    *,
    printed: bool = False,
) -> AlternatingFit:
    """Alternate rotations and translations as the paper does.

    Parameters
    ----------
    data
        Poses.
    offset, leg_weight_n
        From hanging, shapes (K, 6) and (K,).
    leg_com_t_m
        Leg CoM per pose in the transducer frames, shape (P, K, 3); used as printed only.
    printed
        The paper's balance instead of the exact one.
    """
    geometry = data.geometry
    legs = len(geometry.legs)
    applied = data.wrench_t - offset
    turn_nominal = geometry.rot_bt
    force = np.einsum("kij,pkj->pki", turn_nominal, applied[..., :3])
    torque = np.einsum("kij,pkj->pki", turn_nominal, applied[..., 3:])
    com = np.einsum("kij,pkj->pki", turn_nominal, leg_com_t_m)
    weight_b = leg_weight_n[:, None] * data.gravity_b[:, None]
    rest_n = data.robot_weight_n - (0.0 if printed else leg_weight_n.sum())
    norm = np.sqrt(PAPER_NORM)

    def residual(turn: FloatArray, arm: FloatArray) -> FloatArray:
        turned = (turn @ force[..., None])[..., 0]
        moment = (turn @ torque[..., None])[..., 0] + np.cross(arm, turned)
        total = turned.sum(axis=1) + rest_n * data.gravity_b
        if printed:
            total = total - weight_b.sum(axis=1)
            hanging = arm + (turn @ com[..., None])[..., 0]
            moment = moment - np.cross(hanging, weight_b)
        both = np.concatenate([total, moment.sum(axis=1)], axis=1)
        return np.asarray((norm * both).ravel())

    def by_rotation(q: FloatArray, arm: FloatArray) -> FloatArray:
        return residual(cayley(q.reshape(legs, 3)), arm.reshape(legs, 3))

    def by_translation(arm: FloatArray, q: FloatArray) -> FloatArray:
        return by_rotation(q, arm)

    q = np.zeros(3 * legs)
    arm = (geometry.hip_b_m - geometry.chassis_com_b_m).ravel()
    rounds, change = 0, np.inf
    while change >= STEP_TOLERANCE and rounds < _MAX_ROUNDS:
        turned = least_squares_alone(partial(by_rotation, arm=arm), q, COST_TOLERANCE)
        shifted = least_squares_alone(partial(by_translation, q=turned), arm, COST_TOLERANCE)
        change = float(np.abs(np.concatenate([turned - q, shifted - arm])).max())
        q, arm, rounds = turned, shifted, rounds + 1
    return AlternatingFit(cayley(q.reshape(legs, 3)), arm.reshape(legs, 3))


def alternated(
    data: PoseData, legs: tuple[LegKnowledge, ...], joint: PoseFit, *, printed: bool
) -> PoseFit:
    """The paper's alternating solution in the place of the joint one; it has no covariance."""
    offset = np.stack([leg.offset for leg in legs])
    weight = np.array([leg.weight_n for leg in legs])
    com = leg_coms_t_m(tuple(leg.com_m for leg in legs), data.phase_rad)
    found = fit_alternating(data, offset, weight, com, printed=printed)
    options = replace(joint.options, structure=Structure.FULL)
    nominal = replace(
        joint.mounting,
        turn_b=found.turn_b,
        shift_b_m=np.zeros_like(found.arm_b_m),
        offset=offset,
        leg_weight_n=weight,
    )
    shift = found.arm_b_m - arms_b_m(data.geometry, nominal, Structure.FULL)
    return replace(
        joint,
        options=options,
        mounting=replace(nominal, shift_b_m=shift),
        covariance=np.full_like(joint.covariance, np.nan),
    )
