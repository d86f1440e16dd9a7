"""Worlds whose z does not point up: laboratories with y up, maps with z down (north, east, down).

``v_w = C v_log``, with C a rotation that turns the log's vertical up; the heading stays a matter of
the log. What a sensor or an IMU reads in its own axes is not touched.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import quaternions_of, rotation_of_quaternion

if TYPE_CHECKING:
    import pandas as pd

WorldUp = Literal["+x", "-x", "+y", "-y", "+z", "-z"]
TO_Z_UP: Mapping[WorldUp, FloatArray] = {
    "+z": np.eye(3),
    "-z": np.diag([1.0, -1.0, -1.0]),
    "+y": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "-y": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]),
    "+x": np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]]),
    "-x": np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
}
"""Axis that points up in the log -> C."""
_VECTOR = re.compile(
    r"(com|com_acc|com_vel|angmom_rate|angmom|base|\w+_foot)_([xyz])(_m|_mps2|_mps|_nm|_nms)"
)
_QUATERNION = re.compile(r"(body|base|\w+_foot)_q([xyzw])")


def with_z_up(frame: pd.DataFrame, up: WorldUp) -> pd.DataFrame:
    """Positions, accelerations, momenta and attitudes of a table in a world whose z points up.

    Half a vector cannot be turned and is left out, but for a pair about a z that points down.

    Parameters
    ----------
    frame
        Canonical columns, in the log's world.
    up
        Its axis that points up.
    """
    if up == "+z":
        return frame
    turn = TO_Z_UP[up]
    frame = frame.copy()
    for (stem, suffix), names in _groups(frame, _VECTOR).items():
        columns = [f"{stem}_{axis}{suffix}" for axis in "xyz"]
        if up == "-z":
            for column, sign in zip(columns, np.diag(turn), strict=True):
                if column in names:
                    frame[column] = sign * frame[column]
        elif len(names) < 3:
            frame = frame.drop(columns=names)
        else:
            frame[columns] = frame[columns].to_numpy(dtype=np.float64) @ turn.T
    for (stem, _), names in _groups(frame, _QUATERNION).items():
        columns = [f"{stem}_q{axis}" for axis in "xyzw"]
        if len(names) == 4:
            frame[columns] = _turned(frame[columns].to_numpy(dtype=np.float64), turn)
    if up.startswith("-"):  # angles of feet are counted about the log's own vertical and left
        for name in frame.columns:
            if str(name).endswith(("_foot_yaw_rad", "_foot_pitch_rad")):
                frame[name] = -frame[name]
    return frame


def _turned(quaternion: FloatArray, turn: FloatArray) -> FloatArray:
    """Quaternions x y z w of ``C R``; what is none stays as it is, to be found by the checks."""
    good = np.isfinite(quaternion).all(axis=1)
    good &= np.abs(np.linalg.norm(np.nan_to_num(quaternion), axis=1) - 1.0) < 0.05
    out = quaternion.copy()
    if good.any():
        out[good] = quaternions_of(turn @ rotation_of_quaternion(quaternion[good]))
    return out


def _groups(frame: pd.DataFrame, pattern: re.Pattern[str]) -> dict[tuple[str, str], list[str]]:
    """Columns of one vector or quaternion: stem and suffix -> names."""
    groups: dict[tuple[str, str], list[str]] = {}
    for name in map(str, frame.columns):
        if found := pattern.fullmatch(name):
            suffix = found[3] if found.re.groups > 2 else ""
            groups.setdefault((found[1], suffix), []).append(name)
    return groups
