"""A hip transducer that was mounted half or quarter turns off between hanging and standing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.hang.joint import HangFit, HangOptions, fit_hang
from footcal_cli.core.log import Log
from footcal_cli.core.pose import turned
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.pose.seating import check_turned_standing, standing_axes
from footcal_cli.core.pose.turned import turned_when_hanging
from tests.core.pose_cases import Case, case
from tests.core.six_axis_data import hang

LEG = 1
HALF_ABOUT_Z = np.diag([-1.0, -1.0, 1.0])
QUARTER_ABOUT_X = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@pytest.fixture(scope="module")
def stood() -> Case:
    return case(3, poses=30)


def test_a_robot_that_is_mounted_as_said_is_not_called_turned(stood: Case) -> None:
    assert not check_turned_standing(stood.data, stood.legs, stood.noise_sd, PoseOptions())


@pytest.mark.parametrize(
    ("turn", "words", "renamed"),
    [
        pytest.param(HALF_ABOUT_Z, "half a turn about z", True, marks=pytest.mark.slow),
        (QUARTER_ABOUT_X, "a quarter turn about x", False),
    ],
)
def test_a_turned_transducer_is_found_with_its_turn(
    stood: Case, turn: np.ndarray, words: str, *, renamed: bool
) -> None:
    offset = stood.legs[LEG].offset
    own = np.zeros(6) if renamed else offset  # offsets stay in a sensor, not in renamed axes
    wrench = stood.data.wrench_t.copy()
    carried = (wrench[:, LEG] - own).reshape(-1, 2, 3)
    wrench[:, LEG] = (carried @ turn.T).reshape(-1, 6) + own
    data = replace(stood.data, wrench_t=wrench)
    (finding,) = check_turned_standing(data, stood.legs, stood.noise_sd, PoseOptions())
    assert finding.where == stood.data.geometry.legs[LEG]
    assert words in finding.sentence


def test_exchanged_plugs_are_no_mounting_error(stood: Case) -> None:
    names = stood.data.geometry.legs
    there = list(range(len(names)))
    there[0], there[1] = 1, 0
    data = replace(stood.data, wrench_t=stood.data.wrench_t[:, there])
    legs = tuple(stood.legs[k] for k in there)  # hung with the same plugs
    found = standing_axes(data, legs, stood.noise_sd, 0.05, 0.005)
    elsewhere = [f for f in found if f.code == "leg_elsewhere"]
    assert {f.where for f in elsewhere} == set(names[:2])
    assert all(f"{names[0]}" in f.remedy and f"{names[1]}" in f.remedy for f in elsewhere)
    assert not standing_axes(stood.data, stood.legs, stood.noise_sd, 0.05, 0.005)


@pytest.mark.parametrize(
    ("poses", "seed"),
    [
        (8, 3),
        pytest.param(12, 4, marks=pytest.mark.slow),
        pytest.param(20, 3, marks=pytest.mark.slow),
    ],
)
def test_noise_beyond_the_one_believed_moves_no_leg_elsewhere(poses: int, seed: int) -> None:
    """A shift of 70 to 130 mm that is as uncertain as large is no finding."""
    stood = case(seed, (1.0, 0.1), poses=poses)
    believed = np.tile([0.05] * 3 + [0.005] * 3, (6, 1))
    assert not standing_axes(stood.data, stood.legs, believed, 0.05, 0.005)


@pytest.mark.parametrize(
    ("axes", "most_fits"),
    [
        ([0], 5),
        pytest.param([], 0, marks=pytest.mark.slow),
        pytest.param([0, 1, 2], 0, marks=pytest.mark.slow),
    ],
)
def test_a_hanging_legs_axes_are_screened_without_another_answer(
    axes: list[int], most_fits: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    signs = np.ones(6)
    signs[axes] = -1.0
    hung = hang(np.random.default_rng(3), rows=300)
    logs = [log.with_readings(log.readings * signs) for log in hung.logs]
    given = fit_hang(logs)
    fits = 0

    def counted(changed: Sequence[Log], asked: HangOptions) -> HangFit:
        nonlocal fits
        fits += 1
        return fit_hang(changed, asked)

    monkeypatch.setattr(turned, "fit_hang", counted)
    found = turned_when_hanging(logs, HangOptions(), given)
    assert fits <= most_fits
    if axes == [0]:
        assert found is not None
        assert "fx" in {channel.split(".")[1] for channel in found.channels}
    monkeypatch.setattr(turned, "near_the_best", lambda every, *_: every)
    assert turned_when_hanging(logs, HangOptions(), given) == found
    assert fits > most_fits


def test_no_single_axis_is_named_where_the_leg_would_hang_upwards() -> None:
    """Turned as a whole but for one axis: with that one turned too its weight points up."""
    hung = hang(np.random.default_rng(3), rows=300)
    signs = np.array([-1.0, -1.0, -1.0, -1.0, -1.0, 1.0])
    logs = [log.with_readings(log.readings * signs) for log in hung.logs]
    given = fit_hang(logs)
    assert given.values.weight_n < 0
    assert turned_when_hanging(logs, HangOptions(), given) is None
