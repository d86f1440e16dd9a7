"""The bench before anything is diagnosed: sizes as asked, nothing leaks, same seed same bytes."""

from __future__ import annotations

import hashlib
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.blind.hidden import CATALOGUE, switches_in
from tests.blind.ledger import open_ledger
from tests.blind.noise import FAMILIES, Spread
from tests.blind.plan import EXPERIMENTS, ROUNDS, Cell, lines, planned
from tests.blind.trials import drawn, make_trial
from tests.blind.world import Array, World
from tests.blind.worlds import WORLDS, walk
from tests.blind.worlds.proposed import proposed
from tests.blind.yardstick import Yardstick, size_for, yardstick


def _bytes(folder: Path) -> dict[str, str]:
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir()}


@pytest.mark.parametrize("experiment", EXPERIMENTS)
def test_a_clean_world_balances_but_for_what_calibration_explains(experiment: str) -> None:
    maker = WORLDS[experiment]
    world = maker.draw(np.random.default_rng(5), {})
    stick = yardstick(maker, world)
    error = np.where(stick.valid, stick.clean_error, 0.0) / stick.noise
    flat = error[stick.valid]
    left = flat - stick.absorbed @ (stick.absorbed.T @ flat)
    # interpolation of the body between its samples is all that may be left, far below the noise
    assert np.sqrt(np.mean(left**2)) < 0.1


def test_walks_of_the_engine_balance_in_every_symmetry() -> None:
    seen = 0
    for seed in range(12):
        world = WORLDS["walk"].draw(np.random.default_rng(seed), {})
        if world.facts["engine"]:
            seen += 1
            error = walk.error(world)
            assert np.nanmax(np.abs(error)) < 0.002 * world.facts["mass_kg"] * 9.81
    assert 2 <= seen <= 10


def test_poses_of_the_engine_balance() -> None:
    seen = 0
    for seed in range(8):
        world = WORLDS["pose"].draw(np.random.default_rng(seed), {})
        if world.facts["engine"]:
            seen += 1
            error = WORLDS["pose"].error(world)
            assert np.abs(error).max() < 0.02
    assert 1 <= seen <= 6


@pytest.mark.parametrize("experiment", EXPERIMENTS)
def test_hidden_effect_has_the_rho_asked_for_by_an_independent_projection(experiment: str) -> None:
    maker = WORLDS[experiment]
    world = maker.draw(np.random.default_rng(8), {})
    stick = yardstick(maker, world)
    item = next(i for i in CATALOGUE.values() if experiment in i.experiments and not i.switch)
    size, hidden = size_for(
        0.5, lambda s: item.act(world, s, np.random.default_rng(3)), stick, item.guess
    )
    # the same by plain least squares on the calibration directions, touched outputs only
    clean, shifted = maker.error(world), maker.error(hidden)
    valid = np.isfinite(clean)
    change = np.where(valid, (shifted - clean) / stick.noise, 0.0)
    columns = [
        np.where(valid, (maker.error(moved) - clean) / stick.noise, 0.0)[valid]
        for moved in maker.calibrations(world)
    ]
    design = np.stack(columns, axis=1)
    design = design / np.linalg.norm(design, axis=0).clip(1e-300)
    left = np.zeros_like(change)
    left[valid] = change[valid] - design @ np.linalg.lstsq(design, change[valid], rcond=1e-9)[0]
    touched = np.sqrt(np.mean(change**2, axis=0)) > 1e-3 * np.sqrt(np.mean(change**2, axis=0)).max()
    rho = np.sqrt(np.mean(left[:, touched][valid[:, touched]] ** 2))
    assert size > 0
    assert rho == pytest.approx(0.5, rel=0.03)


def test_the_true_gain_is_what_removing_the_effect_brings(tmp_path: Path) -> None:
    cell = Cell("single", "weights", ("creep/two_stage",), 1.0)
    truth = make_trial(cell, 33, tmp_path / "t")
    maker, rng = WORLDS["weights"], np.random.default_rng(33)
    clean = maker.draw(rng, {"drift": False})
    sign_free = CATALOGUE["creep/two_stage"]
    place = int(rng.integers(2**63))
    hidden = sign_free.act(clean, truth["effects"][0]["size"], np.random.default_rng(place))
    rms = []
    for world in (clean, hidden):
        error, left = maker.error(world.noisy()), 0.0
        for column in error.T:
            own = np.isfinite(column)
            reading = world.noisy().shown[own, 0]
            design = np.column_stack([np.ones(own.sum()), reading])
            fitted = np.linalg.lstsq(design, column[own], rcond=None)[0]
            left += float(np.sum((column[own] - design @ fitted) ** 2))
        rms.append(np.sqrt(left))
    assert truth["gain"]["force"] == pytest.approx(1 - rms[0] / rms[1], abs=0.03)


