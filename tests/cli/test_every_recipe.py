"""Every shipped recipe with cells or feet: simulate, check, calibrate, diagnose, no other flags."""

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


OF_ANOTHER = "nao_walk"
"""The biped of `templates/nao_like_biped`, which every run takes; `make studies` takes both."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] if name == OF_ANOTHER else [])
        for name, kinds in ABLE.items() if kinds
    ],
)  # fmt: skip
def test_a_recipe_runs_from_simulation_to_diagnosis(name: str, tmp_path: Path) -> None:
    recipe = tmp_path / "recipe.toml"
    text = (RECIPES / f"{name}.toml").read_text("utf-8")
    recipe.write_text(text.replace("duration_s = 60", "duration_s = 24"), "utf-8")
    given, made = ("--recipe", recipe, "--out"), {}
    for kind in ("weights", "placements", "stand", "walk"):
        short = ("--duration-s", 24) if kind == "walk" else ()
        code = run("simulate", "--experiment", kind, *short, *given, tmp_path / kind)
        assert code == (0 if kind in ABLE[name] else 2), kind
        if code == 0:
            made[kind] = [
                path for path in sorted((tmp_path / kind).glob("*.parquet"))
                if not path.name.startswith("true_")
            ]  # fmt: skip
            out = tmp_path / f"check_{kind}"
            assert run("check", *made[kind], *given, out) == 0
            found = json.loads((out / "run.json").read_text("utf-8"))
            assert found["verdict"]["level"] == "good", (kind, found["verdict"]["sentence"])
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
