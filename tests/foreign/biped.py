"""A biped of rods: who it is, and where its links are for a torso and two feet.

Frames: world x forward, y left, z up, ground at z = 0; a sole frame lies under the ankle. SI units.
A leg is hip roll, hip pitch and knee between two points; the ankle keeps the sole's own attitude.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.foreign.kinds import Kind, kind_of
from tests.foreign.noise import Array, stream

GRAVITY_MPS2 = 9.80665
FEET = ("left", "right")
CELLS = ("fl", "fr", "rl", "rr")
CHANNELS = tuple(f"{foot}_{cell}" for foot in FEET for cell in CELLS)
CELLS_OF = {3: ("toe", "rl", "rr"), 4: CELLS, 6: ("fl", "fr", "ml", "mr", "rl", "rr"), 0: CELLS}
PLATE_KG = 0.025
"""Under each cell of a robot of 6.5 kg."""
LINKS = 7
"""Torso, then thigh, shank and foot of the left and of the right leg."""


@dataclass(frozen=True)
class Biped:
    """A drawn robot.

    Parameters
    ----------
    mass_kg : total; masses_kg (7,) of the links
    thigh_m, shank_m, ankle_m, hip_m : lengths; ankle height; half the distance of the hips
    torso_up_m : CoM of the torso above the hips; torso_inertia_kgm2 about x and y (2,)
    cells_m : (4, 2) in the sole frame, a rectangle; the same for both feet
    scale, zero : (8,) N/count and counts without load, `CHANNELS`
    sd_n : noise of a cell
    believed_masses_kg : (7,) what the estimator takes the links to weigh; same total
    tilt_rad : (2,) error of the IMU's attitude about x and y
    encoder_rad : resolution of a joint
    kind : its make
    """

    mass_kg: float
    masses_kg: Array
    thigh_m: float
    shank_m: float
    ankle_m: float
    hip_m: float
    torso_up_m: float
    torso_inertia_kgm2: Array
    cells_m: Array
    scale: Array
    zero: Array
    sd_n: float
    believed_masses_kg: Array
    tilt_rad: Array
    encoder_rad: float
    kind: Kind

    @property
    def cells(self) -> tuple[str, ...]:
        """Names of the cells under a foot; of the corners of a sole on an ankle transducer."""
        return CELLS_OF[self.kind.cells]

    @property
    def channels(self) -> tuple[str, ...]:
        """Cells of both feet."""
        return tuple(f"{foot}_{cell}" for foot in FEET for cell in self.cells)

    @property
    def plate_kg(self) -> float:
        """Under each cell."""
        return PLATE_KG * self.kind.plate * self.kind.size**3

    @property
    def below_kg(self) -> float:
        """Of a foot below its ankle transducer."""
        return 0.6 * float(self.masses_kg[3])

    @property
    def weight_n(self) -> float:
        """Body weight."""
        return self.mass_kg * GRAVITY_MPS2

    @property
    def leg_m(self) -> float:
        """Height of the hips over the ankles in the normal stance."""
        return 0.93 * (self.thigh_m + self.shank_m)

    def truth(self) -> dict[str, float]:
        """Scales and biases by the names of ``parameters.json``."""
        values: dict[str, float] = {}
        for name, scale, zero in zip(self.channels, self.scale, self.zero, strict=True):
            values |= {f"{name}.scale": float(scale), f"{name}.bias": float(-scale * zero)}
        return values

    def recipe(self) -> dict[str, Any]:
        """``[robot]`` as its owner writes it."""
        stated = {"name": self.kind.name, "mass_kg": self.mass_kg * (1.0 + self.kind.mass_off)}
        if self.kind.cells == 0:
            foot = {
                "transducer_position_m": [0.0, 0.0, self.ankle_m],
                "weight_below_n": round(self.below_kg * GRAVITY_MPS2 * 1.02, 3),
                "com_below_m": [round(x, 3) for x in self.com_below_m],
            }
            return stated | {"feet": dict.fromkeys(FEET, foot)}
        cells = {
            name: {"x_m": float(x), "y_m": float(y)}
            for name, (x, y) in zip(self.cells, self.cells_m, strict=True)
        }
        nameplate = {
            "scale_n_per_count": float(np.round(self.scale.mean(), 8)),
            "zero_counts": float(np.round(self.zero.mean(), 0 if self.kind.bits else -3)),
            "scale_relative_sd": 0.03,
            "bias_sd_n": 4.0 * float(np.abs(self.scale.mean())) * float(self.zero.std()),
        }
        adc = {"adc": {"bits": self.kind.bits}} if self.kind.bits else {}
        return stated | adc | {"nameplate": nameplate, "feet": {f: {"cells": cells} for f in FEET}}

    @property
    def com_below_m(self) -> list[float]:
        """CoM of a foot from its ankle."""
        return [0.015 * self.kind.size, 0.0, -0.7 * self.ankle_m]


def draw_biped(seed: int) -> Biped:
    """A robot, its cells and its estimator's beliefs; the usual one has 4–9 kg."""
    rng, kind = stream(seed, "biped"), kind_of(seed)
    mass = float(np.round(rng.uniform(*kind.mass_kg), 3))
    leg = np.array([rng.uniform(0.08, 0.11), rng.uniform(0.05, 0.07), rng.uniform(0.04, 0.055)])
    shares = np.concatenate([[1.0 - 2.0 * leg.sum()], leg, leg])
    believed = shares * (1.0 + rng.normal(0.0, 0.02, LINKS))
    size = kind.size
    thigh, torso_up = size * float(rng.uniform(0.11, 0.15)), size * float(rng.uniform(0.07, 0.11))
    half = np.round(size * np.array([rng.uniform(0.05, 0.07), rng.uniform(0.028, 0.04)]), 3)
    corners = _places(kind.cells) * half + [0.01 * size, 0.0]
    cells = 2 * len(corners)
    sign = 1.0 if rng.random() < 0.5 else -1.0
    step = rng.uniform(1e-5, 6e-5) * size**3
    unlike = rng.normal(0.0, 0.02, cells)
    level, weight = rng.uniform(2e6, 9e6), mass * 9.81
    if kind.bits:  # the range of the converter is twice the weight
        step, level = 2.0 * weight / 2.0**kind.bits, 0.15 * 2.0**kind.bits
        sign = 1.0
    scale = sign * step * (1.0 + unlike)
    zero = sign * level + rng.normal(0.0, 0.02, cells) * weight / np.abs(scale)
    return Biped(
        mass, mass * shares, thigh, thigh * float(rng.uniform(0.9, 1.1)), 0.045 * size,
        size * float(rng.uniform(0.045, 0.06)), torso_up,
        mass * shares[0] * torso_up**2 * np.array([0.8, 0.6]), corners, scale, np.round(zero),
        kind.noise * weight * float(rng.uniform(5e-4, 2e-3)), mass * believed / believed.sum(),
        rng.normal(0.0, 0.002, 2), 2.0 * np.pi / 2.0 ** int(rng.integers(12, 15)), kind,
    )  # fmt: skip


