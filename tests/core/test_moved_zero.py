"""A zero that moves along a walk shows in the swings; a tracked calibration follows it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from footcal_cli.core.diagnosis import moved_zero as moved_zeros
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.inquiry import Inquiry
from footcal_cli.core.diagnosis.investigation import investigate
from footcal_cli.core.diagnosis.moved_zero import moved_zero, with_moved_zero
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Trait
from footcal_cli.core.inference.case import Case, rows_of
from tests.core.test_diagnosis_bridge import ROBOT, walk_case

CELL = ROBOT.channels[2]


def walked(seed: int, moves: dict[str, float], wander_n: float = 0.0) -> Case:
    """A walk in which zeros move by so many newtons in all, most of it early."""
    case = walk_case(seed, None)
    (log,) = case.logs
    scale = np.array([case.values[f"{c}.scale"] for c in ROBOT.channels])
    share = (log.time_s - log.time_s[0]) / np.ptp(log.time_s)
    zero = np.outer(
        (1.0 - np.exp(-1.5 * share)) / (1.0 - np.exp(-1.5)),
        [moves.get(c, 0.0) for c in ROBOT.channels],
    )
    rng = np.random.default_rng([seed, 7])
    steps = rng.standard_normal((len(log), len(ROBOT.channels)))
    zero += wander_n * np.cumsum(steps, axis=0) / np.sqrt(len(log))
    return replace(case, logs=(replace(log, readings=log.readings + zero / scale),))


def moved(case: Case) -> str:
    return moved_zero(problem_from(case, rows_of(case), [], describe), 0.2)[0]


@pytest.mark.parametrize("seed", range(4))
def test_zeros_that_wander_alike_are_no_cell_of_its_own(seed: int) -> None:
    assert moved(walked(seed, {}, wander_n=1.0)) == ""


def test_a_zero_that_creeps_away_is_found_among_others_that_wander() -> None:
    assert moved(walked(1, {CELL: 3.0}, wander_n=0.1)) == CELL


def test_a_zero_that_moves_by_less_than_matters_has_not_moved() -> None:
    assert moved(walked(1, {CELL: 0.4}, wander_n=0.01)) == ""


@pytest.mark.parametrize(("moved_nm", "expected"), [(2.0, "left.ty"), (0.0, "")])
def test_the_torque_of_an_ankle_that_warms_up_is_found(
    monkeypatch: pytest.MonkeyPatch, moved_nm: float, expected: str
) -> None:
    """Forces wander by newtons, torques by hundredths; one torque goes one way."""
    rng = np.random.default_rng(3)
    time_s = np.linspace(0.0, 48.0, 18)
    zeros = {
        f"{foot}.{axis}": (0.4 if axis[0] == "f" else 0.02) * rng.standard_normal(time_s.size)
        for foot in ("left", "right") for axis in ("fx", "fy", "fz", "tx", "ty", "tz")
    }  # fmt: skip
    zeros["left.ty"] += moved_nm * time_s / time_s[-1]
    monkeypatch.setattr(
        moved_zeros, "at_rest",
        lambda _, name: (time_s, zeros[name], "N" if ".f" in name else "Nm"),
    )  # fmt: skip
    problem = SimpleNamespace(drifts=True, traces=SimpleNamespace(names=tuple(zeros)))
    assert moved_zero(cast(Any, problem), 1.6)[0] == expected


def test_the_answer_names_the_cell_and_what_moves_a_zero() -> None:
    case = walked(2, {CELL: 3.0}, wander_n=0.1)
    zeros = {n: e for n, e in TABLE.items() if Trait.ZERO in e.traits}
    before = investigate(case, {}, describe)
    found = with_moved_zero(before, zeros, Inquiry(TABLE, describe))
    assert found.verdict == "ambiguous"
    (item,) = found.found
    assert item.owner == CELL
    names = {item.cause.signature.effect, *(r.effect for r in item.cause.rivals)}
    assert names == {"bias_drift", "temperature_bias", "creep"}
    duration_s = float(np.ptp(case.logs[0].time_s))
    assert item.intervals[0].value * duration_s == pytest.approx(3.0, rel=0.4)
