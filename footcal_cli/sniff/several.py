"""Several logs at once: alike, one per channel or per load, beside each other, sensors and body."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from footcal_cli.sniff.columns import FileGuess
from footcal_cli.sniff.experiment import UNIT_ASKED, UNIT_TO_FILL_IN, body_entries, plan_of
from footcal_cli.sniff.groups import readings
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.plan import Entry, Plan
from footcal_cli.sniff.units import known_unit

_LOAD = re.compile(r"(\d+(?:[.,p]\d+)?)\s*_?(kg|g|N|lb|lbs|gr|mg)?", re.IGNORECASE)


@dataclass(frozen=True)
class Beside:
    """A log joined to another: its file, and how."""

    file: FileGuess
    by: str
    offset_s: float = 0.0
    why: str = ""


@dataclass(frozen=True)
class Part:
    """Logs of one kind: the plan for them, the pattern of their names, what is joined."""

    plan: Plan
    paths: tuple[Path, ...]
    match: str
    beside: tuple[Beside, ...] = ()


def parts_of(files: Sequence[FileGuess]) -> tuple[list[Part], list[FileGuess]]:
    """Plans for all logs, and the logs that fit nothing."""
    groups: dict[object, list[FileGuess]] = {}
    for file in files:
        names = tuple(c.column for c in file.columns)
        groups.setdefault((file.layout, names), []).append(file)
    alike = list(groups.values())
    if len(alike) == 2 and all(len(group) == 1 for group in alike):
        joined = _two(alike[0][0], alike[1][0])
        if joined:
            return joined, []
    parts, others = [], []
    for group in alike:
        made = _alike(group)
        if made is None:
            others += group
        else:
            parts.append(made)
    return parts, others


def _alike(group: list[FileGuess]) -> Part | None:
    """Logs with the same columns: sessions, loads or channels that the file names tell."""
    paths = tuple(file.path for file in group)
    if len(group) == 1:
        plan = plan_of(group[0])
        return None if plan is None else Part(plan, paths, _escaped(paths[0].name))
    names = [path.name for path in paths]
    head = _common_start(names)
    tail = _common_start([name[::-1] for name in names])[::-1]
    head = head.rstrip("0123456789.")
    longest = min(map(len, names)) - len(head)
    tail = tail[-longest:] if longest > 0 else ""
    while tail and tail[0].isalnum():
        tail = tail[1:]
    middle = [name[len(head) : len(name) - len(tail)] for name in names]
    match = f"{_escaped(head)}*{_escaped(tail)}"
    first = group[0]
    cells = readings(first)
    told = first.of("load") or first.of("label")
    if len(cells) == 1 and not told:
        loads = [_LOAD.fullmatch(word.strip("_- ")) for word in middle]
        units = {found[2] for found in loads if found}
        if all(loads) and len(units) == 1:
            return _per_load(group, paths, match, head, tail, units.pop())
        addresses = {name_guess(word).address or word for word in middle}
        if len(addresses) == len(group):
            return _per_channel(group, paths, middle)
    if len(cells) == 1 and first.of("load") and not first.of("label") and len(set(middle)) > 1:
        plan = plan_of(first)
        if plan is not None and not any(re.fullmatch(r"[\d_-]*", word) for word in middle):
            channel = Entry(
                file_name=f"^{re.escape(head)}(.+){re.escape(tail)}$",
                why="the files' names differ so",
            )
            entries = {k: v for k, v in plan.entries.items() if not k.endswith("_counts")}
            if "counts" not in entries:
                entries["counts"] = next(
                    v for k, v in plan.entries.items() if k.endswith("_counts")
                )
            plan = replace(
                plan, kind="known weights, one file per channel", role="weights",
                channels=tuple(middle), entries={**entries, "channel": channel},
            )  # fmt: skip
            return Part(plan, paths, match)
    plan = plan_of(first)
    return None if plan is None else Part(plan, paths, match)


def _per_load(
    group: list[FileGuess], paths: tuple[Path, ...], match: str, head: str, tail: str,
    unit: str | None,
) -> Part:  # fmt: skip
    """One file per weight, which the file's name gives."""
    expression = rf"^{re.escape(head)}[_ -]*(\d+(?:\.\d+)?)"
    sure = "likely" if unit else "guess"
    load = Entry(
        file_name=expression, unit=known_unit(unit or "") or UNIT_TO_FILL_IN, sure=sure,  # type: ignore[arg-type]
        why="a number in the file's name",
    )  # fmt: skip
    cell = readings(group[0])[0]
    entries = {
        "load_n": load, "counts": Entry(cell, cell.unit if cell.unit in ("V", "mV") else None),
        "channel": Entry(value="cell", why="one cell alone"),
    }  # fmt: skip
    plan = Plan(
        group[0], "known weights, one file per weight", "the files' names differ by a number",
        "likely", "offline-fit", "weights", entries, ("cell",),
        blanks=() if unit else (UNIT_ASKED,),
    )  # fmt: skip
    return Part(plan, paths, match)


