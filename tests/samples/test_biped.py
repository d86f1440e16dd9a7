"""The physics biped obeys Newton and Euler, walks, stands, and repeats itself."""

from __future__ import annotations

import importlib
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco")

MASS_KG = 5.3
WEIGHT_N = MASS_KG * 9.80665


@pytest.fixture(scope="module")
def biped() -> Any:
    """Return the generator, which is a script outside the package."""
    return importlib.import_module("biped")


@pytest.fixture(scope="module")
def walking(biped: ModuleType) -> Any:
    """Return the planner beside it."""
    return sys.modules["walking"]


@pytest.fixture(scope="module")
def walk(biped: Any) -> Any:
    """Return 6 s of the fastest walk."""
    return biped.walk(0.1, 6.0, seed=3)


def loads(biped: Any, motion: Any) -> dict[str, Any]:
    """Return the load of each foot in N."""
    return {
        foot: motion[[f"{foot}_{cell}_n" for cell in biped.CELLS]].sum(axis=1).to_numpy()
        for foot in biped.FEET
    }


def test_model_has_the_dimensions_that_recipes_copy(biped: Any, walking: Any) -> None:
    """Pads, legs and mass of the XML are those of the constants."""
    robot = biped.Biped()
    assert robot.mass_kg == pytest.approx(MASS_KG)
    for foot in biped.FEET:
        sole = robot.model.site(f"{foot}_sole").pos
        assert sole == pytest.approx([0.0, 0.0, -walking.ANKLE_HEIGHT_M])
        pads = [robot.model.geom(f"{foot}_{cell}") for cell in biped.CELLS]
        assert [pad.pos[0] for pad in pads] == pytest.approx(biped.CELL_X_M)
        assert [pad.pos[1] for pad in pads] == pytest.approx(biped.CELL_Y_M)
        assert [pad.pos[2] - pad.size[0] for pad in pads] == pytest.approx([sole[2]] * 4)
        assert abs(robot.model.body(f"{foot}_thigh").pos[1]) == walking.HIP_OFFSET_M
        assert robot.model.body(f"{foot}_shank").pos[2] == -walking.THIGH_M
        assert robot.model.body(f"{foot}_foot").pos[2] == -walking.SHANK_M


def test_postures_put_feet_and_com_where_planned(biped: Any, walking: Any) -> None:
    """Forward kinematics of the inverse kinematics is the plan, turning included."""
    robot = biped.Biped()
    plan = walking.plan_walk(0.1, 4.0, np.random.default_rng(0), turn_radps=0.2)
    qpos = robot.postures(plan)
    at = len(qpos) - 100
    robot.data.qpos[:] = qpos[at]
    biped.mujoco.mj_forward(robot.model, robot.data)
    for side, foot in enumerate(biped.FEET):
        sole = robot.data.site(f"{foot}_sole")
        x, y, z, yaw = plan.feet_m[at, side]
        assert sole.xpos == pytest.approx([x, y, z], abs=1e-9)
        assert sole.xmat[:3] == pytest.approx([np.cos(yaw), -np.sin(yaw), 0.0], abs=1e-9)
    assert robot.data.subtree_com[0] == pytest.approx(plan.com_m[at], abs=1e-5)


def test_com_path_has_the_zmp_it_was_made_for(walking: Any) -> None:
    """The cart-table model turns the CoM path back into the ZMP."""
    plan = walking.plan_walk(0.1, 4.0, np.random.default_rng(0))
    com = plan.com_m
    acc = (com[2:, :2] - 2.0 * com[1:-1, :2] + com[:-2, :2]) / walking.PERIOD_S**2
    zmp = com[1:-1, :2] - com[1:-1, 2:] / walking.GRAVITY_MPS2 * acc
    assert zmp == pytest.approx(plan.zmp_m[1:-1], abs=1e-9)


def test_walk_balances(biped: Any, walk: Any) -> None:
    """Newton and Euler hold between pads and motion, landing or not."""
    balance = biped.check_balance(walk, MASS_KG)
    assert balance.force_pct < 0.1
    assert balance.force_landing_pct < 0.1
    assert balance.cop_m < 2e-4
    assert balance.cop_landing_m < 2e-4


def test_balance_sees_what_is_wrong(biped: Any, walk: Any) -> None:
    """A scale error of 2 % and a pad that reads 1 N too much show at their size."""
    cells = list(biped.CELL_COLUMNS)
    scaled = walk.assign(**{name: walk[name] * 1.02 for name in cells})
    assert biped.check_balance(scaled, MASS_KG).force_pct == pytest.approx(2.0, rel=0.05)
    shifted = walk.assign(left_fl_n=walk["left_fl_n"] + 1.0)
    assert biped.check_balance(shifted, MASS_KG).force_pct == pytest.approx(
        100.0 / WEIGHT_N, rel=0.01
    )


