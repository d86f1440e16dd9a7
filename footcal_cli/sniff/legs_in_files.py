"""A file for each leg and orientation of a robot that hangs, maybe with its joints in files beside.

Room: sniff; called by several. Of ``hang_xu.L1.wrench`` one word says the leg, the rest which axis
points up; the joints of that orientation stand in ``hang_xu.q``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.attitudes import attitude_of
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import escaped, whole_name
from footcal_cli.sniff.file_names import Beside, Part, called
from footcal_cli.sniff.groups import wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, as_one, numbers_of, seconds_of
from footcal_cli.sniff.names import NameGuess, Quantity, name_guess
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.plan import Blank, Entry, LogPlan, times
from footcal_cli.sniff.shafts import shaft_entry
from footcal_cli.sniff.sides import sides_in
from footcal_cli.sniff.vocabulary import LEGS

_LEAST_LEGS, _LEAST_ORIENTATIONS = 2, 3
_NUMBERED_LEG = re.compile(r"[A-Za-z]{1,3}\d")
_SHORT_LEG = re.compile(r"[A-Z]{2,3}")
"""The first letters of where a leg is, such as ``LP`` for levá přední."""
_MOVES, _ALIKE = 0.2, 0.1
"""Shares of the largest scatter: of a joint that moves, and by which joints that move alike differ.
"""
WHICH_JOINT = Blank(
    ('# in [files.columns]: phase_rad = { column = "…", unit = "rad" }, of each leg its own',),
    "nothing says which joint turns which leg",
)


@dataclass(frozen=True)
class _Named:
    """Leg and orientation of a file: the leg's name, what else the name says, the axis down."""

    word: str
    leg: str
    rest: str
    axis: str


def legs_in_files(
    alike: Sequence[list[FileGuess]],
) -> tuple[list[Part], list[list[FileGuess]]]:
    """Parts of the first group of such files, and the groups that are not used for them."""
    for group in alike:
        names = _legs_of(called([file.path for file in group]))
        if not names or not all(map(_hangs, group)):
            continue
        for joints in alike:
            beside = _joints_of(joints, names) if joints is not group else {}
            if beside:
                rest = [own for own in alike if own is not group and own is not joints]
                return _with_joints(group, names, beside), rest
        made = _together(group, names)
        return ([made] if made else []), [own for own in alike if own is not group or not made]
    return [], list(alike)


def _hangs(file: FileGuess) -> bool:
    """Whether a log is of one transducer, and says neither leg nor attitude."""
    own = numbered(file)
    said = own.of("label", "orientation", "load", "com")
    return len(wrenches(own)) == 1 and not said and attitude_of(own, None) is None


def _legs_of(names: Sequence[str]) -> list[_Named]:
    """What each name says; empty where no word in all of them is a leg beside an orientation."""
    parts = [re.split(r"([\W_]+)", name) for name in names]
    if len({len(own) for own in parts}) > 1:
        return []
    for at in range(0, len(parts[0]), 2):
        words = [own[at] for own in parts]
        before = parts[0][at - 2].lower() if at else ""
        legs = _leg_names(words, after_a_leg=before in LEGS)
        rests = ["".join(own[: max(at - 1, 0)] + own[at + 1 :]) for own in parts]
        sides = sides_in([*dict.fromkeys(rests)])
        seen = {leg: {r for w, r in zip(words, rests, strict=True) if w == leg} for leg in legs}
        axes = {axis for axis, _ in sides.values()}
        whole = len({frozenset(own) for own in seen.values()}) == 1
        if len(seen) < _LEAST_LEGS or None in axes or not whole:
            continue
        if len(axes) >= _LEAST_ORIENTATIONS and len({*zip(words, rests, strict=True)}) == len(
            names
        ):
            return [
                _Named(word, legs[word], rest, sides[rest][0] or "")
                for word, rest in zip(words, rests, strict=True)
            ]
    return []


