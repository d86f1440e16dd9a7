"""Which way gravity pulls on a transducer: how an attitude was meant, decided by the forces.

What hangs on a transducer pulls with ``f = w g + b``, `g` the direction of gravity in its frame.
An attitude can be written scalar first or last and lead from body to world or back; the reading
that makes the logged forces the weight of one thing is taken.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import (
    about_axes,
    gravity_in,
    nearest_rotations,
    rotation_of_quaternion,
    rotations_of_euler,
    rotations_of_rotvec,
    rotations_of_rpy,
)
from footcal_cli.sniff.groups import angle_unit, matrix, one_owner
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.names import LETTERED
from footcal_cli.sniff.plan import Entry, of
from footcal_cli.sniff.sides import opposite, pulls, sides_in
from footcal_cli.tables.columns import AXIS_ANGLE, ROTVEC, RPY, XYZ, ZYZ
from footcal_cli.tables.world import TO_Z_UP, WorldUp

EXPLAINED = 0.1
"""Share of the forces' variance that may be left by the right attitude."""
_UNEVEN = 0.3
"""How much the length of what should be gravity may change, as a share of it."""
_TURNED = 0.05
"""Variance of the direction of gravity from which an attitude can be distinguished from another."""
REACTS = (
    "{} the opposite of what pulls on {}: {} axes were turned round; or the world of the attitude "
    "points down (north-east-down): then take the factors out and set world_up"
)
"""What is said where forces and an attitude are of opposite sign."""
_DOWN = re.compile(r"(?i)(?:^|[\W_])(?:ned|frd|north_east_down|vehicle_attitude)(?:[\W_]|$)")
"""Names of worlds whose z points down."""
_INTRINSIC, _PROPER = partial(rotations_of_euler, "XYZ"), partial(rotations_of_euler, "ZYZ")
_ZYZ_SAID = "angles about z, y and the turned z"
Rotations = Callable[[FloatArray], FloatArray]
_MOST = 4000


@dataclass(frozen=True)
class Attitude:
    """How a log says which way gravity pulls.

    Parameters
    ----------
    entries
        Canonical column -> where.
    warnings
        What could be otherwise.
    reacts
        Whether the transducer reads the opposite of what pulls on it.
    explains
        Whether the forces are the weight of one thing in this attitude; None where they cannot
        say so.
    world_up
        The axis of the world that points up.
    """

    entries: Mapping[str, Entry]
    warnings: tuple[str, ...] = ()
    reacts: bool = False
    explains: bool | None = None
    world_up: WorldUp = "+z"


@dataclass(frozen=True)
class AttitudeReading:
    """One way to read an attitude: directions of gravity (n, 3), what it is called, what is up."""

    entries: Mapping[str, Entry]
    gravity: FloatArray
    said: str
    world_up: WorldUp = "+z"

    @property
    def upside_down(self) -> AttitudeReading:
        """The same in a world whose axis points down."""
        turned: WorldUp = "-z" if self.world_up == "+z" else "-y"
        return replace(self, gravity=-self.gravity, world_up=turned)


def attitude_of(file: FileGuess, force: FloatArray | None) -> Attitude | None:
    """The attitude in a log, as the forces of a transducer say it was meant; None without one.

    Parameters
    ----------
    file
        The log.
    force
        Of one transducer, shape (n, 3); None where several take turns.
    """
    found = [_best(candidates, force, file) for candidates in _kinds(file) if candidates]
    directed = _directions(file)
    if directed is not None:
        found.append(_best([directed], force, file, signed=True))
    explained = [one for one in found if one.explains]
    return next(iter(explained or found), None)


def readings_of(file: FileGuess) -> list[AttitudeReading]:
    """Every way to read the attitudes in a log, the plainest first."""
    found = [candidate for candidates in _kinds(file) for candidate in candidates]
    directed = _directions(file)
    if directed is not None:  # of the body, that carries several transducers
        entries = {f"body_{name}": entry for name, entry in directed.entries.items()}
        found.append(AttitudeReading(entries, directed.gravity, directed.said))
    return found


