"""Distortions of a sensing channel that remember: hysteresis, creep, lag, drift and jumps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.effects.contract import (
    DRIFT_TAKES_IT,
    ArrayTransform,
    Effect,
    EffectParameter,
    GridOf,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    on_readings,
)
from footcal_cli.core.effects.memory import (
    RowIntervals,
    first_order_low_pass,
    invert_low_pass,
    linear_recurrence,
    low_pass_decay,
    moment,
    play,
    plus_since,
    recording,
    row_intervals,
    settling,
    settling_rate,
)
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray

STEEPEST = 0.95
"""Share of its slope that a cell may lose, or gain, where its load turns: ``1 − w/2r > 0``, for no
cell shows less under more load. Only that limits the width of a loop, not any number of newtons."""
BINS = 24
"""Loads at which rising and falling readings are compared."""
LOOP_FORM_ERROR = 0.05
"""Sd of the width that a play fitted to another loop has, as a share: Dahl's, Bouc and Wen's and
Maxwell's slip model over ladders of weights and over gaits (tests/core/test_loops.py)."""
_TURN = 0.02
"""Share of the range of loads by which a load must turn back before it counts as turning."""


def loop_width(before: Log, after: Log) -> FloatArray:
    """Widest difference between readings of falling and rising loads at one load, shape (c,).

    The hysteresis error of VDI/VDE 2638 and OIML R 60, over the loads that were recorded; zero
    where loads do not return.

    Parameters
    ----------
    before, after
        The same recording without and with the effect.
    """
    load, added = before.readings, after.readings - before.readings
    low = load.min(axis=0)
    span = np.ptp(load, axis=0)
    fresh = recording(before.time_s, None).fresh
    # held by a play, a direction is not turned by noise
    held = play(load, _TURN * span, load[0], fresh)
    step = np.where(fresh[:, None], 1.0, np.sign(np.diff(held, axis=0, prepend=held[:1] - 1.0)))
    last = np.maximum.accumulate(np.where(step != 0, np.arange(len(step))[:, None], 0), axis=0)
    rising = np.take_along_axis(step, last, axis=0) > 0
    share = (load - low) / np.where(span > 0, span, 1.0)
    place = np.minimum((BINS * share).astype(np.int64), BINS - 1)
    return np.array([_widest(*column) for column in zip(place.T, rising.T, added.T, strict=True)])


def _widest(place: FloatArray, rising: FloatArray, added: FloatArray) -> float:
    """Largest difference of the means over falling and rising rows of one place, and its sign."""
    number = place + BINS * rising.astype(np.int64)
    count = np.bincount(number, minlength=2 * BINS)
    mean = np.bincount(number, added, minlength=2 * BINS) / np.maximum(count, 1)
    apart = np.where((count[:BINS] > 0) & (count[BINS:] > 0), mean[:BINS] - mean[BINS:], 0.0)
    return float(apart[np.argmax(np.abs(apart))])


MOVING = ("walk",)
"""Experiments whose loads change quickly enough to show a lag of milliseconds."""


