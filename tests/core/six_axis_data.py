"""A small simulator of a hexapod with six-axis transducers, independent of the estimators.

Truth: seed 2, Table II. Geometry: BigAnt-like. Everything is written with SciPy rotations and
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
