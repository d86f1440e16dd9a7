"""Placements of both feet, a file for each, and a bench that names foot and cell in two columns."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import Run

CELLS = {"toe": (0.095, 0.0), "heel_l": (-0.055, 0.03), "heel_r": (-0.055, -0.03)}
HOLES = {
    f"{row}{i + 1}": (x, y)
    for row, x in (("A", 0.06), ("B", 0.02), ("C", -0.02), ("D", -0.045))
    for i, y in enumerate((0.0, 0.013, -0.013))
}
SCALE, WEIGHT_N = 205.0, 8.003 * 9.80665
WORDS = {
    "romaji": ("hidari", "migi", "tsumasaki", "kakato_hidari", "kakato_migi", "ashi,sensor,kai"),
    "english": ("left", "right", "toe", "heel_inside_left", "heel_inside_right", "foot,cell,run"),
    "german": ("links", "rechts", "zehe", "ferse_links", "ferse_rechts", "Fuss,Zelle,Durchgang"),
}
EMPTY = {"romaji": "kara", "english": "none", "german": "leer"}


def shares(x: float, y: float) -> np.ndarray:
    """What each cell carries of a weight on a hole, shape (3,)."""
    table = np.array([[1.0, *at] for at in CELLS.values()]).T
    return np.asarray(np.linalg.solve(table, [1.0, x, y]))


def written(folder: Path, tongue: str) -> list[Path]:
    """Placements with an empty foot each round, zeros that the mounting moved, and the bench."""
    rng = np.random.default_rng(5)
    left, right, *cells, names = WORDS[tongue]
    load = {"romaji": "omori_kgf", "english": "load_kgf", "german": "Last_kgf"}[tongue]
    hole = {"romaji": "ten", "english": "hole", "german": "Bohrung"}[tongue]
    paths, bench = [], [f"{names},{load},out_mV"]
    for foot in (left, right):
        mounted = rng.normal(0, 0.05, 3)
        lines = ["no," + f"{hole},{load}," + ",".join(f"{c}_mV" for c in cells)]
        number = 0
        for _ in range(5):
            order = [EMPTY[tongue], *rng.permutation(sorted(HOLES))]
            for name in order:
                number += 1
                empty = name not in HOLES
                force = np.zeros(3) if empty else WEIGHT_N * shares(*HOLES[name])
                read = mounted + force / SCALE + rng.normal(0, 3e-4, 3)
                said = ",".join(f"{r:.4f}" for r in read)
                lines.append(f"{number},{name},{0 if empty else 8.003},{said}")
        path = folder / f"{foot}_placements.csv"
        path.write_text("\n".join(lines) + "\n")
        paths.append(path)
        for cell in cells:
            for run in (1, 2, 3):
                zero = rng.normal(0, 0.02)
                for kg in (0, 1, 2, 4, 8, 4, 2, 1, 0):
                    out = zero + kg * 9.80665 / SCALE + rng.normal(0, 3e-4)
                    bench.append(f"{foot},{cell},{run},{kg},{out:.4f}")
    path = folder / "single_bench.csv"
    path.write_text("\n".join(bench) + "\n")
    return [*paths, path]


def filled(text: str) -> str:
    """The recipe with the places of holes and cells."""
    lines = []
    for line in text.splitlines():
        for axis, at in (("x", 0), ("y", 1)):
            if line.startswith(f"hole_{axis}_m"):
                for name, place in HOLES.items():
                    line = line.replace(f'"{name}" = "?"', f'"{name}" = "{1e3 * place[at]:g}"')
        line = re.sub(r"^# (\[robot.feet)", r"\1", line)
        if "x_m = , y_m" in line:
            x, y = CELLS[tuple(CELLS)[place_of(line)]]
            line = f"{line[2:].partition(' = ')[0]} = {{ x_m = {x}, y_m = {y} }}"
        lines.append(line)
    return "\n".join(lines) + "\n"


def place_of(line: str) -> int:
    """Which of toe and the heel's two cells a line of the recipe is of."""
    name = line[2:].partition(" = ")[0]
    if not re.search("heel|kakato|ferse", name):
        return 0
    return 1 if re.search("left|hidari|links", name) else 2


@pytest.mark.parametrize("tongue", WORDS)
def test_each_file_is_of_its_foot(run: Run, tongue: str, tmp_path: Path) -> None:
    recipe, out = tmp_path / "my.toml", tmp_path / "out"
    answer = run("init", *written(tmp_path, tongue), "-o", recipe)
    assert answer.exit_code == 0, answer.err
    text = recipe.read_text(encoding="utf-8")
    assert "[robot.feet.left.cells]" in text
    assert "[robot.feet.right.cells]" in text
    assert "followed_by" in text
    assert "placements need calibrated cells" not in text
    recipe.write_text(filled(text), encoding="utf-8")
    answer = run("offline-fit", "--recipe", recipe, "--out", out)
    assert answer.exit_code == 0, answer.err
    assert "rows without a load: the zeros of 6 cells" in answer.out.replace("\n", " ")
    rows = json.loads((out / "rmse.json").read_text())["rows"]
    after = [r["rmse"] for r in rows if r["quantity"][:4] == "cop " and r["stage"] == "after"]
    assert 0 < max(after) < 1e-3
