"""Groups of logs: of the same columns, or of one foot each: ``hidari_1`` and ``migi_1``.

Room: sniff; asked by several.
"""

from __future__ import annotations

from collections.abc import Sequence

from footcal_cli.sniff.clocks import one_after_another
from footcal_cli.sniff.groups import readings, wrenches
from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.numbered import numbered


def groups_of(files: Sequence[FileGuess]) -> list[list[FileGuess]]:
    """Logs of the same layout and columns together, and both feet on one clock."""
    alike: dict[object, list[FileGuess]] = {}
    for file in files:
        names = tuple(c.column for c in file.columns)
        alike.setdefault((file.layout, names), []).append(file)
    groups = list(alike.values())
    single = [group[0] for group in groups if len(group) == 1]
    feet = {foot: [file for file in single if _foot(file) == foot] for foot in ("left", "right")}
    both = [own[0] for own in feet.values() if len(own) == 1]
    if len(both) < len(feet) or len({len(readings(file)) for file in both}) > 1:
        return groups
    if one_after_another(both):
        return groups
    return [both, *(group for group in groups if all(group[0] is not file for file in both))]


def _foot(file: FileGuess) -> str:
    """The foot that all cells of a log with stamps are under; empty where there is no such one."""
    if not file.of("time") or file.of("load", "label", "com") or wrenches(numbered(file)):
        return ""
    cells = readings(file)
    sides = {c.name.side for c in cells}
    return sides.pop() if len(sides) == 1 < len(cells) else ""
