"""Causes hidden in walks and stands of the foreign world's bipeds with six-axis ankles."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from tests.blind.abroad_legs import Hide, heavier, with_log
from tests.blind.abroad_streams import averaged, lateness
from tests.blind.classes import FLIPS
from tests.blind.world import Array, Rng
from tests.foreign import Recorded, stand, walk
from tests.foreign.ankles import AXES, UNITS
from tests.foreign.biped import FEET
from tests.foreign.kinds import DRAW

MAKES = (7013, 7014, 7015, 7101, 7205)
"""Robots of 4 to 110 kg; a sixth make has a mass of its own that is off."""
SECONDS = 45.0
CURVES = ("nonlinearity", "nonlinearity_cubic", "dead_zone", "hinge")
LEVEL = ("com_offset", "accel_bias", "imu_tilt", "floor_slope")


def _maker(seed: int) -> int:
    """A seed that draws one of the makes."""
    return (seed // len(MAKES)) * DRAW + MAKES[seed % len(MAKES)]


def _walking(seed: int, **options: Any) -> Recorded:
    return walk(_maker(seed), seconds=SECONDS, **options)


def _standing(seed: int) -> Recorded:
    return stand(_maker(seed))


def _columns(foot: str) -> list[str]:
    return [f"{foot}_{axis}_{unit}" for axis, unit in zip(AXES, UNITS, strict=True)]


Change = Callable[[Array, Array, Rng], Array]
"""``(time_s, wrench (n, 6), rng) -> wrench`` of one foot."""


def _on_foot(record: Callable[[int], Recorded], change: Change) -> Hide:
    def hidden(seed: int, rng: Rng) -> Recorded:
        recorded = record(seed)
        table, own = recorded.logs["cells"].copy(), _columns(str(rng.choice(FEET)))
        time_s = table["time_s"].to_numpy()
        table[own] = change(time_s, table[own].to_numpy(), rng)
        return with_log(recorded, "cells", table)

    return hidden


def _on_body(
    record: Callable[[int], Recorded], change: Callable[[pd.DataFrame, Rng], pd.DataFrame]
) -> Hide:
    def hidden(seed: int, rng: Rng) -> Recorded:
        recorded = record(seed)
        return with_log(recorded, "body", change(recorded.logs["body"].copy(), rng))

    return hidden


def _reach(wrench: Array) -> Array:
    """Largest wrench of a foot: forces by the vertical one, torques by a tenth of a metre of it."""
    force = float(np.ptp(wrench[:, 2]))
    return force * np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])


def _gained(time_s: Array, wrench: Array, rng: Rng) -> Array:
    gain = np.ones(6)
    gain[int(rng.choice([0, 1, 2]))] += float(rng.choice([-1, 1])) * 0.06
    return np.asarray(wrench * gain)


def _coupled(time_s: Array, wrench: Array, rng: Rng) -> Array:
    out = wrench.copy()
    out[:, 0] += 0.04 * wrench[:, 2]
    out[:, 1] -= 0.03 * wrench[:, 2]
    return out


def _jumped(time_s: Array, wrench: Array, rng: Rng) -> Array:
    """A blow: a fifth of the jump comes slowly after it."""
    when = time_s[0] + rng.uniform(0.2, 0.8) * np.ptp(time_s)
    since = np.maximum(time_s - when, 0.0)
    settled = np.where(time_s >= when, 1.0 - 0.2 * np.exp(-since / 3.0), 0.0)
    jump = 0.06 * _reach(wrench) * rng.choice([-1.0, 1.0], 6) * (rng.random(6) < 0.6)
    jump[2] = 0.06 * _reach(wrench)[2]
    return np.asarray(wrench + settled[:, None] * jump)


def _drifting(time_s: Array, wrench: Array, rng: Rng) -> Array:
    late = np.sqrt((time_s - time_s[0]) / np.ptp(time_s))
    drift = 0.05 * _reach(wrench) * rng.choice([-1.0, 1.0], 6) * (rng.random(6) < 0.5)
    drift[2] = 0.05 * _reach(wrench)[2]
    return np.asarray(wrench + late[:, None] * drift)


def _turned(time_s: Array, wrench: Array, rng: Rng) -> Array:
    """Mounted 60 mrad off about one axis."""
    vector = np.zeros(3)
    vector[int(rng.integers(3))] = 0.06 * float(rng.choice([-1, 1]))
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(vector).as_matrix()
    return np.hstack([wrench[:, :3] @ turn, wrench[:, 3:] @ turn])


def _half_turned(time_s: Array, wrench: Array, rng: Rng) -> Array:
    return np.asarray(wrench * np.array([-1.0, -1.0, 1.0, -1.0, -1.0, 1.0]))


def _mirrored(time_s: Array, wrench: Array, rng: Rng) -> Array:
    sign = np.ones(6)
    sign[int(rng.choice([0, 1, 3, 4]))] = -1.0
    return np.asarray(wrench * sign)


def _dead(time_s: Array, wrench: Array, rng: Rng) -> Array:
    out, axis = wrench.copy(), int(rng.integers(5))
    out[:, axis] = out[0, axis]
    return out


def _bent(time_s: Array, wrench: Array, rng: Rng) -> Array:
    out, reach = wrench.copy(), float(np.abs(wrench[:, 2]).max())
    sign = float(rng.choice([-1, 1]))
    out[:, 2] += sign * 0.06 * reach * np.expm1(-np.abs(wrench[:, 2]) / (0.4 * reach))
    return out


def _plugs(seed: int, rng: Rng) -> Recorded:
    recorded = _walking(seed)
    table = recorded.logs["cells"].copy()
    left, right = (_columns(foot) for foot in FEET)
    table[[*left, *right]] = table[[*right, *left]].to_numpy()
    return with_log(recorded, "cells", table)


def _placed(seed: int, rng: Rng) -> Recorded:
    """The recipe has one transducer 15 mm from where it is, in units of a usual foot."""
    recorded = _walking(seed)
    robot: dict[str, Any] = {**recorded.robot}
    feet: Mapping[str, Any] = robot["feet"]
    place = np.array(feet["left"]["transducer_position_m"])
    height = float(place[2]) / 0.045
    place[int(rng.integers(2))] += 0.010 * height * float(rng.choice([-1, 1]))
    moved = {**feet["left"], "transducer_position_m": place.tolist()}
    return replace(recorded, robot={**robot, "feet": {**feet, "left": moved}})


def _pushed(column: str, size: float) -> Callable[[pd.DataFrame, Rng], pd.DataFrame]:
    """A constant in the world's axes; on a straight walk they are the body's."""

    def changed(body: pd.DataFrame, rng: Rng) -> pd.DataFrame:
        angle = rng.uniform(0, 2 * np.pi)
        body[column.format("x")] += size * np.cos(angle)
        body[column.format("y")] += size * np.sin(angle)
        return body

    return changed


def _com(seed: int, rng: Rng) -> Recorded:
    recorded = _walking(seed, turn_radps=0.0)
    height = recorded.logs["body"]["com_z_m"].mean()
    return _on_body(lambda _: recorded, _pushed("com_{}_m", 0.04 * height))(seed, rng)


def _late(seed: int, rng: Rng) -> Recorded:
    return _walking(seed, **lateness(rng))


def _averaged(body: pd.DataFrame, rng: Rng) -> pd.DataFrame:
    return averaged(rng)(body)


ON_ANKLES: tuple[tuple[str, str, tuple[str, ...], Hide], ...] = (
    ("ankles", "", (), lambda s, r: _walking(s)),
    ("ankles", "gain", ("scale_matrix",), _on_foot(_walking, _gained)),
    ("ankles", "coupling", ("cross_coupling",), _on_foot(_walking, _coupled)),
    ("ankles", "jump", ("offset_change",), _on_foot(_walking, _jumped)),
    ("ankles", "drift", ("offset_drift",), _on_foot(_walking, _drifting)),
    ("ankles", "turned", ("mount_rotation",), _on_foot(_walking, _turned)),
    ("ankles", "half turn", FLIPS, _on_foot(_walking, _half_turned)),
    ("ankles", "mirrored", ("axis_flip",), _on_foot(_walking, _mirrored)),
    ("ankles", "dead axis", ("channel_stuck",), _on_foot(_walking, _dead)),
    ("ankles", "curve", CURVES, _on_foot(_walking, _bent)),
    ("ankles", "plugs", ("channel_swap",), _plugs),
    ("ankles", "place", ("mount_translation",), _placed),
    ("ankles", "mass", ("mass",), lambda s, r: heavier(_walking(s), 0.06)),
    ("ankles", "CoM", LEVEL, _com),
    ("ankles", "late", ("delay", "lag"), _late),
    (
        "ankles",
        "averaged",
        ("acceleration_delay",),
        _on_body(_walking, _averaged),
    ),
    ("stance", "", (), lambda s, r: _standing(s)),
)
"""Experiment, cause, names that are right, how it is hidden; walks (ankles), stands (stance).

A stand on two feet that are never lifted says nothing of a mass or a gain: offsets take it.
"""
