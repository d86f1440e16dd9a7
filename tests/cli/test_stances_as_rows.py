"""Stances that were noted as a row each: static-init, then diagnose with what it wrote."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from tests.cli.few_effects import few_or_all
from tests.conftest import Run

CELLS = {"heel": (-0.07, 0.0), "inner": (0.11, -0.03), "outer": (0.10, 0.034)}
FEET_Y, STANCES, MASS_KG, GRAVITY = {"left": 0.1, "right": -0.1}, 14, 60.0, 9.81
SCALE = 0.058
NAMES = tuple(f"{foot}_{cell}" for foot in FEET_Y for cell in CELLS)


def stances(seed: int, gain: float, com_off_m: tuple[float, float] = (0.0, 0.0)) -> pd.DataFrame:
    """Means of fourteen stances; the left inner cell shows `gain` of its load."""
    rng = np.random.default_rng([seed, 11])
    place = np.array(list(CELLS.values()))
    rows = []
    for _ in range(STANCES):
        com = np.array([rng.uniform(-0.02, 0.06), rng.uniform(-0.06, 0.06)])
        left = np.clip(0.5 + com[1] / 0.2, 0.1, 0.9)
        row = {"com_x_m": com[0] - com_off_m[0], "com_y_m": com[1] - com_off_m[1], "com_z_m": 0.71}
        for (foot, y), part in zip(FEET_Y.items(), (left, 1.0 - left), strict=True):
            weight = MASS_KG * GRAVITY * part
            across = com[1] - (left * FEET_Y["left"] + (1.0 - left) * FEET_Y["right"])
            want = weight * np.array([1.0, com[0], across])
            force = np.linalg.solve(np.vstack([np.ones(3), place.T]), want)
            shown = force * (1.0 + 0.001 * rng.standard_normal(3)) + 0.3 * rng.standard_normal(3)
            shown[1] *= gain if foot == "left" else 1.0
            row |= {f"{foot}_{cell}": s / SCALE for cell, s in zip(CELLS, shown, strict=True)}
            row |= {f"{foot}_foot_x_m": 0.0, f"{foot}_foot_y_m": y, f"{foot}_foot_z_m": 0.0}
            row |= {f"{foot}_foot_{angle}_rad": 0.0 for angle in ("roll", "pitch", "yaw")}
        rows.append(row)
    return pd.DataFrame(rows)


def bench(seed: int) -> pd.DataFrame:
    rng = np.random.default_rng([seed, 12])
    load = np.tile([0.0, 50.0, 100.0, 150.0, 200.0, 250.0], 4)
    session = np.repeat(np.arange(4), 6)
    return pd.concat([
        pd.DataFrame({"channel": name, "load_n": load, "session": session,
                      "counts": (load + 0.1 * rng.standard_normal(load.size)) / SCALE})
        for name in NAMES
    ])  # fmt: skip


def recipe() -> str:
    cells = "\n".join(f"{name} = {{ x_m = {x}, y_m = {y} }}" for name, (x, y) in CELLS.items())
    feet = "\n".join(f"[robot.feet.{foot}.cells]\n{cells}" for foot in FEET_Y)
    columns = "\n".join(f'{name}_counts = "{name}"' for name in NAMES)
    return (
        f'[robot]\nname = "walker"\nmass_kg = {MASS_KG}\ngravity_mps2 = {GRAVITY}\n{feet}\n'
        '[data]\ncells = ["stand.csv"]\nweights = ["bench.csv"]\n'
        '[[files]]\nmatch = "stand.csv"\nrow_lasts = 200\nrate_hz = 20\n'
        f"[files.columns]\n{columns}\n"
    )


@pytest.fixture
def calibrated(run: Run, tmp_path: Path) -> Path:
    bench(1).to_csv(tmp_path / "bench.csv", index=False)
    (tmp_path / "r.toml").write_text(recipe(), encoding="utf-8")
    done = run("offline-fit", tmp_path / "bench.csv", "--recipe", tmp_path / "r.toml",
               "--no-pictures", "--out", tmp_path / "cells")  # fmt: skip
    assert done.exit_code == 0, done.err
    return tmp_path


def diagnosed(run: Run, folder: Path, calibration: str, *more: str) -> DiagnosisRecord:
    out = folder / f"of_{calibration}"
    given = folder / calibration / "parameters.json"
    done = run("diagnose", "--experiment", "stand", "--recipe", folder / "r.toml", "--no-pictures",
               "--parameters", given, "--out", out, *more)  # fmt: skip
    assert done.exit_code == 0, done.err
    return read_record(DiagnosisRecord, out / "diagnosis.json")


FEW = few_or_all("scale_change", "crosstalk", "com_offset", "mass", "load_bypass")


@FEW
@pytest.mark.parametrize(
    ("gain", "off_m", "hidden"),
    [(0.87, (0.0, 0.0), "scale_change"), (1.0, (0.007, -0.006), "com_offset"), (1.0, (0, 0), "")],
)
def test_what_stances_noted_as_rows_show(
    run: Run, calibrated: Path, few: tuple[str, ...], gain: float, off_m: tuple[float, float],
    hidden: str,
) -> None:  # fmt: skip
    stances(2, gain, off_m).to_csv(calibrated / "stand.csv", index=False)
    record = diagnosed(run, calibrated, "cells", *few)
    answered = {c.effect for c in record.causes} | {name for own in record.rivals for name in own}
    assert (hidden in answered) if hidden else not answered, record.sentence


def test_what_static_init_made_of_these_very_stances_is_no_baseline(
    run: Run, calibrated: Path
) -> None:
    """Its calibration has taken up a part of the fault; the answer is that of the bench's."""
    stances(2, 0.87).to_csv(calibrated / "stand.csv", index=False)
    done = run("static-init", "--recipe", calibrated / "r.toml", "--no-pictures", "--parameters",
               calibrated / "cells/parameters.json", "--out", calibrated / "stand")  # fmt: skip
    assert done.exit_code == 0, done.err
    (few,) = (mark.args[1][0] for mark in [FEW.mark])
    first, again = (diagnosed(run, calibrated, name, *few) for name in ("cells", "stand"))
    assert again.sentence == first.sentence
    found = json.loads((calibrated / "of_stand/run.json").read_text(encoding="utf-8"))["findings"]
    assert any("calibrated_by_itself" in str(f) for f in found)
