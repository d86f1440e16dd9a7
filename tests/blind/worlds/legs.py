"""What a six-axis leg is: offset, weight, centre of mass over the shaft angle, mounting."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from tests.blind.world import Array, Rng
from tests.blind.worlds.files import write_log

AXES = ("fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm")
ALL_LEGS = ("fl", "ml", "hl", "fr", "mr", "hr")
HIPS_M = {
    "fl": (1, 1),
    "ml": (0, 1.1),
    "hl": (-1, 1),
    "fr": (1, -1),
    "mr": (0, -1.1),
    "hr": (-1, -1),
}
DOWN = {"+x": (1.0, 0, 0), "-x": (-1.0, 0, 0), "+z": (0, 0, 1.0), "-z": (0, 0, -1.0)}


@dataclass(frozen=True)
class Legs:
    """Drawn legs, first axis legs.

    Parameters
    ----------
    names
        As in `ALL_LEGS`.
    offset : (k, 6); weight_n : (k,)
    com_m
        (k, 3, 3): x, y, z by mean, sine, cosine of the shaft angle.
    hip_m : (k, 3) nominal positions in the body
    """

    names: tuple[str, ...]
    offset: Array
    weight_n: Array
    com_m: Array
    hip_m: Array


def legs_of(facts: Mapping[str, Any]) -> Legs:
    """Legs as the facts of a world keep them."""
    return Legs(
        tuple(facts["names"]),
        *(np.array(facts[k]) for k in ("offset", "weight_n", "com_m", "hip_m")),
    )


def draw_legs(rng: Rng, names: Sequence[str]) -> Legs:
    """Legs of a 6–12 kg robot; offsets as large as the published ones."""
    k = len(names)
    offset = rng.normal(size=(k, 6)) * [3, 3, 3, 0.2, 0.2, 0.2]
    com = np.zeros((k, 3, 3))
    com[:, :, 0] = rng.normal(0, [0.004, 0.0, 0.01], (k, 3))
    com[:, 1, 0] = rng.uniform(0.04, 0.07, k)
    angle = rng.uniform(-0.3, 0.3, k)
    radius = rng.uniform(0.02, 0.04, k)
    com[:, 0, 1:] = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    com[:, 2, 1:] = np.column_stack([radius * np.sin(angle), -radius * np.cos(angle)])
    size = np.array([rng.uniform(0.16, 0.25), rng.uniform(0.11, 0.16)])
    hip = np.array([[*(size * HIPS_M[name]), 0.0] for name in names])
    return Legs(
        tuple(names), offset, rng.uniform(4.5, 8.0) + rng.normal(0, 0.1, k), com, np.round(hip, 4)
    )


def com_at(com: Array, phase_rad: Array) -> Array:
    """Leg CoM (n, 3) for coefficients (n or 1, 3, 3)."""
    basis = np.stack([np.ones_like(phase_rad), np.sin(phase_rad), np.cos(phase_rad)], axis=-1)
    return np.asarray(np.einsum("nij,nj->ni", np.broadcast_to(com, (len(basis), 3, 3)), basis))


def small_turn(rotvec: Array) -> Array:
    """Rotation matrices of rotation vectors (..., 3)."""
    flat = Rotation.from_rotvec(np.reshape(rotvec, (-1, 3))).as_matrix()
    return np.asarray(flat.reshape(*np.shape(rotvec)[:-1], 3, 3))


def write_hang(folder: Path, rng: Rng, rows: dict[str, Array], legs: Sequence[str]) -> str:
    """The long hanging table."""
    frame = pd.DataFrame(
        {
            "orientation": np.array(list(DOWN))[rows["log"].astype(int)],
            "time_s": np.round(rows["time_s"], 4),
            "leg": np.array(legs)[rows["leg"].astype(int)],
            "phase_rad": np.round(rows["phase_rad"], 5),
            **{axis: np.round(rows["wrench"][:, i], 6) for i, axis in enumerate(AXES)},
            "temperature_degc": np.round(rows["temperature_degc"], 2),
        }
    )
    return write_log(frame, folder, "hang", rng)
