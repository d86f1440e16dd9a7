"""Files of one robot: weights on its cells, a walk on them, and the body's own stream."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np

from footcal_cli.sniff.bench_cells import cells_of, column_of, in_a_row, in_one_unit, named_as
from footcal_cli.sniff.cells import NAMEPLATE, WEIGHTS, cells_in_time
from footcal_cli.sniff.file_loads import escaped
from footcal_cli.sniff.file_names import Beside, Part
from footcal_cli.sniff.foot_mounts import Mount
from footcal_cli.sniff.foot_poses import with_foot_poses
from footcal_cli.sniff.groups import without_unit
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.lifted import carries_nothing
from footcal_cli.sniff.motion import body_entries, upright, walks
from footcal_cli.sniff.placed_feet import feet_of, of_several_feet, on_feet
from footcal_cli.sniff.plan import Entry, LogPlan
from footcal_cli.sniff.protocol import seconds_by
from footcal_cli.sniff.six_axis_feet import MOTION, as_mounted
from footcal_cli.sniff.still_feet import on_still_feet
from footcal_cli.sniff.units import VOLTAGES
from footcal_cli.sniff.which_cell import named_alike
from footcal_cli.tables.units import TIMES

_DATE = re.compile(
    r"\b\d{4}-\d\d-\d\d[T ]\d\d:\d\d(?::\d\d(?:\.\d{1,6})?)?(?:Z|[+-]\d\d:?\d\d)?(?!\d)"
)


def with_body(
    plan: LogPlan, body: FileGuess, at_rows: Mapping[str, Entry] | None = None,
    mount: Mount | None = None, beside: tuple[Beside, ...] = (),
) -> list[Part]:  # fmt: skip
    """Sensors and the robot's own stream, which may say how the sensors are turned.

    Parameters
    ----------
    at_rows
        The stream at the rows of the sensors.
    """
    plan = as_mounted(plan.moving or plan, mount)
    feet = plan.feet or tuple(dict.fromkeys(c.partition("_")[0] for c in plan.channels))
    motion = body_entries(body, on_cells=not plan.feet)
    still = on_still_feet(motion, feet, plan.entries, at_rows or {})
    entries = still.entries
    if plan.role == "cells" and {"rl_foot_x_m", "rr_foot_x_m"} <= set(entries):
        named = [e.column for n, e in plan.entries.items() if n.endswith("_counts")]
        plan = cells_in_time(plan.file, [c for c in named if c is not None], legs=True)
    command = "online-replay" if walks(entries) else "static-init"
    plan = _on_the_clock_of(plan, body)
    other = LogPlan(
        body, "the robot's own stream: CoM and feet", "its centre of mass", "likely",
        command, "body", entries, robot=upright(body, entries),
    )  # fmt: skip
    blanks = (*(blank for blank in plan.blanks if blank != MOTION), *still.blanks)
    kind = f"{plan.kind}; with a body stream"
    sensors = replace(plan, command=command, kind=kind, blanks=blanks)
    return [
        Part(sensors, (plan.file.path,), escaped(plan.file.path.name), beside),
        Part(other, (body.path,), escaped(body.path.name), _joined(body)),
    ]


def _on_the_clock_of(plan: LogPlan, body: FileGuess) -> LogPlan:
    """Sensors whose stamps count from a date that the notes say, next to a body with dates."""
    entry, clock = plan.entries.get("time_s"), body.of("time")
    if entry is None or entry.column is None or not clock or clock[0].stamps is None:
        return plan
    dates = seconds_by(body, clock[0])
    unit = TIMES.get(entry.unit or "s", 1.0)
    at = entry.column.values
    if at is None or not np.isfinite(dates).any() or np.nanmax(at) * unit > np.nanmin(dates):
        return plan
    for line in plan.file.text.above:
        for said in _DATE.finditer(line):
            when = datetime.fromisoformat(said[0].replace("Z", "+00:00").replace(" ", "T"))
            start = when.replace(tzinfo=when.tzinfo or UTC).timestamp()
            ours = np.array([np.nanmin(at), np.nanmax(at)]) * unit + start
            if ours[0] <= np.nanmax(dates) and ours[1] >= np.nanmin(dates):
                moved = replace(entry.column, add=start / unit)
                why = f"{entry.why}; it counts from {said[0]}, as the notes say"
                made = replace(entry, column=moved, why=why, sure="likely")
                return replace(plan, entries={**plan.entries, "time_s": made})
    said_so = (
        f"the stamps of {plan.file.path.name} and {body.path.name} share no moment: write in "
        "[columns] what is to be added to time_s (add = …, in its unit)"
    )
    return replace(plan, warnings=(*plan.warnings, said_so))


def _joined(body: FileGuess) -> tuple[Beside, ...]:
    why = "the body's stream goes on there"
    return tuple(Beside(file, "time", why=why) for file in body.joined)


def with_bodies(
    parts: Sequence[Part], others: Sequence[FileGuess]
) -> tuple[list[Part], list[FileGuess]]:
    """Bodies' streams and poses of feet, which fit no experiment alone, next to what lacks them."""
    return with_foot_poses(*_with_stream(parts, others))


