"""Several logs at once: alike, beside each other, a reference or an attitude, sensors and body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.alike import groups_of
from footcal_cli.sniff.attitudes import attitude_of
from footcal_cli.sniff.bench_files_of_feet import benches_of_feet
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_index import with_index
from footcal_cli.sniff.file_loads import escaped
from footcal_cli.sniff.file_names import Beside, Part, alike_part, called
from footcal_cli.sniff.foot_mounts import foot_mount
from footcal_cli.sniff.frames import rate_asked
from footcal_cli.sniff.geometry import says_places, with_places
from footcal_cli.sniff.groups import readings, wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.hangings import asked_by_file
from footcal_cli.sniff.hole_sheets import with_holes, with_holes_named
from footcal_cli.sniff.hung_in_stand import with_hung_stance
from footcal_cli.sniff.indexed import ATTITUDE, indexed
from footcal_cli.sniff.known_pieces import with_known_pieces
from footcal_cli.sniff.legs_in_files import legs_in_files
from footcal_cli.sniff.lifted import in_the_air_apart, with_lifted
from footcal_cli.sniff.log_sheets import by_log_sheet
from footcal_cli.sniff.motion import body_entries
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.one_by_one import marked_files
from footcal_cli.sniff.one_sign import of_one_sign, under_hung_names
from footcal_cli.sniff.placed_feet import by_foot
from footcal_cli.sniff.placed_files import placed_files
from footcal_cli.sniff.placement_index import indexed_placements
from footcal_cli.sniff.plan import Blank, Entry, without_silent_rows
from footcal_cli.sniff.protocol import by_own_sheets, by_protocol, by_sheet_of_cells
from footcal_cli.sniff.robot_files import with_bodies, with_body, with_one_name
from footcal_cli.sniff.row_stances import with_row_stances
from footcal_cli.sniff.said_above import as_said_above
from footcal_cli.sniff.shafts import with_shafts
from footcal_cli.sniff.six_axis import HUNG_FIRST, NO_PHASE
from footcal_cli.sniff.stepping import with_sides
from footcal_cli.sniff.steps_beside import by_steps, posed, steps_of
from footcal_cli.sniff.stretches import by_stretches
from footcal_cli.sniff.twins import by_experiment, without_twins
from footcal_cli.sniff.walking import walked
from footcal_cli.tables.units import TIMES


def parts_of(files: Sequence[FileGuess]) -> tuple[list[Part], list[FileGuess]]:
    """Plans for all logs, and the logs that fit nothing."""
    parts, others = _planned(walked(with_shafts(with_known_pieces(files))))
    parts = [replace(p, plan=as_said_above(without_silent_rows(p.plan))) for p in parts]
    made = [replace(p, plan=rate_asked(with_row_stances(p.plan))) for p in parts]
    if not any(part.plan.role == "zeros" for part in made):
        made = [replace(part, plan=with_hung_stance(part.plan)) for part in made]
    if any(part.plan.role == "hang" for part in made):  # it comes first, and is said by then
        made = [
            replace(part, plan=replace(part.plan, blanks=tuple(
                blank for blank in part.plan.blanks if blank is not HUNG_FIRST
            ))) for part in made
        ]  # fmt: skip
        made = under_hung_names(of_one_sign([_with_phase_asked(part, made) for part in made]))
    return sorted(made, key=lambda part: part.plan.command == "pose-calib"), others


def _with_phase_asked(part: Part, parts: Sequence[Part]) -> Part:
    """Poses without the shaft angles that the hanging robot's log has: these are asked for."""
    plan = part.plan
    hung = [other.plan for other in parts if other.plan.role == "hang"]
    turned = any("phase_rad" in own for p in hung for own in (p.entries, *p.wide.values()))
    held = plan.entries.get("phase_rad")
    if not turned or plan.command != "pose-calib" or held is None or held.value is None:
        return part
    return replace(part, plan=replace(plan, blanks=(*plan.blanks, NO_PHASE)))


def _planned(files: Sequence[FileGuess]) -> tuple[list[Part], list[FileGuess]]:
    placed_apart, files = placed_files(with_holes_named(files))
    by_index, files = indexed_placements(files)
    placed_apart += by_index
    alike = groups_of(files)
    hung, alike = legs_in_files(alike)
    if hung:
        more, others = _planned([file for group in alike for file in group]) if alike else ([], [])
        return [*hung, *more], others
    sheets = [g[0] for g in alike if len(g) == 1 and says_places(g[0])]
    for apart in ([], sheets) if not placed_apart else ():
        two = [group for group in alike if not any(group[0] is sheet for sheet in apart)]
        if len(two) == 2 and (paired := _pair(*two)):
            return _with_all_places(paired, apart)
    if len(alike) > 2 and not placed_apart:
        posed, alike = _with_sheets(alike)
        if posed:
            more, others = _planned([file for group in alike for file in group])
            return [*posed, *more], others
    if len(alike) == 1 and not placed_apart and (made := marked_files(alike[0])) is not None:
        return [made], []
    parts, others = placed_apart, []
    alike = [own for whole in alike for own in in_the_air_apart(whole)]
    for group in [own for whole in alike for own in by_experiment(whole)]:
        each = benches_of_feet(group)
        made = None if each else alike_part(group)
        if each:
            parts += each
        elif made is None:
            others += group
        else:
            plan = asked_by_file(made.plan, called(made.paths))
            parts.append(by_foot(replace(made, plan=plan)))
    parts, others = with_bodies(without_twins(parts), others)
    parts, others = with_index(parts, others)
    return with_one_name(*with_lifted(*_with_all_places(parts, others)))


