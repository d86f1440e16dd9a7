"""Hanging robots whose logs name orientations in words: init, and the command that it prints."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.sniff.sides import says_up, side_in
from tests.conftest import Run

WEIGHT_N, OFFSET_N, ROWS = 18.0, np.array([0.4, -0.6, 0.9]), 120
COM_M = np.array([-0.015, 0.04, -0.15])
DOWN = {"-z": [0, 0, -1], "+z": [0, 0, 1], "-x": [-1, 0, 0], "+x": [1, 0, 0]}
PARALLEL = {leg: Rotation.identity() for leg in ("VL", "VR", "HL", "HR")}
UPSIDE_DOWN = {leg: Rotation.from_euler("x", 180, degrees=True) for leg in ("FL", "FR")}
OUTWARD = {
    leg: Rotation.from_euler("x", angle, degrees=True)
    for leg, angle in (("A", -90), ("B", -90), ("D", 90), ("E", 90))
}


def rows_of(
    legs: Mapping[str, Rotation], down: str, rng: np.random.Generator, sign: float
) -> list[tuple[str, float, Any]]:
    """Leg, shaft angle in degrees and wrench of a swing of every leg, in one orientation."""
    made = []
    gravity = np.array(DOWN[down], dtype=float)
    for leg, turn in legs.items():
        for angle in 70.0 * np.sin(np.linspace(0.0, 2 * np.pi, ROWS)):
            force = WEIGHT_N * gravity
            com = Rotation.from_euler("y", angle, degrees=True).apply(COM_M)
            wrench = np.concatenate(
                [turn.inv().apply(force), turn.inv().apply(np.cross(com, force))]
            )
            wrench = sign * wrench + np.concatenate([OFFSET_N, 0.02 * OFFSET_N])
            wrench += rng.normal(0.0, [0.05] * 3 + [0.005] * 3)
            made.append((leg, angle, wrench))
    return made


def hung(
    folder: Path, legs: Mapping[str, Rotation], words: Mapping[str, str], column: str, leg: str,
    angle: str, sign: float = 1.0,
) -> Path:  # fmt: skip
    """One log of all orientations, words -> the axis that truly points down."""
    rng, t = np.random.default_rng(4), 0.0
    lines = [f"t,{column},{leg},{angle},Fx,Fy,Fz,Tx,Ty,Tz"]
    for word, down in words.items():
        for name, at, wrench in rows_of(legs, down, rng, sign):
            t += 0.05
            numbers = ",".join(f"{v:.4f}" for v in wrench)
            lines.append(f"{t:.2f},{word},{name},{at:.3f},{numbers}")
    path = folder / "hung.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def guessed(run: Run, *logs: Path) -> dict[str, Any]:
    recipe = logs[0].with_name("guess.toml")
    answer = run("init", *logs, "-o", recipe, "--overwrite")
    assert answer.exit_code == 0, answer.err
    assert "next: footcal hang-calib --recipe" in answer.out
    return tomllib.loads(recipe.read_text())


@pytest.mark.parametrize(
    ("legs", "words", "names", "sign"),
    [
        (PARALLEL, {"zu": "-z", "zd": "+z", "xu": "-x", "xd": "+x"},
         ("setup", "leg", "q_hfe_deg"), 1.0),
        (UPSIDE_DOWN, {"Z+": "-z", "X+": "-x", "Z-": "+z", "X-": "+x"},
         ("up_axis", "leg", "hfe_deg"), 1.0),
        (OUTWARD, {"z_arriba": "-z", "x_arriba": "-x", "z_abajo": "+z", "x_abajo": "+x"},
         ("orientacion", "pata", "cadera_grados"), -1.0),
        (OUTWARD, {"+z": "+z", "-x": "-x", "-z": "-z", "+x": "+x"},
         ("orientation", "leg", "phase_deg"), 1.0),
        (PARALLEL, {"top_up": "-z", "nose_up": "-x", "top_down": "+z", "nose_down": "+x"},
         ("hanging", "leg", "hip_deg"), 1.0),
    ],
    ids=["letters", "axis that is up", "reaction in Spanish", "along gravity", "sides"],
)  # fmt: skip
def test_words_of_an_orientation_name_an_axis_of_the_body(
    run: Run, tmp_path: Path, legs: Mapping[str, Rotation], words: Mapping[str, str],
    names: tuple[str, str, str], sign: float,
) -> None:  # fmt: skip
    log = hung(tmp_path, legs, words, *names, sign=sign)
    recipe = guessed(run, log)
    columns = recipe["columns"]
    assert columns["orientation"]["names"] == words
    assert columns["leg"] == names[1]
    assert columns["phase_rad"] == {"column": names[2], "unit": "deg"}
    assert columns["fx_n"].get("factor", 1.0) == sign
    assert recipe["hang_calib"]["orientation_of"] == "body"
    for leg, turn in legs.items():
        said = Rotation.from_euler("xyz", recipe["robot"]["legs"][leg]["rotation_rpy_rad"])
        assert (said.inv() * turn).magnitude() < 1e-3


def test_the_command_that_init_prints_weighs_the_legs(run: Run, tmp_path: Path) -> None:
    words = {"zu": "-z", "zd": "+z", "xu": "-x", "xd": "+x"}
    log = hung(tmp_path, OUTWARD, words, "setup", "leg", "hip_deg", sign=-1.0)
    guessed(run, log)
    done = run("hang-calib", "--recipe", tmp_path / "guess.toml", "--out", tmp_path / "out",
               "--no-pictures")  # fmt: skip
    assert done.exit_code == 0, done.err
    found = json.loads((tmp_path / "out/parameters.json").read_text())["parameters"]
    for leg in OUTWARD:
        weight = found[f"{leg}.weight"]
        assert abs(weight["value"] - WEIGHT_N) < max(4 * weight["sd"], 0.02)


def test_orientations_in_the_names_of_files_hang_all_legs_of_one_body(
    run: Run, tmp_path: Path
) -> None:
    said = {"ruecken_oben": "-z", "bauch_oben": "+z", "kopf_oben": "-x", "kopf_unten": "+x"}
    logs, rng = [], np.random.default_rng(4)
    for word, down in said.items():
        lines = ["Zeit_s;Bein;Huefte_Grad;Fx_N;Fy_N;Fz_N;Mx_Ncm;My_Ncm;Mz_Ncm"]
        rows = rows_of(PARALLEL, down, rng, 1.0)
        order = rng.permutation(len(rows))  # the legs come in another order in each file
        for k, i in enumerate(order):
            name, at, wrench = rows[i]
            numbers = (f"{v:.3f}" for v in (*wrench[:3], *(100 * wrench[3:])))
            lines.append(
                ";".join([f"{0.01 * k:.2f}", name, f"{at:.2f}", *numbers]).replace(".", ",")
            )
        path = tmp_path / f"haengend_{word}.csv"
        path.write_text("\n".join(lines) + "\n")
        logs.append(path)
    recipe = guessed(run, *logs)
    (files,) = recipe.get("files", [{}])
    columns = recipe["columns"] if "columns" in recipe else files["columns"]
    names = {f"haengend_{word}.csv": down for word, down in said.items()}
    assert columns["orientation"]["names"] == names
    assert columns["phase_rad"] == {"column": "Huefte_Grad", "unit": "deg"}
    done = run("hang-calib", "--recipe", tmp_path / "guess.toml", "--out", tmp_path / "out",
               "--no-pictures")  # fmt: skip
    assert done.exit_code == 0, done.err


def test_poses_given_beside_hanging_are_an_experiment_of_their_own(
    run: Run, tmp_path: Path
) -> None:
    """Poses have an attitude and loads; they are not the attitude of the hanging log."""
    words = {"z_up": "-z", "z_down": "+z", "x_up": "-x", "x_down": "+x"}
    log = hung(tmp_path, OUTWARD, words, "orientation", "leg", "phase_deg", sign=-1.0)
    rng = np.random.default_rng(6)
    lines = ["pose,t,roll_deg,pitch_deg,leg,phase_deg,foot_x_mm,foot_y_mm,foot_z_mm,"
             "Fx,Fy,Fz,Tx,Ty,Tz"]  # fmt: skip
    for pose in range(1, 21):
        roll, pitch = rng.uniform(-8.0, 8.0, 2)
        share = rng.dirichlet(4 * np.ones(len(OUTWARD)))
        up = Rotation.from_euler("xyz", [roll, pitch, 0.0], degrees=True).inv().apply([0, 0, 1])
        for (leg, turn), own in zip(OUTWARD.items(), share, strict=True):
            force = -turn.inv().apply(90.0 * own * up + rng.normal(0.0, 3.0, 3) * [1, 1, 0])
            numbers = ",".join(f"{v:.3f}" for v in (*force, *rng.normal(0.0, 1.0, 3)))
            foot = ",".join(f"{v:.1f}" for v in rng.normal([0, 0, -140], [150, 150, 3]))
            at = f"{pose},{60 + 27 * pose},{roll:.2f},{pitch:.2f},{leg},{60 + pose / 7:.2f}"
            lines.append(f"{at},{foot},{numbers}")
    poses = tmp_path / "poses.csv"
    poses.write_text("\n".join(lines) + "\n")
    recipe = guessed(run, log, poses)
    assert sorted(recipe["data"]) == ["hang", "poses"]
    hang, stood = (one["columns"] for one in recipe["files"])
    assert hang["orientation"]["names"] == words
    assert "body_roll_rad" not in hang
    assert stood["body_roll_rad"] == {"column": "roll_deg", "unit": "deg"}
    assert stood["phase_rad"] == {"column": "phase_deg", "unit": "deg"}
    assert stood["fx_n"]["factor"] == hang["fx_n"]["factor"] == -1.0


def test_words_that_name_no_axis_are_asked_for(run: Run, tmp_path: Path) -> None:
    words = {"A": "-z", "B": "+z", "C": "-x", "D": "+x"}
    log = hung(tmp_path, PARALLEL, words, "orientation", "leg", "phase_deg")
    answer = run("init", log, "-o", tmp_path / "guess.toml")
    assert answer.exit_code == 0, answer.err
    assert "nothing says which axis points down in each orientation" in answer.out
    text = (tmp_path / "guess.toml").read_text()
    assert '"A" = "", "B" = ""' in text


@pytest.mark.parametrize(
    ("word", "axis", "said"),
    [
        ("zu", "-z", True), ("xd", "+x", True), ("X+", "+x", False), ("kopf_oben", "-x", True),
        ("haengend_bauch_oben.csv", "+z", True), ("nose up", "-x", True), ("up_-y", "+y", True),
        ("z hacia arriba", "-z", True), ("upside_down", "+z", True), ("zd_run", None, False),
        ("x_haut", "-x", True), ("dos en haut", None, False), ("setup", None, False),
    ],
)  # fmt: skip
def test_sides_that_words_name(word: str, axis: str | None, said: bool) -> None:
    assert side_in(word) == (axis, said)


def test_a_column_may_be_called_after_the_axis_that_is_up() -> None:
    assert says_up("up_axis") is True
    assert says_up("eje_abajo") is False
    assert says_up("orientation") is None


@pytest.mark.parametrize("legs", [OUTWARD, {"tool": Rotation.identity()}], ids=["legs", "wrist"])
def test_a_file_for_each_orientation_that_a_column_names(
    run: Run, tmp_path: Path, legs: Mapping[str, Rotation]
) -> None:
    words = {"z_arriba": "-z", "x_arriba": "-x", "z_abajo": "+z", "x_abajo": "+x"}
    head, *rows = hung(tmp_path, legs, words, "orientacion", "pata", "cadera_grados").read_text(
    ).splitlines()  # fmt: skip
    logs = [tmp_path / f"ensayo_{i}.csv" for i in range(len(words))]
    for log, word in zip(logs, words, strict=True):
        log.write_text("\n".join([head, *(x for x in rows if f",{word}," in x)]) + "\n")
    recipe = guessed(run, *logs)
    assert recipe["columns"]["orientation"]["names"] == words
    assert "TO FILL IN" not in (tmp_path / "guess.toml").read_text()
    assert run("init", logs[0], "-o", tmp_path / "guess.toml", "--overwrite").exit_code == 0
    text = (tmp_path / "guess.toml").read_text()
    assert "every row is in the one orientation z_arriba" in text
    assert "turn with its leg" not in text
