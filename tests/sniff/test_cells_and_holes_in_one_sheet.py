"""One sheet places cells, by parts of their columns' names, and holes; readings are newtons."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from tests.conftest import Run

CELLS = {"K1187": (120, 50), "K1188": (120, -50), "K1194": (-80, 42), "K1201": (-80, -42)}
HOLES = {"P1": (110, 0), "P2": (90, 35), "P3": (90, -35), "P4": (40, 0), "P5": (40, 40),
         "P6": (0, -35), "P7": (-40, 0), "P8": (-60, 25)}  # fmt: skip


def written(folder: Path, *, bare: bool) -> list[Path]:
    """A protocol by hole and weight with zeros that are not tared, and the drawing's places."""
    rng = np.random.default_rng(2)
    ends = [name[1:] if bare else name for name in CELLS]
    lines = ["lfd;Durchgang;Masse_kg;Position;" + ";".join(f"F_{name}_N" for name in ends)]
    table = np.array([[1.0, *at] for at in CELLS.values()]).T
    zero, number = rng.normal(0, 1.5, 4), 0
    for run in (1, 2, 3):
        for kg in (25.0, 50.01):
            for hole in ("leer", *rng.permutation(sorted(HOLES))):
                number += 1
                load = 0.0 if hole == "leer" else kg
                share = np.linalg.lstsq(table, [1.0, *HOLES.get(hole, (0, 0))], rcond=None)[0]
                read = zero + 9.80665 * load * share + rng.normal(0, 0.05, 4)
                said = ";".join(f"{r:.2f}" for r in read)
                lines.append(f"{number};{run};{load:.2f};{hole};{said}".replace(".", ","))
    log, sheet = folder / "Protokoll.csv", folder / "Positionen.txt"
    log.write_text("\n".join(lines) + "\n")
    places = {**(CELLS if not bare else {}), **HOLES}
    rows = [f"{name}\t{x},0\t{y},0" for name, (x, y) in places.items()]
    sheet.write_text("\n".join(["Bezeichnung\tx_mm\ty_mm", *rows]) + "\n")
    return [log, sheet]


def test_one_sheet_places_cells_and_holes(run: Run, tmp_path: Path) -> None:
    recipe, out = tmp_path / "my.toml", tmp_path / "out"
    answer = run("init", *written(tmp_path, bare=False), "-o", recipe)
    assert "TO FILL IN" not in answer.out
    assert "k_1187 = { x_m = 0.12, y_m = 0.05 }" in recipe.read_text()
    assert run("offline-fit", "--recipe", recipe, "--out", out, "--quiet").exit_code == 0
    rows = json.loads((out / "rmse.json").read_text())["rows"]
    after = [r["rmse"] for r in rows if r["quantity"][:4] == "cop " and r["stage"] == "after"]
    assert max(after) < 1e-3


def test_places_of_holes_are_none_of_cells(run: Run, tmp_path: Path) -> None:
    recipe = tmp_path / "my.toml"
    answer = run("init", *written(tmp_path, bare=True), "-o", recipe)
    assert "no log says where the cells sit" in answer.out