def _with_all_places(
    parts: Sequence[Part], others: Sequence[FileGuess]
) -> tuple[list[Part], list[FileGuess]]:
    """Plans with the places that sheets say, and what fits nothing."""
    placed, left = with_places(parts, others)
    placed, without_holes = with_holes(placed, others)  # one sheet may place cells and holes
    return placed, [file for file in left if any(file is own for own in without_holes)]


def _pair(one: list[FileGuess], other: list[FileGuess]) -> list[Part]:
    """Plans for two groups of logs that belong together; none where they do not."""
    if len(one) == len(other) == 1 and (joined := _two(one[0], other[0])):
        return joined
    for group, rest in permutations((one, other)):
        if len(group) > len(rest) == 1 and (each := by_sheet_of_cells(group, rest[0])):
            return each
        if len(group) == len(rest) > 1 and (each := by_own_sheets(group, rest)):
            return each
        if len(rest) == 1 and (made := indexed(group, rest[0])) is not None:
            return [made]
        if len(group) > len(rest) == 1 and all(_hang(file, rest[0]) for file in group):
            made = _with_attitude(group, numbered(rest[0]))
            if made is not None:
                return [made]
    return []


def _with_sheets(
    alike: Sequence[list[FileGuess]],
) -> tuple[list[Part], list[list[FileGuess]]]:
    """Six-axis logs with the sheets that say how each was turned, and what is left of the logs."""
    left, parts = list(alike), list[Part]()
    for group, rest in permutations(alike, 2):
        if len(rest) > 1 or not all(any(one is own for own in left) for one in (group, rest)):
            continue
        first, sheet = numbered(group[0]), rest[0]
        if not wrenches(first) or wrenches(numbered(sheet)) or attitude_of(first, None):
            continue
        made = indexed(group, sheet)
        if made is None and len(group) == 1:
            made = posed(group[0], sheet)
        if made is not None:
            parts.append(made)
            left = [own for own in left if own is not group and own is not rest]
    return parts, left


def _two(one: FileGuess, other: FileGuess) -> list[Part]:
    """Two different logs: readings and their reference, or sensors and the body."""
    if (one.of("orientation") or other.of("orientation")) and all(
        wrenches(numbered(file)) for file in (one, other)
    ):
        return []  # two experiments with the same transducers
    for file, beside in ((one, other), (other, one)):
        if beside.of("com") and not file.of("com") and not _has_cells(beside):
            file = with_sides(file, _foot_speeds(file, beside))
            plan = plan_of(file)
            if plan is not None:
                body = _at_rows(file, beside)
                return with_body(plan, beside, body, foot_mount(wrenches(file), body))
    for file, beside in ((one, other), (other, one)):
        still = by_stretches(file, beside) or by_log_sheet(file, beside)
        if still is not None:
            return [still]
    for file, beside in ((one, other), (other, one)):
        if _hang(file, beside):
            made = _with_attitude([file], numbered(beside)) or _of_holds(file, beside)
            if made is not None:
                return [made]
    for file, beside in ((one, other), (other, one)):
        made = by_protocol(file, beside) or by_steps(file, beside) or posed(file, beside)
        if made is not None:
            return [made]
    for file, beside in ((one, other), (other, one)):
        cells = readings(file)
        reference = beside.of("load") or [
            c for c in beside.of("force") if c.name.axis in ("", "fz")
        ]
        has_own = file.of("load") or not cells
        if len(reference) == 1 and not has_own and file.of("time") and beside.of("time"):
            stem = beside.path.name.rsplit(".", 1)[0]
            offset, why = _offset(file, beside)
            load = replace(
                reference[0].as_quantity("load", "likely", "the other file's force"),
                column=f"{stem}.{reference[0].column}",
                values=_at_stamps(file, beside, reference[0], offset),
            )
            plan = plan_of(replace(file, columns=(*file.columns, load)))
            if plan is None:
                continue
            joined = Beside(beside, "time", offset, why)
            warnings = (*plan.warnings, why) if offset else plan.warnings
            return [Part(replace(plan, warnings=warnings), (file.path,), escaped(file.path.name),
                         (joined,))]  # fmt: skip
    return []


def _hang(file: FileGuess, beside: FileGuess) -> bool:
    """Whether a log has transducers without an attitude, which another one has.

    One with transducers of its own is another experiment with them: hanging, and standing poses.
    """
    held = wrenches(numbered(file)) and not attitude_of(numbered(file), None)
    named = (axes["fx"].sure != "guess" for axes in wrenches(numbered(beside)).values())
    if not held or file.of("orientation") or any(named):
        return False
    return attitude_of(numbered(beside), None) is not None


