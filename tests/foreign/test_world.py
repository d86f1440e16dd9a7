"""The foreign world against mechanics: what it writes must balance where nothing is hidden."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

from tests.foreign import (
    Recorded,
    draw_biped,
    draw_hexapod,
    hang,
    placements,
    poses,
    stand,
    walk,
    weights,
)
from tests.foreign.ankles import ankle_offsets
from tests.foreign.biped import CHANNELS, FEET, GRAVITY_MPS2
from tests.foreign.legs import AXES, LEGS
from tests.foreign.motion import move, plan_walk, rate
from tests.foreign.noise import stream


def _forces(recorded: Recorded, role: str) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    table, truth = recorded.logs[role], recorded.truth["parameters"]
    return np.stack(
        [table[f"{c}_counts"] * truth[f"{c}.scale"] + truth[f"{c}.bias"] for c in CHANNELS], axis=1
    )


def test_nothing_here_knows_the_product() -> None:
    here = Path(__file__).parent
    for path in set(here.glob("*.py")) - set(here.glob("test_*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(n.startswith(("footcal", "tests.blind")) for n in names), path.name


def test_motion_obeys_newton_and_euler_and_feet_only_push() -> None:
    robot, rng = draw_biped(3), stream(3, "walk")
    motion = move(robot, plan_walk(robot, rng, 12.0, None), rng)
    assert motion.ground_n.min() > -1e-9
    force = robot.mass_kg * (motion.com_acc_mps2[:, 2] + GRAVITY_MPS2)
    assert np.allclose(motion.ground_n.sum(axis=1), force, rtol=1e-9)
    # momentum of the true CoM over a second: Σ F dt = m Δv + m g t
    velocity = rate(motion.com_m)[:, 2]
    impulse = np.sum(motion.ground_n.sum(axis=1)[1000:1400]) / 400.0
    gained = robot.mass_kg * (velocity[1400] - velocity[1000]) + robot.weight_n
    assert impulse == pytest.approx(gained, rel=2e-3)


@pytest.mark.parametrize("seed", [7004, 7005, 7008])
def test_robots_of_any_size_on_any_cells_only_push(seed: int) -> None:
    robot, rng = draw_biped(seed), stream(seed, "walk")
    motion = move(robot, plan_walk(robot, rng, 6.0, None), rng)
    assert motion.ground_n.min() > -1e-9
    force = robot.mass_kg * (motion.com_acc_mps2[:, 2] + GRAVITY_MPS2)
    assert np.allclose(motion.ground_n.sum(axis=1), force, rtol=1e-9)


def test_ankle_wrenches_of_a_still_robot_carry_its_weight() -> None:
    recorded, robot = stand(7013), draw_biped(7013)
    cells = recorded.logs["cells"]
    offset = ankle_offsets(robot)
    total = sum((cells[f"{foot}_fz_n"] - offset[k, 2]).mean() for k, foot in enumerate(FEET))
    weight = robot.weight_n - 2.0 * robot.below_kg * GRAVITY_MPS2
    assert total == pytest.approx(weight, rel=2e-3)


def test_cells_show_true_loads_through_their_calibration() -> None:
    recorded = walk(4, seconds=10.0)
    error = _forces(recorded, "cells") - recorded.truth["cells_n"]
    sd = recorded.truth["cell_sd_n"]
    loaded = recorded.truth["cells_n"] > 1.0
    assert error[loaded].std() < 3.0 * sd
    assert abs(error.mean()) < sd


def test_body_stream_is_late_by_what_truth_says() -> None:
    recorded = walk(4, seconds=20.0, delay_s=0.083, stated_delay_s=0.02)
    body, truth = recorded.logs["body"], recorded.truth
    fz = truth["cells_n"].sum(axis=1)
    demand = truth["mass_kg"] * (body["com_acc_z_mps2"].to_numpy() + GRAVITY_MPS2)
    errors = {}
    for late in np.arange(0.0, 0.16, 0.01):
        seen = np.interp(truth["cells_time_s"], body["time_s"].to_numpy() - late, demand)
        errors[round(float(late), 3)] = np.std((seen - fz)[200:-100])
    assert min(errors, key=lambda k: errors[k]) in (0.08, 0.09)


def test_bench_readings_follow_the_same_cells() -> None:
    table, truth = weights(5).logs["weights"], weights(5).truth
    for channel in CHANNELS:
        own = table[table["channel"] == channel]
        force = own["counts"] * truth["parameters"][f"{channel}.scale"]
        left = force + truth["parameters"][f"{channel}.bias"] - own["load_n"]
        assert left.abs().max() < 5.0 * truth["cell_sd_n"] + 1e-3 * own["load_n"].max()
    placed = placements(5)
    frame = placed.logs["placements"]
    left_foot = frame[frame["foot"] == "left"]
    total = sum(
        left_foot[f"{c}_counts"] * truth["parameters"][f"left_{c}.scale"]
        + truth["parameters"][f"left_{c}.bias"]
        for c in ("fl", "fr", "rl", "rr")
    )
    assert (total - left_foot["load_n"]).abs().max() < 8.0 * truth["cell_sd_n"]


def test_poses_balance_about_the_chassis() -> None:
    robot, recorded = draw_hexapod(2), poses(2, count=30, noise=2e-5)
    frame = recorded.logs["poses"]
    for _, pose in frame.groupby("pose"):
        x, y, z, w = pose[[f"body_q{a}" for a in "xyzw"]].to_numpy()[0]
        down = -np.array([2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z])
        applied = pose[list(AXES)].to_numpy() - robot.offset
        force = np.einsum("kij,kj->ki", robot.rot_bt, applied[:, :3])
        torque = np.einsum("kij,kj->ki", robot.rot_bt, applied[:, 3:])
        chassis = (robot.mass_kg - robot.leg_kg.sum()) * GRAVITY_MPS2
        assert np.allclose(force.sum(axis=0), -chassis * down, atol=0.1)  # the camera: 0.3 mrad
        about = np.cross(robot.hip_m - robot.chassis_com_m, force) + torque
        assert np.allclose(about.sum(axis=0), 0.0, atol=1e-4)


def test_turning_legs_show_their_acceleration() -> None:
    robot = draw_hexapod(6)
    spread = {}
    for turn_s in (6.0, 60.0):
        frame = hang(6, turn_s=turn_s, turns=4.0).logs["hang"]
        one = frame[(frame["leg"] == "fl") & (frame["orientation"] == "+z")]
        phase = one["phase_rad"].to_numpy()
        basis = np.column_stack([np.ones_like(phase), np.sin(phase), np.cos(phase)])
        left = np.linalg.lstsq(basis, one["fx_n"].to_numpy(), rcond=None)[0]
        spread[turn_s] = float(np.hypot(*left[1:]))
    radius = float(np.hypot(*robot.arm_m[0, 0, 1:3]))
    expected = robot.leg_kg[0] * radius * (2.0 * np.pi / 6.0) ** 2
    assert spread[6.0] == pytest.approx(expected, rel=0.3)
    assert spread[60.0] < 0.15 * expected + 0.003
    assert LEGS[0] == "fl"
