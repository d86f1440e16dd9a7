"""Values that no motion of a body has: of a broken link, or marks for *no reading*."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.quality import Finding

IMPOSSIBLE = 1e6
"""No position, acceleration, angle or moment of a body lies so many SI units from the usual one."""


def find_impossible(values: FloatArray) -> BoolArray:
    """Values beyond all sense, shape (n,)."""
    far = np.abs(values) > IMPOSSIBLE
    if far.any():  # a map's coordinates are large, and all alike
        far = np.abs(values - np.nanmedian(values)) > IMPOSSIBLE
    return far


def check_impossible(values: FloatArray, where: str) -> list[Finding]:
    """Say how many values of a column, shape (n,), are beyond all sense."""
    far = values[find_impossible(values)]
    if not far.size:
        return []
    return [
        Finding(
            "impossible_values", "warning", where,
            f"{far.size} of {values.size} values are beyond all that a body can do, "
            f"{far[0]:.4g} for one: they count as lost",
            "check the link and the logger",
        )
    ]  # fmt: skip
