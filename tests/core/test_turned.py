"""A hip transducer that was mounted half or quarter turns off between hanging and standing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.pose.seating import check_turned_standing
from tests.core.pose_cases import Case, case

LEG = 1
HALF_ABOUT_Z = np.diag([-1.0, -1.0, 1.0])
QUARTER_ABOUT_X = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@pytest.fixture(scope="module")
def stood() -> Case:
    return case(3, poses=30)


def test_a_robot_that_is_mounted_as_said_is_not_called_turned(stood: Case) -> None:
    assert not check_turned_standing(stood.data, stood.legs, stood.noise_sd, PoseOptions())


@pytest.mark.parametrize(
    ("turn", "words"),
    [(HALF_ABOUT_Z, "half a turn about z"), (QUARTER_ABOUT_X, "a quarter turn about x")],
)
def test_a_turned_transducer_is_found_with_its_turn(
    stood: Case, turn: np.ndarray, words: str
) -> None:
    offset = stood.legs[LEG].offset
    wrench = stood.data.wrench_t.copy()
    carried = (wrench[:, LEG] - offset).reshape(-1, 2, 3)  # offsets are the sensor's own
    wrench[:, LEG] = (carried @ turn.T).reshape(-1, 6) + offset
    data = replace(stood.data, wrench_t=wrench)
    (finding,) = check_turned_standing(data, stood.legs, stood.noise_sd, PoseOptions())
    assert finding.where == stood.data.geometry.legs[LEG]
    assert words in finding.sentence
