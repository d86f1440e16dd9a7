"""Walks of a physics engine as base truth: forces that no model of ours made.

Source: ``tests/blind/motions/SOURCE.md``. Mirroring, another mass (forces and angular momentum
scale with it) and another start make several robots of two motions.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from tests.blind.world import Array, Rng
from tests.blind.worlds.gait import Build, Motion

FOLDER = Path(__file__).resolve().parents[1] / "motions"
RATE_HZ = 100.0
MASS_KG = 5.3
CELLS_M = np.array([[0.07, 0.03], [0.07, -0.03], [-0.05, 0.03], [-0.05, -0.03]])
LIFTED_N = 0.02
"""A foot whose pads carry less is in the air."""
MIRRORED_CELLS = np.array([5, 4, 7, 6, 1, 0, 3, 2])


def engine_walk(rng: Rng, seconds: float, *, straight: bool = False) -> tuple[Build, Motion]:
    """One of the engine's walks, changed by symmetries that mechanics has."""
    names = sorted(p.name for p in FOLDER.glob("straight.npz" if straight else "[st]*.npz"))
    data = dict(_load(names[int(rng.integers(len(names)))]))
    rows = min(int(seconds * RATE_HZ), len(data["forces_n"]))
    start = int(rng.integers(0, len(data["forces_n"]) - rows + 1))
    data = {name: values[start : start + rows] for name, values in data.items()}
    if rng.random() < 0.5:
        data = _mirrored(data)
    mass = float(np.round(MASS_KG * rng.uniform(0.7, 1.6), 3))
    forces = data["forces_n"] * mass / MASS_KG
    foot_load = forces.reshape(rows, 2, 4).sum(axis=2)
    swing = (foot_load < LIFTED_N).astype(float)
    landed = np.diff(swing[:, 0], prepend=0.0) < 0
    build = Build(mass, float(data["com_m"][:, 2].mean()), 0.05, CELLS_M)
    motion = Motion(
        time_s=np.arange(rows) / RATE_HZ,
        com_m=data["com_m"],
        com_acc_mps2=data["com_acc_mps2"],
        angmom_rate_nm=data["angmom_rate_nm"] * mass / MASS_KG,
        feet_m=data["feet_m"],
        yaw_rad=data["yaw_rad"],
        forces_n=forces,
        swing=swing,
        cycle=np.cumsum(landed).astype(float),
    )
    return build, motion


@cache
def _load(name: str) -> dict[str, Array]:
    with np.load(FOLDER / name) as stored:
        return {key: np.asarray(stored[key], dtype=np.float64) for key in stored.files}


def _mirrored(data: dict[str, Array]) -> dict[str, Array]:
    """The walk in a mirror: y, yaw and turning about x change sign, left and right change place."""
    flip = np.array([1.0, -1.0, 1.0])
    return {
        "forces_n": data["forces_n"][:, MIRRORED_CELLS],
        "com_m": data["com_m"] * flip,
        "com_acc_mps2": data["com_acc_mps2"] * flip,
        "angmom_rate_nm": data["angmom_rate_nm"] * [-1.0, 1.0],
        "feet_m": data["feet_m"][:, ::-1] * flip,
        "yaw_rad": -data["yaw_rad"][:, ::-1],
    }
