"""What init says of each log: what every column was taken for, a line each.

Room: sniff; called by the command init.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.plan import Entry, LogPlan
from footcal_cli.tables.columns import body_table


def listing(parts: Sequence[Part]) -> list[str]:
    """What every column was taken for, a line each; of logs of one kind what differs."""
    lines: list[str] = []
    said: dict[object, set[str]] = {}
    for part in parts:
        own = _listed(part)
        columns = tuple(c.column for c in part.plan.file.columns)
        before = said.setdefault((part.plan.kind, columns), set())
        lines += [line for line in own if line not in before]
        before |= {*own}
    return lines


def _listed(part: Part) -> list[str]:
    """The lines of one kind of log."""
    lines: list[str] = []
    alike = len(part.paths) - 1
    for file in (part.plan.file, *(b.file for b in part.beside)):
        said = "; ".join(file.text.said)
        rate = f", {file.rate_hz:.4g} Hz" if file.rate_hz else ""
        lines.append(f"{file.path.name}: {file.rows} rows{rate}" + (f"; {said}" if said else ""))
        if alike and file is part.plan.file:
            lines.append(f"  and {alike} more like it")
    lines.append(f"  {part.plan.sure}: {part.plan.kind}, by {part.plan.why}")
    used: dict[str, tuple[str, Entry]] = {}
    choosing: set[str] = set()
    on_top: dict[str, str] = {}
    behind: dict[str, str] = {}
    zeros: dict[str, str] = {}
    for name, entry in _all_entries(part.plan):
        choosing |= set(entry.only_where)
        if entry.column is not None:
            first = used.get(entry.column.column)
            both = name if first is None else f"{first[0]}, {name}"
            used[entry.column.column] = (both, entry)
            below = entry.column.column
            on_top |= {c: f"{below} in {unit}" for c, unit in entry.column.plus.items()}
            behind |= {entry.column.followed_by: below}
            zeros |= {entry.column.minus: below}
        elif entry.file_name is not None:
            lines.append(f"  {name}: from the file's name ({entry.why})")
        elif entry.value is not None and entry.sure == "guess":
            lines.append(f"  {name} = {entry.value}   guess: {entry.why}")
    for column in part.plan.file.columns:
        if column.column in used:
            name, entry = used.pop(column.column)
            unit = f" in {entry.unit}" if entry.unit else ""
            lines.append(f"  {column.column} -> {name}{unit}   {entry.sure}: {entry.why}")
        elif column.column in _read_anyway(part.plan):
            lines.append(f"  {column.column} -> read as it stands   sure: its name")
        elif column.column in on_top:
            lines.append(f"  {column.column} -> on top of {on_top[column.column]}")
        elif column.column in zeros:
            lines.append(f"  {column.column} -> taken from {zeros[column.column]}")
        elif column.column in behind:
            lines.append(f"  {column.column} -> behind {behind[column.column]}")
        elif column.column in part.plan.zeros_where:
            text = " or ".join(part.plan.zeros_where[column.column])
            lines.append(f"  {column.column} -> zeros where it is {text}   likely: no cell "
                         "carries anything there")  # fmt: skip
        elif column.column in choosing:
            lines.append(f"  {column.column} -> which of them the load lies on")
        else:
            what = "not recognised" if column.quantity == "unknown" else column.quantity
            lines.append(f"  {column.column} -> not used   ({what}: {column.why})")
    for source, (name, entry) in used.items():
        lines.append(f"  {source} -> {name}   {entry.sure}: {entry.why}")
    lines += [f"  check: {warning}" for warning in part.plan.warnings]
    return lines


def _read_anyway(plan: LogPlan) -> set[str]:
    """Columns of the body's stream that bear footcal's own names and need no entry."""
    names = {column.column for column in plan.file.columns}
    feet = dict.fromkeys(name.partition("_foot_")[0] for name in names if "_foot_" in name)
    return names & {column.name for column in body_table(tuple(feet)).columns}


def _all_entries(plan: LogPlan) -> Iterator[tuple[str, Entry]]:
    yield from plan.entries.items()
    for entry, own in plan.wide.items():
        for name, place in own.items():
            yield f"{entry}: {name}", place
