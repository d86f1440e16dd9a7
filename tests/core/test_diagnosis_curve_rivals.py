"""Curves that look alike: knees against smooth ones, and what tells a form from another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.field import white_loss
from footcal_cli.core.diagnosis.investigation import investigate
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.linear import left_by
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.bench_logs import WeightsPlan
from tests.core.test_diagnosis_bridge import BENCH, weights_case, with_rivals
from tests.core.test_diagnosis_comparison import cause_of

CURVES = {k: TABLE[k] for k in ("nonlinearity", "nonlinearity_cubic", "hinge", "dead_zone")}


def test_a_dead_zone_and_the_hinge_that_equals_it_lose_alike() -> None:
    """One makes the noise of small loads larger, the other makes that of large loads smaller."""
    hidden = ("hinge", {"all": BENCH.channels}, {"all.hinge": 0.05, "all.hinge_load": 6.0})
    case = weights_case(11, hidden)
    rows = rows_of(case)
    problem = problem_from(case, rows, CURVES.values(), describe)
    subject = Subject(case, problem, CURVES, describe)
    losses, noise = [], None
    for effect, shape in (("hinge", "hinge_load"), ("dead_zone", "dead_zone_width")):
        signature = next(
            s for s in problem.signatures if s.effect == effect and s.where == "all cells"
        )
        cause = cause_of(replace(signature, shape=((shape, 6.0),)))
        start = {f"all.{effect}": 0.05, f"all.{shape}": 6.0}
        fitted = subject.refitted([cause], start)
        fair = subject.without_credit(subject.bare(fitted, [cause]), fitted)
        noise = noise or fair.law
        losses.append(white_loss(fair, noise).sum())
    assert losses[0] == pytest.approx(losses[1], rel=2e-3)


@pytest.mark.slow
def test_a_broken_line_keeps_its_exact_alias() -> None:
    broken = ("hinge", {"all": BENCH.channels}, {"all.hinge": 0.05, "all.hinge_load": 6.0})
    found = investigate(weights_case(13, broken), CURVES, describe)
    assert with_rivals(found) == {"hinge", "dead_zone"}


@pytest.mark.parametrize(
    "knee",
    [
        ("hinge", {"all.hinge": 0.05, "all.hinge_load": 6.0}),
        pytest.param(
            ("dead_zone", {"all.dead_zone": 0.05, "all.dead_zone_width": 6.0}),
            marks=pytest.mark.slow,
        ),
    ],
)
def test_pulling_tells_a_hinge_from_a_dead_zone(knee: tuple[str, dict[str, float]]) -> None:
    """``max(F − 6, 0)`` bends on one side, ``min(|F|, 6)`` on both."""
    name, values = knee
    pulled = WeightsPlan(loads_n=(-20.0, -10.0, -5.0, -2.0, 0.0, 2.0, 5.0, 10.0, 20.0))
    found = investigate(
        weights_case(13, (name, {"all": BENCH.channels}, values), plan=pulled), CURVES, describe
    )
    assert found.verdict == "named"
    assert with_rivals(found) == {name}


def softly_deaf(seed: int, share: float, width_n: float, plan: WeightsPlan) -> Case:
    """Weighed cells that hear small loads less, without a sharp edge: ``x − s w tanh(x / w)``."""
    case = weights_case(seed, None, plan=plan)
    logs = []
    for log in case.logs:
        scale = np.array([case.values[f"{c}.scale"] for c in log.channels])
        zero = np.array([case.values[f"{c}.bias"] for c in log.channels])
        force = log.readings * scale + zero
        force -= share * width_n * np.tanh(force / width_n)
        logs.append(log.with_readings((force - zero) / scale))
    return replace(case, logs=tuple(logs))


@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.slow)])
@pytest.mark.parametrize("width_n", [9.0, pytest.param(13.5, marks=pytest.mark.slow)])
def test_four_loads_do_not_tell_a_soft_dead_zone_from_a_smooth_curve(
    seed: int, width_n: float
) -> None:
    """A cubic polynomial goes through all four."""
    plan = WeightsPlan(loads_n=(0.0, 10.0, 20.0, 30.0))
    found = investigate(softly_deaf(seed, 0.06, width_n, plan), CURVES, describe)
    assert with_rivals(found) >= {"dead_zone", "hinge", "nonlinearity"}


def ending(seed: int, share: float, width_n: float, *, sharp: bool) -> Case:
    """Cells on which loads push and pull, deaf to small ones up to an edge or without one."""
    plan = WeightsPlan(loads_n=(-20.0, -10.0, -5.0, -2.0, 0.0, 2.0, 5.0, 10.0, 20.0))
    values = {"all.dead_zone": share, "all.dead_zone_width": width_n}
    effect = ("dead_zone", {"all": BENCH.channels}, values) if sharp else None
    case = weights_case(seed, effect, plan=plan)
    if sharp:
        return case
    logs = []
    for log in case.logs:
        scale = np.array([case.values[f"{c}.scale"] for c in log.channels])
        zero = np.array([case.values[f"{c}.bias"] for c in log.channels])
        force = log.readings * scale + zero
        force += share * width_n * np.sign(force) * np.expm1(-np.abs(force) / width_n)
        logs.append(log.with_readings((force - zero) / scale))
    return replace(case, logs=tuple(logs))


@pytest.mark.parametrize(("width_n", "sharp"), [(6.0, True), (1.5, False)])
def test_a_dead_zone_is_sure_where_loads_show_its_edge(width_n: float, sharp: bool) -> None:
    """``1 − exp(−|F| / 1.5 N)`` has ended below the lightest loads; no polynomial follows it."""
    found = investigate(ending(13, 0.05 * 6.0 / width_n, width_n, sharp=sharp), CURVES, describe)
    alike = with_rivals(found)
    assert "dead_zone" in alike
    assert ("nonlinearity" in alike) is not sharp


def nearest(curve: FloatArray, terms: Sequence[FloatArray], load: FloatArray) -> float:
    """Share of a curve's square beside scale and bias that the best sum of terms leaves."""
    line = np.stack([np.ones_like(load), load], 1)
    left = left_by(line, curve, 1e-12)
    return float(np.sum(left_by(np.stack([*terms, *line.T], 1), curve, 1e-12) ** 2) / (left @ left))


def test_how_much_a_curve_loses_in_the_form_of_the_other_class() -> None:
    """The figures that the rules are set by: nine even loads."""
    load = np.linspace(0.0, 1.0, 9)
    knees = [np.maximum(load - k, 0.0) for k in np.linspace(0.03, 0.97, 95)]
    cubic = [load**2, load**3]

    def by_a_knee(curve: FloatArray) -> float:
        return min(nearest(curve, [knee], load) for knee in knees)

    assert by_a_knee(load**2) == pytest.approx(0.06, abs=0.005)
    soft = [by_a_knee(w * np.tanh(load / w)) for w in (0.3, 0.45, 0.6)]
    assert 0.02 < min(soft) < max(soft) < 0.04
    sharp = [nearest(np.maximum(load - k, 0.0), cubic, load) for k in (0.2, 0.35, 0.5, 0.7)]
    assert 0.02 < min(sharp) < max(sharp) < 0.08
    smooth = [nearest(np.exp(-load / length), cubic, load) for length in (0.3, 0.45, 0.6)]
    assert max(smooth) < 0.004 < Rules().other_form < min(sharp)
