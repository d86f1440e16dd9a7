"""Whether compiled loops are at hand (``pip install 'footcal[fast]'``)."""

from __future__ import annotations

from types import ModuleType


def kalman_loops() -> ModuleType | None:
    """`footcal_cli.core.online.kalman_loops`, or None without numba."""
    try:
        from footcal_cli.core.online import kalman_loops
    except ImportError:
        return None
    return kalman_loops
