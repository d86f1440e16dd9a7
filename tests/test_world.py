"""Logs of worlds whose z does not point up, and attitudes without a heading."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.body_positions import check_positions
from footcal_cli.recipe import read_recipe
from footcal_cli.tables.columns import TableType, body_table, poses_table
from footcal_cli.tables.reading import Reading
from footcal_cli.tables.table import read_table
from footcal_cli.tables.world import WorldUp

G = 9.80665
# the log's axes in a world with z up, written down by hand: columns are the log's x, y, z
AXES = {
    "+y": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
    "-z": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
    "+x": [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
}  # fmt: skip
VECTORS = ("com_{}_m", "com_acc_{}_mps2", "angmom_rate_{}_nm", "left_foot_{}_m")


def _read(frame: pd.DataFrame, kind: TableType, folder: Path, up: WorldUp) -> pd.DataFrame:
    path = folder / f"log{up}.csv"
    frame.to_csv(path, index=False)
    return read_table(path, kind, Reading(world_up=up), gravity_mps2=G).data


@pytest.mark.parametrize("up", ["+y", "-z", "+x"])
def test_a_log_reads_the_same_in_every_world(up: WorldUp, tmp_path: Path) -> None:
    rng, n = np.random.default_rng(3), 20
    frame = pd.DataFrame({"time_s": np.arange(n) / 100.0})
    for pattern in VECTORS:
        for axis in "xyz":
            frame[pattern.format(axis)] = rng.normal(size=n)
    yaw = rng.uniform(-1.0, 1.0, n)
    foot = Rotation.from_euler("ZY", np.column_stack([yaw, rng.uniform(-0.2, 0.2, n)]))
    frame["left_foot_yaw_rad"] = yaw
    names = [f"left_foot_q{a}" for a in "xyzw"]
    frame[names] = foot.as_quat()
    there = frame.copy()
    turn = Rotation.from_matrix(np.array(AXES[up]).T)  # from z up to the log's world
    for pattern in VECTORS:
        columns = [pattern.format(axis) for axis in "xyz"]
        there[columns] = turn.apply(frame[columns])
    there[names] = (turn * foot).as_quat()
    there["left_foot_yaw_rad"] *= -1.0 if up == "-z" else 1.0
    kind = body_table(("left",))
    here, read = _read(frame, kind, tmp_path, "+z"), _read(there, kind, tmp_path, up)
    for name in here:
        if name not in names:
            assert np.allclose(here[name], read[name], atol=1e-9), name
    same = Rotation.from_quat(here[names]).inv() * Rotation.from_quat(read[names])
    assert same.magnitude().max() < 1e-8


@pytest.mark.parametrize("up", ["+z", "+y", "-z"])
def test_a_world_that_is_not_upright_is_named(up: WorldUp) -> None:
    rng = np.random.default_rng(4)
    com = rng.normal([0.02, 0.0, 0.3], 0.01, (60, 3))
    feet = np.stack([com * 0.2 + [0.0, y, -0.05] for y in (0.05, -0.05)], axis=1)
    turn = np.array(AXES.get(up, np.eye(3))).T
    found = check_positions(com @ turn.T, feet @ turn.T, "body.csv")
    if up == "+z":
        assert not found
        return
    (one,) = found
    assert one.severity == "alarm"
    assert f'world_up = "{up}"' in one.remedy


def test_the_direction_of_gravity_is_an_attitude_but_for_the_heading(tmp_path: Path) -> None:
    body = Rotation.from_euler("ZYX", [[0.4, 0.1, -0.2], [2.0, -1.2, 3.0]])
    gravity = 9.81 * body.inv().apply([0.0, 0.0, -1.0])
    frame = pd.DataFrame({"pose": ["a", "b"], "leg": ["fl", "fl"], "phase_rad": [0.0, 1.0]})
    for name in ("fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm"):
        frame[name] = 1.0
    frame[[f"body_gravity_{a}" for a in "xyz"]] = gravity
    for up in ("+z", "+y"):  # gravity points down in every world
        read = _read(frame, poses_table(), tmp_path, up)
        found = Rotation.from_quat(read[[f"body_q{a}" for a in "xyzw"]])
        assert np.allclose(9.81 * found.inv().apply([0.0, 0.0, -1.0]), gravity, atol=1e-9)


def test_a_recipe_says_which_axis_points_up(tmp_path: Path) -> None:
    recipe = tmp_path / "r.toml"
    recipe.write_text('[robot]\nworld_up = "+y"\n', encoding="utf-8")
    assert read_recipe(recipe, ()).reading(Path("log.csv")).world_up == "+y"
