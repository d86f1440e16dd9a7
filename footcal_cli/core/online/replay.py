"""A recorded walk replayed through every estimator, on the same log and in the same terms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N, Pressure, Reference, pressure
from footcal_cli.core.contact import airborne, gait_cycles
from footcal_cli.core.effects.body import heading_rad
from footcal_cli.core.effects.contract import Scope, columns_of
from footcal_cli.core.experiments import walk
from footcal_cli.core.log import Log
from footcal_cli.core.online.evidence import repetition, rms
from footcal_cli.core.online.filter import Guards, Noise, Track, run_filter
from footcal_cli.core.online.jumps import Jump
from footcal_cli.core.online.rows import (
    PLATE_STATE,
    REFERENCE_STATES,
    Belief,
    Rows,
    advanced,
    cell_rows,
)
from footcal_cli.core.online.smoother import smooth
from footcal_cli.core.online.tuning import LEARNT, Tuning, learn_noise
from footcal_cli.core.online.window import (
    Weights,
    WindowRule,
    WindowTrack,
    run_window,
    run_window_fast,
)
from footcal_cli.core.parameters import BoolArray, Estimates, FloatArray, IntArray, Status

LEARNT_RATIO = 0.5
"""A parameter counts as estimated where the walk at least halved its prior sd."""
_PLATE_EVIDENCE_NATS = 5.0
"""Gain in log likelihood from which plates hanging on the feet are believed in."""
_BEFORE_JUMP, _AFTER_JUMP = 5, 25
"""Updates before and after an onset between which a jump is measured: the foot has swung again."""
_DELAY_PASSES = 2
_DELAY_SETTLED_S = 2e-4


@dataclass(frozen=True)
class Replayed:
    """Forces and CoP of one method, sample by sample.

    Parameters
    ----------
    method
        ``before window han memory smoother``.
    gain, bias_n
        In force at each sample, shape (n, c).
    forces_n
        Corrected, shape (n, c).
    total, feet
        Vertical force and CoP of the robot and of each foot.
    """

    method: str
    gain: FloatArray
    bias_n: FloatArray
    forces_n: FloatArray
    total: Pressure
    feet: tuple[Pressure, ...]


@dataclass(frozen=True)
class Memory:
    """What the estimator that remembers found.

    Parameters
    ----------
    rows
        That it was given, the body stream moved by `delay_s`.
    track, smoothed
        Filter and smoother.
    jumps
        Bias jumps alarmed while filtering, sized by the smoother.
    tuning
        Noise learnt from the innovations; None where it was given.
    noise
        That was used.
    repeated
        Factor on all covariances for errors that repeat in every gait cycle (`repetition`).
    delay_s, delay_sd_s
        Of the body stream behind what the recipe compensated.
    log
        The log with the delay taken out: positions of the feet move with the body stream.
    """

    rows: Rows
    track: Track
    smoothed: Track
    jumps: tuple[Jump, ...]
    tuning: Tuning | None
    noise: Noise
    repeated: float
    delay_s: float
    delay_sd_s: float
    log: Log


@dataclass(frozen=True)
class MemoryOptions:
    """How `run_memory` works.

    Parameters
    ----------
    states, plate, swing
        What is estimated along (`footcal_cli.core.online.rows.cell_rows`).
    noise
        Start of the learning, and the noise itself where it is not learnt.
    learnt
        Names of the noises to learn from the innovations; empty: `noise` is what it is.
    guards
        Huber limit, information gate, jump threshold.
    samples_per_update
        Samples per block.
    align
        Find the delay in a first pass and rebuild the rows about it.
    state_sd
        Prior sd of single states.
    """

    states: tuple[str, ...] = tuple(REFERENCE_STATES)
    plate: bool = True
    swing: bool = True
    noise: Noise = field(default_factory=Noise)
    learnt: tuple[str, ...] = LEARNT
    guards: Guards = field(default_factory=Guards)
    samples_per_update: int = 4
    align: bool = True
    state_sd: Mapping[str, float] = field(default_factory=dict)


def run_memory(log: Log, belief: Belief, options: MemoryOptions | None = None) -> Memory:
    """Filter and smooth a walk; the reference is linearised about the delay that is found.

    Parameters
    ----------
    log
        Raw counts, filtered; rows that must not count are NaN.
    belief
        Prior of the cells.
    options
        Defaults where None.
    """
    options = options or MemoryOptions()

    def rows_of(moved: Log) -> Rows:
        return cell_rows(
            moved,
            belief,
            samples_per_update=options.samples_per_update,
            states=options.states,
            plate=options.plate,
            swing=options.swing,
            state_sd=options.state_sd,
        )

    delay, moved = 0.0, log
    rows = rows_of(moved)
    if options.align and "robot.delay" in options.states:
        at = rows.names.index("robot.delay")
        for _ in range(_DELAY_PASSES):
            first = run_filter(rows, options.noise, options.guards)
            step = float(first.values[-1, at])
            delay += step
            moved = advanced(log, delay)
            rows = rows_of(moved)
            if abs(step) < _DELAY_SETTLED_S:
                break
    tuning = None
    if options.learnt:
        first = run_filter(rows, options.noise, options.guards)
        tuning = learn_noise(
            rows,
            options.noise,
            learnt=options.learnt,
            guards=options.guards,
            known_jumps=first.jumps,
        )
    noise = tuning.noise if tuning else options.noise
    rows = _without_unseen_plates(rows, noise, options.guards)
    track = run_filter(rows, noise, options.guards)
    past = run_filter(
        rows,
        noise,
        replace(options.guards, jump_threshold=np.inf),
        known_jumps=track.jumps,
        keep_history=True,
    )
    delay_sd = 0.0
    if "robot.delay" in rows.names:
        at = rows.names.index("robot.delay")
        delay_sd = float(track.sd[-1, at])
    repeated = repetition(track, gait_phase(moved, rows), rows.totals)
    track = track.inflated(repeated)
    smoothed = smooth(past).inflated(repeated)
    jumps = tuple(_sized(jump, smoothed) for jump in track.jumps)
    return Memory(rows, track, smoothed, jumps, tuning, noise, repeated, delay, delay_sd, moved)


def _without_unseen_plates(rows: Rows, noise: Noise, guards: Guards) -> Rows:
    """The rows without the plates' weights, unless the innovations speak for plates.

    A weight that is not there is only one more way for a bias to be wrong.
    """
    plates = np.array([name.endswith(PLATE_STATE) for name in rows.names])
    if not plates.any():
        return rows
    bare = rows.without(plates)
    with_plates = run_filter(rows, noise, replace(guards, jump_threshold=np.inf)).log_likelihood
    without = run_filter(bare, noise, replace(guards, jump_threshold=np.inf)).log_likelihood
    return rows if with_plates > without + _PLATE_EVIDENCE_NATS else bare


def gait_phase(log: Log, rows: Rows) -> FloatArray:
    """Share of its gait cycle that each update has come to, NaN outside of whole cycles, (u,)."""
    cycle = gait_cycles(log.known["contact"])
    phase = np.full(len(log), np.nan)
    starts = np.flatnonzero(np.diff(cycle) > 0) + 1
    for start, stop in pairwise(starts):
        phase[start:stop] = np.arange(stop - start) / (stop - start)
    return phase[rows.last_sample]


def _sized(jump: Jump, smoothed: Track) -> Jump:
    """A jump with the size that the whole walk gives it; the proof saw only its beginning."""
    at = smoothed.names.index(jump.name)
    onset = int(
        np.clip(np.searchsorted(smoothed.time_s, jump.onset_s), 1, len(smoothed.time_s) - 1)
    )
    last = len(smoothed.time_s) - 1
    before, after = max(onset - _BEFORE_JUMP, 0), min(onset + _AFTER_JUMP, last)
    size = float(smoothed.values[after, at] - smoothed.values[before, at])
    return replace(jump, size=size, sd=float(np.hypot(*smoothed.sd[[before, after], at])))


def held(last_sample: IntArray, values: FloatArray, n: int) -> FloatArray:
    """Values of updates held until the next one, per sample; 0 (the belief) before the first.

    Parameters
    ----------
    last_sample
        Sample after which each update is known, shape (u,).
    values
        Shape (u, k).
    """
    update = np.searchsorted(last_sample, np.arange(n), side="right") - 1
    return np.where((update >= 0)[:, None], values[np.maximum(update, 0)], 0.0)


def corrected(
    method: str,
    log: Log,
    belief: Belief,
    gain: FloatArray,
    bias_n: FloatArray,
    plate_n: FloatArray | None = None,
    min_force_n: float = MIN_FORCE_N,
) -> Replayed:
    """Forces and CoP with given gains and biases, ``F = (1 + γ) F⁰ + β`` and the plate taken off.

    Parameters
    ----------
    gain, bias_n
        Shape (n, c).
    plate_n
        Weight hanging on each swinging foot, shape (n, feet).
    """
    forces = (1.0 + gain) * belief.forces(log.readings) + bias_n
    feet = columns_of(Scope.FOOT, log.channels)
    if plate_n is not None:
        hanging = airborne(log.known["contact"])
        for foot, columns in enumerate(feet):
            share = hanging[:, foot] * plate_n[:, foot] / columns.size
            forces[:, columns] += share[:, None]
    points = log.known["cell_pos_m"]
    finite = np.asarray(np.isfinite(forces).all(axis=1))
    total = _absent(pressure(np.nan_to_num(forces), points, min_force_n), finite)
    single = tuple(
        _absent(
            pressure(np.nan_to_num(forces[:, columns]), points[:, columns], min_force_n),
            finite & (log.known["contact"][:, foot] == 1.0),
        )
        for foot, columns in enumerate(feet)
    )
    return Replayed(method, gain, bias_n, forces, total, single)


def _absent(found: Pressure, usable: BoolArray) -> Pressure:
    """The pressure with samples that are not usable absent, never zero."""
    valid = found.valid & usable & np.isfinite(found.cop_m).all(axis=1)
    return Pressure(
        np.where(usable, found.fz_n, np.nan), np.where(valid[:, None], found.cop_m, np.nan), valid
    )


def replay_track(method: str, memory: Memory, track: Track, belief: Belief) -> Replayed:
    """Forces and CoP along a filter's or a smoother's track."""
    n, c = len(memory.log), len(belief.channels)
    values = held(memory.rows.last_sample, track.values, n)
    plates = [i for i, name in enumerate(track.names) if name.endswith(PLATE_STATE)]
    plate = values[:, plates] if plates else None
    return corrected(method, memory.log, belief, values[:, :c], values[:, c : 2 * c], plate)


def replay_window(
    method: str, log: Log, belief: Belief, track: WindowTrack, setting: int = 0
) -> Replayed:
    """Forces and CoP along the paper's window."""
    n = len(log)
    gain = held(track.last_sample, track.gain[:, setting], n)
    bias = held(track.last_sample, track.bias_n[:, setting], n)
    return corrected(method, log, belief, gain, bias)


