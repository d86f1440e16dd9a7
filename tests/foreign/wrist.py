"""A six-axis transducer between an arm and its tool, turned by hand from hold to hold."""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from tests.foreign.biped import GRAVITY_MPS2
from tests.foreign.files import Recorded
from tests.foreign.legs import AXES
from tests.foreign.noise import coloured, stream

HOLDS, HOLD_S, MOVE_S, RATE_HZ = 18, 4.0, 2.0, 50.0
TOOL = "ft"


def wrist(seed: int) -> Recorded:
    """Holds in many attitudes with moves between them; the cable pulls a little, differently.

    The arm knows its flange to a milliradian; the sensor is mounted as the drawing says but for
    some milliradians more.
    """
    rng = stream(seed, "wrist")
    weight = float(rng.uniform(0.4, 2.5)) * GRAVITY_MPS2
    com = np.array([*rng.normal(0.0, 0.01, 2), rng.uniform(0.03, 0.1)])
    offset = rng.normal(size=6) * np.array([4.0] * 3 + [0.3] * 3)
    each = round((HOLD_S + MOVE_S) * RATE_HZ)
    n = HOLDS * each
    aims = Rotation.random(HOLDS + 1, random_state=int(rng.integers(2**31)))
    moved = np.clip((np.arange(each) / RATE_HZ - HOLD_S) / MOVE_S, 0.0, 1.0)
    moved = moved**2 * (3.0 - 2.0 * moved)
    parts = [
        aims[i] * Rotation.from_rotvec(np.outer(moved, (aims[i].inv() * aims[i + 1]).as_rotvec()))
        for i in range(HOLDS)
    ]
    flange = Rotation.concatenate(parts)
    mount = Rotation.from_rotvec(rng.normal(0.0, 0.004, 3))
    down = (flange * mount).inv().apply([0.0, 0.0, -1.0])
    cable = np.repeat(rng.normal(0.0, 0.004 * weight, (HOLDS, 3)), each, axis=0)
    force = weight * down + cable
    torque = np.cross(com, weight * down)
    sd = np.array([0.05] * 3 + [0.003] * 3)
    wrench = np.column_stack([force, torque]) + offset + sd * coloured(rng, n, 6, RATE_HZ, 0.3)
    said = Rotation.from_rotvec(rng.normal(0.0, 3e-4, (n, 3))) * flange
    angles = said.as_euler("ZYX", degrees=True)
    frame = pd.DataFrame({"t": np.arange(n) / RATE_HZ})
    for i, axis in enumerate(AXES):
        frame[f"{TOOL}_{axis.split('_')[0]}"] = np.round(wrench[:, i], 4)
    frame[["yaw_deg", "pitch_deg", "roll_deg"]] = np.round(angles, 4)
    names = ("fx", "fy", "fz", "tx", "ty", "tz")
    values = {f"{TOOL}.offset_{a}": float(o) for a, o in zip(names, offset, strict=True)}
    values[f"{TOOL}.weight"] = weight
    return Recorded({"wrist": frame}, {}, {"parameters": values, "com_m": com})
