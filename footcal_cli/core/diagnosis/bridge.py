"""From logs and a chain to the arrays of the engine."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

import numpy as np

from footcal_cli.core.diagnosis.imperfections import with_imperfections
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.case import Case, channels_of, residual
from footcal_cli.core.inference.ideal import balanced
from footcal_cli.core.inference.lines import Traces
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.settings import Settings
from footcal_cli.core.inference.signatures import (
    calibration_columns,
    direction_columns,
    library_columns,
)
from footcal_cli.core.inference.tracking import Tracking
from footcal_cli.core.parameters import FloatArray

Describe = Callable[[Case, Problem], tuple[Mapping[str, FloatArray], Mapping[str, FloatArray]]]
"""Regressors (m,) and block-level covariates (B,) of a case."""
_MORE = 1.01


def problem_from(
    case: Case,
    rows: Problem,
    effects: Iterable[Effect],
    describe: Describe,
    within: FloatArray | None = None,
    ideal: Case | None = None,
) -> Problem:
    """Arrays of a case: residual, calibration and library by differentiating its chain.

    Parameters
    ----------
    rows
        Which errors count, from `rows_of`, or the problem of another model.
    within
        Changes of parameters to which calibration is limited, as in `calibration_at`.
    ideal
        Its recordings without noise, where a refit made them already.
    """
    ideal = ideal or balanced(case, case.values)
    library = library_columns(ideal, rows, effects, case if case.drifts else None)
    regressors, covariates = describe(ideal, rows)
    calibration, turn = calibration_at(ideal, rows, within)
    tracking = None
    if case.drifts and case.directions:
        wandering = [d.kind for d in case.directions if not d.lasting]
        _, kind = np.unique(wandering, return_inverse=True)
        tracking = Tracking(rows.time_s, rows.log, kind.astype(np.int64))
    problem = replace(
        rows.bare,
        residual=residual(case, rows, case.values),
        calibration=calibration,
        regressors=regressors,
        covariates=covariates,
        excluded=library.excluded,
        calibration_turn=turn,
        known=known_of(case, turn),
        held=held_of(ideal, rows),
        tracking=tracking,
        settings=_settings(ideal, rows) if case.setting_key else None,
        traces=_traces(case, rows) if rows.rate_hz > 0 or case.setting_key or case.pieces else None,
    )
    return with_imperfections(problem, library, ideal)


def calibration_at(
    ideal: Case, rows: Problem, within: FloatArray | None = None
) -> tuple[FloatArray, FloatArray | None]:
    """What calibration does to the residual at a model, and what each column turns, if constant.

    Parameters
    ----------
    within
        What the baseline's columns turn. Beside an effect that is not linear a parameter shows that
        these data alone cannot calibrate: six sums over all legs know nothing of one leg's offset,
        which another log has fixed. Free, it would be one more shape of that effect.
    """
    if ideal.drifts and ideal.directions:
        return direction_columns(ideal, rows), None
    return calibration_columns(ideal, rows, within)


def held_of(ideal: Case, rows: Problem) -> FloatArray | None:
    """Change of the residual per sd of each lasting difference from a known calibration (m, h)."""
    if not any(direction.lasting for direction in ideal.directions):
        return None
    return direction_columns(ideal, rows, lasting=True)


def known_of(case: Case, turn: FloatArray | None) -> FloatArray | None:
    """Precision known beforehand of what each calibration column turns, shape (p, p)."""
    if case.drifts:  # a calibration that is tracked, or free in every block, has a prior of its own
        return None
    return None if case.known is None or turn is None else turn.T @ case.known @ turn


def _traces(case: Case, rows: Problem) -> Traces:
    """One channel per column of each log, by the name its experiment gives it."""
    channel = np.zeros(rows.residual.size, dtype=np.int64)
    names: list[str] = []
    for i, log in enumerate(case.logs):
        here = rows.log == i
        channel[here] = len(names) + rows.column[here]
        truth, _ = case.chain.remove(log.rows(0, 2), case.values)
        names += case.experiment.balance(truth).outputs
    return Traces(rows.time_s, channel, tuple(names))


def _settings(ideal: Case, rows: Problem) -> Settings:
    """What may differ between settings-up: offset and gain of every sensor."""
    number = np.zeros((2, rows.residual.size), dtype=np.int64)
    for i, log in enumerate(ideal.logs):
        here = rows.log == i
        number[0, here] = i
        number[1, here] = log.known[ideal.setting_key][rows.row[here]]
    _, setting = np.unique(number, axis=1, return_inverse=True)
    numbers = np.asarray(setting).ravel()
    if ideal.experiment.name == "placements":
        columns, kind = _of_each_cell(ideal, rows)
        _, numbered = np.unique(kind, return_inverse=True)
        return Settings(numbers, np.stack(columns, axis=1), np.asarray(numbered))
    axes = _of_each_output(ideal, rows)
    # few hangings know of each axis: in units of their own noise all offsets are taken to be
    # alike, forces' and torques', and all gains
    return Settings(numbers, np.stack(axes, axis=1), np.arange(len(axes)) % 2, rows.log, rows.block)


def _of_each_cell(ideal: Case, rows: Problem) -> tuple[list[FloatArray], list[str]]:
    """Gain and offset of every cell, where an output is a sum over cells."""
    columns, kind = [], []
    seen = ideal.memory()
    still = residual(ideal, rows, ideal.values, seen=seen)
    for channel in channels_of(ideal.logs):
        scale, bias = f"{channel}.scale", f"{channel}.bias"
        values = ideal.values
        gain = {scale: _MORE * values[scale], bias: _MORE * values[bias]}
        for name, moved in (("gain", gain), ("bias", {bias: values[bias] + _MORE - 1.0})):
            column = residual(ideal, rows, {**values, **moved}, seen=seen) - still
            columns.append(column / max(float(np.sqrt(np.mean(column**2))), 1e-300))
            kind.append(name)
    return columns, kind


def _of_each_output(ideal: Case, rows: Problem) -> list[FloatArray]:
    """Offset and gain of every output, where outputs are axes of one sensor."""
    truths = [ideal.chain.remove(log, ideal.values)[0] for log in ideal.logs]
    reading = np.zeros(rows.residual.size)
    for i, truth in enumerate(truths):
        here = rows.log == i
        reading[here] = truth.readings[rows.row[here], rows.column[here]]
    columns = []
    for o in range(len(rows.outputs)):
        own = rows.output == o
        for part in (np.ones(reading.size), reading):
            column = np.where(own, part, 0.0)
            size = float(np.sqrt(np.mean(column[own] ** 2)))
            columns.append(column / max(size, 1e-300))
    return columns
