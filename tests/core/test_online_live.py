"""Live: what a robot could have known at the time, and nothing else."""

from __future__ import annotations

import json
import runpy
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.core.contact import airborne_now, contact_now, detect_contact
from footcal_cli.core.log import Log
from footcal_cli.core.online.estimator import LiveEstimator
from footcal_cli.core.online.evidence import rms
from footcal_cli.core.online.feed import LiveFeed, RobotFacts
from footcal_cli.core.online.live import FIRST_LEARNING_S, run_live
from footcal_cli.core.online.memory import replay_track, run_memory
from footcal_cli.core.online.merging import merge_cells
from footcal_cli.core.online.replay import corrected, errors_against
from footcal_cli.core.online.streams import BodyStream, MergeRule, SensorStream
from footcal_cli.core.signals import low_pass
from tests.core.walk_data import (
    CELLS_FOOT,
    CHANNELS,
    Errors,
    G,
    Recording,
    make_walk,
    record,
)
from tests.core.walking import belief_of, walk_log

ERRORS = Errors(bias_walk=0.03, gain_walk=4e-4, quantum=0.25, delay=0.004, com_offset=(0.003, 0.0))


@pytest.fixture(scope="module")
def walk() -> Recording:
    return record(make_walk(0.04, 25.0, seed=6), ERRORS, seed=6)


@pytest.mark.slow
def test_what_comes_later_does_not_change_what_was_said(walk: Recording) -> None:
    log, belief = walk_log(walk, causal=True), belief_of(walk)
    whole = run_live(log, belief).track
    part = run_live(log.rows(0, 1440), belief).track
    # the delay in force at the end differs: it is told apart from the state
    kept = [i for i, name in enumerate(part.names) if name != "robot.delay"]
    assert part.names == whole.names
    # up to where the body's stream, moved by the delay found, breaks off
    u = len(part.time_s) - 4
    assert part.time_s[u] > 2 * FIRST_LEARNING_S
    np.testing.assert_allclose(part.values[:u, kept], whole.values[:u, kept], atol=1e-12)
    np.testing.assert_allclose(part.sd[:u, kept], whole.sd[:u, kept], rtol=1e-9)


@pytest.mark.slow
def test_live_is_nearly_as_good_as_after_the_fact(walk: Recording) -> None:
    log, belief = walk_log(walk, causal=True), belief_of(walk)
    memory = run_live(log, belief)
    filtered = low_pass(walk.force, 80.0, causal=True)
    nothing = np.zeros(filtered.shape)
    truth = corrected("truth", memory.log, belief, nothing, filtered - belief.forces(log.readings))
    late = walk.cell_time > 10.0
    found = errors_against(replay_track("memory", memory, memory.track, belief), truth)
    hindsight = run_memory(walk_log(walk), belief)
    seen = corrected(
        "truth", hindsight.log, belief, nothing,
        low_pass(walk.force, 80.0) - belief.forces(hindsight.log.readings),
    )  # fmt: skip
    best = errors_against(replay_track("memory", hindsight, hindsight.track, belief), seen)
    assert rms(found.cop_m[late]) < 1.4 * rms(best.cop_m[late])
    assert memory.delay_s == pytest.approx(0.004, abs=0.002)


def test_contact_is_told_from_the_past_alone(walk: Recording) -> None:
    force = low_pass(walk.counts, 80.0, causal=True) * walk.scale0 + walk.bias0
    per_foot = np.stack([force[:, :4].sum(axis=1), force[:, 4:].sum(axis=1)], axis=1)
    told = contact_now(per_foot, 53.0, 80.0)
    np.testing.assert_array_equal(contact_now(per_foot[:900], 53.0, 80.0), told[:900])
    hanging = airborne_now(per_foot, 53.0)
    np.testing.assert_array_equal(airborne_now(per_foot[:900], 53.0), hanging[:900])
    np.testing.assert_array_equal(hanging[told == 0.0], 1.0)
    hindsight = detect_contact(per_foot, 53.0, 80.0)
    both = np.isfinite(told) & np.isfinite(hindsight)
    assert np.mean(told[both] == hindsight[both]) > 0.995
    assert np.mean(told == 0.0) > 0.6 * np.mean(hindsight == 0.0)
    lost = per_foot.copy()
    lost[500:510] = np.nan
    assert np.isnan(contact_now(lost, 53.0, 80.0)[500:510]).all()


