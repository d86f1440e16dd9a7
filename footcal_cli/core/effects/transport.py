"""Clocks and telemetry: the body stream late, filtered or on a drifting clock; samples lost.

The body stream is what does not come from the cells: CoM, acceleration, angular momentum, feet.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from math import prod

import numpy as np

from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    Transform,
    on_readings,
    unchanged,
)
from footcal_cli.core.effects.memory import (
    elapsed,
    first_order_low_pass,
    invert_low_pass,
    recording,
)
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray

BODY_STREAM = (
    "com_m",
    "com_acc_mps2",
    "angmom_rate_nm",
    "foot_yaw_rad",
    "foot_pos_m",
    "foot_rot_wt",
    "foot_acc_mps2",
    "cell_pos_m",
)
"""Known quantities that come by the body's telemetry, where a log has them."""
REMEMBERED_ROWS = 64
"""Rows of the chunk before that a delayed chunk may reach back to."""
_PIECE = 512  # rows that are interpolated at once
_HASH_STEP = np.uint64(0x9E3779B97F4A7C15)
_HASH_MIX = (np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB))


def _stream(log: Log) -> FloatArray:
    """The body stream of a log side by side, shape (n, k)."""
    return _side_by_side(log, BODY_STREAM)


def _slopes(log: Log) -> FloatArray:
    """Of the body stream, shape (n, k)."""
    return slopes(log.time_s, _stream(log), recording(log.time_s, None).fresh)


def _side_by_side(log: Log, names: Sequence[str]) -> FloatArray:
    """Those known quantities that a log has, of any shape (n, …), as columns (n, k); n may be 0."""
    parts = [log.known[name] for name in names if name in log.known]
    columns = [part.reshape(len(log), prod(part.shape[1:])) for part in parts]
    return np.concatenate(columns, axis=1) if columns else np.empty((len(log), 0))


def _with_stream(log: Log, stream: FloatArray, names: Sequence[str] = BODY_STREAM) -> Log:
    """The log with `_side_by_side` replaced."""
    known, start = {}, 0
    for name in names:
        if name in log.known:
            shape = log.known[name].shape
            width = int(np.prod(shape[1:]))
            known[name] = stream[:, start : start + width].reshape(shape)
            start += width
    return log.with_known(**known)


def resample(
    time_s: FloatArray,
    signal: FloatArray,
    at_s: FloatArray,
    fresh: BoolArray,
    slope: FloatArray | None = None,
) -> FloatArray:
    """Cubic Hermite interpolation with finite-difference slopes, within each recording.

    Parameters
    ----------
    time_s, signal
        Stamps (n,) and samples (n, k); increasing within a recording.
    at_s
        Stamps wanted, shape (n,), row by row in the same recording as `time_s`; before its first
        and after its last sample the signal is held.
    fresh
        Rows that start a recording, shape (n,).
    slope
        From `slopes`, where they are known.
    """
    slope = slopes(time_s, signal, fresh) if slope is None else slope
    out = np.empty_like(signal)
    for part in _recordings(fresh):
        if part.stop - part.start < 2:
            out[part] = signal[part]
        else:
            out[part] = hermite(time_s[part], signal[part], slope[part], at_s[part])
    return out


def slopes(time_s: FloatArray, signal: FloatArray, fresh: BoolArray) -> FloatArray:
    """Finite differences within each recording, arguments as of `resample`; shape (n, k)."""
    slope = np.zeros_like(signal)
    for part in _recordings(fresh):
        if part.stop - part.start >= 2:
            slope[part] = np.gradient(signal[part], time_s[part], axis=0)
    return slope


def _recordings(fresh: BoolArray) -> list[slice]:
    """Rows of each recording, from the rows that start one."""
    starts = np.flatnonzero(fresh)
    if not starts.size or starts[0] != 0:
        starts = np.concatenate([[0], starts])
    return [slice(*ends) for ends in itertools.pairwise([*starts.tolist(), fresh.size])]


