"""How much the parameters wander and the rows are worth: learnt from the innovations.

The likelihood of the filter's innovations is raised by steps in the logarithm of every noise, all
trials of a round filtered in one batched pass. Process noise chosen by taste is either blind to a
drifting cell or as nervous as the paper's window.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np

from footcal_cli.core.online.filter import Guards, WalkNoise, run_settings
from footcal_cli.core.online.jumps import BiasJump
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.parameters import FloatArray, IntArray

_GIVEN = ("swing_fixed_n", "swing_fixed_s")
LEARNT = tuple(f.name for f in fields(WalkNoise) if f.name not in _GIVEN)
"""An error that a swinging cell keeps looks like its bias: the converter's step tells it."""
_FURTHEST = 6.0
_PRIOR_SD_LOG, _PRIOR_SD_LOG_TIME = 1.5, 0.5
"""Prior on the logarithm of each noise about its start: a factor of 4.5 is one sd.

Of correlation times only 1.6: an error of the demanded force that lasts for many steps would take
the place of the gains.
"""
_LONGEST = 2.0
"""Correlation times grow by this logarithm at most: what lasts longer than some steps is no noise,
and taken for it an error that a foot in the air keeps would take the place of its offset."""
_CORRELATION_TIMES = ("force_slow_s", "moment_slow_s", "swing_slow_s")
_ROUNDS = 8
_FIRST_STEP = 0.7
_LARGEST_STEP = 1.5


MOST_UPDATES = 2400
"""Noise is learnt from so many updates; their likelihood says no more that a user could see."""
_STRETCH = 200
"""Updates in a row: many times the longest correlation time that is learnt."""


def spread_stretches(updates: int) -> IntArray:
    """Numbers of at most `MOST_UPDATES` updates: all, or stretches from all over the walk.

    The filter goes through the gaps by prediction alone, so that slow walks of the parameters are
    seen over the whole time.
    """
    if updates <= MOST_UPDATES:
        return np.arange(updates)
    count = MOST_UPDATES // _STRETCH
    starts = np.linspace(0, updates - _STRETCH, count).astype(np.int64)
    return np.asarray((starts[:, None] + np.arange(_STRETCH)).ravel())


@dataclass(frozen=True)
class Tuning:
    """Noise that makes the innovations most likely.

    Parameters
    ----------
    noise
        The optimum, for random walks the mean of the variance.
    log_likelihood
        Before and after.
    sd_log
        Sd of the logarithm of each learnt field from the curvature, shape (learnt,).
    """

    noise: WalkNoise
    log_likelihood: tuple[float, float]
    sd_log: FloatArray
    learnt: tuple[str, ...]


