"""Feet on six-axis transducers: rows against the balance, offsets and scales of a known walk."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.contact import cycle_phase, gait_cycles, judge
from footcal_cli.core.effects.body import heading_rad
from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.experiments import walk
from footcal_cli.core.log import Log
from footcal_cli.core.online.reference_states import advanced
from footcal_cli.core.online.rows import by_neighbours
from footcal_cli.core.online.six_axis import (
    KNOWN_MOTION,
    PRIOR_SD,
    shared_errors,
    six_axis_rows,
)
from footcal_cli.core.online.six_axis_replay import SixAxisReplay, replay_six_axis
from footcal_cli.core.online.streams import Merged
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import acceleration_of, clock_of
from footcal_cli.sheets.six_axis_walk import scales_gone, verdict_of
from tests.core.walk_data import G, make_walk

FEET = ("left", "right")
CHANNELS = tuple(f"{foot}.{axis}" for foot in FEET for axis in AXES)
OFFSETS = np.array([4.0, -6.0, 12.0, 0.4, -0.3, 0.2, -3.0, 5.0, -9.0, -0.5, 0.6, -0.1])


def six_axis_walk(
    seed: int, noise_n: float = 0.0, duration_s: float = 20.0
) -> tuple[Log, FloatArray]:
    """A pendulum's walk on ankles 5 cm up and turned; the log and its true wrenches (n, 12)."""
    motion = make_walk(0.1, duration_s, seed=seed)
    every = slice(None, None, 8)  # 50 Hz
    time = motion.time[every]
    n = len(time)
    rng = np.random.default_rng(seed)
    turned = Rotation.from_euler("xyz", [[0.1, 0.0, 0.2], [-0.1, 0.05, 0.0]]).as_matrix()
    rot = np.tile(turned, (n, 1, 1, 1))
    pos = np.concatenate([motion.feet[every], np.full((n, 2, 1), 0.05)], axis=2)
    weight, com_below = np.array([2.0, 2.5]), np.array([[0.01, 0.0, -0.02], [0.0, 0.005, -0.02]])
    # the ground also pushes sideways, in proportion to each foot's load
    load = np.stack([motion.force[every, :4].sum(axis=1), motion.force[every, 4:].sum(axis=1)], 1)
    share = load / load.sum(axis=1, keepdims=True)
    sideways = motion.mass * motion.acc[every, :2]
    cells = motion.cells[every]
    force = np.concatenate([share[:, :, None] * sideways[:, None], load[:, :, None]], axis=2)
    moment = np.zeros((n, 2, 3))
    for k in range(2):
        columns = slice(4 * k, 4 * k + 4)
        up = np.zeros((n, 4, 3))
        up[:, :, 2] = motion.force[every, columns]
        arm = np.concatenate([cells[:, columns], np.zeros((n, 4, 1))], axis=2) - pos[:, k, None]
        moment[:, k] = np.cross(arm, up).sum(axis=1)
        # sideways force acts at the ground below the ankle
        moment[:, k] += np.cross([0.0, 0.0, -0.05], force[:, k] * [1.0, 1.0, 0.0])
    known = {
        "com_m": motion.com[every],
        "com_acc_mps2": motion.acc[every],
        "angmom_rate_nm": motion.angmom_rate[every],
        "mass_kg": np.full(n, motion.mass),
        "gravity_mps2": np.full(n, G),
        "foot_yaw_rad": motion.yaw[every],
        "contact": np.where(load > 1e-9, 1.0, 0.0),
        "foot_rot_wt": rot,
        "foot_pos_m": pos,
        "foot_weight_n": np.tile(weight, (n, 1)),
        "foot_com_m": np.tile(com_below, (n, 1, 1)),
        "foot_acc_mps2": acceleration_of(pos, time),
    }
    back = rot.transpose(0, 1, 3, 2)
    wrench = np.concatenate(
        [np.einsum("nkij,nkj->nki", back, force), np.einsum("nkij,nkj->nki", back, moment)], axis=2
    )
    below = Log("walk", CHANNELS, time, np.zeros((n, 12)), known, np.zeros(n, dtype=np.int64))
    true = (wrench + walk.applied_below(below, known["foot_weight_n"])).reshape(n, 12)
    sd = noise_n * np.tile([1.0, 1.0, 1.0, 0.05, 0.05, 0.05], 2)
    seen = true + OFFSETS + rng.normal(size=true.shape) * sd
    return Log("walk", CHANNELS, time, seen, known, np.zeros(n, dtype=np.int64)), true