def hermite(
    time_s: FloatArray, signal: FloatArray, slope: FloatArray, at_s: FloatArray
) -> FloatArray:
    """Cubic interpolation from values and slopes (n, k) at ascending times, shape (m, k)."""
    left = np.clip(np.searchsorted(time_s, at_s, side="right") - 1, 0, len(time_s) - 2)
    width = time_s[left + 1] - time_s[left]
    u = np.clip((at_s - time_s[left]) / width, 0.0, 1.0)
    v = 1.0 - u
    weights = np.array(
        [v * v * (1.0 + 2.0 * u), v * v * u * width, u * u * (1.0 + 2.0 * v), -u * u * v * width]
    )[..., None]
    out = np.empty((len(at_s), signal.shape[1]))
    # in pieces that stay in the processor's cache
    for start in range(0, len(at_s), _PIECE):
        piece = slice(start, start + _PIECE)
        at, share = left[piece], weights[:, piece]
        part = share[0] * signal[at]
        for number, values in ((1, slope[at]), (2, signal[at + 1]), (3, slope[at + 1])):
            part += np.multiply(values, share[number], out=values)
        out[piece] = part
    return out


def _shifted(
    log: Log, at_s: FloatArray, history: State, names: Sequence[str] = BODY_STREAM
) -> tuple[Log, State]:
    """The log whose body stream, or a part of it, shows at each row what it was at `at_s`."""
    whole = names is BODY_STREAM
    stream = log.of_known(_stream) if whole else _side_by_side(log, names)
    if stream.shape[1] == 0:
        return log, history
    kept = slice(-REMEMBERED_ROWS, None)
    if history is None or log.time_s[0] < history[0][-1]:
        fresh, slope = recording(log.time_s, None).fresh, log.of_known(_slopes) if whole else None
        moved = resample(log.time_s, stream, at_s, fresh, slope)
        return _with_stream(log, moved, names), (log.time_s[kept], stream[kept])
    earlier = len(history[0])
    times = np.concatenate([history[0], log.time_s])
    signal = np.concatenate([history[1], stream])
    wanted = np.concatenate([history[0], at_s])
    fresh = recording(times, None).fresh
    moved = resample(times, signal, wanted, fresh)[earlier:]
    return _with_stream(log, moved, names), (times[kept], signal[kept])


def _late(name: str, sign: float, names: Sequence[str] = BODY_STREAM) -> Transform:
    """Some quantities of the body stream, later by a parameter, or earlier again."""

    def late(log: Log, theta: Theta, state: State) -> tuple[Log, State]:
        return _shifted(log, log.time_s - sign * theta[name][0], state, names)

    return late


def _clock(log: Log, theta: Theta, state: State) -> tuple[Log, State]:
    origin, history = state or (None, None)
    since, origin = elapsed(log, origin)
    log, history = _shifted(log, log.time_s - theta["clock_drift"][0] * since, history)
    return log, (origin, history)


def _unclock(log: Log, theta: Theta, state: State) -> tuple[Log, State]:
    origin, history = state or (None, None)
    since, origin = elapsed(log, origin)
    rate = theta["clock_drift"][0]
    log, history = _shifted(log, log.time_s + rate / (1.0 - rate) * since, history)
    return log, (origin, history)


def _lag(log: Log, theta: Theta, state: State) -> tuple[Log, State]:
    return _lagging(log, theta["lag"], state)


def _unlag(log: Log, theta: Theta, state: State) -> tuple[Log, State]:
    return _lagging(log, -theta["lag"], state)


def _lagging(log: Log, lag_s: FloatArray, state: State) -> tuple[Log, State]:
    """The body stream through a low-pass, or, below zero, as it would be before one."""
    stream = log.of_known(_stream)
    if not stream.size:
        return log, state
    passed = first_order_low_pass if lag_s[0] >= 0.0 else invert_low_pass
    stream, state = passed(stream, log.time_s, np.abs(lag_s), state)
    return _with_stream(log, stream), state