def _per_channel(group: list[FileGuess], paths: tuple[Path, ...], middle: list[str]) -> Part | None:
    """One file per channel of one recording, joined to the first."""
    addresses = [name_guess(word).address or word.strip("_- ") for word in middle]
    stems = [path.name.rsplit(".", 1)[0] for path in paths]
    timed = all(file.of("time") for file in group)
    renamed = []
    for file, address, stem, i in zip(group, addresses, stems, range(len(group)), strict=True):
        cell = readings(file)[0]
        column = cell.column if i == 0 else f"{stem}.{cell.column}"
        made = name_guess(address)
        name = replace(
            cell.name, side=made.side, place=made.place, owner=made.owner or address,
            quantity="reading",
        )  # fmt: skip
        renamed.append(replace(cell, column=column, name=name))
    first = group[0]
    own = tuple(c for c in first.columns if c.column != renamed[0].column)
    plan = plan_of(replace(first, columns=(*own, *renamed)))
    if plan is None:
        return None
    by = "time" if timed else "row"
    beside = tuple(Beside(f, by, why="one file per channel") for f in group[1:])
    return Part(plan, paths[:1], _escaped(paths[0].name), beside)


def _two(one: FileGuess, other: FileGuess) -> list[Part]:
    """Two different logs: readings and their reference, or sensors and the body."""
    for file, beside in ((one, other), (other, one)):
        if beside.of("com") and not file.of("com"):
            plan = plan_of(file)
            if plan is not None:
                return _with_body(plan, beside)
    for file, beside in ((one, other), (other, one)):
        cells = readings(file)
        reference = beside.of("load") or [
            c for c in beside.of("force") if c.name.axis in ("", "fz")
        ]
        has_own = file.of("load") or not cells
        if len(reference) == 1 and not has_own and file.of("time") and beside.of("time"):
            stem = beside.path.name.rsplit(".", 1)[0]
            load = replace(
                reference[0].as_quantity("load", "likely", "the other file's force"),
                column=f"{stem}.{reference[0].column}",
            )
            plan = plan_of(replace(file, columns=(*file.columns, load)))
            if plan is None:
                continue
            offset, why = _offset(file, beside)
            joined = Beside(beside, "time", offset, why)
            warnings = (*plan.warnings, why) if offset else plan.warnings
            return [Part(replace(plan, warnings=warnings), (file.path,), _escaped(file.path.name),
                         (joined,))]  # fmt: skip
    return []


def _offset(file: FileGuess, beside: FileGuess) -> tuple[float, str]:
    """What to add to the other file's stamps: 0 where they overlap, else the starts are matched."""
    scale = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}
    spans = []
    for one in (file, beside):
        column = one.of("time")[0]
        if column.values is None:
            return 0.0, "stamps are dates"
        factor = scale.get(column.unit or "s", 1.0)
        spans.append((float(column.values[0]) * factor, float(column.values[-1]) * factor))
    (a, b), (c, d) = spans
    if min(b, d) - max(a, c) > 0.5 * min(b - a, d - c):
        return 0.0, "the stamps of both files overlap"
    return a - c, "the two clocks have nothing in common: both files are taken to start together"


def _with_body(plan: Plan, body: FileGuess) -> list[Part]:
    """Sensors and the robot's own stream."""
    entries = body_entries(body)
    other = Plan(
        body, "the robot's own stream: CoM and feet", "its centre of mass", "likely",
        "online-replay", "body", entries,
    )  # fmt: skip
    sensors = replace(plan, command="online-replay", kind=f"{plan.kind}; a body stream beside it")
    return [
        Part(sensors, (plan.file.path,), _escaped(plan.file.path.name)),
        Part(other, (body.path,), _escaped(body.path.name)),
    ]


def _common_start(words: Sequence[str]) -> str:
    """The letters that all words begin with."""
    first, last = min(words), max(words)
    return first[: next((i for i, c in enumerate(first) if last[i] != c), len(first))]


def _escaped(name: str) -> str:
    return re.sub(r"[\[\]*]", "?", name)
