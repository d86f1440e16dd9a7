"""A flattened bag of a foot's cells: each row has the hole, empty while a weight is carried."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.conftest import Run

CELLS = ((0.118, 0.046), (0.118, -0.046), (-0.072, 0.04), (-0.072, -0.04))
HOLES = {
    f"H{3 * i + j + 1:02d}": (x, y)
    for i, x in enumerate((0.1, 0.05, 0.0, -0.05)) for j, y in enumerate((0.03, 0.0, -0.03))
}  # fmt: skip
SCALE, KG = 1.25e-3, 15.02


def bag(folder: Path, ends: str) -> list[Path]:
    """Two rounds over the holes at 20 Hz; the label comes after the weight, and goes before it."""
    rng = np.random.default_rng(9)
    table = np.array([[1.0, *at] for at in CELLS]).T
    zero = np.array([-2400.0, 15200, 1300, -9600])
    load, names = [np.zeros((200, 2))], [""] * 200
    for hole in (*HOLES, "", *reversed(HOLES), ""):
        if not hole:
            load, names = [*load, np.zeros((200, 2))], [*names, *[""] * 200]
            continue
        for rows, on, label in ((14, 0, ""), (16, 1, ""), (100, 1, hole), (16, 1, "")):
            load.append(np.tile([on, list(HOLES).index(hole)], (rows, 1)))
            names += [label] * rows
    on, at = np.vstack(load).T
    places = np.array(list(HOLES.values()))[at.astype(int)]
    share = np.linalg.lstsq(table, np.column_stack([np.ones(len(at)), places]).T, rcond=None)[0]
    read = zero + on[:, None] * KG * 9.80665 / SCALE * share.T + rng.normal(0, 60, (len(at), 4))
    stamps = 1_771_840_000_020_148_736 + 50_000_000 * np.arange(len(at))
    columns = {"timestamp_ns": stamps}
    columns |= {f"/left_foot/load_cell_{i}/{ends}": read[:, i].round().astype(int)
                for i in range(4)}  # fmt: skip
    log = folder / "bag_flat.parquet"
    pd.DataFrame({**columns, "/operator/hole.data": names}).to_parquet(log)
    lines = ["cell,repeat,mass_kg,raw"]
    for i in range(4):
        for repeat in (1, 2, 3):
            for kg in (0, 5, 10, 15, 10, 5, 0):
                raw = zero[i] + 900 + kg * 9.80665 / SCALE + rng.normal(0, 30)
                lines.append(f"cell_{i},{repeat},{kg},{raw:.0f}")
    bench = folder / "cell_bench.csv"
    bench.write_text("\n".join(lines) + "\n")
    return [bench, log]


def filled(text: str) -> str:
    lines, cell = [], 0
    for line in text.splitlines():
        for axis in (0, 1):
            if line.startswith(f"hole_{'xy'[axis]}_m"):
                for name, place in HOLES.items():
                    line = line.replace(f'"{name}" = "?"', f'"{name}" = "{1e3 * place[axis]:g}"')
        line = line.replace('"?"', f'"{KG}"') if line.startswith("load_n") else line
        if "[robot.feet" in line:
            line = line.removeprefix("# ")
        if "x_m = , y_m" in line:
            x, y = CELLS[cell]
            line, cell = f"{line[2:].partition(' = ')[0]} = {{ x_m = {x}, y_m = {y} }}", cell + 1
        lines.append(line)
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("ends", ["raw.data", "data"])
def test_an_empty_label_is_an_empty_plate_or_a_weight_on_its_way(
    run: Run, ends: str, tmp_path: Path
) -> None:
    recipe, out = tmp_path / "my.toml", tmp_path / "out"
    answer = run("init", *bag(tmp_path, ends), "-o", recipe)
    assert "holes, and readings that share one weight" in answer.out
    text = recipe.read_text(encoding="utf-8")
    assert '"cell_0" = "left_load_cell_0"' in text
    recipe.write_text(filled(text), encoding="utf-8")
    assert run("offline-fit", "--recipe", recipe, "--out", out, "--quiet").exit_code == 0
    rows = json.loads((out / "rmse.json").read_text())["rows"]
    after = [r["rmse"] for r in rows if r["quantity"][:4] == "cop " and r["stage"] == "after"]
    assert max(after) < 1e-3
    found = json.loads((out / "parameters.json").read_text())["parameters"]
    assert found["left_load_cell_1.bias"]["value"] == pytest.approx(-15200 * SCALE, abs=0.1)
