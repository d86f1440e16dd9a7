"""Placements as labs write them: a row for each cell, an empty plate, a list of raw files."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from footcal_cli.core.parameters import FloatArray
from tests.conftest import Run

G, KG, SCALE = 9.811, 20.0, 24.0
CELLS = {"C1": (110, 38), "C2": (112, -40), "C3": (-60, 36), "C4": (-58, -37)}
HOLES = {"A1": (-50, 20), "A2": (-50, -20), "B1": (0, 25), "B2": (0, -25), "D1": (80, 20),
         "D2": (80, -20)}  # fmt: skip
NOTES = """# Stopa

Uklad: x do przodu, y w lewo, mm. g = 9,811 m/s2.

| czujnik | x_mm | y_mm |
|---|---|---|
{cells}

`plyta.csv` - zmontowana plyta, odwaznik 20 kg (z kula) w otworze, U_mV = srednia 5 s.
"""


def share(hole: tuple[float, float]) -> FloatArray:
    """What each of four cells carries of a weight on a hole of a rigid plate, shape (4,)."""
    at = np.array([*CELLS.values()], dtype=float)
    table = np.vstack([np.ones(4), at.T])
    return np.asarray(np.linalg.lstsq(table, np.array([1.0, *hole]), rcond=None)[0])


def visits(series: int) -> list[tuple[str, tuple[float, float] | None]]:
    """Holes in an order of their own, the empty plate before and after them."""
    order = np.random.default_rng(series).permutation(list(HOLES)).tolist()
    return [("0", None), *((name, HOLES[name]) for name in order), ("0", None)]


def readings(
    hole: tuple[float, float] | None, rng: np.random.Generator, series: int = 0, jump: float = 0.0
) -> FloatArray:
    """mV of four cells, shape (4,); zeros jump from series to series, by nothing on average."""
    force = 0.0 if hole is None else KG * G * share(hole)
    zero = np.array([0.3, -0.1, 0.2, 0.05]) + jump * (series - 2) * np.array([1, -1, 0.5, -2])
    return np.asarray(force / SCALE + zero + rng.normal(0, 2e-3, 4))


def notes(folder: Path) -> Path:
    """Notes with the cells' places, and lines that hold no letter before a number."""
    rows = "\n".join(f"| {name} | {x} | {y} |" for name, (x, y) in CELLS.items())
    path = folder / "notes.md"
    path.write_text(NOTES.format(cells=rows), encoding="utf-8")
    return path


def bench(folder: Path) -> Path:
    """Each cell alone, up and down, with words of the lab."""
    rng = np.random.default_rng(9)
    lines = ["czujnik;kierunek;masa_kg;U_mV"]
    for name in CELLS:
        for word, loads in (("gora", (0, 4, 8, 12)), ("dol", (8, 4, 0))):
            lines += [f"{name};{word};{kg};{kg * G / SCALE + rng.normal(0, 1e-3):.4f}"
                      for kg in loads]  # fmt: skip
    path = folder / "bench.csv"
    path.write_text("\n".join(lines).replace(".", ",") + "\n", encoding="utf-8")
    return path


def a_row_for_each_cell(folder: Path, jump: float = 0.0) -> list[Path]:
    """A long sheet: cells take turns."""
    rng = np.random.default_rng(7)
    lines = ["seria;nr;otwor;x_mm;y_mm;masa_kg;czujnik;U_mV"]
    for series in (1, 2, 3):
        for number, (name, hole) in enumerate(visits(series), 1):
            where = f"{hole[0]};{hole[1]}" if hole else ";"
            put = KG if hole else 0.0
            for cell, mv in zip(CELLS, readings(hole, rng, series, jump), strict=True):
                lines.append(f"{series};{number};{name};{where};{put:.1f};{cell};{mv:.4f}")
    path = folder / "plyta.csv"
    path.write_text("\n".join(lines).replace(".", ",") + "\n", encoding="utf-8")
    return [path]