def memory_reference(memory: Memory) -> Reference:
    """What the motion demands once the delay, CoM offset and L̇ that were found are taken out."""
    log, track = memory.log, memory.smoothed
    values = held(memory.rows.last_sample, track.values, len(log))
    state = {name: values[:, i] for i, name in enumerate(track.names)}
    none = np.zeros(len(log))
    if "robot.delay" in state:
        log = advanced(log, float(track.values[-1, track.names.index("robot.delay")]))
    yaw = heading_rad(log)
    dx, dy = (state.get(f"robot.com_correction_{axis}", none) for axis in "xy")
    com = log.known["com_m"].copy()
    com[:, 0] += np.cos(yaw) * dx - np.sin(yaw) * dy
    com[:, 1] += np.sin(yaw) * dx + np.cos(yaw) * dy
    regained = 1.0 + state.get("robot.angmom_loss", none)
    rate = log.known["angmom_rate_nm"] * regained[:, None]
    return walk.reference_of(log.with_known(com_m=com, angmom_rate_nm=rate))


def memory_estimates(memory: Memory, belief: Belief) -> Estimates:
    """The last state as ``<cell>.scale`` and ``<cell>.bias``; unlearnt ones keep the prior."""
    c = len(belief.channels)
    cells = slice(0, 2 * c)
    sd = memory.track.sd[-1, cells]
    status = [
        Status.ESTIMATED if now < LEARNT_RATIO * before else Status.PRIOR_KEPT
        for now, before in zip(sd, memory.rows.prior_sd[cells], strict=True)
    ]
    values = memory.track.values[-1, cells]
    return belief.estimates(values[:c], values[c:], memory.track.covariance[cells, cells], status)


