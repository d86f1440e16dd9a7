"""What a calibration knows of the cells beyond scale and bias, taken out of a stand or a walk."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from footcal_cli.core.chain import Chain, Link, link
from footcal_cli.core.effects import calibration_of
from footcal_cli.core.effects.cells import (
    TEMPERATURE_BIAS,
    TEMPERATURE_REFERENCE_DEGC,
    TEMPERATURE_SCALE,
)
from footcal_cli.core.effects.contract import Stage, Trait
from footcal_cli.core.log import Log
from footcal_cli.core.online.streams import SensorStream
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import interpolate_slow
from footcal_cli.errors import UsageError
from footcal_cli.recipe import Robot
from footcal_cli.records.effects import effect_of
from footcal_cli.records.results import ParametersRecord

LEAST_TEMPERATURE_DOUBT_K = 5.0
"""How far a room may be from the middle of a calibration's temperatures, at least."""


def cells_in_feet(robot: Robot) -> tuple[FloatArray, ...]:
    """Positions of the cells in each foot's frame, shape (cells, 2) each."""
    return tuple(
        np.array([(cell.x_m, cell.y_m) for cell in foot.cells.values()])
        for foot in robot.feet.values()
    )


@dataclass(frozen=True)
class Undone:
    """Readings of cells after the effects in their calibration are removed.

    Parameters
    ----------
    stream
        The counts they would have shown.
    cells_m
        Where the cells stand in each foot, shape (cells, 2) each.
    gain_sd, bias_sd_n
        What could not be undone exactly adds to the belief, shape (c,).
    findings
        What was assumed.
    state
        What the stream leaves in effects with a memory, for what follows it.
    """

    stream: SensorStream
    cells_m: tuple[FloatArray, ...]
    gain_sd: FloatArray
    bias_sd_n: FloatArray
    findings: tuple[Finding, ...] = ()
    state: Mapping[int, Any] | None = None


def without_cell_effects(
    stream: SensorStream,
    record: ParametersRecord,
    robot: Robot,
    temperature_degc: FloatArray | None = None,
    state: Mapping[int, Any] | None = None,
    moving: Mapping[str, FloatArray] | None = None,
) -> Undone:
    """The counts that cells without the effects of a calibration would have shown.

    Effects of the body's stream are left to those who know it. Where the log has no temperature,
    its effects are undone at the middle of the calibration's own range, and the belief is widened
    by what a temperature anywhere in that range could change.

    Parameters
    ----------
    temperature_degc
        Of the stream's rows, shape (n,).
    state
        Of what came before, where the stream is a piece of a longer one.
    moving
        What is known of the body's motion at the stream's rows (`Log.known`).

    Raises
    ------
    UsageError
        The calibration contains an effect that needs what a stand or a walk never records.
    """
    chain = Chain((link(calibration_of(stream.channels), stream.channels),))
    rows, count = len(stream.time_s), len(stream.channels)
    believed = cells_in_feet(robot)
    places = np.concatenate(believed)
    values = record.values
    log = Log(
        "walk", stream.channels, stream.time_s, stream.readings,
        {"cell_pos_m": np.tile(places, (rows, 1, 1)), **(moving or {})},
        np.zeros(rows, dtype=np.int64),
    )  # fmt: skip
    links = _links_of_cells(record, log)
    gain_sd, bias_sd_n = np.zeros(count), np.zeros(count)
    findings: tuple[Finding, ...] = ()
    if any("temperature_degc" in item.effect.needs for item in links):
        warmth = (
            None if temperature_degc is None
            else interpolate_slow(stream.time_s, temperature_degc, np.nan_to_num(stream.time_s))
        )  # fmt: skip
        if warmth is None:
            middle, half = temperature_range(record)
            warmth = np.full(rows, middle)
            gain_sd, bias_sd_n = temperature_doubt(values, stream.channels, half)
            findings = (temperature_assumed(middle, half, gain_sd, bias_sd_n),)
        log = log.with_known(temperature_degc=warmth)
    if not links:
        return Undone(stream, believed, gain_sd, bias_sd_n)
    extended = chain
    for one in links:
        extended = extended.with_link(one)
    good = np.asarray(np.isfinite(stream.readings).all(axis=1))
    truth, left = extended.remove(log.with_readings(np.nan_to_num(stream.readings)), values, state)
    shown, _ = chain.apply(truth, values)
    moved = truth.known["cell_pos_m"][0] if rows else places
    edges = np.cumsum([len(foot) for foot in believed])[:-1]
    return Undone(
        replace(stream, readings=np.where(good[:, None], shown.readings, np.nan)),
        tuple(np.split(moved, edges)),
        gain_sd,
        bias_sd_n,
        findings,
        left,
    )


def _links_of_cells(record: ParametersRecord, log: Log) -> list[Link]:
    """Effects of the cells beyond their calibration; one that the log cannot undo is refused."""
    links = []
    for item in record.effects:
        effect = effect_of(item)
        if Trait.CALIBRATION in effect.traits or effect.stage in (Stage.BODY, Stage.TRANSPORT):
            continue
        lacking = set(effect.needs) - set(log.known) - {"temperature_degc"}
        if lacking:
            raise UsageError(
                f"the calibration contains {effect.name}, which needs {', '.join(sorted(lacking))}",
                remedy="give the calibration without it, or correct the recipe where it says so",
            )
        links.append(Link(effect, dict(item.owners)))
    return links


def temperature_range(record: ParametersRecord) -> tuple[float, float]:
    """Middle and half width of the temperatures that a calibration was fitted on, °C and K."""
    found = [r["temperature"] for r in record.fitted_range.values() if "temperature" in r]
    if not found:
        return TEMPERATURE_REFERENCE_DEGC, LEAST_TEMPERATURE_DOUBT_K
    low, high = min(r.lowest for r in found), max(r.highest for r in found)
    return 0.5 * (low + high), max(0.5 * (high - low), LEAST_TEMPERATURE_DOUBT_K)


def temperature_doubt(
    values: Mapping[str, float], channels: Sequence[str], half_k: float
) -> tuple[FloatArray, FloatArray]:
    """Sd of gains and biases (N) where the temperature is not known to within ± `half_k`."""
    per_kelvin = [
        [abs(values.get(f"{channel}.{name}", 0.0)) for channel in channels]
        for name in (TEMPERATURE_SCALE.size.name, TEMPERATURE_BIAS.size.name)
    ]
    gain, bias = half_k * np.array(per_kelvin)
    return gain, bias


def temperature_assumed(
    middle: float, half_k: float, gain_sd: FloatArray, bias_sd_n: FloatArray
) -> Finding:
    """What a user reads where a temperature had to be assumed."""
    return Finding(
        "temperature_assumed", "warning", "all cells",
        f"the calibration corrects for temperature but the log has none: {middle:.1f} ± "
        f"{half_k:.1f} °C is assumed, which makes scales uncertain by up to "
        f"{100 * float(gain_sd.max()):.2g} % and biases by up to {float(bias_sd_n.max()):.2g} N",
        "log temperature_degc with the cells",
    )  # fmt: skip
