"""Simulated logs: exact physics in, honest noise on top, the same bytes for the same seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.chain import Chain, chain_of, link
from footcal_cli.core.effects import TABLE
from footcal_cli.core.experiments import hang, placements, pose, stand, walk, weights
from footcal_cli.core.experiments.contract import Balance
from footcal_cli.core.hang.joint import fit_hang
from footcal_cli.core.hang.runs import hang_runs
from footcal_cli.core.log import Log
from footcal_cli.core.simulation.bench_logs import (
    PlacementsPlan,
    WeightsPlan,
    placements_log,
    weights_logs,
)
from footcal_cli.core.simulation.biped_logs import (
    BipedLogs,
    Course,
    StandPlan,
    Streams,
    biped_logs,
    standing_motion,
)
from footcal_cli.core.simulation.forces import foot_cops, shares
from footcal_cli.core.simulation.gait import WalkPlan, walking
from footcal_cli.core.simulation.hexapod_logs import (
    HangPlan,
    PosePlan,
    offset_values,
    orientation_of,
    simulated_hang_log,
    simulated_pose_log,
)
from footcal_cli.core.simulation.noise import SimulatedNoise, stream
from footcal_cli.core.simulation.plans import Spread
from footcal_cli.core.simulation.robots import TABLE_II_OFFSETS, Biped, Hexapod
from footcal_cli.core.simulation.scenario import mounting
from footcal_cli.core.study.stepwise import fit_stepwise
from footcal_cli.errors import UsageError

BIPED, HEXAPOD = Biped(), Hexapod()
CELLS = chain_of([link(TABLE["scale_bias"], BIPED.channels)])
NAMEPLATE = {f"{c}.scale": BIPED.scale_n_per_count for c in BIPED.channels} | {
    f"{c}.bias": -BIPED.scale_n_per_count * BIPED.zero_counts for c in BIPED.channels
}
OFFSETS = chain_of([link(TABLE["offset"], HEXAPOD.channels)])


def walk_logs(plan: WalkPlan, seed: int = 1, streams: Streams | None = None) -> BipedLogs:
    return biped_logs(
        Course("walk", BIPED, lambda t: walking(BIPED, plan, t), plan.duration_s), CELLS, NAMEPLATE,
        seed=seed, streams=streams,
    )  # fmt: skip


def stand_logs(plan: StandPlan, seed: int) -> BipedLogs:
    motion_at = standing_motion(BIPED, plan, seed)
    return biped_logs(
        Course("stand", BIPED, motion_at, plan.duration_s), CELLS, NAMEPLATE, seed=seed
    )


def largest(balance: Callable[[Log], Balance], log: Log) -> float:
    found = balance(log)
    return float(np.abs(found.error[found.valid]).max())


@pytest.mark.parametrize("turn_radps", [0.0, 0.1])
@pytest.mark.parametrize("speed_mps", [0.02, 0.1])
def test_a_walk_obeys_newton_and_euler_exactly(speed_mps: float, turn_radps: float) -> None:
    plan = WalkPlan(duration_s=30.0, speed_mps=speed_mps, turn_radps=turn_radps)
    truth = walk_logs(plan).cells.truth
    assert largest(walk.balance, truth) < 1e-9
    assert truth.readings.min() >= 0.0


def test_the_com_of_a_walk_accelerates_as_it_says() -> None:
    plan = WalkPlan(duration_s=12.0, speed_mps=0.1)
    t = np.arange(0.0, 12.0, 1e-3)
    motion = walking(BIPED, plan, t)
    second = np.gradient(np.gradient(motion.com_m, t, axis=0), t, axis=0)[5:-5]
    np.testing.assert_allclose(second, motion.com_acc_mps2[5:-5], atol=0.01)


def test_a_walk_alternates_support_and_rolls_from_heel_to_toe() -> None:
    plan = WalkPlan(duration_s=20.0, speed_mps=0.1)
    logs = walk_logs(plan)
    truth = logs.cells.truth
    left = truth.readings[:, :4].sum(axis=1)
    left_alone = truth.known["contact"][:, 1] == 0.0
    assert left[truth.known["contact"][:, 0] == 0.0].max() < 1e-9
    assert left[left_alone].min() > 45.0
    front = truth.readings[:, [0, 1]].sum(axis=1) / np.maximum(left, 1.0)
    starts = np.flatnonzero(np.diff(left_alone.astype(int)) == 1) + 1
    ends = np.flatnonzero(np.diff(left_alone.astype(int)) == -1)
    assert np.all(front[ends] > front[starts] + 0.2)
    both = (truth.known["contact"] == 1.0).all(axis=1) & (truth.block > 0)
    assert 0.15 < both.mean() < 0.35


def test_a_stand_obeys_newton_and_euler_in_every_stance() -> None:
    plan = StandPlan(stances=10, stance_s=3.0)
    for seed in range(10):
        truth = stand_logs(plan, seed).cells.truth
        assert largest(walk.balance, truth) < 1e-9
        # Quiet standing takes the CoM as CoP: wrong by the sway's acceleration only.
        assert largest(stand.EXPERIMENT.balance, truth) < 0.1
        assert truth.readings.min() >= 0.0
        assert set(truth.block) == set(range(10))


def test_a_stance_on_one_foot_leaves_the_other_in_the_air() -> None:
    for seed in range(5):
        truth = stand_logs(StandPlan(stances=2, one_foot=4, stance_s=2.0), seed).cells.truth
        assert largest(walk.balance, truth) < 1e-9
        on = np.stack([truth.readings[:, :4].sum(axis=1), truth.readings[:, 4:].sum(axis=1)], -1)
        np.testing.assert_array_equal(on > 1.0, truth.known["contact"] == 1.0)
        alone = (truth.known["contact"] == 0.0).any(axis=1)
        np.testing.assert_array_equal(alone, truth.block >= 2)


def test_weights_and_placements_carry_what_they_say() -> None:
    for done in weights_logs(BIPED, WeightsPlan(sessions=2), CELLS, NAMEPLATE, seed=1).values():
        assert largest(weights.balance, done.truth) == 0.0
        assert done.log.readings == pytest.approx(np.rint(done.log.readings))
    done = placements_log(BIPED, "left", PlacementsPlan(repeats=2), CELLS, NAMEPLATE, seed=1)
    assert len(np.unique(done.log.known["hole_m"], axis=0)) == 18
    assert largest(placements.balance, done.truth) < 1e-9


def test_a_hanging_leg_carries_its_weight_and_table_ii_is_the_truth() -> None:
    values = offset_values(HEXAPOD)
    for leg, offset in TABLE_II_OFFSETS.items():
        done = simulated_hang_log(HEXAPOD, leg, HangPlan(cycles=2), OFFSETS, values, seed=3)
        assert largest(hang.EXPERIMENT.balance, done.truth) == 0.0
        way = np.array(orientation_of(done.log, np.eye(3)))
        opposite = done.log.readings[way == "+z"].mean(axis=0) + done.log.readings[
            way == "-z"
        ].mean(axis=0)
        np.testing.assert_allclose(0.5 * opposite, offset, atol=0.01)


def test_poses_balance_the_chassis_exactly_with_friction_inside() -> None:
    done = simulated_pose_log(
        HEXAPOD, PosePlan(poses=60, tripods=20), OFFSETS, offset_values(HEXAPOD), seed=2
    )
    known, truth = done.truth.known, done.truth.readings.reshape(-1, 6, 2, 3)
    wrench_b = np.einsum("nkij,nkwj->nkwi", known["hip_rot_bt"], truth)
    force = wrench_b[:, :, 0]
    arms = known["hip_pos_b_m"] - known["chassis_com_b_m"][:, None]
    moment = (wrench_b[:, :, 1] + np.cross(arms, force)).sum(axis=1)
    down_b = -known["rot_wb"][:, 2]
    chassis = known["robot_weight_n"] - known["leg_weight_n"].sum(axis=1)
    np.testing.assert_allclose(force.sum(axis=1), -chassis[:, None] * down_b, atol=1e-9)
    np.testing.assert_allclose(moment, 0.0, atol=1e-9)
    sideways = np.linalg.norm(force[:60, :, :2], axis=-1)
    assert sideways.mean() > 1.0
    np.testing.assert_allclose(np.linalg.det(known["rot_wb"]), 1.0)
    lifted = known["contact"] == 0.0
    loads = np.linalg.norm(force, axis=-1)
    np.testing.assert_allclose(loads[lifted], known["leg_weight_n"][lifted])


@pytest.mark.parametrize(("legs", "sets", "on"), [(4, 4, 3), (6, 2, 3), (8, 2, 4)])
def test_legs_of_any_name_and_number_stand_in_turn_across_the_body(
    legs: int, sets: int, on: int
) -> None:
    ahead = np.linspace(0.2, -0.2, legs // 2)
    hips = np.array([(x, y, 0.0) for y in (0.1, -0.1) for x in ahead])
    one = HEXAPOD.legs["fl"]
    robot = replace(
        HEXAPOD,
        legs={f"leg {k}": replace(one, position_m=(x, y, z)) for k, (x, y, z) in enumerate(hips)},
    )
    offsets = chain_of([link(TABLE["offset"], robot.channels)])
    log = simulated_pose_log(
        robot, PosePlan(poses=0, tripods=8), offsets, offset_values(robot), seed=1
    ).truth
    standing = log.known["contact"] > 0.5
    assert len(np.unique(standing, axis=0)) == sets
    assert np.all(standing.sum(axis=1) == on)
    assert np.all(standing[:, : legs // 2].sum(axis=1) >= 1)  # on both sides
    assert np.all(standing[:, legs // 2 :].sum(axis=1) >= 1)
    assert np.isfinite(log.readings).all()


def test_the_planned_belief_is_kept_and_the_truth_is_off_by_the_correction() -> None:
    chain = CELLS.with_link(link(TABLE["cell_position"], BIPED.channels))
    values = {**NAMEPLATE, "left_fl.cell_correction_x": 0.004}
    plan = WalkPlan(duration_s=10.0)
    logs = biped_logs(
        Course("walk", BIPED, lambda t: walking(BIPED, plan, t), 10.0), chain, values, seed=1
    )  # fmt: skip
    believed = walk_logs(plan).cells.log.known["cell_pos_m"]
    np.testing.assert_allclose(logs.cells.log.known["cell_pos_m"], believed, atol=1e-12)
    moved = logs.cells.truth.known["cell_pos_m"] - believed
    np.testing.assert_allclose(np.linalg.norm(moved[:, 0], axis=-1), 0.004)
    assert largest(walk.balance, logs.cells.truth) < 1e-9


def test_the_body_stream_is_late_by_twenty_milliseconds() -> None:
    plan = WalkPlan(duration_s=40.0, speed_mps=0.1)
    body = walk_logs(plan).body
    assert np.all(np.diff(body.time_s) > 0.0)
    taken = np.arange(4000) / 100.0 + 0.0037
    late = body.time_s - taken
    assert late.mean() == pytest.approx(0.020, abs=0.001)
    assert late.std() == pytest.approx(0.004, abs=0.0005)
    motion = walking(BIPED, plan, taken)
    np.testing.assert_allclose(body.known["com_m"], motion.com_m, atol=2e-3)


def test_noise_has_the_sizes_and_memory_it_says() -> None:
    rng = stream(5, "noise")
    t = np.arange(200_000) / 80.0
    block = np.zeros(len(t), dtype=int)
    wandering = SimulatedNoise(wandering=0.2, wandering_time_s=0.5).added(
        np.zeros((len(t), 2)), t, block, rng
    )
    assert wandering.std() == pytest.approx(0.2, rel=0.05)
    after_tau = np.mean(wandering[40:] * wandering[:-40]) / wandering.var()
    assert after_tau == pytest.approx(np.exp(-1.0), abs=0.03)
    repeated = SimulatedNoise(repeat_gain=0.01, repeat_offset=0.1).added(
        np.full((len(t), 2), 10.0), t, np.arange(len(t)) // 100, rng
    )
    means = repeated[::100]
    assert np.ptp(repeated[:100], axis=0).max() == 0.0
    assert means.std() == pytest.approx(np.hypot(0.1, 0.1), rel=0.05)


def test_the_same_seed_gives_the_same_numbers_and_another_seed_others() -> None:
    plan = WalkPlan(duration_s=10.0)
    one, two, other = (walk_logs(plan, seed) for seed in (4, 4, 5))
    np.testing.assert_array_equal(one.cells.log.readings, two.cells.log.readings)
    np.testing.assert_array_equal(one.body.time_s, two.body.time_s)
    assert np.mean(one.cells.log.readings == other.cells.log.readings) < 0.01


@pytest.mark.slow
def test_an_hour_of_walking_is_as_long_as_an_hour() -> None:
    logs = walk_logs(WalkPlan(duration_s=3600.0))
    assert len(logs.cells.log) == 288_000


def test_shares_are_bilinear_on_a_rectangle_and_exact_on_any_foot() -> None:
    rng = np.random.default_rng(0)
    rectangle = np.array([[1.0, 0.5], [1.0, -0.5], [-1.0, 0.5], [-1.0, -0.5]])
    cop = rng.uniform(-0.95, 0.95, (200, 2)) * [1.0, 0.5]
    u, v = cop.T / np.array([[1.0], [0.5]])
    got = shares(rectangle - cop[:, None])
    bilinear = np.stack([(1 + u) * (1 + v), (1 + u) * (1 - v), (1 - u) * (1 + v)], axis=-1) / 4
    np.testing.assert_allclose(got[:, :3], bilinear, atol=1e-9)
    pentagon = np.stack([np.cos(np.arange(5) * 1.2566), np.sin(np.arange(5) * 1.2566)], axis=-1)
    cop = rng.uniform(-0.5, 0.5, (200, 2))
    got = shares(pentagon - cop[:, None])
    np.testing.assert_allclose(got @ pentagon, cop, atol=1e-9)
    assert got.min() > 0.0


def test_a_cop_beyond_the_cells_is_refused() -> None:
    rectangle = np.array([[1.0, 0.5], [1.0, -0.5], [-1.0, 0.5], [-1.0, -0.5]])
    with pytest.raises(UsageError, match="centre of pressure leaves"):
        shares((rectangle - np.array([1.1, 0.0]))[None])


def test_two_feet_share_a_cop_exactly_and_a_swinging_foot_takes_nothing() -> None:
    rng = np.random.default_rng(0)
    ref = np.array([[0.0, 0.05], [0.02, -0.05]]) + 0.01 * rng.standard_normal((50, 2, 2))
    cop = 0.03 * rng.standard_normal((50, 2))
    stands = np.ones((50, 2))
    stands[:10, 0], stands[10:20, 1] = 0.0, 0.0
    share, foot_cop = foot_cops(cop, ref, stands, 0.01 * rng.standard_normal((50, 2)))
    np.testing.assert_allclose(np.einsum("nf,nfi->ni", share, foot_cop), cop, atol=1e-12)
    assert share[:10, 0].max() == share[10:20, 1].max() == 0.0


def test_an_empty_chain_logs_newtons() -> None:
    plan = WalkPlan(duration_s=8.0)
    logs = biped_logs(
        Course("walk", BIPED, lambda t: walking(BIPED, plan, t), 8.0), Chain(()), {},
        seed=1, streams=Streams(cell_noise=SimulatedNoise()), to_counts=False,
    )  # fmt: skip
    np.testing.assert_array_equal(logs.cells.log.readings, logs.cells.truth.readings)


def test_hanging_residuals_have_several_peaks_without_tilt_and_one_with_it() -> None:
    """[Wu], Fig. 5: what is left per orientation, against the spread within each."""
    chain, values = mounting(HEXAPOD, Spread(), seed=4)
    several = 0
    for leg in HEXAPOD.legs:
        log = simulated_hang_log(HEXAPOD, leg, HangPlan(cycles=2), chain, values, seed=4).log
        fits = fit_stepwise([log], naive=True), fit_hang([log])
        runs, _ = hang_runs([log])
        naive, joint = ([part[:, :3] for part in fit.residuals(runs)] for fit in fits)
        apart = [np.ptp([part.mean(axis=0) for part in parts], axis=0) for parts in (naive, joint)]
        within = np.mean([part.std(axis=0) for part in joint], axis=0)
        several += int(np.sum(apart[0] > 4.0 * within))
        assert np.all(apart[1] < within)
    assert several >= 6, "of 18 force axes"


def test_naive_taring_misses_the_balance_by_much_more_than_the_noise() -> None:
    """[Wu], Fig. 2: offsets tared in the air hold the legs' weight, whose torque then moves."""
    chain, values = mounting(HEXAPOD, Spread(), seed=4)
    done = simulated_pose_log(HEXAPOD, PosePlan(poses=60), chain, values, seed=4)
    calibrated, _ = chain.remove(done.log, values)
    exact = pose.EXPERIMENT.balance(calibrated).error
    legs = np.arange(6)
    tare = np.array([leg.offset for leg in HEXAPOD.legs.values()])
    for k, leg in zip(legs, HEXAPOD.legs.values(), strict=True):
        down = np.array([0.0, 0.0, -leg.weight_n])
        com = leg.com_m(np.zeros(1))[0]
        tare[k] += np.concatenate([down, np.cross(com, down)])
    tared = done.log.with_readings(done.log.readings - tare.ravel())
    naive = pose.EXPERIMENT.balance(
        tared.with_known(leg_weight_n=np.zeros_like(done.log.known["leg_weight_n"]))
    ).error
    rms = [np.sqrt(np.mean(error[:, 3:5] ** 2, axis=0)) for error in (naive, exact)]
    assert np.all(rms[0] > 4.0 * rms[1])
