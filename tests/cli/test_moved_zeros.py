"""Benches on which only the zero moves from repeat to repeat: that is said, and no misfit."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import Run

SCALE = 432.0
LADDER = (0, 2, 5, 10, 20, 10, 5, 2, 0)
RECIPE = """name = "bench"
[robot]
channels = ["a", "b"]
[columns]
channel = "cell"
repeat = "rep"
load_n = { column = "mass_kg", unit = "kg" }
counts = { column = "mV", unit = "mV" }
[data]
weights = "bench.csv"
"""


def bench(folder: Path, moves_mv: float, bend: float = 0.0) -> Path:
    """Three ladders on each of two cells; the zero of each is its own, the readings bend a bit."""
    rng = np.random.default_rng(3)
    lines = ["cell,rep,mass_kg,mV"]
    for cell in "ab":
        for rep, moved in enumerate((-1.0, 0.4, 0.8), 1):
            for kg in LADDER:
                force = 9.80665 * kg
                mv = force / SCALE + moves_mv * moved + bend * (force / 196.0) ** 2
                lines.append(f"{cell},{rep},{kg},{mv + rng.normal(0, 2e-4):.5f}")
    (folder / "bench.csv").write_text("\n".join(lines) + "\n")
    (folder / "r.toml").write_text(RECIPE)
    return folder / "r.toml"


def verdict(run: Run, recipe: Path) -> str:
    out = recipe.parent / "out"
    run("offline-fit", "--recipe", recipe, "--out", out, "--quiet", "--overwrite")
    return str(json.loads((out / "run.json").read_text())["verdict"]["sentence"])


def test_only_the_zero_moves(run: Run, tmp_path: Path) -> None:
    recipe = bench(tmp_path, 0.02)
    said = verdict(run, recipe)
    assert said.startswith("Scales hold, but the zero of both channels moves from session to sess")
    answer = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "two")
    assert "zeros of its 3 sessions" in answer.out
    assert "tared" not in answer.out
    found = json.loads((tmp_path / "two/parameters.json").read_text())["parameters"]
    assert found["a.scale"]["value"] == pytest.approx(SCALE, rel=2e-3)


def test_zeros_that_hold_are_not_said_to_move(run: Run, tmp_path: Path) -> None:
    assert verdict(run, bench(tmp_path, 0.0)).startswith("A scale and a bias describe")


def test_a_curve_is_no_moved_zero(run: Run, tmp_path: Path) -> None:
    assert "zero" not in verdict(run, bench(tmp_path, 0.0, bend=0.05))
