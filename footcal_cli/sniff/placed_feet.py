"""Placements of both feet, a file for each: the files' names say the foot.

Room: sniff; asked by several and robot_files.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from footcal_cli.sniff.cells import WHERE
from footcal_cli.sniff.file_loads import Names
from footcal_cli.sniff.file_names import Part, called
from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.names import common_start, name_guess
from footcal_cli.sniff.placed import channels_of, where_cells
from footcal_cli.sniff.plan import Entry, LogPlan
from footcal_cli.sniff.units import split_unit

_TWO_LEGS = {"fl": "left", "fr": "right"}
"""What lf and rf are, where there are two feet."""


def by_foot(part: Part) -> Part:
    """Placements whose files are called after feet, each of its foot; any other part as it is."""
    plan, foot = part.plan, part.plan.entries.get("foot")
    if plan.role != "placements" or foot is None or foot.value is None or len(part.paths) < 2:
        return part
    names = Names.of(called(part.paths))
    sides = {word: name_guess(re.sub(r"[\W_]+", "_", word)).side for word in names.middle}
    if not all(sides.values()) or len({*sides.values()}) < 2:
        return part
    feet = tuple(dict.fromkeys(sides.values()))
    cells = tuple(name.removesuffix("_counts") for name in plan.read)
    entry = Entry(file_name=names.expression, names=sides, why="the files' names")
    blanks = tuple(where_cells(feet, cells) if b.why == WHERE else b for b in plan.blanks)
    entries = {**plan.entries, "foot": entry}
    made = replace(plan, entries=entries, channels=channels_of(feet, cells), blanks=blanks)
    return replace(part, plan=made)


def feet_of(plan: LogPlan) -> tuple[str, ...]:
    """The feet of placements; empty for all other logs."""
    if plan.role != "placements":
        return ()
    return tuple(dict.fromkeys(channel.partition("_")[0] for channel in plan.channels))


def of_several_feet(
    plan: LogPlan, feet: Sequence[str], cells: Mapping[str, ColumnGuess]
) -> dict[str, str]:
    """Channels of weights, a foot and a cell each, -> cells of feet: ``hidari_toe``, ``left_toe``.

    Empty unless every channel is one of its own.

    Parameters
    ----------
    feet
        As the placements name them.
    cells
        Cell within its foot -> the placements' column of it.
    """
    called = {_plain(word): cell for cell, c in cells.items() for word in (cell, c.column)}
    found = {}
    for channel in plan.channels:
        for parted in re.finditer(r"[\W_]+", channel):
            foot, rest = channel[: parted.start()], channel[parted.end() :]
            side = next((f for f in feet if f == foot.lower()), "")
            side = side or name_guess(foot).address
            side = (
                side if side in feet else name_guess(f"foot_{foot}").side or _TWO_LEGS.get(side, "")
            )
            if side in feet and _plain(rest) in called:
                found[channel] = f"{side}_{called[_plain(rest)]}"
                break
    whole = len(found) == len({*found.values()}) == len(plan.channels)
    return found if whole else {}


def on_feet(plan: LogPlan, cells: Mapping[str, ColumnGuess]) -> dict[str, str]:
    """Channels of weights, a foot and a cell each, -> cells of a stream (``prava_PL``).

    Empty unless every channel is one of its own.

    Parameters
    ----------
    cells
        Cell -> its column in the stream.
    """
    parted = {cell: cell.partition("_")[::2] for cell in cells}
    head = common_start([own for _, own in parted.values()]) if parted else ""
    head = head[: head.rfind("_") + 1]  # f_pl, f_pp: forces of pl and pp
    within = {own.removeprefix(head): cells[cell] for cell, (_, own) in parted.items()}
    feet = list(dict.fromkeys(foot for foot, _ in parted.values()))
    named = of_several_feet(plan, feet, within)
    found = {n: f"{foot}_{head}{own}" for n, (foot, _, own) in
             ((n, cell.partition("_")) for n, cell in named.items())}  # fmt: skip
    return found if {*found.values()} <= {*cells} else {}


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", "", split_unit(name)[0]).lower()
