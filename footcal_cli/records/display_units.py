"""Units in which people read a quantity: one for all values of a page, whatever the files hold."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite, pi

_READ_IN = {
    "m": (1e3, "mm"),
    "s": (1e3, "ms"),
    "s/s": (1e6, "ppm"),
    "rad": (180.0 / pi, "°"),
    "N²": (1e6, "mN²"),
}
_COARSE_N_PER_COUNT = 0.01
"""From this scale on, that of a coarse converter, a scale is read in mN per count."""

_OF_A_FORCE = 1.3
"""Scales that are all so near one are of forces that something calibrated, in N by their unit."""
_NO_COUNT = 0.5
"""From this scale on readings are hardly counts: volts, or what an amplifier made of them."""


def display_unit(unit: str, values: Iterable[float] = ()) -> tuple[float, str]:
    """Factor and unit in which values of a quantity are read.

    Parameters
    ----------
    unit
        The unit of the files: m, s, s/s, rad, N², N/count; any other stays as it is.
    values
        All values of the quantity on the page, in that unit; only scales ask for them.

    Returns
    -------
    factor, unit
        What a value is multiplied with, and the unit then: 1000 and mm.
    """
    if unit == "N/count":
        sizes = [abs(v) for v in values if isfinite(v)]
        largest = max(sizes, default=0.0)
        if largest and max(largest, 1.0 / max(min(sizes), 1e-300)) < _OF_A_FORCE:
            return 1.0, "N/N"
        if largest >= _NO_COUNT:
            return 1.0, "N per unit read"
        return (1e3, "mN/count") if largest >= _COARSE_N_PER_COUNT else (1e6, "µN/count")
    return _READ_IN.get(unit, (1.0, unit))
