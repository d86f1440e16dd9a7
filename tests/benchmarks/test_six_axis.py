"""How fast six-axis calibrations are, each against its paper's method in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from footcal_cli.core.hang.joint import fit_hang
from footcal_cli.core.hang.stepwise import fit_stepwise
from footcal_cli.core.pose.alternating import fit_alternating
from footcal_cli.core.pose.data import PoseData, summarise
from footcal_cli.core.pose.joint import fit_pose
from tests.core.pose_cases import Case, case
from tests.core.six_axis_data import TABLE_2, WEIGHT_N, com_m, hang

Record = Callable[[str, object], None]


def seconds(call: Callable[[], object], repeats: int = 3) -> float:
    """Best of some repeats."""
    best = np.inf
    for _ in range(repeats):
        began = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - began)
    return float(best)


@pytest.mark.slow
def test_joint_hanging_fit_of_six_legs_against_the_stepwise_method(
    record_property: Record,
) -> None:
    """Four logs × 6 legs × 10⁴ samples."""
    logs = [
        hang(np.random.default_rng(leg), leg, rows=10_000, rate_hz=50.0).logs for leg in range(6)
    ]
    joint = seconds(lambda: [fit_hang(log) for log in logs])
    stepwise = seconds(lambda: [fit_stepwise(log) for log in logs], 1)
    record_property("joint_s", joint)
    record_property("stepwise_s", stepwise)
    assert joint < stepwise / 25.0


@pytest.mark.slow
def test_joint_standing_fit_against_the_alternating_scheme(record_property: Record) -> None:
    one = case(1, friction_n=3.0)
    com = np.stack([com_m(one.data.phase_rad[:, k]) for k in range(6)], axis=1)
    joint = seconds(lambda: fit_pose(summarise(one.data), one.legs, one.noise_sd), 5)
    printed = seconds(lambda: fit_alternating(one.data, TABLE_2, WEIGHT_N, com, printed=True), 1)
    record_property("joint_s", joint)
    record_property("as_printed_s", printed)
    assert joint < printed / 60.0


def written(one: Case, poses: int, path: Path) -> None:
    """The case's poses as a wide Parquet file, repeated to the asked number."""
    data = one.data
    rows = np.arange(poses) % len(data)
    table = {f"w{i}": data.wrench_t.reshape(len(data), 36)[rows, i] for i in range(36)}
    table |= {f"g{i}": data.gravity_b[rows, i] for i in range(3)}
    pd.DataFrame(table).to_parquet(path)


def test_fifty_thousand_poses_in_under_a_second_with_reading(tmp_path: Path) -> None:
    one = case(2, poses=2000)
    path, poses = tmp_path / "poses.parquet", 50_000
    written(one, poses, path)

    def whole() -> None:
        table = pq.read_table(path)
        columns = np.stack([column.to_numpy() for column in table.columns], axis=1)
        data = PoseData(
            one.data.geometry,
            columns[:, :36].reshape(-1, 6, 6),
            np.zeros((poses, 6)),
            columns[:, 36:],
            np.broadcast_to(np.eye(3), (poses, 3, 3)),
            np.ones((poses, 6)),
            one.data.robot_weight_n,
            one.data.leg_weight_n,
            np.arange(poses),
        )
        assert fit_pose(summarise(data), one.legs, one.noise_sd).converged

    took = seconds(whole, 2)
    assert took < 1.0


def test_work_of_the_iterations_does_not_depend_on_the_number_of_poses() -> None:
    one = case(3, poses=1000)
    few = summarise(one.data)
    fit = fit_pose(few, one.legs, one.noise_sd)
    assert fit.iterations <= 12
    assert few.gram.shape == (40, 40)
