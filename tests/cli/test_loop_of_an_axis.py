"""A transducer at a wrist: a loop of one axis is a hysteresis, a gain of one axis is none."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.app import main

POSES, WEIGHT_N, ARM_M = 60, 17.0, (0.004, -0.002, 0.072)
NOISE = np.array([0.02, 0.02, 0.02, 0.0015, 0.0015, 0.0015])
AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
REACHES = np.array([0.04, 0.1, 0.2, 0.35, 0.5])
WEIGHTS = np.array([0.8, 1.2, 1.4, 1.0, 0.6])
RECIPE = """
[robot.legs.sensor]
rotation_rpy_rad = [0, 0, 0]
[columns]
time_s = "t"
body_qx = "qx"
body_qy = "qy"
body_qz = "qz"
body_qw = "qw"
leg = { value = "sensor" }
[data]
hang = ["wrist.csv"]
[diagnose]
experiment = "hang"
"""


def run_once(*arguments: str | Path) -> None:
    with pytest.raises(SystemExit) as end:
        main([str(a) for a in arguments] + ["--quiet", "--no-pictures"])
    assert end.value.code == 0


def loop_of(load: np.ndarray, share: float) -> np.ndarray:
    """Prandtl and Ishlinskii: what five plays add, each from rest."""
    reach, z = REACHES * np.abs(load).max(), np.zeros(REACHES.size)
    out = []
    for x in load:
        z = np.clip(z, x - reach, x + reach)
        out.append(share * float(WEIGHTS @ (z - x)) / WEIGHTS.sum())
    return np.array(out)


def diagnosed(folder: Path, axis: str, fault: str, seed: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    steps = Rotation.from_rotvec(rng.normal(0.0, 0.55, (POSES, 3)))
    turned = [Rotation.random(random_state=seed)]
    for step in steps[1:]:
        turned.append(turned[-1] * step)
    attitude = Rotation.concatenate(turned)
    force = attitude.inv().apply([0.0, 0.0, -WEIGHT_N])
    wrench = np.hstack([force, np.cross(ARM_M, force)])
    c = AXES.index(axis)
    load = wrench[:, c].copy()
    wrench[:, c] += loop_of(load, 0.11) if fault == "loop" else 0.03 * load
    wrench += [0.8, -1.2, 2.0, 0.03, 0.01, -0.02] + NOISE * rng.standard_normal(wrench.shape)
    table = pd.DataFrame(wrench, columns=[a + ("_n" if a[0] == "f" else "_nm") for a in AXES])
    table[["qx", "qy", "qz", "qw"]] = attitude.as_quat()
    table["t"] = 6.0 * np.arange(POSES)
    table.to_csv(folder / "wrist.csv", index=False)
    recipe = folder / "recipe.toml"
    recipe.write_text(RECIPE, encoding="utf-8")
    fit, out = folder / "fit", folder / "diagnosis"
    run_once("hang-calib", "--recipe", recipe, "--out", fit)
    run_once("diagnose", "--recipe", recipe, "--parameters", fit / "parameters.json", "--out", out)
    record: dict[str, Any] = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    return record


@pytest.mark.parametrize(("axis", "unit"), [("fy", "N"), ("ty", "Nm")])
def test_a_loop_of_an_axis_is_named_with_its_axis(tmp_path: Path, axis: str, unit: str) -> None:
    found = diagnosed(tmp_path, axis, "loop", 3)
    (cause,) = found["causes"]
    assert cause["effect"] == "hysteresis"
    assert cause["where"] == f"sensor.{axis}"
    assert cause["unit"] == unit


@pytest.mark.parametrize("axis", ["fy", "ty"])
def test_a_gain_of_an_axis_is_no_loop(tmp_path: Path, axis: str) -> None:
    found = diagnosed(tmp_path, axis, "gain", 3)
    assert not [c for c in found["causes"] if "hysteresis" in (c["effect"], *c["rivals"])]
    assert found["verdict"] != "none"
