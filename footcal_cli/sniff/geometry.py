"""A sheet that says where the cells of a log sit: a name, x and y in each row.

Room: sniff; asked by several.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from footcal_cli.sniff.cells import WHERE, toml_key
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.guesses import FileGuess, numbers_of
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.plan import Blank, Plan

_TO_M = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254}
_LARGEST_M = 0.5
"""No foot is longer; places without a unit that lie further out are in mm."""


def with_places(
    parts: Sequence[Part], others: Sequence[FileGuess]
) -> tuple[list[Part], list[FileGuess]]:
    """Plans whose cells' places a sheet says, and the logs that fit nothing then."""
    left = []
    for sheet in others:
        places = _places(sheet)
        made = [replace(part, plan=_placed(part.plan, places, sheet)) for part in parts]
        if all(new.plan is old.plan for new, old in zip(made, parts, strict=True)):
            left.append(sheet)
        parts = made
    return list(parts), left


def _places(sheet: FileGuess) -> dict[str, tuple[float, float]]:
    """Names of a sheet's rows -> x and y in m; empty where it is no such sheet."""
    named = [c for c in sheet.columns if c.codes is not None and len(c.words) == sheet.rows]
    at = {
        axis: [c for c in sheet.columns
               if c.values is not None and c.column.lower().split("_")[0].strip("[( ") == axis]
        for axis in "xy"
    }  # fmt: skip
    if not named or any(len(columns) != 1 for columns in at.values()):
        return {}
    places = []
    for axis in "xy":
        column = at[axis][0]
        values = numbers_of(column)
        unit = column.unit or ("m" if abs(values).max() < _LARGEST_M else "mm")
        places.append(values * _TO_M.get(unit, 1.0))
    return dict(zip(named[0].words, zip(*(p.tolist() for p in places), strict=True), strict=True))


def _placed(plan: Plan, places: dict[str, tuple[float, float]], sheet: FileGuess) -> Plan:
    """A plan with the places of all its cells; as it is where the sheet does not say them all."""
    asked = next((blank for blank in plan.blanks if blank.why == WHERE), None)
    if asked is None or not places:
        return plan
    by_address = {name_guess(name).address or name: at for name, at in places.items()}
    feet: dict[str, list[str]] = {}
    for channel in plan.channels:
        column = plan.entries[f"{channel}_counts"].column
        own = "" if column is None else column.column
        at = places.get(own) or places.get(channel) or by_address.get(channel)
        if at is None:
            return plan
        foot, _, cell = channel.partition("_")
        line = f"{toml_key(cell)} = {{ x_m = {at[0]:.5g}, y_m = {at[1]:.5g} }}"
        feet.setdefault(foot, []).append(f"{line}    # likely: {sheet.path.name}")
    tables = tuple("\n".join([f"[robot.feet.{f}.cells]", *lines]) for f, lines in feet.items())
    blanks: tuple[Blank, ...] = tuple(blank for blank in plan.blanks if blank is not asked)
    return replace(plan, robot=(*plan.robot, *tables), blanks=blanks)
