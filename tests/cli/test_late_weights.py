"""Weights whose number was typed some seconds before they lay there, in a file for each cell."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import Run

SCALE = -2.33e-5
LOADS = (0, 500, 1000, 2000, 3000, 5000, 4000, 2000, 0)
STAYS_S = 30.0
ZEROS = {"1": 82000.0, "2": -31000.0, "3": 13500.0}


def streams(folder: Path, late_s: tuple[float, float], word: str) -> list[Path]:
    """A raw stream per cell at 10 Hz with the total weight that was typed."""
    rng = np.random.default_rng(6)
    paths = []
    for cell, zero in ZEROS.items():
        stamps = np.arange(0.0, STAYS_S * len(LOADS), 0.1)
        typed = np.array(LOADS)[(stamps / STAYS_S).astype(int)]
        came = STAYS_S * np.arange(len(LOADS)) + rng.uniform(*late_s, len(LOADS))
        came[0] = 0.0
        lying = np.array(LOADS)[np.searchsorted(came, stamps, side="right") - 1]
        read = zero + lying * 9.80665e-3 / SCALE + rng.normal(0, 500, stamps.size)
        lines = [f"# HX711 10 SPS {word} {cell}", "millis,ham,agirlik_g"]
        lines += [f"{1e3 * t:.0f},{r:.0f},{g}" for t, r, g in zip(stamps, read, typed, strict=True)]
        path = folder / f"hx711_{word}{cell}.txt"
        path.write_text("\n".join(lines) + "\n")
        paths.append(path)
    return paths


@pytest.mark.parametrize(
    "word", ["hucre", *(pytest.param(w, marks=pytest.mark.slow) for w in ("anturi", "cell"))]
)
def test_weights_that_come_late_are_read_where_they_lie(
    run: Run, word: str, tmp_path: Path
) -> None:
    recipe, out = tmp_path / "r.toml", tmp_path / "out"
    answer = run("init", *streams(tmp_path, (1.0, 4.5), word), "-o", recipe)
    assert "one file per channel" in answer.out
    assert run("offline-fit", "--recipe", recipe, "--out", out, "--quiet").exit_code == 0
    found = json.loads((out / "parameters.json").read_text())["parameters"]
    scales = [p["value"] for name, p in found.items() if name.endswith(".scale")]
    assert scales == pytest.approx([SCALE] * 3, rel=2e-3)
    rows = json.loads((out / "rmse.json").read_text())["rows"]
    assert max(r["rmse"] for r in rows) < 0.1


def test_weights_that_come_too_late_are_said(run: Run, tmp_path: Path) -> None:
    recipe = tmp_path / "r.toml"
    run("init", *streams(tmp_path, (9.0, 10.0), "cell"), "-o", recipe)
    answer = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out")
    assert "plateaus.settle_s = " in answer.out
    with recipe.open("a") as file:
        file.write("\n[offline_fit]\nplateaus.settle_s = 12\n")
    answer = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "again")
    assert "plateaus.settle_s" not in answer.out
    assert answer.exit_code == 0