def test_walk_is_walking(biped: Any, walk: Any) -> None:
    """Feet take turns, a swinging foot weighs nothing, and the robot gets ahead."""
    left, right = loads(biped, walk).values()
    stepping = walk["time_s"].to_numpy() > 2.6
    lifted = {foot: walk[f"{foot}_foot_z_m"].to_numpy() > 0.005 for foot in biped.FEET}
    assert lifted["left"][stepping].mean() > 0.2
    assert lifted["right"][stepping].mean() > 0.2
    assert not (lifted["left"] & lifted["right"]).any()
    assert np.all(left[lifted["left"]] == 0.0)
    assert np.all(right[lifted["right"]] == 0.0)
    assert walk["com_x_m"].iloc[-1] == pytest.approx(0.1 * 3.4, abs=0.04)
    assert 0.05 < walk["landing"].mean() < 0.4


def test_standing_reads_the_weight(biped: Any, walk: Any) -> None:
    """Before the first step the pads carry m g and the IMU reads g upward."""
    quiet = walk[walk["time_s"] < 1.8]
    total = sum(loads(biped, quiet).values())
    assert np.mean(total) == pytest.approx(WEIGHT_N, rel=0.002)
    assert quiet["imu_acc_z_mps2"].mean() == pytest.approx(9.80665, rel=0.002)
    assert quiet[["com_acc_x_mps2", "com_acc_y_mps2", "com_acc_z_mps2"]].mean().abs().max() < 0.01


def test_means_are_exact_over_their_window(walk: Any) -> None:
    """The IMU stamps and the CoM stamps agree: positions differentiate to accelerations."""
    position = walk[["com_x_m", "com_y_m", "com_z_m"]].to_numpy()
    acc = walk[["com_acc_x_mps2", "com_acc_y_mps2", "com_acc_z_mps2"]].to_numpy()
    second = (position[2:] - 2.0 * position[1:-1] + position[:-2]) / 0.01**2
    smooth = (acc[2:] + 2.0 * acc[1:-1] + acc[:-2]) / 4.0
    assert np.sqrt(np.mean((second - smooth) ** 2)) < 0.05


def test_same_seed_same_bytes(biped: Any, walk: Any, tmp_path: Path) -> None:
    """A motion and its file repeat exactly; another seed makes another motion."""
    again = biped.walk(0.1, 6.0, seed=3)
    other = biped.walk(0.1, 6.0, seed=4)
    paths = [tmp_path / name for name in ("a.parquet", "b.parquet")]
    for motion, path in zip((walk, again), paths, strict=True):
        biped.write_motion(motion, path)
    assert walk.equals(again)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert np.abs(other["left_fl_n"] - walk["left_fl_n"]).max() > 0.1


def test_stand_holds_its_stances(biped: Any, walking: Any) -> None:
    """Weight goes where a stance asks, on feet that were re-placed and turned."""
    stances = (
        walking.Stance("left", weight=0.5),
        walking.Stance("turned", right_m=(0.02, -0.06, -0.3), com_z_m=0.25),
    )
    motion = biped.stand(stances, 1.0, seed=1)
    assert [name for name, _, _ in motion.attrs["stances"]] == ["left", "turned"]
    quiet = [motion[motion["time_s"].between(a, b)] for _, a, b in motion.attrs["stances"]]
    shares = [loads(biped, part)["left"].mean() / WEIGHT_N for part in quiet]
    assert shares == pytest.approx([0.75, 0.5], abs=0.03)
    assert quiet[1]["com_z_m"].mean() == pytest.approx(0.25, abs=0.002)
    assert quiet[1]["right_foot_yaw_rad"].mean() == pytest.approx(-0.3, abs=0.01)
    assert biped.check_balance(motion, MASS_KG).force_pct < 0.05


def test_turning_walk_keeps_its_balance(biped: Any) -> None:
    """The CoP balance holds in a world frame that the robot does not face."""
    motion = biped.walk(0.04, 6.0, seed=1, turn_radps=0.15)
    assert motion["left_foot_yaw_rad"].iloc[-1] > 0.3
    assert biped.check_balance(motion, MASS_KG).cop_m < 2e-4


def test_fall_is_an_error(biped: Any, walking: Any) -> None:
    """Nobody gets the motion of a robot that fell."""
    plan = walking.plan_stand((), 1.0)
    tipping = replace(plan, com_m=plan.com_m + np.array([0.07, 0.0, 0.0]))
    with pytest.raises(biped.FallError):
        biped.Biped().run(tipping, plan.duration_s, np.random.default_rng(1))


def test_stride_out_of_reach_is_an_error(biped: Any) -> None:
    """A leg is not stretched beyond its length."""
    with pytest.raises(ValueError, match="cannot span"):
        biped.walk(0.8, 6.0, seed=1)
