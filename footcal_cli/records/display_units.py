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

_NO_COUNT = 1.0
"""From this scale on readings are hardly counts: volts, or forces that something calibrated."""


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
        largest = max((abs(v) for v in values if isfinite(v)), default=0.0)
        if largest >= _NO_COUNT:
            return 1.0, "N per unit read"
        return (1e3, "mN/count") if largest >= _COARSE_N_PER_COUNT else (1e6, "µN/count")
    return _READ_IN.get(unit, (1.0, unit))
