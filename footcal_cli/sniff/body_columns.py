"""Names of the feet of a body's stream, and its columns taken for what they are.

Room: sniff; asked by bodies and stands.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.guesses import ColumnGuess, Sure
from footcal_cli.sniff.names import NameGuess, Quantity, common_start, name_guess
from footcal_cli.sniff.triples import MATRIX, ROLL_PITCH_YAW, Axes

_HIGHEST_M, _HIGHEST_CM = 5.0, 150.0
"""Higher no CoM lies above the ground on which feet stand, in m and in cm."""
_ROLES = {"com": "com_{}_m", "vel": "com_vel_{}_mps", "acc": "com_acc_{}_mps2",
          "rate": "angmom_rate_{}_nm", "momentum": "angmom_{}_nms"}  # fmt: skip
_QUANTITY: Mapping[str, Quantity] = {"com": "com", "acc": "com_acc"}
_WHY = {
    "com": "above all feet",
    "vel": "follows the CoM's velocity",
    "acc": "follows the CoM's acceleration",
    "rate": "a moment that is zero on average",
    "momentum": "an angular momentum: its rate is taken",
}


def length_unit(height: FloatArray) -> str:
    """The unit of places without one by the heights (n,) of a CoM: 404 is mm, 40 cm, 0.4 m."""
    usual = float(np.nanmedian(np.abs(height)))
    return "mm" if usual > _HIGHEST_CM else "cm" if usual > _HIGHEST_M else "m"


def foot_names(
    stems: Sequence[str], places_m: Sequence[FloatArray], heading_rad: FloatArray | None
) -> list[str]:
    """Left and right, or the names of legs: by words, else by which foot is on whose left.

    Parameters
    ----------
    stems
        What stands before the axis in the names of each foot's place.
    places_m
        Shape (n, 3) each.
    heading_rad
        Of the first foot on the grid; None where it is not known.
    """
    said = [name_guess(f"{stem}x") for stem in stems]
    if len(stems) > 2:
        places = [name.place for name in said]
        if not all(places):  # LFX is no leg by itself
            places = [name_guess(stem.rstrip("_. ")).place for stem in stems]
        if all(places) and len({*places}) == len(stems):
            return places
        different = apart([stem.rstrip("_. ") for stem in stems])
        tokens = [re.sub(r"[\W_]+", "", word).lower() for word in different]
        return tokens if all(tokens) else [f"leg{i + 1}" for i in range(len(stems))]
    sides = [name.side or {"fl": "left", "fr": "right"}.get(name.place, "") for name in said]
    if {*sides} == {"left", "right"}:
        return sides
    line = places_m[1][:, :2] - places_m[0][:, :2]
    if heading_rad is None:  # feet go forward
        middle = (places_m[0] + places_m[1])[:, :2] / 2
        ahead = np.gradient(middle, axis=0)
    else:
        ahead = np.stack([np.cos(heading_rad), np.sin(heading_rad)], axis=1)
    to_the_left = float(np.sum(ahead[:, 0] * line[:, 1] - ahead[:, 1] * line[:, 0]))
    return ["right", "left"] if to_the_left > 0 else ["left", "right"]


def apart(names: Sequence[str]) -> list[str]:
    """What tells names apart: whole words between what all begin and end with."""
    head = common_start(names)
    head = re.sub(r"[^\W\d_]+$", "", head)
    tail = common_start([name[::-1] for name in names])[::-1]
    tail = re.sub(r"^[^\W_]+", "", tail)
    longest = min(map(len, names)) - len(head)
    tail = tail[-longest:] if longest > 0 and tail else ""
    return [name[len(head) : len(name) - len(tail)] for name in names]


def differing_parts(words: Sequence[str]) -> list[str]:
    """The letters in which words differ, between those that all begin and end with."""
    head = len(common_start(words))
    tail = len(common_start([word[head:][::-1] for word in words]))
    return [word[head : len(word) - tail].lower() for word in words]


def of_the_com(roles: Mapping[str, Axes], *, length: str) -> dict[str, ColumnGuess]:
    """Columns of the CoM, of what is derived of it and of the angular momentum."""
    made = {}
    for role, axes in roles.items():
        if role == "vel" and "acc" in roles:
            continue
        for axis, column in axes.columns.items():
            if axis not in "xyz":
                continue
            name = NameGuess(_QUANTITY.get(role, "motion"), axis, owner=_ROLES[role].format(axis))
            by_size = length if role == "com" and length != "m" else None
            unit = column.unit or by_size
            why = _WHY[role] + (f", in {unit} by its size" if unit != column.unit else "")
            made[column.column] = replace(column, name=name, unit=unit, sure="likely", why=why)
    return made


def of_the_feet(
    feet: Sequence[Axes], names: Sequence[str], frames: Mapping[int, Axes],
    units: Mapping[int, tuple[str, str]], *, length: str,
) -> dict[str, ColumnGuess]:  # fmt: skip
    """Columns of the places and the orientations of feet; `units` of angles, and by what."""
    made = {}

    def taken(
        column: ColumnGuess, foot: str, what: str, unit: str | None, why: str,
        sure: Sure = "likely",
    ) -> None:  # fmt: skip
        side = foot if foot in ("left", "right") else ""
        name = NameGuess("motion", side=side, place="" if side else foot,
                         owner=f"{foot}_foot_{what}")  # fmt: skip
        made[column.column] = replace(column, name=name, unit=unit, sure=sure, why=why)

    for i, (foot, name) in enumerate(zip(feet, names, strict=True)):
        for axis, column in ((a, foot.columns[a]) for a in "xyz" if a in foot.columns):
            unit = column.unit or length
            taken(column, name, f"{axis}_m", unit, "it stands, and is higher while it moves")
        if i not in frames:
            continue
        for axis, column in frames[i].columns.items():
            if axis in "xyzw":
                taken(column, name, f"q{axis}", None, "of length one, next to the foot's place")
            elif axis in MATRIX:
                taken(column, name, f"r{axis}", None, "of a rotation, next to the foot's place")
            elif axis in ROLL_PITCH_YAW:
                unit, said = units[i]
                why = "an angle next to the foot's place"
                why += f", {frames[i].why}" if frames[i].why else ""
                why += f", in {unit} by {said}" if said else f"; nothing says that it is in {unit}"
                sure: Sure = "likely" if said and not frames[i].why else "guess"
                taken(column, name, f"{axis}_rad", unit, why, sure)
    return made