def _leg_names(words: Sequence[str], *, after_a_leg: bool) -> dict[str, str]:
    """Words -> names of legs; empty where one of them is none."""
    different = sorted({*words})
    said = [name_guess(word) for word in different]
    if all(guess.place for guess in said):
        return {word: guess.address for word, guess in zip(different, said, strict=True)}
    if all(_NUMBERED_LEG.fullmatch(word) for word in different):
        return {word: word for word in different}
    if after_a_leg and all(word.isdigit() or word.isalpha() for word in different):
        return {word: f"leg_{word}" for word in different}
    if all(guess.side for guess in said):
        return {word: guess.side for word, guess in zip(different, said, strict=True)}
    short = all(_SHORT_LEG.fullmatch(word) for word in different)
    # in whatever language: that each stands beside each orientation is asked of what is found
    alike = short and len({*map(len, different)}) == 1
    return {word: word for word in different} if alike else {}


def _whole(
    group: Sequence[FileGuess], names: Sequence[_Named], more: Sequence[ColumnGuess] = ()
) -> LogPlan | None:
    """The plan that all files show together; None where they do not hang."""
    files = [numbered(file) for file in group]
    rows = [file.rows for file in files]
    columns = (
        _said("label", [n.leg for n in names], rows),
        _said("orientation", [n.rest for n in names], rows),
    )
    plan = plan_of(as_one(files, (*columns, *more)))
    hung = plan is not None and plan.role == "hang" and plan.entries.get("orientation")
    return plan if hung else None


def _said(quantity: Quantity, own: Sequence[str], rows: Sequence[int]) -> ColumnGuess:
    """A column of what the name of each file says, in every row of it."""
    words, why = tuple(dict.fromkeys(own)), "the files' names"
    codes = np.repeat([words.index(word) for word in own], rows)
    return ColumnGuess(why, NameGuess(quantity), None, "likely", why, words=words, codes=codes)


def _together(group: Sequence[FileGuess], names: Sequence[_Named]) -> Part | None:
    """One entry for all files, leg and orientation by their names."""
    plan = _whole(group, names)
    if plan is None:
        return None
    paths = tuple(file.path for file in group)
    whole = called(paths)
    said = plan.entries["orientation"].names
    entries = {
        **plan.entries, **times(numbered(group[0]), needed=True)[0],
        "leg": Entry(file_name=whole_name(whole), why="the files' names",
                     names=dict(zip(whole, (n.leg for n in names), strict=True))),
        "orientation": Entry(file_name=whole_name(whole), why="the files' names",
                             names={w: said[n.rest] for w, n in zip(whole, names, strict=True)}),
    }  # fmt: skip
    plan = replace(plan, file=group[0], entries=entries,
                   kind=f"{plan.kind}, a file for each leg and orientation")  # fmt: skip
    return Part(plan, paths, _match(whole))


def _match(names: Sequence[str]) -> str:
    """A pattern of several names: what all begin and end with."""
    short = min(map(len, names))
    head = next((i for i in range(short) if len({n[i] for n in names}) > 1), short)
    tail = next((i for i in range(short - head) if len({n[-1 - i] for n in names}) > 1), 0)
    return f"{escaped(names[0][:head])}*{escaped(names[0][len(names[0]) - tail :])}"


def _joints_of(group: Sequence[FileGuess], names: Sequence[_Named]) -> dict[str, FileGuess]:
    """The file of joints of each orientation; empty where these files are none."""
    sides = sides_in(called([file.path for file in group]))
    found = {axis: file for (axis, _), file in zip(sides.values(), group, strict=True) if axis}
    fit = len(found) == len(group) and found.keys() == {n.axis for n in names}
    free = all(file.of("time") and not wrenches(numbered(file)) for file in group)
    return found if fit and free else {}