def _with_stream(
    parts: Sequence[Part], others: Sequence[FileGuess]
) -> tuple[list[Part], list[FileGuess]]:
    """The one body's stream that fits no experiment alone, next to the one log that lacks it."""
    bodies = [file for file in others if file.of("com")]
    alone = [p for p in parts if p.plan.command == "static-init" and len(p.paths) == 1]
    files = [p.plan.file for p in alone]
    alone = [p for p in alone if not any(carries_nothing(p.plan.file, file) for file in files)]
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
    columns: dict[str, ColumnGuess] = {}
    for part in parts:
        if part.plan.role != "weights":
            foot = part.plan.entries.get("foot")
            before = f"{foot.value}_" if foot is not None and foot.value else ""
            for name, entry in part.plan.read.items():
                if entry.column is not None:
                    cell = before + name.removesuffix("_counts")
                    cells[entry.column.column] = cells[without_unit(entry.column.column)] = cell
                    columns.setdefault(entry.column.column, entry.column)
    feet = [foot for part in parts for foot in feet_of(part.plan)]
    within = {
        name.removesuffix("_counts"): e.column for part in parts if feet_of(part.plan)
        for name, e in part.plan.read.items() if e.column
    }  # fmt: skip
    streamed = {name: column for part in parts for name, column in cells_of(part.plan).items()}
    renamed = [
        replace(p, plan=_ordered(_renamed(
            p.plan, named_as(p.plan, streamed) or of_several_feet(p.plan, feet, within)
            or on_feet(p.plan, streamed) or cells,
            [*columns.values()],
        ), streamed)) for p in parts
    ]  # fmt: skip
    if len({*feet}) == 1:  # by what is alike in their names, where none is the same
        of_foot = {f"{feet[0]}_{cell}": column for cell, column in within.items()}
        renamed = [
            p if p.plan.role != "weights" or {*p.plan.channels} & {*of_foot} else
            replace(p, plan=_renamed(p.plan, named_as(p.plan, of_foot), []))
            for p in renamed
        ]  # fmt: skip
    renamed = in_one_unit(renamed)
    weighed = {c for part in renamed if part.plan.role == "weights" for c in part.plan.channels}
    voltage = _voltage(renamed)
    made = [_in_voltage(_untied(_weighed(p.plan, weighed), streamed), voltage) for p in renamed]
    return [replace(p, plan=plan) for p, plan in zip(renamed, made, strict=True)], list(others)


def _untied(plan: LogPlan, streamed: Mapping[str, ColumnGuess]) -> LogPlan:
    """A bench of which no name says which cells of a stream it weighed: that is said."""
    if plan.role != "weights" or len(plan.channels) < 2 or not streamed:
        return plan
    if {*plan.channels} & {*streamed}:
        return plan
    ours, theirs = (", ".join(list(names)[:3]) for names in (plan.channels, streamed))
    said = (
        f"no name says which of the cells {theirs} … the weights of {ours} … lay on: write "
        "names = { bench = cell } into its channel in [columns]"
    )
    return replace(plan, warnings=(*plan.warnings, said))


def _ordered(plan: LogPlan, streamed: Mapping[str, ColumnGuess]) -> LogPlan:
    """A plan for weights on cells that a stream numbers; as it is where names are one already."""
    row = in_a_row(plan, streamed)
    if plan.role != "weights" or {*plan.channels} & {*streamed} or not row:
        return plan
    pairs = ", ".join(f"{a} is {streamed[b].column}" for a, b in list(row.items())[:2])
    said = f"cells are taken in their order on each foot: {pairs} …"
    return replace(_renamed(plan, row, []), warnings=(*plan.warnings, said))


def _voltage(parts: Sequence[Part]) -> str | None:
    """The one unit of the voltages that logs of weights say; None without."""
    plans = [part.plan for part in parts if part.plan.role == "weights"]
    places = [own for plan in plans for own in (plan.entries, *plan.wide.values())]
    units = {own["counts"].unit for own in places if "counts" in own}
    unit = units.pop() if len(units) == 1 else None
    return unit if unit in VOLTAGES or unit == "mV/V" else None


def _in_voltage(plan: LogPlan, unit: str | None) -> LogPlan:
    """A plan whose readings are no whole counts, in the unit of the weights on the same cells."""
    if unit is None or plan.role == "weights":
        return plan
    why = "a voltage, as under the weights"
    entries = {
        name: replace(entry, unit=unit, sure="guess", why=why)
        if name.endswith("_counts") and entry.unit is None and entry.column is not None
        and not entry.column.counts else entry
        for name, entry in plan.entries.items()
    }  # fmt: skip
    return replace(plan, entries=entries)


def _weighed(plan: LogPlan, weighed: set[str]) -> LogPlan:
    """A plan for cells whose newtons per count the weights of the same log say."""
    if not plan.channels or not set(plan.channels) <= weighed:
        return plan
    kept = tuple(blank for blank in plan.blanks if blank not in (NAMEPLATE, WEIGHTS))
    return replace(plan, blanks=kept)


def _renamed(
    plan: LogPlan, cells: Mapping[str, str], columns: Sequence[ColumnGuess]
) -> LogPlan:  # fmt: skip
    """A plan for weights with the cells' texts under the given names, if each has one."""
    channel = plan.entries.get("channel")
    given = {name: cells.get(column_of(plan, name), cells.get(name)) for name in plan.channels}
    if None in given.values() and plan.role == "weights":
        alike = named_alike(plan.channels, columns)
        given = {name: cells[alike[name].column] if alike else None for name in given}
    renamed = {name: cell for name, cell in given.items() if cell is not None}
    if plan.role != "weights" or len(renamed) < len(given) or all(n == c for n, c in given.items()):
        return plan
    if plan.wide_into == "channel" and set(plan.wide) == set(given):
        wide = {renamed[name]: own for name, own in plan.wide.items()}
        return replace(plan, wide=wide, channels=tuple(renamed.values()))
    if channel is None or (channel.column is None and channel.file_name is None):
        return plan
    words = {name: word for word, name in channel.names.items()}
    names = {words.get(name, name): cell for name, cell in renamed.items()}
    entries = {**plan.entries, "channel": replace(channel, names=names)}
    return replace(plan, entries=entries, channels=tuple(renamed.values()))
