"""Lines between the rows that say what holds below: a load, a cell, what was added or removed.

Room: tables; imported by `delimited`, which reads such texts.
"""

from __future__ import annotations

import re

ADDED, REMOVED, ZERO = "added_", "removed_", "zero_"
"""How groups begin that do not say what holds: counted up or down, or that nothing lies there."""


class Carried:
    """What holds for the next row, by the lines read so far.

    Parameters
    ----------
    expression
        Regular expression with named groups; empty for no such lines. Groups called
        ``added_<name>`` and ``removed_<name>`` change the column ``<name>``, which begins at 0;
        where ``zero_<name>`` is found, the column is 0 and the others stay.
    """

    def __init__(self, expression: str) -> None:
        self._between = re.compile(expression) if expression else None
        self.holds: dict[str, str | None] = {
            name: "0" if counted else None for name, counted in _groups(expression).items()
        }

    @property
    def some(self) -> bool:
        """Whether there are such lines."""
        return self._between is not None

    def takes(self, line: str) -> bool:
        """Whether a line is one of them; it holds from here on."""
        found = self._between.search(line) if self._between is not None else None
        if found is None:
            return False
        said = [(*_named(group), word) for group, word in found.groupdict().items()]
        zeros = {name: "0" for name, way, word in said if way == ZERO and word is not None}
        holds = self.holds | zeros
        for name, way, word in said if not zeros else ():
            if not way:
                holds[name] = word
            elif word is not None:
                sign = 1 if way == ADDED else -1
                now = float(holds[name] or 0) + sign * float(word.replace(",", "."))
                holds[name] = f"{now:.10g}"
        self.holds = holds
        return True


def carried_names(expression: str) -> list[str]:
    """Columns that such lines fill."""
    return list(_groups(expression))


def _groups(expression: str) -> dict[str, bool]:
    """Columns by name, and whether their numbers are counted up and down."""
    groups: dict[str, bool] = {}
    for group in re.compile(expression).groupindex if expression else ():
        name, way = _named(group)
        groups[name] = groups.get(name, False) or way in (ADDED, REMOVED)
    return groups


def _named(group: str) -> tuple[str, str]:
    for way in (ADDED, REMOVED, ZERO):
        if group.startswith(way) and group != way:
            return group.removeprefix(way), way
    return group, ""
