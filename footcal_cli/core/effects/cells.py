"""Memoryless distortions of a sensing channel, in newtons (newton metres on torque axes).

x is the true load of a channel, y what it shows before scale and bias.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.contract import (
    DRIFT_TAKES_IT,
    Effect,
    EffectParameter,
    GridOf,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    columns_of,
    is_six_axis,
    on_readings,
    over,
    plus,
    times,
    unchanged,
)
from footcal_cli.core.log import EXPERIMENT_NAMES, Log
from footcal_cli.core.parameters import FloatArray

TEMPERATURE_REFERENCE_DEGC = 25.0
"""Temperature at which scale and bias are stated."""

_NEWTON_STEPS = 8


def _bend(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return x + theta["quadratic"] * x**2, state


def _unbend(y: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    root = np.sqrt(np.clip(1.0 + 4.0 * theta["quadratic"] * y, 0.0, None))
    return 2.0 * y / (1.0 + root), state


def _cubic(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return x + theta["cubic"] * x**3, state


def _uncubic(y: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    """``x = (2/k) sinh(asinh(3ky/2)/3)``, ``k = √(3c)``; sin and arcsin for a falling cubic.

    Beyond its turning point a falling cubic has no inverse: the nearest load is taken.
    """
    cubic = np.broadcast_to(theta["cubic"], y.shape[1:])
    x = y.copy()
    for c in np.flatnonzero(cubic):
        k = np.sqrt(3.0 * abs(cubic[c]))
        third = 1.5 * k * y[:, c]
        if cubic[c] > 0:
            x[:, c] = 2.0 / k * np.sinh(np.arcsinh(third) / 3.0)
        else:
            x[:, c] = 2.0 / k * np.sin(np.arcsin(np.clip(third, -1.0, 1.0)) / 3.0)
    return x, state


def _deaden(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    width = theta["dead_zone_width"]
    return x - theta["dead_zone"] * np.clip(x, -width, width), state


def _undeaden(y: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    kept, width = 1.0 - theta["dead_zone"], theta["dead_zone_width"]
    lost = np.sign(y) * theta["dead_zone"] * width
    return np.where(np.abs(y) <= kept * width, y / kept, y + lost), state


def _soften(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    """``y = x − s w (1 − exp(−|x|/w)) sgn x``: a dead zone that ends smoothly."""
    width = theta["dead_zone_width"]
    return x + theta["dead_zone"] * width * np.sign(x) * np.expm1(-np.abs(x) / width), state


def _unsoften(y: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    """By Newton's method from the sharp inverse, beyond the root of a curve that bends one way."""
    share, width = theta["dead_zone"], theta["dead_zone_width"]
    x, _ = _undeaden(y, log, theta, state)
    for _ in range(_NEWTON_STEPS):
        shown, _ = _soften(x, log, theta, state)
        x = x - (shown - y) / (1.0 - share * np.exp(-np.abs(x) / width))
    return x, state


