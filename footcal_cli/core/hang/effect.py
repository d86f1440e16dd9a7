"""A hanging leg's weight, CoM and tilts as a link of the chain, and the residual under it.

The balance of a hanging leg knows its weight, CoM and direction of gravity from `Log.known`. What
`hang-calib` fits of them is more than the table's effects have (harmonics, any orientation), so
that it comes as an effect of its own, with the names that `hang-calib` writes. Temperature and time
of a log are those since the fit's references. `hang-calib` fits the residual of this chain, and
`diagnose` judges it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.chain import Chain, Link, chain_of, link
from footcal_cli.core.effects.calibration import AXES, OFFSET, wrench_of
from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    Transform,
)
from footcal_cli.core.experiments.hang import EXPERIMENT
from footcal_cli.core.hang.model import (
    DRIFT,
    WARMTH,
    HangModel,
    leg_com_acc_t_mps2,
    leg_com_t_m,
)
from footcal_cli.core.hang.runs import RUN, of_no_leg
from footcal_cli.core.inference.reduction import Probe
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, ParameterSet


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
        traits=(Trait.HUNG,),
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
    return chain_of(
        [
            link(OFFSET, channels_of_leg(model)),
            Link(hanging_effect(model), {model.leg: (model.leg,)}),
        ]
    )


def channels_of_leg(model: HangModel) -> tuple[str, ...]:
    """Channels of the leg's transducer."""
    return tuple(f"{model.leg}.{axis}" for axis in AXES)


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
        direction = model.gravity_dir_t(np.array([theta[name][0] for name in tilts]))
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


@dataclass(frozen=True)
class HangResidual:
    """The experiment's residual under the chain of one leg, by the parameters of a model.

    Parameters
    ----------
    model
        What hangs, in which runs.
    probe
        As many rows of each run as it has regressors, at rest.
    """

    model: HangModel
    probe: Probe

    @classmethod
    def of(cls, model: HangModel) -> HangResidual:
        """Of what hangs."""
        names = model.parameters(0.0).names
        probe = Probe.of(EXPERIMENT, hanging_chain(model), names, *_rows_at_rest(model))
        return cls(model, probe)

    def errors(self, log: Log, theta: FloatArray) -> FloatArray:
        """Measured − demanded wrench of each row, shape (n, 6), N and Nm."""
        return self.probe.errors(log, theta)

    def coefficients(self, theta: FloatArray) -> FloatArray:
        """C of the residual ``w − z Cᵀ`` of a leg at rest, by regressor, shape (L, 6, d)."""
        return -self.probe.coefficients(theta)

    def at_rest(self, log: Log, theta: FloatArray) -> FloatArray:
        """Readings without what the turning of the leg adds, shape (n, 6)."""
        if not log.known["shaft_radps"].any():
            return log.readings
        zero = np.zeros(len(log))
        still = log.with_known(shaft_radps=zero, shaft_radps2=zero)
        return log.readings + self.errors(log, theta) - self.errors(still, theta)


def _rows_at_rest(model: HangModel) -> tuple[Log, FloatArray]:
    """As many rows of each run as it has regressors z, which read nothing; and their z (d, d).

    Angles all round the turn, one row at one degree more, one a second later; nothing turns.
    """
    harmonics, runs = model.com_columns, len(model.nominal_dir_t)
    size = harmonics + model.temperature + model.drift
    unit = np.eye(size)
    turn = np.where(np.arange(size) < harmonics, np.arange(size) * 2.0 * np.pi / harmonics, 0.0)
    warmth = unit[harmonics] if model.temperature else np.zeros(size)
    late = unit[-1] if model.drift else np.zeros(size)
    known = {
        "phase_rad": np.tile(turn, runs),
        "temperature_degc": np.tile(warmth, runs),
        **of_no_leg(model.nominal_dir_t.repeat(size, axis=0)),
        RUN: np.repeat(np.arange(float(runs)), size),
    }
    log = Log(
        EXPERIMENT.name,
        channels_of_leg(model),
        np.tile(late, runs),
        np.zeros((runs * size, 6)),
        known,
        np.repeat(np.arange(runs), size),
    )
    return log, model.regressors(turn, warmth, late)
