"""Columns that are numbered, not named: a wrench, a pose or a matrix by its place in a row."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import nearest_rotations
from footcal_cli.sniff.couples import couples
from footcal_cli.sniff.derived import SCATTERS
from footcal_cli.sniff.groups import AXES, are_two_plates, owner_of
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.legs_in_rows import of_legs
from footcal_cli.sniff.names import (
    FORCE,
    LETTERED,
    NOISE,
    TORQUE,
    NameGuess,
    Quantity,
    name_guess,
    words_of,
)
from footcal_cli.sniff.pressed import carry_alike
from footcal_cli.sniff.quaternions import (
    by_letters,
    in_a_row,
    of_length_one,
    without_other_lengths,
)
from footcal_cli.sniff.units import GRAVITY_MPS2, split_unit

_INDEXED = re.compile(r"^(.*?)[\[_. (]*(\d+)[\])]*$")
_WRENCH_STEM = re.compile(
    r"wrench|(?<!le)ft|force|tcp|f_ext|reaction|sensordata|spatial", re.IGNORECASE
)
_POSE_STEM = re.compile(r"pose|tcp|flange", re.IGNORECASE)
_NO_WRENCH = re.compile(
    r"pose|position|speed|vel|foot|feet|joint(?!.?reaction)|target|leg|strut|actuator|cable|tendon",
    re.IGNORECASE,
)
"""Also forces along legs, struts and cables: six of a platform are no wrench."""
_SAID_WRENCH = re.compile(r"wrench|(?<!le)ft(?![a-z])", re.IGNORECASE)
"""Six numbers of a foot that is called so are one."""
_ACCELERATION = {"acc", "accel", "acceleration", "accelerometer"}
_LETTER = re.compile(
    r"(?:^|[\W_])([A-Z])$|(?i:(?:rot|orient|angle?|euler|dreh|giro|rotaci[oó]n)[a-z]*[\W_]?([a-z])$)"
)
"""The letter of an angle: a capital alone, or any behind a word for turning."""
_WHOLE_TURN_DEG = 360.0
_GRAVITY_WITHIN, _NEARLY_ALL = 0.03, 0.9
"""How far an accelerometer at rest is from g, and in which share of rows."""
_ROWS_OF_A_POSE, _ORTHONORMAL = 3, 0.02
"""A pose without its last row, and how far its rotation may be from one."""
_AS_LONG_AS: Mapping[Quantity, float] = {"acceleration": GRAVITY_MPS2, "gravity": 1.0}
"""How long three components are, by what they are of."""
_VECTORS: tuple[tuple[Collection[str], Quantity, str], ...] = (
    (FORCE, "force", "f"), (TORQUE, "force", "t"), (_ACCELERATION, "acceleration", ""),
    ({"gravity", "grav"}, "gravity", ""),
)  # fmt: skip
"""Words of a vector, its quantity, and the letter before its axes."""
_SAID_OF_VECTORS = {"n", "nm", "linear", "vector", "vec", "dir", "direction", "unit"}
_VECTOR_LETTER = re.compile(r"(?:.*[\W_])?[FMT]")
"""A vector that is called by its capital: ``F(1)``."""
_PLACES = {"p", "pos", "position", "xyz"}
_TURNS = 0.05
"""How much a component changes at least where a quaternion is recognised by its length."""
_TURNED_AND_FELT = 9
"""Three numbers of an attitude and six of a wrench."""
_STILL, _SWINGS = 0.1, 0.3
"""Shares of their largest number by which forces in one attitude, and torques there, scatter."""
_LARGER = 3.0
"""Forces in N are larger than torques in Nm by this much, in nearly every log."""


def numbered(file: FileGuess) -> FileGuess:
    """The log with numbered columns taken for wrenches, poses and rotation matrices."""
    file = replace(file, columns=tuple(_in_radians(c) for c in of_length_one(file)))
    file = without_other_lengths(file)
    stems: dict[str, list[ColumnGuess]] = {}
    for column in file.columns:
        found = _INDEXED.match(column.column)
        if found and column.values is not None and column.quantity != "motion":
            stems.setdefault(found[1], []).append(column)
    made: dict[str, ColumnGuess] = {}
    for stem, columns in stems.items():
        if len(columns) == 6 and _POSE_STEM.search(stem) and "force" not in stem.lower():
            made |= _pose(columns)
        elif len(columns) in (9, 12, 16):
            made |= _matrix(columns)
    if not any(column.quantity in ("matrix", "angle") for column in made.values()):
        made = {}
    axes = {c.name.axis for c in file.of("quaternion")}
    whole = axes >= set("xyzw") or axes >= set("0123")
    if not whole and not any(c.quantity == "matrix" for c in (*file.columns, *made.values())):
        made |= in_a_row(stems) or by_letters(file)
    made |= _wrenches(file, stems, made)
    made |= couples(file)
    felt_by = sum(c.name.axis == "fx" for c in made.values())
    beside = [c for stem, c in stems.items() if len(c) == len(AXES) and c[0].column not in made]
    if felt_by == len(beside) == 1 and not file.of("quaternion", "angle", "matrix", "gravity"):
        made |= _pose(beside[0])  # six numbers beside a wrench
    if not file.of("angle", "gravity", "matrix", "acceleration", "quaternion") and not any(
        c.quantity in ("quaternion", "angle", "matrix") for c in made.values()
    ):
        felt = _gravity(file)
        made |= {} if felt.keys() & made.keys() else felt
    if not whole and not file.of("angle", "gravity", "matrix") and file.of("force"):
        made |= {k: v for k, v in _lettered(file).items() if k not in made}
    for stem, columns in stems.items():
        cells = {c.column for c in file.of("reading")} - {c.column for c in columns}
        moved = bool(cells) and any("com" in words_of(other) for other in stems)
        made |= {k: v for k, v in _vector(stem, columns, moved).items() if k not in made}
    made = made or _axes_again(file)
    return replace(file, columns=tuple(made.get(c.column, c) for c in file.columns))


def numbered_beside(sheet: FileGuess, file: FileGuess) -> FileGuess:
    """A sheet with its columns as they are meant beside the forces of a log."""
    names = {c.column for c in sheet.columns}
    felt = [c for c in numbered(file).of("force") if c.column not in names]
    whole = numbered(replace(sheet, columns=(*sheet.columns, *felt)))
    return replace(whole, columns=tuple(c for c in whole.columns if c.column in names))


def _wrenches(
    file: FileGuess, stems: dict[str, list[ColumnGuess]], taken: dict[str, ColumnGuess]
) -> dict[str, ColumnGuess]:
    """Six numbered or nameless columns as a wrench."""
    six = {
        stem: c for stem, c in stems.items()
        if len(c) == 6 and _WRENCH_STEM.search(stem)
        and (not _NO_WRENCH.search(stem) or (name_guess(stem).side and _SAID_WRENCH.search(stem)))
        and c[0].column not in taken and not SCATTERS & {*words_of(stem)}
    }  # fmt: skip
    six = six or of_legs({k: c for k, c in stems.items() if c[0].column not in taken})
    nameless = [c for c in file.columns if c.column.startswith("column_")]
    free = [
        c for c in nameless
        if c.quantity == "unknown" and c.values is not None and c.column not in taken
    ]  # fmt: skip
    made: dict[str, ColumnGuess] = {}
    if not six and len(free) == len(AXES) and not any(c.counts for c in free):
        six = {"": free}
    elif not six and not file.of("quaternion", "angle", "matrix", "gravity") and not taken:
        moving = [c for c in free if np.nanstd(numbers_of(c)) > 0]
        if are_two_plates(moving):
            six = {"plate 1": moving[: len(AXES)], "plate 2": moving[len(AXES) :]}
        elif len(moving) in (_TURNED_AND_FELT, _TURNED_AND_FELT + 3) and not moving[-1].counts:
            six = {"": moving[-len(AXES) :]}  # a pose and a wrench
            where, turned = moving[:-_TURNED_AND_FELT], moving[-_TURNED_AND_FELT : -len(AXES)]
            made = _pose([*where, *turned])
    for stem, columns in six.items():
        torque_first = all(
            size(columns[3:]) > _LARGER * size(columns[:3]) for size in (_scatter, _largest)
        ) and not (_swing(columns[:3]) < _STILL and _swing(columns[3:]) > _SWINGS)
        # in one attitude forces stand still, and torques of a leg that swings do not: in gf cm
        order = AXES[3:] + AXES[:3] if torque_first else AXES
        why = "six columns in a row; " + (
            "the last three vary more, so they are the forces" if torque_first
            else "forces first, as most logs have them"
        )  # fmt: skip
        owner = owner_of(re.sub(r"(?i)wrench|force|ft|tcp|actual|[\[_.]+", " ", stem).strip())
        for axis, column in zip(order, columns, strict=True):
            name = replace(
                column.name, quantity="force", axis=axis, owner="" if owner == "sensor" else owner,
                unit=None,
            )  # fmt: skip
            made[column.column] = replace(column, name=name, sure="guess", why=why)
    return made


def _scatter(columns: Sequence[ColumnGuess]) -> float:
    """The largest sd of several columns."""
    return max(float(np.nanstd(numbers_of(c))) for c in columns) + 1e-9


def _swing(columns: Sequence[ColumnGuess]) -> float:
    """How far several columns move beside their largest number."""
    return _scatter(columns) / (_largest(columns) + 1e-9)


def _largest(columns: Sequence[ColumnGuess]) -> float:
    """The largest number in several columns, whatever its sign."""
    return max(float(np.nanmax(np.abs(numbers_of(c)))) for c in columns)


def _gravity(file: FileGuess) -> dict[str, ColumnGuess]:
    """Three unnamed numbers in a row as long as gravity, or as 1, though they change."""
    unnamed = ("unknown", "reading")
    for three in zip(file.columns, file.columns[1:], file.columns[2:], strict=False):
        if any(c.values is None or c.name.axis or c.quantity not in unnamed for c in three):
            continue
        values = np.column_stack([numbers_of(c) for c in three])
        values = values[np.isfinite(values).all(axis=1)]
        if len(values) < 3 or np.ptp(values, axis=0).max() < _TURNS * np.abs(values).max():
            continue
        size = np.linalg.norm(values, axis=1)
        for quantity, length in _AS_LONG_AS.items():
            if np.mean(np.abs(size - length) < _GRAVITY_WITHIN * length) > _NEARLY_ALL:
                return {
                    c.column: replace(
                        c, name=NameGuess(quantity, axis), unit=None, sure="likely",
                        why="three numbers as long as gravity",
                    )
                    for axis, c in zip("xyz", three, strict=True)
                }  # fmt: skip
    return {}


def _lettered(file: FileGuess) -> dict[str, ColumnGuess]:
    """Angles of an arm's flange by their letters: W P R about x, y, z; A B C about z, y, x.

    O A T are about z, y and the z that has turned. Three other letters in a row are angles too, of
    which the forces say what they are about.
    """
    found: dict[str, ColumnGuess] = {}
    for column in file.columns:
        last = _LETTER.search(split_unit(column.column)[0].strip())
        values = column.values
        if last is None or values is None or column.unit not in (None, "deg", "rad"):
            continue
        if np.nan_to_num(np.abs(values)).max(initial=0.0) <= _WHOLE_TURN_DEG:
            found.setdefault((last[1] or last[2]).upper(), column)
    one = sum(c.name.axis == "fx" for c in file.of("force")) == 1
    others = "".join(
        letter for letter, c in found.items()
        if one and letter not in "XYZ" and c.quantity != "time" and np.nanstd(numbers_of(c)) > 0
    )  # fmt: skip
    for letters, angles in (
        ("WPR", ("roll", "pitch", "yaw")), ("ABC", ("yaw", "pitch", "roll")),
        ("OAT", ("z1", "y2", "z3")), (others, ("yaw", "pitch", "roll")),
    ):  # fmt: skip
        if len(letters) == len(angles) and set(letters) <= set(found):
            named = letters in ("WPR", "OAT")
            return {
                found[letter].column: replace(
                    found[letter], sure="likely", why=f"one of the angles {' '.join(letters)}",
                    name=NameGuess("angle", angle, unit=found[letter].unit,
                                   owner="" if named else LETTERED),
                )
                for letter, angle in zip(letters, angles, strict=True)
            }  # fmt: skip
    return {}


def _vector(
    stem: str, columns: Sequence[ColumnGuess], moved: bool = False
) -> dict[str, ColumnGuess]:
    """``force[0] … force[2]`` as its components along x, y and z.

    `moved`: a CoM and readings stand next to it, so that three numbers of a foot are its place.
    """
    words = words_of(stem)
    if len(columns) != 3 or not words:
        return {}
    *before, last = [w for w in words if w not in _SAID_OF_VECTORS] or words
    for called, quantity, letter in () if carry_alike(columns) else _VECTORS:
        if last in called and (len(last) > 1 or _VECTOR_LETTER.fullmatch(stem)):
            if quantity == "acceleration" and "com" in before:
                quantity = "com_acc"
            owner = "_".join(w for w in before if w not in NOISE)
            return {
                c.column: replace(
                    c, name=replace(c.name, quantity=quantity, axis=f"{letter}{axis}", owner=owner),
                    sure="likely", why=f"the {i + 1}. of three numbers of a vector",
                )
                for i, (axis, c) in enumerate(zip("xyz", columns, strict=True))
            }  # fmt: skip
    named = [name_guess(f"{stem}_{axis}") for axis in "xyz"]
    placed = _PLACES & set(words) or (
        moved and {"foot", "feet"} & set(words) and not all(c.counts for c in columns)
    )
    if "com" not in words and not (named[0].side and placed):
        return {}
    return {
        c.column: replace(
            c, name=replace(name, axis=axis), sure="likely", why=f"the {axis} of a body's motion"
        )
        for axis, name, c in zip("xyz", named, columns, strict=True)
    }


def _in_radians(column: ColumnGuess) -> ColumnGuess:
    """An angle in thousandths of a radian."""
    if column.quantity != "angle" or column.unit != "mrad" or column.values is None:
        return column
    name = replace(column.name, unit="rad", factor=1e-3)
    return replace(column, name=name, unit="rad", values=1e-3 * column.values)


def _axes_again(file: FileGuess) -> dict[str, ColumnGuess]:
    """Columns that are called x, y, z alone, again and again, as pandas counts them: ``x.1``.

    Two vectors beside a quaternion are taken for a force and a torque; whether they are the weight
    of one thing its attitudes say.
    """
    found: list[dict[str, ColumnGuess]] = []
    for column in file.columns:
        axis = re.fullmatch(r"([xyzw])(?:\.\d+)?", column.column.strip().lower())
        if axis is None or column.values is None:
            continue
        if not found or axis[1] in found[-1] or axis[1] == "x":
            found.append({})
        found[-1][axis[1]] = column
    turned = [own for own in found if set(own) == set("xyzw")]
    felt = [own for own in found if set(own) == set("xyz")]
    if len(turned) != 1 or len(felt) < len(found) - 1 or file.of("force"):
        return {}
    if len(felt) > len("ft") and (at := found.index(turned[0])) > 0:
        felt = [own for own in felt if own is not found[at - 1]]  # of a pose the place is first
    if len(felt) != len("ft"):
        return {}
    four = np.column_stack([numbers_of(turned[0][a]) for a in "xyzw"])
    if not np.allclose(np.linalg.norm(four, axis=1), 1.0, atol=1e-3):
        return {}
    for own in felt:  # of an inertial unit one is as long as gravity
        size = np.linalg.norm(np.column_stack([numbers_of(own[a]) for a in "xyz"]), axis=1)
        if np.mean(np.abs(size - GRAVITY_MPS2) < _GRAVITY_WITHIN * GRAVITY_MPS2) > _NEARLY_ALL:
            return {}
    made = {
        c.column: replace(c, name=NameGuess("quaternion", a), unit=None, sure="likely",
                          why="x, y, z and w of length one")
        for a, c in turned[0].items()
    }  # fmt: skip
    for letter, own in zip("ft", felt, strict=True):
        why = f"the {'first' if letter == 'f' else 'second'} x, y, z of two without a name"
        for a, c in own.items():
            name = NameGuess("force", letter + a)
            made[c.column] = replace(c, name=name, sure="guess", why=why)
    return made


def _pose(columns: Sequence[ColumnGuess]) -> dict[str, ColumnGuess]:
    """Three numbers of an attitude behind three coordinates, as arms report their flange."""
    turns = [c for c in columns[-3:] if c.values is not None]
    if len(turns) < 3 or any(float(np.nanmax(np.abs(numbers_of(c)))) > 360.0 for c in turns):
        return {}
    made = {}
    for axis, column in zip(("rx", "ry", "rz"), turns, strict=True):
        name = replace(column.name, quantity="angle", axis=axis, owner="pose", side="", place="")
        made[column.column] = replace(
            column, name=name, sure="guess", why="the last three numbers of a pose"
        )
    for column in columns[:-3]:
        made[column.column] = column.as_quantity("other", "guess", "where a pose is")
    return made


def _matrix(columns: Sequence[ColumnGuess]) -> dict[str, ColumnGuess]:
    """A rotation matrix of nine numbers, or within a pose of sixteen; which way by the last row."""
    values = np.column_stack([numbers_of(c) for c in columns])
    size = 3 if len(columns) == 9 else 4
    blocks = values.reshape(-1, len(columns) // size, size)
    by_columns = False
    if len(columns) == _ROWS_OF_A_POSE * size:
        turned = values.reshape(-1, size, _ROWS_OF_A_POSE).transpose(0, 2, 1)
        by_columns = _skew(turned) < _skew(blocks)
        blocks = turned if by_columns else blocks
        if _skew(blocks) > _ORTHONORMAL:
            return {}
    elif size == 4:
        bottom, right = blocks[:, 3, :3], blocks[:, :3, 3]
        by_columns = bool(np.allclose(right, 0.0) and not np.allclose(bottom, 0.0))
        if not by_columns and not np.allclose(bottom, 0.0):
            return {}
    rotations = nearest_rotations(blocks[:: max(len(blocks) // 200, 1), :3, :3])
    if np.isnan(rotations).all(axis=(1, 2)).mean() > 0.2:
        return {}
    made = {}
    for at, column in enumerate(columns):
        i, j = _place(at, len(columns) // size if by_columns else size, by_columns)
        said = "column by column" if by_columns else "row by row"
        inside = max(i, j) <= 3
        name = replace(
            column.name, quantity="matrix" if inside else "other", axis=f"{i}{j}" if inside else "",
            side="", place="", owner="pose",
        )  # fmt: skip
        made[column.column] = replace(
            column, name=name, sure="guess", why=f"a rotation matrix, {said}"
        )
    return made


def _skew(blocks: FloatArray) -> float:
    """How far the left of blocks (n, 3, 4) is from a rotation, as a median."""
    rotation = blocks[:, :3, :3]
    product = rotation @ np.swapaxes(rotation, 1, 2)
    return float(np.nanmedian(np.abs(product - np.eye(3)).max(axis=(1, 2))))


def _place(at: int, size: int, by_columns: bool) -> tuple[int, int]:
    row, column = divmod(at, size)
    return (column + 1, row + 1) if by_columns else (row + 1, column + 1)