@dataclass(frozen=True)
class Errors:
    """Errors of one method against a reference, per sample; NaN where either is absent.

    Parameters
    ----------
    cop_m
        Shape (n, 2).
    vgrf_n
        Shape (n,).
    foot_cop_m
        Shape (n, feet, 2).
    """

    cop_m: FloatArray
    vgrf_n: FloatArray
    foot_cop_m: FloatArray


def errors_against(ours: Replayed, truth: Replayed | Reference) -> Errors:
    """Ours minus the reference: another calibration, the truth, or what the motion demands."""
    n, feet = ours.forces_n.shape[0], len(ours.feet)
    if isinstance(truth, Reference):
        per_foot = np.full((n, feet, 2), np.nan)
        return Errors(ours.total.cop_m - truth.cop_m, ours.total.fz_n - truth.fz_n, per_foot)
    per_foot = np.stack(
        [a.cop_m - b.cop_m for a, b in zip(ours.feet, truth.feet, strict=True)], axis=1
    )
    return Errors(
        ours.total.cop_m - truth.total.cop_m, ours.total.fz_n - truth.total.fz_n, per_foot
    )


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
    many = Weights(weights.force, weights.cop, candidates)
    tried = run_window_fast(log, belief, many, rule, static=static)
    scores = [
        rms(errors_against(replay_window("window", log, belief, tried, b), truth).cop_m)
        for b in range(candidates.size)
    ]
    best = float(candidates[int(np.argmin(scores))])
    exact = run_window(log, belief, Weights(weights.force, weights.cop, best), rule, static=static)
    return best, exact
