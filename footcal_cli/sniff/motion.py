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
from footcal_cli.core.spatial import rotations_logged
from footcal_cli.sniff.body_columns import length_unit
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.names import COMMANDED, words_of
from footcal_cli.sniff.plan import Entry, of, times
from footcal_cli.sniff.triples import MATRIX, ROLL_PITCH_YAW
from footcal_cli.sniff.units import LENGTHS, known_unit, metres_per, split_unit
from footcal_cli.sniff.vocabulary import SOLES
from footcal_cli.tables.world import TO_Z_UP, WorldUp

_STEP_M, _AWAY, _AWAY_M = 0.03, 0.7, 0.5
"""A foot that stands moves by less, as far as an estimator's drift goes; a CoM above such feet by
less than a share of its height, or where that is not known than half a metre."""
_JUMP_M, _STANCE_ROWS = 0.005, 20
"""From one stance to the next a foot is this far away at once, and stays for so many rows."""
_LENGTH = re.compile(r"(?i)\blength\W{0,3}units?\W+([a-z]+)")
"""``Length Units,Meters``, as motion capture says above its table."""
_STEADY_DEG, _ASKEW_DEG = 35.0, 20.0
"""How far lines between feet may scatter in steps, and feet that point along x stand askew."""
_WALKED = 2.0
"""Widths of a stance by which feet have gone somewhere."""
_LEVEL = 0.9
"""How much of a foot's z axis points up at least."""
_RATES = {"vel", "velocity", "v", "speed", "omega", "twist"}
_IN_A_POSE = re.compile(r"[tp][xyz]")
"""Where a pose is: its ``tx`` is no torque."""
_MOMENTUM = {"ldot", "hdot", "angmom", "dl", "dh"}
_MOMENTUM_RATE = re.compile(r"(?:d[lh]|[lh]dot)([xyz])")
"""dLx, HdotY: written in one word."""
_FEET = {"foot", "feet", "lfoot", "rfoot", "footl", "footr", "ankle", *SOLES}
_LEGS = {"fl", "fr", "ml", "mr", "hl", "hr", "rl", "rr"}
_BEHIND = {"ml", "mr", "hl", "hr", "rl", "rr"}
_AT = {"pos", "position", "p", "x", "y", "z", "yaw", "w", "q", "quat", "quaternion", "orientation"}
"""All that the name of a foot's place says besides which foot: ``left.pos.x``."""
_ATTITUDES = ("quaternion", "angle", "matrix", "gravity")
_NO_PLACE = {"force", "cop", "acceleration", "com", "com_acc", "quaternion", "angle"}


def body_entries(file: FileGuess, *, on_cells: bool = True) -> dict[str, Entry]:
    """Stamps and every column of the motion, by canonical name.

    `on_cells`: cells stand at places in frames of feet whose z is up; others have no place there.
    """
    entries, _, _ = times(file, needed=False)
    asked = {c.column for c in file.of("com", "com_acc") if COMMANDED & set(words_of(c.column))}
    if len(asked) < len(file.of("com")):  # what was asked for stands next to what was reached
        file = replace(file, columns=tuple(c for c in file.columns if c.column not in asked))
    length = next((u for x in file.text.above if (f := _LENGTH.search(x)) and
                   (u := known_unit(f[1])) in LENGTHS), None)  # fmt: skip
    length = length or _by_its_size(file)
    behind = any(c.name.place in _BEHIND for c in file.columns)
    stepping = {c.name.owner for c in file.of("motion") if c.name.owner.endswith("_foot_x_m")}
    for column in file.columns:
        name = _canonical(column)
        if stepping and column.quantity != "motion" and re.search(r"_foot_[xyz]_m$", name):
            continue  # the feet were found by their steps: L_x is an angular momentum beside them
        if not behind:  # LF and RF of two feet are no front legs
            name = name.replace("fl_foot", "left_foot").replace("fr_foot", "right_foot")
        if name and name not in entries:
            default = next((u for end, u in _UNITS.items() if name.endswith(end)), None)
            if length and name.endswith(_PLACES):
                default = length
            entries[name] = of(column, column.unit or default)
    entries = _level(entries)
    return _on_the_floor(_without_other_frames(entries, file) if on_cells else entries)