def test_the_true_gain_of_placements_is_counted_by_output(tmp_path: Path) -> None:
    truth = make_trial(Cell("single", "placements", ("wrong_hole/label",), 1.0), 8, tmp_path / "t")
    found = drawn(Cell("single", "placements", ("wrong_hole/label",), 1.0), 8)
    maker, noise = WORLDS["placements"], found.stick.noise
    rng, rms = np.random.default_rng(0), []
    for world in (found.clean, found.world):
        seen = world.noisy().shown
        if world.quantum_n > 0:
            seen = seen + world.quantum_n * rng.uniform(-0.5, 0.5, seen.shape)
        arms = world.row["cell_pos_m"] - world.row["hole_m"][:, None]
        each = np.concatenate([np.ones((*seen.shape, 1)), arms], axis=2) / noise
        design = np.concatenate([each, each * seen[..., None]], axis=1)
        flat = design.transpose(0, 2, 1).reshape(-1, 8)
        target = (maker.error(world.with_shown(seen)) / noise).ravel()
        left = target - flat @ np.linalg.lstsq(flat, target, rcond=None)[0]
        rms.append(np.sqrt(np.mean(left.reshape(-1, 3) ** 2, axis=0)))
    gains = [truth["gain"][name] for name in ("fz", "moment_x", "moment_y")]
    assert gains == pytest.approx((1 - rms[0] / rms[1]).tolist(), abs=0.03)
    assert max(gains) > 0.1


def test_a_pure_calibration_error_leaves_nothing() -> None:
    for experiment in ("weights", "placements", "walk"):
        maker = WORLDS[experiment]
        world = maker.draw(np.random.default_rng(2), {})
        stick = yardstick(maker, world)
        rng = np.random.default_rng(4)
        gain, bias = rng.normal(1, 0.05, world.shown.shape[1]), rng.normal(0, 1.0)
        wrong = world.with_shown(world.shown * gain + bias)
        assert stick.rho(wrong) < 1e-6 * np.abs(stick.influence(wrong)).max()


@pytest.mark.parametrize("family", FAMILIES)
def test_noise_families_have_their_sd_and_memory(family: str) -> None:
    rng = np.random.default_rng(1)
    block = np.repeat(np.arange(40), 500)
    load = np.abs(rng.normal(10, 4, (block.size, 2)))
    spread = Spread(family, load, block, np.array([0.1, 2.0]), repeatability=0.0)
    noise = spread.draw(rng)
    # 0.6² offset + 0.6² gain + 0.8² white where the gain wanders with the block
    expected = np.sqrt(0.64 + 2 * 0.36) if family == "block_gain_offset" else 1.0
    assert noise.std(axis=0) == pytest.approx(expected * np.array([0.1, 2.0]), rel=0.15)
    inside = noise[:500, 0] - noise[:500, 0].mean()
    lag_one = float(inside[1:] @ inside[:-1] / (inside @ inside))
    wanted = {"ar90": 0.9, "ar98": 0.98}.get(family)
    assert lag_one == (pytest.approx(wanted, abs=0.06) if wanted else pytest.approx(0, abs=0.3))


def test_same_seed_same_bytes_and_another_seed_others(tmp_path: Path) -> None:
    for experiment in EXPERIMENTS:
        cell = Cell("null", experiment)
        folders = [tmp_path / f"{experiment}{i}" for i in range(3)]
        for folder, seed in zip(folders, (11, 11, 12), strict=True):
            make_trial(cell, seed, folder)
        assert _bytes(folders[0]) == _bytes(folders[1])
        assert _bytes(folders[0]) != _bytes(folders[2])


