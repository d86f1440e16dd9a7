"""Sessions compared: against a published gauge study, and against series whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.fleet import Sessions, study
from footcal_cli.core.inference.repeated import (
    components_of,
    find_changes,
    level_of_sessions,
    outlying,
    segments_of,
    trend_of,
)

# AIAG, Measurement Systems Analysis, 4th edition (2010): 3 operators, 3 trials each, 10 parts
AIAG = np.array(
    [
        [0.29, -0.56, 1.34, 0.47, -0.80, 0.02, 0.59, -0.31, 2.26, -1.36],
        [0.41, -0.68, 1.17, 0.50, -0.92, -0.11, 0.75, -0.20, 1.99, -1.25],
        [0.64, -0.58, 1.27, 0.64, -0.84, -0.21, 0.66, -0.17, 2.01, -1.31],
        [0.08, -0.47, 1.19, 0.01, -0.56, -0.20, 0.47, -0.63, 1.80, -1.68],
        [0.25, -1.22, 0.94, 1.03, -1.20, 0.22, 0.55, 0.08, 2.12, -1.62],
        [0.07, -0.68, 1.34, 0.20, -1.28, 0.06, 0.83, -0.34, 2.19, -1.50],
        [0.04, -1.38, 0.88, 0.14, -1.46, -0.29, 0.02, -0.46, 1.77, -1.49],
        [-0.11, -1.13, 1.09, 0.20, -1.07, -0.67, 0.01, -0.56, 1.45, -1.77],
        [-0.15, -0.96, 0.67, 0.11, -1.45, -0.49, 0.21, -0.49, 1.87, -2.16],
    ]
)
PART = np.tile(np.arange(10), 9)
OPERATOR = np.repeat([0, 1, 2], 30)


def test_the_published_gauge_study_is_reproduced() -> None:
    """Printed variances: repeatability 0.03997, operator 0.05146, parts 1.08645."""
    found = components_of(AIAG.ravel(), {"robot": PART, "operator": OPERATOR})
    assert [c.name for c in found] == ["robot", "operator", "repeatability"]
    np.testing.assert_allclose([c.sd**2 for c in found], [1.08645, 0.05146, 0.03997], atol=1e-5)
    assert all(c.low < c.sd < c.high for c in found)


def test_intervals_of_components_hold_the_truth() -> None:
    rng, hits, runs = np.random.default_rng(3), np.zeros(2), 150
    robot = np.repeat(np.arange(6), 5)
    for _ in range(runs):
        values = rng.normal(0, 2.0, 6)[robot] + rng.normal(0, 0.5, robot.size)
        found = components_of(values, {"robot": robot})
        hits += [found[0].low < 2.0 < found[0].high, found[1].low < 0.5 < found[1].high]
    assert (hits / runs > 0.90).all()


def test_levels_cover_the_truth_with_and_without_spread() -> None:
    rng = np.random.default_rng(0)
    for tau in (0.0, 1.5):
        error = []
        for _ in range(300):
            sd = rng.uniform(0.5, 1.5, 10)
            level = level_of_sessions(rng.normal(3.0, np.hypot(sd, tau)), sd)
            error.append((level.value - 3.0) / level.sd)
        # Student's t on 9 dof has sd 1.13; the claimed sd is a floor, which makes it smaller
        assert 0.8 < np.std(error) < 1.25


@pytest.mark.parametrize("tau", [0.0, 1.0])
def test_a_quiet_series_is_left_alone(tau: float) -> None:
    rng, false = np.random.default_rng(1), np.zeros(3)
    for _ in range(200):
        n = int(rng.integers(6, 30))
        sd = rng.uniform(0.5, 1.5, n)
        values = rng.normal(0.0, np.hypot(sd, tau))
        trend = trend_of(np.arange(n, dtype=float), values, sd)
        assert trend is not None
        alone = outlying(values, sd, np.zeros(n, dtype=np.int64), alpha=0.05)
        false += [bool(find_changes(values, sd, alpha=0.05)), alone.min() < 0.05, trend.p < 0.05]
    assert (false / 200 < 0.09).all()  # 5 % and three sd of 200 draws


def test_a_step_is_found_where_it_is_and_as_large_as_it_is() -> None:
    rng, places, error = np.random.default_rng(2), [], []
    for _ in range(60):
        sd = np.full(24, 0.3)
        values = rng.normal(0.0, 0.4, 24) + 2.0 * (np.arange(24) >= 15)
        (change,) = find_changes(values, sd, alpha=1e-3)
        places.append(change.first_after)
        error.append((change.size - 2.0) / change.sd)
    assert np.median(places) == 15
    assert 0.8 < np.sqrt(np.mean(np.square(error))) < 1.3
    assert segments_of([change], 24).tolist().count(1) == 24 - change.first_after


def test_an_outlying_session_does_not_hide_another() -> None:
    rng = np.random.default_rng(4)
    values, sd = rng.normal(0.0, 0.2, 15), np.full(15, 0.2)
    values[[3, 9]] += 5.0
    p = outlying(values, sd, np.zeros(15, dtype=np.int64), alpha=0.01)
    assert np.flatnonzero(p < 0.01).tolist() == [3, 9]


def sessions_with(values: np.ndarray, robots: np.ndarray) -> Sessions:
    n = values.size
    return Sessions(
        names=np.array([f"s{i:02d}" for i in range(n)]),
        robot=robots,
        operator=np.full(n, ""),
        day=np.array([f"d{i:02d}" for i in range(n)]),
        time=np.arange(n, dtype=float),
        values={"left_fl.bias": values},
        sd={"left_fl.bias": np.full(n, 0.05)},
        units={"left_fl.bias": "N"},
    )


def test_a_jump_a_drift_and_a_stray_session_are_distinguished() -> None:
    rng = np.random.default_rng(6)
    k = np.arange(20)
    jumped = rng.normal(0, 0.05, 20) + 0.5 * (k >= 12)
    drifted = rng.normal(0, 0.05, 20) + 0.03 * k
    stray = rng.normal(0, 0.05, 20) + 1.0 * (k == 7)
    robots = np.repeat(["jumped", "drifted", "stray"], 20)
    fleet = study(sessions_with(np.concatenate([jumped, drifted, stray]), robots))
    by_robot = {one.robot: one for one in fleet.series}
    assert len(by_robot["jumped"].changes) == 1
    assert by_robot["drifted"].drifting
    assert by_robot["drifted"].trend is not None
    assert abs(by_robot["drifted"].trend.slope - 0.03) < 3 * by_robot["drifted"].trend.slope_sd
    assert not by_robot["stray"].proved
    assert fleet.outlying_sessions() == {"s47": ["left_fl.bias"]}
    (budget,) = fleet.budgets
    assert budget.sd_of("repeatability") == pytest.approx(0.05, rel=0.3)


def test_two_sessions_are_too_few_to_say_anything() -> None:
    fleet = study(sessions_with(np.array([0.0, 9.0]), np.array(["a", "a"])))
    assert not fleet.series[0].proved
    assert not fleet.outlying_sessions()