def _hinge(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return x + theta["hinge"] * np.maximum(x - theta["hinge_load"], 0.0), state


def _unhinge(y: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    above = np.maximum(y - theta["hinge_load"], 0.0)
    return y - above + above / (1.0 + theta["hinge"]), state


def _saturate(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    limit = theta["saturation_limit"]
    return x - theta["saturation"] * (x - np.clip(x, -limit, limit)), state


def _unsaturate(y: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    limit, kept = theta["saturation_limit"], 1.0 - theta["saturation"]
    above = y - np.clip(y, -limit, limit)
    return y - above + above / np.where(kept > 0, kept, 1.0), state


def _quantise(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    step = np.broadcast_to(theta["quantisation"], x.shape)
    steps = np.divide(x, step, out=np.zeros_like(x), where=step > 0)
    return np.where(step > 0, np.rint(steps) * step, x), state


def mixing(log: Log, share: FloatArray, heard: FloatArray) -> FloatArray:
    """Matrix (c, c): each cell adds a share of what it hears of its foot's other cells.

    It hears the mean of all others (`heard` 0), or the cell that many places before it in the
    order in which the foot's cells are wired and read.
    """
    matrix = np.eye(len(log.channels))
    if is_six_axis(log.channels):
        return matrix
    for cells in columns_of(Scope.FOOT, log.channels):
        count = len(cells)
        for at, cell in enumerate(cells):
            before = int(heard[cell])
            others = [cells[(at - before) % count]] if before else np.delete(cells, at)
            for other in others:
                if other != cell:
                    matrix[cell, other] += share[cell] / len(others)
    return matrix


def _crosstalk(x: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return x @ mixing(log, theta["crosstalk"], theta["crosstalk_from"]).T, state


def _uncrosstalk(y: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    own = np.linalg.solve(mixing(log, theta["crosstalk"], theta["crosstalk_from"]), y.T).T
    return np.asarray(own, dtype=np.float64), state


def _warmth(log: Log) -> FloatArray:
    """Temperature above the reference, shape (n, 1); 0 where none was logged."""
    temperature = log.known.get("temperature_degc")
    if temperature is None:
        return np.zeros((len(log), 1))
    warmth: FloatArray = temperature.reshape(-1, 1) - TEMPERATURE_REFERENCE_DEGC
    return warmth


def _scale(_log: Log, theta: Theta) -> FloatArray:
    return 1.0 + theta["scale_change"]


def _warm_scale(log: Log, theta: Theta) -> FloatArray:
    return 1.0 + theta["temperature_scale"] * _warmth(log)


def _warm_bias(log: Log, theta: Theta) -> FloatArray:
    return theta["temperature_bias"] * _warmth(log)


def _flipped(_log: Log, theta: Theta) -> FloatArray:
    return 1.0 - 2.0 * theta["sign_flip"]


CROSSTALK = Effect(
    name="crosstalk",
    traits=(Trait.MIXTURE,),
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(
        EffectParameter("crosstalk", "-", 0.0, -0.4, 0.4, 0.02),
        EffectParameter(
            "crosstalk_from", "channel", 0.0, 0.0, 127.0, 1.0, True, (0.0, 1.0, 2.0, 3.0)
        ),
    ),
    apply=on_readings(_crosstalk),
    remove=on_readings(_uncrosstalk),
    experiments=("weights", "placements", "stand", "walk"),
    formula="y_i = x_i + κ_i · mean of the foot's other cells, or · the n-th cell before it",
    source="NAO CoP self-calibration, section 5.1; OIML R 76 eccentric loading; multiplexed "
    "converters",
    remedy="load the cells one at a time; decouple their seats or the wiring of the amplifier",
    mimics=("cell_position", "scale_bias"),
    separates="weights on single cells while all cells are read",
)

NONLINEARITY = Effect(
    name="nonlinearity",
    traits=(Trait.CURVE, Trait.SMOOTH),
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(EffectParameter("quadratic", "1/N", 0.0, -0.1, 0.1, 1e-3),),
    apply=on_readings(_bend),
    remove=on_readings(_unbend),
    experiments=EXPERIMENT_NAMES,
    formula="y = x + q x²; inverse x = 2y / (1 + √(1 + 4 q y))",
    source="load-cell data sheets: combined error; NAO CoP self-calibration, Table 2 (falling "
    "sensitivity)",
    remedy="calibrate with at least six loads over the whole range and keep the quadratic term",
    mimics=("load_bypass", "nonlinearity_cubic", "hinge", "saturation"),
    separates="weights up and down over the whole range, cell by cell",
)

NONLINEARITY_CUBIC = Effect(
    name="nonlinearity_cubic",
    traits=(Trait.CURVE, Trait.SMOOTH, Trait.SMALL_CELL),
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(EffectParameter("cubic", "1/N²", 0.0, -0.01, 0.01, 2e-5),),
    apply=on_readings(_cubic),
    remove=on_readings(_uncubic),
    experiments=("weights", "placements", "stand", "walk", "pose"),
    formula="y = x + k x³; inverse by Newton's method",
    source="symmetric (odd) part of a transducer's curve",
    remedy="calibrate with at least eight loads over the whole range and keep the cubic term",
    mimics=("nonlinearity", "saturation", "hinge", "load_bypass"),
    separates="a ladder of many weights up to full scale",
)

DEAD_ZONE = Effect(
    name="dead_zone",
    traits=(Trait.CURVE, Trait.KNEE, Trait.SMALL_CELL),
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(
        EffectParameter("dead_zone", "-", 0.0, -0.9, 0.95, 0.1),
        EffectParameter(
            "dead_zone_width", "N", 4.0, 0.02, 1e4, 4.0, True, (0.05, 0.1, 0.2, 0.4), GridOf.LOAD
        ),
    ),
    apply=on_readings(_deaden),
    remove=on_readings(_undeaden),
    other_form=(on_readings(_soften), on_readings(_unsoften)),
    experiments=EXPERIMENT_NAMES,
    formula="y = x − s · clip(x, −w, w)",
    source="seats with play, force-sensing resistors near zero load",
    remedy="preload the cell or never use it below the width; check for a loose seat",
    mimics=("hinge", "nonlinearity"),
    separates="no weighing can: it equals a scale change plus a hinge; look at the unloaded seat",
)

HINGE = Effect(
    name="hinge",
    traits=(Trait.CURVE, Trait.KNEE, Trait.SMALL_CELL),
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(
        EffectParameter("hinge", "-", 0.0, -0.9, 3.0, 0.1),
        EffectParameter(
            "hinge_load", "N", 8.0, 0.02, 1e4, 8.0, True, (0.1, 0.2, 0.4, 0.6, 0.8), GridOf.LOAD
        ),
    ),
    apply=on_readings(_hinge),
    remove=on_readings(_unhinge),
    experiments=EXPERIMENT_NAMES,
    formula="y = x + s · max(x − h, 0)",
    source="a second load path that closes at the load h",
    remedy="look for a part that starts to touch at that load",
    mimics=("dead_zone", "saturation", "nonlinearity", "load_bypass"),
    separates="a fine ladder of weights around the knee",
)

SCALE_CHANGE = Effect(
    name="scale_change",
    traits=(Trait.GAIN,),
    unseen_walking="its gain follows it; asked for where nothing else explains the walk",
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(EffectParameter("scale_change", "-", 0.0, -0.9, 1.0, 0.02),),
    apply=on_readings(times(_scale)),
    remove=on_readings(over(_scale)),
    experiments=("stand", "walk"),
    formula="y = (1 + g) x: the scale is no longer what it was calibrated to",
    source="overload, a bent flexure, a loose screw, another amplifier since the calibration",
    remedy="calibrate these cells again: offline-fit with weights",
    mimics=("creep", "temperature_scale", "nonlinearity", "load_bypass"),
    separates="weights on each cell, as in the calibration before",
)

TEMPERATURE_SCALE = Effect(
    name="temperature_scale",
    unseen_walking=DRIFT_TAKES_IT + "weigh before and after warming up",
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(EffectParameter("temperature_scale", "1/K", 0.0, -0.02, 0.02, 5e-4),),
    apply=on_readings(times(_warm_scale)),
    remove=on_readings(over(_warm_scale)),
    experiments=("weights", "placements", "stand", "walk", "hang"),
    formula="y = x (1 + k (T − 25 °C))",
    source="load-cell data sheets: temperature effect on span; OIML R 60",
    remedy="calibrate at two temperatures, or at the one the robot works at",
    needs=("temperature_degc",),
    mimics=("creep", "temperature_bias"),
    separates="the same weight before and after warming up, with a temperature sensor",
)

TEMPERATURE_BIAS = Effect(
    name="temperature_bias",
    unseen_walking=DRIFT_TAKES_IT + "hold a long stand with a temperature sensor",
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(EffectParameter("temperature_bias", "N/K", 0.0, -1.0, 1.0, 0.02),),
    apply=on_readings(plus(_warm_bias)),
    remove=on_readings(plus(_warm_bias, -1.0)),
    experiments=("weights", "placements", "stand", "walk", "hang"),
    formula="y = x + k (T − 25 °C)",
    source="load-cell data sheets: temperature effect on zero; OIML R 60",
    remedy="re-zero after warm-up; log the temperature",
    needs=("temperature_degc",),
    mimics=("bias_drift", "creep"),
    separates="ten minutes unloaded while warming up, then cooling down",
)

SIGN_FLIP = Effect(
    name="sign_flip",
    traits=(Trait.SMALL_CELL, Trait.WHOLE),
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(EffectParameter("sign_flip", "-", 0.0, 0.0, 1.0, 0.3),),
    apply=on_readings(times(_flipped)),
    remove=on_readings(over(_flipped)),
    experiments=EXPERIMENT_NAMES,
    formula="y = (1 − 2 s) x, s = 1 for a flipped channel",
    source="signal wires exchanged",
    remedy="exchange the two signal wires, or change the sign of the scale",
    mimics=("axis_flip", "scale_bias"),
    separates="press the cell by hand: the reading must grow",
)

SATURATION = Effect(
    name="saturation",
    traits=(Trait.CURVE, Trait.KNEE, Trait.SMALL_CELL),
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(
        EffectParameter("saturation", "-", 0.0, 0.0, 1.0, 0.3),
        EffectParameter(
            "saturation_limit",
            "N",
            20.0,
            0.02,
            1e4,
            20.0,
            True,
            (0.25, 0.5, 0.7, 0.85, 0.95),
            GridOf.LOAD,
        ),
    ),
    apply=on_readings(_saturate),
    remove=on_readings(_unsaturate),
    experiments=EXPERIMENT_NAMES,
    formula="y = x − s · (x − clip(x, −L, L)), s = 1 for a hard stop",
    source="amplifier or converter at the end of its range; mechanical overload stop",
    remedy="lower the gain of the amplifier, or leave loads beyond the limit out",
    mimics=("hinge", "nonlinearity", "load_bypass"),
    separates="weights above and below the limit, cell by cell",
    invertible=False,
)

QUANTISATION = Effect(
    name="quantisation",
    traits=(Trait.UNGRADED,),
    stage=Stage.CELL,
    scope=Scope.CHANNEL,
    parameters=(EffectParameter("quantisation", "N", 0.0, 0.0, 50.0, 0.1),),
    apply=on_readings(_quantise),
    remove=on_readings(unchanged),
    experiments=EXPERIMENT_NAMES,
    formula="y = q · round(x / q)",
    source="NAO CoP self-calibration: smallest visible force step 0.5 N",
    remedy="log the raw counts instead of rounded forces; average while loads vary",
    mimics=("dead_zone", "hysteresis"),
    separates="a slowly growing load: the reading rises in steps",
    invertible=False,
)

EFFECTS = (
    CROSSTALK,
    NONLINEARITY,
    NONLINEARITY_CUBIC,
    DEAD_ZONE,
    HINGE,
    SCALE_CHANGE,
    TEMPERATURE_SCALE,
    TEMPERATURE_BIAS,
    SIGN_FLIP,
    SATURATION,
    QUANTISATION,
)
"""In the order in which a load passes them."""
