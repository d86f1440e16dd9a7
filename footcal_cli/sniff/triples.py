"""Columns that are the axes of one thing by their names: vectors, quaternions, angles of a frame.

Room: sniff; asked by bodies.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import nearest_rotations, rotations_logged, rotations_of_rpy
from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.names import common_start
from footcal_cli.sniff.vocabulary import ANGLES

_LETTER = re.compile(r"[xyzw](?![A-Za-z])", re.IGNORECASE)
_BRACKETED = re.compile(r"(?P<stem>.+?)[ _.]?(?:\[(?P<at>\d)\]|\((?P<or>\d)\))")
_BARE = re.compile(r"(?P<stem>.+)_(?P<at>[0-3])(?P<or>)")
_COM_BARE = re.compile(r"(?i)(?:.*[\W_])?com(?:[\W_]?(?:pos|m)\w*)?_[23]")
"""``CoM_1``: where the CoM is numbered so, other vectors of the body are."""
_NUMBER = re.compile(r"(\d+)(?=\D*$)")
_ANGLE = re.compile("|".join(sorted(ANGLES, key=len, reverse=True)), re.IGNORECASE)
_WORD = re.compile(r"[^\W\d_]+")
_TURN = re.compile(r"(?i)\br(?:ot)?[_ ]?\{?([xyz])\}?\s*\(\s*([^\W\d_]+)\s*\)")
"""A factor of a rotation: ``Rz(yaw)``, ``rot_z(gier)``, ``R_z(ψ)``."""
_TURNS = re.compile(r"(?i)(?:^|[\W_])(r|rot|rotation|ang|angle|theta|euler|rpy|giro|o?rient)_?$")
_ABOUT = re.compile(
    r"(?i)^(?P<before>(?:.*[\W_.])?)(?P<turn>rot|rotation|tilt|turn|incl\w*?|neig\w*|kipp\w*|dreh\w*|"
    r"n[aá]klon\w*|klop\w*|nato[cč]\w*|oto[cč]\w*|obr[oó]t\w*|pochyl\w*|kierto\w*|kallist\w*|"
    r"lutning\w*|vridning\w*|kantel\w*|draai\w*|gir[oa]\w*|e[gğ]im\w*|d[oö]n[uü][sş]\w*|"
    r"наклон\w*|поворот\w*)_?(?P<axis>[xyz])(?P<after>(?:[\W_].*)?)$"
)
"""A tilt or a turn about an axis, in words of several languages: ``klopeni_x``, ``natoceni_z``."""
_PART = re.compile(r"(?<![^\W_])[^\W\d_]{2,5}(?![^\W_])")
"""A word between signs that may be short for another."""
_UNIT_NORM = 0.02
_PIECE = 2
"""So many letters two names share by chance."""
ROLL_PITCH_YAW = ("roll", "pitch", "yaw")
MATRIX = tuple(f"{i}{j}" for i in "123" for j in "123")
_TWO = re.compile(r"([0-3])[_,]?([0-3])(?=\D*$)")


@dataclass(frozen=True)
class Axes:
    """Columns of one thing.

    Parameters
    ----------
    before, after
        What stands before and after the axis in their names.
    columns
        Axis -> column.
    why
        Why an axis is which, where their names do not say it.
    """

    before: str
    after: str
    columns: Mapping[str, ColumnGuess]
    why: str = ""

    def values(self, axes: Sequence[str]) -> FloatArray:
        """Numbers of some axes, shape (n, k); zeros of one that is not logged."""
        known = [None if a not in self.columns else self.columns[a].values for a in axes]
        rows = next((v.size for v in known if v is not None), 0)
        return np.column_stack([np.zeros(rows) if v is None else v for v in known])


def axes_of(columns: Sequence[ColumnGuess]) -> list[Axes]:
    """Columns by what their names share around a letter x, y, z or w: ``lf_px``, ``com.x``."""
    found = _around_letters(columns) | _in_brackets(columns)
    whole = [Axes(*key, own) for key, own in found.items() if {"x", "y", "z"} <= own.keys()]
    used = set[str]()
    kept = []
    for axes in sorted(whole, key=lambda a: -len(a.columns)):
        names = {c.column for c in axes.columns.values()}
        if not names & used:
            kept.append(axes)
            used |= names
    return [axes for axes in whole if axes in kept]


def flat_axes_of(columns: Sequence[ColumnGuess]) -> list[Axes]:
    """Columns by what their names share around a letter x or y, where none has a z."""
    found = _around_letters(columns).items()
    return [Axes(*key, own) for key, own in found if own.keys() == {"x", "y"}]


def _around_letters(
    columns: Sequence[ColumnGuess],
) -> dict[tuple[str, str], dict[str, ColumnGuess]]:
    """What stands before and after a letter of an axis -> the column of each letter."""
    found: dict[tuple[str, str], dict[str, ColumnGuess]] = {}
    for column in columns:
        for letter in _LETTER.finditer(column.column):
            key = column.column[: letter.start()], column.column[letter.end() :]
            found.setdefault(key, {}).setdefault(letter[0].lower(), column)
    return found


def _in_brackets(columns: Sequence[ColumnGuess]) -> dict[tuple[str, str], dict[str, ColumnGuess]]:
    """Three numbers of a vector by their place in it: ``pcom[0]`` … ``pcom[2]``; ``CoM_1``."""
    stems: dict[str, dict[int, ColumnGuess]] = {}
    ends: dict[str, str] = {}
    bare = any(_COM_BARE.fullmatch(column.column) for column in columns)
    for column in columns:
        at = _BRACKETED.fullmatch(column.column) or (bare and _BARE.fullmatch(column.column))
        if at and not column.counts:
            stems.setdefault(at["stem"], {})[int(at["at"] or at["or"])] = column
            ends[at["stem"]] = "_" if at.re is _BARE else "["
    return {
        (f"{stem}{ends[stem]}", "]"): dict(zip("xyz", (own[i] for i in sorted(own)), strict=True))
        for stem, own in stems.items() if sorted(own) in ([0, 1, 2], [1, 2, 3])
    }  # fmt: skip


def quaternions(columns: Sequence[ColumnGuess], vectors: Sequence[Axes]) -> list[Axes]:
    """Four columns of one thing whose squares add up to 1: x y z w, or numbered with w first."""
    found = [axes for axes in vectors if "w" in axes.columns]
    numbers: dict[tuple[str, str], dict[str, ColumnGuess]] = {}
    for column in columns:
        if at := _NUMBER.search(column.column):
            key = column.column[: at.start()], column.column[at.end() :]
            numbers.setdefault(key, {})[at[1]] = column
    for key, own in numbers.items():
        four = dict(zip("0123", (own[i] for i in sorted(own)), strict=False))
        if own.keys() not in ({*"0123"}, {*"1234"}):  # nine are a matrix, of which four say nothing
            continue
        if of_length_one(Axes(*key, four).values("0123")):
            found.append(Axes(*key, upright(four)))
    return [axes for axes in found if of_length_one(axes.values("xyzw"))]


def upright(own: Mapping[str, ColumnGuess]) -> dict[str, ColumnGuess]:
    """Numbered components as w x y z or x y z w: soles point up."""
    orders = (dict(zip(order, (own[i] for i in "0123"), strict=True)) for order in ("wxyz", "xyzw"))
    return max(orders, key=lambda o: float(np.nanmedian(
        rotations_logged(Axes("", "", o).values("xyzw"))[:, 2, 2])))  # fmt: skip


def of_length_one(four: FloatArray) -> bool:
    """Whether four numbers, shape (n, 4), are of length one in most rows."""
    size = np.linalg.norm(four[np.isfinite(four).all(axis=1)], axis=1)
    return bool(size.size) and float(np.median(np.abs(size - 1.0))) < _UNIT_NORM


def matrices(columns: Sequence[ColumnGuess], *, by_columns: bool = False) -> list[Axes]:
    """Nine columns of one thing that are a rotation matrix: ``r11`` … ``r33``, ``R_00`` … ``R_22``.

    Their keys are ``11`` … ``33``, row by row. Of ``R[0]`` … ``R[8]`` nothing in the numbers says
    whether rows or columns follow each other: a sole is nearly level either way.
    """
    found: dict[tuple[str, str], dict[str, ColumnGuess]] = {}
    for column in columns:
        if at := _TWO.search(column.column):
            key = column.column[: at.start()], column.column[at.end() :]
            found.setdefault(key, {})[at[1] + at[2]] = column
    made = _in_one_row(columns, by_columns=by_columns)
    for key, own in found.items():
        first = "0" if "00" in own else "1"
        wanted = [f"{int(first) + i}{int(first) + j}" for i in range(3) for j in range(3)]
        if own.keys() == {*wanted}:
            made.append(Axes(*key, {m: own[n] for m, n in zip(MATRIX, wanted, strict=True)}))
    return [axes for axes in made if is_rotation(axes)]


def _in_one_row(columns: Sequence[ColumnGuess], *, by_columns: bool) -> list[Axes]:
    """Rotation matrices numbered 0 to 8 or 1 to 9, rows or columns one after the other."""
    found: dict[tuple[str, str], dict[int, ColumnGuess]] = {}
    for column in columns:
        if at := _NUMBER.search(column.column):
            key = column.column[: at.start()], column.column[at.end() :]
            found.setdefault(key, {})[int(at[1])] = column
    order = [f"{j}{i}" for i in "123" for j in "123"] if by_columns else MATRIX
    made = [
        Axes(*key, dict(zip(order, (own[n] for n in sorted(own)), strict=True)))
        for key, own in found.items() if sorted(own) in ([*range(9)], [*range(1, 10)])
    ]  # fmt: skip
    return [axes for axes in made if is_rotation(axes)]


def is_rotation(axes: Axes) -> bool:
    """Whether nine columns are rotation matrices in all rows that are whole."""
    nine = _three_by_three(axes)
    good = np.isfinite(nine).all(axis=(1, 2))
    return bool(good.any() and np.isfinite(nearest_rotations(nine[good])).all())


def _three_by_three(axes: Axes) -> FloatArray:
    return axes.values(MATRIX).reshape(-1, 3, 3)


def angles(columns: Sequence[ColumnGuess], above: Sequence[str] = ()) -> list[Axes]:
    """Columns called roll, pitch and yaw, or yaw alone, by what their names share around it.

    So are ``sole_rx sole_ry sole_rz`` where none of them is more than a turn, and columns called
    as a formula `above` the table has it.
    """
    found: dict[tuple[str, str], dict[str, ColumnGuess]] = {}
    called = ANGLES | in_a_formula(above)
    for column in columns:
        for word in (*_WORD.finditer(column.column), *_ANGLE.finditer(column.column)):
            key = column.column[: word.start()], column.column[word.end() :]
            if word[0].lower() in called:
                found.setdefault(key, {}).setdefault(called[word[0].lower()], column)
    for key, own in (*_shortened(columns).items(), *_about_axes(columns).items()):
        found.setdefault(key, own)
    made = [Axes(*key, own) for key, own in found.items() if "yaw" in own]
    names = {column.column for column in columns}
    for axes in axes_of(columns):
        turns = _TURNS.search(axes.before)
        if turns is None or "w" in axes.columns or not at_most_a_turn(axes):
            continue
        left = axes.before[: turns.start(1)] + "l" + axes.before[turns.end(1) :]
        if turns[1].lower() == "r" and any(name.lower().startswith(left.lower()) for name in names):
            continue  # what is called l and r is left and right
        own = dict(zip(ROLL_PITCH_YAW, (axes.columns[a] for a in "xyz"), strict=True))
        made.append(Axes(axes.before, axes.after, own))
    return made


def in_a_formula(above: Sequence[str]) -> dict[str, str]:
    """What the angles of a rotation about z, the turned y and the turned x are called, -> which.

    >>> in_a_formula(["R = Rz(gier) Ry(stamp) Rx(rol), foot to world"])
    {'gier': 'yaw', 'stamp': 'pitch', 'rol': 'roll'}
    """
    for line in above:
        turns = [found.groups() for found in _TURN.finditer(line)]
        if [axis.lower() for axis, _ in turns] == [*"zyx"]:
            return dict(zip((word.lower() for _, word in turns), ROLL_PITCH_YAW[::-1], strict=True))
    return {}


def _shortened(columns: Sequence[ColumnGuess]) -> dict[tuple[str, str], dict[str, ColumnGuess]]:
    """Three angles of one frame by the beginnings of their words: ``pe_rol pe_arf pe_gui``."""
    found: dict[tuple[str, str], dict[str, ColumnGuess]] = {}
    for column in columns:
        for part in _PART.finditer(column.column):
            axes = {a for word, a in ANGLES.items() if word.startswith(part[0].lower())}
            if len(axes) == 1:
                key = column.column[: part.start()], column.column[part.end() :]
                found.setdefault(key, {}).setdefault(axes.pop(), column)
    return {key: own for key, own in found.items() if own.keys() == {*ROLL_PITCH_YAW}}


def _about_axes(columns: Sequence[ColumnGuess]) -> dict[tuple[str, str], dict[str, ColumnGuess]]:
    """Tilts about x and y and a turn about z, which may have words of their own."""
    found: dict[tuple[str, str], dict[str, ColumnGuess]] = {}
    for column in columns:
        if at := _ABOUT.fullmatch(column.column):
            own = found.setdefault((at["before"], at["after"]), {})
            own.setdefault(at["axis"].lower(), column)
    return {
        key: dict(zip(ROLL_PITCH_YAW, (own[axis] for axis in "xyz"), strict=True))
        for key, own in found.items()
        if own.keys() == set("xyz") and at_most_a_turn(Axes(*key, own))
    }


def at_most_a_turn(axes: Axes) -> bool:
    """Whether three numbers are no more than a turn, in rad by their unit, else in degrees."""
    unit = axes.columns["x"].unit
    most = float(np.nanmax(np.abs(axes.values("xyz")), initial=0.0))
    return unit in (None, "rad", "deg") and most <= (2.0 * np.pi if unit == "rad" else 360.0)


def frames_of(places: Sequence[Axes], turned: Sequence[Axes]) -> dict[int, Axes]:
    """Foot -> its orientation: the names begin alike, or share most, more than of all feet."""
    alike = len(common_start([place.before for place in places]))
    found = {}
    same = [[axes for axes in turned if axes.before == place.before] for place in places]
    for i, place in enumerate(places):
        if same[i] and [other.before for other in places].count(place.before) == 1:
            found[i] = next((axes for axes in same[i] if "w" in axes.columns), same[i][0])
            continue
        shared = [(len(common_start([place.before, axes.before])), axes) for axes in turned]
        most = max((n for n, _ in shared), default=0)
        own = [axes for n, axes in shared if n == most]
        if most > alike or (most and len(places) == 1):
            found[i] = next((axes for axes in own if "w" in axes.columns), own[0])
    return found or by_pieces(places, turned)


def by_pieces(places: Sequence[Axes], turned: Sequence[Axes]) -> dict[int, Axes]:
    """Place -> its orientation by the longest piece of their names, ``p_WLSole`` and ``q_WLSole``.

    It is longer than what the orientation shares with any other place. Empty if one has none.
    """
    found: dict[int, tuple[int, Axes]] = {}
    for axes in turned:
        pieces = [_shared(axes, place) for place in places]
        i = int(np.argmax(pieces))
        if pieces[i] > max(_PIECE, found.get(i, (0, axes))[0]) and pieces.count(pieces[i]) == 1:
            found[i] = pieces[i], axes
    return {i: axes for i, (_, axes) in found.items()} if len(found) == len(places) else {}


def _shared(one: Axes, other: Axes) -> int:
    """Letters of the longest piece of both names."""
    a, b = (f"{axes.before}*{axes.after}".lower() for axes in (one, other))
    return SequenceMatcher(None, a, b, autojunk=False).find_longest_match().size


def rotations(axes: Axes, unit: str = "rad") -> FloatArray:
    """Foot to world of a quaternion, a matrix or ``Rz(yaw) Ry(pitch) Rx(roll)``, (n, 3, 3)."""
    if "11" in axes.columns:
        return nearest_rotations(_three_by_three(axes))
    if "w" in axes.columns:
        return rotations_logged(axes.values("xyzw"))
    rows = len(axes.values(["yaw"]))
    three = [
        axes.values([a])[:, 0] if a in axes.columns else np.zeros(rows) for a in ROLL_PITCH_YAW
    ]
    return rotations_of_rpy(np.stack(three, axis=1) * (np.pi / 180.0 if unit == "deg" else 1.0))
