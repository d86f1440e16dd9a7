"""Standing and walking on six-axis transducers as the case that `diagnose` takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.chain import Chain, link
from footcal_cli.core.diagnosis.blocks import cut_balanced
from footcal_cli.core.diagnosis.recording import swings_apart
from footcal_cli.core.effects.body import COM_OFFSET
from footcal_cli.core.experiments import stand, walk
from footcal_cli.core.experiments.contract import Experiment
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.tracking import Direction
from footcal_cli.core.log import Log
from footcal_cli.core.online.six_axis import PRIOR_SD
from footcal_cli.core.online.streams import MergeRule
from footcal_cli.core.parameters import BoolArray, Parameter, ParameterSet
from footcal_cli.core.spatial import whole_rows
from footcal_cli.errors import DataError
from footcal_cli.intake.cases.shared import (
    FINDING,
    CaseRead,
    baseline_of,
    chain_of,
    finding_nm,
    followed,
    of_cells,
    rate_of,
    without_momentum,
)
from footcal_cli.intake.recordings import Recording, read_recordings
from footcal_cli.intake.stances import judged_rows
from footcal_cli.recipe.options import DiagnoseOptions

if TYPE_CHECKING:
    from footcal_cli.session.session import Session


def read(session: Session[DiagnoseOptions]) -> CaseRead:
    """Standing and walking on six-axis transducers: offsets are what is calibrated, and drift.

    Scales, mass, CoM and mounting are candidates: a walk's own calibration does not know them.
    """
    kind, options = session.options.experiment, session.options
    experiment = walk.ON_SIX_AXIS if kind == "walk" else stand.ON_SIX_AXIS
    recordings = read_recordings(session, MergeRule(delay_s=options.delay_s), kind)
    logs = [
        _log_of(recording, experiment, judged_rows(session.recipe, kind, recording))
        for recording in recordings
    ]
    channels = logs[0].channels
    chain, values = chain_of(baseline_of(session), channels, experiment.calibration)
    logs = [as_corrected(log, values) for log in logs]
    calibration = offset_parameters(channels, values)
    values |= {parameter.name: parameter.value for parameter in calibration}
    weight = session.recipe.robot.weight_n or 700.0
    rate = rate_of(logs[0], recordings[0].name)
    walks = kind == "walk"
    kept, stride = followed(logs, rate if walks else 0.0)
    case = Case(
        experiment=experiment,
        logs=kept,
        chain=chain,
        values=values,
        calibration=ParameterSet(calibration),
        tolerance_n=options.tolerance_n or 0.001 * weight,
        finding_n=options.tolerance_n or FINDING * weight if walks else 0.0,
        finding_nm=finding_nm(kept, weight) if walks else 0.0,
        tolerance_nm=options.tolerance_mm / 1000.0 * weight,
        drifts=walks,
        alike=False,
        stride=stride,
        groups={c: "swing force" if ".f" in c else "swing torque" for c in channels},
        one_recording=len(logs) == 1,
        pieces=not walks,
        tolerance_stated=options.tolerance_n is not None,
        directions=offset_directions(channels) if walks else (),
        demand_noisy=walks,
    )
    return CaseRead(case, [], of_cells(experiment))


def as_corrected(log: Log, values: Mapping[str, float]) -> Log:
    """The log with the CoM as a calibration corrected it; how far it may be off stays usual.

    Not with its mass: a gain of one foot shows as a mass too, half of it as the gain.
    """
    neutral = {f"robot.{p.name}": p.neutral for p in COM_OFFSET.parameters}
    if all(values.get(name, still) == still for name, still in neutral.items()):
        return log
    of = Chain((link(COM_OFFSET, log.channels),))
    return of.remove(log, {**neutral, **values})[0]


def _log_of(recording: Recording, experiment: Experiment, judged: BoolArray) -> Log:
    """Rows where all is known, in blocks of whole gait cycles; quiet stances in pieces."""
    merged, log = recording.merged, without_momentum(recording)
    if recording.temperature_degc is not None:
        log = log.with_known(temperature_degc=recording.temperature_degc)
    if experiment is walk.ON_SIX_AXIS:
        log = swings_apart(log, merged.raw, merged.rate_hz)
    good = judged & np.isfinite(log.readings).all(axis=1)
    for name in experiment.known:
        if name != "contact":
            good &= whole_rows(log.known[name])
    if not good.any():
        raise DataError(
            "at no time are all readings, the body's motion and its feet known",
            remedy="run check on both logs: every column must hold numbers, and their stamps must "
            "be of the same clock and in s",
        )
    return cut_balanced(log.at(np.asarray(good)))


def offset_parameters(channels: Sequence[str], values: dict[str, float]) -> tuple[Parameter, ...]:
    """Offset of each axis as a parameter that the data alone determine."""
    found = []
    for channel in channels:
        foot, axis = channel.split(".")
        name, force = f"{foot}.offset_{axis}", axis[0] == "f"
        unit, step = ("N", 1.0) if force else ("Nm", 0.1)
        found.append(Parameter(name, unit, values.get(name, 0.0), scale=step))
    return tuple(found)


def offset_directions(channels: Sequence[str]) -> tuple[Direction, ...]:
    """Each axis's offset as a way of drifting, forces and torques with a speed of their own."""
    found = []
    for channel in channels:
        foot, axis = channel.split(".")
        kind = f"offset_{axis[0]}"
        name = f"{foot}.offset_{axis}"
        found.append(Direction(name, kind, {name: PRIOR_SD[kind][1]}))
    return tuple(found)
