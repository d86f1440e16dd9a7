"""Shaft angles and contacts of legs, next to their transducers.

Room: sniff; called by six_axis, and by several before logs are planned.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.groups import wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.names import Quantity, words_of
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.plan import Entry, of
from footcal_cli.sniff.turning import turning
from footcal_cli.sniff.vocabulary import LEGS

_NUMBERED = re.compile(
    r"(?<![^\W_])(?:q|th|theta|phi|alpha|ang|angle|joint|gelenk|winkel|junta|giunto|articulacion|"
    r"angulo|angolo|θ|φ)[\W_]?\d(?!\d)", re.IGNORECASE,
)  # fmt: skip
"""Joints by their number: ``FL_q1``, ``joint_2``, ``θ1``."""
_CALLED = {"phi", "theta", "alpha", "psi", "beta", "ang", "angle", "joint", "gelenk", "winkel", "q",
           "φ", "θ", "α"}  # fmt: skip
"""How the angle of a leg is called without a number: ``Phi_VL``."""
_TURNS_MOST = "the joint that moves most next to its transducer"
_LARGEST_RAD = 13.0
"""An angle without a unit that goes further than two turns in radians is in degrees."""


def beside(
    file: FileGuess, six: Mapping[str, Mapping[str, ColumnGuess]], *quantities: Quantity
) -> dict[str, ColumnGuess]:
    """The one column of a quantity that belongs to each transducer; empty unless all have one.

    A column belongs to a transducer that its name names, else to the one of the same leg, else to
    the one of the same number.
    """
    columns = _columns(file, quantities)
    for belongs in (_named_after, _of_one_leg, _of_one_number):
        found = {
            name: [c for c in columns if belongs(c, group["fx"])] for name, group in six.items()
        }
        taken = [c.column for there in found.values() for c in there]
        if all(found.values()) and len({*taken}) == len(taken):
            return _moving_most(found)
    return {}


def _named_after(column: ColumnGuess, axis: ColumnGuess) -> bool:
    ours, theirs = column.name, axis.name
    return (ours.side, ours.place) == (theirs.side, theirs.place) and (
        {*theirs.owner.split("_")} <= {*ours.owner.split("_"), ""}
    )


def _of_one_leg(column: ColumnGuess, axis: ColumnGuess) -> bool:
    ours, theirs = column.name, axis.name
    return (ours.side, ours.place) == (theirs.side, theirs.place) != ("", "")


def _of_one_number(column: ColumnGuess, axis: ColumnGuess) -> bool:
    ours, theirs = (re.findall(r"\d+", c.column) for c in (column, axis))
    # behind its plug's number J1_0 has that of its axis
    return bool(ours) and [int(n) for n in ours] == [int(n) for n in theirs[: len(ours)]]


def _moving_most(found: Mapping[str, Sequence[ColumnGuess]]) -> dict[str, ColumnGuess]:
    """One column for each transducer; of several joints in each leg the one that moves most.

    Joints are distinguished by what stands in their names beside the leg's.
    """
    called = {
        name: {_beside_the_others(c, there): c for c in there} for name, there in found.items()
    }
    joints = {*next(iter(called.values()))}
    if any({*own} != joints for own in called.values()):
        return {}
    moved = {
        joint: sum(float(np.nanstd(numbers_of(own[joint]))) for own in called.values())
        for joint in sorted(joints)
    }
    joint = max(moved, key=lambda j: moved[j])
    return {name: own[joint] for name, own in called.items()}


def _beside_the_others(column: ColumnGuess, others: Sequence[ColumnGuess]) -> str:
    """Words of a name that the names of a leg's other joints do not share."""
    words = [{*words_of(c.column)} for c in others if c is not column]
    return " ".join(w for w in words_of(column.column) if not all(w in own for own in words))


def with_shafts(files: Sequence[FileGuess]) -> list[FileGuess]:
    """Logs in which joints of legs (q1, q2, Phi) are known for shafts, or for other joints.

    The joint of each leg that moves most next to its transducer turns the leg; the others are held,
    or move what hangs there. What one log shows holds for all of them.
    """
    found: set[str] = set()
    turned: dict[str, ColumnGuess] = {}
    for file in files:
        six = wrenches(numbered(file))
        if six and not file.of("phase"):
            joints = _joints(file) if len(six) > 1 else set[str]()
            felt = {c.column for axes in six.values() for c in axes.values()}
            free = tuple(c for c in file.columns if c.column not in felt)
            made = replace(file, columns=tuple(_as_shaft(c, joints) for c in free))
            ours = {c.column for c in beside(made, six, "phase").values()}
            if not ours:
                turned |= {c.column: c for c in turning(file, six)}
            found |= ours
    return [
        replace(file, columns=_turned(
            tuple(_known(c, found, _joints(file)) for c in file.columns), turned
        )) for file in files
    ]  # fmt: skip


