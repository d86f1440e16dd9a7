"""The sliding window and the static assumption on one walk, each with weights of its own.

Nothing that memory found is used: the delay is the recipe's, the CoM and L̇ are the log's. ωF and
ωP come from the quiet standing before the first step ([NAO], section 3.3.2); ωS is, for each of
the two, the one whose held parameters predict best what the motion demands.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N, Reference
from footcal_cli.core.experiments import walk
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.evidence import rms
from footcal_cli.core.online.replay import Replayed, corrected, errors_against, held_until_next
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.study.window import (
    Weights,
    WindowRule,
    WindowTrack,
    run_window,
    run_window_fast,
    standing_weights,
)

SMOOTH_CANDIDATES = np.geomspace(1e1, 1e8, 15)
QUIET_S = 0.5
"""Standing that ωF and ωP need."""


def replay_window(
    method: str,
    log: Log,
    belief: Belief,
    track: WindowTrack,
    setting: int = 0,
    min_force_n: float = MIN_FORCE_N,
) -> Replayed:
    """Forces and CoP along the paper's window."""
    n = len(log)
    gain = held_until_next(track.last_sample, track.gain[:, setting], n)
    bias = held_until_next(track.last_sample, track.bias_n[:, setting], n)
    return corrected(method, log, belief, gain, bias, min_force_n=min_force_n)


def best_smoothing(
    log: Log,
    belief: Belief,
    weights: Weights,
    truth: Replayed | Reference,
    candidates: FloatArray,
    rule: WindowRule | None = None,
    *,
    static: bool = False,
) -> tuple[float, WindowTrack]:
    """The ωS with the least CoP error, and the paper's window run exactly with it.

    Parameters
    ----------
    candidates
        Values of ωS to try, in one batched pass of the fast window.
    """
    rule = rule or WindowRule()
    many = Weights(weights.force, weights.cop, candidates)
    tried = run_window_fast(log, belief, many, rule, static=static)
    scores = [
        rms(
            errors_against(
                replay_window("window", log, belief, tried, b, rule.min_force_n), truth
            ).cop_m
        )
        for b in range(candidates.size)
    ]
    best = float(candidates[int(np.argmin(scores))])
    exact = run_window(log, belief, Weights(weights.force, weights.cop, best), rule, static=static)
    return best, exact


@dataclass(frozen=True)
class GivenWeights:
    """Weights that a recipe gives; None for those that the log must give."""

    force: float | None = None
    cop: float | None = None
    smooth: float | None = None


@dataclass(frozen=True)
class Windowed:
    """One of the two methods on a walk: its weights, and the forces and CoP it makes."""

    weights: Weights
    replayed: Replayed


def run_windows(
    log: Log, belief: Belief, methods: Sequence[str], rule: WindowRule, given: GivenWeights
) -> dict[str, Windowed]:
    """Run ``window`` and ``static`` as asked; none where nothing gives ωF and ωP.

    Parameters
    ----------
    methods
        Which of ``window`` and ``static`` to run.
    given
        Weights that are not to be chosen.
    """
    base = _standing(log, belief, rule, given)
    if base is None:
        return {}
    demand = walk.reference_of(log)
    found = {}
    for method in methods:
        static = method == "static"
        smooth = given.smooth
        if smooth is None:
            smooth, track = best_smoothing(
                log, belief, base, demand, SMOOTH_CANDIDATES, rule, static=static
            )
            weights = Weights(base.force, base.cop, smooth)
        else:
            weights = Weights(base.force, base.cop, smooth)
            track = run_window(log, belief, weights, rule, static=static)
        replayed = replay_window(method, log, belief, track, min_force_n=rule.min_force_n)
        found[method] = Windowed(weights, replayed)
    return found


def _standing(log: Log, belief: Belief, rule: WindowRule, given: GivenWeights) -> Weights | None:
    """ωF and ωP, given or from quiet standing; None where there is too little of it."""
    if given.force is not None and given.cop is not None:
        return Weights(given.force, given.cop, 1.0)
    quiet = standing_start(log)
    if quiet is None:
        return None
    own = standing_weights(log.rows(*quiet), belief, rule)
    return Weights(given.force or own.force, given.cop or own.cop, 1.0)


def standing_start(log: Log) -> tuple[int, int] | None:
    """Rows of the standing before the first step, None where it is shorter than `QUIET_S`."""
    standing = np.asarray((log.known["contact"] == 1.0).all(axis=1))
    usable = np.asarray(np.isfinite(log.readings).all(axis=1))
    if not usable.any():
        return None
    first = int(np.argmax(usable))
    moving = np.flatnonzero(~standing[first:])
    stop = first + int(moving[0]) if moving.size else len(log)
    long_enough = stop > first and log.time_s[stop - 1] - log.time_s[first] >= QUIET_S
    return (first, stop) if long_enough else None
