"""Tails and quantiles of the usual distributions, made of special functions alone.

Equal to those of `scipy.stats`, without the third of a second that its import takes. Every
function takes numbers or arrays, which are broadcast; a freedom that is not above 0 gives NaN.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import special

from footcal_cli.core.parameters import FloatArray, IntArray

Numbers = float | FloatArray | IntArray


def chi2_sf(x: Numbers, freedom: Numbers) -> Any:
    """``P(χ² > x)`` with so many degrees of freedom."""
    return _known(special.chdtrc(freedom, np.maximum(x, 0.0)), freedom)


def chi2_cdf(x: Numbers, freedom: Numbers) -> Any:
    """``P(χ² ≤ x)``."""
    return _known(special.chdtr(freedom, np.maximum(x, 0.0)), freedom)


def chi2_isf(p: Numbers, freedom: Numbers) -> Any:
    """The x of ``P(χ² > x) = p``."""
    return _known(special.chdtri(freedom, p), freedom)


def chi2_ppf(p: Numbers, freedom: Numbers) -> Any:
    """The x of ``P(χ² ≤ x) = p``."""
    return _known(2.0 * special.gammaincinv(np.asarray(freedom) / 2.0, p), freedom)


def ncx2_cdf(x: Numbers, freedom: Numbers, excess: Numbers) -> Any:
    """``P(χ² ≤ x)`` of the non-central χ²."""
    return _known(special.chndtr(np.maximum(x, 0.0), freedom, excess), freedom)


def f_sf(x: Numbers, above: Numbers, below: Numbers) -> Any:
    """``P(F > x)`` with so many degrees of freedom above and below the line."""
    return _known(special.fdtrc(above, below, np.maximum(x, 0.0)), above, below)


def f_ppf(p: Numbers, above: Numbers, below: Numbers) -> Any:
    """The x of ``P(F ≤ x) = p``."""
    return _known(special.fdtri(above, below, p), above, below)


def t_sf(x: Numbers, freedom: Numbers) -> Any:
    """``P(t > x)`` of Student's t."""
    return _known(special.stdtr(freedom, np.negative(x)), freedom)


def t_logcdf(x: Numbers, freedom: Numbers) -> Any:
    """``ln P(t ≤ x)``."""
    below, above = special.stdtr(freedom, x), special.stdtr(freedom, np.negative(x))
    with np.errstate(divide="ignore"):
        return _known(np.where(below > 0.5, np.log1p(-above), np.log(below))[()], freedom)


def t_ppf(p: Numbers, freedom: Numbers) -> Any:
    """The x of ``P(t ≤ x) = p``."""
    return _known(special.stdtrit(freedom, p), freedom)


def norm_sf(x: Numbers) -> Any:
    """``P(z > x)`` of a Gaussian of sd one."""
    return special.ndtr(np.negative(x))


def norm_isf(p: Numbers) -> Any:
    """The x of ``P(z > x) = p``."""
    return -special.ndtri(p)


def norm_ppf(p: Numbers) -> Any:
    """The x of ``P(z ≤ x) = p``."""
    return special.ndtri(p)


def cauchy_logpdf(x: Numbers, scale: Numbers) -> Any:
    """``ln [1 / (π s (1 + x²/s²))]``."""
    ratio = np.asarray(x) / scale
    with np.errstate(divide="ignore"):
        return np.log(1.0 / np.pi / (1.0 + ratio * ratio)) - np.log(scale)


def _known(found: Any, *freedom: Numbers) -> Any:
    """NaN where a freedom is none."""
    some = np.all([np.greater(f, 0.0) for f in np.broadcast_arrays(*freedom)], axis=0)
    return found if np.all(some) else np.where(some, found, np.nan)[()]
