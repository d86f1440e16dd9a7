"""Proposed experiments carried out: the same robot, the same effect but for what is taken away."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.diagnosis.plans import PLANS
from tests.blind.bench import ask
from tests.blind.diagnosing import diagnosed
from tests.blind.followup import make_followup
from tests.blind.plan import Cell
from tests.blind.scoring import Verdict, judge_followup
from tests.blind.trials import drawn, make_trial
from tests.blind.world import GRAVITY_MPS2
from tests.blind.worlds import WORLDS
from tests.blind.worlds.proposed import SETTLED, can_make, proposed
from tests.blind.yardstick import yardstick


def truth_of(experiment: str, key: str, size: float, seed: int = 11) -> dict[str, Any]:
    """What the ledger knows of a designed alias."""
    return {
        "kind": "alias", "experiment": experiment, "drift": False, "seed": seed, "rho": 1.0,
        "effects": [{"key": key, "size": size, "place": 3, "right": [key.split("/")[0]]}],
    }  # fmt: skip


def table_of(folder: Path, stem: str) -> pd.DataFrame:
    path = next(folder.glob(f"{stem}.[cp]*"))
    return pd.read_parquet(path) if path.suffix == ".parquet" else pd.read_csv(path)


def test_every_plan_that_settles_something_can_be_made_here() -> None:
    for plan in PLANS:
        if plan.settles:
            assert can_make(plan.id)
            assert set(SETTLED[plan.id]) == set(plan.settles)


@pytest.mark.parametrize(("key", "stays"), [("delay/jittered", True), ("lag/butterworth", False)])
def test_a_walk_without_smoothing_keeps_a_delay_and_no_low_pass(
    tmp_path: Path, key: str, stays: bool
) -> None:
    proposal = {"id": "walk_unsmoothed", "repeats": 1, "without": ["lag"]}
    truth = truth_of("walk", key, 0.02)
    made = table_of(
        make_followup(truth, {"next_experiment": proposal}, 5, tmp_path / "with"), "body"
    )
    none = {**truth, "effects": [{**truth["effects"][0], "size": 1e-9}]}
    clean = table_of(
        make_followup(none, {"next_experiment": proposal}, 5, tmp_path / "without"), "body"
    )
    moved = np.abs(made["com_x_m"] - clean["com_x_m"]).max()
    assert (moved > 1e-4) == stays
    options = tomllib.loads((tmp_path / "with" / "recipe.toml").read_text("utf-8"))["diagnose"]
    assert options["without"] == ["lag"]


@pytest.mark.parametrize("key", ["robot_weight/belief", "leg_weight/shoe"])
def test_a_scale_corrects_the_robot_s_weight_and_no_leg_s(tmp_path: Path, key: str) -> None:
    truth = truth_of("pose", key, 4.0)
    truth["seed"] = 12
    proposal = {"id": "weigh_robot", "repeats": 1, "without": ["robot_weight"]}
    folder = make_followup(truth, {"next_experiment": proposal}, 5, tmp_path / "made")
    before = drawn(Cell("alias", "pose", (key,), 1.0), truth["seed"]).clean
    recipe = tomllib.loads((folder / "recipe.toml").read_text("utf-8"))
    error_n = (recipe["robot"]["mass_kg"] - before.robot["mass_kg"]) * GRAVITY_MPS2
    assert abs(error_n) < 0.1
    # the poses are the same, and so is their noise
    poses = table_of(folder, "poses").sort_values(["pose", "leg"])
    assert len(poses) == 6 * before.facts["poses"]
    first = (before.shown + before.noise).reshape(-1, 6, 6)[0]
    shown = poses[poses["pose"] == "pose 1"][["fx_n", "fy_n", "fz_n"]].to_numpy()
    order = np.argsort(["fl", "ml", "hl", "fr", "mr", "hr"])
    np.testing.assert_allclose(shown, first[order, :3], atol=1e-5)


@pytest.mark.slow
def test_the_second_experiment_leaves_the_hidden_one_of_two_rivals(tmp_path: Path) -> None:
    """A CoM that is off, or cells that all are: with toes out and in the same size is there."""
    truth = make_trial(Cell("alias", "stand", ("com_offset/standing",), 1.0), 1234, tmp_path / "a")
    ask(tmp_path / "a", "stand")
    first = diagnosed(tmp_path / "a", tmp_path / "first")
    assert {"com_offset", "cell_position"} <= set(first["rivals"][0])
    assert {s["effect"] for s in first["suspects"]} == set(first["rivals"][0])
    ask(make_followup(truth, first, 5, tmp_path / "b"), first["next_experiment"]["kind"])
    second = diagnosed(tmp_path / "b", tmp_path / "second")
    assert second["survivors"] == ["com_offset"]
    assert judge_followup(truth, Verdict.read(first), Verdict.read(second))
    # and if the robot had been put right meanwhile, the CoM would be gone too
    mended = {**truth, "effects": [{**truth["effects"][0], "size": 1e-9}]}
    ask(make_followup(mended, first, 5, tmp_path / "c"), first["next_experiment"]["kind"])
    third = diagnosed(tmp_path / "c", tmp_path / "third")
    says = {f["effect"]: f["says"] for f in third["after"]}
    assert says["com_offset"] == "gone"
    assert "com_offset" not in third["survivors"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("plan", "settles"), [("weigh_robot", "robot_weight"), ("hang_again", "leg_weight")]
)
def test_once_a_weight_is_settled_no_rival_finds_its_noise_again(
    tmp_path: Path, plan: str, settles: str
) -> None:
    """The same log is diagnosed again: gains of all axes fitted to it would fit its noise twice."""
    key = {"robot_weight": "robot_weight/belief", "leg_weight": "leg_weight/shoe"}[settles]
    truth = make_trial(Cell("alias", "pose", (key,), 1.0), 4321, tmp_path / "a")
    ask(tmp_path / "a", "pose")
    first = diagnosed(tmp_path / "a", tmp_path / "first")
    rivals = {s["effect"] for s in first["suspects"]}
    assert {"robot_weight", "leg_weight"} <= rivals
    proposal = {"id": plan, "kind": "pose", "repeats": 1, "without": [settles]}
    again = {**first, "next_experiment": {**first["next_experiment"], **proposal}}
    ask(make_followup(truth, again, 5, tmp_path / "b"), "pose")
    second = diagnosed(tmp_path / "b", tmp_path / "second")
    says = {f["effect"]: f["says"] for f in second["after"]}
    assert says == {settles: "unseen"} | dict.fromkeys(rivals - {settles}, "gone")
    assert second["survivors"] == [settles]


def test_holes_of_the_same_foot() -> None:
    """Loads on known holes balance about them, on the cells of the robot that stood."""
    before = WORLDS["stand"].draw(np.random.default_rng(4), {})
    world = proposed(np.random.default_rng(2), "holes", before, 1)
    assert world.channels == before.channels[:4]
    np.testing.assert_array_equal(world.row["cell_pos_m"][0], before.row["cells_m"][0][:4])
    np.testing.assert_array_equal(world.scale, before.scale[:4])
    assert world.row["load_n"].max() == pytest.approx(
        0.5 * before.robot["mass_kg"] * GRAVITY_MPS2, abs=0.01
    )
    assert len({tuple(hole) for hole in world.row["hole_m"]}) == 18
    error = yardstick(WORLDS["placements"], world).clean_error
    assert np.abs(error).max() < 1e-9