def _by_its_size(file: FileGuess) -> str | None:
    """The unit of places without one by the height of the CoM: 404 is mm, 40 is cm, 0.4 is m."""
    for column in file.of("com"):
        if column.name.axis == "z" and column.unit is None and column.values is not None:
            unit = length_unit(column.values)
            return unit if unit != "m" else None
    return None


def _level(entries: dict[str, Entry]) -> dict[str, Entry]:
    """The motion with qx = qy = 0 for feet of which w and z of a quaternion alone are logged."""
    why = "not logged: the foot is taken to stand level"
    made = dict(entries)
    for side in ("left", "right"):
        w, x, y, z = (f"{side}_foot_q{a}" for a in "wxyz")
        if {w, z} <= set(entries) and not {x, y} & set(entries):
            made |= {name: Entry(value="0.0", sure="guess", why=why) for name in (x, y)}
    return made


def _on_the_floor(entries: dict[str, Entry]) -> dict[str, Entry]:
    """The motion with z = 0 for feet of which x and y alone are logged: soles flat on the floor."""
    feet = [name.removesuffix("_foot_x_m") for name in entries if name.endswith("_foot_x_m")]
    if not {"com_x_m", "com_y_m"} <= set(entries):
        return entries
    flat = [foot for foot in feet if f"{foot}_foot_y_m" in entries]
    if len(flat) < len(feet) or any(f"{foot}_foot_z_m" in entries for foot in feet):
        return entries
    why = "not logged: the sole is taken to lie on the floor, from where the CoM's z counts"
    said = Entry(value="0.0", sure="guess", why=why)
    return entries | {f"{foot}_foot_z_m": said for foot in flat}


def _without_other_frames(entries: dict[str, Entry], file: FileGuess) -> dict[str, Entry]:
    """The motion without feet's orientations of frames whose z is not up where the world's is not.

    Motion capture with y up creates bodies with y up: such an orientation is not that of the foot
    in whose frame the cells' places are known. The feet are then taken to stand level.
    """
    up = up_of(entries, {column.column: column for column in file.columns})
    entries = _without_steep(entries, up)
    if up == "+z":
        return entries | _headings(entries, up)
    axis, sign = "xyz".index(up[1]), 1.0 if up[0] == "+" else -1.0
    kept = dict(entries)
    for side in ("left", "right"):
        for numbers in ([f"q{a}" for a in "xyzw"], [f"r{n}" for n in MATRIX]):
            names = [f"{side}_foot_{one}" for one in numbers]
            columns = [e.column.values for n in names if (e := entries.get(n)) and e.column]
            logged = [values for values in columns if values is not None]
            if len(logged) != len(names):
                continue
            rises = _rises(np.column_stack(logged), axis)
            if np.nanmedian(sign * rises) < _LEVEL:
                kept = {name: entry for name, entry in kept.items() if name not in names}
    return kept | _headings(kept, up)


def _without_steep(entries: Mapping[str, Entry], up: WorldUp) -> dict[str, Entry]:
    """The motion without roll and pitch that are no sole's: other axes, joints, or no radians."""
    steep = set()
    for name, entry in entries.items():
        if not name.endswith(("_foot_roll_rad", "_foot_pitch_rad")) or entry.column is None:
            continue
        tilt = numbers_of(entry.column)
        tilt = np.radians(tilt) if entry.unit == "deg" else tilt
        if up != "+z" or not np.nanmedian(np.abs(tilt)) < np.arccos(_LEVEL):
            steep.add(name.rpartition("_foot_")[0])
    tilts = {f"{foot}_foot_{angle}_rad" for foot in steep for angle in ("roll", "pitch")}
    return {name: entry for name, entry in entries.items() if name not in tilts}