def _turned(
    columns: tuple[ColumnGuess, ...], turned: Mapping[str, ColumnGuess]
) -> tuple[ColumnGuess, ...]:
    """Columns with those that turn a leg in some log as its shaft's, and no other joint's."""
    if not {c.column for c in columns} & turned.keys():
        return columns
    made = []
    for column in columns:
        if (seen := turned.get(column.column)) is not None and column.values is not None:
            column = replace(
                column, name=seen.name, unit=seen.unit, sure=seen.sure, why=seen.why,
                values=column.values * seen.name.factor,
            )  # fmt: skip
        elif column.quantity == "phase":
            why = "a joint that does not turn the leg while it hangs"
            column = column.as_quantity("other", "likely", why)
        made.append(column)
    return tuple(made)


def _joints(file: FileGuess) -> set[str]:
    """Columns that turn a leg about one axis, ``R1_pitch``: no attitude, which has a roll too.

    The yaw of a foot whose place is known is its heading.
    """
    turns = [c for c in file.of("angle") if c.name.axis in ("roll", "pitch", "yaw")]
    placed = {(c.name.side, c.name.place) for c in file.of("foot_position")}
    turns = [c for c in turns if (c.name.side, c.name.place) not in placed]
    held = {stem: {c.name.axis for c in turns if _stem(c) == stem} for stem in {*map(_stem, turns)}}
    several = sum("roll" not in axes for stem, axes in held.items() if stem) > 1
    return {c.column for c in turns if several and _stem(c) and "roll" not in held[_stem(c)]}


def _stem(column: ColumnGuess) -> str:
    """What a name says beside its angle: the leg."""
    return "_".join(p for p in (column.name.side, column.name.place, column.name.owner) if p)


def _as_shaft(column: ColumnGuess, joints: Collection[str] = ()) -> ColumnGuess:
    """A column of a joint as that of a shaft."""
    if column.column in joints:
        return column.as_quantity("phase", "guess", _TURNS_MOST)
    called = _NUMBERED.search(column.column) or _CALLED & {*words_of(column.column)}
    plain = column.quantity in ("unknown", "quaternion") and column.unit in (None, "rad", "deg")
    joint = column.values is not None and called and plain
    return column.as_quantity("phase", "guess", _TURNS_MOST) if joint else column


def _known(column: ColumnGuess, shafts_of: Collection[str], joints: Collection[str]) -> ColumnGuess:
    """A joint as what the logs of legs show it to be."""
    made = _as_shaft(column, joints)
    if not shafts_of or made is column:
        return column
    if column.column in shafts_of:
        return made
    return column.as_quantity("other", "likely", "a joint that does not turn the whole leg")


def legs_first(labels: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Columns of labels, those before others that are called after legs."""
    return sorted(labels, key=lambda c: not LEGS & {*words_of(c.column)})


def shafts(
    file: FileGuess, six: Mapping[str, Mapping[str, ColumnGuess]]
) -> tuple[Entry | None, dict[str, Entry]]:
    """The shaft angle of every row, and that of each transducer in a wide log."""
    named = _columns(file, ("phase",)) or _columns(file, ("angle",))
    if len(six) == 1 and len(named) > 1:  # the joint that moves the leg, not those that are held
        named = [max(named, key=lambda c: float(np.nanstd(numbers_of(c))))]
    if len(named) == 1:
        return shaft_entry(named[0]), {}
    each = beside(file, six, "phase") or beside(file, six, "angle")
    return None, {name: shaft_entry(column) for name, column in each.items()}


def _columns(file: FileGuess, quantities: tuple[Quantity, ...]) -> list[ColumnGuess]:
    """Columns of numbers; of angles those that are of no attitude."""
    return [
        c for c in file.of(*quantities)
        if c.values is not None and (c.quantity != "angle" or c.name.axis == "angle")
    ]  # fmt: skip


def shaft_entry(column: ColumnGuess) -> Entry:
    """A shaft angle in its unit, or in the one that its size says."""
    if column.unit:
        return of(column, column.unit)
    most = float(np.nanmax(np.abs(numbers_of(column)), initial=0.0))
    return of(column, "deg" if most > _LARGEST_RAD else "rad")
