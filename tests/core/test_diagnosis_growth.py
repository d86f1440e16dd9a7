"""What a cause must show once it is in the model: a size, and a gain of its own."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from footcal_cli.core.diagnosis import growth
from footcal_cli.core.diagnosis.answer import Cause, Diagnosis
from footcal_cli.core.diagnosis.gain import losses
from footcal_cli.core.diagnosis.growth import grown_by_one
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.sized import is_something
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.scatter import Scatter
from footcal_cli.core.parameters import FloatArray

BLOCKS, ROWS = 12, 60
COUPLINGS = TABLE["cross_coupling"].sizes
SIZE = COUPLINGS[0]


def problem_of(residual: FloatArray, accepted: FloatArray | None = None) -> Problem:
    index = np.repeat(np.arange(BLOCKS), ROWS)
    return Problem(
        residual=residual,
        calibration=np.ones((residual.size, 1)),
        columns=np.empty((residual.size, 0)),
        signatures=(),
        block=index,
        output=np.zeros_like(index),
        sequence=index,
        outputs=("fz",),
        units=("N",),
        noise=np.ones(residual.size),
        tolerance=np.array([0.1]),
        rate_hz=20.0,
        accepted=accepted,
    )


def test_a_rival_that_one_block_tells_apart_does_not_take_the_gain_away() -> None:
    """In all other blocks the two trade against each other at will."""
    rng = np.random.default_rng(0)
    cause, noise = rng.standard_normal((2, BLOCKS * ROWS))
    rival = cause + 1e-3 * rng.standard_normal(cause.size)
    rival[:ROWS] = -3.0 * cause[:ROWS]
    residual = 0.3 * cause + noise
    baseline = problem_of(residual)
    alone = problem_of(residual, cause[:, None])
    both = replace(alone, accepted=np.stack([cause, rival], axis=1))
    law = alone.law
    start, end = losses(baseline, [alone], law)
    assert start - end > 0.5 * 0.3**2 * cause.size
    assert losses(baseline, [both], law)[1] > start
    assert losses(baseline, [alone, both], law)[1] == end


def stands(values: FloatArray, apart: FloatArray) -> bool:
    """Whether couplings of one leg count as something, by what leaving out blocks does to them."""
    parameters = COUPLINGS[: values.size]
    names = tuple(f"fl.{p.name}" for p in parameters)
    scatter = Scatter(apart, np.full(values.size, float(BLOCKS)), 0.0, np.zeros((values.size,) * 2))
    intervals = tuple(
        scatter.interval(v, turn) for v, turn in zip(values, np.eye(values.size), strict=True)
    )
    model = SimpleNamespace(
        names=names,
        values=dict(zip(names, values, strict=True)),
        intervals=intervals,
        scatter=scatter,
    )
    one = Interval(0.01, 0.0, 0.02)
    signature = Signature("cross_coupling", SIZE.name, "fl", "-", owners=(("fl", ("fl",)),))
    cause = Cause(signature, one, 0.001, one, 9, 0.0, (), ())
    return is_something(cause, TABLE["cross_coupling"], cast("Refit", model))


def drawn(rng: np.random.Generator, covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Estimates of what is nothing, and what leaving out each of their blocks does to them."""
    each = rng.multivariate_normal(np.zeros(len(covariance)), covariance * BLOCKS, size=BLOCKS)
    return each.mean(axis=0), (each.mean(axis=0) - each) / (BLOCKS - 1)


def test_sizes_that_calibration_trades_count_by_what_they_are_together() -> None:
    """Each of two is unsure, their sum is not."""
    rng = np.random.default_rng(1)
    spread = np.array([[1.0, -0.999], [-0.999, 1.0]]) * 0.01**2
    nothing, apart = drawn(rng, spread)
    each = [
        Scatter(apart, np.full(2, float(BLOCKS)), 0.0, np.zeros((2, 2))).interval(0.005, t)
        for t in np.eye(2)
    ]
    assert all(i.low < 0.0 < i.high for i in each)
    assert stands(nothing + 0.005, apart)


def test_sizes_that_are_all_nothing_together_seldom_count() -> None:
    """Of nine: each alone does in one of twenty, and so does Hotelling's test of all."""
    rng = np.random.default_rng(2)
    spread = np.diag(np.full(9, 0.01**2))
    found = [stands(*drawn(rng, spread)) for _ in range(400)]
    assert np.mean(found) < 0.15


NAMED, LIKE, NEXT = "cell_position", "dead_zone", "creep"


def cause_named(effect: str) -> Cause:
    one = Interval(0.0, 0.0, 0.0)
    return Cause(Signature(effect, effect, "fl", "-"), one, 0.0, one, 9, 0.0, (), ())


def grown_from(
    monkeypatch: pytest.MonkeyPatch, nothing: set[str], unsettled: set[str]
) -> tuple[str | None, list[str]]:
    """Which effect stands its refit, and the winners of all contests, where some are nothing."""
    contests: list[str] = []

    def answer(*names: str) -> Diagnosis:
        return cast("Diagnosis", SimpleNamespace(
            causes=tuple(cause_named(n) for n in names), rules=Rules()))  # fmt: skip

    def decided(*given: Any) -> tuple[Cause, Refit]:
        first, failed = given[3].causes[0].signature.effect, given[5]
        won = LIKE if first == NAMED and LIKE not in failed else first
        contests.append(won)
        return cause_named(won), cast("Refit", SimpleNamespace(converged=won not in unsettled))

    def needed(subject: Subject, causes: list[Cause], fitted: Refit) -> tuple[list[Cause], Refit]:
        return [c for c in causes if c.signature.effect not in nothing], fitted

    def again(*given: Any) -> Diagnosis:
        left = [name for name in (NAMED, NEXT) if name not in given[4]]
        return answer(*left[:1])

    monkeypatch.setattr(growth, "decided", decided)
    monkeypatch.setattr(growth, "_needed", needed)
    monkeypatch.setattr(growth, "diagnose", again)
    subject = cast("Subject", SimpleNamespace(table=TABLE))
    found, _ = grown_by_one(subject, [], None, cast("Problem", None), answer(NAMED), None, 0)
    return (found[0][0].signature.effect if found else None), contests


def test_a_look_alike_that_is_nothing_takes_no_name_with_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It wins by a hair and has no size; what was named has one."""
    assert grown_from(monkeypatch, {LIKE}, set()) == (NAMED, [LIKE, NAMED])
    assert grown_from(monkeypatch, {LIKE, NAMED}, set()) == (NEXT, [LIKE, NAMED, NEXT])
    assert grown_from(monkeypatch, {LIKE, NAMED, NEXT}, set())[0] is None


def test_a_refit_that_found_no_end_leaves_the_word_to_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where no other one finds an end, it counts."""
    assert grown_from(monkeypatch, set(), {LIKE})[0] == NAMED
    assert grown_from(monkeypatch, set(), {LIKE, NAMED})[0] == NEXT
    assert grown_from(monkeypatch, {NEXT}, {LIKE, NAMED})[0] == LIKE


@pytest.mark.parametrize("held", [None, 2])
def test_imperfections_lie_between_what_is_held_and_effects(held: int | None) -> None:
    rows = BLOCKS * ROWS
    usual = np.random.default_rng(0).standard_normal((rows, 3))
    problem = replace(
        problem_of(np.zeros(rows), np.ones((rows, 1))),
        held=None if held is None else np.zeros((rows, held)), usual=usual,
    )  # fmt: skip
    np.testing.assert_array_equal(problem.shared[:, problem.usual_columns], usual)
