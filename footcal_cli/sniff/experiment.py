"""Which experiment a log is of: decided by which quantities stand beside each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.cells import UNNAMED, cells_in_time, said_to_be_cells, toml_key
from footcal_cli.sniff.feet_weighed import (
    beside_a_weight,
    in_kilograms,
    in_said_unit,
    on_a_plate,
)
from footcal_cli.sniff.felt_places import felt_places, less_zeros
from footcal_cli.sniff.groups import channel_names, readings, wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, codes_of, numbers_of, seconds_of
from footcal_cli.sniff.holds import blank_loads, said_loads, typed_loads
from footcal_cli.sniff.levers import with_levers
from footcal_cli.sniff.loads import belongs_to, loads_and_cells, share_the_load
from footcal_cli.sniff.meant_load import meant
from footcal_cli.sniff.motion import without_motion
from footcal_cli.sniff.names import ADDED, STATISTICS, NameGuess, name_guess, words_of
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.placed import at_holes, by_one_weight
from footcal_cli.sniff.plan import (
    Entry,
    LogPlan,
    extras,
    of,
    reading_entry,
    times,
)
from footcal_cli.sniff.plates import force_and_cop
from footcal_cli.sniff.six_axis import transducers
from footcal_cli.sniff.ways import with_ways
from footcal_cli.sniff.weights import (
    known_wrench,
    loads_across,
    runs_across,
    weights,
)

_AXES = 6
_TURNS = 0.5
"""In a table of one row per cell the next row is mostly of another."""


def plan_of(file: FileGuess) -> LogPlan | None:
    """The plan for one log, None where its columns fit no experiment."""
    file = less_zeros(file)
    file = in_said_unit(beside_a_weight(in_kilograms(with_levers(without_motion(numbered(file))))))
    six = wrenches(file)
    loads, cells = loads_and_cells(file)
    plate = on_a_plate(file, readings(file))
    if plate is not None:
        return plate
    holes: Mapping[str, ColumnGuess] = {c.name.axis: c for c in file.of("hole")}
    cops = {c.name.axis: c for c in file.of("cop")}
    if {"x", "y"} <= set(holes) and {"x", "y"} <= set(cops):
        return _cop_points(file, holes, cops)
    put = loads or [c for c in file.of("load") if c.values is not None]  # one weight everywhere
    if put and not six and not {"x", "y"} <= set(holes):
        felt = felt_places(file, put[0])
        holes, cells = felt or (holes, cells)
    if put and not six and (placed := at_holes(file, holes, put[0], cells)) is not None:
        return placed
    if not six and not file.of("com") and (not put or (not cells and len(put) > 1)):
        # a unit of mass behind a short name is called a load: of several they are readings
        read = [c for c in cells or put if c not in holes.values()]
        if (placed := by_one_weight(file, holes, read)) is not None:
            return placed
    hips = six and len({word for c in file.of("label") for word in c.words}) > 1
    plates = None if holes or (loads and cells) or hips else force_and_cop(file)
    if plates is not None:
        return plates
    rig = known_wrench(file, six)
    if rig is not None:
        return rig
    if why_not(file) is not None and not (six and not _a_matrix(file)):
        return None
    if six and _read_once(file):
        return None
    if six:
        return transducers(file, six)
    runs = runs_across(file, loads)
    if runs is not None and all(STATISTICS & {*words_of(c.column)} for c in cells):
        return runs
    if loads and cells:
        one = meant(loads, cells)
        plan = _as_typed(file, one.loads, cells) or weights(file, one.loads, cells)
        return with_ways(one.said_in(_once(plan, one.loads)))
    across = loads_across(file)
    if across is not None:
        return across
    if len(cells) == 1:
        return _unloaded(file, cells[0])
    if cells:
        return cells_in_time(file, cells)
    return None


def _read_once(file: FileGuess) -> tuple[str, ...]:
    """What the rows are called where each is another thing, and nothing says when or how turned."""
    if file.of("time", "quaternion", "angle", "matrix", "gravity", "acceleration", "orientation"):
        return ()
    words = [c.words for c in file.columns if c.words]
    return next((own for own in words if 1 < len(own) == file.rows), ())


def _once(plan: LogPlan, loads: list[ColumnGuess]) -> LogPlan:
    """A plan that says which columns are its load again."""
    entries = [*plan.entries.values(), *(e for own in plan.wide.values() for e in own.values())]
    used = {e.column.column for e in entries if e.column is not None}
    spare = [c.column for c in loads[1:] if c.column not in used]
    if not spare or len(spare) == len(loads):
        return plan
    said = f"{', '.join(spare)}: taken for {loads[0].column} once more, not added to it"
    return replace(plan, warnings=(*plan.warnings, said))


def why_not(file: FileGuess) -> tuple[str, str] | None:
    """Why a log that is understood cannot be used as it is, and what to do; None otherwise."""
    if _a_matrix(file):
        return (
            "six rows of six numbers without names: the matrix of a transducer, which is a "
            "calibration already",
            "give the log of its readings: under known loads, or of a tool in a dozen directions",
        )
    once = _read_once(file)
    if once and wrenches(numbered(file)):
        return (
            f"one row for each of {', '.join(once[:3])} …, without stamps or an attitude: results "
            "of a calibration or of tests, no readings",
            "give the log that they were worked out of: fx … tz of each sample, in a dozen "
            "attitudes; a calibration of footcal goes to --parameters",
        )
    axes = {c.name.axis for c in file.of("force")}
    cops = {c.name.axis for c in file.of("cop")}
    if {"x", "y"} <= cops and not axes and not loads_and_cells(file)[1] and not file.of("hole"):
        return (
            "a centre of pressure without the force that it belongs to",
            "log the vertical force of the plate too (fz), or the readings of its cells; to check "
            "a plate, the known points that were pressed (hole_x_m, hole_y_m)",
        )
    if {"x", "y"} <= {c.name.axis for c in file.of("hole")} and {"fz", "tx", "ty"} <= axes:
        return (
            "known points on a plate, and the force and moments that it reported",
            "add its CoP as cop_x_m = -My / Fz and cop_y_m = Mx / Fz (less what Fx and Fy do at "
            "the depth of its surface): offline-fit compares that with hole_x_m and hole_y_m",
        )
    feet = next((c.words for c in file.of("label") if len(c.words) > 1), ())
    if feet and {"fx", "fy", "fz"} <= axes and not {"tx", "ty", "tz"} & axes:
        columns = ", ".join(f"{foot}_fz" for foot in feet[:2])
        return (
            f"forces along three axes of {len(feet)} feet, one row per foot",
            f"write one row per stamp, a column of vertical force for each foot ({columns}, …)",
        )
    attitude = {c.quantity for c in file.columns} & {"quaternion", "angle", "matrix", "gravity"}
    if not feet and attitude and {"fx", "fy", "fz"} <= axes and not {"tx", "ty", "tz"} & axes:
        return (
            "the three forces of a sensor that is turned, without its torques",
            "log the torques too (tx, ty, tz): hang-calib fits offsets, weight and CoM from all "
            "six axes together",
        )
    dead = [c.column for c in file.of("force") if c.name.axis == "fz" and not np.any(c.values)]
    if {"fx", "fy"} <= axes and dead and not {"tx", "ty", "tz"} & axes:
        return (
            f"forces along three axes, of which the vertical one, {dead[0]}, is 0 in every row",
            f"check that {dead[0]} is connected and refreshed; for a calibration log known loads "
            "next to the axis that they pull on (load_n), or all six axes and the attitude",
        )
    loads, cells = loads_and_cells(file)
    added = next((c for c in loads if ADDED & set(words_of(c.column)) and not c.summed), None)
    if added is not None:
        return (
            f"{added.column}: by its name what was added at each step, not what lay on the sensor",
            "give the total load in each row (load_kg), or call the column so if it is the total",
        )
    sided = next(
        (c for c in file.of("label") if {name_guess(w).side for w in c.words} == {"left", "right"}),
        None,
    )
    if sided is not None and len(cells) > 1 and not loads:
        return (
            f"rows of two feet in one table ({sided.column}), each at stamps of its own",
            "write a file for each foot (left.csv, right.csv), or one row per stamp with a column "
            "for each cell of each foot",
        )
    apart = _one_row_per_cell(file, cells)
    if not loads and apart:
        return (
            f"readings of {len(apart)} cells below each other, one row per cell and stamp",
            "write one row per stamp, a column for each cell "
            f"({', '.join(f'{name}_counts' for name in apart[:3])}, …), or known loads in a column",
        )
    scaled = belongs_to(file, loads, cells)
    if scaled is not None:
        one = loads[0].column
        return (
            f"the readings follow {one} times {scaled.column}, not {one} alone: a torque, if that "
            "is the length of a lever",
            f"a lever: keep to one length of it; a gain or a supply: divide the readings by "
            f"{scaled.column}, or give a channel to each of its settings",
        )
    if loads and len(cells) > 1 and share_the_load(loads, cells):
        first = toml_key(next(iter(channel_names(cells))))
        return (
            f"{len(cells)} cells whose readings add up to the known load: they share it, and no "
            "column says how much each carried",
            f"give each its own load ({first}_load_n, …), load them one by one, or put the weight "
            "on known points (hole_x_m, hole_y_m)",
        )
    return None


def _a_matrix(file: FileGuess) -> bool:
    """Whether a log is the matrix of a six-axis transducer."""
    numbers = [c for c in file.columns if c.values is not None]
    plain = all(c.column.startswith("column_") for c in file.columns)
    return plain and len(numbers) == len(file.columns) == file.rows == _AXES


def _one_row_per_cell(file: FileGuess, cells: list[ColumnGuess]) -> list[str]:
    """Names of cells whose readings take turns in one column; empty where they do not."""
    labels = [c for c in file.of("label", "placement") if c.codes is not None and len(c.words) > 1]
    if len(cells) != 1 or not labels:
        return []
    codes = np.column_stack([codes_of(c) for c in labels])
    changes = np.any(np.diff(codes, axis=0) != 0, axis=1)
    different = np.unique(codes, axis=0)
    if changes.mean() < _TURNS or len(different) < 2 or codes.min() < 0:
        return []
    return ["_".join(c.words[i] for c, i in zip(labels, row, strict=True)) for row in different]


def _as_typed(
    file: FileGuess, loads: Sequence[ColumnGuess], cells: Sequence[ColumnGuess]
) -> LogPlan | None:
    """One cell and weights that were typed at some moment of each hold; None where holds are not.

    What was typed holds until the next text, but the weight lay there before.
    """
    load = loads[0]
    if len(loads) != 1 or len(cells) != 1 or not load.held or load.codes is None:
        return None
    label = replace(load, values=None, words=tuple(load.names), name=NameGuess("label"))
    typed = replace(file, columns=tuple(label if c.column == load.column else c
                                        for c in file.columns))  # fmt: skip
    plan = _unloaded(typed, cells[0])
    return plan if plan.ready and plan.options else None


def _unloaded(file: FileGuess, cell: ColumnGuess) -> LogPlan:
    """One cell alone, with no load beside it."""
    time, rate, blanks = times(file, needed=True)
    name = next(iter(channel_names([cell])))
    name = name if name not in ("counts", "reading", "value", "cell_1") else "cell"
    entries = {**time, f"{name}_counts": reading_entry(cell), **extras(file)}
    entries.pop("repeat", None)
    seconds = np.arange(file.rows) / (rate or 100.0)
    if time and (stamped := seconds_of(file.of("time")[0])) is not None:
        seconds = stamped - stamped[0]
    if loads := said_loads(seconds, numbers_of(cell), file.text.above):
        return LogPlan(
            file, "one cell alone, weights put on it one after another",
            "loads listed above the table, as many as holds", "likely",
            "offline-fit", "weights_stream", entries, (name,), rate_hz=rate,
            options=loads, blanks=tuple(blanks),
        )  # fmt: skip
    for column in file.of("other", "label"):
        if column.codes is None or not 0 < np.sum(column.codes >= 0) < file.rows:
            continue
        typed = [
            (float(seconds[i]), column.words[column.codes[i]])
            for i in np.flatnonzero(column.codes >= 0)
        ]
        if loads := typed_loads(seconds, numbers_of(cell), typed):
            return LogPlan(
                file, "one cell alone, weights put on it one after another",
                f"what was typed in {column.column} at each hold", "likely",
                "offline-fit", "weights_stream", entries, (name,), rate_hz=rate,
                options=loads,
                blanks=tuple(blanks),
            )  # fmt: skip
    doubt = () if said_to_be_cells(cell) else (UNNAMED,)
    return LogPlan(
        file, "one cell alone, without a load", "one column of readings",
        "guess" if doubt else "likely",
        "offline-fit", "weights_stream", entries, (name,), rate_hz=rate,
        blanks=(*doubt, blank_loads(seconds, numbers_of(cell), stamped=bool(time)), *blanks),
    )  # fmt: skip


def _cop_points(
    file: FileGuess, holes: Mapping[str, ColumnGuess], cops: Mapping[str, ColumnGuess]
) -> LogPlan:
    names = file.of("placement", "label", "orientation", "sequence")
    entries = {
        "placement": of(names[0]) if names else Entry(value="point", why="no name of the points"),
        **{f"hole_{a}_m": of(holes[a], holes[a].unit or "m") for a in "xy"},
        **{f"cop_{a}_m": of(cops[a], cops[a].unit or "m") for a in "xy"},
    }
    return LogPlan(
        file, "known points and the CoP that an instrument reported",
        "positions of points and a CoP", "likely", "offline-fit", "cop_points", entries,
    )  # fmt: skip