def learn_noise(
    rows: Rows,
    start: WalkNoise | None = None,
    *,
    learnt: Sequence[str] = LEARNT,
    guards: Guards | None = None,
    known_jumps: Sequence[BiasJump] = (),
) -> Tuning:
    """Learn the noise of rows and random walks from the innovations.

    Each round evaluates a step up and down in every coordinate, takes the Newton step of the
    parabola through each three points, and halves it where the joint step does not help.

    Parameters
    ----------
    start
        Where to begin, and the centre of a weak prior.
    learnt
        Fields of `WalkNoise` to move; the others are kept (a recipe's).
    guards
        Its Huber limit.
    known_jumps
        Bias jumps found before: left closed, one jump would be learnt as wandering or as noise.
    """
    start = start or WalkNoise()
    rows = rows.chosen(spread_stretches(len(rows)))
    if rows.per_stamp_s is None:
        learnt = [name for name in learnt if name != "jitter_s"]
    if rows.soles is None:
        learnt = [name for name in learnt if name != "sole_m"]
    field_names = [f.name for f in fields(WalkNoise)]
    lasting = np.array([name in _CORRELATION_TIMES for name in learnt], dtype=bool)
    at = np.array([field_names.index(name) for name in learnt])
    with np.errstate(divide="ignore"):
        origin = np.log(start.stacked()[0])
    prior_sd = np.where(lasting, _PRIOR_SD_LOG_TIME, _PRIOR_SD_LOG)
    furthest = np.where(lasting, _LONGEST, _FURTHEST)

    highest = origin[at] + furthest
    highest[[name == "gain_walk" for name in learnt]] = np.log(_widest_gain_walk(rows))

    def within(points: FloatArray) -> FloatArray:
        points = points.copy()
        lowest = np.minimum(origin[at] - _FURTHEST, highest)
        points[:, at] = np.clip(points[:, at], lowest, highest)
        return points

    def score(points: FloatArray) -> FloatArray:
        points = within(points)
        likelihood, _, _ = run_settings(
            rows, WalkNoise.of(np.exp(points)), guards, known_jumps=known_jumps, states=False
        )
        moved = (points[:, at] - origin[at]) / prior_sd
        return np.asarray(likelihood - 0.5 * np.sum(moved**2, axis=1))

    point, first, best, curvature = _climbed(score, origin, at, 1.0 / prior_sd**2)
    point = within(point[None])[0]
    sd_log = 1.0 / np.sqrt(curvature)
    # the mean of a walk's variance, not its mode: exp(2 s²) for a log-normal amplitude. A walk too
    # small is blind to drift and sure of itself
    walks = np.array([name.endswith(("_walk", "_walk_n")) for name in learnt], dtype=bool)
    point[at[walks]] += np.minimum(sd_log[walks], 1.0) ** 2
    return Tuning(WalkNoise.of(np.exp(point)), (first, best), sd_log, tuple(learnt))


def _widest_gain_walk(rows: Rows) -> float:
    """Random walk with which gains wander as far as they were unsure of before, 1/√s.

    Without a bound a coarse cell's gain may wander to −1: the moments of cells that show nothing
    have no error.
    """
    gains = [name.endswith(".gain") for name in rows.names]
    if not any(gains) or len(rows) < 2:
        return np.inf
    return float(rows.prior_sd[gains].max() / np.sqrt(max(np.ptp(rows.time_s), 1e-9)))


def _climbed(
    score: Callable[[FloatArray], FloatArray],
    origin: FloatArray,
    at: IntArray,
    least: FloatArray,
) -> tuple[FloatArray, float, float, FloatArray]:
    """The highest point found, the score of the origin and its own, and the curvature there.

    Parameters
    ----------
    score
        Of points, shape (trials, fields) to (trials,).
    at
        Coordinates that move, shape (learnt,).
    least
        Curvature of the prior, shape (learnt,).
    """
    point, curvature = origin.copy(), least
    first = best = float(score(point[None])[0])
    step = np.full(at.size, _FIRST_STEP)
    shares = np.array([1.0, 0.6, 0.3, 0.1])
    for _ in range(_ROUNDS):
        trials = np.tile(point, (2 * at.size, 1))
        trials[np.arange(at.size), at] += step
        trials[at.size + np.arange(at.size), at] -= step
        scores = score(trials)
        up, down = scores[: at.size], scores[at.size :]
        slope = (up - down) / (2 * step)
        curvature = np.maximum((2 * best - up - down) / step**2, least)
        move = np.clip(slope / curvature, -_LARGEST_STEP, _LARGEST_STEP)
        candidates = np.tile(point, (shares.size, 1))
        candidates[:, at] += shares[:, None] * move
        pool = np.concatenate([candidates, trials])
        pool_scores = np.concatenate([score(candidates), scores])
        winner = int(np.argmax(pool_scores))
        gained = float(pool_scores[winner]) - best
        if gained > 0:
            point, best = pool[winner], float(pool_scores[winner])
        step = np.clip(1.0 / np.sqrt(curvature), 0.1, _FIRST_STEP)
        if gained < 0.2:
            break
    return point, first, best, curvature
