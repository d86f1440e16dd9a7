"""The estimator that remembers, over a whole walk: delay aligned, noise learnt, then filtered.

An estimator's CoM acceleration holds motion that never was: odometry that changes its foot bumps at
every step, and each bump is differentiated twice. These false forces repeat with the gait, so that
thousands of steps never average them out, and gains of cells are bent until they fit. They are
harmonics of the step; what moves a robot from foot to foot is the step itself. Where errors repeat,
or a plate would have to weigh less than nothing to make up for them, total rows are filtered below
the second harmonic of the step, on both sides alike, and only as many are kept as are independent.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footcal_cli.core.centroidal import MIN_FORCE_N, Reference
from footcal_cli.core.contact import cycle_phase, gait_cycles
from footcal_cli.core.effects.body import heading_rad
from footcal_cli.core.effects.transport import SMOOTHING
from footcal_cli.core.experiments import walk
from footcal_cli.core.log import Log
from footcal_cli.core.online.alignment import aligned, coarse_delay_s
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.evidence import repetition
from footcal_cli.core.online.filter import Guards, Track, WalkNoise, run_filter
from footcal_cli.core.online.jumps import BiasJump
from footcal_cli.core.online.plates import PLATE_MASS, PLATE_STATE, lacking_n
from footcal_cli.core.online.reference_states import MOMENTUM_SHARES, REFERENCE_STATES, advanced
from footcal_cli.core.online.replay import Replayed, corrected, held_until_next
from footcal_cli.core.online.rows import Rows, cell_rows
from footcal_cli.core.online.smoother import run_smoother
from footcal_cli.core.online.tuning import LEARNT, Tuning, learn_noise
from footcal_cli.core.parameters import BoolArray, Estimates, FloatArray, learnt_status

_HARMONICS = 2.4
"""Cutoff in cycles per stride: above the step, which is the second."""
_ORDER = 4
_SPARE = 1.1
"""Rows kept over the two per period that a cutoff leaves independent."""


def step_band_hz(log: Log) -> float:
    """Cutoff above the frequency of steps, Hz; ``inf`` without whole gait cycles."""
    cycle = gait_cycles(log.known["contact"])
    starts = np.flatnonzero(np.diff(cycle) > 0) + 1
    if starts.size < 2:
        return np.inf
    return float(_HARMONICS / np.median(np.diff(log.time_s[starts])))


def within_band(rows: Rows, cutoff_hz: float) -> Rows:
    """Totals without what lies above a frequency, and only as many as are independent.

    Errors and their derivatives are filtered alike, so that the rows stay exact. What swinging
    feet show needs no demand and stays as it is.
    """
    if not np.isfinite(cutoff_hz):
        return rows
    step = float(np.median(np.diff(rows.time_s)))
    every = int(1.0 / (2.0 * _SPARE * cutoff_hz * step))
    if every < 2:
        return rows
    from scipy.signal import butter, sosfiltfilt

    sections = butter(_ORDER, 2.0 * cutoff_hz * step, output="sos")
    totals = slice(0, rows.totals)
    valid = rows.valid.copy()
    whole: BoolArray = np.asarray(valid[:, totals].all(axis=1))

    def filtered(values: FloatArray) -> FloatArray:
        held = _held(values, whole)
        return np.asarray(sosfiltfilt(sections, held, axis=0))

    h, error, stamps = rows.h.copy(), rows.error.copy(), rows.per_stamp_s
    h[:, totals], error[:, totals] = filtered(h[:, totals]), filtered(error[:, totals])
    stamps = None if stamps is None else filtered(stamps)
    soles = None if rows.soles is None else rows.soles.within(filtered)
    # near a gap and near the ends the filter sees what was put there
    gaps = np.pad(~whole, every, constant_values=True)
    around = np.convolve(gaps, np.ones(2 * every + 1), "valid") > 0.5
    kept = np.zeros(whole.size, dtype=bool)
    kept[every // 2 :: every] = True
    valid[:, totals] &= (kept & ~around)[:, None]
    return replace(rows, h=h, error=error, per_stamp_s=stamps, valid=valid, soles=soles)


def _held(values: FloatArray, good: BoolArray) -> FloatArray:
    """The rows, each bad one replaced by the last good one before it."""
    at = np.where(good, np.arange(good.size), -1)
    at = np.maximum.accumulate(at)
    first = int(np.argmax(good))
    return np.asarray(values[np.where(at < 0, first, at)])


_STATE_EVIDENCE_NATS, _FAULTY_EVIDENCE_NATS = 5.0, 15.0
"""Gain in log likelihood from which a doubted state is believed; the second where the model lacks
something, since an error of a cell in part looks like one of the body."""
INADEQUATE = 2.0
"""Factor of repeated errors above which the model lacks something: without a fault it stays below
1.8 on the walks of the study."""
_BEFORE_JUMP, _AFTER_JUMP = 5, 25
"""Updates before and after an onset between which a jump is measured: the foot has swung again."""
_DELAY_PASSES = 2
_SURE_SD = 3.0


@dataclass(frozen=True)
class Memory:
    """What the estimator that remembers found.

    Parameters
    ----------
    rows
        That it was given, the body stream moved by `delay_s`.
    jumps
        Bias jumps alarmed while filtering, sized by the smoother.
    tuning
        Noise learnt from the innovations; None where it was given.
    repeated
        Factor on all covariances for errors that repeat in every gait cycle (`repetition`).
    delay_s, delay_sd_s
        Of the body stream behind what the recipe compensated.
    log
        The log with the delay taken out: positions of the feet move with the body stream.
    band_hz
        Frequency up to which totals were used: errors of the motion repeat above it.
    """

    rows: Rows
    track: Track
    smoothed: Track
    jumps: tuple[BiasJump, ...]
    tuning: Tuning | None
    noise: WalkNoise
    repeated: float
    delay_s: float
    delay_sd_s: float
    log: Log
    band_hz: float = np.inf


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
    align
        Find the delay in a first pass and rebuild the rows about it.
    state_sd
        Prior sd of single states.
    hindsight
        Whether a block may look at the readings of the next.
    """

    states: tuple[str, ...] = tuple(n for n in REFERENCE_STATES if n not in MOMENTUM_SHARES)
    plate: bool = True
    swing: bool = True
    noise: WalkNoise = field(default_factory=WalkNoise)
    learnt: tuple[str, ...] = LEARNT
    guards: Guards = field(default_factory=Guards)
    samples_per_update: int = 4
    align: bool = True
    state_sd: Mapping[str, float] = field(default_factory=dict)
    hindsight: bool = True