def _hysteresis(x: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    reach, lost = theta["hysteresis_reach"], _lost_slope(theta)
    last, start = state or (None, np.zeros(x.shape[1]))
    passed, last = row_intervals(log, last)
    z = play(x, reach, start, passed.fresh)
    return x + lost * (z - x), (last, z[-1])


def _lost_slope(theta: Theta) -> FloatArray:
    """``w/2r``, the share of its slope that a cell loses where its load turns."""
    share = 0.5 * theta["hysteresis_width"] / theta["hysteresis_reach"]
    return np.clip(share, -STEEPEST, STEEPEST)


def _widest_loop(shape: Mapping[str, float]) -> float:
    return 2.0 * STEEPEST * shape["hysteresis_reach"]


def _unhysteresis(y: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    reach = theta["hysteresis_reach"]
    yielding = 1.0 - _lost_slope(theta)
    last, start = state or (None, np.zeros(y.shape[1]))
    passed, last = row_intervals(log, last)
    z = play(y, reach * yielding, start, passed.fresh)
    return y / yielding + (1.0 - 1.0 / yielding) * z, (last, z[-1])


def _creep(name: str) -> ArrayTransform:
    def crept(x: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
        last, start = state or (None, np.zeros(x.shape[1]))
        passed, last = row_intervals(log, last)
        fresh, decay = _forgetting(passed, theta[f"{name}_time"])
        slow = linear_recurrence(np.where(fresh, 0.0, decay), (1.0 - decay) * x, start)
        return x + theta[name] * slow, (last, slow[-1])

    return crept


def _uncreep(name: str) -> ArrayTransform:
    def rested(y: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
        last, start = state or (None, np.zeros(y.shape[1]))
        passed, last = row_intervals(log, last)
        fresh, decay = _forgetting(passed, theta[f"{name}_time"])
        share = 1.0 / (1.0 + theta[name] * (1.0 - decay))
        drive = (1.0 - decay) * share * y
        slow = linear_recurrence(np.where(fresh, 0.0, decay * share), drive, start)
        return y - theta[name] * slow, (last, slow[-1])

    return rested


def _forgetting(passed: RowIntervals, time_constant_s: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Rows that start rested (n, 1), and the decay since the row before (n, c)."""
    return passed.fresh[:, None], low_pass_decay(passed.interval_s, time_constant_s)


def _lag(x: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return first_order_low_pass(x, log.time_s, theta["sensor_lag"], state)


def _unlag(y: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return invert_low_pass(y, log.time_s, theta["sensor_lag"], state)


def _drift(since_s: FloatArray, theta: Theta) -> FloatArray:
    return theta["bias_drift"] * settling(since_s[:, None], theta["drift_settling"])


def _jump(since_s: FloatArray, theta: Theta) -> FloatArray:
    return theta["bias_jump"] * (since_s[:, None] >= theta["jump_time"])


HYSTERESIS = Effect(
    name="hysteresis",
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(
        EffectParameter("hysteresis_width", "N", 0.0, -1000.0 * STEEPEST, 1000.0 * STEEPEST, 0.3),
        EffectParameter(
            "hysteresis_reach",
            "N",
            4.0,
            0.001,
            1e4,
            4.0,
            True,
            (0.05, 0.1, 0.2, 0.4, 0.8),
            GridOf.LOAD,
        ),
    ),
    traits=(Trait.MEMORY, Trait.SPECTRUM),
    by_column=True,
    apply=on_readings(_hysteresis),
    remove=on_readings(_unhysteresis),
    experiments=("weights", "stand", "walk", "hang"),
    formula="y = x + w (z − x) / 2r, play z_k = min(max(z_{k−1}, x_k − r), x_k + r)",
    source="Prandtl–Ishlinskii operator; inverse after Kuhnen, Eur. J. Control 9 (2003); w < 0: "
    "the reading runs ahead of its load, as behind gauges that compensate creep too much",
    remedy="approach every load from the same side; check glued seats and screws",
    mimics=("sensor_lag", "creep"),
    separates="a staircase of weights up and down with long holds",
    most=_widest_loop,
    stated=loop_width,
    stated_as="widest loop",
    form_error=LOOP_FORM_ERROR,
)


def _creep_row(name: str, time_s: float, grid: tuple[float, ...], what: str) -> Effect:
    """One creep with its own time constant; two of them in a chain make a two-stage creep."""
    return Effect(
        name=name,
        traits=(Trait.TIMED, Trait.MEMORY, Trait.SPECTRUM),
        unseen_walking=DRIFT_TAKES_IT + "hold one weight for ten minutes",
        stage=Stage.CELL,
        scope=Scope.CHANNEL,
        parameters=(
            EffectParameter(name, "-", 0.0, -0.3, 1.0, 0.02),
            EffectParameter(f"{name}_time", "s", time_s, 0.05, 1e5, time_s, True, grid),
        ),
        by_column=True,
        apply=on_readings(_creep(name)),
        remove=on_readings(_uncreep(name)),
        experiments=("weights", "stand", "walk"),
        formula="y = x + c s, ds/dt = (x − s) / τ; removed by the same recursion solved for x",
        source=f"OIML R 60 (creep and minimum dead-load output return): {what}",
        remedy="read each load after the same waiting time; unload between measurements",
        mimics=("bias_drift", "temperature_bias", "hysteresis"),
        separates="one weight held for ten minutes, then ten minutes unloaded",
    )


CREEP = _creep_row("creep", 60.0, (10.0, 30.0, 60.0, 120.0, 300.0), "the first minutes")
CREEP_SLOW = _creep_row("creep_slow", 900.0, (600.0, 900.0, 1800.0), "the slow part")

SENSOR_LAG = Effect(
    name="sensor_lag",
    traits=(Trait.TIMED, Trait.MEMORY, Trait.LOW_PASS),
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(EffectParameter("sensor_lag", "s", 0.0, 0.0, 0.5, 0.02),),
    by_column=True,
    apply=on_readings(_lag),
    remove=on_readings(_unlag),
    experiments=MOVING,
    formula="τ dy/dt = x − y, x linear between samples; inverse by the same recursion",
    source="amplifier and converter filters (HX711 settling, averaging firmware)",
    remedy="raise the converter's rate, switch its averaging off, or give the lag to the recipe",
    mimics=("delay", "hysteresis"),
    separates="twenty quick taps, each rising within 10 ms",
)

BIAS_DRIFT = Effect(
    name="bias_drift",
    traits=(Trait.TIMED, Trait.MEMORY, Trait.ZERO),
    unseen_walking=DRIFT_TAKES_IT + "log ten unloaded minutes",
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    by_column=True,
    parameters=(EffectParameter("bias_drift", "N/s", 0.0, -10.0, 10.0, 5e-4), settling_rate()),
    apply=on_readings(plus_since(_drift)),
    remove=on_readings(plus_since(_drift, -1.0)),
    experiments=("weights", "placements", "stand", "walk"),
    of_recording=True,
    formula="y = x + k t₁ (1 − exp(−r t)) / (1 − exp(−r t₁)), t₁ = 30 min; with r = 0 x + k t",
    source="load-cell data sheets: zero drift, warm-up time; NAO CoP self-calibration, open points",
    remedy="switch on half an hour before, and re-zero often, e.g. at every swing",
    mimics=("temperature_bias", "creep"),
    separates="ten minutes unloaded at a constant temperature",
)

BIAS_JUMP = Effect(
    name="bias_jump",
    traits=(Trait.TIMED, Trait.MEMORY),
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    by_column=True,
    parameters=(
        EffectParameter("bias_jump", "N", 0.0, -1e3, 1e3, 0.5),
        moment("jump_time", 10),
    ),
    apply=on_readings(plus_since(_jump)),
    remove=on_readings(plus_since(_jump, -1.0)),
    experiments=("weights", "placements", "stand", "walk"),
    of_recording=True,
    formula="y = x + J for t − t₀ ≥ t_J",
    source="mechanical shock, a tugged cable, a re-tared amplifier",
    remedy="check the cell's cable and seat; calibrate the parts before and after apart",
    mimics=("bias_drift", "temperature_bias"),
    separates="unload before and after the suspected moment",
)

EFFECTS = (HYSTERESIS, CREEP, CREEP_SLOW, SENSOR_LAG, BIAS_DRIFT, BIAS_JUMP)
"""In the order in which a load passes them."""
