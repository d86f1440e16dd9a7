"""Files of one robot: weights on its cells, a walk on them, and the body's own stream."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from footcal_cli.sniff.cells import NAMEPLATE, WEIGHTS, cells_in_time
from footcal_cli.sniff.file_loads import escaped
from footcal_cli.sniff.file_names import Beside, Part
from footcal_cli.sniff.groups import without_unit
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.motion import body_entries, upright, walks
from footcal_cli.sniff.plan import IN_NEWTON, Entry, LogPlan
from footcal_cli.sniff.six_axis_feet import MOTION
from footcal_cli.sniff.still_feet import on_still_feet
from footcal_cli.sniff.units import split_unit


def with_body(
    plan: LogPlan, body: FileGuess, at_rows: Mapping[str, Entry] | None = None, mounting: str = "",
    beside: tuple[Beside, ...] = (),
) -> list[Part]:  # fmt: skip
    """Sensors and the robot's own stream, which may say how the sensors are turned.

    Parameters
    ----------
    at_rows
        The stream at the rows of the sensors.
    """
    plan = plan.moving or plan
    feet = plan.feet or tuple(dict.fromkeys(c.partition("_")[0] for c in plan.channels))
    still = on_still_feet(body_entries(body), feet, plan.entries, at_rows or {})
    entries = still.entries
    if plan.role == "cells" and {"rl_foot_x_m", "rr_foot_x_m"} <= set(entries):
        named = [e.column for n, e in plan.entries.items() if n.endswith("_counts")]
        plan = cells_in_time(plan.file, [c for c in named if c is not None], legs=True)
    command = "online-replay" if walks(entries) else "static-init"
    other = LogPlan(
        body, "the robot's own stream: CoM and feet", "its centre of mass", "likely",
        command, "body", entries, robot=upright(body, entries),
    )  # fmt: skip
    blanks = (*(blank for blank in plan.blanks if blank != MOTION), *still.blanks)
    kind = f"{plan.kind}; with a body stream"
    sensors = replace(
        plan, command=command, kind=kind, blanks=blanks, mounting=mounting or plan.mounting
    )
    return [
        Part(sensors, (plan.file.path,), escaped(plan.file.path.name), beside),
        Part(other, (body.path,), escaped(body.path.name)),
    ]


def with_bodies(
    parts: Sequence[Part], others: Sequence[FileGuess]
) -> tuple[list[Part], list[FileGuess]]:
    """A body's stream that fits no experiment alone, next to the one log that lacks it."""
    bodies = [file for file in others if file.of("com")]
    alone = [p for p in parts if p.plan.command == "static-init" and len(p.paths) == 1]
    if len(bodies) != 1 or len(alone) != 1:
        return list(parts), list(others)
    joined = with_body(alone[0].plan, bodies[0], beside=alone[0].beside)
    kept = [part for part in parts if part is not alone[0]]
    return [*kept, *joined], [file for file in others if file is not bodies[0]]


def with_one_name(
    parts: Sequence[Part], others: Sequence[FileGuess]
) -> tuple[list[Part], list[FileGuess]]:
    """Weights whose cells are called as the columns of a walk or foot, under their names there."""
    cells: dict[str, str] = {}
    for part in parts:
        if part.plan.role != "weights":
            foot = part.plan.entries.get("foot")
            before = f"{foot.value}_" if foot is not None and foot.value else ""
            for name, entry in part.plan.entries.items():
                if name.endswith("_counts") and entry.column is not None:
                    cell = before + name.removesuffix("_counts")
                    cells[entry.column.column] = cells[without_unit(entry.column.column)] = cell
    streamed = {
        name.removesuffix("_counts"): entry.column
        for part in parts if part.plan.role == "cells"
        for name, entry in part.plan.entries.items()
        if name.endswith("_counts") and entry.column is not None
    }  # fmt: skip
    renamed = [
        replace(part, plan=_renamed(part.plan, _alike(part.plan, streamed) or cells))
        for part in parts
    ]
    renamed = _in_one_unit(renamed)
    weighed = {c for part in renamed if part.plan.role == "weights" for c in part.plan.channels}
    return [replace(p, plan=_weighed(p.plan, weighed)) for p in renamed], list(others)


def _alike(plan: LogPlan, cells: Mapping[str, ColumnGuess]) -> dict[str, str]:
    """Channels of weights -> the cells of a stream whose names end alike, each with one of its own.

    ``L_FL`` is ``adc_L_FL``, ``i1`` is ``lc_i1``, ``lectura_izq_1`` is ``izq_1_kg``.
    """
    plain = {cell: _plain(column.column) for cell, column in cells.items()}
    found = {}
    for channel in plan.channels:
        words = {_plain(channel), _plain(_column(plan, channel))}
        same = [cell for cell in cells if cell == channel]
        own = same or [
            cell for cell, name in plain.items()
            if any(name.endswith(word) or word.endswith(name) for word in words)
        ]  # fmt: skip
        if len(own) != 1:
            return {}
        found[channel] = own[0]
    return found if len({*found.values()}) == len(found) else {}


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", "", split_unit(name)[0]).lower()


def _in_one_unit(parts: list[Part]) -> list[Part]:
    """Readings of a cell on a bench and in a stream as they stand where one of both has no unit.

    The bench says how many newtons one of its numbers is; a stream in kg would be weighed twice.
    """
    units: dict[str, set[str | None]] = {}
    for part in parts:
        for channel, entry in _read(part.plan):
            units.setdefault(channel, set()).add(entry.unit)
    bare = {channel for channel, said in units.items() if None in said and len(said) > 1}
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


def _weighed(plan: LogPlan, weighed: set[str]) -> LogPlan:
    """A plan for cells whose newtons per count the weights of the same log say."""
    if not plan.channels or not set(plan.channels) <= weighed:
        return plan
    kept = tuple(blank for blank in plan.blanks if blank not in (NAMEPLATE, WEIGHTS))
    return replace(plan, blanks=kept)


def _renamed(plan: LogPlan, cells: Mapping[str, str]) -> LogPlan:
    """A plan for weights with the cells' texts under the given names, if each has one."""
    channel = plan.entries.get("channel")
    given = {name: cells.get(_column(plan, name), cells.get(name)) for name in plan.channels}
    renamed = {name: cell for name, cell in given.items() if cell is not None}
    if plan.role != "weights" or len(renamed) < len(given) or all(n == c for n, c in given.items()):
        return plan
    if plan.wide_into == "channel" and set(plan.wide) == set(given):
        wide = {renamed[name]: own for name, own in plan.wide.items()}
        return replace(plan, wide=wide, channels=tuple(renamed.values()))
    if channel is None or channel.column is None:
        return plan
    entries = {**plan.entries, "channel": replace(channel, names=renamed)}
    return replace(plan, entries=entries, channels=tuple(renamed.values()))


def _column(plan: LogPlan, channel: str) -> str:
    """The column that holds a channel's readings, where each has its own."""
    read = plan.wide.get(channel, {}).get("counts")
    return read.column.column if read is not None and read.column is not None else channel
