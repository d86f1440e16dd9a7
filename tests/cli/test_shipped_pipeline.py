"""The commands one after the other, as a user chains them with the shipped recipes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from footcal_cli.app import main
from tests.cli.few_effects import few_or_all

RECIPES = Path(__file__).resolve().parents[2] / "recipes"
BIPED, HEXAPOD = RECIPES / "nao_simulated.toml", RECIPES / "hexapod_simulated.toml"


def run(*args: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([*(str(a) for a in args), "--quiet"])
    return int(ended.value.code or 0)


def record(folder: Path, name: str) -> Any:
    return json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def biped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Simulated bench, stand and walk of the shipped recipe, and the bench's calibration."""
    out = tmp_path_factory.mktemp("biped")
    recipe = out / "recipe.toml"
    # the shipped recipe, with a shorter walk
    text = BIPED.read_text(encoding="utf-8").replace("duration_s = 60", "duration_s = 12")
    recipe.write_text(text, encoding="utf-8")
    for kind in ("weights", "stand", "walk"):
        asked = ("--recipe", recipe, "--experiment", kind, "--out", out / kind)
        assert run("simulate", *asked) == 0
    # every fifth reading tells the same, sooner
    weights = out / "weights.parquet"
    pd.read_parquet(out / "weights" / "weights.parquet").iloc[::5].to_parquet(weights)
    assert run("offline-fit", weights, "--recipe", recipe, "--out", out / "fit") == 0
    return out


def next_commands(biped: Path, out: Path, *given: object) -> None:
    for command, kind in (("static-init", "stand"), ("online-replay", "walk")):
        logs = (biped / kind / "cells.parquet", biped / kind / "body.parquet")
        asked = ("--recipe", biped / "recipe.toml", "--out", out / command, *given)
        assert run(command, *logs, *asked) == 0, command


@pytest.mark.slow
def test_stand_and_walk_run_with_the_recipe_alone(biped: Path, tmp_path: Path) -> None:
    next_commands(biped, tmp_path)


@few_or_all("hysteresis", "nonlinearity", "mass")
def test_bench_stand_walk_and_diagnosis_run_with_the_calibration_of_the_bench(
    biped: Path, tmp_path: Path, few: tuple[str, ...]
) -> None:
    given = ("--parameters", biped / "fit" / "parameters.json")
    next_commands(biped, tmp_path, *given)
    logs = (biped / "walk" / "cells.parquet", biped / "walk" / "body.parquet")
    asked = ("--recipe", biped / "recipe.toml", "--experiment", "walk", *given)
    assert run("diagnose", *logs, *asked, *few, "--out", tmp_path / "diagnose") == 0
    # the hysteresis that the bench found is still in the calibration that standing refined
    effects = [e["effect"] for e in record(tmp_path / "static-init", "parameters")["effects"]]
    assert effects == ["hysteresis"]


def _with_effect(biped: Path, out: Path, effect: str, sizes: dict[str, tuple[float, str]]) -> Path:
    """The bench's calibration with one more effect in it."""
    found = record(biped / "fit", "parameters")
    owner = "left_fl"
    for name, (value, unit) in sizes.items():
        found["parameters"][f"{owner}.{name}"] = {
            "value": value, "sd": abs(value) / 10, "unit": unit, "status": "estimated",
        }  # fmt: skip
    found["effects"].append({"effect": effect, "owners": {owner: [owner]}})
    for name, ranges in found["fitted_range"].items():
        low, high = (20.0, 24.0) if name == owner else (21.0, 23.0)
        ranges["temperature"] = {"lowest": low, "highest": high, "unit": "degC"}
    path = out / "with_effect.json"
    path.write_text(json.dumps(found), encoding="utf-8")
    return path


def test_a_temperature_effect_is_undone_where_the_log_has_its_temperature(
    biped: Path, tmp_path: Path
) -> None:
    # 0.5 N/K at 25 °C (the effect's reference) changes nothing, at 27 °C one newton
    warm = _with_effect(biped, tmp_path, "temperature_bias", {"temperature_bias": (0.5, "N/K")})
    fz = {}
    for degrees in (25.0, 27.0):
        cells = pd.read_parquet(biped / "stand" / "cells.parquet")
        cells["temperature_degc"] = degrees
        log, out = tmp_path / f"{degrees}.parquet", tmp_path / f"at_{degrees}"
        cells.to_parquet(log)
        given = ("--recipe", biped / "recipe.toml", "--parameters", warm, "--out", out)
        assert run("static-init", log, biped / "stand" / "body.parquet", *given) == 0
        rows = record(out, "rmse")["rows"]
        fz[degrees] = next(r["rmse"] for r in rows if r["quantity"] == "vgrf")
        codes = [f["code"] for f in record(out, "run")["findings"]]
        assert "temperature_assumed" not in codes
    assert abs(fz[27.0] - fz[25.0]) > 0.5


