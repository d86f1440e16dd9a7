"""A guess as a recipe with a comment on every line, and as lines for people."""

from __future__ import annotations

import os.path
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

from footcal_cli.sniff.file_names import Part, called
from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.plan import Blank, Entry, of, rate_said
from footcal_cli.sniff.said_mounts import said_mount
from footcal_cli.tables.reading import BLANKS, Layout

_ROBOT, _FEET = "# [robot]", "# [robot.feet."
_DIAGNOSED = {
    "static-init": "stand", "online-replay": "walk", "hang-calib": "hang", "pose-calib": "pose"
}  # fmt: skip
"""What `diagnose` calls the experiment of a command; weights where nothing is said."""
_UNTURNED = (
    "# transducer_rotation_rpy_rad = [0.0, 0.0, 0.0]    # from its frame to the logged foot's"
)
_MOUNTED = (
    "# transducer_position_m = [0.0, 0.0, 0.0]    # in the logged foot frame",
    "# weight_below_n = 0.0    # what hangs below the transducer",
    "# com_below_m = [0.0, 0.0, 0.0]    # its CoM from the transducer, in the transducer's axes",
)
_IF_KNOWN = "# if known: no log says how the transducer is mounted."


def recipe_text(parts: Sequence[Part], target: Path, command_line: str) -> str:
    """The whole recipe."""
    stem = parts[0].paths[0].name.split(".")[0]
    lines = [
        "# Written by footcal init. Every guess says how sure it is: sure, likely, guess.",
        *dict.fromkeys(f"# {p.plan.kind} ({p.plan.sure}: {p.plan.why})" for p in parts),
        f"# Next: {next_step(parts, command_line)}",
        *dict.fromkeys(f"# Check: {warning}" for p in parts for warning in p.plan.warnings),
        f"name = {_quoted(stem)}",
    ]
    root = _data_root(parts, target)
    if root != ".":
        lines.append(f"data_root = {_quoted(root)}    # the folder that holds recipe and logs")
    channels = [c for part in parts for c in part.plan.channels]
    # a name of the log would make the calibration of one recipe that of another robot in the next
    lines += ["", "[robot]", '# name = "…"    # the robot, where several share a laboratory']
    if channels and all(part.plan.role != "placements" for part in parts):
        lines.append(f"channels = [{', '.join(_quoted(c) for c in dict.fromkeys(channels))}]")
    blanks = _each_once([blank for part in parts for blank in part.plan.blanks])
    for blank in blanks:
        if blank.lines[0] == _ROBOT:  # that table stands there already
            lines += [_asked(blank), *blank.lines[1:]]
    tables: dict[str, str] = {}
    for part in parts:
        feet = (f"[robot.feet.{_key(foot)}]\n{_mounted(part, foot)}" for foot in part.plan.feet)
        for table in (*part.plan.robot, *feet):
            tables.setdefault(table.splitlines()[0], table)  # hanging and standing share legs
    lines += [line for line in tables.values() if not line.startswith("[")]
    for table in tables.values():
        if table.startswith("["):
            lines += ["", table]
    for blank in blanks:
        if blank.lines[0] != _ROBOT:
            lines += ["", _asked(blank), *blank.lines]
    several = len(parts) > 1
    written: set[str] = set()
    for part in parts:
        for block in "\n".join(_file_lines(part, several)).split("\n\n"):
            if block not in written:  # a sheet of several cells is described once
                lines += ["", *block.splitlines()]
                written.add(block)
    if not several:
        lines += ["", "[columns]", *_entries(parts[0].plan.entries)]
    lines += ["", "[data]"]
    roles: dict[str, list[str]] = {}
    for part in parts:
        for role in (part.plan.role, *("zeros",) * bool(part.plan.zeros_where)):
            roles.setdefault(role, []).extend(_relative(p, target) for p in part.paths)
    lines += [f"{role} = [{', '.join(map(_quoted, names))}]" for role, names in roles.items()]
    for command in dict.fromkeys(part.plan.command for part in parts if part.plan.options):
        own = (line for p in parts if p.plan.command == command for line in p.plan.options)
        lines += ["", f"[{command.replace('-', '_')}]", *dict.fromkeys(own)]
    if kind := _diagnosed(parts):
        other = "    # or weights" * any(part.plan.role == "weights" for part in parts)
        lines += ["", "[diagnose]", f"experiment = {_quoted(kind)}{other}"]
    return "\n".join(lines) + "\n"


def _each_once(blanks: Sequence[Blank]) -> list[Blank]:
    """What is to be filled in, each table once: logs of the same feet ask for the same places."""
    feet: dict[str, dict[str, dict[str, None]]] = {}
    for blank in blanks:
        table = ""
        for line in blank.lines if blank.lines[0].startswith(_FEET) else ():
            table = line if line.startswith(_FEET) else table
            feet.setdefault(blank.why, {}).setdefault(table, {})[line] = None
    lines = {why: tuple(x for own in tables.values() for x in own) for why, tables in feet.items()}
    return list(dict.fromkeys(
        replace(blank, lines=lines[blank.why]) if blank.lines[0].startswith(_FEET) else blank
        for blank in blanks
    ))  # fmt: skip


