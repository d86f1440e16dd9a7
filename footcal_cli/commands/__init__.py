"""The commands, one file each: read -> core -> write, no mathematics."""

from __future__ import annotations

from pkgutil import iter_modules

_NOT_COMMANDS = frozenset(
    {
        "options",
        "bench_logs",
        "bench_report",
        "bench_outcome",
        "diagnose_cases",
        "six_axis_logs",
        "pose_outcome",
        "pose_series",
        "apply_legs",
        "apply_cells",
    }
)


def option_tables() -> frozenset[str]:
    """Names of the option tables a recipe may hold: one per command, its module's name."""
    return frozenset(m.name for m in iter_modules(__path__)) - _NOT_COMMANDS