def _has_cells(file: FileGuess) -> bool:
    """Whether a body's stream holds the cells under the feet too: it is a walk by itself."""
    plan = plan_of(file) if readings(file) else None
    return plan is not None and plan.role == "cells"


def _at_rows(file: FileGuess, body: FileGuess) -> dict[str, Entry]:
    """The body's motion at the stamps of a log; empty without stamps."""
    if not file.of("time") or not body.of("time"):
        return {}
    offset, _ = _offset(file, body)
    return {
        name: replace(e, column=replace(e.column, values=_at_stamps(file, body, e.column, offset)))
        for name, e in body_entries(body, on_cells=not wrenches(file)).items()
        if e.column is not None
    }


def _foot_speeds(file: FileGuess, body: FileGuess) -> dict[str, FloatArray]:
    """Change of each foot's place from row to row of a log; empty without a place or stamps."""
    entries, found = _at_rows(file, body), {}
    for side in ("left", "right"):
        columns = [entries[n].column for a in "xyz" if (n := f"{side}_foot_{a}_m") in entries]
        places = [c.values for c in columns if c is not None and c.values is not None]
        if len(places) == 3:
            found[side] = np.linalg.norm(np.gradient(np.array(places), axis=1), axis=0)
    return found


def _turned(file: FileGuess, beside: FileGuess) -> tuple[FileGuess, Beside] | None:
    """A log with the attitude of another one: by stamps, without any by rows; None where neither.

    Where stamps are dates, what is joined is not seen here.
    """
    timed = bool(file.of("time") and beside.of("time"))
    if not timed and (file.rows != beside.rows or file.of("time") or beside.of("time")):
        return None
    offset, why = _offset(file, beside) if timed else (0.0, "as many rows, neither with stamps")
    stem = beside.path.name.rsplit(".", 1)[0]
    joined = (
        replace(
            c, column=f"{stem}.{c.column}",
            values=_at_stamps(file, beside, c, offset) if timed else c.values,
        )
        for c in beside.of(*ATTITUDE)
    )  # fmt: skip
    join = Beside(beside, "time" if timed else "row", offset, why)
    return replace(file, columns=(*file.columns, *joined)), join


def _with_attitude(group: Sequence[FileGuess], beside: FileGuess) -> Part | None:
    """Six-axis transducers in files of their own, and the attitude from another log."""
    turned = [made for file in group if (made := _turned(file, beside)) is not None]
    if len(turned) < len(group) or len({join.offset_s for _, join in turned}) > 1:
        return None
    part, join = alike_part([file for file, _ in turned]), turned[0][1]
    if part is None:
        return None
    plan = part.plan
    if join.offset_s or join.by == "row":
        plan = replace(plan, warnings=(*plan.warnings, join.why))
    match = part.match
    if len(group) == 1:
        match = escaped(called([*part.paths, beside.path])[0])
    return replace(part, plan=plan, match=match, beside=(join,))


def _of_holds(file: FileGuess, beside: FileGuess) -> Part | None:
    """A six-axis transducer, and attitudes of which nothing says when they were: that is asked."""
    if beside.of("time") or beside.rows >= file.rows or steps_of(file, beside) is not None:
        return None
    plan = plan_of(file)
    if plan is None or not any("attitude" in blank.why for blank in plan.blanks):
        return None
    asked = Blank(
        (f"# {beside.path.name}: write the number of the hold into both logs, in a column `hold`",
         "# (1, 2, …; empty while the transducer moves), then run footcal init again"),
        f"{beside.path.name} holds {beside.rows} attitudes and neither stamps nor numbers of holds",
    )  # fmt: skip
    blanks = tuple(asked if "attitude" in blank.why else blank for blank in plan.blanks)
    return Part(replace(plan, blanks=blanks), (file.path,), escaped(file.path.name))


def _at_stamps(
    file: FileGuess, beside: FileGuess, column: ColumnGuess, offset: float
) -> FloatArray | None:
    """Values of another log's column at the stamps of a log; NaN where stamps are dates."""
    ours, theirs = _seconds(file), _seconds(beside)
    if column.values is None:
        return None
    if ours is None or theirs is None:
        return np.full(file.rows, np.nan)
    return np.interp(ours, theirs + offset, column.values)


def _seconds(file: FileGuess) -> FloatArray | None:
    """Stamps of a log in s, shape (n,); None where they are dates."""
    column = file.of("time")[0]
    return None if column.values is None else column.values * TIMES.get(column.unit or "s", 1.0)


def _offset(file: FileGuess, beside: FileGuess) -> tuple[float, str]:
    """What to add to the other file's stamps: 0 where they overlap, else the starts are matched."""
    ours, theirs = _seconds(file), _seconds(beside)
    if ours is None or theirs is None:
        return 0.0, "stamps are dates"
    a, b, c, d = float(ours[0]), float(ours[-1]), float(theirs[0]), float(theirs[-1])
    if min(b, d) - max(a, c) > 0.5 * min(b - a, d - c):
        return 0.0, "the stamps of both files overlap"
    return a - c, "the two clocks have nothing in common: both files are taken to start together"