def _mounted(part: Part, foot: str) -> str:
    """How the transducer at a foot is mounted, by the forces or the notes, and what is open."""
    own = [part.plan.mounting] if part.plan.mounting else []
    said = said_mount(part.plan.file.text.above, foot).lines()
    own += [line for line in said if not (own and "rotation" in line)]
    asked = [line for line in (_UNTURNED, *_MOUNTED)
             if not any(x.startswith(line[2:].partition(" ")[0]) for x in own)]  # fmt: skip
    if part.plan.mounting:
        asked = [line for line in asked if line is not _UNTURNED]
    return "\n".join([*own, *((_IF_KNOWN, *asked) if asked else ())])


def _diagnosed(parts: Sequence[Part]) -> str:
    """What `diagnose` calls the one experiment next to weights; empty for several, and weights."""
    commands = {part.plan.command for part in parts} - {"offline-fit"}
    if not commands and any(part.plan.role == "placements" for part in parts):
        return "placements"
    return _DIAGNOSED.get(commands.pop(), "") if len(commands) == 1 else ""


def _asked(blank: Blank) -> str:
    return f"# {'TO FILL IN' if blank.needed else 'if known'}: {blank.why}."


def next_step(parts: Sequence[Part], command_line: str) -> str:
    """The exact command, after what is to be filled in; weights first, whose scales others need."""
    plan = min(
        (part.plan for part in parts),
        key=lambda plan: (plan.command != "offline-fit", plan.command == "pose-calib"),
    )
    command = f"footcal {plan.command} {command_line}"
    wanted = _wanted(parts, plan.command)
    said = f"fill in what is marked TO FILL IN ({wanted}), then " if wanted else ""
    after = ""
    for name in dict.fromkeys(p.plan.command for p in parts if p.plan.command != plan.command):
        open_yet = _wanted(parts, name)
        to_do = f", what is marked TO FILL IN filled in ({open_yet})" if open_yet else ""
        after += f"; after it {name}, with its parameters.json{to_do}"
    if plan.command == "offline-fit" and (kind := _diagnosed(parts)):
        last = "with the parameters.json written last"
        after += f"; then diagnose (experiment {kind}), {last}, says what the model lacks"
    return f"{said}{command}{after}"


def _wanted(parts: Sequence[Part], command: str) -> str:
    """What the logs of a command leave open, each once."""
    plans = (part.plan for part in parts if part.plan.command == command)
    return "; ".join(dict.fromkeys(b.why for own in plans for b in own.blanks if b.needed))


def _file_lines(part: Part, several: bool) -> list[str]:
    """The entries of ``[[files]]`` for a kind of log and what is joined to it."""
    plan = part.plan
    lines: list[str] = []
    own = _layout_lines(plan.file)
    if plan.rate_hz is not None:
        known = rate_said(plan.file) == plan.rate_hz
        why = "likely: as said above the table" if known else "guess: the log has no time stamps"
        why = "likely: the usual step of its stamps" if plan.file.of("time") else why
        own.append(f"rate_hz = {plan.rate_hz:g}    # {why}")
    if plan.zeros_where:
        texts = {c: _list(t) if t[1:] else _quoted(t[0]) for c, t in plan.zeros_where.items()}
        rows = ", ".join(f"{_key(column)} = {text}" for column, text in texts.items())
        own.append(f"zeros_where = {{ {rows} }}    # likely: nothing on the cells")
    for beside in part.beside:
        offset = f", offset_s = {beside.offset_s!r}" if beside.offset_s else ""
        if beside.how:
            offset += f", how = {_quoted(beside.how)}, tolerance_s = {beside.tolerance_s:g}"
            offset += f", apart_s = {beside.apart_s:g}" * bool(beside.apart_s)
        if beside.only_where:
            offset += f", only_where = {_table(beside.only_where)}"
        apart = beside.file.path.parent != part.paths[0].parent
        place = Path(os.path.relpath(beside.file.path, part.paths[0].parent))
        name = _quoted(place.as_posix() if apart else beside.file.path.name)
        one = f"{{ file = {name}, by = {_quoted(beside.by)}{offset} }}"
        own.append(f"join = [{one}]    # {beside.why}")
    if len(part.beside) > 1:
        joins = [line for line in own if line.startswith("join = ")]
        own = [line for line in own if not line.startswith("join = ")]
        inner = ",\n    ".join(line.split("[", 1)[1].rsplit("]", 1)[0] for line in joins)
        own.append(f"join = [    # {part.beside[0].why}\n    {inner},\n]")
    if own or several or plan.wide:
        lines += ["[[files]]", f"match = {_quoted(part.match)}", *own]
    if plan.wide:
        lines.append(f"wide_into = {_quoted(plan.wide_into)}    # a row for every entry of wide")
    if several:
        lines += ["[files.columns]", *_entries(plan.entries)]
    for entry, columns in plan.wide.items():
        lines += [f"[files.wide.{_key(entry)}]", *_entries(columns)]
    for beside in part.beside:
        other = beside.file
        times, own_lines = other.of("time"), [*_layout_lines(other)]
        name = called([other.path, *part.paths])[0]
        if not (own_lines or times or fnmatch(name, part.match)):
            continue
        joined = ["[[files]]", f"match = {_quoted(name)}", *own_lines]
        if times:
            joined += ["[files.columns]", *_entries({"time_s": of(times[0])})]
        # the first entry that matches a file is its own
        lines = [*joined, "", *lines] if fnmatch(name, part.match) else [*lines, "", *joined]
    return lines


