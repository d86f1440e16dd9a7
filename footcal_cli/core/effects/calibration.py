"""Newtons to counts and back: scale and bias of cells, offsets of six-axis transducers."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    on_readings,
    on_wrenches,
    plus,
)
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

AXES: tuple[str, ...] = ("fx", "fy", "fz", "tx", "ty", "tz")
"""Order of a wrench's components."""
AXIS_UNITS: tuple[str, ...] = ("N", "N", "N", "Nm", "Nm", "Nm")


def per_axis(
    prefix: str, force_sd: float, torque_sd: float, bound: float, per: str = ""
) -> tuple[EffectParameter, ...]:
    """One size per axis of a transducer: ``<prefix>_fx`` in N, ..., ``<prefix>_tz`` in Nm."""
    return tuple(
        EffectParameter(
            f"{prefix}_{axis}",
            unit + per,
            0.0,
            -bound,
            bound,
            force_sd if unit == "N" else torque_sd,
        )
        for axis, unit in zip(AXES, AXIS_UNITS, strict=True)
    )


def wrench_of(theta: Theta, prefix: str) -> FloatArray:
    """The sizes of `per_axis` as wrenches, shape (legs, 6)."""
    return np.stack([theta[f"{prefix}_{axis}"] for axis in AXES], axis=-1)


def _to_counts(x: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return (x - theta["bias"]) / theta["scale"], state


def _to_newtons(y: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    return y * theta["scale"] + theta["bias"], state


def _offset(_log: Log, theta: Theta) -> FloatArray:
    return wrench_of(theta, "offset")


SCALE_BIAS = Effect(
    name="scale_bias",
    traits=(Trait.CALIBRATION,),
    stage=Stage.CALIBRATION,
    scope=Scope.CHANNEL,
    parameters=(
        EffectParameter("scale", "N/count", 1.0, -np.inf, np.inf, 0.02),
        EffectParameter("bias", "N", 0.0, -np.inf, np.inf, 0.3),
    ),
    apply=on_readings(_to_counts),
    remove=on_readings(_to_newtons),
    experiments=("weights", "placements", "stand", "walk"),
    formula="F = scale · S + bias, so S = (F − bias) / scale",
    source="NAO CoP self-calibration, eqs. (1)(2)",
    remedy="calibrate: offline-fit with weights, then static-init and online-replay",
    mimics=("sign_flip", "nonlinearity", "temperature_bias"),
    separates="weights from zero to full scale on each cell",
)

OFFSET = Effect(
    name="offset",
    traits=(Trait.CALIBRATION,),
    stage=Stage.CALIBRATION,
    scope=Scope.LEG,
    parameters=per_axis("offset", 3.0, 0.3, np.inf),
    apply=on_wrenches(plus(_offset)),
    remove=on_wrenches(plus(_offset, -1.0)),
    experiments=("hang", "pose", "stand", "walk"),
    formula="w_measured = w_applied + w_offset",
    source="Wu & Revzen, eq. (1)",
    remedy="calibrate: hang-calib; after months, again or from poses with lifted legs",
    mimics=("offset_drift", "leg_weight", "leg_com"),
    separates="hanging in two opposite pairs of orientations",
)

EFFECTS = (OFFSET, SCALE_BIAS)
