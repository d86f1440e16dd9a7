"""Logs with the same columns: loads, channels and orientations from the names of the files."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.readings import straightness
from footcal_cli.sniff.attitudes import attitude_of, named_orientation
from footcal_cli.sniff.cell_and_load import cell_and_load, load_above
from footcal_cli.sniff.cells_by_files import cells_of_files, files_of_cells, weights_per_channel
from footcal_cli.sniff.clocks import one_after_another
from footcal_cli.sniff.displays import as_reading, displayed, without_display
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import Names, escaped, loads_named, whole_name
from footcal_cli.sniff.groups import readings, slug, wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, as_one, seconds_of
from footcal_cli.sniff.names import NameGuess, name_guess
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.own_offsets import legs_by_offsets
from footcal_cli.sniff.plan import NOT_SAID, UNIT_ASKED, Entry, LogPlan, reading_entry, times
from footcal_cli.sniff.runs_of_cells import cells_and_runs, series_of_cells
from footcal_cli.sniff.six_axis import forces_of, share_a_weight
from footcal_cli.tables.textfiles import called_as

_IDLE, _STRAIGHT = 0.05, 0.95
"""Share of the largest load of an empty plate; share of forces' variance that weights explain."""
_LEAST_ORIENTATIONS = 3
_TWO_LEGS = {"fl": "left", "fr": "right"}
"""Legs of which one has no others."""


@dataclass(frozen=True)
class Beside:
    """A log joined to another: its file, and how."""

    file: FileGuess
    by: str
    offset_s: float = 0.0
    why: str = ""
    how: str = ""
    tolerance_s: float = 0.1
    apart_s: float = 0.0
    only_where: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Part:
    """Logs of one kind: the plan for them, the pattern of their names, what is joined."""

    plan: LogPlan
    paths: tuple[Path, ...]
    match: str
    beside: tuple[Beside, ...] = ()


def called(paths: Sequence[Path]) -> list[str]:
    """What tells logs apart: their names, or their folders' too where all are named alike."""
    names = [path.name for path in paths]
    if len(set(names)) == len(names):
        return names
    return [called_as(path, "/") for path in paths]


def alike_part(group: list[FileGuess]) -> Part | None:
    """Logs with the same columns: sessions, loads, channels or orientations by their names."""
    paths = tuple(file.path for file in group)
    first = group[0]
    plan = plan_of(first)
    if len(group) == 1:
        beside = tuple(Beside(f, "time", why="the walk goes on there") for f in first.joined)
        return None if plan is None else Part(plan, paths, escaped(paths[0].name), beside)
    names = Names.of(called(paths))
    plates = None if names.of_folders else _per_plate(group, names)
    if plates is not None:
        return plates
    six = wrenches(numbered(first))
    if six:
        plan = _turned_in_all(group, plan)
    stated = first.of("load") or first.of("label")
    if loads_named(names) is not None and readings(first) and displayed(group):
        # a display beside the reading: what the files are called after was put on
        made = _per_load([without_display(file) for file in group], names)
        if made is not None:
            return made
    if len(stated) == len(first.of("load")) == 1 and not six and not readings(first):
        # the names say what was put on, the column what the display made of it
        shown = [as_reading(file) for file in group]
        if (made := _per_load(shown, names)) is not None:
            return made
    if len(six) == 1 and not stated:
        hung = names.of_folders or first.of("orientation")  # no foot that stands, then
        of_foot = None if hung else _per_foot(group, names)
        return (
            _per_orientation(group, names) or _per_load(group, names) or of_foot
            or (None if plan is None else Part(_per_leg(group, plan, names), paths, names.match))
        )  # fmt: skip
    if six and not first.of("load") and (legs := _legs_per_orientation(group, names)):
        return legs
    if len(readings(first)) > 1 and not stated and not six:
        both = cell_and_load(group, *names.with_unit)
        if both is not None:
            return Part(both, paths, names.match)
        if (made := _per_foot(group, names)) is not None:
            return made
    if len(readings(first)) == 1:
        if not stated:
            both = cell_and_load(group, *names.with_unit) or load_above(group)
            if both is not None:
                return Part(both, paths, names.match)
        if not stated:
            made = _per_load(group, names)
            addresses = {cell.address for cell in cells_of_files(group, names.middle)}
            alone = names.of_folders or one_after_another(group)
            if made is None and len(addresses) == len(group) and not alone:
                made = _per_channel(group, names)
            if made is not None:
                return made
        elif (
            plan is not None and not first.of("label") and len(set(names.middle)) > 1
            # numbers are loads that were asked for, or runs, but behind a word for cells
            and (names.of_cells or loads_named(names) is None)
            and (names.of_cells or not any(re.fullmatch(r"[\d_-]*", w) for w in names.middle))
        ):  # fmt: skip
            made_of = cells_and_runs(plan, group, names) or weights_per_channel(plan, names)
            return Part(made_of, paths, names.match)
    plan = series_of_cells(plan, group, names) or files_of_cells(plan, group, names) or plan
    return None if plan is None else Part(plan, paths, names.match)


