"""The robot's own stream in a log: CoM, its acceleration, angular momentum, poses of the feet.

A walk is logged in one table with its sensors as often as beside it; either way no column of the
motion is a reading.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from footcal_cli.core.body_positions import upright_axis
from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, seconds_of
from footcal_cli.sniff.names import COMMANDED, words_of
from footcal_cli.sniff.plan import Entry, of, times
from footcal_cli.sniff.units import split_unit

_STEP_M, _IN_M = 0.03, {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
"""A foot that stands moves by less, as far as an estimator's drift goes."""
_GONE_M, _WALKS_MPS, _SPEED_S = 0.2, 0.12, 0.2
"""A CoM that only shifts the weight ends nearer to its beginning and is slower (RMS)."""
_RATES = {"vel", "velocity", "v", "speed", "omega", "twist"}
_IN_A_POSE = re.compile(r"[tp][xyz]")
"""Where a pose is: its ``tx`` is no torque."""
_MOMENTUM = {"ldot", "hdot", "angmom", "dl", "dh"}
_MOMENTUM_RATE = re.compile(r"(?:d[lh]|[lh]dot)([xyz])")
"""dLx, HdotY: written in one word."""
_FEET = {"foot", "feet", "lfoot", "rfoot", "footl", "footr", "sole", "ankle"}
_LEGS = {"fl", "fr", "ml", "mr", "hl", "hr", "rl", "rr"}
_BEHIND = {"ml", "mr", "hl", "hr", "rl", "rr"}
_AT = {"pos", "position", "p", "x", "y", "z", "yaw"}
"""All that the name of a foot's place says besides which foot: ``left.pos.x``."""
_ATTITUDES = ("quaternion", "angle", "matrix", "gravity")
_NO_PLACE = {"force", "cop", "acceleration", "com", "com_acc", "quaternion", "angle"}


def body_entries(file: FileGuess) -> dict[str, Entry]:
    """Stamps and every column of the motion, by canonical name."""
    entries, _, _ = times(file, needed=False)
    asked = {c.column for c in file.of("com", "com_acc") if COMMANDED & set(words_of(c.column))}
    if len(asked) < len(file.of("com")):  # what was asked for stands next to what was reached
        file = replace(file, columns=tuple(c for c in file.columns if c.column not in asked))
    behind = any(c.name.place in _BEHIND for c in file.columns)
    for column in file.columns:
        name = _canonical(column)
        if not behind:  # LF and RF of two feet are no front legs
            name = name.replace("fl_foot", "left_foot").replace("fr_foot", "right_foot")
        if name and name not in entries:
            default = next((u for end, u in _UNITS.items() if name.endswith(end)), None)
            entries[name] = of(column, column.unit or default)
    return entries


_UNITS = {"_foot_x_m": "m", "_foot_y_m": "m", "_foot_z_m": "m", "_foot_yaw_rad": "rad"}


def without_motion(file: FileGuess) -> FileGuess:
    """The log with each column of a motion taken for that: beside a CoM, or a pose's position."""
    last = {c.column: "".join(words_of(c.column)[-1:]) for c in file.columns}
    if {"px", "py", "pz"} <= {*last.values()} and file.of(*_ATTITUDES):
        posed = (
            c.as_quantity("other", "likely", "where the pose is")
            if last[c.column] in ("px", "py", "pz") and c.quantity in ("unknown", "reading")
            else c
            for c in file.columns
        )
        file = replace(file, columns=tuple(posed))
    axes = {c.name.axis for c in file.of("com")}
    if not {"x", "y", "z"} <= axes:
        return file
    columns = (
        c.as_quantity("other", "likely", "the body's motion")
        if c.quantity not in ("com", "com_acc", "angle", "quaternion") and _of_motion(c)
        else c
        for c in file.columns
    )
    return replace(file, columns=tuple(columns))


def walks(entries: Mapping[str, Entry]) -> bool:
    """Whether a body's motion is one of steps: a foot's place moves along the ground.

    A stand shows no scale of a horizontal force; `static-init` asks it for none. Without places of
    the feet it is the speed of the CoM that says it.
    """
    known = False
    for name, entry in entries.items():
        column = entry.column
        if not name.endswith(("_foot_x_m", "_foot_y_m")):
            continue
        known = True
        if column is None or column.values is None:
            continue
        low, high = np.nanquantile(column.values, [0.01, 0.99])
        if (high - low) * _IN_M.get(entry.unit or "m", 1.0) > _STEP_M:
            return True
    return bool(entries) and not known and _goes(entries)


