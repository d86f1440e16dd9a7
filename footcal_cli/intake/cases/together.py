"""Cells under several known loads at once, or known wrenches, as the case that `diagnose` takes.

Room: intake; called by weights, whose experiment it is.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.bench.matrix import study_matrix
from footcal_cli.core.bench.regression import fit_affine
from footcal_cli.core.effects import having
from footcal_cli.core.effects.contract import Trait
from footcal_cli.core.experiments.weights import EXPERIMENT
from footcal_cli.core.inference.case import Case
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray, Parameter, ParameterSet, Status
from footcal_cli.intake.bench import RowsTogether, rows_together
from footcal_cli.intake.cases.shared import (
    CaseRead,
    affine_parameters,
    baseline_of,
    chain_of,
    needs_time,
)
from footcal_cli.recipe.options import DiagnoseOptions

if TYPE_CHECKING:
    from footcal_cli.records.results import ParameterRecord, ParametersRecord
    from footcal_cli.session.session import Session

_SENSOR = "sensor"
"""Name of a transducer under known wrenches; its axes are ``sensor.fx`` …"""
_NO_FOOT = (
    "the names of the cells say no foot (<foot>_<cell>); the matrix of offline-fit shows crosstalk"
)
_LEAST_SESSIONS = 3
"""With fewer sessions load cases are what can be left out."""
_TOLERANCE = 0.002
"""Share of the largest load that an error must reach to matter, as for weights."""


def read_together(session: Session[DiagnoseOptions]) -> CaseRead | None:
    """One log of all channels; blocks are sessions, or load cases; None where there is no log.

    Cells keep their raw readings, so that crosstalk can be named. Readings of a transducer are
    taken through its matrix (`--parameters`, or the one that these rows give): what is judged are
    six axes in N and Nm.
    """
    options = session.recipe.options.get("offline_fit", {})
    known_wrench = bool(options.get("known_wrench", False))
    rows = rows_together(session, known_wrench=known_wrench)
    if rows is None:
        return None
    block = rows.session if np.unique(rows.session).size >= _LEAST_SESSIONS else rows.case
    order = np.argsort(block, kind="stable")
    block = np.unique(block[order], return_inverse=True)[1].astype(np.int64)
    baseline = _without_matrix(baseline_of(session))
    case = _of_axes(session, rows, order, block) if known_wrench else None
    case = case or _of_cells(rows, order, block, baseline)
    largest = float(np.nanmax(np.abs(rows.loads[:, [u == "N" for u in rows.units]])))
    levers = rows.loads[:, [u == "Nm" for u in rows.units]]
    largest_nm = float(np.nanmax(np.abs(levers))) if levers.size else largest
    tolerance_n = session.options.tolerance_n or _TOLERANCE * largest
    case = replace(
        case, tolerance_n=tolerance_n,
        tolerance_nm=tolerance_n / largest * largest_nm if levers.size
        else session.options.tolerance_mm / 1000.0 * largest,
    )  # fmt: skip
    untested = needs_time(EXPERIMENT, "the rows have no time stamps")
    if not known_wrench and not any("_" in channel for channel in rows.channels):
        untested |= dict.fromkeys(having(Trait.MIXTURE, experiment=EXPERIMENT.name), _NO_FOOT)
    before = _matrix_record(*_matrix(session.parameters, rows), rows) if known_wrench else {}
    return CaseRead(case, [], untested, before=before)


def _of_cells(
    rows: RowsTogether, order: IntArray, block: IntArray, baseline: ParametersRecord | None
) -> Case:
    chain, values = chain_of(baseline, rows.channels, EXPERIMENT.calibration)
    for i, channel in enumerate(rows.channels):
        if f"{channel}.scale" not in values:
            fit = fit_affine(channel, rows.loads[:, i], rows.readings[:, i])
            values |= {f"{channel}.scale": fit.scale_n_per_count, f"{channel}.bias": fit.bias_n}
    return Case(
        experiment=EXPERIMENT,
        logs=(_log(rows.channels, rows.readings[order], {"load_n": rows.loads[order]}, block),),
        chain=chain, values=values,
        calibration=ParameterSet(affine_parameters(rows.channels, values)),
        tolerance_n=1.0, tolerance_nm=1.0, alike=False,
        groups=dict.fromkeys(rows.channels, "force"),
    )  # fmt: skip


def _of_axes(
    session: Session[DiagnoseOptions], rows: RowsTogether, order: IntArray, block: IntArray
) -> Case:
    matrix, bias = _matrix(session.parameters, rows)
    channels = tuple(f"{_SENSOR}.{axis}" for axis in rows.outputs)
    readings = (rows.readings @ matrix.T + bias)[order]
    record = baseline_of(session)
    if record is not None:  # of its effects those of the axes; what the bridges do is in the matrix
        own = tuple(e for e in record.effects if set(channels) >= {*sum(e.owners.values(), ())})
        record = record.model_copy(update={"effects": own})
    chain, known = chain_of(record, channels, EXPERIMENT.calibration)
    parameters = []
    for channel, unit in zip(channels, rows.units, strict=True):
        scale, zero = (known.get(f"{channel}.{p}", v) for p, v in (("scale", 1.0), ("bias", 0.0)))
        parameters.append(Parameter(f"{channel}.scale", "1", scale, scale=0.02))
        parameters.append(Parameter(f"{channel}.bias", unit, zero, scale=0.3))
    groups = {axis: "force" if unit == "N" else "torque"
              for axis, unit in zip(rows.outputs, rows.units, strict=True)}  # fmt: skip
    return Case(
        experiment=EXPERIMENT,
        logs=(_log(channels, readings, {"wrench": rows.loads[order]}, block),),
        chain=chain, values={**known, **{p.name: p.value for p in parameters}},
        calibration=ParameterSet(tuple(parameters)),
        tolerance_n=1.0, tolerance_nm=1.0, alike=False, groups=groups,
    )  # fmt: skip


def _log(
    channels: tuple[str, ...], readings: FloatArray, known: dict[str, FloatArray], block: IntArray
) -> Log:
    return Log("weights", channels, np.arange(float(len(readings))), readings, known, block)


def _matrix(record: ParametersRecord | None, rows: RowsTogether) -> tuple[FloatArray, FloatArray]:
    """Matrix (6, c) and bias (6,) of a calibration, or of these rows where none is given."""
    values = {} if record is None else record.values
    names = [[f"{axis}.scale_from_{c}" for c in rows.channels] for axis in rows.outputs]
    if all(name in values for row in names for name in row):
        matrix = np.array([[values[name] for name in row] for row in names])
        return matrix, np.array([values.get(f"{axis}.bias", 0.0) for axis in rows.outputs])
    fit = study_matrix(
        rows.channels, rows.readings, rows.outputs, rows.loads, rows.session, rows.case, rows.units
    ).chosen
    return fit.matrix, fit.bias


def _matrix_record(
    matrix: FloatArray, bias: FloatArray, rows: RowsTogether
) -> dict[str, ParameterRecord]:
    """What stands before the axes in the calibration that a diagnosis leaves: matrix and bias."""
    from footcal_cli.records.results import ParameterRecord

    found = {}
    for axis, unit, row, zero in zip(rows.outputs, rows.units, matrix, bias, strict=True):
        named = {f"{axis}.scale_from_{c}": (v, f"{unit}/count")
                 for c, v in zip(rows.channels, row, strict=True)}  # fmt: skip
        for name, (value, its) in {**named, f"{axis}.bias": (zero, unit)}.items():
            found[name] = ParameterRecord(
                value=float(value), sd=None, unit=its, status=Status.ESTIMATED
            )
    return found


def _without_matrix(record: ParametersRecord | None) -> ParametersRecord | None:
    """A calibration without one channel's share in another: named again, it would count twice."""
    if record is None or not any(".scale_from_" in name for name in record.parameters):
        return record
    kept = {n: p for n, p in record.parameters.items() if ".scale_from_" not in n}
    return record.model_copy(update={"parameters": kept, "covariance": ()})
