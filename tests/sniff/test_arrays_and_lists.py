"""``init`` of what a colleague hands over: arrays, MATLAB, JSON lines, and lists in prose."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from footcal_cli.formats.contract import component_names
from footcal_cli.sniff.listed_places import circle_in, grid_in, pieces_in, places_in
from footcal_cli.sniff.said_accuracy import accuracy_in
from tests.conftest import Run

ZERO = np.array([47000, 7000, -34000])
WEIGHT_N, COM_M = 28.1, np.array([0.004, -0.011, 0.087])


def recipe(run: Run, folder: Path) -> dict[str, Any]:
    done = run("init", folder, "-o", folder / "r.toml")
    assert done.exit_code == 0, done.err
    return tomllib.loads((folder / "r.toml").read_text(encoding="utf-8"))


def tool(seed: int) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Attitudes of a wrist (n, 3, 3) and the wrench of its tool (n, 6), with noise."""
    rng = np.random.default_rng(seed)
    turn = Rotation.random(60, random_state=seed)
    force = turn.inv().apply([0.0, 0.0, -WEIGHT_N])
    zero = np.array([1.5, -0.7, 2.0, 0.02, 0.07, -0.01])
    wrench = np.hstack([force, np.cross(COM_M, force)]) + zero
    sd = np.repeat([0.1, 0.01], 3)
    return turn.as_matrix(), wrench + sd * rng.standard_normal(wrench.shape)


def test_rotations_and_vectors_of_a_matlab_file(tmp_path: Path, run: Run) -> None:
    turn, wrench = tool(1)
    savemat(tmp_path / "polso.mat", {
        "R_flangia": np.moveaxis(turn, 0, -1), "forza_N": wrench[:, :3], "coppia_Nm": wrench[:, 3:],
        "dev_std": 0.1 + 0.0 * wrench, "tempo_s": 15.0 * np.arange(60.0),
    })  # fmt: skip
    found = recipe(run, tmp_path)
    columns = found["columns"]
    assert columns["fy_n"]["column"] == "forza_y_N"
    assert columns["tz_nm"]["column"] == "coppia_z_Nm"
    assert columns["body_r23"] == "R_flangia_23"
    assert not any("dev_std" in str(entry) for entry in columns.values())
    done = run("hang-calib", "--recipe", tmp_path / "r.toml", "--out", tmp_path / "o")
    assert done.exit_code == 0, done.err
    fitted = json.loads((tmp_path / "o" / "parameters.json").read_text())["parameters"]
    weight = fitted["sensor.weight"]
    assert abs(weight["value"] - WEIGHT_N) < 4 * weight["sd"]


def test_one_stance_in_each_line(tmp_path: Path, run: Run) -> None:
    rng = np.random.default_rng(2)
    lines = []
    for k in range(60):
        com = [0.02 * rng.standard_normal(), 0.02 * rng.standard_normal(), 0.8]
        share = 0.5 + com[1] / 0.2
        line = {"pose": k, "com_m": com, "temp_C": 22.0}
        for foot, y, part in (("left", 0.1, share), ("right", -0.1, 1.0 - share)):
            force = 300.0 * part
            line[foot] = {
                "pos_m": [0.0, y, 0.06], "quat_xyzw": [0.0, 0.0, 0.0, 1.0],
                "wrench_mean": [0.0, 0.0, force, 0.0, -force * com[0], 0.0],
                "wrench_std": [0.1] * 6,
            }  # fmt: skip
        lines.append(json.dumps(line))
    (tmp_path / "poses.jsonl").write_text("\n".join(lines))
    (tmp_path / "NOTES.md").write_text("The robot stands on both feet; it weighs 30.6 kg.\n")
    found = recipe(run, tmp_path)
    assert found["columns"]["left_foot_qw"] == "left.quat_w"
    assert found["columns"]["right_foot_y_m"]["column"] == "right.pos_y_m"
    assert found["columns"]["left_fz_n"]["column"] == "left.wrench_mean_2"
    assert "std" not in str(found["columns"])
    assert found["diagnose"]["experiment"] == "stand", "rows without stamps are no walk"


@pytest.mark.parametrize(
    ("name", "count", "names"),
    [
        ("com_m", 3, ["com_x_m", "com_y_m", "com_z_m"]),
        ("cells_N", 3, ["cells_0_N", "cells_1_N", "cells_2_N"]),
        ("q_deg", 3, ["q_0_deg", "q_1_deg", "q_2_deg"]),
        ("quat_wxyz", 4, ["quat_w", "quat_x", "quat_y", "quat_z"]),
        ("wrench", 6, [f"wrench_{i}" for i in range(6)]),
    ],
)
def test_names_of_the_numbers_of_a_list(name: str, count: int, names: list[str]) -> None:
    assert component_names(name, count) == names


