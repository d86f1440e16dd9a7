"""Walks on simulated ankle transducers: offsets, delay, jumps and mass against the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from footcal_cli.core.contact import flicker, judge
from footcal_cli.core.log import Log
from footcal_cli.core.online import six_axis_replay
from footcal_cli.core.online.filter import WalkNoise
from footcal_cli.core.online.six_axis_replay import GUARDS, SixAxisReplay, replay_six_axis
from footcal_cli.core.online.streams import Merged
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import clock_of
from tests.core.ankle_walks import CHANNELS, ankle_walk
from tests.core.walking import turned_world


@dataclass(frozen=True)
class Walk:
    """A simulated walk, and the true values of the chain."""

    log: Log
    values: dict[str, float]

    @property
    def merged(self) -> Merged:
        log, clock = self.log, clock_of(self.log.time_s)
        return Merged(log, log.readings, judge({}, len(log)), clock, clock, 50.0, None, None)

    def replayed(self, *, scales: bool = False, **options: object) -> SixAxisReplay:
        return replay_six_axis(self.merged, samples_per_update=2, scales=scales, **options)  # type: ignore[arg-type]

    def scores(self, found: SixAxisReplay) -> FloatArray:
        """Errors of all estimates in units of their sd."""
        true = np.array([self.values.get(name, 0.0) for name in found.estimates.names])
        return np.asarray((found.estimates.values - true) / found.estimates.sd)


def walk(seed: int, duration_s: float = 24.0, **effects: dict[str, float]) -> Walk:
    """Offsets of tens of newtons, a calm walk, and effects by name with their parameters."""
    rng = np.random.default_rng(seed + 1000)
    offsets = {
        channel: float(rng.normal(0.0, 15.0 if channel.split(".")[1][0] == "f" else 1.0))
        for channel in CHANNELS
    }
    done, values = ankle_walk(seed, duration_s, offsets, effects)
    return Walk(done.log, values)


def test_errors_are_as_large_as_their_sd_and_innovations_as_claimed() -> None:
    scores, ratios = [], []
    for seed in (21, 22):
        made = walk(seed)
        found = made.replayed()
        scores.append(made.scores(found))
        ratios.append(found.consistency.ratio)
        assert not found.jumps
        assert max(found.repeated) < 2.0
    # forty-eight errors, those of one walk not independent of each other
    assert 0.75 < np.sqrt(np.mean(np.square(scores))) < 1.3
    assert np.max(np.abs(scores)) < 4.5
    assert ratios == pytest.approx([1.0] * 2, abs=0.1)


@pytest.mark.slow
def test_free_scales_do_not_shrink_with_the_noise() -> None:
    """Were the mass free as well, all forces and the mass would shrink together by 7 sd."""
    made = walk(23, duration_s=40.0)
    found = made.replayed(scales=True)
    scores = made.scores(found)
    scales = np.array([".scale_" in name for name in found.estimates.names])
    assert abs(np.mean(scores[scales])) < 1.0
    assert np.sqrt(np.mean(np.square(scores))) < 1.4
    assert found.estimates.sd[scales].min() >= 0.002  # as unsure as the mass


@pytest.mark.slow
def test_errors_are_as_large_as_their_sd_over_twenty_walks() -> None:
    scores = np.array([(made := walk(seed)).scores(made.replayed()) for seed in range(100, 120)])
    assert 0.9 < np.sqrt(np.mean(np.square(scores))) < 1.15
    assert 0.9 <= np.mean(np.abs(scores) < 1.96) <= 0.98


def test_a_delay_of_the_body_stream_is_found_with_its_sd() -> None:
    made = walk(31, 16.0, delay={"robot.delay": 0.03})
    found = made.replayed()
    assert found.delay_s == pytest.approx(0.03, abs=0.001)
    assert found.delay_sd_s < 0.001
    free = np.abs(made.scores(found))
    assert np.sqrt(np.mean(np.square(free))) < 1.6


@pytest.mark.slow
def test_totals_that_ask_for_different_delays_are_told_and_none_is_taken_out() -> None:
    made = walk(36)
    acc = made.log.known["com_acc_mps2"].copy()
    acc[:, 0], acc[:, 1] = np.roll(acc[:, 0], 4), np.roll(acc[:, 1], -4)  # 80 ms late, early
    found = Walk(made.log.with_known(com_acc_mps2=acc), made.values).replayed()
    assert not found.delay_found
    assert found.delay_asked_s[0] > 0.02
    assert found.delay_asked_s[1] < -0.02
    assert found.delay_s == 0.0


def test_a_jump_of_an_offset_is_alarmed_with_foot_axis_time_and_size() -> None:
    jump = {"left.offset_change_fz": 20.0, "left.change_time": 12.0}
    found = walk(32, offset_change=jump).replayed()
    (alarm,) = found.jumps
    assert alarm.name == "left.offset_fz"
    assert alarm.onset_s == pytest.approx(12.0, abs=0.2)
    assert alarm.found_s - 12.0 < 2.0
    assert abs(alarm.size - 20.0) < 4.0 * alarm.sd


def test_mass_that_the_model_lacks_is_found_beside_the_offsets() -> None:
    made = walk(33, 16.0, mass={"robot.mass_correction": 6.9})
    found = made.replayed()
    assert found.estimates["robot.mass_correction"] == pytest.approx(6.9, abs=0.15)
    assert np.abs(made.scores(found)[:12]).max() < 4.0


def test_an_update_that_teaches_nothing_changes_nothing() -> None:
    made = walk(34, duration_s=8.0)
    found = made.replayed(guards=replace(GUARDS, least_gain_nats=1e9))
    assert not found.track.used.any()
    assert found.estimates.values == pytest.approx(0.0)
    # nothing was learnt: the prior sd, and what the random walks have added to it since
    walked = np.array([n.rsplit(".", 1)[1].startswith("offset_f") for n in found.estimates.names])
    assert np.all(found.estimates.sd[walked] >= found.rows.prior_sd[walked])
    np.testing.assert_allclose(found.estimates.sd[~walked], found.rows.prior_sd[~walked], rtol=0.01)


@pytest.mark.slow
def test_a_wrong_model_gets_less_weight_until_the_innovations_fit() -> None:
    """The robot's forward motion is half invented; it repeats with the gait, unlike any noise."""
    made = walk(35)
    cycle = 2.0 * np.pi * made.log.time_s / 2.0  # two steps of a second
    invented = made.log.known["com_acc_mps2"].copy()
    invented[:, 0] += 0.5 * np.sin(cycle)
    wrong = Walk(made.log.with_known(com_acc_mps2=invented), made.values)
    found = wrong.replayed()
    assert found.consistency.ratio <= found.consistency.high
    assert found.repeated[0] > 2.0
    fx, fy = np.asarray(found.rows.total_sd_factor)[:2] * found.tuning.noise.force_slow_n
    assert fx > 1.3 * fy
    assert np.sqrt(np.mean(np.square(wrong.scores(found)[:12]))) < 1.5