def upside_down(file: FileGuess, reading: AttitudeReading) -> str:
    """Why the world of a log seems to point down where the forces would be those of a reaction.

    Empty where nothing says so: a name, or an accelerometer, which shows up at rest.
    """
    names = " ".join((file.path.stem, *(c.column for c in file.columns)))
    if _DOWN.search(names):
        return "by its name its world points down"
    felt = one_owner(file.of("acceleration"), "xyz")
    if felt and not any("gravity" in name for name in reading.entries):
        along = np.nansum(_table([felt[a] for a in "xyz"]) * reading.gravity)
        return "by the accelerometer its world points down" if along > 0 else ""
    return ""


def _kinds(file: FileGuess) -> tuple[list[AttitudeReading], ...]:
    return _quaternions(file), _matrices(file), _angles(file), _three_numbers(file)


def named_orientation(words: Sequence[str], entry: Entry, force: FloatArray) -> Attitude | None:
    """Orientations by name: which axis points along gravity; None where a name says no axis.

    Parameters
    ----------
    words
        One per row of `force`, such as ``plus_x`` or ``z_up``.
    entry
        Where they stand.
    force
        Mean forces under these orientations, shape (n, 3).
    """
    axes = {word: axis for word, (axis, _) in sides_in(words).items()}
    if not all(axes.values()):
        return None
    gravity = np.array([pulls(axes[word] or "") for word in words])
    names = {word: axis or "" for word, axis in axes.items()}
    candidate = AttitudeReading({}, gravity, "")
    slope, left = _fit(candidate, force)
    warnings: tuple[str, ...] = ()
    reacts = bool(slope < 0 and left < EXPLAINED)
    if reacts:
        names = {word: opposite(axis) for word, axis in names.items()}
        warnings = (
            "the forces are the weight only if the names say which axis points up, or if the "
            "transducer reads what it exerts: each name was turned round",
        )  # fmt: skip
    if left > EXPLAINED:
        warnings = ("the forces are not the weight of one thing in the orientations named",)
    return Attitude({"orientation": replace(entry, names=names)}, warnings, False, left < EXPLAINED)


def _best(
    candidates: Sequence[AttitudeReading], force: FloatArray | None, file: FileGuess, *,
    signed: bool = False,
) -> Attitude:  # fmt: skip
    """The candidate under which the forces are a weight, the first where none is better."""
    first = candidates[0]
    if force is None or not turns(first.gravity):
        return Attitude(first.entries)
    fits = [_fit(candidate, force) for candidate in candidates]
    at = int(np.argmin([left for _, left in fits]))
    if fits[0][1] < 2 * fits[at][1] + 1e-4:
        at = 0
    chosen, (slope, left) = candidates[at], fits[at]
    if left > EXPLAINED:
        return Attitude(first.entries, (), False, False)
    warnings = [f"{chosen.said}: so the forces are the weight of one thing"] if at else []
    entries = chosen.entries
    if slope < 0 and signed:
        entries = {name: _turned(entry) for name, entry in entries.items()}
        warnings.append("gravity was turned round, so that what hangs on the transducer has weight")
    elif slope < 0 and (why := upside_down(file, chosen)):
        chosen, slope = chosen.upside_down, -slope
        warnings.append(f"{why}: so what hangs on the transducer has weight")
    elif slope < 0:
        warnings.append(REACTS.format("the transducer reads", "it", "its six"))
    reacts = bool(slope < 0 and not signed)
    return Attitude(entries, tuple(warnings), reacts, True, chosen.world_up)


def _turned(entry: Entry) -> Entry:
    return replace(entry, factor=-(entry.factor or 1.0))


def turns(gravity: FloatArray) -> bool:
    """Whether directions (n, 3) differ enough for attitudes to be distinguished."""
    return float(np.nanvar(gravity, axis=0).sum()) > _TURNED


