"""Columns of standing logs, in long form (one row per leg), to arrays per pose or stamp."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import Geometry
from footcal_cli.core.spatial import rotation_of_quaternion


@dataclass(frozen=True)
class Frames:
    """Complete rows of a long table: every leg once per pose or stamp.

    Parameters
    ----------
    keys
        Pose name or stamp of each frame, shape (P,).
    columns
        Name -> shape (P, K, …).
    incomplete
        Frames that lacked a leg, or had one more often than another.
    broken
        Frames with a reading that is not a number.
    left_out
        Keys of both.
    """

    keys: NDArray[Any]
    columns: Mapping[str, FloatArray]
    incomplete: int
    broken: int
    left_out: NDArray[Any] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    @property
    def rejected(self) -> dict[str, int]:
        """Frames left out, by reason."""
        reasons = {
            "a leg is missing, or there more often than another": self.incomplete,
            "reading is not a number": self.broken,
        }
        return {reason: count for reason, count in reasons.items() if count}


def frames_of(
    key: NDArray[Any],
    leg: NDArray[Any],
    legs: Sequence[str],
    columns: Mapping[str, FloatArray],
    may_miss: Sequence[str] = (),
) -> Frames:
    """Pivot a long table to a row per key; of several readings of every leg, their median.

    Parameters
    ----------
    key
        Pose or stamp, shape (n,).
    leg
        Leg of each row, shape (n,).
    legs
        Order wanted, K names.
    columns
        Name -> values (n, …).
    may_miss
        Columns in which a missing number does not spoil the frame.
    """
    order, index = {name: i for i, name in enumerate(legs)}, leg.astype(str)
    place = np.array([order.get(name, -1) for name in index])
    used = np.flatnonzero(place >= 0)
    _, first, frame = np.unique(key[used], return_index=True, return_inverse=True)
    rank = np.empty(first.size, dtype=np.int64)
    rank[np.argsort(first, kind="stable")] = np.arange(first.size)
    frame = rank[frame.ravel()]
    cell = frame * len(legs) + place[used]
    count = np.bincount(cell, minlength=first.size * len(legs)).reshape(first.size, len(legs))
    whole = (count == np.maximum(count[:, :1], 1)).all(axis=1)
    by_cell = np.argsort(cell, kind="stable")
    reading = np.arange(cell.size) - np.searchsorted(cell[by_cell], cell[by_cell])
    most = int(count.max(initial=1))
    pivoted = {}
    for name, values in columns.items():
        out = np.full((first.size * len(legs), most, *values.shape[1:]), np.nan)
        out[cell[by_cell], reading] = values[used][by_cell]
        pivoted[name] = _medians(out).reshape(first.size, len(legs), *values.shape[1:])
    sound = whole.copy()
    for name, values in pivoted.items():
        if name not in may_miss:
            sound &= np.isfinite(values).reshape(first.size, -1).all(axis=1)
    keys = key[used][np.sort(first)]
    return Frames(
        keys[sound],
        {name: values[sound] for name, values in pivoted.items()},
        int((~whole).sum()),
        int((whole & ~sound).sum()),
        keys[~sound],
    )


def _medians(readings: FloatArray) -> FloatArray:
    """Median over axis 1 of the readings that are numbers, NaN where none is."""
    if readings.shape[1] == 1:
        return readings[:, 0]
    with warnings.catch_warnings(action="ignore", category=RuntimeWarning):
        return np.asarray(np.nanmedian(readings, axis=1))


def pose_log(
    geometry: Geometry,
    frames: Frames,
    *,
    robot_weight_n: float,
    leg_weight_n: FloatArray,
    time_s: FloatArray | None = None,
) -> Log:
    """A pose log (one row per frame) from `wrench`, `phase_rad`, `body_q` and `contact`."""
    columns = frames.columns
    poses, legs = columns["phase_rad"].shape
    return Log(
        "pose",
        tuple(f"{leg}.{axis}" for leg in geometry.legs for axis in AXES),
        np.arange(poses, dtype=float) if time_s is None else time_s,
        columns["wrench"].reshape(poses, 6 * legs),
        {
            "phase_rad": columns["phase_rad"],
            "rot_wb": rotation_of_quaternion(columns["body_q"][:, 0]),
            "hip_rot_bt": np.broadcast_to(geometry.rot_bt, (poses, legs, 3, 3)),
            "hip_pos_b_m": np.broadcast_to(geometry.hip_b_m, (poses, legs, 3)),
            "chassis_com_b_m": np.broadcast_to(geometry.chassis_com_b_m, (poses, 3)),
            "robot_weight_n": np.full(poses, robot_weight_n),
            "leg_weight_n": np.broadcast_to(leg_weight_n, (poses, legs)),
            "contact": columns.get("contact", np.full((poses, legs), np.nan)),
        },
        np.arange(poses, dtype=np.int64),
    )