def _turned_in_all(group: list[FileGuess], plan: LogPlan | None) -> LogPlan | None:
    """The plan of what hangs in another attitude in each file, as all files show it."""
    first = numbered(group[0])
    one = len(wrenches(first)) == 1 and not first.of("label")
    said = [{*c.words} for file in group for c in file.of("orientation")]
    turned = any(words != said[0] for words in said)
    if plan is None or not (turned or (not one and attitude_of(first, None) is not None)):
        return plan
    whole = plan_of(as_one(group, ()))
    if whole is None or whole.role != "hang":
        return plan
    return replace(whole, file=group[0], rate_hz=plan.rate_hz)


def _per_orientation(group: list[FileGuess], names: Names) -> Part | None:
    """One file per orientation of a six-axis transducer, which the file's name gives."""
    first = numbered(group[0])
    if first.of("orientation") or attitude_of(first, None) is not None:
        return None
    words = called([file.path for file in group])
    means = np.array([
        np.nanmean(forces_of(next(iter(wrenches(numbered(file)).values()))), axis=0)
        for file in group
    ])  # fmt: skip
    expression = whole_name(words)
    entry = Entry(file_name=expression, sure="likely", why="the files' names")
    found = named_orientation(words, entry, means)
    different = set() if found is None else set(found.entries["orientation"].names.values())
    plan = plan_of(first)
    if found is None or plan is None or len(different) < _LEAST_ORIENTATIONS:
        return None
    blanks = tuple(blank for blank in plan.blanks if "attitude" not in blank.why)
    plan = replace(
        plan, entries={**plan.entries, **found.entries}, blanks=blanks, sure="likely",
        kind="a six-axis transducer, one file per orientation", why="six axes; the files' names",
        warnings=(*plan.warnings, *found.warnings),
    )  # fmt: skip
    return Part(plan, tuple(file.path for file in group), names.match)


def _legs_per_orientation(group: list[FileGuess], names: Names) -> Part | None:
    """One file per orientation of a body that carries several transducers, a row for each."""
    first = numbered(group[0])
    plan = plan_of(first)
    if plan is None or first.of("orientation") or attitude_of(first, None) is not None:
        return None
    words = tuple(called([file.path for file in group]))
    codes = np.repeat(np.arange(len(group)), [file.rows for file in group])
    why = "the files' names"
    column = ColumnGuess(
        why, NameGuess("orientation"), None, "likely", why, words=words, codes=codes
    )  # fmt: skip
    whole = plan_of(as_one(group, (column,)))
    hung = None if whole is None else whole.entries.get("orientation")
    if whole is None or hung is None or len({*hung.names.values()}) < _LEAST_ORIENTATIONS:
        return None
    expression = whole_name(words)
    clock = {name: plan.entries[name] for name in ("time_s",) if name in plan.entries}
    orientation = Entry(file_name=expression, sure="likely", why=why, names=hung.names)
    entries = {**whole.entries, **clock, "orientation": orientation}
    made = replace(whole, file=group[0], entries=entries, rate_hz=plan.rate_hz,
                   kind=f"{whole.kind}, one file per orientation")  # fmt: skip
    return Part(made, tuple(file.path for file in group), names.match)


def _per_load(group: list[FileGuess], names: Names) -> Part | None:
    """One file per weight, which the file's name gives; of six axes the vertical force is read."""
    six = wrenches(numbered(group[0]))
    cell = next(iter(six.values()))["fz"] if six else readings(group[0])[0]
    load = loads_named(names)
    if load is None or (six and not _weighed(group, names, load)):
        return None
    channel = "fz" if six else "cell"
    entries = {
        "load_n": load, "counts": reading_entry(cell),
        "channel": Entry(value=channel, why="the vertical force" if six else "one cell alone"),
    }  # fmt: skip
    first = group[0]
    if cell.values is not None and np.isnan(cell.values).any() and first.of("time"):
        first = replace(first, rows_of=cell.column)  # another sensor of the recorder is faster
        entries |= times(first, needed=False)[0]
    warnings = (
        "the load is taken to stand on the sensor, its force along z; fx, fy and torques are not "
        "calibrated",
    ) if six else ()  # fmt: skip
    plan = LogPlan(
        first, "known weights, one file per weight", "the files' names differ by a number",
        "likely", "offline-fit", "weights", entries, (channel,),
        blanks=() if load.unit != NOT_SAID else (UNIT_ASKED,), warnings=warnings,
    )  # fmt: skip
    return Part(plan, tuple(file.path for file in group), names.match)


