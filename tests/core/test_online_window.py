"""The paper's window: its own cost minimised, and the same answer from sliding sums."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from footcal_cli.core.experiments.walk import reference_of
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.study.window import (
    Weights,
    WindowRule,
    run_window,
    run_window_fast,
    standing_weights,
)
from footcal_cli.errors import DataError
from tests.core.walk_data import Errors, Recording, make_walk, record
from tests.core.walking import belief_of, walk_log

RULE = WindowRule()


@pytest.fixture(scope="module")
def walk() -> tuple[Recording, Log, Belief]:
    recording = record(make_walk(0.04, 12.0, seed=6), Errors(quantum=0.1), seed=6)
    return recording, walk_log(recording), belief_of(recording)


def test_each_update_minimises_the_papers_cost(walk: tuple[Recording, Log, Belief]) -> None:
    _, log, belief = walk
    weights = Weights(4e4, 3e4, 2e3)
    track = run_window(log, belief, weights, WindowRule(iterations=12, largest_step=5.0))
    reference = reference_of(log)
    unit = np.concatenate([belief.gain_sd, belief.bias_sd_n])
    weight_n = float(log.known["mass_kg"][0] * 9.80665)
    for j in (80, 150):
        stop = int(track.last_sample[j]) + 1
        rows = np.arange(stop - RULE.samples, stop)
        before = np.concatenate([track.gain[j - 1, 0], track.bias_n[j - 1, 0]]) / unit

        def cost(
            theta: FloatArray, rows: np.ndarray = rows, before: FloatArray = before
        ) -> FloatArray:
            z = theta * unit
            force = belief.forces(log.readings[rows]) * (1 + z[:8]) + z[8:]
            total = force.sum(axis=1)
            cop = np.einsum("nc,nck->nk", force, log.known["cell_pos_m"][rows]) / total[:, None]
            return np.concatenate(
                [
                    np.sqrt(4e4) * (total - reference.fz_n[rows]) / weight_n,
                    (np.sqrt(3e4) * (cop - reference.cop_m[rows]) / RULE.foot_length_m).ravel(),
                    np.sqrt(2e3) * (theta - before),
                ]
            )

        best = least_squares(cost, before, xtol=1e-12, ftol=1e-12, gtol=1e-12).x
        ours = np.concatenate([track.gain[j, 0], track.bias_n[j, 0]]) / unit
        np.testing.assert_allclose(ours, best, atol=2e-4)


def test_sliding_sums_give_the_iterated_answer_within_two_percent(
    walk: tuple[Recording, Log, Belief],
) -> None:
    _, log, belief = walk
    weights = Weights(4e4, 3e4, 2e3)
    exact = run_window(log, belief, weights)
    fast = run_window_fast(log, belief, weights)
    for ours, theirs, sd in (
        (fast.gain, exact.gain, belief.gain_sd),
        (fast.bias_n, exact.bias_n, belief.bias_sd_n),
    ):
        assert np.sqrt(np.mean(((ours - theirs) / sd) ** 2)) < 0.02


def test_many_weights_in_one_pass_are_the_single_runs(
    walk: tuple[Recording, Log, Belief],
) -> None:
    _, log, belief = walk
    many = Weights(np.array([4e4, 1e4]), np.array([3e4, 9e4]), np.array([2e3, 5e2]))
    for run in (run_window, run_window_fast):
        together = run(log, belief, many)
        alone = run(log, belief, Weights(1e4, 9e4, 5e2))
        np.testing.assert_allclose(together.gain[:, 1], alone.gain[:, 0], atol=1e-10)


def test_steps_are_bounded(walk: tuple[Recording, Log, Belief]) -> None:
    _, log, belief = walk
    tight = WindowRule(iterations=3, largest_step=0.01)
    track = run_window(log, belief, Weights(1e6, 1e6, 1e-3), tight)
    step = np.abs(np.diff(track.bias_n[:, 0], axis=0)) / belief.bias_sd_n
    assert step.max() <= 0.03 + 1e-12


def test_weights_come_from_the_scatter_of_quiet_standing(
    walk: tuple[Recording, Log, Belief],
) -> None:
    _, log, belief = walk
    weights = standing_weights(log.rows(60, 150), belief, RULE)
    # 0.05 m/s² after 10 Hz on 5.4 kg, 0.1 N on eight cells: a quarter newton of 53
    assert 53.0 / np.sqrt(weights.force) == pytest.approx(0.25, abs=0.15)
    assert 160.0 / np.sqrt(weights.cop) == pytest.approx(1.0, abs=0.6)


def test_a_log_without_contact_is_refused(walk: tuple[Recording, Log, Belief]) -> None:
    _, log, belief = walk
    flying = log.with_known(contact=np.zeros_like(log.known["contact"]))
    with pytest.raises(DataError, match="no foot"):
        run_window(flying, belief, Weights(1.0, 1.0, 1.0))