def _rises(logged: FloatArray, axis: int) -> FloatArray:
    """A foot's z along an axis of the world by its quaternion (n, 4) or its matrix (n, 9)."""
    if logged.shape[1] == len(MATRIX):
        return logged[:, 3 * axis + 2]
    return rotations_logged(logged)[:, axis, 2]


def _headings(entries: Mapping[str, Entry], up: WorldUp) -> dict[str, Entry]:
    """Which way feet point whose orientation is not logged, where that is not along x.

    The left foot stands on the left of the right one: with ``d`` from the right to the left one,
    its heading is ``atan2(-d_x, d_y)``. Empty where that differs from row to row as in a turn, by
    less from x than feet are set askew, or where feet that walk go another way.
    """
    turned = any(re.search(r"_foot_(?:yaw_rad|qw|r11)$", name) for name in entries)
    feet = [_place(entries, f"{side}_foot") for side in ("left", "right")]
    left, right = feet
    if turned or left is None or right is None or up == "-z" or left.shape != right.shape:
        return {}
    good = np.isfinite(left + right).all(axis=1)
    if not good.any():
        return {}
    apart, middle = ((left - right)[good] @ TO_Z_UP[up].T, (left + right)[good] @ TO_Z_UP[up].T / 2)
    heading = np.angle(np.exp(1j * np.arctan2(-apart[:, 0], apart[:, 1])).mean(), deg=True)
    ways = np.degrees(np.arctan2(-apart[:, 0], apart[:, 1])) - heading
    usual = float(np.median(np.abs((ways + 180.0) % 360.0 - 180.0)))
    if usual > _STEADY_DEG or abs(heading) < max(_ASKEW_DEG, 2.0 * usual):
        return {}
    gone = (middle[-1] - middle[0])[:2]
    along = abs(gone @ [np.cos(np.radians(heading)), np.sin(np.radians(heading))])
    far = float(np.linalg.norm(gone))
    if far > _WALKED * np.median(np.linalg.norm(apart[:, :2], axis=1)) and along < 0.7 * far:
        return {}  # sideways, or with one foot before the other
    why = "not logged: the left foot stands on the left of the right one"
    said = Entry(value=f"{np.radians(heading):.4f}", sure="guess", why=why)
    return {f"{side}_foot_yaw_rad": said for side in ("left", "right")}


def _place(
    entries: Mapping[str, Entry], stem: str, own: Mapping[str, ColumnGuess] | None = None
) -> FloatArray | None:
    """A place of a motion by its canonical names, or by columns called so; None without."""
    names = [f"{stem}_{axis}_m" for axis in "xyz"]
    columns = [entries[n].column if n in entries else (own or {}).get(n) for n in names]
    values = [c.values for c in columns if c is not None and c.values is not None]
    return np.column_stack(values) if len(values) == 3 else None


_PLACES = ("_x_m", "_y_m", "_z_m")
_UNITS = {
    **{f"_foot_{axis}_m": "m" for axis in "xyz"},
    **{f"_foot_{axis}_rad": "rad" for axis in ROLL_PITCH_YAW},
}


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
        if c.quantity not in ("com", "com_acc", "motion", "angle", "quaternion") and _of_motion(c)
        else c
        for c in file.columns
    )
    return replace(file, columns=tuple(columns))


