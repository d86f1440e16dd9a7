"""Stands in which the robot hung once: a file among the stands, or a stance among others."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord
from tests.conftest import Run

WEIGHT_N, STANCES = 700.0, 10
CELLS = ((0.105, 0.005), (-0.05, 0.034), (-0.05, -0.034))
ZERO_N = np.array([3.0, -2.0, 1.5, -4.0, 2.5, 0.5])
NAMES = ("Z", "FL", "FM")


def stances(rng: np.random.Generator) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Places of both soles (2, 2), the CoM (2,) and what each cell carries (6,), of each stance."""
    found = []
    for _ in range(STANCES):
        soles = np.array([[0.0, 0.13], [0.0, -0.13]]) + rng.uniform(-0.03, 0.03, (2, 2))
        com = soles.mean(axis=0) + rng.uniform(-0.03, 0.03, 2)
        at = np.vstack([soles[0] + CELLS, soles[1] + CELLS])
        table = np.vstack([np.ones(6), at.T])
        found.append(
            (soles, com, np.linalg.lstsq(table, WEIGHT_N * np.r_[1.0, com], rcond=None)[0])
        )
    return found


def read(force: np.ndarray, rng: np.random.Generator, rows: int) -> np.ndarray:
    """Readings (rows, 6) in newtons."""
    return np.asarray(force + ZERO_N + rng.normal(0, 0.3, (rows, 6)))


def files(folder: Path) -> list[Path]:
    """A file for each stand with decimal commas, one of the hanging robot, and a sheet of poses."""
    rng = np.random.default_rng(1)
    header = "Zeit;" + ";".join(f"F_{s}_{n}" for s in ("LI", "RE") for n in NAMES)
    units = "s;" + ";".join(["N"] * 6)
    paths, poses = [], ["Stand;links_x_mm;links_y_mm;links_gier_grad;rechts_x_mm;rechts_y_mm;"
                        "rechts_gier_grad"]  # fmt: skip
    hung = (np.zeros((2, 2)), np.zeros(2), np.zeros(6))
    for number, (soles, com, force) in enumerate([hung, *stances(rng)]):
        lines = [f"{header};Schwerpunkt_x;Schwerpunkt_y", f"{units};mm;mm"]
        for i, row in enumerate(read(force, rng, 300)):
            centre = ";".join(f"{1e3 * c + rng.normal(0, 0.3):.2f}" for c in com)
            said = ";".join(f"{v:.2f}" for v in row)
            lines.append(f"{0.02 * i:.2f};{said};{centre}".replace(".", ","))
        path = folder / f"stand_{number:02d}{'' if number else '_haengend'}.asc"
        path.write_text("\n".join(lines) + "\n")
        paths.append(path)
        if number:
            feet = ";".join(f"{1e3 * x:.2f};{1e3 * y:.2f};0,0" for x, y in soles)
            poses.append(f"{number};{feet}".replace(".", ","))
    sheet = folder / "posen.csv"
    sheet.write_text("\n".join(poses) + "\n")
    return [*paths, sheet]


def one_file(folder: Path) -> list[Path]:
    """All stances in one log under a number, the hanging robot being 0."""
    rng = np.random.default_rng(2)
    cells = ",".join(f"{s}_{n}_N" for s in "LR" for n in ("F1", "F2", "F3"))
    lines = [f"t,stance_id,{cells},l_sole_x,l_sole_y,l_sole_z,r_sole_x,r_sole_y,r_sole_z,"
             "com_x,com_y,com_z"]  # fmt: skip
    hung = (np.array([[0.0, 0.13], [0.0, -0.13]]), np.zeros(2), np.zeros(6))
    clock = 0.0
    for number, (soles, com, force) in enumerate([hung, *stances(rng)]):
        z = 0.0 if number else 0.3
        for row in read(force, rng, 300):
            feet = ",".join(f"{x:.5f},{y:.5f},{z + rng.normal(0, 1e-4):.5f}" for x, y in soles)
            centre = ",".join(f"{c + rng.normal(0, 3e-4):.5f}" for c in com)
            said = ",".join(f"{v:.3f}" for v in row)
            lines.append(f"{clock:.2f},{number},{said},{feet},{centre},{0.7 + z:.4f}")
            clock += 0.02
    path = folder / "standing_log.csv"
    path.write_text("\n".join(lines) + "\n")
    return [path]