def test_a_hidden_effect_shows_in_the_data_and_nowhere_else(tmp_path: Path) -> None:
    """Same files and keys as a null of the same seed: only numbers differ."""
    for experiment in EXPERIMENTS:
        item = next(i for i in CATALOGUE.values() if experiment in i.experiments and not i.switch)
        words = {w for name in (*item.right, *item.key.split("/")) for w in (name, name.upper())}
        null, hidden = tmp_path / f"n{experiment}", tmp_path / f"h{experiment}"
        make_trial(Cell("null", experiment), 21, null)
        make_trial(Cell("single", experiment, (item.key,), 0.5), 21, hidden)
        assert {p.stem for p in null.iterdir()} == {p.stem for p in hidden.iterdir()}
        assert _keys(null) == _keys(hidden)
        text = b"".join(p.read_bytes() for p in hidden.iterdir() if p.suffix != ".parquet").decode()
        assert not [w for w in words if w in text.replace("offset_m", "")]


def _keys(folder: Path) -> list[str]:
    lines = (folder / "recipe.toml").read_text(encoding="utf-8").splitlines()
    return sorted(line.split("=")[0].strip() for line in lines)


def test_development_and_sealed_seeds_never_meet(tmp_path: Path) -> None:
    development = open_ledger(tmp_path / "d", "development")
    sealed = open_ledger(tmp_path / "s", "sealed")
    other = open_ledger(tmp_path / "t", "sealed")
    numbers = range(20_000)
    seeds = [{ledger.seed(str(n)) for n in numbers} for ledger in (development, sealed, other)]
    assert all(len(s) == len(numbers) for s in seeds)
    assert not seeds[0] & seeds[1]
    assert not seeds[1] & seeds[2]
    assert open_ledger(tmp_path / "s", "sealed").seed("7") == sealed.seed("7")


def test_at_least_half_of_the_hidden_effects_are_foreign() -> None:
    cells = [
        c
        for line in lines()
        for c in line.cells
        if c.kind in ("single", "pair", "switch", "unseen")
    ]
    foreign = [all(CATALOGUE[key].foreign for key in cell.hidden) for cell in cells]
    assert np.mean(foreign) > 0.5


def test_memories_start_rested_with_every_block() -> None:
    world = WORLDS["weights"].draw(np.random.default_rng(0), {})
    for key in ("hysteresis/bouc_wen", "creep/two_stage"):
        hidden = CATALOGUE[key].act(world, 0.1, np.random.default_rng(1))
        change: Array = (hidden.shown - world.shown)[world.fresh]
        assert np.abs(change).max() < 1e-12


@pytest.mark.parametrize("number", range(4))
def test_a_load_that_bypasses_a_foot_misses_all_its_cells_alike(number: int) -> None:
    """``F − s·max(F − F_touch, 0)`` is shared in proportion: no cell can have it alone."""
    found = drawn(Cell("single", "placements", ("load_bypass/table",), 1.0), 9800 + number)
    lost = 1.0 - found.world.shown / found.clean.shown
    assert lost.max() > 0.01
    np.testing.assert_allclose(lost, np.broadcast_to(lost[:, :1], lost.shape), atol=1e-9)


def test_switches_change_the_error_by_more_than_the_noise() -> None:
    for item in CATALOGUE.values():
        if not item.switch or item.untestable:
            continue
        for experiment in item.experiments:
            maker = WORLDS[experiment]
            world = maker.draw(np.random.default_rng(6), {})
            hidden = item.act(replace(world), item.guess, np.random.default_rng(2))
            assert yardstick(maker, world).rho(hidden) > 1.0, (item.key, experiment)


def _left_by(item: str, stick: Yardstick, world: World, place: int) -> Array:
    """What an effect at ρ 0.5 leaves, as one vector."""
    entry = CATALOGUE[item]
    _, hidden = size_for(
        0.5,
        lambda s: entry.act(world, s, np.random.default_rng(place)),
        stick,
        entry.guess,
        entry.most,
    )
    return stick.left(hidden).ravel()


@pytest.mark.parametrize(
    ("experiment", "first", "second", "places"),
    [
        ("weights", "dead_zone/soft", "hinge/soft", 12),
        ("walk", "delay/jittered", "lag/butterworth", 1),
        ("walk", "imu_tilt/belief", "accel_bias/belief", 20),
        ("walk", "accel_bias/belief", "com_offset/belief", 20),
        ("pose", "robot_weight/belief", "leg_weight/shoe", 1),
        ("pose", "case_strain/vertical", "scale_matrix/standing", 60),
    ],
)
def test_designed_aliases_leave_the_same_behind(
    experiment: str, first: str, second: str, places: int
) -> None:
    """|cos| > 0.95 at the best of some directions or shapes: such data do not separate them."""
    maker = WORLDS[experiment]
    world = maker.draw(np.random.default_rng(101), {"straight": True})
    stick = yardstick(maker, world)
    mine = _left_by(first, stick, world, 2)
    others = [_left_by(second, stick, world, place) for place in range(places)]
    cosines = [abs(mine @ o) / np.sqrt((mine @ mine) * (o @ o)) for o in others]
    assert max(cosines) > 0.95