def _layout_lines(file: FileGuess) -> list[str]:
    """Lines of a layout that is no plain CSV."""
    layout, plain = file.layout, Layout()
    lines = []
    if layout.line:
        lines.append(f"line = {_literal(layout.line)}    # every line that it finds itself in")
    if layout.carried:
        lines.append(f"carried = {_literal(layout.carried)}    # holds for the rows below")
    if file.rows_of:
        lines.append(f"rows_of = {_quoted(file.rows_of)}    # topics take turns in the table")
    if layout.pivot is not None:
        by, labels = map(_list, (layout.pivot.by, layout.pivot.labels))
        at = f", at = {_quoted(layout.pivot.at)}" if layout.pivot.at else ""
        at += f", held = {_list(layout.pivot.held)}" if layout.pivot.held else ""
        lines.append(f"pivot = {{ by = {by}, labels = {labels}{at} }}    # one row per sample")
    if layout.separator != plain.separator:
        name = {BLANKS: "space", "\t": "tab"}.get(layout.separator, layout.separator)
        lines.append(f"separator = {_quoted(name)}")
    for key in ("decimal", "thousands", "encoding", "comment"):
        value = getattr(layout, key)
        if value != getattr(plain, key):
            lines.append(f"{key} = {_quoted(value)}")
    if layout.skip_rows:
        lines.append(f"skip_rows = {layout.skip_rows}    # above the header")
    if not layout.header:
        lines.append("header = false")
    if layout.names:
        lines.append(f"names = {_list(layout.names)}")
    if layout.row_lasts > 1:
        lines.append(f"row_lasts = {layout.row_lasts}    # likely: each row is a stance")
    if layout.turned:
        lines.append("turned = true    # each line begins with its name")
    if layout.until:
        lines.append(f"until = {_quoted(layout.until)}    # the table ends above it")
    if layout.skip_below:
        lines.append(f"skip_below = {layout.skip_below}    # units")
    return lines


def _entries(entries: Mapping[str, Entry]) -> list[str]:
    return [f"{_key(name)} = {_place(entry)}    # {entry.sure}: {entry.why}"
            for name, entry in entries.items()]  # fmt: skip


def _place(entry: Entry) -> str:
    said = [] if entry.column is None else [f"column = {_quoted(entry.column.column)}"]
    for key, written in _WRITTEN.items():
        # what is corrected of a guess stands in the entry, the rest in the guess alone
        value = getattr(entry, key) if hasattr(entry, key) else getattr(entry.column, key, None)
        if value:
            said.append(f"{key} = {written(value)}")
    if len(said) == 1 and entry.column is not None:
        return _quoted(entry.column.column)
    return f"{{ {', '.join(said)} }}"


def _number_or_text(value: str) -> str:
    return value if value.replace(".", "", 1).lstrip("-").isdigit() else _quoted(value)


def _list(texts: Sequence[str]) -> str:
    return f"[{', '.join(map(_quoted, texts))}]"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\t", "\\t")
    return f'"{escaped}"'


def _literal(text: str) -> str:
    return f"'{text}'" if "'" not in text else _quoted(text)


def _key(name: str) -> str:
    plain = all(c.isascii() and (c.isalnum() or c in "_-") for c in name)
    return name if plain and name else _quoted(name)


def _table(pairs: Mapping[str, str], key: Callable[[str], str] = _key) -> str:
    return f"{{ {', '.join(f'{key(a)} = {_quoted(b)}' for a, b in pairs.items())} }}"


_WRITTEN: Mapping[str, Callable[[Any], str]] = {
    "followed_by": _quoted, "value": _number_or_text, "file_name": _literal, "unit": _quoted,
    "factor": str,
    "format": _quoted, "wraps_at": "{:.0f}".format, "summed": lambda _: "true", "plus": _table,
    "minus": _quoted, "add": "{:.15g}".format,
    "high_word": _quoted, "over": _quoted, "nanoseconds": _quoted,
    "names": lambda names: _table(names, _quoted), "only_where": _table, "missing": _list,
    "held": lambda _: "true", "pattern": _literal,
}  # fmt: skip
"""Keys of a place -> how their values are written, in this order."""


def _relative(path: Path, target: Path) -> str:
    return Path(os.path.relpath(path.resolve(), target.resolve().parent)).as_posix()


def _data_root(parts: Sequence[Part], target: Path) -> str:
    """The folder, seen from the recipe, that its paths must not leave."""
    folder = target.resolve().parent
    logs = [path.resolve().parent for part in parts for path in part.paths]
    common = Path(os.path.commonpath([folder, *logs]))
    return Path(os.path.relpath(common, folder)).as_posix()