TRIANGLE = """Foot on three cells, 55 mm from its centre.
The disc lies on cells at a radius of 55 mm, at 90, 210 and 330 degrees from x (K1, K2, K3).
Holes (no., x mm, y mm):
   1     0.00    0.00
   2    25.00    0.00
   3    12.50   21.65
  12   -25.00  -21.65
"""


def test_places_in_prose() -> None:
    holes = places_in(Path("a.txt"), TRIANGLE)
    assert holes is not None
    assert holes.columns[0].words == ("1", "2", "3", "12")
    assert holes.columns[1].unit == "mm"
    cells = circle_in(Path("a.txt"), TRIANGLE)
    assert cells is not None
    assert cells.columns[0].words == ("K1", "K2", "K3")
    assert cells.columns[2].values == pytest.approx([55.0, -27.5, -27.5])
    told = (
        "Holes: rows A to E at y = 50, 25, 0, -25, -50 mm, columns 1 to 7 at\n"
        "x = -90, -60, ..., +90 mm."
    )
    grid = grid_in(Path("a.txt"), told)
    assert grid is not None
    where = dict(zip(grid.columns[0].words, zip(*(c.values for c in grid.columns[1:] if c.values is
                 not None), strict=True), strict=True))  # fmt: skip
    assert where["A1"] == (-90.0, 50.0)
    assert where["E7"] == (90.0, -50.0)
    assert pieces_in(Path("a.txt"), "it would be 51.38 kg, and g 9.81") is None


def test_how_far_readings_may_be_off() -> None:
    gain, zero = accuracy_in([
        "Sensitivities from the certificates (0.4 %) are applied, the zeros are not tared",
        "(2-3 N), resolution 0.25 N; non-linearity 0.05 % of full scale",
    ])  # fmt: skip
    assert gain is not None
    assert zero is not None
    assert (gain[0], zero[0]) == (0.004, 3.0)
    assert accuracy_in(["crosstalk under 0.5 % FS, 0.02 %/K on span"]) == (None, None)


def test_stacks_on_spots_in_a_file_each(tmp_path: Path, run: Run) -> None:
    cells = np.array([[0.06, 0.0], [-0.035, 0.045], [-0.035, -0.045]])
    gain = np.array([4230.0, 4327.0, 4324.0])
    spots = {"A": (0, 0), "B": (42, 0), "C": (-22, 30), "D": (-22, -30)}
    rng = np.random.default_rng(3)
    for name, (x, y) in spots.items():
        share = np.linalg.solve(np.vstack([np.ones(3), cells.T]), [1.0, x / 1e3, y / 1e3])
        mass = np.repeat([0, 2, 4, 8, 14, 18, 14, 8, 4, 2, 0], 40)
        force = 9.807 * mass[:, None] * share
        counts = np.rint(gain * force + ZERO + 75 * rng.standard_normal(force.shape))
        table = pd.DataFrame(counts.astype(int), columns=["ch1", "ch2", "ch3"])
        table.insert(0, "mass_kg", mass)
        table.insert(0, "time_s", 0.1 * np.arange(mass.size))
        table.to_csv(tmp_path / f"session_{name}.csv", index=False)
    (tmp_path / "README.txt").write_text(
        "Weights are stacked on a spindle, one spot per session.\n"
        "The boards give nominally 4280 counts per newton, up when a cell is pressed.\n"
        "After every change I wait for six seconds and log for four more.\n"
        "Frame: origin on the plate at the mark, x to the toe, y to the left, mm.\n"
        "  cell 1 (ch1):  60,   0\n  cell 2 (ch2): -35,  45\n  cell 3 (ch3): -35, -45\n"
        "The spots were, g = 9.807 m/s2:\n"
        "  session A:   0,   0\n  session B:  42,   0\n  session C: -22,  30\n"
        "  session D: -22, -30   (the next day)\n"
    )  # fmt: skip
    found = recipe(run, tmp_path)
    assert found["columns"]["load_n"] == {"column": "mass_kg", "unit": "kg"}
    assert found["columns"]["hole_x_m"]["names"]["C"] == "-22"
    assert found["robot"]["feet"]["foot"]["cells"]["ch2"] == {"x_m": -0.035, "y_m": 0.045}
    done = run("offline-fit", "--recipe", tmp_path / "r.toml", "--out", tmp_path / "o")
    assert done.exit_code == 0, done.err
    fitted = json.loads((tmp_path / "o" / "parameters.json").read_text())["parameters"]
    for k, true in enumerate(gain):
        assert 1.0 / fitted[f"foot_ch{k + 1}.scale"]["value"] == pytest.approx(true, rel=2e-3)
