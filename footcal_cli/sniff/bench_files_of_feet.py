"""Known weights on the cells of both feet, a file for each foot: cells are called alike in both.

Room: sniff; asked by several.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import Names, escaped
from footcal_cli.sniff.file_names import Part, called
from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.plan import LogPlan


def benches_of_feet(group: Sequence[FileGuess]) -> list[Part]:
    """A plan for each file, its cells under the name of the file's foot; empty without feet."""
    if len(group) < 2:
        return []
    names = Names.of(called([file.path for file in group]))
    sides = names.feet or [name_guess(f"foot_{word.strip('_- .')}").side for word in names.middle]
    if not all(sides) or len({*sides}) < 2:
        return []
    parts = []
    for file, side in zip(group, sides, strict=True):
        plan = plan_of(file)
        made = None if plan is None else _of_foot(plan, side)
        if made is None:
            return []
        parts.append(Part(made, (file.path,), escaped(file.path.name)))
    return parts


def _of_foot(plan: LogPlan, side: str) -> LogPlan | None:
    """A plan for weights on several cells with these under the name of a foot; None for others."""
    if plan.role != "weights" or len(plan.channels) < 2:
        return None
    if any(name_guess(word).side for word in plan.channels):
        return None
    given = {word: f"{side}_{word}" for word in plan.channels}
    channel = plan.entries.get("channel")
    if plan.wide_into == "channel" and {*plan.wide} == {*given}:
        wide = {given[word]: own for word, own in plan.wide.items()}
        return replace(plan, wide=wide, channels=(*given.values(),))
    if channel is None or channel.column is None or channel.names:
        return None
    entries = {**plan.entries, "channel": replace(channel, names=given)}
    return replace(plan, entries=entries, channels=(*given.values(),))