def _with_joints(
    group: Sequence[FileGuess], names: Sequence[_Named], beside: Mapping[str, FileGuess]
) -> list[Part]:
    """An entry for each file, the joint that turns its leg from the file beside it."""
    words = list(dict.fromkeys(n.word for n in names))
    turning, why = _turning([*beside.values()], words)
    more: list[ColumnGuess] = []
    if turning:
        values = np.concatenate([
            _at_stamps(file, beside[n.axis], turning[n.word])
            for file, n in zip(group, names, strict=True)
        ])  # fmt: skip
        first = _column(next(iter(beside.values())), turning[words[0]])
        more = [replace(first, name=NameGuess("phase"), values=values)]
    plan = _whole(group, names, more)
    if plan is None:
        return []
    parts = []
    said = plan.entries["orientation"].names
    for file, n in zip(group, names, strict=True):
        joints = beside[n.axis]
        entries = {
            **plan.entries, **times(numbered(file), needed=True)[0],
            "leg": Entry(value=n.leg, why="the file's name"),
            "orientation": Entry(value=said[n.rest], why="the file's name"),
        }  # fmt: skip
        if turning:
            column = _column(joints, turning[n.word])
            stem = joints.path.name.rsplit(".", 1)[0]
            entry = shaft_entry(replace(column, column=f"{stem}.{column.column}"))
            entries["phase_rad"] = replace(entry, sure="guess", why=why)
        own = replace(
            plan, file=file, entries=entries,
            blanks=plan.blanks if turning else (*plan.blanks, WHICH_JOINT),
            warnings=(*plan.warnings, *([why] if turning else [])),
        )  # fmt: skip
        join = Beside(joints, "time", why="the joints in that orientation")
        parts.append(Part(own, (file.path,), escaped(file.path.name), (join,)))
    return parts


def _turning(files: Sequence[FileGuess], words: Sequence[str]) -> tuple[dict[str, str], str]:
    """Leg -> the column of the joint that turns it, and why; empty where nothing says it."""
    columns = [
        c.column for c in files[0].columns
        if c.values is not None and c.quantity not in ("time", "sequence")
    ]  # fmt: skip
    moved = {
        name: float(np.mean([np.nanstd(numbers_of(_column(f, name))) for f in files]))
        for name in columns
    }
    own = {
        word: {re.sub(rf"(?i)(?<![a-z0-9]){word}(?![a-z0-9])", "", name): name for name in columns
               if re.search(rf"(?i)(?<![a-z0-9]){word}(?![a-z0-9])", name)}
        for word in words
    }  # fmt: skip
    shared = set.intersection(*({*joints} for joints in own.values()))
    if shared:
        most = max(sorted(shared), key=lambda j: sum(moved[own[word][j]] for word in words))
        return {word: own[word][most] for word in words}, "the joint of the leg that moves most"
    moving = [name for name in columns if moved[name] > _MOVES * max(moved.values())]
    if len(moving) != len(words):
        return {}, ""
    first = np.concatenate([numbers_of(_column(f, moving[0])) for f in files])
    for name in moving[1:]:
        other = np.concatenate([numbers_of(_column(f, name)) for f in files])
        if np.nanstd(other - first) > _ALIKE * np.nanstd(first):
            return {}, ""
    why = "the joints that move, in the order of the legs' names; they move alike"
    return dict(zip(sorted(words), moving, strict=True)), why


def _column(file: FileGuess, name: str) -> ColumnGuess:
    return next(c for c in file.columns if c.column == name)


def _at_stamps(file: FileGuess, beside: FileGuess, name: str) -> FloatArray:
    """A joint at the stamps of a leg's log, shape (n,); as it is near them without stamps."""
    column = numbers_of(_column(beside, name))
    clock = file.of("time")
    ours = seconds_of(clock[0]) if clock else None
    theirs = seconds_of(beside.of("time")[0])
    if ours is None or theirs is None:
        return np.full(file.rows, np.nan)
    return np.interp(ours, theirs, column)
