"""Robots to simulate: a biped on load cells and a hexapod on six-axis transducers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.parameters import FloatArray

GRAVITY_MPS2 = 9.80665
NAO_CELLS: Mapping[str, tuple[float, float]] = {
    "fl": (0.07, 0.03),
    "fr": (0.07, -0.03),
    "rl": (-0.05, 0.03),
    "rr": (-0.05, -0.03),
}
"""Load cells of a NAO-like foot, m in the foot frame."""
TABLE_II_OFFSETS: Mapping[str, tuple[float, ...]] = {
    "fl": (0.57, 3.71, -2.039, 0.2176, 0.0921, -0.0177),
    "ml": (1.419, -4.884, -0.406, -0.0136, 0.0808, 0.0144),
    "hl": (1.47, -1.30, -5.61, 0.2457, 0.002, 0.034),
    "fr": (-0.93, 0.653, -2.183, -0.3611, -0.153, 0.0222),
    "mr": (-0.06, -0.123, -0.07, -0.2392, -0.0982, 0.004),
    "hr": (-8.49, -1.448, -2.43, -0.3159, 0.3449, 0.001),
}
"""Offsets of the six transducers of BigAnt, N and Nm ([Wu], Table II)."""
TABLE_II_LEG_WEIGHTS_N: Mapping[str, float] = {
    "fl": 6.2, "ml": 6.2, "hl": 6.2, "fr": 6.4, "mr": 6.2, "hr": 6.1,
}  # fmt: skip


@dataclass(frozen=True)
class Biped:
    """A biped whose feet stand on load cells.

    Parameters
    ----------
    feet
        Name of each foot -> its cells -> position in the foot frame, m.
    mass_kg, com_height_m
        Of the whole robot while walking.
    half_width_m
        From the middle to each foot, m.
    scale_n_per_count, zero_counts
        Nameplate of the cells: newtons per count, and counts without load.
    adc_counts
        Range of the converter (24 bits, offset binary).
    """

    feet: Mapping[str, Mapping[str, tuple[float, float]]] = field(
        default_factory=lambda: {"left": NAO_CELLS, "right": NAO_CELLS}
    )
    mass_kg: float = 5.3
    gravity_mps2: float = GRAVITY_MPS2
    com_height_m: float = 0.26
    half_width_m: float = 0.05
    scale_n_per_count: float = -3.41e-5
    zero_counts: float = 8.32e6
    adc_counts: int = 2**24

    @property
    def channels(self) -> tuple[str, ...]:
        """``<foot>_<cell>`` of all feet."""
        return tuple(f"{foot}_{cell}" for foot, cells in self.feet.items() for cell in cells)

    @property
    def foot_of_channel(self) -> FloatArray:
        """Number of the foot of each channel, shape (c,)."""
        return np.repeat(np.arange(len(self.feet)), [len(cells) for cells in self.feet.values()])

    def cells_m(self, foot: str) -> FloatArray:
        """Cell positions of a foot in its frame, shape (cells, 2)."""
        return np.array(list(self.feet[foot].values()), dtype=float)

    @property
    def weight_n(self) -> float:
        """Body weight."""
        return self.mass_kg * self.gravity_mps2


@dataclass(frozen=True)
class HexapodLeg:
    """A leg on a six-axis transducer at the hip.

    Parameters
    ----------
    position_m, rotation_bt
        Nominal transducer origin in the body and transducer-to-body rotation (rows).
    offset
        Wrench shown without load, N and Nm.
    weight_n
        Everything beyond the transducer.
    com_sin_m, com_cos_m, com_mean_m
        Leg CoM in the transducer frame: ``r(φ) = sin·sin φ + cos·cos φ + mean``.
    """

    position_m: tuple[float, float, float]
    rotation_bt: tuple[tuple[float, float, float], ...]
    offset: tuple[float, ...]
    weight_n: float
    com_sin_m: tuple[float, float, float]
    com_cos_m: tuple[float, float, float]
    com_mean_m: tuple[float, float, float]

    def com_acc_mps2(self, phase_rad: FloatArray, speed_radps: float) -> FloatArray:
        """Acceleration of the CoM of a leg that turns evenly, shape (n, 3)."""
        com: FloatArray = speed_radps**2 * (np.array(self.com_mean_m) - self.com_m(phase_rad))
        return com

    def com_m(self, phase_rad: FloatArray) -> FloatArray:
        """Leg CoM in the transducer frame, shape (n, 3)."""
        sine = np.sin(phase_rad)[..., None] * np.array(self.com_sin_m)
        cosine = np.cos(phase_rad)[..., None] * np.array(self.com_cos_m)
        com: FloatArray = sine + cosine + np.array(self.com_mean_m)
        return com


def leg_at(
    name: str, position_m: tuple[float, float, float], rpy_rad: tuple[float, float, float]
) -> HexapodLeg:
    """A leg whose transducer sits at a nominal place, turned by roll, pitch, yaw.

    Table II's offset and weight where the leg has one of its names.
    """
    rotation = Rotation.from_euler("xyz", rpy_rad).as_matrix()
    outward = 1.0 if position_m[1] >= 0 else -1.0
    forward_t = np.round(rotation.T @ np.array([1.0, 0.0, 0.0]), 12)
    sideways_t = np.round(rotation.T @ np.array([0.0, outward, 0.0]), 12)
    up_t = np.round(rotation.T @ np.array([0.0, 0.0, 1.0]), 12)
    return HexapodLeg(
        position_m,
        tuple(_triple(row) for row in rotation),
        TABLE_II_OFFSETS.get(name, (0.0,) * 6),
        TABLE_II_LEG_WEIGHTS_N.get(name, 6.2),
        com_sin_m=_triple(-0.03 * forward_t),
        com_cos_m=_triple(-0.03 * up_t),
        com_mean_m=_triple(0.004 * forward_t + 0.07 * sideways_t + 0.005 * up_t),
    )


def _triple(values: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


_HIPS = {
    "fl": (0.22, 0.14, 0.0),
    "ml": (0.0, 0.16, 0.0),
    "hl": (-0.22, 0.14, 0.0),
    "fr": (0.22, -0.14, 0.0),
    "mr": (0.0, -0.16, 0.0),
    "hr": (-0.22, -0.14, 0.0),
}


def _bigant_legs() -> dict[str, HexapodLeg]:
    """Six modules; those on the right are turned by π about z."""
    return {
        name: leg_at(name, place, (0.0, 0.0, np.pi if name.endswith("r") else 0.0))
        for name, place in _HIPS.items()
    }


@dataclass(frozen=True)
class Hexapod:
    """A hexapod with a six-axis transducer at each hip (BigAnt, [Wu]).

    Parameters
    ----------
    legs
        By name, in the order of the channels.
    mass_kg
        Of the whole robot, legs included.
    chassis_com_b_m
        CoM of what is not leg, in the body frame.
    foot_arm_m, foot_outward_m
        Crank length and sideways distance of the foot from the hip: φ = 0 points down.
    """

    legs: Mapping[str, HexapodLeg] = field(default_factory=_bigant_legs)
    mass_kg: float = 8.18
    gravity_mps2: float = GRAVITY_MPS2
    chassis_com_b_m: tuple[float, float, float] = (0.004, -0.002, 0.01)
    foot_arm_m: float = 0.16
    foot_outward_m: float = 0.09

    @property
    def channels(self) -> tuple[str, ...]:
        """``<leg>.<axis>`` of all legs."""
        return tuple(f"{leg}.{axis}" for leg in self.legs for axis in AXES)

    @property
    def weight_n(self) -> float:
        """Weight of the whole robot."""
        return self.mass_kg * self.gravity_mps2

    @property
    def hip_pos_b_m(self) -> FloatArray:
        """Nominal transducer origins in the body, shape (legs, 3)."""
        return np.array([leg.position_m for leg in self.legs.values()])

    @property
    def hip_rot_bt(self) -> FloatArray:
        """Nominal transducer-to-body rotations, shape (legs, 3, 3)."""
        return np.array([leg.rotation_bt for leg in self.legs.values()])

    @property
    def leg_weight_n(self) -> FloatArray:
        """Leg weights, shape (legs,)."""
        return np.array([leg.weight_n for leg in self.legs.values()])