def _smoothed(sign: float) -> Transform:
    def smoothed(log: Log, theta: Theta, state: State) -> tuple[Log, State]:
        signal = _side_by_side(log, _DIFFERENTIATED)
        if not signal.shape[1]:
            return log, state
        fresh = recording(log.time_s, None).fresh
        slope = slopes(log.time_s, signal, fresh)
        first, before, after, last = (
            resample(log.time_s, signal, log.time_s + step * _BESIDE_S, fresh, slope)
            for step in (-2.0, -1.0, 1.0, 2.0)
        )
        bend = (before - 2.0 * signal + after) / _BESIDE_S**2
        fourth = (first - 4.0 * before + 6.0 * signal - 4.0 * after + last) / _BESIDE_S**4
        variance, fourth_moment = theta["smoothing"][0], theta["smoothing_fourth"][0]
        signal = signal + sign * (variance / 2.0 * bend + fourth_moment / 24.0 * fourth)
        return _with_stream(log, signal, _DIFFERENTIATED), state

    return smoothed


_DIFFERENTIATED = ("com_acc_mps2", "angmom_rate_nm")
_BESIDE_S = 0.025
SMOOTHED_OVER_S = 2.0 * _BESIDE_S
"""So far from a sample lie those from which its fourth derivative is taken."""


def _uniform(rows: np.ndarray, seed: float) -> FloatArray:
    """A number in [0, 1) for each row number (splitmix64), the same in every run."""
    z = (rows.astype(np.uint64) + np.uint64(int(seed) + 1) * np.uint64(1 << 32)) * _HASH_STEP
    z = (z ^ (z >> np.uint64(30))) * _HASH_MIX[0]
    z = (z ^ (z >> np.uint64(27))) * _HASH_MIX[1]
    uniform: FloatArray = (z ^ (z >> np.uint64(31))).astype(float) / 2.0**64
    return uniform


