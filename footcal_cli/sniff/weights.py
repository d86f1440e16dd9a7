"""Plans for known weights: a load beside each reading, sheets of them, recordings under a load."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np

from footcal_cli.core.readings import straightness
from footcal_cli.errors import UsageError
from footcal_cli.sniff.bench_of_feet import on_each_foot
from footcal_cli.sniff.body_columns import apart
from footcal_cli.sniff.clocks import recorded
from footcal_cli.sniff.groups import AXES, channel_names, could_be_read, follows
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of, seconds_of
from footcal_cli.sniff.holds import short_holds
from footcal_cli.sniff.names import PUT, words_of
from footcal_cli.sniff.one_cell import in_one_row, one_cell, without_their_mean
from footcal_cli.sniff.plan import (
    FORCES,
    Blank,
    Entry,
    LogPlan,
    extras,
    load_entry,
    of,
    pieces_under,
    reading_entry,
    times,
)
from footcal_cli.sniff.pressed import pressed_along
from footcal_cli.sniff.read_again import read_again
from footcal_cli.sniff.tokens import with_unit
from footcal_cli.sniff.units import known_unit, split_unit
from footcal_cli.sniff.which_cell import (
    ON_WHICH,
    cell_column,
    followers,
    loaded_cell,
    loaded_words,
    named_alike,
    not_used,
    one_cell_moves,
)
from footcal_cli.tables.reading import READ_AGAIN
from footcal_cli.tables.units import conversion

_MANY = 10
"""Different loads under which a reading of two values measures none."""
_FOLLOWS, _IDLE = 0.9, 0.2
"""How much of its variance a load explains: of a cell that carries it, and of one that does not."""
_FEWEST_PARTS, _WHOLE = 2.0, 1e-6
"""Units that are written beside each other, pounds and ounces: so many parts, a whole number."""
_BY_ITSELF = (
    "taken that every cell carried the whole load by itself; if the load stood on all of them, "
    "give each its share"
)
_STRAIGHT = 0.98  # share of a reading's variance that the load on a cell explains at least


def weights(
    file: FileGuess, loads: list[ColumnGuess], cells: list[ColumnGuess],
    named: Mapping[str, ColumnGuess] | None = None,
) -> LogPlan:  # fmt: skip
    """The plan for known loads and readings in one table.

    Parameters
    ----------
    file
        The log.
    loads, cells
        Its columns of known loads and of readings.
    named
        Readings by the name of their channel, where some of a table were left out.
    """
    load, unused = loads[0], None
    entry, asked = load_entry(load)
    labels = [c for c in file.of("label") if len(c.words) > 0]
    time, _, _ = times(file, needed=False)
    entries = {"load_n": entry, **time, **extras(file)}
    one_name = next(iter(named)) if named else "cell"
    named = dict(named or channel_names(cells))
    if (wrench := _axes_of(loads)) and len(cells) >= len(AXES):
        return _known_wrench(file, wrench, named, time)
    if len(loads) == len(cells) > 1:
        pairs = dict(zip(named, loads, strict=True))
        if _one_proportion(loads):
            return _each_its_load(file, named, pairs, time)
        entries = {f"{n}_load_n": of(c, c.unit or "N") for n, c in pairs.items()}
        entries |= {f"{n}_counts": reading_entry(c) for n, c in named.items()}
        return LogPlan(
            file, "several cells loaded at once, each with its own known load",
            "as many loads as readings", "likely", "offline-fit", "weights_together",
            entries, tuple(named),
        )  # fmt: skip
    if len(cells) > 1 and (on_which := loaded_cell(file, load, cells)) is not None:
        labels = [on_which, *labels]
        cells = [c for c in cells if c.column != on_which.column]
    if labels and len(cells) > 1:
        on = _one_at_a_time(file, load, labels, cells)
        on = on or read_again(file, load, entries, labels, cells, asked)
        if on is not None:
            return on
        unused, labels = labels[0], []  # of several readings it is not the cell that they tell
    following, idle = pressed_along(load, cells)
    why = "of the axes of one instrument another carries the load"
    if not idle:
        following, idle = follow(load, cells)
        why = "the load does not move it while others follow"
    if still := [c for c in cells if not moves(c)]:
        following, idle, why = [c for c in cells if c not in still], still, "never changes"
    elif still := [c for c in cells if _last_bit(c, load)]:
        following, idle, why = [c for c in cells if c not in still], still, "moves by its last bit"
    if idle and following:
        left = {n: c for n, c in named.items() if c in following}
        kept = weights(file, loads, following, left)
        seconds = {e.column.followed_by for e in kept.entries.values() if e.column is not None}
        spare = ", ".join(c.column for c in idle if c.column not in seconds)
        said = (f"{spare}: left out, {why}",) * bool(spare)
        return replace(kept, warnings=(*kept.warnings, *said))
    if len(cells) == 1 or labels:
        cell = cells[0]
        chosen = cell_column(file, load, cell, labels)
        labels = [chosen] if chosen is not None else []
        channel = of(chosen) if chosen is not None else Entry(value=one_name, why="one cell alone")
        if recorded(file, load) and not labels:
            return _stream(file, {one_name: cell}, entries, asked)
        entries |= {"channel": channel, "counts": reading_entry(cell)}
        entries |= pieces_under(load, [c for c in file.of("label") if c not in labels])
        return LogPlan(
            file, "known weights, one row per reading", "a load next to each reading",
            "likely", "offline-fit", "weights", entries,
            tuple(labels[0].words) if labels else (one_name,), blanks=asked,
        )  # fmt: skip
    if one_cell_moves(load, cells):
        asked = (*asked, ON_WHICH)
    if recorded(file, load):
        return _stream(file, named, entries, asked)
    wide = {name: {"counts": reading_entry(column)} for name, column in named.items()}
    if one_cell(load, cells):
        channel = Entry(value="cell", why="readings without names, all on one line of the load")
        into = READ_AGAIN if in_one_row(load, cells) else "repeat"
        cells = without_their_mean(cells)
        wide = {str(i): {"counts": reading_entry(c)} for i, c in enumerate(cells, 1)}
        return LogPlan(
            file, f"known weights on one cell, {len(cells)} readings in each row", "numbers "
            "without names that agree", "likely", "offline-fit", "weights",
            {**entries, "channel": channel}, ("cell",), wide, into, blanks=asked,
        )  # fmt: skip
    return LogPlan(
        file, f"known weights, the readings of {len(cells)} cells side by side",
        "one load and several readings in a row", "guess", "offline-fit", "weights",
        entries, tuple(named), wide, blanks=asked,
        warnings=() if ON_WHICH in asked else (_BY_ITSELF, *not_used(unused)),
    )  # fmt: skip


def moves(cell: ColumnGuess) -> bool:
    """Whether a reading ever changes."""
    values = numbers_of(cell)
    good = values[np.isfinite(values)]
    return bool(good.size and np.ptp(good) > 0)


def _last_bit(cell: ColumnGuess, load: ColumnGuess) -> bool:
    """Whether a reading knows two values alone under a load of many."""
    read, put = (np.unique(v[np.isfinite(v)]).size for v in map(numbers_of, (cell, load)))
    return read <= 2 and put >= _MANY


def follow(
    load: ColumnGuess, cells: Sequence[ColumnGuess], least: float | None = None
) -> tuple[list[ColumnGuess], list[ColumnGuess]]:
    """Readings that follow a known load, and those that stand still while others follow it.

    Without one that follows, or without any that does not, none is left out; unless `least` says
    how much of each reading's variance the load must explain.
    """
    assert load.values is not None, "known loads are numbers"
    shares = []
    for cell in cells:
        assert cell.values is not None, "readings are numbers"
        if cell.values.size != load.values.size:
            return list(cells), []  # of two files
        shares.append(straightness(load.values, cell.values))
    if least is None and (max(shares) < _FOLLOWS or min(shares) > _IDLE):
        return list(cells), []
    idle = [c for c, share in zip(cells, shares, strict=True) if share <= (least or _IDLE)]
    return [c for c in cells if c not in idle], idle


def added_up(added: ColumnGuess, cells: Sequence[ColumnGuess]) -> ColumnGuess:
    """What was added at each step as its sum, where readings follow that and not the steps."""
    steps = numbers_of(added)
    total = replace(added, values=np.cumsum(steps), summed=True)
    if not np.isfinite(steps).all() or follow(total, cells, _STRAIGHT)[1]:
        return added
    if not follow(added, cells, _STRAIGHT)[1]:
        return added
    return replace(total, sure="likely", why="what was added at each step: the readings follow "
                   "its sum")  # fmt: skip


def in_two_units(loads: list[ColumnGuess]) -> list[ColumnGuess]:
    """Loads of which one is what a larger unit beside it leaves over: pounds and ounces.

    The larger unit is counted in whole numbers, and the smaller number never reaches one of it;
    beside fractions of the larger unit it is a load by itself.
    """
    for whole, rest in permutations(loads, 2):
        parts = _parts_of(whole.unit, rest.unit)
        over = numbers_of(rest)[np.isfinite(numbers_of(rest))]
        counted = numbers_of(whole)[np.isfinite(numbers_of(whole))]
        if parts < _FEWEST_PARTS or abs(parts - round(parts)) > _WHOLE:
            continue
        if np.any(counted != np.round(counted)):
            continue
        if over.size and over.min() >= 0.0 and over.max() < parts:
            values = numbers_of(whole) + np.nan_to_num(numbers_of(rest)) / parts
            plus = {**whole.plus, rest.column: rest.unit or ""}
            both = replace(whole, values=values, plus=plus, why=f"its name, {rest.column} on top")
            return in_two_units([both, *(c for c in loads if c is not whole and c is not rest)])
    return loads


def _parts_of(whole: str | None, part: str | None) -> float:
    """How many of one unit make one of another; 0 where these are no two units of a load."""
    if whole is None or part is None or "count" in (whole, part):
        return 0.0
    try:
        large, small = conversion(whole, "N", 1.0), conversion(part, "N", 1.0)
    except UsageError:
        return 0.0
    return large.slope / small.slope if large.weighed == small.weighed else 0.0


def _one_at_a_time(
    file: FileGuess, load: ColumnGuess, labels: Sequence[ColumnGuess], cells: list[ColumnGuess]
) -> LogPlan | None:
    """A weight that lies on one cell at a time, all of them read: a column names the loaded one."""
    for label, foot in permutations(labels, 2):
        if (both := on_each_foot(file, load, label, foot, cells)) is not None:
            return both
    for label in labels:
        words = loaded_words(load, label)
        on = named_alike(words, cells) or followers(load, label, cells)
        if len(on) != len(words) or len({c.column for c in on.values()}) < 2:
            continue
        entry, asked = load_entry(replace(load, held=load.held or label.held))
        wide = {
            word: {
                "load_n": replace(entry, only_where={label.column: word}),
                "counts": reading_entry(cell),
            }
            for word, cell in on.items()
        }
        return LogPlan(
            file, f"known weights on one of {len(on)} cells at a time, all of them read",
            "a load, the cell it lies on, and several readings in a row", "likely", "offline-fit",
            "weights", {**times(file, needed=False)[0], **extras(file)}, tuple(on), wide,
            blanks=asked,
        )  # fmt: skip
    return None


def _axes_of(loads: Sequence[ColumnGuess]) -> dict[str, ColumnGuess]:
    """Known loads by the axis of a wrench that their names say; empty unless they are all six."""
    found = {}
    for load in loads:
        for letter, axis in re.findall(r"(?<![a-z])([fmt])([xyz])(?![a-z])", load.column.lower()):
            found[("f" if letter == "f" else "t") + axis] = load
    return found if set(found) == set(AXES) and len(loads) == len(AXES) else {}


def known_wrench(file: FileGuess, six: Mapping[str, Mapping[str, ColumnGuess]]) -> LogPlan | None:
    """A rig's wrench, called applied or known, beside gauges or axes that felt it; else None."""
    gauges = [
        c for c in file.of("reading", "unknown")
        if could_be_read(c) and c.unit not in FORCES and moves(c)
    ]  # fmt: skip
    put = [g for g in six.values() if all(PUT & set(words_of(c.column)) for c in g.values())]
    felt = [g for g in six.values() if len(put) == 1 and follows(g, put[0])]
    named = channel_names(gauges)
    if len(felt) == 1 and len(gauges) < len(AXES):  # of a transducer that has axes already
        columns = [felt[0][axis] for axis in AXES]
        named = dict(zip(apart([c.column for c in columns]), columns, strict=True))
    if len(put) != 1 or len(named) < len(AXES):
        return None
    return _known_wrench(file, put[0], named, times(file, needed=False)[0])


