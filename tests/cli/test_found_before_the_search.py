"""What checks find before any effect is looked for is the answer of ``diagnose``, not a remark."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd

from tests.conftest import Run
from tests.core.test_odd_gain import CELLS_M, rows

RECIPE = """name = "plate"
[robot]
[robot.nameplate]
scale_n_per_count = 1.0
scale_relative_sd = 0.002
[robot.feet.left.cells]
{cells}
[data]
placements = "holes.csv"
[diagnose]
experiment = "placements"
"""


def test_a_gain_that_the_calibration_has_taken_is_said(tmp_path: Path, run: Run) -> None:
    placed = rows(11, np.array([1.001, 0.998, 1.044, 1.0]))
    names = [f"f{k}" for k in range(1, 5)]
    table = pd.DataFrame(placed.forces_n, columns=[f"{n}_counts" for n in names])
    table["hole_x_m"], table["hole_y_m"] = placed.hole_m.T
    table["load_n"], table["foot"] = placed.load_n, "left"
    table["placement"] = [f"h{k}" for k in placed.placement]
    table["repeat"] = np.repeat([1, 2, 3], 35)
    empty = {"foot": "left", "placement": "empty", "load_n": 0.0, "repeat": 1}
    table = pd.concat([pd.DataFrame([{**empty, **{f"{n}_counts": 0.0 for n in names}}]), table])
    table.to_csv(tmp_path / "holes.csv", index=False)
    cells = "\n".join(f"{n} = {{ x_m = {x}, y_m = {y} }}"
                      for n, (x, y) in zip(names, CELLS_M, strict=True))  # fmt: skip
    (tmp_path / "r.toml").write_text(RECIPE.format(cells=cells))
    fitted = run("offline-fit", "--recipe", tmp_path / "r.toml", "--out", tmp_path / "fit")
    assert fitted.exit_code == 0, fitted.err
    assert "left_f3: it reads 4." in fitted.out, fitted.out
    done = run(
        "diagnose", "--recipe", tmp_path / "r.toml", "--parameters",
        tmp_path / "fit" / "parameters.json", "--out", tmp_path / "said", "--no-pictures",
    )  # fmt: skip
    assert done.exit_code == 0, done.err
    record = json.loads((tmp_path / "said" / "diagnosis.json").read_text())
    assert record["sentence"].startswith("Found before the search: left_f3: it reads 4.")
    assert [f["code"] for f in record["findings"]].count("cell_gain") == 1


def test_a_weight_at_no_hole_is_refused(tmp_path: Path, run: Run) -> None:
    cells = "\n".join(
        f"f{k} = {{ x_m = {0.1 * (k % 2)}, y_m = {0.1 * (k // 2)} }}" for k in range(4)
    )
    (tmp_path / "r.toml").write_text(RECIPE.format(cells=cells))
    (tmp_path / "holes.csv").write_text(
        "foot,placement,hole_x_m,hole_y_m,load_n,f0_counts,f1_counts,f2_counts,f3_counts\n"
        "left,empty,,,0,0,0,0,0\nleft,a,0.01,0.02,50,12,13,12,13\nleft,b,,0.02,50,12,13,12,13\n"
    )
    done = run("offline-fit", "--recipe", tmp_path / "r.toml", "--out", tmp_path / "fit")
    assert done.exit_code == 3
    assert "hole_x_m" in done.err
    assert "where a weight lies" in done.err