def _weighed(group: Sequence[FileGuess], names: Names, load: Entry) -> bool:
    """Whether numbers in the names of six-axis files are weights: of a unit, or felt along z.

    Files of poses and of tests are numbered too.
    """
    if load.unit != NOT_SAID:
        return True
    said = [re.search(load.file_name or "", name) for name in names.whole]
    put = np.array([float(load.names.get(f[1], f[1])) if f else np.nan for f in said])
    felt = [np.nanmean(forces_of(next(iter(wrenches(numbered(f)).values())))[:, 2]) for f in group]
    return straightness(put, np.array(felt)) > _STRAIGHT


def _per_foot(group: list[FileGuess], names: Names) -> Part | None:
    """The transducers or the cells of a robot's feet in a file each, joined by time."""
    sides = _feet_of(group, names)
    timed = all(file.of("time") for file in group) and not one_after_another(group)
    if not timed or not all(sides) or len({*sides}) < len(group):
        return None
    columns = []
    first, clock = group[0], seconds_of(group[0].of("time")[0])
    for i, (file, side) in enumerate(zip(group, sides, strict=True)):
        stem = file.path.name.rsplit(".", 1)[0]
        six, theirs = wrenches(numbered(file)), seconds_of(file.of("time")[0])
        for c in next(iter(six.values())).values() if six else readings(file):
            name = replace(c.name, side=side, owner="")
            name = replace(name, place="" if six else name.place or slug(c.column))
            made = replace(c, name=name)
            if i > 0:
                made = replace(made, column=f"{stem}.{c.column}")
            if i > 0 and clock is not None and theirs is not None and c.values is not None:
                made = replace(made, values=np.interp(clock, theirs, c.values))
            columns.append(made)
    own = {c.column for c in columns}
    plan = plan_of(replace(first, columns=(
        *(c for c in first.columns if c.column not in own and not c.words), *columns
    )))  # fmt: skip
    if plan is None:
        return None
    beside = tuple(Beside(file, "time", why="the other foot") for file in group[1:])
    return Part(plan, (first.path,), escaped(first.path.name), beside)


def _feet_of(group: Sequence[FileGuess], names: Names) -> list[str]:
    """The foot that each file is of: left and right, or legs that the files are called after."""
    sides = names.feet or list(map(_foot_of, group, names.middle))
    if all(sides) or wrenches(numbered(group[0])):  # transducers of legs hang
        return sides
    legs = [name_guess(word).place for word in names.middle]
    return [_TWO_LEGS.get(leg, leg) for leg in legs] if {*legs} == {*_TWO_LEGS} else legs


def _at_stamps_of(first: FileGuess, file: FileGuess, cell: ColumnGuess) -> FloatArray | None:
    """Readings of a cell at the stamps of another log; as they stand where stamps are dates."""
    ours, theirs = (seconds_of(one.of("time")[0]) for one in (first, file))
    if file is first or ours is None or theirs is None or cell.values is None:
        return cell.values
    return np.interp(ours, theirs, cell.values)


def _foot_of(file: FileGuess, word: str) -> str:
    """The foot that a file is of, by its cells or by its name; empty where neither says it."""
    sides = {c.name.side for c in readings(file)}
    name = name_guess(word if name_guess(word).place else f"foot_{word}")  # sx, sol
    return sides.pop() if len(sides) == 1 and "" not in sides else name.side * (not name.place)