@pytest.mark.parametrize("command", ["static-init", "apply"])
def test_a_temperature_effect_without_temperature_is_a_warning_not_a_refusal(
    biped: Path, tmp_path: Path, command: str
) -> None:
    warm = _with_effect(biped, tmp_path, "temperature_bias", {"temperature_bias": (0.5, "N/K")})
    cells = pd.read_parquet(biped / "stand" / "cells.parquet")
    cells.drop(columns="temperature_degc").to_parquet(tmp_path / "cells.parquet")
    logs = [tmp_path / "cells.parquet", biped / "stand" / "body.parquet"]
    given = ("--recipe", biped / "recipe.toml", "--parameters", warm, "--out", tmp_path / "out")
    assert run(command, *logs[: 1 if command == "apply" else 2], *given) == 0
    (found,) = [
        f for f in record(tmp_path / "out", "run")["findings"] if f["code"] == "temperature_assumed"
    ]
    assert found["severity"] == "warning"
    # middle of 20 … 24 °C, at least five kelvin either way: 0.5 N/K · 5 K
    assert "22.0 ± 5.0 °C" in found["sentence"]
    assert "2.5 N" in found["sentence"]


def test_cells_that_placements_moved_are_used_where_they_are(biped: Path, tmp_path: Path) -> None:
    """A cell believed 10 mm off moves the CoP of the stand by its share of the load."""
    move = {"cell_correction_x": (0.01, "m"), "cell_correction_y": (0.0, "m")}
    moved = _with_effect(biped, tmp_path, "cell_position", move)
    before = {}
    for name, calibration in (("as_is", biped / "fit" / "parameters.json"), ("moved", moved)):
        logs = (biped / "stand" / "cells.parquet", biped / "stand" / "body.parquet")
        given = ("--recipe", biped / "recipe.toml", "--parameters", calibration)
        assert run("static-init", *logs, *given, "--out", tmp_path / name) == 0
        rows = record(tmp_path / name, "rmse")["rows"]
        before[name] = next(
            r["rmse"] for r in rows if r["quantity"] == "cop_x" and r["stage"] == "before"
        )
    # an eighth of the weight stands on the cell, give or take how the robot leans
    assert 0.0006 < before["moved"] - before["as_is"] < 0.0025


@few_or_all("cable_drag", "robot_weight")
def test_hanging_then_poses_then_apply_then_diagnosis(tmp_path: Path, few: tuple[str, ...]) -> None:
    for kind, short in (("hang", "cycles = 2"), ("pose", "cycles = 2\nposes = 24")):
        recipe = tmp_path / "recipe.toml"
        text = HEXAPOD.read_text(encoding="utf-8").replace("cycles = 3", short)
        recipe.write_text(text, encoding="utf-8")
        asked = ("--recipe", recipe, "--experiment", kind, "--out", tmp_path / kind)
        assert run("simulate", *asked) == 0
    hang, poses = tmp_path / "hang" / "hang.parquet", tmp_path / "pose" / "poses.parquet"
    out = {name: tmp_path / f"out_{name}" for name in ("hang", "pose", "apply", "diagnose")}
    recipe = tmp_path / "recipe.toml"
    assert run("hang-calib", hang, "--recipe", recipe, "--out", out["hang"]) == 0
    given = ("--recipe", recipe, "--parameters", out["hang"] / "parameters.json")
    assert run("pose-calib", poses, *given, "--out", out["pose"]) == 0
    given = ("--recipe", recipe, "--parameters", out["pose"] / "parameters.json")
    assert run("apply", poses, *given, "--out", out["apply"]) == 0
    more = ("--experiment", "pose", *few, "--out", out["diagnose"])
    assert run("diagnose", poses, *given, *more) == 0
