"""A recorded walk on six-axis feet: offsets and scales of both, and what is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.experiments import walk
from footcal_cli.core.log import Log
from footcal_cli.core.online.alignment import aligned
from footcal_cli.core.online.evidence import Consistency, check_consistency, repetition
from footcal_cli.core.online.filter import Guards, Track, WalkNoise, run_filter
from footcal_cli.core.online.jumps import BiasJump
from footcal_cli.core.online.memory import gait_phase, sized_jumps
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.online.six_axis import (
    DELAY_STATE,
    MASS_STATE,
    PRIOR_SD,
    corrected_log,
    shared_errors,
    six_axis_rows,
)
from footcal_cli.core.online.smoother import run_smoother
from footcal_cli.core.online.streams import Merged
from footcal_cli.core.online.tuning import LEARNT, Tuning, learn_noise
from footcal_cli.core.parameters import Estimates, FloatArray, learnt_status

_GOOD_DEMAND = 0.02
_BELIEVABLE = 4.0
"""Prior sd that a scale may be off by."""
_DELAY_PASSES = 8
_AGREED_S, _AGREED_SHARE = 0.008, 0.25
"""The delays that the totals ask for agree within this time or this share of the delay."""
_SHARE_ROUNDS, _SMALLEST_SHARE, _LARGEST_SHARE = 2, 0.2, 5.0
_INFLATIONS = 4
START = WalkNoise(
    force_n=5.0,
    moment_nm=2.0,
    force_slow_n=15.0,
    moment_slow_nm=5.0,
    force_slow_s=0.2,
    moment_slow_s=0.2,
    swing_n=2.0,
    swing_slow_n=4.0,
    swing_slow_s=0.3,
    gain_walk=1e-5,
    bias_walk_n=0.05,
    state_walk=1e-4,
)
"""A humanoid of 70 kg; the innovations say the rest."""
GUARDS = Guards(least_jump_n=5.0)
"""A jump of an offset below 5 N or 0.5 Nm is left to the random walk."""
_ROW_NOISE = (
    "force_n", "moment_nm", "force_slow_n", "moment_slow_nm",
    "swing_n", "swing_slow_n", "swing_fixed_n",
)  # fmt: skip


@dataclass(frozen=True)
class SixAxisReplay:
    """What came out of a walk on six-axis feet.

    Parameters
    ----------
    merged, rows
        What went in, the body stream moved by `delay_s`.
    jumps
        Offset jumps alarmed while filtering, sized by the smoother.
    estimates
        From the filter's last state, by name.
    before, after
        Errors of the balance per sample before and with the held estimates, shape (n, k); NaN
        where they do not count.
    vertical_n
        Total vertical force before and after, and what the motion demands, shape (n, 3).
    consistency
        Of the innovations.
    inflated
        Factor on all noise variances that the innovations asked for beyond the learnt noise.
    repeated
        Factors on the noise variances of the totals and of swinging feet for errors that repeat
        in every gait cycle.
    demand_sd_n
        How well the motion of the body tells the vertical force, as the innovations have it.
    delay_s, delay_sd_s
        Of the body stream behind what the recipe compensated.
    delay_asked_s, delay_found
        What each total alone asks for (on top of `delay_s`), and whether they agree: where they
        do not, no delay is taken out.
    """

    merged: Merged
    rows: Rows
    track: Track
    smoothed: Track
    tuning: Tuning
    jumps: tuple[BiasJump, ...]
    estimates: Estimates
    before: FloatArray
    after: FloatArray
    vertical_n: FloatArray
    consistency: Consistency
    inflated: float
    repeated: tuple[float, float]
    demand_sd_n: float
    delay_s: float
    delay_sd_s: float
    delay_asked_s: FloatArray
    delay_found: bool


def replay_six_axis(
    merged: Merged,
    *,
    samples_per_update: int,
    scales: bool | None = None,
    guards: Guards = GUARDS,
) -> SixAxisReplay:
    """Filter and smooth a walk on six-axis feet.

    Parameters
    ----------
    merged
        From `footcal_cli.core.online.streams.merge_six_axis`.
    samples_per_update
        Samples averaged to one block.
    scales
        Whether each axis has an unknown scale; None: where the motion's demand is good to 2 % of
        the weight. Regressing good readings on a poor demand would pull every scale to zero.
    guards
        Huber limit, information gate, jump threshold.
    """
    # with free scales the likeliest noise is none: readings times zero balance weights of zero
    aligned = _aligned(merged.log, samples_per_update, guards)
    log = aligned.log
    aligned.rows.refuse_if_empty()
    fixed, tuning = _learnt(aligned.rows, guards)
    demand_sd = _vertical_sd(fixed, tuning.noise)
    weight_n = float(np.mean(log.known["mass_kg"] * log.known["gravity_mps2"]))
    free = _rows(
        log, samples_per_update, scales=True, delay=aligned.agreed, moved_s=aligned.delay_s
    )
    unsure = scales is None
    if unsure and demand_sd >= _GOOD_DEMAND * weight_n:
        known = _without_scales(aligned.rows, free, fixed, tuning.noise, guards)
        if known is not None:
            again, own = _learnt(known, guards)
            found = _vertical_sd(again, own.noise)
            if found < _GOOD_DEMAND * weight_n:
                fixed, tuning, demand_sd = again, own, found
    if scales is None:
        scales = demand_sd < _GOOD_DEMAND * weight_n
    rows = _as_learnt(free if scales else aligned.rows, fixed)
    noise, track, inflated = _consistent(rows, tuning.noise, guards)
    consistency = check_consistency(track)
    rows, repeated = _without_repeats(log, rows, track)
    if max(repeated) > 1.0:
        track = run_filter(rows, noise, guards)
    smoothed = run_smoother(rows, noise, guards, track.jumps)
    corrected = corrected_log(log, track.names, smoothed, rows)
    before, after = _errors(merged.log), _errors(corrected)
    weight = log.known["mass_kg"] * (log.known["com_acc_mps2"][:, 2] + log.known["gravity_mps2"])
    vertical = np.stack([before[:, 2] + weight, after[:, 2] + weight, weight], axis=1)
    at = track.names.index(DELAY_STATE)
    return SixAxisReplay(
        merged=merged,
        rows=rows,
        track=track,
        smoothed=smoothed,
        tuning=tuning,
        jumps=sized_jumps(track.jumps, smoothed),
        estimates=_estimates(track, rows, log, aligned.delay_s, exact_scales=not unsure),
        before=before,
        after=after,
        vertical_n=vertical,
        consistency=consistency,
        inflated=inflated,
        repeated=repeated,
        demand_sd_n=demand_sd,
        delay_s=aligned.delay_s + float(track.values[-1, at]),
        delay_sd_s=float(track.sd[-1, at]),
        delay_asked_s=aligned.asks_s,
        delay_found=aligned.agreed,
    )


def _as_learnt(rows: Rows, learnt: Rows) -> Rows:
    """Rows with the shares of the noise that others were learnt to have."""
    return replace(
        rows, swing_sd_factor=learnt.swing_sd_factor, total_sd_factor=learnt.total_sd_factor
    )


def _without_scales(
    rows: Rows, free: Rows, fixed: Rows, noise: WalkNoise, guards: Guards
) -> Rows | None:
    """Rows without the errors that scales of a believable size explain; None where none do.

    Scales that are off by some per cent look like a poor demand of the motion. A demand that is
    poor would be explained by scales, too, but by scales near −1.
    """
    track = run_filter(_as_learnt(free, fixed), noise, guards)
    scales = np.array([".scale_" in name for name in free.names])
    z = np.where(scales, track.values[-1] / free.prior_sd, 0.0)
    if np.abs(z).max() > _BELIEVABLE:
        return None
    return replace(rows, error=rows.error + free.h @ z)


@dataclass(frozen=True)
class _Aligned:
    """A log with its delay taken out.

    `asks_s` is what each total alone would move the body's stream by, from where all of them
    together put it; `agreed` whether they agree, so that it is a delay.
    """

    log: Log
    delay_s: float
    rows: Rows
    asks_s: FloatArray
    agreed: bool


def _aligned(log: Log, samples_per_update: int, guards: Guards) -> _Aligned:
    """The delay that all totals together ask for, taken out where each of them agrees.

    A body that is late is late for every force and moment alike. Where one total wants it earlier
    and another later, the motion is wrong in another way, and it is left as it is.
    """
    delay, moved, rows = aligned(
        log, lambda late, by: _rows(late, samples_per_update, scales=False, moved_s=by),
        DELAY_STATE, START, guards.without_jumps(), _DELAY_PASSES,
    )  # fmt: skip
    at = rows.names.index(DELAY_STATE)
    asks = _asked_delays(rows, at)
    if np.max(np.abs(asks)) <= max(_AGREED_S, _AGREED_SHARE * abs(delay)):
        return _Aligned(moved, delay, rows, asks, agreed=True)
    asks = _asked_delays(_rows(log, samples_per_update, scales=False), at)
    rows = _rows(log, samples_per_update, scales=False, delay=False)
    return _Aligned(log, 0.0, rows, asks, agreed=False)


def _rows(
    log: Log, samples_per_update: int, *, scales: bool, delay: bool = True, moved_s: float = 0.0
) -> Rows:
    """Rows of a walk, without those for which a moved body stream has no sample.

    Without a delay its column is empty and it keeps its prior.
    """
    rows = six_axis_rows(log, samples_per_update=samples_per_update, scales=scales, mass=not scales)
    if not delay:
        rows.h[:, :, rows.names.index(DELAY_STATE)] = 0.0
    inside = (rows.time_s <= log.time_s[-1] - moved_s) & (rows.time_s >= log.time_s[0] - moved_s)
    return replace(rows, valid=rows.valid & inside[:, None])


def _asked_delays(rows: Rows, at: int) -> FloatArray:
    """Delay that each total asks for by itself, its mean left free, shape (totals,)."""
    asked = np.zeros(rows.totals)
    for k in range(rows.totals):
        h, error = rows.h[rows.valid[:, k], k, at], rows.error[rows.valid[:, k], k]
        h = h - h.mean() if h.size else h
        if h @ h > 0:
            asked[k] = -(h @ (error - error.mean())) / (h @ h) * rows.prior_sd[at]
    return asked


def _learnt(rows: Rows, guards: Guards) -> tuple[Rows, Tuning]:
    """The rows with each kind's share of the noise, and the noise, both from the innovations.

    One noise serves all forces, all moments and all axes of swinging feet; the mean square of each
    kind's own normalised innovations says how much more or less it is.
    """
    learnt = tuple(name for name in LEARNT if name not in ("gain_walk", "state_walk"))
    jumps = run_filter(rows, START, guards).jumps
    tuning = learn_noise(rows, START, learnt=learnt, guards=guards, known_jumps=jumps)
    kinds = [name.rsplit(".", 1)[-1] for name in rows.outputs]
    for _ in range(_SHARE_ROUNDS):
        track = run_filter(rows, tuning.noise, guards.without_jumps(), known_jumps=jumps)
        squared = (track.innovation / track.innovation_sd) ** 2
        share = np.array([_root_mean(squared[:, _same(kinds, k)]) for k in range(len(kinds))])
        share = np.clip(share, _SMALLEST_SHARE, _LARGEST_SHARE)
        rows = replace(
            rows,
            total_sd_factor=rows.total_sd_factor * share[: rows.totals],
            swing_sd_factor=rows.swing_sd_factor * share[rows.totals :],
        )
    again = learn_noise(rows, tuning.noise, learnt=learnt, guards=guards, known_jumps=jumps)
    return rows, again


def _same(kinds: Sequence[str], k: int) -> list[int]:
    """Rows of the same kind: a total for itself, an axis with that of the other feet."""
    return [i for i, kind in enumerate(kinds) if kind == kinds[k] and (i < 5) == (k < 5)]


def _root_mean(squared: FloatArray) -> float:
    """Root mean of squares of normalised values, each counted up to the limit of the filter."""
    seen = squared[np.isfinite(squared)]
    return float(np.sqrt(np.mean(np.minimum(seen, GUARDS.huber**2)))) if seen.size else 1.0


def _vertical_sd(rows: Rows, noise: WalkNoise) -> float:
    """How well the motion tells the vertical force."""
    share = np.broadcast_to(rows.total_sd_factor, rows.totals)[rows.outputs.index("fz")]
    return float(share * np.hypot(noise.force_n, noise.force_slow_n))


def _consistent(rows: Rows, noise: WalkNoise, guards: Guards) -> tuple[WalkNoise, Track, float]:
    """Noise with which the normalised innovations lie in their band, the track, the factor.

    Where a robot's model is wrong in ways that no noise of the filter describes, its innovations
    stay too large however well the noise was learnt. All row variances are then multiplied by
    what the innovations show (covariance matching), so that intervals are not a lie.
    """
    factor = 1.0
    track = run_filter(rows, noise, guards)
    for _ in range(_INFLATIONS):
        found = check_consistency(track)
        if not found.ratio > found.high:
            break
        factor *= found.ratio
        larger = {name: getattr(noise, name) * np.sqrt(found.ratio) for name in _ROW_NOISE}
        noise = replace(noise, **larger)
        track = run_filter(rows, noise, guards)
    return noise, track, factor


def _without_repeats(log: Log, rows: Rows, track: Track) -> tuple[Rows, tuple[float, float]]:
    """The rows with errors that repeat in every gait cycle counted once, and the two factors."""
    phase = gait_phase(log, rows)
    t = rows.totals
    swing = replace(
        track, innovation=track.innovation[:, t:], innovation_sd=track.innovation_sd[:, t:]
    )
    factors = (repetition(track, phase, t), repetition(swing, phase, len(rows.outputs) - t))
    rows = replace(
        rows,
        total_sd_factor=rows.total_sd_factor * np.sqrt(factors[0]),
        swing_sd_factor=rows.swing_sd_factor * np.sqrt(factors[1]),
    )
    return rows, factors


def _estimates(
    track: Track, rows: Rows, log: Log, delay_s: float, *, exact_scales: bool
) -> Estimates:
    """The filter's last state, its delay on top of the one already taken out.

    What the balance cannot see, `shared_errors`, comes on top of the covariance of what was
    learnt from it, and so do scales that were left alone, unless they are exact.
    """
    values = track.values[-1].copy()
    values[track.names.index(DELAY_STATE)] += delay_s
    learnt = 1.0 - np.diag(track.covariance) / rows.prior_sd**2
    shared = shared_errors(log, track.names, values)
    if not exact_scales:
        shared = np.concatenate([shared, _of_scales(log, track.names, values)])
    shared = shared * np.sqrt(np.maximum(learnt, 0.0))
    covariance = track.covariance + shared.T @ shared
    status = learnt_status(np.sqrt(np.diag(covariance)), rows.prior_sd)
    return Estimates(track.names, track.units, values, covariance, status)


def _of_scales(log: Log, names: Sequence[str], values: FloatArray) -> FloatArray:
    """Errors of one sd that scales bring which are no unknowns of their own, shape (m, p).

    An offset is a reading without load times its scale; mass and weights below are vertical forces.
    """
    at = {name: i for i, name in enumerate(names)}
    feet, sd = walk.feet_of(log), PRIOR_SD["scale"][1]
    taken = [(k, a) for k in range(len(feet)) for a in AXES if f"{feet[k]}.scale_{a}" not in at]
    errors = np.zeros((len(taken), len(names)))
    for row, (k, axis) in zip(errors, taken, strict=True):
        own = at[f"{feet[k]}.offset_{axis}"]
        row[own] = sd * values[own]
        if axis == "fz":
            row[at[f"{feet[k]}.weight"]] = sd * float(log.known["foot_weight_n"][0, k])
            if MASS_STATE in at:
                row[at[MASS_STATE]] = sd * float(np.mean(log.known["mass_kg"])) / len(feet)
    return errors


def _errors(log: Log) -> FloatArray:
    balance = walk.six_axis_balance(log)
    return np.where(balance.valid, balance.error, np.nan)