def as_merged(log: Log) -> Merged:
    clock = clock_of(log.time_s)
    return Merged(log, log.readings, judge({}, len(log)), clock, clock, 50.0, None, None)


@cache
def replayed(seed: int, *, scales: bool | None = None, shaken: bool = False) -> SixAxisReplay:
    """A walk with noise of 0.5 N, whose acceleration tells little where it is shaken."""
    log, _ = six_axis_walk(seed, 0.5, 14.0)
    if shaken:
        noise = np.random.default_rng(0).normal(0.0, 1.0, (len(log), 3))
        log = log.with_known(com_acc_mps2=log.known["com_acc_mps2"] + noise)
    return replay_six_axis(as_merged(log), samples_per_update=2, scales=scales)


def test_the_true_wrenches_balance_the_motion() -> None:
    log, true = six_axis_walk(1)
    balance = walk.EXPERIMENT.balance(log.with_readings(true))
    assert balance.outputs[:5] == ("fx", "fy", "fz", "mx", "my")
    middle = slice(20, -20)
    worst = np.abs(np.where(balance.valid, balance.error, 0.0))[middle].max(axis=0)
    # horizontal forces balance but for the moment they were not given: all to the last digit
    assert worst[:3].max() < 1e-6
    assert worst[5:].max() < 1e-9
    assert worst[3:5].max() < 1e-6
    assert balance.valid[:, 5:].any()


def test_every_column_is_what_its_unknown_does_to_the_balance() -> None:
    log, _ = six_axis_walk(2)
    rows = six_axis_rows(log, samples_per_update=1)
    base = walk.six_axis_balance(log)
    yaw = heading_rad(log)

    def along(error: FloatArray) -> FloatArray:
        """The rows (fx, fy) and (mx, my) along and across the heading."""
        turned = error.copy()
        for x in (0, 3):
            vector = (error[:, x] + 1j * error[:, x + 1]) * np.exp(-1j * yaw)
            turned[:, x], turned[:, x + 1] = vector.real, vector.imag
        return turned

    np.testing.assert_allclose(rows.error[rows.valid], along(base.error)[base.valid], atol=1e-9)
    step = 1e-4
    both = [*rows.names, "robot.mass_correction"]  # scales and the mass are never free together
    with_mass = six_axis_rows(log, samples_per_update=1, scales=False, mass=True)
    for name in both:
        of = rows if name in rows.names else with_mass
        i = of.names.index(name)
        owner, kind = name.split(".")
        readings, known = log.readings.copy(), dict(log.known)
        start = base
        if kind.startswith("scale"):  # as the neighbouring blocks read: their noise is another one
            readings = by_neighbours(readings, 1)
            start = walk.six_axis_balance(log.with_readings(readings))
        if kind.startswith("offset"):
            readings[:, CHANNELS.index(f"{owner}.{kind[-2:]}")] -= step
        elif kind.startswith("scale"):
            readings[:, CHANNELS.index(f"{owner}.{kind[-2:]}")] *= 1 + step
        elif kind == "mass_correction":
            # through gravity alone: the measured acceleration is noisy and would pull it down
            assert np.all(of.h[:, 2, i] == -log.known["gravity_mps2"] * of.prior_sd[i])
            assert not np.delete(of.h[:, :, i], 2, axis=1).any()
            continue
        elif kind == "weight":
            known["foot_weight_n"] = known["foot_weight_n"].copy()
            known["foot_weight_n"][:, FEET.index(owner)] += step
        elif kind.startswith("com_below"):
            known["foot_com_m"] = known["foot_com_m"].copy()
            known["foot_com_m"][:, FEET.index(owner), "xyz".index(kind[-1])] += step
        elif kind.startswith("com_correction"):
            known["com_m"] = known["com_m"].copy()
            angle = yaw + (kind[-1] == "y") * np.pi / 2
            known["com_m"][:, :2] += step * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        elif kind.startswith("motion_size"):
            acc = known["com_acc_mps2"].copy()
            ahead = np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
            axis = ahead if kind[-1] == "x" else np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
            pushed = by_neighbours(acc, 1)[:, :2]  # as scales have it
            acc[:, :2] += step * axis * np.einsum("ni,ni->n", axis, pushed)[:, None]
            known["com_acc_mps2"] = acc
        elif kind == "angmom_loss":
            continue  # of the part that repeats: the next test
        else:
            assert name == "robot.delay"
            known = dict(advanced(log, step).known)
        moved = walk.six_axis_balance(log.with_readings(readings).with_known(**known))
        change = along(moved.error - start.error) / step * rows.prior_sd[i]
        if kind.startswith("scale"):  # of a foot in the air not its own, noisy reading
            change[:, rows.totals :] = rows.h[:, rows.totals :, i]
        # the moment of inertia forces about a moved CoM is left to the reference
        tolerance = 0.15 if kind.startswith("com_corr") else 0.1 if kind == "delay" else 1e-6
        if kind.startswith("motion_size"):  # from the forces measured, with their noise
            tolerance = 0.1
        size = max(np.abs(change[rows.valid]).max(), 1e-12)
        assert np.abs(rows.h[:, :, i] - change)[rows.valid].max() < tolerance * size, name


