"""What bends with a recorded signal is seen in few stances; what does not is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core.diagnosis.curves import Curve, strongest_curve
from footcal_cli.core.diagnosis.detection import detect
from footcal_cli.core.diagnosis.engine import leftover
from footcal_cli.core.diagnosis.features import features_of
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.weighing import single_rows_p
from footcal_cli.core.inference.evidence import sign_patterns
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.scores import scores
from footcal_cli.core.parameters import FloatArray

STANCES = 24
NAMES = ("CoP ahead", "CoP beside", "load")


def stances(rng: np.random.Generator) -> dict[str, FloatArray]:
    return {name: np.repeat(rng.normal(size=STANCES), 3) for name in NAMES}


def standing(signals: dict[str, FloatArray], residual: FloatArray) -> Problem:
    """One row per stance and output; an offset and a gain per output are fitted."""
    block, output = np.repeat(np.arange(STANCES), 3), np.tile(np.arange(3), STANCES)
    load = np.eye(3)[output] * signals["load"][:, None]
    return Problem(
        residual=residual,
        calibration=np.hstack([np.eye(3)[output], load]),
        columns=np.empty((residual.size, 0)),
        signatures=(),
        block=block,
        output=output,
        sequence=output * STANCES + block,
        outputs=("fz", "mx", "my"),
        units=("N", "Nm", "Nm"),
        noise=np.ones(residual.size),
        tolerance=np.full(3, 0.1),
        regressors=signals,
    )


def found_in(problem: Problem) -> Curve:
    features = features_of(problem)
    grams, _ = whitened_grams(problem, features.columns)
    return strongest_curve(grams, features, grams.calibration, problem.residual.size)


@pytest.mark.slow
def test_noise_bends_with_nothing() -> None:
    rng = np.random.default_rng(1)
    p = np.array(
        [found_in(standing(stances(rng), rng.normal(size=3 * STANCES))).p for _ in range(300)]
    )
    # 15 of 300 expected below 0.05 at most
    assert np.sum(p < 0.05) <= stats.binom.ppf(0.999, 300, 0.05)
    assert np.sum(p < 0.5) > 60


def test_a_sole_that_rolls_over_its_edge_in_four_stances_is_seen() -> None:
    rng = np.random.default_rng(2)
    signals = stances(rng)
    ahead = signals["CoP ahead"]
    edge = np.clip(ahead - np.sort(ahead)[-15], 0.0, None)
    assert np.count_nonzero(edge[::3]) == 4
    noise = rng.normal(size=edge.size)
    problem = standing(signals, noise + 10.0 * edge * np.tile([1.0, 0.0, -0.7], STANCES))
    curve = found_in(problem)
    assert curve.name == "CoP ahead"
    assert curve.p < 1e-3
    assert 0.1 < curve.share < 0.95
    features = features_of(problem)
    grams, _ = whitened_grams(problem, features.columns)
    signs = sign_patterns(grams.blocks)
    seen = detect(problem, grams, features, grams.calibration, signs)
    assert leftover(seen, Rules())
    # sign flips alone cannot tell: too few stances carry it
    assert not leftover(replace(seen, curve=Curve()), Rules())


def test_noise_is_what_one_calibration_of_all_stances_leaves() -> None:
    """However far off the calibration was, and of each output apart."""
    rng = np.random.default_rng(4)
    size = np.array([1.0, 0.2, 3.0])
    found = []
    for _ in range(40):
        problem = standing(stances(rng), rng.normal(size=3 * STANCES) * np.tile(size, STANCES))
        off = problem.calibration @ rng.normal(0.0, 30.0, 6)
        found.append(replace(problem, residual=problem.residual + off).law.whitener.sd)
    assert np.sqrt(np.mean(np.square(found), axis=0)) == pytest.approx(size, rel=0.1)


def test_what_acts_in_four_stances_has_a_level_of_its_own() -> None:
    rng = np.random.default_rng(5)
    p = []
    for _ in range(200):
        signals = stances(rng)
        problem = standing(signals, rng.normal(size=3 * STANCES))
        edges = [np.clip(u - np.sort(u)[-15], 0.0, None) for u in signals.values()]
        grams, _ = whitened_grams(problem, np.stack(edges, axis=1))
        found = scores(grams.inner, grams.calibration, grams.features)
        p.append(single_rows_p(problem, found, grams.calibration.size))
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.03)
    assert np.mean(np.array(p) < 0.5) == pytest.approx(0.5, abs=0.1)


def test_units_and_what_is_fitted_change_nothing() -> None:
    rng = np.random.default_rng(3)
    signals = stances(rng)
    problem = standing(signals, rng.normal(size=3 * STANCES))
    loud = replace(problem, residual=7.0 * problem.residual)
    turned = replace(problem, calibration=problem.calibration @ rng.normal(size=(6, 6)))
    for other in (loud, turned):
        assert found_in(other).p == pytest.approx(found_in(problem).p, rel=1e-6)
    # a signal that is fitted already bends no more by its straight line
    line = replace(problem, residual=problem.residual + 50.0 * problem.calibration[:, 4])
    assert found_in(line).p > 0.01
