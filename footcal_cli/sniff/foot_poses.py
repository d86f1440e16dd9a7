"""Where the feet stand in each stance, by a sheet: a row for each stance, or stance and foot.

Room: sniff; asked by robot_files. A column of the log says the stance, or the name of its file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from footcal_cli.sniff.file_loads import Names
from footcal_cli.sniff.file_names import Part, called
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.hole_sheets import along, texts_of
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.plan import Entry
from footcal_cli.sniff.still_feet import WHERE_FEET_STAND

_SIDES = ("left", "right")
_LEAST_STANCES = 2


@dataclass(frozen=True)
class _Poses:
    """A sheet's poses.

    Parameters
    ----------
    stances
        Texts of each column that may say the stance, by its name: as many as rows.
    feet
        Foot -> its rows, and what of its pose stands in which column.
    """

    sheet: FileGuess
    stances: Mapping[str, list[str]]
    feet: Mapping[str, tuple[list[int], Mapping[str, ColumnGuess]]]


def with_foot_poses(
    parts: Sequence[Part], others: Sequence[FileGuess]
) -> tuple[list[Part], list[FileGuess]]:
    """Stands with the feet where one sheet says that they were, and the logs left."""
    made, left = list(parts), []
    for sheet in others:
        poses = _poses_of(sheet)
        placed = [part if poses is None else _placed(part, poses) for part in made]
        if all(new is old for new, old in zip(placed, made, strict=True)):
            left.append(sheet)
        made = placed
    return made, left


def _poses_of(sheet: FileGuess) -> _Poses | None:
    """The poses of both feet in a sheet; None where it holds none."""
    for column in sheet.columns:
        words = texts_of(column) if column.codes is not None else []
        sides = [name_guess(f"{word}_foot").side for word in words]
        if {*sides} != {*_SIDES}:
            continue
        pose = _pose([c for c in sheet.columns if c is not column], sheet)
        rows = {side: [i for i, own in enumerate(sides) if own == side] for side in _SIDES}
        return _named(sheet, {side: (rows[side], pose) for side in _SIDES})
    own = {side: _pose([c for c in sheet.columns if c.name.side == side], sheet) for side in _SIDES}
    return _named(sheet, {side: ([*range(sheet.rows)], own[side]) for side in _SIDES})


def _named(
    sheet: FileGuess, feet: Mapping[str, tuple[list[int], Mapping[str, ColumnGuess]]]
) -> _Poses | None:
    """Poses with the columns that call them: another text in each row of a foot."""
    if not all({"x_m", "y_m"} <= set(pose) for _, pose in feet.values()):
        return None
    used = {c.column for _, pose in feet.values() for c in pose.values()}
    stances = {}
    for column in sheet.columns:
        texts = [] if column.column in used else texts_of(column)
        each = [[texts[i] for i in rows] for rows, _ in feet.values()] if texts else []
        if each and all(len({*own}) == len(own) >= _LEAST_STANCES for own in each):
            stances[column.column] = texts
    return _Poses(sheet, stances, feet) if stances else None


def _pose(columns: Sequence[ColumnGuess], sheet: FileGuess) -> dict[str, ColumnGuess]:
    """What of a foot's pose stands in which column, by the end of its canonical name."""
    found = {}
    places = [c for c in columns if c.quantity not in ("angle", "quaternion", "com", "com_acc")]
    for axis in "xyz":
        if (column := along(replace(sheet, columns=tuple(places)), axis)) is not None:
            found[f"{axis}_m"] = column
    for column in columns:
        if column.values is not None and column.quantity == "angle" and column.name.axis:
            found.setdefault(f"{column.name.axis}_rad", column)
        if column.values is not None and column.quantity == "quaternion":
            found.setdefault(f"q{column.name.axis}", column)
    return found


def _placed(part: Part, poses: _Poses) -> Part:
    """A stand with the feet of a sheet; as it is where it has feet, or the sheet other stances."""
    entries = part.plan.entries
    known = any(e.column is not None for name, e in entries.items() if "_foot_x" in name)
    if "com_x_m" not in entries or known:
        return part
    for name, stances in poses.stances.items():
        at = _in_a_column(part, name, stances) or _in_file_names(part, stances)
        if at is None:
            continue
        place, called_there = at
        feet = {
            f"{side}_foot_{end}": replace(
                place, unit=column.unit or _unit(end, entries), sure="likely",
                why=f"by {poses.sheet.path.name}",
                names={
                    word: f"{numbers_of(column)[i] + 0.0:.10g}" for i in rows
                    for word in called_there.get(stances[i], ())
                },
            )
            for side, (rows, pose) in poses.feet.items() for end, column in pose.items()
        }  # fmt: skip
        flat = Entry(value="0.0", sure="likely", why="no height is said: soles on the floor")
        low = {name: flat for side in _SIDES if (name := f"{side}_foot_z_m") not in feet}
        feet |= {name: entry for name, entry in low.items() if name not in entries}
        blanks = tuple(b for b in part.plan.blanks if b.why != WHERE_FEET_STAND)
        return replace(part, plan=replace(part.plan, entries={**entries, **feet}, blanks=blanks))
    return part


def _unit(end: str, entries: Mapping[str, Entry]) -> str | None:
    """The unit of a length that says none: the CoM's."""
    return (entries["com_x_m"].unit or "m") if end.endswith("_m") else None


def _in_a_column(
    part: Part, name: str, stances: Sequence[str]
) -> tuple[Entry, dict[str, list[str]]] | None:
    """The log's column of stances, and what each is called there; None without one."""
    for column in part.plan.file.columns:
        words = {*texts_of(column)} - {""}
        if column.column == name and len(words) >= _LEAST_STANCES and words <= {*stances}:
            return Entry(column), {word: [word] for word in words}
    return None


def _in_file_names(part: Part, stances: Sequence[str]) -> tuple[Entry, dict[str, list[str]]] | None:
    """What of the files' names says the stance, and what each is called there; None if nothing."""
    if len(part.paths) < _LEAST_STANCES:
        return None
    names = Names.of(called(part.paths))
    found: dict[str, list[str]] = {}
    for path, word in zip(part.paths, names.middle, strict=True):
        stem = path.name.split(".")[0]
        alike = {stance for stance in stances if stance in (stem, word)}
        number = _number(word)
        alike = alike or {s for s in stances if number is not None and _number(s) == number}
        if len(alike) != 1:
            return None
        found.setdefault(alike.pop(), []).append(word)
    return Entry(file_name=names.expression), found


def _number(text: str) -> int | None:
    """The one number in a text."""
    numbers = re.findall(r"\d+", text)
    return int(numbers[0]) if len(numbers) == 1 else None
