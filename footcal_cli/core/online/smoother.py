"""The best estimate after the fact: Rauch-Tung-Striebel smoothing of the filter's history."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.inference.kalman import smooth_back
from footcal_cli.core.online.compiled import kalman_loops
from footcal_cli.core.online.filter import Track, track_of
from footcal_cli.core.online.jumps import BiasJump
from footcal_cli.core.online.noise import Guards, WalkNoise
from footcal_cli.core.online.passes import FilterOutput, Pass
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.parameters import FloatArray

STRETCH = 500
"""Updates whose history is held at once (20 MB for a biped)."""


def run_smoother(
    rows: Rows,
    noise: WalkNoise,
    guards: Guards,
    known_jumps: Sequence[BiasJump] = (),
    *,
    begun: Pass | None = None,
    fast: bool = True,
) -> Track:
    """Every state given the whole walk, the history of one stretch in memory at a time.

    ``x̂ₖ|N = x̂ₖ + Cₖ (x̂ₖ₊₁|N − x̂ₖ₊₁|k)``, ``Cₖ = Pₖ Φᵀ P⁻¹ₖ₊₁|k`` (Rauch, Tung, Striebel,
    AIAA Journal 3, 1965).
    The filter runs forwards and leaves its state at the start of every stretch; backwards, each
    stretch is filtered again with its history and smoothed.

    Parameters
    ----------
    rows, noise, guards, known_jumps, fast
        As `footcal_cli.core.online.filter.run_filter`; other jumps are not looked for, since a
        correction is not a transition.
    begun
        A pass that has come to the first of the rows, `known_jumps` opened; the prior where None.
    """
    whole = begun or Pass.begin(rows, noise, known_jumps)
    starts = range(0, len(rows), STRETCH)
    pieces, states = [], []
    for start in starts:
        part = whole.part(start, start + STRETCH)
        states.append((part.mean.copy(), part.cov.copy()))
        pieces.append(part.run(rows.part(start, start + STRETCH), guards, fast=fast))
        whole.mean, whole.cov = part.mean, part.cov
    track = track_of(rows, whole, FilterOutput.joined(pieces), None)
    values, variance = np.empty(track.values.shape), np.empty(track.values.shape)
    seen = whole.tuned.seen
    momentary = np.empty((len(rows), seen.size))
    p = len(rows.names)
    ahead = (whole.mean, whole.cov)
    later: tuple[FloatArray, FloatArray] | None = None
    for start, state in zip(reversed(starts), reversed(states), strict=True):
        part = whole.part(start, start + STRETCH)
        part.mean, part.cov = state
        found = part.run(rows.part(start, start + STRETCH), guards, keep_history=True, fast=fast)
        mean, cov = found.past_mean.copy(), found.past_cov.copy()
        if later is not None:
            decay = whole.decay[start + STRETCH]
            mean[-1], cov[-1] = smooth_back(mean[-1], cov[-1], decay, ahead, later)
        _back(mean, cov, found, part.decay, fast=fast)
        cut = slice(start, start + STRETCH)
        values[cut], momentary[cut] = mean[:, :p], mean[:, seen]
        variance[cut] = np.diagonal(cov, axis1=1, axis2=2)[:, :p]
        ahead, later = (found.ahead_mean[0], found.ahead_cov[0]), (mean[0], cov[0])
    return replace(
        track,
        values=values * rows.prior_sd,
        sd=np.sqrt(np.clip(variance, 0.0, None)) * rows.prior_sd,
        momentary=momentary if seen.size else None,
    )


def _back(
    mean: FloatArray, cov: FloatArray, past: FilterOutput, decay: FloatArray, *, fast: bool
) -> None:
    """Smooth in place from the last update, smoothed already, to the first."""
    loops = kalman_loops() if fast else None
    if loops is not None:
        loops.smooth_walk(mean, cov, past.past_cov, past.ahead_mean, past.ahead_cov, decay)
        return
    for j in range(len(mean) - 2, -1, -1):
        ahead, later = (past.ahead_mean[j + 1], past.ahead_cov[j + 1]), (mean[j + 1], cov[j + 1])
        mean[j], cov[j] = smooth_back(mean[j], cov[j], decay[j + 1], ahead, later)
