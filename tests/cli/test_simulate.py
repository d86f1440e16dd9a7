"""``footcal simulate`` and ``footcal effects`` as the shell runs them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.effects import TABLE
from footcal_cli.core.simulation.biped_logs import Streams
from footcal_cli.core.simulation.gait import WalkPlan, walking
from footcal_cli.core.simulation.robots import Biped
from footcal_cli.records.files import read_record
from footcal_cli.records.results import TruthRecord
from footcal_cli.tables.columns import (
    body_table,
    cells_table,
    hang_table,
    placements_table,
    poses_table,
    weights_table,
)
from footcal_cli.tables.table import read_table
from tests.conftest import Run, drawing
from tests.core.test_simulation import walk_logs

CELLS = tuple(f"{foot}_{cell}" for foot in ("left", "right") for cell in ("fl", "fr", "rl", "rr"))
QUICK = {
    "weights": (),
    "placements": (),
    "stand": (),
    "walk": ("--duration-s", "12"),
    "hang": (),
    "pose": (),
}
TABLES = {
    "weights": {"weights": weights_table()},
    "placements": {"placements": placements_table(("fl", "fr", "rl", "rr"))},
    "stand": {"cells": cells_table(CELLS), "body": body_table(("left", "right"))},
    "walk": {"cells": cells_table(CELLS), "body": body_table(("left", "right"))},
    "hang": {"hang": hang_table()},
    "pose": {"poses": poses_table()},
}


@pytest.mark.parametrize("experiment", TABLES)
def test_logs_are_read_by_footcal_and_the_same_seed_gives_the_same_bytes(
    run: Run, tmp_path: Path, experiment: str
) -> None:
    for out, seed in (("one", "3"), ("two", "3"), ("other", "4")):
        answer = run(
            "simulate", "--experiment", experiment, *QUICK[experiment], "--seed", seed,
            "--out", tmp_path / out, "--quiet",
        )  # fmt: skip
        assert answer.exit_code == 0, answer.err
    assert read_record(TruthRecord, tmp_path / "one/truth.json").experiment == experiment
    for stem, table in TABLES[experiment].items():
        read = read_table(tmp_path / f"one/{stem}.parquet", table, {}, gravity_mps2=9.80665)
        assert len(read) > 50
        required = [column.name for column in table.columns if not column.optional]
        assert set(required) <= set(read.data.columns)
    for name in [*(f"{stem}.parquet" for stem in TABLES[experiment]), "truth.json"]:
        one, two, other = ((tmp_path / out / name).read_bytes() for out in ("one", "two", "other"))
        assert one == two, name
        assert one != other, name


def test_the_truth_explains_the_log(run: Run, tmp_path: Path) -> None:
    answer = run(
        "simulate", "--experiment", "walk", "--duration-s", "12", "--noise", "0",
        "--effect", "left_rr.bias_jump=1.5,jump_time=6", "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    assert "bias_jump (left_rr)" in answer.out
    truth = read_record(TruthRecord, tmp_path / "out/truth.json")
    cells = pd.read_parquet(tmp_path / "out/cells.parquet")
    loads = pd.read_parquet(tmp_path / "out/true_loads.parquet")
    for channel in CELLS:
        scale, bias = (truth.parameters[f"{channel}.{name}"] for name in ("scale", "bias"))
        shown = scale * cells[f"{channel}_counts"] + bias
        jump = 1.5 * ((channel == "left_rr") & (cells["time_s"] >= 6.0))
        error = shown - loads[f"{channel}_n"] - jump
        assert np.abs(error).max() < 0.51 * abs(scale), channel
    assert truth.parameters["left_rr.bias_jump"] == 1.5
    assert {e.effect: e.owners for e in truth.effects}["bias_jump"] == {"left_rr": ("left_rr",)}


def test_a_calibration_can_be_given(run: Run, tmp_path: Path, repository: Path) -> None:
    made = run(
        "offline-fit", "--recipe", repository / "recipes/nao_table2.toml",
        "--out", tmp_path / "fit", "--quiet",
    )  # fmt: skip
    assert made.exit_code in (0, 1)
    answer = run(
        "simulate", "--experiment", "stand", "--parameters", tmp_path / "fit/parameters.json",
        "--out", tmp_path / "out", "--quiet",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    fitted = json.loads((tmp_path / "fit/parameters.json").read_text())["parameters"]
    truth = read_record(TruthRecord, tmp_path / "out/truth.json")
    assert truth.parameters["left_fl.scale"] == fitted["left_fl.scale"]["value"]
    useless = run(
        "simulate", "--experiment", "hang", "--parameters", tmp_path / "fit/parameters.json",
        "--out", tmp_path / "no",
    )  # fmt: skip
    assert useless.exit_code == 2
    assert "no parameter of this robot" in useless.err


def test_a_recorded_motion_brings_its_own_loads(run: Run, tmp_path: Path) -> None:
    """A planned walk, its truth written as a motion, comes back with the loads it brought."""
    plan = WalkPlan(duration_s=10.0)
    planned = walk_logs(plan, streams=Streams(cell_rate_hz=100.0)).cells.truth
    motion = walking(Biped(), plan, planned.time_s)
    columns = {"time_s": planned.time_s}
    columns |= {f"{c}_n": planned.readings[:, i] for i, c in enumerate(planned.channels)}
    for i, axis in enumerate("xyz"):
        columns[f"com_{axis}_m"] = motion.com_m[:, i]
        columns[f"com_acc_{axis}_mps2"] = motion.com_acc_mps2[:, i]
        for k, foot in enumerate(("left", "right")):
            columns[f"{foot}_foot_{axis}_m"] = motion.foot_m[:, k, i]
            columns[f"{foot}_foot_yaw_rad"] = motion.foot_yaw_rad[:, k]
    columns |= {f"angmom_rate_{a}_nm": motion.angmom_rate_nm[:, i] for i, a in enumerate("xy")}
    pd.DataFrame(columns).to_parquet(tmp_path / "motion.parquet")
    answer = run(
        "simulate", tmp_path / "motion.parquet", "--experiment", "walk", "--out", tmp_path / "out"
    )
    assert answer.exit_code == 0, answer.err
    loads = pd.read_parquet(tmp_path / "out/true_loads.parquet")
    for i, channel in enumerate(CELLS):
        brought = np.interp(loads["time_s"], planned.time_s, planned.readings[:, i])
        np.testing.assert_allclose(loads[f"{channel}_n"], brought, atol=1e-9)
    refused = run(
        "simulate", tmp_path / "motion.parquet", "--experiment", "hang", "--out", tmp_path / "no"
    )
    assert refused.exit_code == 2
    assert "stands and walks on load cells only" in refused.err


@pytest.mark.parametrize("recipe", ["nao_simulated", "hexapod_simulated"])
def test_the_recipes_run(run: Run, tmp_path: Path, repository: Path, recipe: str) -> None:
    recipe_file = repository / f"recipes/{recipe}.toml"
    with drawing():
        answer = run("simulate", "--recipe", recipe_file, "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    assert (tmp_path / "out/figures/shown_and_true.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--effect", "histeresis=1"), "did you mean 'hysteresis'?"),
        (("--effect", "hysteresis=much"), "not a number"),
        (("--effect", "hysteresis=9999"), "between -950 and 950"),
        (("--effect", "middle_rr.hysteresis=1"), "no channel named 'middle_rr'"),
        (("--effect", "hysteresis=1,reach=2"), "has no parameter 'reach'"),
        (("--effect", "creep=0.01", "--effect", "left_fl.creep=0.02"), "twice"),
        (("--speed-mps", "0.9"), "less than or equal to 0.3"),
    ],
)
def test_mistakes_are_one_line_and_write_nothing(
    run: Run, tmp_path: Path, arguments: tuple[str, ...], said: str
) -> None:
    answer = run("simulate", "--experiment", "walk", *arguments, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    assert answer.err.count("\n") == 1
    assert said in answer.err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_an_hour_of_an_eight_cell_walk_is_written_whole(run: Run, tmp_path: Path) -> None:
    answer = run(
        "simulate", "--experiment", "walk", "--duration-s", "3600", "--effect", "hysteresis=0.3",
        "--out", tmp_path / "out", "--quiet",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    assert len(pd.read_parquet(tmp_path / "out/cells.parquet", columns=["time_s"])) == 288_000


def test_effects_lists_every_row_and_explains_each(run: Run) -> None:
    listed = run("effects")
    assert listed.exit_code == 0
    for name, effect in TABLE.items():
        assert f"\n{name} " in listed.out
        explained = run("effects", name)
        assert explained.exit_code == 0
        for text in (effect.formula, effect.remedy, effect.separates, effect.mimics[0]):
            assert text in explained.out
    walk = run("effects", "--experiment", "walk")
    assert "\ndelay " in walk.out
    assert "\nleg_com " not in walk.out
    assert run("effects", "histeresis").exit_code == 2


def test_hangings_are_named_after_the_axes_that_the_recipe_names(run: Run, tmp_path: Path) -> None:
    """Legs turned by 60 and 180 degrees; `hang-calib` finds their offsets."""
    legs = "\n".join(
        f"[robot.legs.{name}]\nposition_m = [{x}, {y}, 0.0]\nrotation_rpy_rad = [0.0, 0.0, {yaw}]"
        for name, x, y, yaw in (
            ("fl", 0.2, 0.1, 1.0472), ("fr", 0.2, -0.1, -1.0472), ("hl", -0.2, 0.0, 3.1416)
        )
    )  # fmt: skip
    recipe = tmp_path / "turned.toml"
    recipe.write_text(
        f'[robot]\nname = "turned"\nmass_kg = 8.0\n{legs}\n[hang_calib]\norientation_of = "body"\n'
        '[simulate]\nexperiment = "hang"\ncycles = 2\nhang_tilt_sd_rad = 0.0\n'
        "mount_rotation_sd_rad = 0.0\n",
        encoding="utf-8",
    )
    made = run("simulate", "--recipe", recipe, "--out", tmp_path / "sim", "--quiet")
    assert made.exit_code == 0, made.err
    truth = read_record(TruthRecord, tmp_path / "sim/truth.json")
    hung = pd.read_parquet(tmp_path / "sim/hang.parquet")
    force = hung[["fx_n", "fy_n", "fz_n"]].to_numpy()
    for name, yaw in (("fl", np.pi / 3), ("hl", np.pi)):
        offset = [truth.parameters[f"{name}.offset_f{axis}"] for axis in "xyz"]
        mine = ((hung["leg"] == name) & (hung["orientation"] == "+x")).to_numpy()
        carried = (force[mine] - offset).mean(axis=0)
        along = np.array([np.cos(yaw), -np.sin(yaw), 0.0])
        np.testing.assert_allclose(carried / np.linalg.norm(carried), along, atol=5e-3)
    found = run(
        "hang-calib", tmp_path / "sim/hang.parquet", "--recipe", recipe,
        "--out", tmp_path / "fit", "--quiet",
    )  # fmt: skip
    assert found.exit_code == 0, found.err
    fitted = json.loads((tmp_path / "fit/parameters.json").read_text())["parameters"]
    for name, true in truth.parameters.items():
        if ".offset_" in name:
            assert abs(fitted[name]["value"] - true) < 5.0 * fitted[name]["sd"]