def test_a_plate_is_found_live() -> None:
    heavy = record(make_walk(0.04, 20.0, seed=7), replace(ERRORS, plate=1.5), seed=7)
    memory = run_live(walk_log(heavy, causal=True), belief_of(heavy))
    at = memory.track.names.index("left.plate_weight")
    assert memory.track.values[-1, at] == pytest.approx(1.5, abs=0.6)


def test_sample_by_sample_is_the_same_run() -> None:
    jumped = record(make_walk(0.04, 20.0, seed=8), replace(ERRORS, jumps=((2, 12.0, 1.5),)), seed=8)
    log, belief = walk_log(jumped, causal=True), belief_of(jumped)
    whole = run_live(log, belief).track
    assert whole.jumps, "one is there to be found"
    estimator = LiveEstimator(belief)
    updates = []
    for i in range(len(log)):
        updates += estimator.push(log.rows(i, i + 1))
    late = len(whole.time_s) - len(updates)
    assert 0 <= late <= 3
    updates += estimator.finish()
    np.testing.assert_array_equal([u.time_s for u in updates], whole.time_s)
    delays = np.array([u.delay_s for u in updates])
    assert len(set(delays)) >= 2, "learnt once or more"
    for jump in whole.jumps:
        then = next(u for u in updates if u.time_s >= jump.found_s)
        assert (jump.name, jump.onset_s) in {(j.name, j.onset_s) for j in then.jumps}
    for name in whole.names:
        at = whole.names.index(name)
        has = np.array([name in u.names for u in updates])
        known = [(u.values, u.sd, u.names.index(name)) for u in updates if name in u.names]
        values = np.array([value[i] for value, _, i in known])
        sds = np.array([sd[i] for _, sd, i in known])
        said = values + (delays[has] - delays[-1] if name == "robot.delay" else 0.0)
        np.testing.assert_allclose(said, whole.values[has, at], rtol=0, atol=1e-9)
        np.testing.assert_allclose(sds, whole.sd[has, at], rtol=1e-9, atol=1e-9)


def test_what_arrives_in_pieces_is_merged_as_the_whole(walk: Recording) -> None:
    belief, n = belief_of(walk), 700
    sensors = SensorStream(walk.cell_time, walk.counts, CHANNELS)
    height = np.zeros((*walk.feet.shape[:2], 1))
    body = BodyStream(
        walk.body_time, walk.com, walk.acc, walk.angmom_rate,
        np.concatenate([walk.feet, height], axis=2), walk.yaw,
    )  # fmt: skip
    robot = RobotFacts(belief, (CELLS_FOOT,) * 2, walk.mass, G)
    whole = merge_cells(
        sensors, body, belief, robot.cells_foot_m, walk.mass, G, rule=MergeRule(causal=True)
    ).log
    feed = LiveFeed(robot)
    rows: list[Log] = []
    for start in range(0, n, 20):
        now = walk.cell_time[start + 19]
        behind, until = np.searchsorted(walk.body_time, [walk.cell_time[start - 1], now])
        part = slice(0 if start == 0 else behind, until)
        arrived = {
            f.name: getattr(body, f.name)[part]
            for f in fields(body) if getattr(body, f.name) is not None
        }  # fmt: skip
        rows.append(feed.push(
            SensorStream(walk.cell_time[start : start + 20], walk.counts[start : start + 20],
                         CHANNELS),
            BodyStream(**arrived),
        ))  # fmt: skip
    times = np.concatenate([r.time_s for r in rows])
    assert times.size > n - 30
    np.testing.assert_array_equal(times, whole.time_s[: times.size])
    for name in ("com_m", "com_acc_mps2", "cell_pos_m", "contact", "airborne"):
        got = np.concatenate([r.known[name] for r in rows if len(r)])
        np.testing.assert_allclose(got, whole.known[name][: times.size], rtol=0, atol=1e-9)
    got = np.concatenate([r.readings for r in rows])
    np.testing.assert_allclose(got, whole.readings[: times.size], rtol=1e-9, atol=1e-9)


def test_the_example_walks(repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    namespace = runpy.run_path(str(repository / "sample_data" / "live_walk.py"))
    namespace["main"](4.2)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    truth = json.loads((repository / "sample_data/biped/walk_002_truth.json").read_text())
    truth = truth["parameters"]
    zero = namespace["ZERO_COUNTS"]
    for word, name in zip(lines[-1].split()[2:], namespace["CHANNELS"], strict=True):
        value, sd = map(float, word.split("±"))
        # what the true cell shows where the data sheet has no load
        assert abs(value - (truth[f"{name}.bias"] + truth[f"{name}.scale"] * zero)) < 4 * sd