def test_the_column_of_the_momentum_is_what_repeats_with_the_gait() -> None:
    """Noise of a differentiated stream stands in the error, too, and would pull its size to −1."""
    log, _ = six_axis_walk(2)
    phase = cycle_phase(log.known["contact"])
    inside = np.isfinite(phase)
    turn = np.exp(1j * heading_rad(log))
    along = turn * np.exp(2j * np.pi * np.where(inside, phase, 0.0))
    momentum = np.stack([along.real, along.imag], axis=1)
    noise = np.random.default_rng(0).normal(0.0, 1.0, momentum.shape)
    columns = []
    for shown in (momentum, momentum + noise):
        rows = six_axis_rows(log.with_known(angmom_rate_nm=shown), samples_per_update=1)
        at = rows.names.index("robot.angmom_loss")
        columns.append(rows.h[:, 3:5, at] / rows.prior_sd[at])
    use = rows.valid[:, 3] & inside
    assert use.sum() > 300
    cycles = gait_cycles(log.known["contact"]).max()
    # forty bins a cycle: within one, the direction turns by a fortieth
    assert np.abs(columns[0] + momentum)[use].max() < 2.0 * np.pi / 40
    kept = np.sqrt(np.mean((columns[1] - columns[0])[use] ** 2))
    assert kept == pytest.approx(1.0 / np.sqrt(cycles), rel=0.3)


def test_the_columns_of_scales_in_the_air_carry_no_noise() -> None:
    """A scale regressed on a noisy reading is pulled towards −1 by the noise that both hold."""
    log, _ = six_axis_walk(2)
    noise = np.random.default_rng(0).normal(0.0, 0.5, log.readings.shape)
    clean, noisy = (
        six_axis_rows(one, samples_per_update=1)
        for one in (log, log.with_readings(log.readings + noise))
    )
    for i in (i for i, name in enumerate(clean.names) if ".scale_" in name):
        both = (clean.h[:, clean.totals :, i], noisy.h[:, clean.totals :, i])
        change = (both[1] - both[0])[clean.valid[:, clean.totals :]] / clean.prior_sd[i]
        assert np.ptp(change[change != 0.0]) < 1e-9  # one median a foot and axis
        assert np.abs(change).max() < 0.1