def walks(entries: Mapping[str, Entry]) -> bool:
    """Whether a body's motion is one of steps: a foot's place moves along the ground.

    Where no foot's place is logged, the CoM leaves the ground that feet could stand on.

    A stand shows no scale of a horizontal force; `static-init` asks it for none.
    """

    def far(*ends: str) -> list[float]:
        columns = [
            (e.column.values, e.unit) for name, e in entries.items()
            if e.column is not None and e.column.values is not None and name.endswith(ends)
        ]  # fmt: skip
        spans = [np.ptp(np.nanquantile(values, [0.01, 0.99])) for values, _ in columns]
        return [float(s) * metres_per(unit) for s, (_, unit) in zip(spans, columns, strict=True)]

    feet = far("_foot_x_m", "_foot_y_m")
    if feet:
        return max(feet) > _STEP_M and not _put_elsewhere(entries)
    away = max(far("com_x_m", "com_y_m"), default=0.0)
    com = _place(entries, "com")
    high = 0.0 if com is None else float(abs(np.nanmedian(com[:, 2])))
    height = high * metres_per(entries["com_z_m"].unit) if high else 0.0
    return away > (_AWAY * height if height > _STEP_M else _AWAY_M)


def _put_elsewhere(entries: Mapping[str, Entry]) -> bool:
    """Whether feet stand still but for a few rows at which all goes on elsewhere: stances in a row.

    Through a step a foot moves from row to row; where stances follow one another in one table, it
    is elsewhere at once, and stays there.
    """
    columns = [
        e.column.values * metres_per(e.unit) for name, e in entries.items()
        if name.endswith(("_foot_x_m", "_foot_y_m")) and e.column is not None
        and e.column.values is not None
    ]  # fmt: skip
    places = np.column_stack(columns)
    with np.errstate(invalid="ignore"):
        jumps = np.flatnonzero(np.any(np.abs(np.diff(places, axis=0)) > _JUMP_M, axis=1)) + 1
    stances = np.split(places, jumps)
    if len(stances) < 2 or min(map(len, stances)) < _STANCE_ROWS:
        return False
    spans = [np.ptp(np.nanquantile(own, [0.01, 0.99], axis=0), axis=0) for own in stances]
    return bool(np.nanmax(spans) <= _STEP_M)


def up_of(entries: Mapping[str, Entry], own: Mapping[str, ColumnGuess] | None = None) -> WorldUp:
    """The axis of the world that points up, by the CoM above left and right foot: +z for want."""
    com = _place(entries, "com", own)
    feet = [at for side in ("left", "right")
            if (at := _place(entries, f"{side}_foot", own)) is not None]  # fmt: skip
    if com is None or not feet:
        return "+z"
    stacked = np.stack(feet, axis=1)
    good = np.isfinite(com).all(axis=1) & np.isfinite(stacked).all(axis=(1, 2))
    up = upright_axis(com[good], stacked[good]) if good.any() else ""
    return next((axis for axis in TO_Z_UP if axis == up), "+z")


def upright(file: FileGuess, entries: Mapping[str, Entry]) -> tuple[str, ...]:
    """A recipe's line that says which axis of the world points up, where it is not z."""
    up = up_of(entries, {column.column: column for column in file.columns})
    if up == "+z":
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
    if column.quantity == "motion":
        return column.name.owner
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
        turned = column.name.axis in ROLL_PITCH_YAW
        return f"{side}_foot_{column.name.axis}_rad" if turned else ""
    if last in ("x", "y", "z") and not _RATES & set(words) and column.quantity not in _NO_PLACE:
        return f"{side}_foot_{last}_m"
    return ""


def is_momentum_rate(name: str) -> bool:
    """Whether a name is that of the rate of an angular momentum about x or y."""
    words = words_of(name)
    return words[-1:] in (["x"], ["y"]) and {"momentum", "rate"} <= set(words)


def _words(column: ColumnGuess) -> list[str]:
    """Words of a column's name without its unit."""
    stem, _, _ = split_unit(re.sub(r"\[(\d+)\]", r"_\1", column.column.lstrip("%#$/ ")))
    words = words_of(stem)
    if words and _IN_A_POSE.fullmatch(words[-1]) and {"pose", "translation", *_FEET} & set(words):
        words = [*words[:-1], words[-1][-1]]
    counted = words[-1:] and words[-1].isdigit() and column.name.axis in ("x", "y", "z")
    return [*words[:-1], column.name.axis] if counted else words