def _goes(entries: Mapping[str, Entry]) -> bool:
    """Whether the CoM ends elsewhere than it began, or moves fast; so where no column says it."""
    time = entries.get("time_s")
    stamps = seconds_of(time.column) if time is not None and time.column is not None else None
    columns = [entries[n].column if n in entries else None for n in ("com_x_m", "com_y_m")]
    values = [c.values for c in columns if c is not None and c.values is not None]
    if stamps is None or len(values) < 2:
        return True
    place = _IN_M.get(entries["com_x_m"].unit or "m", 1.0) * np.column_stack(values)
    good = np.isfinite(place).all(axis=1) & np.isfinite(stamps)
    place, stamps = place[good], stamps[good]
    few = max(len(place) // 20, 1)
    if len(place) < 3 or np.linalg.norm(place[-few:].mean(0) - place[:few].mean(0)) > _GONE_M:
        return True
    reach = max(round(_SPEED_S / max(float(np.median(np.diff(stamps))), 1e-9)), 1)
    moved = np.linalg.norm(place[reach:] - place[:-reach], axis=1)
    within = np.maximum(stamps[reach:] - stamps[:-reach], 1e-9)
    return bool(np.sqrt(np.mean((moved / within) ** 2)) > _WALKS_MPS)


def upright(file: FileGuess, entries: Mapping[str, Entry]) -> tuple[str, ...]:
    """A recipe's line that says which axis of the world points up, where it is not z."""

    def place(stem: str) -> FloatArray | None:
        names = [f"{stem}_{axis}_m" for axis in "xyz"]
        columns = [entries[n].column if n in entries else own.get(n) for n in names]
        values = [c.values for c in columns if c is not None and c.values is not None]
        return np.column_stack(values) if len(values) == 3 else None

    own = {column.column: column for column in file.columns}
    com = place("com")
    feet = [at for side in ("left", "right") if (at := place(f"{side}_foot")) is not None]
    if com is None or not feet:
        return ()
    stacked = np.stack(feet, axis=1)
    good = np.isfinite(com).all(axis=1) & np.isfinite(stacked).all(axis=(1, 2))
    up = upright_axis(com[good], stacked[good]) if good.any() else ""
    if up in ("", "+z"):
        return ()
    return (f'world_up = "{up}"    # likely: the CoM lies above the feet along {up}',)


def _of_motion(column: ColumnGuess) -> bool:
    """Whether a column is of the motion, speeds that no calibration needs among them."""
    words = _words(column)
    moving = bool(_RATES & set(words)) and words[-1] in ("x", "y", "z")
    return bool(_canonical(column)) or moving


def _canonical(column: ColumnGuess) -> str:
    """Canonical name of a column of the motion; empty for any other."""
    if column.values is None:
        return ""
    words, side = _words(column), column.name.side or column.name.place
    last = words[-1] if words else ""
    if column.quantity in ("com", "com_acc"):
        stem, unit = {"com": ("com", "m"), "com_acc": ("com_acc", "mps2")}[column.quantity]
        return f"{stem}_{column.name.axis}_{unit}"
    if rate := _MOMENTUM_RATE.fullmatch("".join(words)):
        return f"angmom_rate_{rate[1]}_nm" if rate[1] != "z" else ""
    if last in ("x", "y", "z") and (_MOMENTUM & set(words) or {"momentum", "rate"} <= set(words)):
        return f"angmom_rate_{last}_nm" if last != "z" else ""
    named = bool(_FEET & set(words)) or {*column.name.owner.split("_")} - {""} <= _AT
    if side not in {"left", "right", *_LEGS} or not named:
        return ""
    if column.quantity == "quaternion" and column.name.axis in ("x", "y", "z", "w"):
        return f"{side}_foot_q{column.name.axis}"
    if column.quantity == "angle":
        return f"{side}_foot_yaw_rad" if column.name.axis == "yaw" else ""
    if last in ("x", "y", "z") and not _RATES & set(words) and column.quantity not in _NO_PLACE:
        return f"{side}_foot_{last}_m"
    return ""


def _words(column: ColumnGuess) -> list[str]:
    """Words of a column's name without its unit."""
    stem, _, _ = split_unit(re.sub(r"\[(\d+)\]", r"_\1", column.column.lstrip("%#$/ ")))
    words = words_of(stem)
    if words and _IN_A_POSE.fullmatch(words[-1]) and {"pose", "translation"} & set(words):
        words = [*words[:-1], words[-1][-1]]
    counted = words[-1:] and words[-1].isdigit() and column.name.axis in ("x", "y", "z")
    return [*words[:-1], column.name.axis] if counted else words
