"""The commands, one file each: read -> core -> write, no mathematics."""

from __future__ import annotations

from pkgutil import iter_modules

_NOT_COMMANDS = frozenset({"helptexts", "options"})


def option_tables() -> frozenset[str]:
    """Names of the option tables that a recipe may hold: one per command, named after it."""
    return frozenset(m.name for m in iter_modules(__path__)) - _NOT_COMMANDS