def _drop(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    count, held = state or (0, x[0])
    rows = count + np.arange(len(x))
    dropped = _uniform(rows, theta["dropped_seed"][0]) < theta["dropped_samples"][0]
    last = np.maximum.accumulate(np.where(dropped, -1, np.arange(len(x))))
    shown = np.where((last < 0)[:, None], held, x[np.maximum(last, 0)])
    return shown, (count + len(x), shown[-1])


_DELAYS_S = (
    -0.15, -0.12, -0.09, -0.07, -0.05, -0.03, 0.03, 0.05, 0.07, 0.09, 0.12, 0.15,
)  # fmt: skip
_LATE_S = (-0.09, -0.06, -0.03, 0.03, 0.06, 0.09)
_PPM = (-4e-3, -2e-3, -1e-3, -5e-4, 5e-4, 1e-3, 2e-3, 4e-3)

LAG = Effect(
    name="lag",
    traits=(Trait.MEMORY, Trait.LOW_PASS),
    stage=Stage.TRANSPORT,
    scope=Scope.ROBOT,
    parameters=(EffectParameter("lag", "s", 0.0, -0.5, 0.5, 0.02),),
    apply=_lag,
    remove=_unlag,
    experiments=("walk",),
    formula="τ dy/dt = x − y on every quantity of the body stream, x linear between samples; "
    "below zero the readings lag behind it",
    source="low-pass in the robot's state estimator, or in the amplifier of all cells",
    remedy="switch the smoothing off, or give the lag to the recipe",
    needs=("com_acc_mps2",),
    mimics=("delay", "sensor_lag", "acceleration_delay"),
    separates="the same walk with all smoothing of the body's stream switched off; a motion only "
    "if it stops within one and a half delays, both streams logged at 500 Hz or more",
)

CLOCK_DRIFT = Effect(
    name="clock_drift",
    stage=Stage.TRANSPORT,
    scope=Scope.ROBOT,
    parameters=(EffectParameter("clock_drift", "s/s", 0.0, -0.05, 0.05, 1e-4, far=_PPM),),
    apply=_clock,
    remove=_unclock,
    experiments=("walk",),
    formula="y(t) = x(t − k (t − t₀)) on every quantity of the body stream",
    source="two free-running clocks; quartz: up to 100 ppm",
    remedy="synchronise the clocks, or log a common pulse at the start and at the end",
    needs=("com_acc_mps2",),
    mimics=("delay",),
    separates="a long walk: the delay at its end differs from that at its start",
    tolerance=1e-3,
    anticipates=True,
    traits=(Trait.MEMORY,),
)

DELAY = Effect(
    name="delay",
    stage=Stage.TRANSPORT,
    scope=Scope.ROBOT,
    parameters=(EffectParameter("delay", "s", 0.0, -0.5, 0.5, 0.02, far=_DELAYS_S),),
    apply=_late("delay", 1.0),
    remove=_late("delay", -1.0),
    experiments=("walk",),
    formula="y(t) = x(t − d) on every quantity of the body stream",
    source="NAO CoP self-calibration: fixed telemetry delay of 20 ms",
    remedy="give the delay to the recipe (`delay_s`), or stamp samples where they are taken",
    needs=("com_acc_mps2",),
    mimics=("lag", "sensor_lag", "clock_drift", "acceleration_delay"),
    separates="the same walk with all smoothing of the body's stream switched off; a motion only "
    "if it stops within one and a half delays, both streams logged at 500 Hz or more",
    tolerance=1e-3,
    anticipates=True,
    traits=(Trait.MEMORY,),
)

ACCELERATION_DELAY = Effect(
    name="acceleration_delay",
    stage=Stage.TRANSPORT,
    scope=Scope.ROBOT,
    parameters=(EffectParameter("acceleration_delay", "s", 0.0, -0.2, 0.2, 0.02, far=_LATE_S),),
    apply=_late("acceleration_delay", 1.0, _DIFFERENTIATED),
    remove=_late("acceleration_delay", -1.0, _DIFFERENTIATED),
    experiments=("walk",),
    formula="y(t) = x(t − d) on the CoM's acceleration and the rate of angular momentum alone",
    source="one-sided filters of velocities and accelerations in state estimators",
    remedy="filter the acceleration forwards and backwards, or delay CoM and feet as much",
    needs=("com_acc_mps2",),
    mimics=("delay", "lag", "angular_momentum"),
    separates="the same walk with the acceleration differentiated anew from the logged CoM",
    tolerance=1e-3,
    anticipates=True,
    traits=(Trait.MEMORY,),
)

DROPPED_SAMPLES = Effect(
    name="dropped_samples",
    traits=(Trait.UNGRADED,),
    stage=Stage.TRANSPORT,
    scope=Scope.ROBOT,
    parameters=(
        EffectParameter("dropped_samples", "-", 0.0, 0.0, 0.95, 0.02),
        EffectParameter("dropped_seed", "-", 0.0, 0.0, 1e6, 1.0, True, (0.0,)),
    ),
    apply=on_readings(_drop),
    remove=on_readings(unchanged),
    experiments=("walk", "hang"),
    of_recording=True,
    formula="y_k = x of the last row that arrived; a share p of the rows does not",
    source="lossy radio or bus; telemetry that repeats its last packet",
    remedy="shorten the bus, lower the rate, or log a packet counter and leave repeats out",
    mimics=("quantisation", "channel_stuck"),
    separates="count exactly repeated rows: `footcal check`",
    invertible=False,
)

SMOOTHING = Effect(
    name="smoothing",
    stage=Stage.TRANSPORT,
    scope=Scope.ROBOT,
    parameters=(
        EffectParameter("smoothing", "s²", 0.0, -0.01, 0.01, 2e-4),
        EffectParameter("smoothing_fourth", "s⁴", 0.0, -1e-3, 1e-3, 1e-7),
    ),
    apply=_smoothed(1.0),
    remove=_smoothed(-1.0),
    experiments=("walk",),
    formula="y = x + v/2 d²x/dt² + u/24 d⁴x/dt⁴ on what was differentiated: a symmetric filter, "
    "moments v and u",
    source="differences of encoder readings over a window, as every state estimator takes them",
    remedy="differentiate over a shorter window",
    needs=("com_acc_mps2",),
    anticipates=True,
)
"""No row of the table: fitted beside every cause of a walk."""

EFFECTS = (LAG, CLOCK_DRIFT, DELAY, ACCELERATION_DELAY, DROPPED_SAMPLES)
