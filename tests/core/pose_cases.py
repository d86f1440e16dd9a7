"""Cases shared by the tests of standing poses: a robot, its hanging logs, its poses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from footcal_cli.core.hang.joint import fit_hang
from footcal_cli.core.pose.data import PoseData, pose_data, summarise
from footcal_cli.core.pose.hanging import LegKnowledge, leg_knowledge
from footcal_cli.core.pose.joint import PoseFit, fit_pose
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.spatial import rotation_log
from tests.core.six_axis_data import (
    HIP_POS_M,
    ROBOT_WEIGHT_N,
    TABLE_2,
    WEIGHT_N,
    Array,
    Robot,
    Standing,
    draw_robot,
    hang_robot,
    stand,
)

LOW = (0.02, 0.002)
HIGH = (0.5, 0.15)


def known_offsets(
    offset: Array, offset_sd: Array, weight_n: float, weight_sd_n: float
) -> LegKnowledge:
    """Knowledge without hanging logs: offsets and weight with their sd, no directions."""
    none = np.zeros((0, 3))
    covariance = np.diag(np.append(offset_sd, weight_sd_n) ** 2)
    return LegKnowledge(offset, weight_n, none, none, covariance, np.zeros((3, 1)))


@dataclass(frozen=True)
class Case:
    """A robot that hung and stood.

    Parameters
    ----------
    legs
        What hanging said.
    noise_sd
        True noise of a pose's wrench, shape (6, 6).
    """

    robot: Robot
    standing: Standing
    data: PoseData
    legs: tuple[LegKnowledge, ...]
    noise_sd: Array

    def fit(self, options: PoseOptions | None = None) -> PoseFit:
        """The joint fit."""
        return fit_pose(summarise(self.data), self.legs, self.noise_sd, options)

    @property
    def arm_b_m(self) -> Array:
        """True chassis CoM to hip."""
        return np.asarray(HIP_POS_M + self.robot.shift_b_m - self.robot.chassis_com_b_m)

    @property
    def truth(self) -> Array:
        """In the order of `PoseFit.estimates`: mounting along the nominal transducer's axes."""
        nominal = self.robot.rot_nominal
        turn = np.swapaxes(nominal, 1, 2) @ self.robot.turn_b @ nominal
        shift = self.robot.shift_b_m - self.robot.chassis_com_b_m
        return np.concatenate(
            [
                rotation_log(turn).ravel(),
                np.einsum("kji,kj->ki", nominal, shift).ravel(),
                TABLE_2.ravel(),
                WEIGHT_N,
                [ROBOT_WEIGHT_N],
            ]
        )


@cache
def _hung(seed: int) -> tuple[Robot, tuple[LegKnowledge, ...], dict[str, object]]:
    """The drawn robot of a seed, what its hanging says, and where the random numbers then stand."""
    rng = np.random.default_rng([20, seed])
    robot = draw_robot(rng)
    legs = _hanging(rng, robot)
    return robot, legs, dict(rng.bit_generator.state)


def _hanging(rng: np.random.Generator, robot: Robot) -> tuple[LegKnowledge, ...]:
    logs = hang_robot(rng, robot, rows=1000, force_sd=0.05, torque_sd=0.005)
    return tuple(leg_knowledge(fit_hang(log)) for log in logs)


def case(
    seed: int,
    noise: tuple[float, float] = LOW,
    *,
    poses: int = 543,
    robot: Robot | None = None,
    hung: bool = True,
    friction_n: float = 1.5,
) -> Case:
    """Draw a case; without `hung` the offsets and weights are known, the directions not."""
    rng = np.random.default_rng([20, seed])
    if hung and robot is None:
        robot, legs, after = _hung(seed)
        rng.bit_generator.state = after
    elif hung:
        assert robot is not None
        legs = _hanging(rng, robot)
    else:
        robot = robot or draw_robot(rng)
        sd = np.array([1e-3] * 3 + [1e-4] * 3)
        legs = tuple(known_offsets(o, sd, w, 1e-3) for o, w in zip(TABLE_2, WEIGHT_N, strict=True))
    standing = stand(
        rng, robot, poses, force_sd=noise[0], torque_sd=noise[1], friction_n=friction_n
    )
    noise_sd = np.tile([noise[0]] * 3 + [noise[1]] * 3, (6, 1))
    return Case(robot, standing, pose_data(standing.log), legs, noise_sd)


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