def run_memory(log: Log, belief: Belief, options: MemoryOptions | None = None) -> Memory:
    """Filter and smooth a walk; the reference is linearised about the delay that is found.

    Parameters
    ----------
    log
        Raw counts, filtered; rows that must not count are NaN.
    options
        Defaults where None.
    """
    options = _for_stream(options or MemoryOptions(), log)
    if options.align and "robot.delay" in options.states:
        delay, moved, rows = aligned(
            log, lambda moved, _: walk_rows(moved, belief, options), "robot.delay", options.noise,
            options.guards, _DELAY_PASSES,
        )  # fmt: skip
    else:
        delay, moved, rows = 0.0, log, walk_rows(log, belief, options)
    rows.refuse_if_empty()
    phase = gait_phase(moved, rows)
    noise, tuning, first = _learnt(rows, options)
    repeated = repetition(first, phase, rows.totals)
    if weightless := _weigh_less_than_nothing(first):
        rows = rows.without(np.array([PLATE_STATE in name for name in rows.names]))
    known = weightless or repeated > INADEQUATE
    band_hz = step_band_hz(moved) if known else np.inf
    if known:
        rows = within_band(rows, band_hz)
        noise, tuning, first = _learnt(rows, options)
        repeated = repetition(first, phase, rows.totals, known=True)
    rows = believed(rows, noise, options.guards, repeated)
    track = run_filter(rows, noise, options.guards)
    past = run_smoother(rows, noise, options.guards, track.jumps)
    _, delay_sd = track.at_end("robot.delay")
    repeated = repetition(track, phase, rows.totals, known=known)
    track = track.inflated(repeated)
    smoothed = past.inflated(repeated)
    jumps = sized_jumps(track.jumps, smoothed)
    return Memory(
        rows, track, smoothed, jumps, tuning, noise, repeated, delay, delay_sd, moved, band_hz
    )


