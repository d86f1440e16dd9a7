"""Owners who write logs in their own frames, and take the recipe that ``footcal init`` writes.

A make here is a robot of `tests.foreign.kinds`, logged as text in other axes. What no log can say
(masses, lengths, a data sheet) is filled in where the recipe asks for it, and nothing else.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from tests.foreign.files import Recorded

Fill = Mapping[str, Mapping[str, str]]
"""Table of a recipe -> key -> value, as TOML."""
WORLDS = {
    "y up": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]),
    "north east down": np.diag([1.0, -1.0, -1.0]),
}
_VECTORS = ("com_{}_m", "com_acc_{}_mps2", "left_foot_{}_m", "right_foot_{}_m")
_MIRROR = {"fy_n": -1.0, "tx_nm": -1.0, "tz_nm": -1.0}
"""A frame whose y points the other way: forces are vectors, torques turn with the hand."""


@dataclass(frozen=True)
class Logged:
    """Files as their owner wrote them, by name, and what he fills in."""

    files: Mapping[str, pd.DataFrame]
    fill: Fill


def in_world(recorded: Recorded, world: str) -> Recorded:
    """The same log in another world's axes; the heading counts about its own vertical.

    The rate of angular momentum gains its vertical part, which the estimator takes for nothing.
    """
    if "body" not in recorded.logs:
        return recorded
    turn = WORLDS[world]
    body = recorded.logs["body"].copy()
    if "angmom_rate_x_nm" in body:
        body["angmom_rate_z_nm"] = 0.0
    for pattern in (*_VECTORS, "angmom_rate_{}_nm"):
        columns = [pattern.format(axis) for axis in "xyz"]
        if columns[0] in body:
            body[columns] = body[columns].to_numpy() @ turn.T
    if turn[2, 2] < 0:
        for name in map(str, body.columns):
            if name.endswith("_yaw_rad"):
                body[name] = -body[name]
    return Recorded(
        {**recorded.logs, "body": body}, recorded.robot, recorded.truth, recorded.commands
    )


def left_handed(recorded: Recorded, role: str) -> Recorded:
    """Transducers in a left-handed frame: their y axis points the other way."""
    frame = recorded.logs[role].copy()
    for column, sign in _MIRROR.items():
        frame[column] *= sign
    return Recorded({role: frame}, recorded.robot, recorded.truth, recorded.commands)


def with_accelerometer(recorded: Recorded) -> Recorded:
    """An IMU's specific force in place of the poses' attitudes: 9.8 m/s² that point up at rest."""
    frame = recorded.logs["poses"].copy()
    names = [f"body_q{axis}" for axis in "xyzw"]
    x, y, z, w = frame[names].to_numpy().T
    up = np.column_stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])
    frame = frame.drop(columns=names)
    frame[[f"imu_acc_{axis}" for axis in "xyz"]] = np.round(9.80665 * up, 4)
    return Recorded({"poses": frame}, recorded.robot, recorded.truth, recorded.commands)


def logged(recorded: Recorded) -> Logged:
    """Text files of all tables, and what the owner knows of his robot."""
    files = {f"{role}.csv": frame for role, frame in recorded.logs.items()}
    return Logged(files, _known(recorded))


def _known(recorded: Recorded) -> Fill:
    """``[robot]`` of the world's own recipe, table by table, and the commands' options."""
    fill: dict[str, dict[str, str]] = {}

    def add(path: str, content: Mapping[str, object]) -> None:
        for key, value in content.items():
            if isinstance(value, Mapping) and not path.endswith(".cells"):
                add(f"{path}.{key}", value)
            elif key != "name":
                fill.setdefault(path, {})[key] = _toml(value)

    add("robot", recorded.robot)
    for command, options in recorded.commands.items():
        add(command, options)
    return fill


def filled(recipe: str, fill: Fill) -> str:
    """A recipe with values where it asks for them; tables it does not have are added below."""
    lines, left = recipe.splitlines(), {table: dict(keys) for table, keys in fill.items()}
    out, table = [], ""
    for line in lines:
        plain = line.removeprefix("# ") if re.match(r"# (\[[\w.]+\]|\w+ = )", line) else line
        if plain.startswith("[["):
            out += _rest(left, table)
            table = ""
        if head := re.match(r"\[([\w.]+)\]", plain):
            out += _rest(left, table)
            table = head[1]
            out.append(plain if table in fill else line)
            continue
        key = re.match(r"(\w+) = ", plain)
        if key and key[1] in left.get(table, {}):
            out.append(f"{key[1]} = {left[table].pop(key[1])}")
        else:
            out.append(line)
    out += _rest(left, table)
    for name, keys in left.items():
        if keys:
            out += ["", f"[{name}]", *(f"{key} = {value}" for key, value in keys.items())]
    return "\n".join(out) + "\n"


def _rest(left: dict[str, dict[str, str]], table: str) -> list[str]:
    """What a table's own lines did not ask for."""
    return [f"{key} = {value}" for key, value in left.pop(table, {}).items()]


def _toml(value: object) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{k} = {_toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(_toml(one) for one in value) + "]"
    return str(value) if isinstance(value, int) else repr(float(value))  # type: ignore[arg-type]


Habit = Callable[[Recorded], Recorded]


def _no_change(recorded: Recorded) -> Recorded:
    return recorded


def _mirrored(recorded: Recorded) -> Recorded:
    (role,) = recorded.logs
    return left_handed(recorded, role)


def _accelerometer(recorded: Recorded) -> Recorded:
    return with_accelerometer(recorded) if "poses" in recorded.logs else recorded


OWNERS: Mapping[int, Habit] = {
    7101: _no_change, 7102: _no_change, 7103: _no_change, 7104: _no_change, 7105: _no_change,
    7106: lambda r: in_world(r, "y up"), 7107: lambda r: in_world(r, "north east down"),
    7108: _mirrored, 7109: _accelerometer, 7110: _no_change, 7111: _no_change,
}  # fmt: skip
"""Make -> how its owner writes a log; the recipe is that of ``footcal init``."""
