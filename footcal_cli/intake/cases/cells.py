"""Standing and walking on load cells as the case that `diagnose` takes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.contact import airborne
from footcal_cli.core.diagnosis.blocks import cut_balanced
from footcal_cli.core.diagnosis.recording import noise_of_smoothed, steps_of, swings_apart
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Scope, columns_of
from footcal_cli.core.experiments import stand, walk
from footcal_cli.core.experiments.contract import Experiment
from footcal_cli.core.experiments.walk import channel_contact, reference_of
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.lines import Series, swing_series
from footcal_cli.core.inference.tracking import gain_and_bias
from footcal_cli.core.log import Log
from footcal_cli.core.online.streams import MergeRule
from footcal_cli.core.online.weighed import weighed_by_each_foot
from footcal_cli.core.parameters import BoolArray, ParameterSet
from footcal_cli.core.quality import Finding
from footcal_cli.core.spatial import whole_rows
from footcal_cli.errors import DataError
from footcal_cli.intake.cases.shared import (
    FINDING,
    GAIN_MOVES,
    CaseRead,
    affine_parameters,
    baseline_of,
    chain_of,
    finding_nm,
    followed,
    known_before,
    rate_of,
    without_momentum,
)
from footcal_cli.intake.recordings import Recording, read_recordings
from footcal_cli.intake.stances import judged_rows
from footcal_cli.recipe.options import DiagnoseOptions

if TYPE_CHECKING:
    from footcal_cli.session.session import Session


PAUSE_S = 60.0
"""Between recordings that are set one after the other."""


def unseen_walking() -> dict[str, str]:
    """Effects that a walk alone cannot show: why, and what would."""
    return {e.name: e.unseen_walking for e in TABLE.values() if e.unseen_walking}


def read(session: Session[DiagnoseOptions]) -> CaseRead:
    """Standing and walking: merged streams, blocks of whole gait cycles or stances."""
    kind = session.options.experiment
    experiment = walk.EXPERIMENT if kind == "walk" else stand.EXPERIMENT
    least = session.recipe.robot.least_force_n
    rule = MergeRule(delay_s=session.options.delay_s, min_force_n=least)
    recordings = read_recordings(session, rule, kind, body_needed=kind == "walk")
    logs, steps, noises = [], [], []
    for recording in recordings:
        merged = recording.merged
        if kind == "walk":
            session.note(_weighed(recording, session.recipe.robot.mass_kg or 1.0))
        steps.append(steps_of(merged.raw))
        noises.append(noise_of_smoothed(merged.raw, merged.log.readings, merged.rate_hz))
        judged = judged_rows(session.recipe, kind, recording)
        logs.append(_log_of(recording, experiment, judged))
    channels = logs[0].channels
    chain, values = chain_of(baseline_of(session), channels, experiment.calibration)
    belief = recordings[0].belief
    if belief is not None:
        for i, channel in enumerate(channels):
            values.setdefault(f"{channel}.scale", float(belief.scale_n_per_count[i]))
            values.setdefault(f"{channel}.bias", float(belief.bias_n[i]))
    weight = session.recipe.robot.weight_n or 50.0
    # a stance may be a single row
    rate = rate_of(logs[0], recordings[0].name) if kind == "walk" else 0.0
    kept, stride = followed(logs, rate)
    scale = np.abs([values[f"{channel}.scale"] for channel in channels])
    known = known_before(session, channels, values)
    held_to = None if known is None else GAIN_MOVES
    case = Case(
        experiment=experiment,
        logs=kept,
        chain=chain,
        values=values,
        calibration=ParameterSet(affine_parameters(channels, values)),
        tolerance_n=session.options.tolerance_n or 0.001 * weight,
        tolerance_nm=session.options.tolerance_mm / 1000.0 * weight,
        drifts=kind == "walk",
        alike=False,
        stride=stride,
        groups=dict.fromkeys(channels, "swing"),
        one_recording=len(logs) == 1,
        raw=_unfiltered(recordings) if kind == "walk" else None,
        directions=gain_and_bias(channels, values, held_to) if kind == "walk" else (),
        demand_noisy=kind == "walk",
        known=known,
        finding_n=session.options.tolerance_n or FINDING * weight if kind == "walk" else 0.0,
        finding_nm=finding_nm(kept, weight) if kind == "walk" else 0.0,
        tolerance_stated=session.options.tolerance_n is not None,
        pieces=kind == "stand",
        least_noise={
            channel: size * step / np.sqrt(12.0)
            for channel, size, step in zip(channels, scale, np.median(steps, axis=0), strict=True)
        },
        reading_noise_n=float(np.median(scale * np.median(noises, axis=0))),
    )
    return CaseRead(case, [], unseen_walking() if kind == "walk" else {})


def _log_of(recording: Recording, experiment: Experiment, judged: BoolArray) -> Log:
    """The samples of a recording that its balance can use, in blocks."""
    merged, log = recording.merged, without_momentum(recording)
    good = judged & np.isfinite(log.readings).all(axis=1)
    for name in experiment.known:
        if name != "contact" and name in log.known:
            finite = whole_rows(log.known[name])
            # insoles without a robot know no CoM at all; their weight still balances
            good &= finite if finite.any() else True
    log = log.with_known(airborne=airborne(log.known["contact"]))
    if recording.temperature_degc is not None:
        log = log.with_known(temperature_degc=recording.temperature_degc)
    if experiment is walk.EXPERIMENT:
        log = swings_apart(log, merged.raw, merged.rate_hz)
    if not (np.nan_to_num(log.known["contact"][good]) != 0.0).any():
        raise DataError(
            "no sample can be used: no foot is known to stand", file=recording.name,
            remedy="check contact, mass, units and the calibration (footcal check)",
        )  # fmt: skip
    return cut_balanced(log.at(np.asarray(good)))


def _weighed(recording: Recording, stated_kg: float) -> tuple[Finding, ...]:
    """A mass that each foot contradicts; a walk lets the scales take it up, and tests none."""
    log, belief = recording.merged.log, recording.belief
    assert belief is not None  # feet with cells
    found = weighed_by_each_foot(
        belief.forces(log.readings), channel_contact(log), columns_of(Scope.FOOT, log.channels),
        reference_of(log).fz_n, belief.gain_sd, stated_kg,
    )  # fmt: skip
    return (
        ()
        if found is None
        else found.findings(
            "a walk shows the same if all scales have changed since they were calibrated"
        )
    )


def _unfiltered(recordings: list[Recording]) -> Series:
    """Swinging cells before the filter, all recordings one after the other."""
    time_s, forces, contact, rates, last = [], [], [], [], 0.0
    for recording in recordings:
        merged = recording.merged
        belief = recording.belief
        assert belief is not None  # feet with cells
        time_s.append(merged.log.time_s - merged.log.time_s[0] + last)
        # no stretch reaches from one recording into the next
        last = float(time_s[-1][-1]) + PAUSE_S
        forces.append(belief.forces(merged.raw))
        contact.append(channel_contact(merged.log))
        rates.append(merged.rate_hz)
    return swing_series(
        np.concatenate(time_s),
        np.concatenate(forces),
        np.concatenate(contact) == 0.0,
        recordings[0].merged.log.channels,
        float(np.median(rates)),
    )