def _per_plate(group: list[FileGuess], names: Names) -> Part | None:
    """Plates or feet that carry one weight together, a file each with the same stamps."""
    vertical = [_vertical(file) for file in group]
    if any(v is None for v in vertical):
        return None
    size = [0.0 if v is None else float(np.abs(np.nanmean(v))) for v in vertical]
    used = [s > _IDLE * max(size) for s in size]
    if sum(used) == 1 and len(group) > 1:
        return _only_plate(group, used)
    named = [(f, w, v) for f, w, v, u in zip(group, names.middle, vertical, used, strict=True) if u]
    group, words, vertical = (list(part) for part in zip(*named, strict=True))
    stamps = [file.of("time")[0].values if file.of("time") else None for file in group]
    first_stamps = stamps[0]
    if first_stamps is None or not all(
        s is not None and s.shape == first_stamps.shape and np.allclose(s, first_stamps)
        for s in stamps[1:]
    ):
        return None
    if not share_a_weight(np.array(vertical).T):
        return None
    columns, feet = [], dict(zip(names.middle, names.feet, strict=False))
    for i, (file, word) in enumerate(zip(group, words, strict=True)):
        side = feet.get(word) or name_guess(word).side or f"plate_{word.strip('_- ')}"
        stem = file.path.name.rsplit(".", 1)[0]
        for c in numbered(file).of("force", "cop"):
            column = c.column if i == 0 else f"{stem}.{c.column}"
            columns.append(
                replace(c, name=replace(c.name, side=side, place="", owner=""), column=column)
            )
    first, own = group[0], {c.column for c in columns}
    kept = (c for c in first.columns if c.column not in own)
    plan = plan_of(replace(first, columns=(*kept, *columns)))
    if plan is None:
        return None
    beside = tuple(Beside(file, "time", why="a file for each plate or foot") for file in group[1:])
    return Part(plan, (first.path,), escaped(first.path.name), beside)


def _only_plate(group: list[FileGuess], used: Sequence[bool]) -> Part | None:
    """The one plate of several that anything stands on."""
    file = next(file for file, own in zip(group, used, strict=True) if own)
    plan = plan_of(file)
    if plan is None or plan.command != "static-init":
        return None
    others = ", ".join(f.path.name for f, own in zip(group, used, strict=True) if not own)
    plan = replace(plan, warnings=(*plan.warnings, f"{others}: left out, nothing stands on them"))
    return Part(plan, (file.path,), escaped(file.path.name))


def _vertical(file: FileGuess) -> FloatArray | None:
    """The vertical force of a log's only plate or transducer, shape (n,); None without one."""
    forces = [c for c in numbered(file).of("force") if c.name.axis in ("fz", "")]
    return forces[0].values if len(forces) == 1 and not file.of("label", "load") else None


def _per_leg(group: Sequence[FileGuess], plan: LogPlan, names: Names) -> LogPlan:
    """One file per leg where the files' names say so; else all are of one transducer.

    The legs of one body share its attitude: how each is turned in it is looked for in all at once.
    """
    addresses = [name_guess(word) for word in names.middle]
    legs = {word: a.address for word, a in zip(names.middle, addresses, strict=True)}
    named = all(a.side or a.place for a in addresses)
    if named and all(re.fullmatch(r"[A-Za-z]{1,2}_?\d", word) for word in legs):
        legs = {word: word for word in legs}  # L1 L2 L3 are three legs
    if not named or len(set(legs.values())) < len(legs):
        legs = names.legs or legs_by_offsets(group, names.middle)
    if not legs or "leg" not in plan.entries:
        return plan
    if plan.role == "hang" and not group[0].of("orientation"):
        codes = np.repeat(np.arange(len(group)), [file.rows for file in group])
        ours = ColumnGuess(
            "leg", NameGuess("label"), None, "likely", "the files' names",
            words=tuple(legs.values()), codes=codes,
        )  # fmt: skip
        whole = plan_of(as_one(group, (ours,)))
        if whole is not None and whole.role == "hang":
            entries = {**whole.entries, **{n: e for n, e in plan.entries.items() if n == "time_s"}}
            plan = replace(whole, file=group[0], entries=entries, rate_hz=plan.rate_hz)
    leg = Entry(file_name=names.expression, why="the files' names", names=legs)
    return replace(plan, entries={**plan.entries, "leg": leg})


def _per_channel(group: list[FileGuess], names: Names) -> Part | None:
    """One file per channel of one recording, joined to the first."""
    paths, found = [file.path for file in group], cells_of_files(group, names.middle)
    stems = [p.name.rsplit(".", 1)[0] for p in paths]
    timed = all(file.of("time") for file in group)
    renamed = []
    for file, of, stem, i in zip(group, found, stems, range(len(group)), strict=True):
        cell = readings(file)[0]
        column = cell.column if i == 0 else f"{stem}.{cell.column}"
        name = replace(cell.name, side=of.side, place=of.place, owner=of.owner, quantity="reading")
        values = _at_stamps_of(group[0], file, cell) if timed else cell.values
        if values is None or values.size != group[0].rows:
            return None  # by rows no one recording
        renamed.append(replace(cell, column=column, name=name, values=values))
    first = group[0]
    own = tuple(c for c in first.columns if c.column != renamed[0].column)
    plan = plan_of(replace(first, columns=(*own, *renamed)))
    if plan is None:
        return None
    by = "time" if timed else "row"
    beside = tuple(Beside(f, by, why="one file per channel") for f in group[1:])
    return Part(plan, tuple(paths[:1]), escaped(paths[0].name), beside)