def _weigh_less_than_nothing(track: Track) -> bool:
    """Whether a plate's weight is surely negative: it stands for something that the model lacks."""
    plates = [track.at_end(name) for name in track.names if name.endswith(PLATE_STATE)]
    return any(weight < -_SURE_SD * sd for weight, sd in plates)


def _for_stream(options: MemoryOptions, log: Log) -> MemoryOptions:
    """What a stream has no rate of angular momentum for is a share of the body's own motion."""
    if "robot.angmom_loss" not in options.states or np.any(log.known["angmom_rate_nm"]):
        return options
    kept = tuple(name for name in options.states if name != "robot.angmom_loss")
    return replace(options, states=(*kept, *MOMENTUM_SHARES))


def _learnt(rows: Rows, options: MemoryOptions) -> tuple[WalkNoise, Tuning | None, Track]:
    """The noise as the innovations have it, how it was found, and the filter's run with it."""
    jumps = run_filter(rows, options.noise, options.guards).jumps if options.learnt else ()
    noise, tuning = noise_learnt(rows, options, jumps)
    return noise, tuning, run_filter(rows, noise, options.guards)


def noise_learnt(
    rows: Rows, options: MemoryOptions, jumps: Sequence[BiasJump]
) -> tuple[WalkNoise, Tuning | None]:
    """The noise as the innovations have it, and how it was found; as given where it is."""
    if not options.learnt:
        return options.noise, None
    tuning = learn_noise(
        rows, options.noise, learnt=options.learnt, guards=options.guards, known_jumps=jumps
    )
    return tuning.noise, tuning


def begun_delay_s(log: Log, belief: Belief, options: MemoryOptions) -> float:
    """The delay that a coarse search finds."""
    return coarse_delay_s(
        log, lambda moved: walk_rows(moved, belief, options), "robot.delay", options.noise,
        options.guards,
    )  # fmt: skip


def walk_rows(log: Log, belief: Belief, options: MemoryOptions) -> Rows:
    """The rows that the options ask for."""
    return cell_rows(
        log,
        belief,
        samples_per_update=options.samples_per_update,
        states=options.states,
        plate=options.plate,
        swing=options.swing,
        neighbours=options.hindsight,
        state_sd=options.state_sd,
    )


def believed(rows: Rows, noise: WalkNoise, guards: Guards, repeated: float) -> Rows:
    """The rows without the states that the innovations do not speak for.

    A state that is not needed is one more way to be wrong. Plates must earn their place always,
    an offset of the CoM only where the rate of angular momentum is not known: it would take up
    what that lacks. Elsewhere it stays: without it the scales would take up the offset.
    Likelihoods are divided by the factor `repeated`, as overdispersed ones are (Burnham and
    Anderson, Model Selection and Multimodel Inference, 2002, section 2.5).
    """
    quiet = guards.without_jumps()
    faulty = repeated > INADEQUATE
    least = _FAULTY_EVIDENCE_NATS if faulty else _STATE_EVIDENCE_NATS
    for kind in (
        (PLATE_STATE, "com_correction") if faulty and _no_momentum(rows) else (PLATE_STATE,)
    ):
        doubted = np.array([kind in name for name in rows.names])
        if not doubted.any():
            continue
        bare = rows.without(doubted)
        gained = (
            run_filter(rows, noise, quiet).log_likelihood
            - run_filter(bare, noise, quiet).log_likelihood
        )
        if gained <= least * repeated:
            rows = bare
    return rows


def _no_momentum(rows: Rows) -> bool:
    """Whether the stream has no rate of angular momentum of which a share could be missing."""
    at = [name == "robot.angmom_loss" for name in rows.names]
    return not np.any(rows.h[:, :, at])


def gait_phase(log: Log, rows: Rows) -> FloatArray:
    """Share of its gait cycle that each update has come to, NaN outside of whole cycles, (u,)."""
    return cycle_phase(log.known["contact"])[rows.last_sample]


def sized_jumps(jumps: Iterable[BiasJump], smoothed: Track) -> tuple[BiasJump, ...]:
    """Jumps with the sizes that the whole walk gives them, without those that it refutes."""
    found = (sized(jump, smoothed) for jump in jumps)
    return tuple(jump for jump in found if not jump.refuted)


