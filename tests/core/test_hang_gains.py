"""Gains of axes that differ, seen by a weight in many attitudes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.hang.gains import unequal_gains
from footcal_cli.core.hang.runs import HangRun
from footcal_cli.core.parameters import FloatArray

OFFSET, ROWS = np.array([4.0, -7.0, 12.0]), 20


def hung(seed: int, mix: FloatArray, attitudes: int = 24) -> list[HangRun]:
    """Means of 20 rows of 0.08 N under 22.5 N, mounted askew, in attitudes of up to 70°."""
    rng = np.random.default_rng([seed, 62])
    askew = Rotation.from_rotvec(rng.normal(0.0, 0.05, 3))
    runs = []
    for _ in range(attitudes):
        axis = rng.normal(size=3)
        turn = Rotation.from_rotvec(rng.uniform(-1.2, 1.2) * axis / np.linalg.norm(axis))
        down = turn.apply([0.0, 0.0, -1.0])
        wrench = np.zeros((ROWS, 6))
        wrench[:, :3] = 22.5 * mix @ askew.apply(down) + OFFSET + rng.normal(0.0, 0.08, (ROWS, 3))
        none = np.zeros(ROWS)
        runs.append(HangRun(down, wrench, none, none, none, 22.5, none, none))
    return runs


def test_a_gain_of_six_percent_is_seen_with_what_it_does_to_offsets() -> None:
    found = unequal_gains(hung(1, np.diag([1.0, 1.0, 1.06])))
    assert found is not None
    assert found.spread == pytest.approx(0.06 / 1.02, rel=0.05)
    # of 22.5 N that hang by 0.8 on average, six hundredths less what a common weight takes up
    assert 0.5 < found.offset_moved_n < 1.3


@pytest.mark.parametrize("seed", range(20))
def test_equal_gains_are_no_finding(seed: int) -> None:
    assert unequal_gains(hung(seed, np.eye(3))) is None


def test_few_attitudes_or_those_in_a_plane_say_nothing() -> None:
    assert unequal_gains(hung(2, np.diag([1.0, 1.0, 1.06]), attitudes=6)) is None
    flat = [
        replace(run, nominal_dir_t=np.array([0.0, np.sin(k), -np.cos(k)]))
        for k, run in enumerate(hung(3, np.diag([1.0, 1.0, 1.06]), 9))
    ]
    assert unequal_gains(flat) is None
