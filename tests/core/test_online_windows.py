"""The papers' two methods on a walk: weights of their own, no help, and ε of the CoP everywhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.experiments import walk as walking
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.comparison import ReplaySettings, compare
from footcal_cli.core.online.evidence import rms
from footcal_cli.core.online.memory import MemoryOptions
from footcal_cli.core.online.merging import merge_cells
from footcal_cli.core.online.replay import errors_against
from footcal_cli.core.online.streams import BodyStream, MergeRule, SensorStream
from footcal_cli.core.study.walk import PaperMethods
from footcal_cli.core.study.window import WindowRule
from footcal_cli.core.study.windows import GivenWeights, run_windows, standing_start
from tests.core.walk_data import CELLS_FOOT, CHANNELS, Errors, G, Recording, make_walk, record
from tests.core.walking import belief_of, walk_log

BOTH = ("window", "static")


@pytest.fixture(scope="module")
def made() -> Recording:
    return record(make_walk(0.04, 12.0, seed=5), Errors(quantum=0.25), seed=5)


@pytest.fixture(scope="module")
def walk(made: Recording) -> tuple[Log, Belief]:
    return walk_log(made), belief_of(made)


def test_each_method_has_the_weight_that_predicts_best_for_itself(
    walk: tuple[Log, Belief],
) -> None:
    log, belief = walk
    rule, demand = WindowRule(), walking.reference_of(log)
    own = run_windows(log, belief, BOTH, rule, GivenWeights())
    smooth = float(np.asarray(own["window"].weights.smooth))
    same = run_windows(log, belief, BOTH, rule, GivenWeights(smooth=smooth))
    own_error, same_error = (
        rms(errors_against(found["static"].replayed, demand).cop_m) for found in (own, same)
    )
    # a static robot is believed by far too much at the weight that suits the moving one
    assert own_error < 0.5 * same_error
    assert float(np.asarray(own["static"].weights.smooth)) > smooth


def test_without_standing_there_are_no_weights_unless_they_are_given(
    walk: tuple[Log, Belief],
) -> None:
    log, belief = walk
    found = standing_start(log)
    assert found is not None
    moving = log.rows(found[1], len(log))
    assert standing_start(moving) is None
    assert run_windows(moving, belief, BOTH, WindowRule(), GivenWeights()) == {}
    given = GivenWeights(1e4, 1e4, 1e3)
    done = run_windows(moving, belief, BOTH, WindowRule(), given)
    assert set(done) == set(BOTH)
    assert done["window"].weights.force == 1e4


def test_the_smallest_force_reaches_every_cop(made: Recording) -> None:
    belief = belief_of(made)
    body = BodyStream(
        made.body_time, made.com, made.acc, made.angmom_rate,
        np.concatenate([made.feet, np.zeros((*made.feet.shape[:2], 1))], axis=2), made.yaw,
    )  # fmt: skip
    least_n = 35.0  # more than a foot carries in double support
    rule = MergeRule(delay_s=0.0, min_force_n=least_n)
    merged = merge_cells(
        SensorStream(made.cell_time, made.counts, CHANNELS), body, belief, (CELLS_FOOT,) * 2,
        made.mass, G, rule=rule,
    )  # fmt: skip
    settings = ReplaySettings(memory=MemoryOptions(learnt=(), align=False), min_force_n=least_n)
    rule_of_window = WindowRule(min_force_n=least_n)
    papers = PaperMethods.run(merged.log, belief, BOTH, rule_of_window, GivenWeights())
    rng = np.random.default_rng(0)
    found = compare(merged, belief, settings, truth_n=made.force, others=papers.replayed, rng=rng)
    assert set(found.replayed) == {"before", *BOTH, "memory", "smoother", "true"}
    for one in found.replayed.values():
        for pressure in (one.total, *one.feet):
            known = np.isfinite(pressure.cop_m).all(axis=1)
            assert known.any()
            assert (pressure.fz_n[known] > least_n).all()
        light = one.feet[0].fz_n < least_n
        assert (light & (one.feet[0].fz_n > 5.0)).any()


def test_a_cop_below_the_smallest_force_teaches_the_window_nothing(
    walk: tuple[Log, Belief],
) -> None:
    log, belief = walk
    weights = GivenWeights(1e-6, 1e6, 1e-3)
    deaf = replace(WindowRule(), min_force_n=1e3)
    found = run_windows(log, belief, ("window",), deaf, weights)["window"]
    heard = run_windows(log, belief, ("window",), WindowRule(), weights)["window"]
    assert np.abs(found.replayed.gain).max() < 1e-3 < np.abs(heard.replayed.gain).max()
