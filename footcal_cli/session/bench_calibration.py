"""The ``parameters.json`` of a bench calibration: channels, their effects, cells in their feet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from footcal_cli.core.bench.cop_study import FootStudy
from footcal_cli.core.bench.study import ChannelStudy
from footcal_cli.core.parameters import Estimates
from footcal_cli.records.results import (
    EffectRecord,
    ParameterRecord,
    ParametersRecord,
    Range,
    covariance_blocks,
    parameter_records,
)
from footcal_cli.session.calibration import PLACED_CELLS, calibration_record
from footcal_cli.session.session import Session


def bench_calibration(
    session: Session[Any],
    studies: Sequence[ChannelStudy],
    estimates: Sequence[Estimates],
    feet: Sequence[FootStudy],
) -> ParametersRecord | None:
    """Channels and, where physics was chosen, the corrections of cells by their placements.

    Parameters
    ----------
    studies
        Channels with weights of their own.
    estimates
        Of these and of cells that were loaded together.
    feet
        Feet with placements.
    """
    parameters: dict[str, ParameterRecord] = {}
    ranges: dict[str, dict[str, Range]] = {}
    earlier = session.parameters
    effects = list(effect_records(studies))
    if not estimates and earlier is not None:
        parameters |= earlier.parameters
        ranges |= earlier.fitted_range
        effects += list(earlier.effects)
    for group in estimates:
        parameters |= parameter_records(group)
    for study in studies:
        ranges[study.channel] = fitted_ranges(study)
    groups = list(estimates)
    for found in feet:
        if found.estimates is None:
            continue
        parameters |= parameter_records(found.estimates)
        placed = {*found.estimates.names}  # a scale by the placements replaces a believed one
        groups = [*(g for g in groups if placed.isdisjoint(g.names)), found.estimates]
        names = [f"{channel}.bias" for channel in found.rows.cells]
        biases = found.biases(np.array([parameters[name].value for name in names]))
        for name, bias in zip(names, biases.tolist(), strict=True):
            parameters[name] = parameters[name].model_copy(update={"value": bias})
        for effect in found.effects():
            owners: dict[str, tuple[str, ...]] = {c: (c,) for c in found.rows.cells}
            effects.append(EffectRecord(effect=effect, owners=owners))
    if not parameters:
        return None
    return calibration_record(
        session, PLACED_CELLS, parameters, covariance=covariance_blocks(*groups),
        fitted_range=ranges, effects=effects,
    )  # fmt: skip


def effect_records(studies: Sequence[ChannelStudy]) -> tuple[EffectRecord, ...]:
    """The effects that the channels' models contain, for any command's chain."""
    owners: dict[str, dict[str, tuple[str, ...]]] = {}
    for study in studies:
        for term in study.fit.terms if study.fit is not None else ():
            if term.effect:
                owner = f"{study.channel}{term.owner}"
                owners.setdefault(term.effect, {})[owner] = (study.channel,)
    return tuple(EffectRecord(effect=name, owners=carried) for name, carried in owners.items())


def fitted_ranges(study: ChannelStudy) -> dict[str, Range]:
    """Loads, readings, temperatures the model was fitted on, and how far loads are off a line."""
    affine, fit = study.affine, study.fit
    ranges = {
        "load": Range.of(affine.load_n, "N"),
        "reading": Range.of(affine.counts, "count"),
        "line_error": Range.of(affine.residual_n, "N"),
    }
    if fit is not None and fit.temperature_range_degc is not None:
        low, high = fit.temperature_range_degc
        ranges["temperature"] = Range(lowest=low, highest=high, unit="degC")
    return ranges
