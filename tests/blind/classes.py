"""Classes of causes that one remedy serves, and names that lie in one of them."""

from __future__ import annotations

from collections.abc import Iterable

LEVEL = ("com_offset", "accel_bias", "imu_tilt", "floor_slope", "cell_position")
CURVES = ("nonlinearity", "nonlinearity_cubic", "saturation", "hinge", "dead_zone")
CREEP = ("creep", "creep_slow")
LATE = ("delay", "lag")
SLOW = (*LATE, "sensor_lag")
"""Streams apart in time, whichever of them it is and by what filter."""
SUM = ("wrong_weight", "load_bypass")
FLIPS = ("axis_flip", "mount_rotation", "sign_flip")
CLASSES = tuple(frozenset(c) for c in (CURVES, LEVEL, CREEP, SLOW, SUM, FLIPS))
"""Causes that one remedy serves."""


def classes_of(names: Iterable[str]) -> int:
    """Number of causes among names, those that one remedy serves counted as one."""
    return len({next((c for c in CLASSES if name in c), frozenset([name])) for name in names})