def sized(jump: BiasJump, smoothed: Track) -> BiasJump:
    """A jump with the size that the whole walk gives it; the proof saw only its beginning."""
    at = smoothed.names.index(jump.name)
    onset = int(
        np.clip(np.searchsorted(smoothed.time_s, jump.onset_s), 1, len(smoothed.time_s) - 1)
    )
    last = len(smoothed.time_s) - 1
    before, after = max(onset - _BEFORE_JUMP, 0), min(onset + _AFTER_JUMP, last)
    size = float(smoothed.values[after, at] - smoothed.values[before, at])
    return replace(jump, size=size, sd=float(np.hypot(*smoothed.sd[[before, after], at])))


def replay_track(
    method: str, memory: Memory, track: Track, belief: Belief, min_force_n: float = MIN_FORCE_N
) -> Replayed:
    """Forces and CoP along a filter's or a smoother's track."""
    n, c = len(memory.log), len(belief.channels)
    values = held_until_next(memory.rows.last_sample, track.values, n)
    plates = [i for i, name in enumerate(track.names) if name.endswith((PLATE_STATE, PLATE_MASS))]
    below = lacking_n(memory.log, [track.names[i] for i in plates], values[:, plates])
    bias = values[:, c : 2 * c]
    if track.momentary is not None:
        bias = bias + held_until_next(memory.rows.last_sample, track.momentary, n)
    return corrected(
        method, memory.log, belief, values[:, :c], bias, below, min_force_n=min_force_n
    )


def memory_reference(memory: Memory) -> Reference:
    """What the motion demands once the delay, CoM offset and L̇ that were found are taken out."""
    log, track = memory.log, memory.smoothed
    values = held_until_next(memory.rows.last_sample, track.values, len(log))
    state = {name: values[:, i] for i, name in enumerate(track.names)}
    none = np.zeros(len(log))
    if "robot.delay" in state:
        log = advanced(log, float(track.values[-1, track.names.index("robot.delay")]))
    yaw = heading_rad(log)
    dx, dy = (state.get(f"robot.com_correction_{axis}", none) for axis in "xy")
    com = log.known["com_m"].copy()
    com[:, 0] += np.cos(yaw) * dx - np.sin(yaw) * dy
    com[:, 1] += np.sin(yaw) * dx + np.cos(yaw) * dy
    com[:, 2] += state.get("robot.com_correction_z", none)
    regained = 1.0 + state.get("robot.angmom_loss", none)
    rate = log.known["angmom_rate_nm"] * regained[:, None] + _share_of_motion(log, state)
    log = log.with_known(com_m=com, angmom_rate_nm=rate)
    last = {name: track.values[-1:, i] for i, name in enumerate(track.names)}
    theta = {name: last.get(f"robot.{name}", np.zeros(1)) for name in SMOOTHING.parameter_names}
    sharp, _ = SMOOTHING.remove(log, theta, None)
    return walk.reference_of(sharp)


def _share_of_motion(log: Log, state: Mapping[str, FloatArray]) -> FloatArray:
    """The rate of angular momentum by `MOMENTUM_SHARES`, Nm, (n, 2); nothing without them."""
    if not set(MOMENTUM_SHARES) <= set(state):
        return np.zeros((len(log), 2))
    known, yaw = log.known, heading_rad(log)
    push = (known["mass_kg"] * known["com_m"][:, 2])[:, None] * known["com_acc_mps2"][:, :2]
    turned = (push[:, 0] + 1j * push[:, 1]) * np.exp(-1j * yaw)
    ahead, left = (state[name] / (1.0 - state[name]) for name in MOMENTUM_SHARES)
    moment = (ahead * turned.real + 1j * left * turned.imag) * np.exp(1j * yaw)
    return np.stack([-moment.imag, moment.real], axis=1)


def memory_estimates(memory: Memory, belief: Belief) -> Estimates:
    """The last state as ``<cell>.scale`` and ``<cell>.bias``; unlearnt ones keep the prior."""
    c = len(belief.channels)
    cells = slice(0, 2 * c)
    status = learnt_status(memory.track.sd[-1, cells], memory.rows.prior_sd[cells])
    values = memory.track.values[-1, cells]
    return belief.estimates(values[:c], values[c:], memory.track.covariance[cells, cells], status)