def test_phases_of_one_sample_are_broken_readings_at_the_ends_of_a_log_too() -> None:
    force = np.full((400, 1), 700.0)
    force[100:150] = force[250:300] = 5.0
    force[120] = force[280] = 900.0
    force[399] = 4.0  # a swing of one sample at the end
    force[140] = -900.0  # no ground pulls
    found = flicker(force, 700.0, 50.0)
    assert np.flatnonzero(found[:, 0]).tolist() == [120, 140, 280, 399]


@pytest.mark.slow
def test_a_walk_s_calibration_does_not_depend_on_the_heading() -> None:
    made = walk(3, 16.0)
    elsewhere = replace(made, log=turned_world(made.log, -2.2, np.array([30.0, -70.0])))
    first, second = (one.replayed(scales=True).estimates for one in (made, elsewhere))
    assert first.names == second.names
    assert np.all(np.abs(second.values - first.values) < 1e-4 * first.sd)


def test_innovations_four_times_as_large_as_they_may_be_double_the_noise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ratios = iter([4.0, 1.0])
    monkeypatch.setattr(six_axis_replay, "run_filter", lambda _rows, noise, _guards: noise)
    monkeypatch.setattr(
        six_axis_replay, "check_consistency",
        lambda _track: SimpleNamespace(ratio=next(ratios), high=1.2),
    )  # fmt: skip
    noise = WalkNoise()
    larger, _, factor = six_axis_replay._consistent(cast(Any, None), noise, GUARDS)
    assert factor == 4.0
    for name in six_axis_replay._ROW_NOISE:
        np.testing.assert_allclose(getattr(larger, name), 2.0 * getattr(noise, name))