def _known_wrench(
    file: FileGuess, wrench: Mapping[str, ColumnGuess], named: Mapping[str, ColumnGuess],
    time: Mapping[str, Entry],
) -> LogPlan:  # fmt: skip
    """A six-axis transducer in a rig: the applied wrench next to its readings."""
    entries = dict(time)
    for axis in AXES:
        unit, name = ("N", "n") if axis[0] == "f" else ("N*m", "nm")
        entries[f"known_{axis}_{name}"] = of(wrench[axis], wrench[axis].unit or unit)
    entries |= {f"{name}_counts": reading_entry(column) for name, column in named.items()}
    return LogPlan(
        file, f"a known wrench on a transducer with {len(named)} readings",
        "six loads along and about axes, and readings", "likely", "offline-fit",
        "weights_together", entries, tuple(named), options=("known_wrench = true",),
    )  # fmt: skip


def _one_proportion(loads: list[ColumnGuess]) -> bool:
    """Whether known loads rise and fall together: no crosstalk can be seen."""
    from footcal_cli.core.bench.matrix import directions

    table = np.column_stack([numbers_of(c) for c in loads])
    return directions(table[np.isfinite(table).all(axis=1)]) < len(loads)


def _each_its_load(
    file: FileGuess, named: dict[str, ColumnGuess], loads: dict[str, ColumnGuess],
    time: dict[str, Entry],
) -> LogPlan:  # fmt: skip
    """Cells that were loaded side by side, each with a load of its own in every row."""
    asked = tuple({blank for c in loads.values() for blank in load_entry(c)[1]})
    wide = {
        name: {"load_n": load_entry(loads[name])[0], "counts": reading_entry(column)}
        for name, column in named.items()
    }
    return LogPlan(
        file, f"known weights on {len(named)} cells, each with its own load in every row",
        "as many loads as readings, all in one proportion", "likely", "offline-fit", "weights",
        {**time, **extras(file)}, tuple(named), wide, blanks=asked,
    )  # fmt: skip