def _places(cells: int) -> Array:
    """Places of the cells in half lengths and widths of the sole, (n, 2)."""
    if cells == 3:
        return np.array([[1.6, 0.0], [-1.0, 1.8], [-1.0, -1.8]])
    if cells == 6:
        return np.array([[1.0, 1], [1, -1], [0, 1], [0, -1], [-1, 1], [-1, -1]])
    return np.array([[1.0, 1], [1, -1], [-1, 1], [-1, -1]])


@dataclass(frozen=True)
class LegAngles:
    """Hip roll, hip pitch and knee of both legs, each (n, 2), rad."""

    roll: Array
    pitch: Array
    knee: Array

    def quantised(self, step_rad: float) -> LegAngles:
        """As encoders of that resolution show them."""
        return LegAngles(*(np.round(a / step_rad) * step_rad for a in vars(self).values()))


def angles_of(robot: Biped, leg: Array) -> LegAngles:
    """Angles that put the ankles at hip + `leg` (n, 2, 3) in torso axes."""
    a, b = robot.thigh_m, robot.shank_m
    length = np.minimum(np.linalg.norm(leg, axis=-1), 0.9999 * (a + b))
    inner = np.arccos(np.clip((a * a + b * b - length**2) / (2.0 * a * b), -1.0, 1.0))
    roll = np.arctan2(leg[..., 1], -leg[..., 2])
    across = np.arctan2(leg[..., 0], np.hypot(leg[..., 1], leg[..., 2]))
    lead = np.arcsin(np.clip(b * np.sin(inner) / length, -1.0, 1.0))
    return LegAngles(roll, across + lead, np.pi - inner)


def leg_points(robot: Biped, angles: LegAngles) -> tuple[Array, Array]:
    """Knees and ankles from the hips in torso axes, each (n, 2, 3)."""

    def along(pitch: Array, size: float) -> Array:
        down = -size * np.cos(pitch)
        return np.stack(
            [size * np.sin(pitch), -down * np.sin(angles.roll), down * np.cos(angles.roll)], -1
        )

    knee = along(angles.pitch, robot.thigh_m)
    return knee, knee + along(angles.pitch - angles.knee, robot.shank_m)


def link_centres(robot: Biped, torso_m: Array, attitude: Array, knee: Array, ankle: Array) -> Array:
    """CoMs of the links (n, 7, 3) for hips-midpoint `torso_m` (n, 3) and `attitude` (n, 3, 3)."""
    hips = np.array([[0.0, robot.hip_m, 0.0], [0.0, -robot.hip_m, 0.0]])
    foot = ankle + np.array(robot.com_below_m)
    parts = np.stack([hips + 0.45 * knee, hips + 0.5 * (knee + ankle), hips + foot], axis=2)
    up = np.broadcast_to(np.array([0.0, 0.0, robot.torso_up_m]), (len(torso_m), 1, 3))
    local = np.concatenate([up, parts.reshape(len(torso_m), 6, 3)], axis=1)
    return np.asarray(torso_m[:, None] + np.einsum("nij,nkj->nki", attitude, local))
