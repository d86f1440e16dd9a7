"""The body's stream of stances by what its numbers are, whatever its CoM is called: ``SP_x``.

Room: sniff; asked by walking. In a stand no column moves as steps do. Two places are named after a
left and a right foot; the CoM is the one other place that lies above their middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.body_columns import (
    differing_parts,
    foot_names,
    length_unit,
    of_the_com,
    of_the_feet,
)
from footcal_cli.sniff.file_loads import by_letters
from footcal_cli.sniff.foot_angles import angle_unit, headings_beside
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, looked_at_joined
from footcal_cli.sniff.motion import body_entries
from footcal_cli.sniff.names import common_start, name_guess
from footcal_cli.sniff.triples import Axes, angles, axes_of, flat_axes_of, frames_of, quaternions
from footcal_cli.sniff.units import LENGTHS
from footcal_cli.sniff.vocabulary import WITH_A_LEG

_SIDES = ({"left", "right"}, {"fl", "fr"})
_CLEARLY = 0.5
_ABOVE, _BESIDE = 0.5, 1.5
"""How far the CoM lies above the feet and beside their middle: widths of the stance."""


def standing(file: FileGuess) -> FileGuess:
    """A log with the CoM and the feet of stances taken for that; as it is where it has none.

    Of several files that are one stream the feet may be named by their files alone.
    """
    if file.of("com") and not file.joined and "left_foot_x_m" in body_entries(file):
        return file
    return looked_at_joined(file, _standing) or file


def _standing(file: FileGuess) -> FileGuess | None:
    could = [c for c in file.columns if _could_be_a_place(c)]
    vectors = [v for v in axes_of(could) if "w" not in v.columns]
    named = [(v, side) for v in vectors if (side := _side(v))] or _by_letters(vectors)
    feet, names = [v for v, _ in named], [side for _, side in named]
    if len(feet) != 2 or {*names} not in _SIDES:
        feet, names = _alike([*vectors, *flat_axes_of(could)], vectors), []
    if len(feet) != 2:
        return None
    places = [v.values("xyz") for v in feet]
    above = [v for v in vectors if v not in feet and _above(v.values("xyz"), *places)]
    if len(above) != 1:
        return None
    columns = [c for c in file.columns if c.values is not None]
    turned = [*quaternions(columns, axes_of(columns)), *angles(columns, file.text.above)]
    frames = frames_of(feet, turned)
    frames = frames or headings_beside(feet, columns)
    units = {
        i: angle_unit(own, np.zeros(file.rows, complex), file.text.above)
        for i, own in frames.items() if "yaw" in own.columns
    }  # fmt: skip
    said = [own for own in units.values() if own[1]]
    if not said and units:
        line = (places[1] - places[0])[:, :2]
        said = [by for own in frames.values() if (by := _across(own.values(["yaw"])[:, 0], line))]
    units = {i: own if own[1] or not said else said[0] for i, own in units.items()}
    length = length_unit(above[0].values("z")[:, 0])
    if {*names} != {"left", "right"}:
        ahead = np.zeros(file.rows)  # feet that stand point along x, unless their yaw says more
        if 0 in frames and "yaw" in frames[0].columns:
            ahead = frames[0].values(["yaw"])[:, 0] * (np.pi / 180 if units[0][0] == "deg" else 1)
        names = foot_names([v.before for v in feet], places, None if names else ahead)
    made = of_the_com({"com": above[0]}, length=length) | of_the_feet(
        feet, names, frames, units, length=length
    )
    why = "two feet with a place above them"
    made = {c: n if n.unit in ("deg", "rad") else replace(n, why=why) for c, n in made.items()}
    return replace(file, columns=tuple(made.get(c.column, c) for c in file.columns))


def _across(yaw: FloatArray, line: FloatArray) -> tuple[str, str] | None:
    """The unit in which a foot's yaw (n,) is across the line to the other one (n, 2), if any is.

    Unless it is a straight one in either.
    """
    along = np.arctan2(line[:, 1], line[:, 0])
    rad, deg = (float(np.nanmean(np.abs(np.cos(a - along)))) for a in (yaw, np.radians(yaw)))
    if min(rad, deg) > _CLEARLY * max(rad, deg):
        return None
    return ("rad" if rad < deg else "deg", "its size: feet stand side by side")


def _alike(vectors: Sequence[Axes], whole: Sequence[Axes]) -> list[Axes]:
    """The one pair of places called alike but for a part, with one other place above its middle."""
    found = []
    for pair in combinations(vectors, 2):
        stems = [v.before for v in pair]
        different = differing_parts(stems)
        if pair[0].after != pair[1].after or not all(different):
            continue
        if len(different[0]) == len(stems[0]) or pair[0].columns.keys() != pair[1].columns.keys():
            continue
        places = [v.values("xyz") for v in pair]
        above = [v for v in whole if v not in pair and _above(v.values("xyz"), *places)]
        if len(above) == 1:
            found.append([*pair])
    return found[0] if len(found) == 1 else []


def _could_be_a_place(column: ColumnGuess) -> bool:
    lengths = column.unit is None or column.unit in LENGTHS
    return column.values is not None and lengths and not column.counts and column.quantity in (
        "unknown", "other", "hole", "placement", "position", "com", "foot_position", "reading"
    )  # fmt: skip


def _side(axes: Axes) -> str:
    name = name_guess(f"{axes.before}x{axes.after}")
    return name.side or name.place or WITH_A_LEG.get(axes.before.strip("_. -").lower(), "")


def _by_letters(vectors: Sequence[Axes]) -> list[tuple[Axes, str]]:
    """The one pair of vectors that differ by the first letter of left and right: ``X_WL_x``."""
    found = []
    for pair in combinations(vectors, 2):
        same = len(common_start([v.before for v in pair]))
        sides = by_letters([v.before[same:] for v in pair])
        if sides and pair[0].after == pair[1].after:
            found.append([*zip(pair, sides, strict=True)])
    return found[0] if len(found) == 1 else []


def _above(com: FloatArray, left: FloatArray, right: FloatArray) -> bool:
    """Whether a place (n, 3) lies above the middle of two feet (n, 3) in most rows of all three."""
    said = np.isfinite(np.hstack([com, left, right])).all(axis=1)
    com, left, right = com[said], left[said], right[said]
    wide = np.linalg.norm((left - right)[:, :2], axis=1)
    way = com - (left + right) / 2
    high, beside = way[:, 2] > _ABOVE * wide, np.linalg.norm(way[:, :2], axis=1) < _BESIDE * wide
    return bool(wide.size and np.median(wide) > 0 and np.mean(high & beside) > 0.9)