def loads_across(file: FileGuess) -> LogPlan | None:
    """A sheet of cells by weights, the weights in the header: ``cell; 0 kg; 0.5 kg; 1 kg``."""
    loads: dict[str, tuple[float, str]] = {}
    for column in file.columns:
        found = with_unit(column.column.strip())
        unit = known_unit(found[1]) if found else None
        if found and unit in FORCES and column.values is not None:
            loads[column.column] = (float(found[0].replace(",", ".")), unit)
    others = [c for c in file.columns if c.column not in loads]
    labels = [c for c in others if c.words]
    if len(loads) < 2 or len(labels) != 1 or any(c.values is not None for c in others):
        return None
    columns = {c.column: c for c in file.columns}
    wide = {
        name: {
            "load_n": Entry(value=f"{value:g}", unit=unit, why="the header"),
            "counts": reading_entry(replace(columns[name], unit=None)),
        }
        for name, (value, unit) in loads.items()
    }
    return LogPlan(
        file, "known weights, a column of readings for each", "loads in the header", "likely",
        "offline-fit", "weights", {"channel": of(labels[0])}, tuple(labels[0].words), wide,
        "load_n",
    )  # fmt: skip


def runs_across(file: FileGuess, loads: list[ColumnGuess]) -> LogPlan | None:
    """One cell, a column of readings for each run: ``load; run 1; run 2``."""
    runs = {
        found[1]: c for c in file.of("repeat")
        if c.values is not None and (found := re.search(r"(\d+)\W*$", split_unit(c.column)[0]))
        and np.unique(c.values).size > 2
    }  # fmt: skip
    if len(loads) != 1 or len(runs) < 2:
        return None
    entry, asked = load_entry(loads[0])
    wide = {number: {"counts": reading_entry(column)} for number, column in runs.items()}
    channel = Entry(value="cell", why="one cell, a column for each run")
    return LogPlan(
        file, f"known weights on one cell, {len(runs)} runs side by side",
        "a load and numbered runs in a row", "likely", "offline-fit", "weights",
        {"load_n": entry, "channel": channel}, ("cell",), wide, "repeat", blanks=asked,
    )  # fmt: skip


def _stream(
    file: FileGuess, named: dict[str, ColumnGuess], entries: dict[str, Entry],
    asked: tuple[Blank, ...],
) -> LogPlan:  # fmt: skip
    """A recording of one or more cells under a load that is read too."""
    runs = {"session": entries["repeat"]} if "repeat" in entries else {}  # it was taken out then
    kept = ("time_s", "load_n", "temperature_degc", "session")
    entries = {name: entry for name, entry in (runs | entries).items() if name in kept}
    entries |= {f"{name}_counts": reading_entry(column) for name, column in named.items()}
    load, time = (entries[name].column for name in ("load_n", "time_s"))
    options: tuple[str, ...] = ()
    if load is not None and time is not None and (at := seconds_of(time)) is not None:
        options = short_holds(at, numbers_of(load))
    return LogPlan(
        file, "a running recording while the load changes", "time, load and readings", "likely",
        "offline-fit", "weights_stream", entries, tuple(named), blanks=asked, options=options,
        warnings=(_BY_ITSELF,) if len(named) > 1 and ON_WHICH not in asked else (),
    )  # fmt: skip
