"""How long six-axis calibrations take, each beside its paper's method in the same run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from footcal_cli.core.hang.joint import fit_hang
from footcal_cli.core.pose.data import PoseData, summarise
from footcal_cli.core.pose.joint import fit_pose
from footcal_cli.core.study.alternating import fit_alternating
from footcal_cli.core.study.stepwise import fit_stepwise
from tests.core.pose_cases import Case, case
from tests.core.six_axis_data import TABLE_2, WEIGHT_N, com_m, hang


@pytest.mark.benchmark(group="hanging: 4 logs, 6 legs, 10 000 samples")
@pytest.mark.parametrize("method", ["joint", "stepwise"])
def test_hanging(benchmark: Any, method: str) -> None:
    fit: Callable[[Any], object] = fit_hang if method == "joint" else fit_stepwise
    logs = [
        hang(np.random.default_rng(leg), leg, rows=10_000, rate_hz=50.0).logs for leg in range(6)
    ]
    benchmark.pedantic(lambda: [fit(log) for log in logs], rounds=3)


@pytest.mark.benchmark(group="standing: 543 poses")
@pytest.mark.parametrize("method", ["joint", "alternating as printed", "alternating, exact"])
def test_standing(benchmark: Any, method: str) -> None:
    one = case(1, friction_n=3.0)
    com = np.stack([com_m(one.data.phase_rad[:, k]) for k in range(6)], axis=1)

    def fit() -> object:
        if method == "joint":
            return fit_pose(summarise(one.data), one.legs, one.noise_sd)
        printed = method == "alternating as printed"
        return fit_alternating(one.data, TABLE_2, WEIGHT_N, com, printed=printed)

    benchmark.pedantic(fit, rounds=3)


def written(one: Case, poses: int, path: Path) -> None:
    """The case's poses as a wide Parquet file, repeated to the asked number."""
    data = one.data
    rows = np.arange(poses) % len(data)
    table = {f"w{i}": data.wrench_t.reshape(len(data), 36)[rows, i] for i in range(36)}
    table |= {f"g{i}": data.gravity_b[rows, i] for i in range(3)}
    pd.DataFrame(table).to_parquet(path)


@pytest.mark.benchmark(group="standing: 50 000 poses, reading included")
def test_fifty_thousand_poses(benchmark: Any, tmp_path: Path) -> None:
    one = case(2, poses=2000)
    path, poses = tmp_path / "poses.parquet", 50_000
    written(one, poses, path)

    def whole() -> bool:
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
        return fit_pose(summarise(data), one.legs, one.noise_sd).converged

    assert benchmark.pedantic(whole, rounds=3)


def test_work_of_the_iterations_does_not_depend_on_the_number_of_poses() -> None:
    one = case(3, poses=1000)
    few = summarise(one.data)
    fit = fit_pose(few, one.legs, one.noise_sd)
    assert fit.iterations <= 12
    assert few.gram.shape == (40, 40)