def _fit(candidate: AttitudeReading, force: FloatArray) -> tuple[float, float]:
    """Weight, and the share of the forces' variance that ``w g + b`` leaves."""
    step = max(1, len(force) // _MOST)
    f, g = force[::step], candidate.gravity[::step]
    good = np.isfinite(f).all(axis=1) & np.isfinite(g).all(axis=1)
    if good.sum() < 3:
        return 0.0, 1.0
    f, g = f[good] - f[good].mean(axis=0), g[good] - g[good].mean(axis=0)
    spread = float((g * g).sum())
    if spread == 0.0 or not f.any():
        return 0.0, 1.0
    slope = float((f * g).sum()) / spread
    return slope, float(((f - slope * g) ** 2).sum() / (f * f).sum())


def _table(columns: Sequence[ColumnGuess]) -> FloatArray:
    return np.column_stack([c.values if c.values is not None else np.nan for c in columns])


def _worlds(
    entries: Mapping[str, Entry], rotations: FloatArray, said: str
) -> tuple[AttitudeReading, AttitudeReading]:
    """An attitude in a world whose z points up, and in one whose y does."""
    return (
        AttitudeReading(entries, gravity_in(rotations), said),
        AttitudeReading(entries, gravity_in(TO_Z_UP["+y"] @ rotations), f"{said}, y up", "+y"),
    )


def _quaternions(file: FileGuess) -> list[AttitudeReading]:
    """A quaternion by its letters, or by its numbers in either order, and its conjugate."""
    found = file.of("quaternion")
    named = one_owner(found, "xyzw")
    numbered = one_owner(found, "0123")
    orders = {}
    if named:
        orders["as it is named"] = [named[a] for a in "xyzw"]
    elif numbered:
        columns = [numbered[a] for a in "0123"]
        orders = {"scalar first": [*columns[1:], columns[0]], "scalar last": columns}
    candidates: list[AttitudeReading] = []
    for order, columns in orders.items():
        values = _table(columns)
        norm = np.linalg.norm(values, axis=1)
        if not np.nanmedian(np.abs(norm - 1.0)) < 0.05:
            return []  # four numbers that are no quaternion
        for sign, way in ((1.0, "body to world"), (-1.0, "world to body")):
            entries = {
                f"body_q{a}": replace(of(c), unit=None)
                for a, c in zip("xyzw", columns, strict=True)
            }
            if sign < 0:
                entries["body_qw"] = replace(entries["body_qw"], factor=-1.0)
            rotations = rotation_of_quaternion(values * [1.0, 1.0, 1.0, sign])
            candidates += _worlds(entries, rotations, f"quaternion {order}, {way}")
    return candidates


def _matrices(file: FileGuess) -> list[AttitudeReading]:
    """A rotation matrix, and its transpose."""
    found = matrix(file)
    if not found:
        return []
    rows = nearest_rotations(_table([c for c, _ in found.values()]).reshape(-1, 3, 3))
    names = list(found)
    turned = [names[3 * j + i] for i in range(3) for j in range(3)]
    plain = {n: of(found[n][0]) for n in names}
    back = {n: of(found[m][0]) for n, m in zip(names, turned, strict=True)}
    return [
        *_worlds(plain, rows, "body to world"),
        *_worlds(back, np.swapaxes(rows, 1, 2), "a matrix from world to body"),
    ]


def _angles(file: FileGuess) -> list[AttitudeReading]:
    """Roll, pitch and yaw, and the same with the other sign."""
    angles = one_owner(file.of("angle"), ("roll", "pitch", "yaw"))
    entries: dict[str, Entry] = {}
    if not angles:
        angles = one_owner(file.of("angle"), ("roll", "pitch"))
        entries["body_yaw_rad"] = Entry(value="0.0", why="gravity does not depend on the heading")
    if not angles:
        return []
    unit = angle_unit(angles)
    entries |= {f"body_{a}_rad": of(c, unit) for a, c in angles.items()}
    scale = np.pi / 180 if unit == "deg" else 1.0
    values = _table([angles[a] for a in ("roll", "pitch")]) * scale
    values = np.column_stack([values, np.zeros(len(values))])
    heading = _table([angles["yaw"]])[:, 0] * scale if "yaw" in angles else 0.0
    whole = values.copy()
    whole[:, 2] = heading
    back = {name: replace(e, factor=-1.0) for name, e in entries.items() if e.column is not None}
    found = [
        *_worlds(entries, rotations_of_rpy(whole), "roll, pitch and yaw"),
        *_worlds({**entries, **back}, rotations_of_rpy(-whole), "angles with the other sign"),
    ]
    if all(angles[a].name.owner == LETTERED for a in angles) and "yaw" in angles:  # A, B, C
        columns = [angles[a] for a in ("yaw", "pitch", "roll")]
        for names, rotations, way in (
            (ZYZ, _PROPER, _ZYZ_SAID), (RPY, rotations_of_rpy, "angles about x, y and z"),
            (XYZ, _INTRINSIC, "angles about x, the turned y and the turned z"),
        ):  # fmt: skip
            named = {n: of(c, unit) for n, c in zip(names, columns, strict=True)}
            found += _worlds(named, rotations(_table(columns) * scale), way)
    return found


def _three_numbers(file: FileGuess) -> list[AttitudeReading]:
    """``rx ry rz`` of an arm: a rotation vector or angles about x, y and z, either way round.

    Or about x, the turned y and the turned z; or angles that are called ones about z, y and the
    turned z, or an axis and an angle.
    """
    ways: list[list[AttitudeReading]] = []
    forms: tuple[tuple[tuple[str, ...], str, Rotations], ...] = (
        (ROTVEC, "a rotation vector", rotations_of_rotvec),
        (RPY, "angles about x, y and z", rotations_of_rpy),
        (XYZ, "angles about x, the turned y and the turned z", _INTRINSIC),
    )
    found = one_owner(file.of("angle"), ("rx", "ry", "rz"))
    if not found:
        found = one_owner(file.of("angle"), ("z1", "y2", "z3"))
        forms = ((ZYZ, _ZYZ_SAID, _PROPER),)
    if not found:
        return _axis_and_angle(file)
    unit = angle_unit(found)
    values = _table(list(found.values())) * (np.pi / 180 if unit == "deg" else 1.0)
    for names, said, rotations in forms:
        entries = {n: of(c, unit) for n, c in zip(names, found.values(), strict=True)}
        back = {n: replace(entry, factor=-1.0) for n, entry in entries.items()}
        ways.append(
            [
                *_worlds(entries, rotations(values), said),
                *_worlds(back, rotations(-values), f"{said}, with the other sign"),
            ]
        )
    if unit != "rad":  # angles are likelier than a vector
        ways = [*ways[1:], *ways[:1]]
    return [one for own in ways for one in own]


def _axis_and_angle(file: FileGuess) -> list[AttitudeReading]:
    """An axis of length one and the angle about it, and the other way round."""
    found = one_owner(file.of("angle"), ("ax", "ay", "az", "angle"))
    if not found:
        return []
    angle = found["angle"]
    unit = angle_unit({"angle": angle})
    values = _table([found[a] for a in ("ax", "ay", "az", "angle")])
    values[:, 3] *= np.pi / 180 if unit == "deg" else 1.0
    entries = {n: of(c) for n, c in zip(AXIS_ANGLE[:3], found.values(), strict=False)}
    entries[AXIS_ANGLE[3]] = of(angle, unit)
    back = {**entries, AXIS_ANGLE[3]: replace(entries[AXIS_ANGLE[3]], factor=-1.0)}
    rotations = rotations_of_rotvec(about_axes(values))
    return [
        *_worlds(entries, rotations, "an axis and an angle"),
        *_worlds(back, np.swapaxes(rotations, 1, 2), "an axis and an angle, from world to body"),
    ]


def _directions(file: FileGuess) -> AttitudeReading | None:
    """Gravity itself, or what an accelerometer at rest reads, which points up."""
    for quantity, sign in (("gravity", 1.0), ("acceleration", -1.0)):
        found = one_owner(file.of(quantity), "xyz")
        if not found:
            continue
        values = sign * _table([found[a] for a in "xyz"])
        size = np.linalg.norm(values, axis=1, keepdims=True)
        if np.nanstd(size) > _UNEVEN * np.nanmean(size):
            continue  # no direction of gravity: it was taken out, or the sensor is shaken
        entries = {f"gravity_{a}": replace(of(c), unit=None) for a, c in found.items()}
        if sign < 0:
            why = "an accelerometer at rest reads what points up"
            entries = {n: replace(e, factor=-1.0, why=why) for n, e in entries.items()}
        return AttitudeReading(entries, values / np.where(size > 0, size, np.nan), quantity)
    return None
