"""Lines between the rows that say what holds below: a load, a cell, what was added or removed.

Room: tables; imported by `delimited`, which reads such texts.
"""

from __future__ import annotations

import re

ADDED, REMOVED = "added_", "removed_"
"""How groups begin whose numbers are counted up and down instead of replacing what held."""


class Carried:
    """What holds for the next row, by the lines read so far.

    Parameters
    ----------
    expression
        Regular expression with named groups; empty for no such lines. Groups called
        ``added_<name>`` and ``removed_<name>`` change the column ``<name>``, which begins at 0.
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
        holds = dict(self.holds)
        for group, said in found.groupdict().items():
            name, sign = _named(group)
            if not sign:
                holds[name] = said
            elif said is not None:
                now = float(holds[name] or 0) + sign * float(said.replace(",", "."))
                holds[name] = f"{now:.10g}"
        self.holds = holds
        return True


def carried_names(expression: str) -> list[str]:
    """Columns that such lines fill."""
    return list(_groups(expression))


def _groups(expression: str) -> dict[str, bool]:
    """Columns by name, and whether their numbers are counted up and down."""
    groups = re.compile(expression).groupindex if expression else {}
    return {name: bool(sign) for name, sign in map(_named, groups)}


def _named(group: str) -> tuple[str, int]:
    for start, sign in ((ADDED, 1), (REMOVED, -1)):
        if group.startswith(start) and group != start:
            return group.removeprefix(start), sign
    return group, 0
