"""Whether groups of readings have lines of their own: F tests against what they could share.

Room: bench (`footcal_cli.core.bench`), used by `footcal_cli.sniff.which_cell`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import FloatArray, IntArray

_RCOND = 1e-12
_LEAST = 3
"""Readings of a group from which a line has a residual."""


@dataclass(frozen=True)
class SplitLines:
    """What lines of their own explain beyond shared ones.

    Parameters
    ----------
    variance
        Residual variance under a line per group, in squared units of the readings.
    one_line, one_zero, one_slope
        Chance of so large an F if all groups shared a line, their zero or their slope.
    """

    variance: float
    one_line: float
    one_zero: float
    one_slope: float


def split_lines(force: FloatArray, read: FloatArray, codes: IntArray) -> SplitLines | None:
    r"""Compare :math:`y = a_g + b_g F` with a shared line, a shared zero and a shared slope.

    Parameters
    ----------
    force, read
        Loads and readings, shape (n,); rows without either are left out.
    codes
        Group of each row, shape (n,), negative where none is named.

    Returns
    -------
    SplitLines | None
        None where a row has no group, or a group too few rows or one load alone.
    """
    from scipy.special import fdtrc

    if codes.size != force.size:
        return None
    good = np.isfinite(force) & np.isfinite(read)
    x, y, groups = force[good], read[good], codes[good]
    names = np.unique(groups)
    each = [x[groups == name] for name in names]
    if len(names) < 2 or groups.min() < 0:
        return None
    if any(own.size < _LEAST or np.ptp(own) == 0 for own in each):
        return None
    zeros = (groups[:, None] == names).astype(np.float64)
    slopes = zeros * x[:, None]
    one = np.ones_like(x)
    free = y.size - 2 * len(names)
    # no residual is below the rounding of the readings themselves
    rounding = free * (np.finfo(np.float64).eps * float(np.abs(y).max())) ** 2
    own_lines = max(_residual(np.hstack([zeros, slopes]), y), rounding)
    if own_lines == 0:
        return None

    def chance(design: FloatArray) -> float:
        fewer = 2 * len(names) - design.shape[1]
        ratio = max(_residual(design, y) - own_lines, 0.0) / fewer / (own_lines / free)
        return float(fdtrc(fewer, free, ratio))

    return SplitLines(
        own_lines / free, chance(np.column_stack([one, x])),
        chance(np.column_stack([one, slopes])), chance(np.column_stack([zeros, x])),
    )  # fmt: skip


def _residual(design: FloatArray, y: FloatArray) -> float:
    """Sum of squares that a linear model leaves of y, shape (n,)."""
    from footcal_cli.core.inference.linear import left_by

    return float(np.sum(left_by(design, y, _RCOND) ** 2))
