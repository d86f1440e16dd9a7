"""A table of means with their scatter: what stands beside a mean is no load and no reading."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import Run

SCALE = 1.2e-5
NAMES = (
    "Cell,Trial,Load_lbf,MeanCounts,StdCounts,NumSamples",
    "Cell,Trial,Load_lbf,mean_counts,sd_counts,NumSamples",
    "Cell,Trial,Load_lbf,Counts,Counts_std,NumSamples",
    "Zelle,Durchgang,Last_lbf,Anzeige,Standardabweichung,Anzahl",
)


@pytest.mark.parametrize("header", NAMES)
def test_scatter_is_no_load(run: Run, header: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    lines = [header]
    for at, cell in enumerate(("ToeMed", "ToeLat", "HeelMed")):
        for trial in (1, 2, 3):
            for load in (0, 5, 10, 25, 50, 25, 10, 5, 0):
                mean = 3e4 * (at + 1) + load * 4.4482216 / SCALE + rng.normal(0, 20)
                spread, samples = rng.uniform(200, 370), rng.integers(396, 402)
                lines.append(f"{cell},{trial},{load},{mean:.2f},{spread:.3f},{samples}")
    log = tmp_path / "cells.csv"
    log.write_text("\n".join(lines) + "\n")
    recipe, out = tmp_path / "my.toml", tmp_path / "out"
    answer = run("init", log, "-o", recipe)
    assert answer.exit_code == 0, answer.err
    assert run("offline-fit", "--recipe", recipe, "--out", out).exit_code == 0
    fitted = json.loads((out / "parameters.json").read_text())["parameters"]
    assert fitted["HeelMed.scale"]["value"] == pytest.approx(SCALE, rel=1e-3)
