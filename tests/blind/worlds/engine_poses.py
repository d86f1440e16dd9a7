"""Poses of a physics engine's hexapod as base truth: wrenches that no model of ours made.

Source: ``tests/blind/motions/SOURCE.md``. A drawn part of its poses, another mass (every wrench
scales with it) and other offsets make many robots of one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from tests.blind.world import GRAVITY_MPS2, Array, Rng
from tests.blind.worlds.legs import ALL_LEGS, Legs

FILE = Path(__file__).resolve().parents[1] / "motions" / "poses" / "hexapod.npz"
TRIPOD_SHARE = 1.0 / 3.0


@dataclass(frozen=True)
class Poses:
    """Poses of one robot, true.

    Parameters
    ----------
    tilt : (p, 3) rotation vector body to world
    phase_rad, contact : (p, 6)
    wrench : (p, 6, 6) on each transducer in its true axes, no offset
    mount : (6, 3, 3) true transducer to body axes; hip_m : (6, 3) from the chassis' CoM
    total_n
        Weight of the robot.
    """

    legs: Legs
    tilt: Array
    phase_rad: Array
    contact: Array
    wrench: Array
    mount: Array
    hip_m: Array
    total_n: float


def engine_poses(rng: Rng, poses: int) -> Poses:
    """Some of the engine's poses, every third on three legs, of a lighter or heavier robot."""
    data = _load()
    lifted, standing = np.flatnonzero(data["tripod"] > 0), np.flatnonzero(data["tripod"] == 0)
    few = int(poses * TRIPOD_SHARE)
    chosen = np.concatenate([
        rng.choice(standing, poses - few, replace=False), rng.choice(lifted, few, replace=False),
    ])  # fmt: skip
    chosen = rng.permutation(chosen)
    heavier = float(rng.uniform(0.8, 1.3))
    legs = Legs(
        ALL_LEGS,
        rng.normal(size=(6, 6)) * [3, 3, 3, 0.2, 0.2, 0.2],
        heavier * data["leg_weight_n"],
        data["leg_com_m"],
        np.round(data["nominal_m"] - data["chassis_com_m"], 4),
    )
    return Poses(
        legs,
        data["tilt"][chosen],
        data["phase_rad"][chosen],
        data["contact"][chosen],
        heavier * data["wrench"][chosen],
        data["mount"],
        data["hip_m"],
        float(heavier * data["mass_kg"] * GRAVITY_MPS2),
    )


@cache
def _load() -> dict[str, Array]:
    with np.load(FILE) as stored:
        return {key: np.asarray(stored[key], dtype=np.float64) for key in stored.files}
