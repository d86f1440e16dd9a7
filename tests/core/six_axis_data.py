"""A small simulator of a hexapod with six-axis transducers, independent of the estimators.

Truth: [Wu], Table II. Geometry: BigAnt-like. Everything is written with SciPy rotations and
plain cross products; nothing here imports the code under test except the log container.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from footcal_cli.core.log import Log

Array = NDArray[np.float64]
G = 9.80665
LEGS = ("hl", "ml", "fl", "hr", "mr", "fr")
TABLE_2: Array = np.array(
    [
        [1.47, 1.419, 0.57, -8.49, -0.06, -0.93],
        [-1.30, -4.884, 3.71, -1.448, -0.123, 0.653],
        [-5.61, -0.406, -2.039, -2.43, -0.07, -2.183],
        [0.2457, -0.0136, 0.2176, -0.3159, -0.2392, -0.3611],
        [0.002, 0.0808, 0.0921, 0.3449, -0.0982, -0.153],
        [0.034, 0.0144, -0.0177, 0.001, 0.004, 0.0222],
    ]
).T
WEIGHT_N: Array = np.array([6.2, 6.2, 6.2, 6.1, 6.2, 6.4])
COM_M: Array = np.array([[0.004, 0.030, 0.008], [0.055, 0.0, 0.0], [-0.004, 0.008, -0.030]])
"""``mean, sin, cos`` per axis."""
AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
FOUR_WAYS: Array = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 0, 1], [0, 0, -1]])
HIP_POS_M: Array = np.array(
    [
        [-0.22, 0.14, 0.0],
        [0.0, 0.16, 0.0],
        [0.22, 0.14, 0.0],
        [-0.22, -0.14, 0.0],
        [0.0, -0.16, 0.0],
        [0.22, -0.14, 0.0],
    ]
)
ROBOT_WEIGHT_N = 8.18 * G


def noise(rng: np.random.Generator, rows: int, sd: Array, rate_hz: float, memory_s: float) -> Array:
    """Stationary noise (rows, c): white for no memory, else AR(1) with that time constant."""
    white = rng.normal(size=(rows, sd.size))
    if memory_s == 0.0:
        return np.asarray(white * sd)
    rho = np.exp(-1.0 / (rate_hz * memory_s))
    driven = np.sqrt(1.0 - rho**2) * white
    driven[0] = white[0]
    return np.asarray(lfilter([1.0], [1.0, -rho], driven, axis=0) * sd)


def com_m(phase_rad: Array, com: Array = COM_M) -> Array:
    """Leg CoM (n, 3) from ``mean, sin, cos, sin2 …`` per axis."""
    z = [np.ones_like(phase_rad)]
    for h in range(1, (com.shape[1] - 1) // 2 + 1):
        z += [np.sin(h * phase_rad), np.cos(h * phase_rad)]
    return np.asarray(np.stack(z, axis=-1) @ com.T)


@dataclass(frozen=True)
class Hanging:
    """Logs of one hanging leg, and the true turn of each."""

    logs: list[Log]
    turn_rad: Array


def hang(
    rng: np.random.Generator,
    leg: int = 0,
    *,
    directions: Array = FOUR_WAYS,
    rows: int = 2000,
    rate_hz: float = 10.0,
    cycles: float = 10.0,
    tilt_rad: float = np.deg2rad(2.0),
    exact_tilt: bool = False,
    force_sd: float = 0.1,
    torque_sd: float = 0.01,
    memory_s: float = 0.0,
    com: Array = COM_M,
    temperature_slope: float = 0.0,
    offset: Array | None = None,
    turn_rad: Array | None = None,
) -> Hanging:
    """Hang one leg of Table II in the given directions.

    Tilts are normal with sd `tilt_rad` about the two axes across gravity, or exactly that large
    in a random direction.
    """
    bias = TABLE_2[leg] if offset is None else offset
    phase = 0.3 + 2 * np.pi * cycles * np.arange(rows) / rows
    if turn_rad is None:
        turn_rad = rng.normal(size=(len(directions), 3))
        turn_rad -= np.sum(turn_rad * directions, axis=1, keepdims=True) * directions
        if exact_tilt:
            turn_rad /= np.linalg.norm(turn_rad, axis=1, keepdims=True)
        turn_rad = tilt_rad * turn_rad
    logs = []
    for i, (direction, turn) in enumerate(zip(directions, turn_rad, strict=True)):
        down = Rotation.from_rotvec(turn).apply(direction)
        force = WEIGHT_N[leg] * down
        torque = np.cross(com_m(phase, com), force)
        time_s = np.arange(rows) / rate_hz
        temperature = 20.0 + 2.0 * i + 5.0 * time_s / time_s[-1] if rows > 1 else np.full(1, 20.0)
        sd = np.array([force_sd] * 3 + [torque_sd] * 3)
        wrench = np.column_stack([np.broadcast_to(force, (rows, 3)), torque]) + bias
        wrench = wrench + temperature_slope * (temperature - 25.0)[:, None] * np.ones(6)
        wrench = wrench + noise(rng, rows, sd, rate_hz, memory_s)
        logs.append(
            Log(
                "hang",
                tuple(f"{LEGS[leg]}.{axis}" for axis in AXES),
                time_s,
                wrench,
                {
                    "phase_rad": phase,
                    "gravity_dir": np.broadcast_to(direction, (rows, 3)).copy(),
                    "leg_weight_n": np.full(rows, 6.0),
                    "leg_com_m": np.zeros((rows, 3)),
                    "temperature_degc": temperature,
                },
                np.full(rows, i),
            )
        )
    return Hanging(logs, turn_rad)


@dataclass(frozen=True)
class Robot:
    """A hexapod as really built.

    Parameters
    ----------
    turn_b, shift_b_m
        Mounting errors: ``R = turn R_nominal`` about the hip, and the hip's displacement.
    chassis_com_b_m
        True CoM of the chassis (believed at the origin).
    """

    turn_b: Array
    shift_b_m: Array
    chassis_com_b_m: Array

    @property
    def rot_nominal(self) -> Array:
        """Left transducers along the body, right ones turned by pi about z."""
        left, right = np.eye(3), np.diag([-1.0, -1.0, 1.0])
        return np.stack([right if leg.endswith("r") else left for leg in LEGS])

    @property
    def rot_bt(self) -> Array:
        """True rotation, transducer to body."""
        return np.asarray(self.turn_b @ self.rot_nominal)


def draw_robot(
    rng: np.random.Generator,
    rotation_sd_rad: float = 0.035,
    shift_sd_m: float = 0.003,
    com_b_m: tuple[float, float, float] = (0.035, -0.010, 0.015),
) -> Robot:
    """Draw mounting errors."""
    turn = Rotation.from_rotvec(rotation_sd_rad * rng.normal(size=(6, 3))).as_matrix()
    return Robot(turn, shift_sd_m * rng.normal(size=(6, 3)), np.array(com_b_m))


def hang_robot(rng: np.random.Generator, robot: Robot, **options: float) -> list[list[Log]]:
    """Hang the whole robot four ways; logs per leg, the tilt shared through the chassis."""
    body_axes = FOUR_WAYS
    tilt = np.deg2rad(2.0) * rng.normal(size=(4, 3))
    down_b = np.stack(
        [Rotation.from_rotvec(t).apply(e) for t, e in zip(tilt, body_axes, strict=True)]
    )
    logs = []
    for k in range(6):
        nominal = body_axes @ robot.rot_nominal[k]
        true = down_b @ robot.rot_bt[k]
        axis = np.cross(nominal, true)
        sine = np.linalg.norm(axis, axis=1, keepdims=True)
        angle = np.arctan2(sine[:, 0], np.sum(nominal * true, axis=1))
        turn = axis / sine * angle[:, None]
        logs.append(hang(rng, k, directions=nominal, turn_rad=turn, **options).logs)  # type: ignore[arg-type]  # numbers
    return logs


@dataclass(frozen=True)
class Standing:
    """A pose log and the true wrenches behind it (P, 6, 6)."""

    log: Log
    wrench_t: Array
    ground_b: Array


def stand(
    rng: np.random.Generator,
    robot: Robot,
    poses: int = 543,
    *,
    force_sd: float = 0.02,
    torque_sd: float = 0.002,
    contact: Array | None = None,
    tilt_rad: float = 0.05,
    friction_n: float = 3.0,
    offset: Array | None = None,
) -> Standing:
    """Stand in random poses: foot forces drawn, then balanced with the least change.

    The CoM of every leg moves with its shaft; feet slide as they like (internal forces).
    """
    bias = TABLE_2 if offset is None else offset
    contact = np.ones((poses, 6)) if contact is None else contact
    phase = np.deg2rad(36.0) * rng.integers(-1, 2, size=(poses, 6)).astype(float)
    phase = np.where(contact > 0, phase, np.pi + rng.uniform(-0.6, 0.6, size=(poses, 6)))
    rot_wb = Rotation.from_euler(
        "zyx",
        np.column_stack(
            [rng.uniform(-np.pi, np.pi, poses), tilt_rad * rng.normal(size=(poses, 2))]
        ),
    ).as_matrix()
    down_b = -rot_wb[:, 2, :]
    hip = HIP_POS_M + robot.shift_b_m
    side = np.where(HIP_POS_M[:, 1] > 0, 1.0, -1.0)
    foot_b = hip + np.stack(
        [-0.16 * np.sin(phase), np.broadcast_to(0.09 * side, phase.shape), -0.16 * np.cos(phase)],
        axis=-1,
    )
    com_b = hip + np.einsum("kij,pkj->pki", robot.rot_bt, com_m(phase))
    chassis_n = ROBOT_WEIGHT_N - WEIGHT_N.sum()

    drawn = friction_n * rng.normal(size=(poses, 6, 3))
    drawn[..., 2] += ROBOT_WEIGHT_N / contact.sum(axis=1)[:, None]
    drawn *= contact[..., None]
    weight = WEIGHT_N[:, None] * down_b[:, None]
    force = drawn.sum(axis=1) + weight.sum(axis=1) + chassis_n * down_b
    moment = (np.cross(foot_b, drawn) + np.cross(com_b, weight)).sum(axis=1)
    moment += np.cross(robot.chassis_com_b_m, chassis_n * down_b)
    arm = np.zeros((poses, 6, 3, 3))
    x, y, z = np.moveaxis(foot_b, -1, 0)
    arm[..., 0, 1], arm[..., 0, 2], arm[..., 1, 2] = -z, y, -x
    arm[..., 1, 0], arm[..., 2, 0], arm[..., 2, 1] = z, -y, x
    grasp = np.concatenate([np.broadcast_to(np.eye(3), arm.shape), arm], axis=2)
    grasp = np.moveaxis(grasp * contact[..., None, None], 1, 2).reshape(poses, 6, 18)
    change = np.linalg.pinv(grasp) @ np.concatenate([force, moment], axis=1)[..., None]
    ground = drawn - change.reshape(poses, 6, 3)

    applied = ground + weight
    torque = np.cross(foot_b - hip, ground) + np.cross(com_b - hip, weight)
    wrench = np.concatenate(
        [
            np.einsum("kij,pki->pkj", robot.rot_bt, applied),
            np.einsum("kij,pki->pkj", robot.rot_bt, torque),
        ],
        axis=2,
    )
    sd = np.array([force_sd] * 3 + [torque_sd] * 3)
    readings = wrench + bias + sd * rng.normal(size=wrench.shape)
    log = Log(
        "pose",
        tuple(f"{leg}.{axis}" for leg in LEGS for axis in AXES),
        np.arange(poses, dtype=float),
        readings.reshape(poses, 36),
        {
            "phase_rad": phase,
            "rot_wb": rot_wb,
            "hip_rot_bt": np.broadcast_to(robot.rot_nominal, (poses, 6, 3, 3)),
            "hip_pos_b_m": np.broadcast_to(HIP_POS_M, (poses, 6, 3)),
            "chassis_com_b_m": np.zeros((poses, 3)),
            "robot_weight_n": np.full(poses, ROBOT_WEIGHT_N),
            "leg_weight_n": np.broadcast_to(WEIGHT_N, (poses, 6)),
            "contact": contact,
        },
        np.arange(poses),
    )
    return Standing(log, wrench, ground)
