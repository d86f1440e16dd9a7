"""Robots to simulate: a biped on load cells and a hexapod on six-axis transducers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.spatial import rotation_of_rpy

Triple = tuple[float, float, float]

GRAVITY_MPS2 = 9.80665
NAO_CELLS: Mapping[str, tuple[float, float]] = {
    "fl": (0.07, 0.03),
    "fr": (0.07, -0.03),
    "rl": (-0.05, 0.03),
    "rr": (-0.05, -0.03),
}
"""Load cells of a NAO-like foot, m in the foot frame."""
NAO_KG, NAO_COM_HEIGHT_M, NAO_HALF_WIDTH_M, NAO_ANKLE_M = 5.3, 0.26, 0.05, 0.045
_EDGE_M = 1e-3
"""Points that are closer to the line between two cells are not on the plate any more."""
_WIDEST = 1000.0
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
class Ankle:
    """A six-axis transducer between a leg and its foot.

    Parameters
    ----------
    position_m, rotation_rpy_rad
        In the logged frame of the foot.
    weight_below_n, com_below_m
        What hangs below the transducer, and its CoM in the transducer's frame.
    frame_height_m
        Of the logged frame's origin above the sole.
    """

    position_m: Triple = (0.0, 0.0, 0.0)
    rotation_rpy_rad: Triple = (0.0, 0.0, 0.0)
    weight_below_n: float = 0.0
    com_below_m: Triple = (0.0, 0.0, 0.0)
    frame_height_m: float = 0.0

    @property
    def rot_fs(self) -> FloatArray:
        """Transducer to foot frame, shape (3, 3)."""
        return rotation_of_rpy(self.rotation_rpy_rad)

    @property
    def rot_flat(self) -> FloatArray:
        """Foot frame to the heading's, of a foot that stands flat, shape (3, 3).

        The foot's frame is upright where the transducer's z is vertical then, else the
        transducer's is.
        """
        vertical = abs(abs(self.rot_fs[2, 2]) - 1.0) < 1e-6
        return np.eye(3) if vertical else self.rot_fs.T


@dataclass(frozen=True)
class Biped:
    """A biped whose feet stand on load cells or hang on six-axis transducers; or loose cells.

    Parameters
    ----------
    feet
        Name of each foot -> its cells -> position in the foot frame, m; the corners of its sole
        where it hangs on a transducer.
    mass_kg, com_height_m
        Of the whole robot while walking.
    half_width_m
        From the middle to each foot, m.
    scale_n_per_count, zero_counts
        Nameplate of the cells: newtons per count, and counts without load.
    adc_counts
        Range of the converter (24 bits, offset binary; signed where the zero is no load's).
    ankles
        Transducers in place of cells, by foot.
    loose
        Cells that are part of no foot.
    """

    feet: Mapping[str, Mapping[str, tuple[float, float]]] = field(
        default_factory=lambda: {"left": NAO_CELLS, "right": NAO_CELLS}
    )
    mass_kg: float = NAO_KG
    gravity_mps2: float = GRAVITY_MPS2
    com_height_m: float = NAO_COM_HEIGHT_M
    half_width_m: float = NAO_HALF_WIDTH_M
    scale_n_per_count: float = -3.41e-5
    zero_counts: float = 8.32e6
    adc_counts: int = 2**24
    ankles: Mapping[str, Ankle] = field(default_factory=dict)
    loose: tuple[str, ...] = ()

    @property
    def channels(self) -> tuple[str, ...]:
        """``<foot>_<cell>`` of all feet, ``<foot>.<axis>`` of transducers; or the loose cells."""
        if self.ankles:
            return tuple(f"{foot}.{axis}" for foot in self.feet for axis in AXES)
        if self.loose:
            return self.loose
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

    @property
    def length(self) -> float:
        """Size of the robot relative to a NAO, by its mass: ``(m / m_NAO)^(1/3)``."""
        return float(np.cbrt(self.mass_kg / NAO_KG))

    @property
    def room(self) -> float:
        """How far a CoP may move in the smallest foot, relative to a NAO's; at most 1."""
        nao = _reach_m(np.array(list(NAO_CELLS.values())))
        each = [_reach_m(self.cells_m(foot)) / nao for foot in self.feet]
        return float(np.round(np.min(each, initial=1.0), 9))

    def within(self, foot: str, points_m: FloatArray) -> BoolArray:
        """Which points (n, 2) of a foot's frame lie between its cells."""
        edges = _edges(self.cells_m(foot))
        inside = points_m @ edges[:, :2].T + edges[:, 2] <= -_EDGE_M
        return np.asarray(inside.all(axis=1), dtype=bool)

    @property
    def converts(self) -> bool:
        """Whether readings are a converter's codes: else a logger wrote forces.

        A converter that reached a thousand times the robot's weight would not see the robot.
        """
        return self.adc_counts * abs(self.scale_n_per_count) < _WIDEST * self.weight_n

    @property
    def codes(self) -> tuple[float, float]:
        """Lowest and highest code of the converter."""
        signed = abs(self.zero_counts) < 0.25 * self.adc_counts
        low = -0.5 * self.adc_counts if signed else 0.0
        return low, low + self.adc_counts - 1.0


def _edges(points_m: FloatArray) -> FloatArray:
    """Outward normals and offsets of the hull of points (n, 2), shape (edges, 3)."""
    from scipy.spatial import ConvexHull

    return np.asarray(ConvexHull(points_m).equations)


def _reach_m(points_m: FloatArray) -> FloatArray:
    """How far their hull reaches from the mean of points, along x and y, shape (2,)."""
    normal, offset = np.hsplit(_edges(points_m), [2])
    depth = -(normal @ points_m.mean(axis=0) + offset[:, 0])
    with np.errstate(divide="ignore"):
        each: FloatArray = (depth[:, None] / np.abs(normal)).min(axis=0)
    return each


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
