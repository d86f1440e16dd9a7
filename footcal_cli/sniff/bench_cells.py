"""The cells of a bench and of a stream: one name, and one unit, for both.

Room: sniff; asked by robot_files.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.plan import FORCES, IN_NEWTON, Entry, LogPlan
from footcal_cli.sniff.same_names import ends_alike, holds_name, is_word_of, same_of_a_foot


def cells_of(plan: LogPlan) -> dict[str, ColumnGuess]:
    """Cell -> its column in a stream; empty for all other logs."""
    return {
        name.removesuffix("_counts"): entry.column
        for name, entry in plan.entries.items()
        if plan.role == "cells" and name.endswith("_counts") and entry.column is not None
    }


def column_of(plan: LogPlan, channel: str) -> str:
    """The column that holds a channel's readings, where each has its own."""
    read = plan.wide.get(channel, {}).get("counts")
    return read.column.column if read is not None and read.column is not None else channel


def named_as(plan: LogPlan, cells: Mapping[str, ColumnGuess]) -> dict[str, str]:
    """Channels of weights -> the cells of a stream whose names are alike, each with one of its own.

    As words of theirs: ``PI`` is ``PI_conteggi``. Else at their ends: ``L_FL`` is ``adc_L_FL``,
    ``i1`` is ``lc_i1``, ``lectura_izq_1`` is ``izq_1_kg``. Else anywhere: ``left_foot/cell1`` is
    ``/left_foot/cell1/force/z``, ``toe_l`` is ``toe_l_cnt``. Else by their foot and number.
    """
    names = {cell: column.column for cell, column in cells.items()}
    for alike in (is_word_of, ends_alike, holds_name, same_of_a_foot):
        found = {}
        for channel in plan.channels:
            words = {channel, column_of(plan, channel)}
            same = [cell for cell in cells if cell == channel]
            own = same or [
                cell for cell, name in names.items() if any(alike(name, word) for word in words)
            ]
            if len(own) == 1:
                found[channel] = own[0]
        if len(found) == len({*found.values()}) == len(plan.channels):
            return found
    return {}


def in_a_row(plan: LogPlan, cells: Mapping[str, ColumnGuess]) -> dict[str, str]:
    """Channels of weights -> a stream's numbered cells, in their order on each foot.

    ``left_foot/toe``, ``left_foot/heel`` are ``force[0]``, ``force[1]`` of the left foot. Empty
    where the cells are not numbered, or a foot has not as many in both.
    """
    streamed = {c: c.rpartition("_")[::2] for c in cells}
    if not all(number.isdigit() for _, number in streamed.values()):
        return {}
    sides = {channel: name_guess(channel).side for channel in plan.channels}
    found: dict[str, str] = {}
    for side in dict.fromkeys(sides.values()):
        ours = [channel for channel, own in sides.items() if own == side]
        theirs = sorted((c for c, (foot, _) in streamed.items() if foot == side),
                        key=lambda c: int(streamed[c][1]))  # fmt: skip
        if len(ours) != len(theirs):
            return {}
        found |= dict(zip(ours, theirs, strict=True))
    return found if len(found) == len(streamed) else {}


def in_one_unit(parts: list[Part]) -> list[Part]:
    """Readings of a cell on a bench and in a stream as they stand where one of both has no unit.

    The bench says how many newtons one of its numbers is; a stream in kg would be weighed twice.
    """
    units: dict[str, set[str | None]] = {}
    for part in parts:
        for channel, entry in _read(part.plan):
            units.setdefault(channel, set()).add(entry.unit)
    bare = {
        channel for channel, said in units.items()
        if None in said and said - {None} and said - {None} <= {*FORCES}
    }  # fmt: skip
    return [
        replace(part, plan=_as_it_stands(part.plan, bare))
        if any(c in bare for c, _ in _read(part.plan)) else part for part in parts
    ]  # fmt: skip


def _read(plan: LogPlan) -> list[tuple[str, Entry]]:
    """Readings of a plan by channel."""
    found = [(n.removesuffix("_counts"), e) for n, e in plan.entries.items() if n != "counts"
             and n.endswith("_counts")]  # fmt: skip
    found += [(channel, own["counts"]) for channel, own in plan.wide.items() if "counts" in own]
    if "counts" in plan.entries:
        found += [(channel, plan.entries["counts"]) for channel in plan.channels]
    return found


def _as_it_stands(plan: LogPlan, channels: set[str]) -> LogPlan:
    """A plan with readings whose unit is left out."""
    why = "as it stands: its weights say what one of it is"
    entries = {
        name: replace(e, unit=None, why=why)
        if name.removesuffix("_counts") in channels or name == "counts" else e
        for name, e in plan.entries.items()
    }  # fmt: skip
    wide = {
        channel: {name: replace(e, unit=None) if name == "counts" else e for name, e in own.items()}
        for channel, own in plan.wide.items()
    }
    robot = tuple(table for table in plan.robot if table != IN_NEWTON)
    return replace(plan, entries=entries, wide=wide, robot=robot)