def test_a_wandering_calibration_takes_in_what_a_walk_cannot_show() -> None:
    for seed in range(3):
        world = WORLDS["walk"].draw(np.random.default_rng(seed), {"drift": True})
        stick = yardstick(WORLDS["walk"], world)
        assert stick.follows is not None
        for item in switches_in("walk", untestable=True):
            hidden = item.act(world, item.guess, np.random.default_rng(1))
            assert np.abs(stick.influence(hidden)).max() > 0.1
            assert stick.rho(hidden) < 0.1


def test_following_the_calibration_absorbs_more_than_a_constant_one_does() -> None:
    world = WORLDS["walk"].draw(np.random.default_rng(3), {"drift": True})
    following = yardstick(WORLDS["walk"], world)
    constant = yardstick(WORLDS["walk"], replace(world, drift_per_root_s=(0.0, 0.0)))
    tug = CATALOGUE["unseen/cable_tug"].act(world, 0.15, np.random.default_rng(1))
    jitter = CATALOGUE["delay/jittered"].act(world, 0.004, np.random.default_rng(1))
    assert following.rho(tug) < 0.7 * constant.rho(tug)
    assert following.rho(jitter) == pytest.approx(constant.rho(jitter), rel=0.1)


@pytest.mark.parametrize("plan", ["fine_ladder", "taps"])
def test_a_proposed_bench_experiment_is_of_the_same_cells(plan: str) -> None:
    before = WORLDS["weights"].draw(np.random.default_rng(1), {})
    world = proposed(np.random.default_rng(2), plan, before, 3)
    assert world.channels == before.channels
    assert np.array_equal(world.scale, before.scale)
    assert world.row["load_n"].max() == pytest.approx(before.facts["full_n"], rel=1e-3)


def test_a_proposed_hanging_is_of_the_same_legs() -> None:
    before = WORLDS["pose"].draw(np.random.default_rng(6), {"blocks": 12})
    world = proposed(np.random.default_rng(2), "hang", before, 1)
    legs = before.facts["legs"]
    assert world.experiment == "hang"
    assert list(world.robot["legs"]) == legs["names"]
    of_leg = world.row["leg"].astype(int)
    assert np.array_equal(world.row["weight_n"], np.array(legs["weight_n"])[of_leg])
    # what is left of a leg without noise is its offset
    left = WORLDS["hang"].error(world)[of_leg == 2, 12:18]
    assert left == pytest.approx(np.broadcast_to(legs["offset"][2], left.shape), abs=1e-9)


@pytest.mark.parametrize(
    "plan",
    [
        "bounce",
        "turn_and_bounce",
        "walk_turning",
        "walk_squatting",
        "walk_slow_fast",
        "walk_unsmoothed",
        "stand_turned",
    ],
)
def test_a_proposed_motion_of_the_same_robot_balances(plan: str) -> None:
    before = WORLDS["walk"].draw(np.random.default_rng(4), {})
    world = proposed(np.random.default_rng(2), plan, before, 1)
    assert world.facts["mass_kg"] == before.facts["mass_kg"]
    assert np.array_equal(world.zero, before.zero)
    stick = yardstick(WORLDS[world.experiment], world)
    error = np.where(stick.valid, stick.clean_error, 0.0) / stick.noise
    assert np.sqrt(np.mean(error**2)) < 0.15


def test_every_injection_is_planned_and_a_full_run_hits_its_counts() -> None:
    whole = planned(ROUNDS)
    assert len({p.trial for p in whole}) == len(whole)
    first = Counter((p.choices[0].kind, p.choices[0].experiment, p.choices[0].rho) for p in whole)
    assert sum(n for (kind, _, _), n in first.items() if kind == "null") >= 200
    singles = [n for (kind, _, _), n in first.items() if kind == "single"]
    assert min(singles) >= 30
    keys = {key for p in whole for cell in p.choices for key in cell.hidden}
    assert keys == set(CATALOGUE)
    # a run in two parts is the run in one
    parts = {p.trial for p in (*planned(10), *planned(20, first_round=10))}
    assert parts == {p.trial for p in whole}
