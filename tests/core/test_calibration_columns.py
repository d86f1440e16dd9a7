"""Directions of the calibration of sensors that share no log are each of one sensor."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.inference.case import residual, rows_of
from footcal_cli.core.inference.linear import left_by
from footcal_cli.core.inference.signatures import calibration_columns
from tests.core.leg_cases import LEGS, distorting, hang_case, hung_logs


def test_legs_that_hang_apart_have_directions_of_their_own() -> None:
    case = hang_case(hung_logs(4, *distorting("", "", {})))
    rows = rows_of(case)
    columns, turn = calibration_columns(case, rows)
    owner = np.array([p.name.split(".")[0] for p in case.calibration])
    log_of = {leg: i for i, log in enumerate(case.logs) for leg in LEGS
              if log.channels[0].startswith(f"{leg}.")}  # fmt: skip
    its = [{leg for leg in LEGS if way[owner == leg].any()} for way in turn.T]
    assert {len(legs) for legs in its} == {1}
    for leg in LEGS:
        mine = [k for k, legs in enumerate(its) if legs == {leg}]
        assert not columns[np.ix_(rows.log != log_of[leg], mine)].any()
    # orthonormal but for the number of rows, and all that any parameter does to the residual
    size = rows.residual.size
    np.testing.assert_allclose(columns.T @ columns / size, np.eye(len(its)), atol=1e-9)
    for parameter in list(case.calibration)[::5]:
        ends = (
            residual(case, rows, {**case.values, parameter.name: parameter.value + sign * step})
            for step in [1e-4 * parameter.step] for sign in (1.0, -1.0)
        )  # fmt: skip
        change = np.subtract(*ends)
        assert np.linalg.norm(left_by(columns, change, 1e-9)) < 1e-5 * np.linalg.norm(change)
    # the same directions at the same values, each from the log of its own leg alone
    again, same = calibration_columns(case, rows, turn)
    assert np.linalg.norm(left_by(columns, again, 1e-9)) < 1e-5 * np.linalg.norm(again)
    assert {len({leg for leg in LEGS if way[owner == leg].any()}) for way in same.T} == {1}
