"""The paper's own fit of the mounting: two least squares in turn (seed 2, eqs. (8) and (9)).

Rotations by Cayley vectors with the translations kept, then translations with the rotations kept,
until no parameter moves by more than 10⁻³. With `printed` the balance is the paper's: foot
wrenches about a CoM that does not move with the legs, against the whole robot's weight; without
it the exact chassis balance. Kept for comparison.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import PoseData
from footcal_cli.core.pose.joint import PAPER_NORM
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
    rounds
        Alternations.
    cost
        Sum of squares in the K-norm.
    """

    turn_b: FloatArray
    arm_b_m: FloatArray
    rounds: int
    cost: float


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

    q = np.zeros((legs, 3))
    arm = geometry.hip_b_m - geometry.chassis_com_b_m
    cost = np.inf
    rounds = 0
    for rounds in range(1, _MAX_ROUNDS + 1):
        kept = arm
        turned = least_squares(
            lambda v, kept=kept: residual(cayley(v.reshape(legs, 3)), kept),
            q.ravel(),
            ftol=COST_TOLERANCE,
        )
        turn = cayley(turned.x.reshape(legs, 3))
        shifted = least_squares(
            lambda v, turn=turn: residual(turn, v.reshape(legs, 3)),
            arm.ravel(),
            ftol=COST_TOLERANCE,
        )
        change = max(
            float(np.abs(turned.x - q.ravel()).max()), float(np.abs(shifted.x - arm.ravel()).max())
        )
        q, arm = turned.x.reshape(legs, 3), shifted.x.reshape(legs, 3)
        cost = float(2.0 * shifted.cost)
        if change < STEP_TOLERANCE:
            break
    return AlternatingFit(cayley(q), arm, rounds, cost)
