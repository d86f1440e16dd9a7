"""From logs and a chain to the arrays of the engine."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from footcal_cli.core.diagnosis.case import Case, Rows, balanced, residual
from footcal_cli.core.diagnosis.problem import Problem
from footcal_cli.core.diagnosis.signatures import (
    calibration_columns,
    direction_columns,
    library_columns,
)
from footcal_cli.core.diagnosis.tracking import Tracking
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.parameters import FloatArray

Describe = Callable[[Case, Rows], tuple[Mapping[str, FloatArray], Mapping[str, FloatArray]]]
"""Regressors (m,) and block-level covariates (B,) of a case."""


def problem_from(case: Case, rows: Rows, effects: Iterable[Effect], describe: Describe) -> Problem:
    """Arrays of a case: residual, calibration and library by differentiating its chain."""
    ideal = balanced(case, case.values)
    library = library_columns(ideal, rows, effects)
    regressors, covariates = describe(ideal, rows)
    tracking, turn = None, None
    if case.drifts and case.directions:
        calibration = direction_columns(ideal, rows)
        _, kind = np.unique([d.kind for d in case.directions], return_inverse=True)
        tracking = Tracking(rows.time_s, rows.log, kind.astype(np.int64))
    else:
        calibration, turn = calibration_columns(ideal, rows)
    tolerance = np.array(
        [case.tolerance_nm if unit == "Nm" else case.tolerance_n for unit in rows.units]
    )
    return Problem(
        residual=residual(case, rows, case.values),
        calibration=calibration,
        calibration_names=tuple(f"direction {i + 1}" for i in range(calibration.shape[1])),
        columns=library.columns,
        signatures=library.signatures,
        block=rows.block,
        output=rows.output,
        sequence=rows.sequence,
        outputs=rows.outputs,
        units=rows.units,
        noise=rows.noise,
        tolerance=tolerance,
        regressors=regressors,
        rate_hz=rows.rate_hz,
        covariates=covariates,
        excluded=library.excluded,
        calibration_turn=turn,
        tracking=tracking,
        alike=case.alike,
        drifts=case.drifts,
    )
