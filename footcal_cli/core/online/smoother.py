"""The best estimate after the fact: Rauch-Tung-Striebel smoothing of the filter's history."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.core.online.compiled import kalman_loops
from footcal_cli.core.online.filter import Track
from footcal_cli.core.online.kalman import smooth_back


def smooth(track: Track, *, fast: bool = True) -> Track:
    """Every state given the whole walk.

    ``x̂ₖ|N = x̂ₖ + Cₖ (x̂ₖ₊₁|N − x̂ₖ₊₁|k)``, ``Cₖ = Pₖ Φᵀ P⁻¹ₖ₊₁|k`` (Rauch, Tung, Striebel,
    AIAA Journal 3, 1965).

    Parameters
    ----------
    track
        From `footcal_cli.core.online.filter.run_filter` with ``keep_history=True`` and, where it
        found jumps, filtered again with these known: a correction is not a transition.
    fast
        Use compiled loops where they are at hand.
    """
    past = track.history
    if past is None:
        raise ValueError("this track has no history: filter with keep_history=True")
    if track.jumps:
        raise ValueError("filter again with the jumps as known_jumps before smoothing")
    mean, cov = past.mean.copy(), past.covariance.copy()
    p = past.scale.size
    loops = kalman_loops() if fast else None
    if loops is not None:
        loops.smooth_walk(
            mean, cov, past.covariance, past.mean_ahead, past.covariance_ahead, past.decay
        )
    else:
        for j in range(len(mean) - 2, -1, -1):
            ahead = (past.mean_ahead[j + 1], past.covariance_ahead[j + 1])
            later = (mean[j + 1], cov[j + 1])
            mean[j], cov[j] = smooth_back(mean[j], cov[j], past.decay[j + 1], ahead, later)
    variance = np.diagonal(cov, axis1=1, axis2=2)[:, :p]
    return replace(
        track,
        values=mean[:, :p] * past.scale,
        sd=np.sqrt(np.clip(variance, 0.0, None)) * past.scale,
        momentary=mean[:, past.own] if past.own.size else None,
        history=None,
    )
