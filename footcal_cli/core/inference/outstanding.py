"""Candidates that stand out though a variance is estimated that they swell themselves.

Few blocks tell of the variance between them: an effect would pass for poor repeatability for most
of its size. A candidate that stands out even so, the variance estimated beside it as in a t-test,
is fitted while the variance is estimated.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy import stats

from footcal_cli.core.parameters import FloatArray

MOST_SUSPECTS = 3
"""Candidates that may be taken for effects while variances are estimated."""
RARE = 0.05
"""Probability with which the best of all candidates explains that much of noise."""
SHARES = (1.0, 0.05)
"""Of the variances, at which the strongest candidate is suspected: one that made a variance large
is hidden by it, and another stands out in its place."""
_INSIDE = 1e-8  # share of a column's square that a base leaves, below which it leaves none


def strongest(score: FloatArray, own: FloatArray, whole: FloatArray) -> tuple[int, float]:
    """Which candidate has the largest ``|z| = |g̃·r̃| / |g̃|``, and that.

    Parameters
    ----------
    score, own, whole
        ``g̃·r̃``, ``|g̃|²`` and ``|g|²`` of each, g̃ what a base leaves of g.
    """
    z = np.abs(score) / np.sqrt(np.where(own > _INSIDE * whole, own, np.inf))
    best = int(np.argmax(z))
    return best, float(z[best])


def outstanding(tested: Mapping[int, float], among: int) -> int | None:
    """The suspect with the largest |z| if the best of so many candidates rarely has it by chance.

    Parameters
    ----------
    tested
        Suspect -> |z|, the variance estimated beside it.
    among
        Of how many candidates the suspects were the strongest.
    """
    best = max(sorted(tested), key=lambda suspect: tested[suspect])
    return best if tested[best] > float(stats.norm.isf(0.5 * RARE / among)) else None
