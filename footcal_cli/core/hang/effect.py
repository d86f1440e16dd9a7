"""A hanging leg's weight, CoM and tilts as a link of the chain, for `diagnose`.

The balance of a hanging leg knows its weight, CoM and direction of gravity from `Log.known`. What
`hang-calib` fits of them is more than the table's effects have (harmonics, any orientation), so
that it comes as an effect of its own, with the names that `hang-calib` writes. Temperature and time
of a log are those since the fit's references.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.chain import Chain, Link, chain_of, link
from footcal_cli.core.effects.calibration import OFFSET, wrench_of
from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    Scope,
    Stage,
    State,
    Theta,
    Transform,
)
from footcal_cli.core.hang.model import (
    AXES,
    DRIFT,
    WARMTH,
    HangModel,
    leg_com_acc_t_mps2,
    leg_com_t_m,
)
from footcal_cli.core.hang.runs import RUN
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import ParameterSet
from footcal_cli.core.spatial import rotation_exp


def hanging_effect(model: HangModel) -> Effect:
    """What is believed of one leg and its runs, replaced by what its parameters say.

    Only the leg of the model is touched. The believed quantities are overwritten whenever a log is
    corrected, so that nothing needs to be put back when one is distorted.
    """
    own = own_parameters(model)
    names = [name.split(".", 1)[1] for name in own.names]

    def kept(log: Log, _theta: Theta, state: State) -> tuple[Log, State]:
        return log, state

    return Effect(
        name=f"hanging of {model.leg}",
        stage=Stage.BODY,
        scope=Scope.LEG,
        parameters=tuple(
            EffectParameter(name, p.unit, 0.0, -np.inf, np.inf, p.step)
            for name, p in zip(names, own, strict=True)
        ),
        apply=kept,
        remove=_remove_of(model),
        experiments=("hang",),
        formula="w = [m (g u − r̈); r(φ) × m (g u − r̈)], u = exp([s]) e",
        source="Wu & Revzen, eqs. (4)-(7)",
        remedy="calibrate: hang-calib",
    )


def hanging_chain(model: HangModel) -> Chain:
    """All that `hang-calib` fits to a leg: offsets, and what hangs on them."""
    channels = tuple(f"{model.leg}.{axis}" for axis in AXES)
    return chain_of(
        [link(OFFSET, channels), Link(hanging_effect(model), {model.leg: (model.leg,)})]
    )


def own_parameters(model: HangModel) -> ParameterSet:
    """Weight, CoM and tilts; the offsets are the table's effect ``offset``."""
    return ParameterSet(
        tuple(
            p
            for p in model.parameters(0.0)
            if p.name.split(".", 1)[1] not in OFFSET.parameter_names
        )
    )


def _remove_of(model: HangModel) -> Transform:
    tilts = model.tilt_names()
    coms = model.com_names()

    def remove(log: Log, theta: Theta, state: State) -> tuple[Log, State]:
        if not log.channels[0].startswith(f"{model.leg}."):
            return log, state
        turn = model.tilt_design @ np.array([theta[name][0] for name in tilts])
        direction = (rotation_exp(turn) @ model.nominal_dir_t[..., None])[..., 0]
        com = np.array([theta[name][0] for name in coms]).reshape(3, model.com_columns)
        phase = log.known["phase_rad"]
        if "shaft_radps" in log.known:
            shaft = log.known["shaft_radps"], log.known["shaft_radps2"]
            moved = leg_com_acc_t_mps2(com, phase, *shaft) / model.gravity_mps2
            log = log.with_known(leg_acc_g=moved)
        readings = log.readings
        if model.temperature:
            warmth = log.known["temperature_degc"][:, None]
            readings = readings - warmth * wrench_of(theta, WARMTH)
        if model.drift:
            readings = readings - log.time_s[:, None] * wrench_of(theta, DRIFT)
        return log.with_readings(readings).with_known(
            leg_weight_n=np.full(len(log), theta["weight"][0]),
            leg_com_m=leg_com_t_m(com, phase),
            gravity_dir=direction[log.known[RUN].astype(np.int64)],
        ), state

    return remove
