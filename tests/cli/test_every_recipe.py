"""Every shipped recipe with cells or feet: simulate, check, calibrate, diagnose, no other flags.

Each is simulated and checked in every test run, one of each kind of robot is calibrated and
diagnosed; `make studies` does so with all of them.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from footcal_cli.app import main

RECIPES = Path(__file__).resolve().parents[2] / "recipes"
BENCH, FEET, WHOLE = ("weights",), ("weights", "placements"), ("weights", "placements", "stand")
ABLE = {
    "bench_foot": FEET,
    "forceplate_cop_points": (),
    "hexapod": (),
    "hexapod_simulated": (),
    "icub_four_ft": (),
    "insole_plenum": BENCH,
    "loadcell_creep": BENCH,
    "loadsol_insoles": (*WHOLE, "walk"),
    "nao_simulated": (*WHOLE, "walk"),
    "nao_table2": BENCH,
    "nao_walk": (*WHOLE, "walk"),
    "reemc_walking": ("stand", "walk"),
    "templates/force_plate": (),
    "templates/humanoid_ankle_transducers": ("stand", "walk"),
    "templates/kitchen_scale_hx711": BENCH,
    "templates/nao_like_biped": (*WHOLE, "walk"),
    "templates/quadruped_foot_sensors": BENCH,
    "templates/wrist_sensor_tool": (),
}
"""What a robot of each recipe can do on its feet; the rest is refused with what it can."""


def run(*args: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([*(str(a) for a in args), "--quiet", "--no-pictures"])
    return int(ended.value.code or 0)


def test_every_shipped_recipe_is_listed() -> None:
    shipped = {str(p.relative_to(RECIPES).with_suffix("")) for p in RECIPES.rglob("*.toml")}
    assert shipped == set(ABLE)


WHOLE_WAY = {
    "bench_foot": "feet on a bench",
    "insole_plenum": "cells of an insole on a bench",
    "templates/kitchen_scale_hx711": "one cell",
    "loadsol_insoles": "a biped on cells: bench, stand, walk",
    "templates/humanoid_ankle_transducers": "a biped on transducers: stand, walk",
}
"""What every test run calibrates and diagnoses, each the quickest of its kind."""
ANY = [name for name, kinds in ABLE.items() if kinds]


def recipe_in(folder: Path, name: str) -> Path:
    recipe = folder / "recipe.toml"
    text = (RECIPES / f"{name}.toml").read_text("utf-8")
    recipe.write_text(text.replace("duration_s = 60", "duration_s = 24"), "utf-8")
    return recipe


def checked(name: str, recipe: Path) -> dict[str, list[Path]]:
    """The logs of every experiment that the robot can do, simulated; `check` calls them good."""
    folder, given, made = recipe.parent, ("--recipe", recipe, "--out"), {}
    for kind in ("weights", "placements", "stand", "walk"):
        short = ("--duration-s", 24) if kind == "walk" else ()
        code = run("simulate", "--experiment", kind, *short, *given, folder / kind)
        assert code == (0 if kind in ABLE[name] else 2), kind
        if code == 0:
            made[kind] = [
                path for path in sorted((folder / kind).glob("*.parquet"))
                if not path.name.startswith("true_")
            ]  # fmt: skip
            out = folder / f"check_{kind}"
            assert run("check", *made[kind], *given, out) == 0
            found = json.loads((out / "run.json").read_text("utf-8"))
            assert found["verdict"]["level"] == "good", (kind, found["verdict"]["sentence"])
    return made


@pytest.mark.parametrize("name", [name for name in ANY if name not in WHOLE_WAY])
def test_a_recipe_is_simulated_and_checked(name: str, tmp_path: Path) -> None:
    assert set(checked(name, recipe_in(tmp_path, name))) == set(ABLE[name])


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[] if name in WHOLE_WAY else [pytest.mark.slow]) for name in ANY],
)
def test_a_recipe_runs_from_simulation_to_diagnosis(name: str, tmp_path: Path) -> None:
    recipe = recipe_in(tmp_path, name)
    given, made = ("--recipe", recipe, "--out"), checked(name, recipe)
    if "weights" in made:
        bench = [*made["weights"], *made.get("placements", [])]
        assert run("offline-fit", *bench, *given, tmp_path / "fit") == 0
    if "stand" in made:
        assert run("static-init", *made["stand"], *given, tmp_path / "init") == 0
    if "walk" in made:
        assert run("online-replay", *made["walk"], *given, tmp_path / "replay") == 0
        calibration = tmp_path / "replay" / "parameters.json"
        asked = ("--experiment", "walk", "--parameters", calibration)
        assert run("diagnose", *made["walk"], *asked, *given, tmp_path / "diagnosis") == 0
    else:
        asked = ("--experiment", "weights", "--parameters", tmp_path / "fit" / "parameters.json")
        assert run("diagnose", *made["weights"], *asked, *given, tmp_path / "diagnosis") == 0