@pytest.mark.parametrize("seeds", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_offsets_of_both_feet_are_found_with_honest_intervals(seeds: int) -> None:
    scores = []
    for seed in range(seeds):
        found = replayed(seed, scales=False)
        at = [found.estimates.names.index(f"{c.split('.')[0]}.offset_{c.split('.')[1]}")
              for c in CHANNELS]  # fmt: skip
        off = found.estimates.values[at] - OFFSETS
        assert np.abs(off[[0, 1, 2, 6, 7, 8]]).max() < 0.5
        scores.append(off / found.estimates.sd[at])
        assert found.after[:, 2][np.isfinite(found.after[:, 2])].std() < 1.5
    assert 0.3 < np.sqrt(np.mean(np.square(scores))) < 1.8


def test_scales_are_left_alone_where_the_motion_tells_too_little() -> None:
    assert not any("scale" in n for n in replayed(0, shaken=True).rows.names)
    good = replayed(0)
    names = [n for n in good.rows.names if "scale" in n]
    assert len(names) == 12
    vertical = [good.estimates["left.scale_fz"], good.estimates["right.scale_fz"]]
    assert vertical == pytest.approx([0.0, 0.0], abs=0.05)


def test_scales_that_are_off_are_no_poor_motion() -> None:
    """Vertical scales 8 % apart leave 2 N of 53 N: a motion that is good to 2 % seemed worse."""
    log, _ = six_axis_walk(0, 0.2, 14.0)
    gains = np.random.default_rng(4).normal(0.0, 0.02, 12)
    gains[[2, 8]] = 0.05, -0.03
    found = replay_six_axis(as_merged(log.with_readings(log.readings / (1.0 + gains))),
                            samples_per_update=2)  # fmt: skip
    for foot, true in zip(FEET, gains[[2, 8]], strict=True):
        at = found.estimates.names.index(f"{foot}.scale_fz")
        assert found.estimates.values[at] == pytest.approx(true, abs=0.01)
        assert abs(found.estimates.values[at] - true) < 3.0 * found.estimates.sd[at]
    assert found.demand_sd_n < 0.02 * 53.0


def test_offsets_are_as_unsure_as_scales_that_were_left_alone() -> None:
    """Said to be exact they are; else an offset of 12 N is one of 12 N ± 3 %."""
    left, exact = (replayed(0, scales=asked, shaken=True).estimates for asked in (None, False))
    assert left.names == exact.names
    at = left.names.index("left.offset_fz")
    assert left.values[at] == exact.values[at]
    more = np.sqrt(left.covariance[at, at] - exact.covariance[at, at])
    assert more == pytest.approx(0.03 * abs(left.values[at]), rel=0.05)


def test_a_scale_of_all_feet_and_a_motion_of_another_size_are_one_thing() -> None:
    """Their columns are opposite, so that the priors share out what both could be."""
    log, _ = six_axis_walk(0, noise_n=0.5)
    light = log.with_known(foot_weight_n=np.zeros_like(log.known["foot_weight_n"]))
    rows = six_axis_rows(light, samples_per_update=2)
    at = {name: i for i, name in enumerate(rows.names)}
    scales = [at[f"{foot}.scale_f{axis}"] for foot in FEET for axis in "xyz"]
    for axis, row in (("x", 0), ("y", 1)):
        motion = at[f"robot.motion_size_{axis}"]
        use = rows.valid[:, row]
        by_feet = (rows.h[use][:, row, scales] / rows.prior_sd[scales]).sum(axis=1)
        by_motion = rows.h[use, row, motion] / rows.prior_sd[motion]
        apart = by_feet - by_feet.mean() + by_motion - by_motion.mean()
        assert np.std(apart) < 0.02 * np.std(by_feet)
    found = replayed(0)
    shared = PRIOR_SD["scale"][1] / np.sqrt(len(FEET))
    sd = shared * KNOWN_MOTION / np.hypot(shared, KNOWN_MOTION)  # if only priors tell them apart
    for foot in FEET:  # turned by 0.1 rad to 0.2 rad, so that the weight knows a part of it
        assert found.track.sd[-1, found.track.names.index(f"{foot}.scale_fx")] > 0.6 * sd


@pytest.mark.slow
def test_noise_does_not_pull_scales_of_axes_that_hardly_feel_anything() -> None:
    """Half a newton of noise on pushes of one newton: −0.16 ± 0.02 by the block's own reading."""
    scores = []
    for seed in range(3):
        found = replayed(seed)
        assert scales_gone(found.track, found.rows.prior_sd) == ()
        at = [i for i, name in enumerate(found.track.names) if ".scale_" in name]
        scores.append(found.track.values[-1, at] / found.track.sd[-1, at])
    assert len(scores[0]) == 12
    assert 0.5 < np.sqrt(np.mean(np.square(scores))) < 1.5


def test_a_scale_that_no_transducer_has_is_not_called_good() -> None:
    """One axis that reads a fifth too little: found, and more than three prior sd away."""
    log, _ = six_axis_walk(0, 0.1, 14.0)
    readings = log.readings.copy()
    readings[:, CHANNELS.index("left.fx")] /= 1.2
    found = replay_six_axis(as_merged(log.with_readings(readings)), samples_per_update=2)
    assert scales_gone(found.track, found.rows.prior_sd) == ("left.scale_fx",)
    verdict = verdict_of(found)
    assert verdict.level == "warning"
    assert any("left.scale_fx" in action for action in verdict.actions)


def test_a_wrong_mass_moves_all_estimates_along_what_they_share() -> None:
    """Masses, weights and momentum off by a share: scales and offsets are off by that share."""
    log, _ = six_axis_walk(0, noise_n=0.1)
    share = 0.002
    heavy = log.with_known(
        **{
            name: (1.0 + share) * log.known[name]
            for name in ("mass_kg", "angmom_rate_nm", "foot_weight_n")
        }
    )
    rows, moved = (six_axis_rows(one, samples_per_update=1) for one in (log, heavy))
    z = np.zeros(len(rows.names))
    offsets = [rows.names.index(f"{c.replace('.', '.offset_')}") for c in CHANNELS]
    z[offsets] = OFFSETS / rows.prior_sd[offsets]
    along = shared_errors(log, rows.names, z * rows.prior_sd)[0] / rows.prior_sd
    before = (rows.error + rows.h @ z)[rows.valid]
    after = (moved.error + rows.h @ (z + along))[rows.valid]
    only_mass = (moved.error + rows.h @ z)[rows.valid]
    assert np.abs(only_mass - before).max() > 0.05
    # what is off by a share are the errors themselves, the noise in the air, and what a block
    # reads other than its neighbours
    other = np.nanmax(np.abs(log.readings - by_neighbours(log.readings, 1)))
    assert np.abs(after - before).max() < 2 * share * (np.abs(before).max() + other) + 1e-9


def test_without_a_rate_of_angular_momentum_its_share_of_the_moment_is_a_state() -> None:
    """A body whose limbs swing as it is pushed: L̇ in proportion to the moment of the force."""
    log, true = six_axis_walk(0)
    acc, height = by_neighbours(log.known["com_acc_mps2"], 1), log.known["com_m"][:, 2]
    share = np.array([0.3, -0.2])
    pull = log.known["mass_kg"][:, None] * acc[:, :2] * share * height[:, None]
    momentum = np.stack([-pull[:, 1], pull[:, 0]], axis=1)
    limbs = log.with_readings(true).with_known(angmom_rate_nm=momentum)
    unknown = limbs.with_known(angmom_rate_nm=np.zeros_like(momentum))
    rows = six_axis_rows(unknown, samples_per_update=1)
    z = np.zeros(len(rows.names))
    for axis, value in zip("xy", share, strict=True):
        at = rows.names.index(f"robot.angmom_share_{axis}")
        z[at] = value / rows.prior_sd[at]
    expected = walk.six_axis_balance(limbs).error[:, 3:5]
    found = (rows.error + rows.h @ z)[:, 3:5]
    use = rows.valid[:, 3:5]
    change = np.abs(expected - rows.error[:, 3:5])[use].max()
    assert np.abs(found - expected)[use].max() < 0.1 * change