def rows_of_means(folder: Path) -> list[Path]:
    """A row for each stance, mean and scatter of each cell; the robot hung before and after."""
    rng = np.random.default_rng(3)
    cells = [f"{s}_{n}" for s in ("left", "right") for n in ("toe", "heel_l", "heel_r")]
    columns = [f"{cell}_{what}_N" for cell in cells for what in ("mean", "std")]
    columns += [f"{s}_sole_{axis}" for s in ("left", "right") for axis in "xyz"]
    hung = (np.array([[0.0, 0.13], [0.0, -0.13]]), np.zeros(2), np.zeros(6))
    lines = [",".join(["stance", *columns, "com_x", "com_y", "com_z"])]
    every = [("air_start", hung), *enumerate(stances(rng), 1), ("air_end", hung)]
    for name, (soles, com, force) in every:
        noisy = read(force, rng, 400)
        means = np.column_stack([noisy.mean(axis=0), noisy.std(axis=0)]).ravel()
        feet = [v for x, y in soles for v in (x, y, 0.0)]
        lines.append(",".join([str(name), *(f"{v:.4f}" for v in (*means, *feet, *com, 0.7))]))
    path = folder / "standing_stats.csv"
    path.write_text("\n".join(lines) + "\n")
    return [path]


def filled(text: str) -> str:
    """The recipe with the mass and the places of the cells."""
    text = re.sub(r"(?m)^# mass_kg =.*$", f"mass_kg = {WEIGHT_N / 9.80665:.4f}", text)
    text = text.replace("# [robot.feet", "[robot.feet")
    at = iter([*CELLS, *CELLS])

    def placed(found: re.Match[str]) -> str:
        x, y = next(at)
        return f"{found[1]} = {{ x_m = {x}, y_m = {y} }}"

    return re.sub(r"(?m)^# (\S+) = \{ x_m = , y_m =  \}$", placed, text)


WRITERS = pytest.mark.parametrize(
    ("write", "where"),
    [
        (files, ""),
        (one_file, 'stance_id = "0"'),
        (rows_of_means, 'stance = ["air_start", "air_end"]'),
    ],
    ids=["files", "one file", "rows of means"],
)


@WRITERS
def test_the_hanging_robot_gives_the_zeros(
    run: Run, write: object, where: str, tmp_path: Path
) -> None:
    recipe, out = tmp_path / "my.toml", tmp_path / "out"
    answer = run("init", *write(tmp_path), "-o", recipe)  # type: ignore[operator]
    assert answer.exit_code == 0, answer.err
    assert "left out" not in answer.out
    text = recipe.read_text(encoding="utf-8")
    assert "zeros = [" in text
    assert ("zeros_where" in text) is bool(where)
    assert where in text
    recipe.write_text(filled(text), encoding="utf-8")
    answer = run("static-init", "--recipe", recipe, "--out", out)
    assert answer.exit_code == 0, answer.err + answer.out
    assert f"{STANCES} stances show" in answer.out
    assert "the motion is left out" not in answer.out
    record = read_record(ParametersRecord, out / "parameters.json")
    zeros = [-p.value for name, p in record.parameters.items() if name.endswith(".bias")]
    np.testing.assert_allclose(zeros, ZERO_N, atol=1.5)


