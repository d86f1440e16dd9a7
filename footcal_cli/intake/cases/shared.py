"""Logs and a calibration as the case that `diagnose` takes: what all experiments share."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.chain import Chain, Link, link
from footcal_cli.core.contact import cycle_phase
from footcal_cli.core.diagnosis.second_path import StraightCell
from footcal_cli.core.effects import find_effect, having
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.core.experiments.contract import Experiment
from footcal_cli.core.inference.case import Case, every
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, Parameter
from footcal_cli.core.quality import Finding
from footcal_cli.errors import DataError
from footcal_cli.recipe.options import DiagnoseOptions
from footcal_cli.records.effects import effect_of
from footcal_cli.records.results import ParameterRecord, ParametersRecord
from footcal_cli.tables.table import Table
from footcal_cli.tables.units import SPELLINGS

if TYPE_CHECKING:
    from footcal_cli.intake.recordings import Recording
    from footcal_cli.session.session import Session


_FEWEST_SAMPLES = 2
_FOLLOWED_HZ, _JUDGED_HZ = 100.0, 20.0
"""Rates at which what remembers follows a walk, whose logs are filtered far below that, and at
which its residual is judged."""
OF_CELLS = "for load cells only; transducers have scale_matrix, cross_coupling and axis_flip"


def rate_of(log: Log, name: str) -> float:
    """Samples per second of what counts of a walk.

    Raises
    ------
    DataError
        Fewer than two samples count.
    """
    if len(log) < _FEWEST_SAMPLES:
        raise DataError(
            f"{len(log)} sample of this walk counts", file=name,
            remedy="check the stamps of both logs: of one clock, and in s (footcal check)",
        )  # fmt: skip
    return 1.0 / float(np.median(np.diff(log.time_s)))


@dataclass(frozen=True)
class CaseRead:
    """A case, what was found in the raw data, and what the logs came without.

    Parameters
    ----------
    case
        For the core.
    findings
        On raw data.
    untested
        Effect -> reason why these logs cannot test it.
    instead
        Effects in the units of these logs, by the name of the table's.
    before
        Parameters that stand before the case's channels in the calibration: a sensor's matrix.
    """

    case: Case
    findings: list[Finding]
    untested: dict[str, str]
    instead: Mapping[str, Effect] = field(default_factory=dict)
    before: Mapping[str, ParameterRecord] = field(default_factory=dict)

    def testable(self, table: Mapping[str, Effect]) -> dict[str, Effect]:
        """The effects that these logs can test."""
        return {
            name: self.instead.get(name, effect)
            for name, effect in table.items()
            if name not in self.untested
        }

    def gains(self, table: Mapping[str, Effect]) -> dict[str, Effect]:
        """What scales one cell or mixes several, of cells whose gains were known before."""
        if self.case.known is None or not self.case.drifts:
            return {}
        kinds = {Trait.GAIN, Trait.MIXTURE}
        return {name: effect for name, effect in table.items() if kinds & set(effect.traits)}

    def zeros(self, table: Mapping[str, Effect]) -> dict[str, Effect]:
        """What moves the zero of one sensor, which a tracked calibration follows."""
        if not self.case.drifts:
            return {}
        return {name: effect for name, effect in table.items() if Trait.ZERO in effect.traits}

    def like_a_gain(self, table: Mapping[str, Effect]) -> dict[str, Effect]:
        """What scales all forces, alike or nearly, of cells whose gains were known before."""
        if self.case.known is None:
            return {}
        kinds = {Trait.ALL_ALIKE, Trait.MIXTURE, Trait.OF_THE_SUM}
        return {name: effect for name, effect in table.items() if kinds & set(effect.traits)}


def followed(logs: Sequence[Log], rate_hz: float) -> tuple[tuple[Log, ...], int]:
    """The rows of walks that are kept, and every how many of these are judged."""
    often = max(int(rate_hz / _FOLLOWED_HZ), 1)
    stride = max(round(rate_hz / often / _JUDGED_HZ), 1)
    return tuple(every(log, often) for log in logs), stride


def chain_of(
    record: ParametersRecord | None, channels: Sequence[str], calibration: Sequence[str]
) -> tuple[Chain, dict[str, float]]:
    """The chain that a calibration describes, its effects included, and its values."""
    chain = Chain(())
    for name in calibration:
        chain = chain.with_link(link(find_effect(name), channels))
    values: dict[str, float] = {}
    if record is not None:
        values = record.values
        for item in record.effects:
            if item.effect not in calibration:
                chain = chain.with_link(Link(effect_of(item), dict(item.owners)))
    return chain, values


def baseline_of(session: Session[DiagnoseOptions]) -> ParametersRecord | None:
    """The calibration to start from, without the effects that `offline-fit` chose on these rows.

    A curve that it took out of them would leave nothing to find: what one command finds no other
    denies.
    """
    record = session.parameters
    if record is None or record.command != _CHOOSES:
        return record
    return without_chosen(record) if chose_effects(record, session.inputs.values()) else record


_CHOOSES = "offline-fit"
"""The command that chooses effects by held-out rows."""


def chose_effects(record: ParametersRecord, digests: Iterable[str]) -> bool:
    """Whether `offline-fit` chose effects by some of these logs, and by no calibration before."""
    given = any(name.endswith(".json") for name in record.inputs)
    chosen = bool(record.effects) and record.command == _CHOOSES and not given
    return chosen and not set(record.inputs.values()).isdisjoint(digests)


def without_chosen(record: ParametersRecord) -> ParametersRecord:
    """A calibration without its effects, and so of scales and biases alone."""
    taken = {
        f"{owner}.{parameter.name}"
        for item in record.effects
        for owner in item.owners
        for parameter in effect_of(item).parameters
    }
    kept = {name: value for name, value in record.parameters.items() if name not in taken}
    return record.model_copy(update={"effects": (), "parameters": kept, "covariance": ()})


def load_unit(tables: Sequence[Table]) -> tuple[str, float]:
    """Unit in which the loads are written, in short, and how many newtons one of it is."""
    columns = [c for table in tables for c in table.read_as if c.name.endswith("load_n")]
    newtons = columns[0].factor if columns else None
    if newtons is None:
        return "N", 1.0
    full = columns[0].unit.removesuffix(" (its weight)")
    return next((short for short, name in SPELLINGS.items() if name == full), full), newtons


def affine_parameters(channels: Sequence[str], values: dict[str, float]) -> tuple[Parameter, ...]:
    """Scale and bias of each channel as parameters that the data alone determine."""
    found = []
    for channel in channels:
        scale = values[f"{channel}.scale"]
        found.append(
            Parameter(f"{channel}.scale", "N/count", scale, scale=max(0.02 * abs(scale), 1e-12))
        )
        found.append(Parameter(f"{channel}.bias", "N", values[f"{channel}.bias"], scale=0.3))
    return tuple(found)


FINDING = 0.005
"""Share of the weight that a walk without a name may be off: what laboratory force platforms are
specified to, and more than an estimator knows of an acceleration."""
FINDING_MOMENT = 0.01
"""The same of a moment, as a share of the weight times the height of the CoM, where nobody logged
the angular momentum of limbs that swing: its rate is twice as large."""
_RCOND = 1e-14
GAIN_MOVES, BIAS_MOVES_N, BIAS_MOVES = 0.01, 0.1, 0.003
"""How far a calibration may have moved since it was made: its gain; its bias in newtons, and as a
share of the largest load that it was fitted to."""


def known_before(
    session: Session[DiagnoseOptions], channels: Sequence[str], values: dict[str, float]
) -> FloatArray | None:
    """Precision with which scale and bias were known before these logs, shape (2c, 2c).

    ``F = (1 + γ) F⁰ + β``: what the calibrating command reported, and γ, β by which it may have
    moved since. None where there is no such calibration, or it was made from these very logs alone.
    """
    record = session.parameters
    names = [f"{channel}.{what}" for channel in channels for what in ("scale", "bias")]
    if record is None or set(record.inputs.values()) <= set(session.inputs.values()):
        return None
    if any(name not in record.parameters or not record.parameters[name].sd for name in names):
        return None
    covariance = np.array(record.covariance_of(tuple(names)))
    for i, channel in enumerate(channels):
        at = slice(2 * i, 2 * i + 2)
        gain = GAIN_MOVES * np.array([values[f"{channel}.scale"], values[f"{channel}.bias"]])
        fitted = record.fitted_range.get(channel, {}).get("load")
        largest = 0.0 if fitted is None else max(abs(fitted.lowest), abs(fitted.highest))
        bias = np.array([0.0, max(BIAS_MOVES_N, BIAS_MOVES * largest)])
        covariance[at, at] += np.outer(gain, gain) + np.outer(bias, bias)
    return scaled_inverse(covariance, _RCOND)


def straight_cells(record: ParametersRecord | None) -> dict[str, StraightCell]:
    """Cells that a calibration has seen loaded with weights, by channel."""
    ranges = {} if record is None else record.fitted_range
    return {
        channel: StraightCell(
            own["load"].highest, own["line_error"].highest - own["line_error"].lowest
        )
        for channel, own in ranges.items()
        if {"load", "line_error"} <= own.keys()
    }


def finding_nm(logs: Sequence[Log], weight_n: float) -> float:
    """Moment from which what has no name is a finding in these walks, Nm."""
    if all("angmom_missing" not in log.known for log in logs):
        return 0.0
    height_m = float(np.median(np.concatenate([log.known["com_m"][:, 2] for log in logs])))
    return FINDING_MOMENT * weight_n * height_m


def without_momentum(recording: Recording) -> Log:
    """The merged log; one without a rate of angular momentum says so (`LIMB_SWING.needs`).

    With the share of its gait cycle of each row, by which such a rate repeats.
    """
    log = recording.merged.log
    if not recording.no_angular_momentum:
        return log
    phase = cycle_phase(log.known["contact"])
    return log.with_known(angmom_missing=np.ones(len(log)), gait_phase=phase)


def needs_time(experiment: Experiment, reason: str) -> dict[str, str]:
    """Effects of an experiment that need time stamps, each with the reason not to try them."""
    return dict.fromkeys(sorted(having(Trait.TIMED, experiment=experiment.name)), reason)


_TENTHS = 10


def in_order(experiment: Experiment, what: str, each_s: float) -> dict[str, Effect]:
    """Effects in time in units of rows: their order is known, their stamps are not.

    Parameters
    ----------
    what, each_s
        What a row is called, and about how long one takes, s.
    """
    units = {f"{unit}/s": f"{unit}/{what}" for unit in ("N", "Nm")} | {"s": f"{what}s"}

    def counted(effect: Effect) -> Effect:
        return replace(
            effect,
            parameters=tuple(
                replace(
                    p, unit=units.get(p.unit, p.unit),
                    prior_sd=p.prior_sd * (each_s if p.unit.endswith("/s") else 1.0),
                    # every tenth of the rows: no moment within a block shows
                    grid=p.grid[1::2] if len(p.grid) > _TENTHS else p.grid,
                )
                for p in effect.parameters
            ),
            formula=f"{effect.formula}; t in {what}s, in the order of the log",
        )  # fmt: skip

    timed = having(Trait.TIMED, experiment=experiment.name)
    return {name: counted(find_effect(name)) for name in timed}


def of_cells(experiment: Experiment) -> dict[str, str]:
    """Effects of an experiment that are said of load cells and not tried on transducers."""
    return dict.fromkeys(sorted(having(Trait.SMALL_CELL, experiment=experiment.name)), OF_CELLS)
