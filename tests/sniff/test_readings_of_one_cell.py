"""A protocol for each cell: its serial number above the table, three readings at each step."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import Run

CELLS = {"25-0417": (492.6, 0.016), "25-0418": (493.3, -0.024), "25-0421": (496.9, 0.011)}
STEPS = (0, 10, 20, 40, 60, 40, 20, 10, 0)


def protocols(folder: Path, above: str, header: str) -> list[Path]:
    """Files called after serial numbers; decimal commas, series by name, readings 10 s apart."""
    rng = np.random.default_rng(8)
    paths = []
    for cell, (scale, zero) in CELLS.items():
        lines = ["Protokol;;;;;;", f"{above};{cell};;;;;", "Datum;14.04.2026;;;;;", header]
        for series in ("R1", "R2", "R3", "V1"):
            moved = rng.normal(0, 2e-3)
            for at, kg in enumerate(STEPS, 1):
                mass = 1.0002 * kg
                read = mass * 9.80665 / scale - zero + moved + rng.normal(0, 1e-4, 3)
                said = ";".join(f"{x:.5f}" for x in read)
                row = f"{series};{at};{kg // 10};{mass:.3f};{said};21.7"
                lines.append(row.replace(".", ","))
        path = folder / f"protokol_{cell}.csv"
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        paths.append(path)
    return paths


@pytest.mark.parametrize(
    ("above", "header"),
    [
        ("Snímač v.č.", "řada;krok;počet závaží;hmotnost [kg];čtení 1 [mV/V];čtení 2 [mV/V];"
         "čtení 3 [mV/V];teplota [°C]"),
        ("Sensor Nr", "Reihe;Schritt;Anzahl;Masse [kg];Ablesung 1 [mV/V];Ablesung 2 [mV/V];"
         "Ablesung 3 [mV/V];Temperatur [°C]"),
        ("Serial", "series;step;weights;mass [kg];reading 1 [mV/V];reading 2 [mV/V];"
         "reading 3 [mV/V];temperature [°C]"),
    ],
)  # fmt: skip
def test_a_file_for_each_cell_with_readings_again(
    run: Run, above: str, header: str, tmp_path: Path
) -> None:
    recipe, out = tmp_path / "my.toml", tmp_path / "out"
    answer = run("init", *protocols(tmp_path, above, header), "-o", recipe)
    assert answer.exit_code == 0, answer.err
    text = recipe.read_text(encoding="utf-8")
    assert 'channels = ["25-0417", "25-0418", "25-0421"]' in text
    assert 'wide_into = "reading"' in text
    assert "session = " in text
    run("offline-fit", "--recipe", recipe, "--out", out, "--quiet")
    found = json.loads((out / "parameters.json").read_text())["parameters"]
    for cell, (scale, _) in CELLS.items():
        assert found[f"{cell}.scale"]["value"] == pytest.approx(scale, rel=2e-3)
