"""A recorded walk on six-axis feet: offsets and scales of both, and what is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.experiments import walk
from footcal_cli.core.log import Log
from footcal_cli.core.online.evidence import Consistency, check_consistency
from footcal_cli.core.online.filter import Guards, Noise, Track, run_filter
from footcal_cli.core.online.replay import LEARNT_RATIO, held
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.online.six_axis import six_axis_rows
from footcal_cli.core.online.smoother import smooth
from footcal_cli.core.online.streams import Merged
from footcal_cli.core.online.tuning import LEARNT, Tuning, learn_noise
from footcal_cli.core.parameters import Estimates, FloatArray, Status

_GOOD_DEMAND = 0.02
START = Noise(
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


@dataclass(frozen=True)
class SixAxisReplay:
    """What came out of a walk on six-axis feet.

    Parameters
    ----------
    merged, rows
        What went in.
    track, smoothed, tuning
        Filter, smoother, learnt noise.
    estimates
        From the smoother's last state (the filter's), by name.
    before, after
        Errors of the balance per sample before and with the held estimates, shape (n, k); NaN
        where they do not count.
    vertical_n
        Total vertical force before and after, and what the motion demands, shape (n, 3).
    consistency
        Of the innovations.
    demand_sd_n
        How well the motion of the body tells the force, as the innovations have it.
    """

    merged: Merged
    rows: Rows
    track: Track
    smoothed: Track
    tuning: Tuning
    estimates: Estimates
    before: FloatArray
    after: FloatArray
    vertical_n: FloatArray
    consistency: Consistency
    demand_sd_n: float


def replay_six_axis(
    merged: Merged, *, samples_per_update: int, scales: bool | None = None
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
    """
    log = merged.log
    guards = Guards(jump_threshold=np.inf)
    # with free scales the likeliest noise is none: readings times zero balance weights of zero
    fixed = six_axis_rows(log, samples_per_update=samples_per_update, scales=False)
    learnt = tuple(name for name in LEARNT if name not in ("gain_walk", "state_walk"))
    tuning = learn_noise(fixed, START, learnt=learnt, guards=guards)
    demand_sd = float(np.hypot(tuning.noise.force_n, tuning.noise.force_slow_n))
    weight_n = float(np.mean(log.known["mass_kg"] * log.known["gravity_mps2"]))
    if scales is None:
        scales = demand_sd < _GOOD_DEMAND * weight_n
    rows = fixed
    if scales:
        rows = six_axis_rows(log, samples_per_update=samples_per_update, scales=True)
    track = run_filter(rows, tuning.noise, guards, keep_history=True)
    smoothed = smooth(track)
    status = [
        Status.ESTIMATED if now < LEARNT_RATIO * before else Status.PRIOR_KEPT
        for now, before in zip(track.sd[-1], rows.prior_sd, strict=True)
    ]
    estimates = Estimates(
        track.names, track.units, track.values[-1], track.covariance, tuple(status)
    )
    corrected = corrected_log(log, track.names, smoothed, rows)
    before = _errors(log)
    after = _errors(corrected)
    weight = log.known["mass_kg"] * (log.known["com_acc_mps2"][:, 2] + log.known["gravity_mps2"])
    vertical = np.stack([before[:, 2] + weight, after[:, 2] + weight, weight], axis=1)
    return SixAxisReplay(
        merged, rows, replace(track, history=None), smoothed, tuning, estimates, before, after,
        vertical, check_consistency(track), demand_sd,
    )  # fmt: skip


def _errors(log: Log) -> FloatArray:
    balance = walk.six_axis_balance(log)
    return np.where(balance.valid, balance.error, np.nan)


def corrected_log(log: Log, names: Sequence[str], track: Track, rows: Rows) -> Log:
    """The log with offsets, scales, mass, CoM and weights as a track has them, sample by sample."""
    n = len(log)
    values = held(rows.last_sample, track.values, n)
    # what was not yet known at the very start is what the first update says
    values[: rows.last_sample[0]] = track.values[0]
    column = {name: values[:, i] for i, name in enumerate(names)}
    feet = walk.feet_of(log)
    readings = log.readings.copy()
    for k, foot in enumerate(feet):
        for j, axis in enumerate(AXES):
            at = 6 * k + j
            scale = column.get(f"{foot}.scale_{axis}", np.zeros(n))
            readings[:, at] = (1.0 + scale) * readings[:, at] - column[f"{foot}.offset_{axis}"]
    com = log.known["com_m"].copy()
    com[:, 0] += column["robot.com_correction_x"]
    com[:, 1] += column["robot.com_correction_y"]
    weight = log.known["foot_weight_n"] + np.stack(
        [column[f"{foot}.weight"] for foot in feet], axis=1
    )
    return log.with_readings(readings).with_known(
        com_m=com,
        mass_kg=log.known["mass_kg"] + column["robot.mass_correction"],
        foot_weight_n=weight,
    )