def test_ten_rows_of_stances_are_refused_as_no_quiet_standing(run: Run, tmp_path: Path) -> None:
    """In none of them the CoP stood still enough to compare cells by it, which was a crash."""
    recipe = tmp_path / "my.toml"
    (path,) = rows_of_means(tmp_path)
    assert run("init", path, "-o", recipe).exit_code == 0
    text = re.sub(r"(?m)^(row_lasts|zeros).*\n", "", recipe.read_text(encoding="utf-8"))
    recipe.write_text(filled(text), encoding="utf-8")
    header, _, *stands = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join([header, *stands[:10]]) + "\n", encoding="utf-8")
    answer = run("static-init", "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 3
    assert "no quiet standing" in answer.err


TURKISH = ("TOPUK", "IC", "DIS")


def turkish_rows(folder: Path) -> list[Path]:
    """A row of means for each stance, in Turkish; nothing is posed while the robot hangs."""
    rng = np.random.default_rng(3)
    head = [
        "No",
        "Durus",
        *(f"{s}-{n} [N]" for s in "LR" for n in TURKISH),
        *(f"{s}-{n} std" for s in "LR" for n in TURKISH),
        *(f"KM_{a} [mm]" for a in "xyz"),
    ]
    for side in ("Sol", "Sag"):
        head += [f"{side}_{a} [mm]" for a in "xyz"]
        head += [f"{side}_{a} [der]" for a in ("yalpa", "yunuslama", "sapma")]
    lines = ["Deney:\tSakin durus", "", "\t".join(head)]
    hung = (np.zeros((2, 2)), np.zeros(2), np.zeros(6))
    for number, (soles, com, force) in enumerate([hung, *stances(rng), hung]):
        row = [*(force + ZERO_N + rng.normal(0, 0.05, 6)), *rng.uniform(0.3, 0.6, 6)]
        said = [f"{v:.2f}" for v in row]
        if number in (0, STANCES + 1):
            said += [""] * 15
        else:
            said += [f"{1e3 * v:.1f}" for v in (*com, 0.7)]
            for sole in soles:
                said += [f"{1e3 * v:.1f}" for v in (*sole, 0.0)]
                said += [f"{v:.2f}" for v in rng.normal(0, 0.05, 3)]
        name = "Askida" if number in (0, STANCES + 1) else f"durus {number}"
        lines.append("\t".join([str(number), name, *said]).replace(".", ","))
    path = folder / "durus.txt"
    path.write_text("\n".join(lines) + "\n")
    return [path]


def test_a_sheet_of_stances_in_another_language(run: Run, tmp_path: Path) -> None:
    recipe, notes = tmp_path / "r.toml", tmp_path / "notes.md"
    places = [f"| {s}-{n} | {1e3 * x:g} | {1e3 * y:g} |"
              for s in "LR" for n, (x, y) in zip(TURKISH, CELLS, strict=True)]  # fmt: skip
    notes.write_text("\n".join([
        f"Robotun kutlesi: {WEIGHT_N / 9.8018:.2f} kg. g = 9,8018 m/s2.", "", "Hucreler (mm):", "",
        "| hucre | x | y |", "|---|---|---|", *places,
    ]) + "\n")  # fmt: skip
    done = run("init", *turkish_rows(tmp_path), notes, "-o", recipe)
    assert done.exit_code == 0, done.err
    made = tomllib.loads(recipe.read_text())
    columns = made["columns"]
    assert columns["com_z_m"] == {"column": "KM_z [mm]", "unit": "mm"}
    assert columns["left_foot_yaw_rad"] == {"column": "Sol_sapma [der]", "unit": "deg"}
    assert columns["right_foot_roll_rad"] == {"column": "Sag_yalpa [der]", "unit": "deg"}
    assert sum(name.endswith("_counts") for name in columns) == 6
    assert made["files"][0]["zeros_where"] == {"Durus": "Askida"}
    assert {*made["robot"]["feet"]} == {"left", "right"}
    out = tmp_path / "out"
    done = run("static-init", "--recipe", recipe, "--out", out, "--no-pictures")
    assert done.exit_code == 0, done.err
    record = read_record(ParametersRecord, out / "parameters.json")
    biases = [v.value for name, v in record.parameters.items() if name.endswith(".bias")]
    assert biases == pytest.approx([*-ZERO_N], abs=0.3)
