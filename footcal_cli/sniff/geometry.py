"""A sheet that says where the cells or the hips of a log sit: a name, x, y (and z) in each row.

Room: sniff; asked by several.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.cells import WHERE, toml_key
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.groups import slug
from footcal_cli.sniff.guesses import FileGuess, numbers_of
from footcal_cli.sniff.hole_sheets import texts_of
from footcal_cli.sniff.listed_places import names_of_rows
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.plan import Blank, LogPlan
from footcal_cli.sniff.same_names import is_word_of, plainly
from footcal_cli.sniff.six_axis import UNPLACED, WHERE_LEGS
from footcal_cli.sniff.units import metres_per, split_unit

_LARGEST_M = 2.0
"""No robot is longer; places without a unit that lie further out are in mm."""
_LARGEST_FOOT_M = 0.5
_AXIS = re.compile(r"[_. ][fv]?[xyz]$", re.IGNORECASE)
_INDEX, _LAST = re.compile(r"(?:\D*[\W_])?(\d+)\]?"), re.compile(r"(\d+)\]?$")
"""Of a list in a text, and of the column of one of its numbers: ``[0]``, ``left/force[0]``.

All cells of a foot are listed: numbers of holes are more.
"""
_Places = Mapping[str, tuple[float, ...]]


def with_places(
    parts: Sequence[Part], others: Sequence[FileGuess]
) -> tuple[list[Part], list[FileGuess]]:
    """Plans whose cells' or legs' places a sheet says, and the logs that fit nothing then."""
    left = []
    for sheet in others:
        flat, deep = _places(sheet, "xy", _LARGEST_FOOT_M), _places(sheet, "xyz", _LARGEST_M)
        made = [
            replace(part, plan=_with_legs(_placed(part.plan, flat, sheet), deep, sheet))
            for part in parts
        ]
        if all(new.plan is old.plan for new, old in zip(made, parts, strict=True)):
            left.append(sheet)
        parts = made
    return list(parts), left


def says_places(sheet: FileGuess) -> bool:
    """Whether a table is a list of places and holds nothing but these."""
    return bool(_places(sheet, "xy", _LARGEST_FOOT_M)) and not sheet.of("load", "time", "reading")


def _places(sheet: FileGuess, axes: str, largest_m: float) -> _Places:
    """Names of a sheet's rows -> x, y (and z) in m; empty where it is no such sheet."""
    at = {
        axis: [c for c in sheet.columns
               if c.values is not None and re.split(r"[\W_]", c.column.lower())[0] == axis]
        for axis in axes
    }  # fmt: skip
    if any(len(columns) != 1 for columns in at.values()):
        return {}
    columns = [at[axis][0] for axis in axes]
    others = [c for c in sheet.columns if c not in columns]
    whole = (c.words for c in others if c.codes is not None and len(c.words) == sheet.rows)
    names = next(whole, ()) or names_of_rows([own for c in others if (own := texts_of(c))])
    if not names:
        return {}
    far = max(float(abs(numbers_of(c)).max()) for c in columns)
    guess = "m" if far < largest_m else "mm"
    places = [numbers_of(c) * metres_per(c.unit or guess) for c in columns]
    return dict(zip(names, map(tuple, np.column_stack(places).tolist()), strict=True))


def _with_legs(plan: LogPlan, places: _Places, sheet: FileGuess) -> LogPlan:
    """A plan with the places of all its legs; as it is where the sheet does not say them all."""
    if not places or not any(UNPLACED in table for table in plan.robot):
        return plan
    said = {name.lower(): at for name, at in places.items()}
    by_address = {name_guess(name).address: at for name, at in places.items()}
    tables = []
    for table in plan.robot:
        if UNPLACED in table:
            leg = table.partition("]")[0].removeprefix("[robot.legs.").strip('"')
            at = said.get(leg.lower()) or by_address.get(name_guess(leg).address)
            if at is None:
                return plan
            numbers = ", ".join(f"{v:.5g}" for v in at)
            placed = f"position_m = [{numbers}]    # likely: {sheet.path.name}"
            table = table.replace(UNPLACED, placed)
        tables.append(table)
    blanks = tuple(blank for blank in plan.blanks if blank.why != WHERE_LEGS)
    return replace(plan, robot=tuple(tables), blanks=blanks)


def _placed(plan: LogPlan, places: _Places, sheet: FileGuess) -> LogPlan:
    """A plan with the places of all its cells; as it is where the sheet does not say them all."""
    asked = next((blank for blank in plan.blanks if blank.why == WHERE), None)
    if asked is None or not places:
        return plan
    by_address = {name_guess(name).address or name: at for name, at in places.items()}
    by_channel = {slug(name): at for name, at in places.items()}
    holes = plan.entries.get("hole_x_m")  # one sheet may place cells and holes
    called = {n: at for n, at in places.items() if holes is None or n not in holes.names}
    by_index = {(name_guess(n).side, int(f[1])): at
                for n, at in called.items() if (f := _INDEX.fullmatch(n))}  # fmt: skip
    of_feet = Counter(channel.partition("_")[0] for channel in plan.channels)
    said = Counter(side for side, _ in by_index)
    listed = len(by_index) == len(places) and all(
        count == said.get(foot, said[""]) for foot, count in of_feet.items()
    )
    feet: dict[str, list[str]] = {}
    first = _first_index(plan) if listed else 0
    for channel in plan.channels:
        # cells of placements are called within their foot
        names = (f"{channel}_counts", f"{channel.partition('_')[2]}_counts")
        read = next((plan.read[name] for name in names if name in plan.read), None)
        own = "" if read is None or read.column is None else read.column.column
        at = places.get(own) or by_channel.get(channel) or by_address.get(channel)
        foot, _, cell = channel.partition("_")
        at = at or _within(own, called) or {n.lower(): at for n, at in called.items()}.get(cell)
        if at is None and listed and (f := _LAST.search(split_unit(own)[0])):
            number = int(f[1]) - first + min(index for _, index in by_index)
            at = by_index.get((foot, number), by_index.get(("", number)))
        if at is None:
            return plan
        line = f"{toml_key(cell)} = {{ x_m = {at[0]:.5g}, y_m = {at[1]:.5g} }}"
        feet.setdefault(foot, []).append(f"{line}    # likely: {sheet.path.name}")
    tables = tuple("\n".join([f"[robot.feet.{f}.cells]", *lines]) for f, lines in feet.items())
    blanks: tuple[Blank, ...] = tuple(blank for blank in plan.blanks if blank is not asked)
    return replace(plan, robot=(*plan.robot, *tables), blanks=blanks)


def _first_index(plan: LogPlan) -> int:
    """The number that the columns of cells begin with: 0 in arrays, 1 by hand."""
    names = (e.column.column for e in plan.read.values() if e.column is not None)
    found = [int(f[1]) for name in names if (f := _LAST.search(split_unit(name)[0]))]
    return min(found, default=0)


def _within(column: str, places: _Places) -> tuple[float, ...] | None:
    """The place of the one name that a column's holds or ends with: ``K1187`` of ``F_K1187_N``.

    Letters of an axis may follow: ``toe_lat`` of ``LC_toe_lat_vz``.
    """
    bare = split_unit(column)[0]
    called = {n: at for n, at in places.items() if re.search(r"[^\W\d_]", n)}
    words = [at for n, at in called.items() if is_word_of(bare, n)]
    own = tuple(plainly(x) for x in (bare, _AXIS.sub("", bare)))
    ends = [at for n, at in called.items() if any(x.endswith(plainly(n)) for x in own)]
    return next((found[0] for found in (words, ends) if len(found) == 1), None)