def an_empty_plate_between(folder: Path) -> list[Path]:
    """A row for each placement; NaN where nothing lay, and a remark there alone."""
    rng = np.random.default_rng(7)
    lines = ["Trial,Hole,HoleX_mm,HoleY_mm,Mass_kg,C1_mV,C2_mV,C3_mV,C4_mV,Comment"]
    number = 0
    for series in (1, 2, 3):
        for name, hole in visits(series):
            number += 1
            where = f"{hole[0]},{hole[1]},{KG}," if hole else "NaN,NaN,0,"
            read = ",".join(f"{mv:.4f}" for mv in readings(hole, rng))
            lines.append(f"{number},{name},{where}{read},{'' if hole else 'empty plate'}")
    path = folder / "plate.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return [path]


def a_list_of_raw_files(folder: Path, jump: float = 0.0) -> list[Path]:
    """A raw file for each placement, and a list that says what each is of."""
    rng = np.random.default_rng(7)
    listed, paths = ["file,kai,ana,x_mm,y_mm,omori_kg,biko"], list[Path]()
    for series in (1, 2, 3):
        for name, hole in visits(series):
            path = folder / f"m{len(paths) + 1:03d}.csv"
            where = f"{hole[0]},{hole[1]},{KG}" if hole else ",,0"
            listed.append(f"{path.name},{series},{'nashi' if hole is None else name},{where},")
            read = readings(hole, rng, series, jump) + rng.normal(0, 1e-3, (30, 4))
            rows = [f"{0.01 * i:.4f}," + ",".join(f"{v:.4f}" for v in row)
                    for i, row in enumerate(read)]  # fmt: skip
            head = "t_s," + ",".join(f"{cell}_mV" for cell in CELLS)
            path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
            paths.append(path)
    index = folder / "list.csv"
    index.write_text("\n".join(listed) + "\n", encoding="utf-8")
    return [*paths, index]


@pytest.mark.parametrize(
    "layout", [a_row_for_each_cell, an_empty_plate_between, a_list_of_raw_files]
)
def test_placements_with_an_empty_plate(run: Run, layout: Any, tmp_path: Path) -> None:
    recipe, out = tmp_path / "my.toml", tmp_path / "out"
    answer = run("init", *layout(tmp_path), bench(tmp_path), notes(tmp_path), "-o", recipe)
    assert answer.exit_code == 0, answer.err
    made = tomllib.loads(recipe.read_text(encoding="utf-8"))
    assert "TO FILL IN" not in answer.out
    assert "left out" not in answer.out
    assert made["robot"]["gravity_mps2"] == G
    (foot,) = made["robot"]["feet"].values()
    places = [[1e3 * at["x_m"], 1e3 * at["y_m"]] for at in foot["cells"].values()]
    assert places == pytest.approx(np.array([*CELLS.values()]))
    done = run("offline-fit", "--recipe", recipe, "--out", out, "--quiet")
    assert done.exit_code == 0, done.err
    found = json.loads((out / "parameters.json").read_text())["parameters"]
    scales = [own["value"] for name, own in found.items() if name.endswith(".scale")]
    assert scales == pytest.approx([SCALE] * 4, rel=3e-3)
    biases = [own["value"] for name, own in found.items() if name.endswith(".bias")]
    assert biases == pytest.approx([-SCALE * z for z in (0.3, -0.1, 0.2, 0.05)], abs=0.1)


@pytest.mark.parametrize("layout", [a_row_for_each_cell, a_list_of_raw_files])
@pytest.mark.parametrize("jump", [0.0, 0.05])
def test_each_series_of_a_plate_has_its_own_zeros(
    run: Run, layout: Any, jump: float, tmp_path: Path
) -> None:
    """A plate that was taken off between series moves zeros by 1 to 2 N; the CoP stays right."""
    recipe, out = tmp_path / "my.toml", tmp_path / "out"
    files = [*layout(tmp_path, jump), bench(tmp_path), notes(tmp_path)]
    assert run("init", *files, "-o", recipe).exit_code == 0
    done = run("offline-fit", "--recipe", recipe, "--out", out, "--no-pictures")
    assert done.exit_code == 0, done.err
    assert ("each has its own zeros" in done.out) == (jump > 0)
    found = re.search(r"(\d\.\d+) ± \d\.\d+ mm", done.out)
    assert found is not None
    assert float(found[1]) < 0.15
