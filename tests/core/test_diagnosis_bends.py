"""A curve that is named for one axis against other curves of that axis."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.bends import (
    Bends,
    against_bends,
    bend_left,
    bends_of,
    bent_axes,
    largest,
    open_curves,
)
from footcal_cli.core.diagnosis.curves import explained_p
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.unnamed import KNEES, Unnamed
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.evidence import Interval, sign_patterns
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.whitening import has_single_rows
from footcal_cli.core.parameters import FloatArray
from tests.core.leg_cases import distorting, pose_case

RULES = Rules()
LEGS = ("fl", "mr")
POSES, BLOCKS, OUTPUTS = 168, 42, 3
"""So few poses to a block that none has a calibration of its own, as on six legs."""
REMOVED = 250.0
"""Squared error that the names remove, here about that of an effect half as large as the noise."""


def posed(seed: int, hidden: str) -> tuple[Problem, FloatArray, FloatArray]:
    """A parabola of one force is named in single poses; a line and knees of that force."""
    rng = np.random.default_rng([31, seed])
    force = np.repeat(rng.normal(0.0, 8.0, POSES), OUTPUTS)
    output = np.tile(np.arange(OUTPUTS), POSES)
    zero = 12.0 if hidden == "bends about another zero" else 0.0
    shape = np.abs(force) if hidden == "folds" else (force + zero) ** 2
    curved = np.abs(force) if hidden == "folds" else force**2
    shape = shape * (output == 0) / np.std(curved)
    knees = np.stack(
        [np.maximum(force - knee, 0.0) * (output == 0) for knee in np.quantile(force, KNEES)], 1
    )
    problem = Problem(
        residual=1.3 * shape + rng.normal(size=force.size),
        calibration=np.hstack([np.eye(OUTPUTS)[output], rng.normal(size=(force.size, 1))]),
        columns=np.empty((force.size, 0)),
        signatures=(),
        block=np.repeat(np.arange(POSES) * BLOCKS // POSES, OUTPUTS),
        output=output,
        sequence=np.arange(force.size),
        outputs=("fx", "fy", "fz"),
        units=("N", "N", "N"),
        noise=np.ones(force.size),
        tolerance=np.full(OUTPUTS, 0.1),
        accepted=(force**2 * (output == 0))[:, None],
    )
    line = np.stack([force * (output == 0), 1.0 * (output == 0)], 1)
    return problem, line, knees


def judged(seed: int, hidden: str) -> Unnamed:
    problem, line, knees = posed(seed, hidden)
    assert has_single_rows(problem)
    return against_bends(problem, Bends(line, knees), sign_patterns(problem.blocks, seed))


def test_what_a_fold_leaves_matters_from_the_tolerance_of_some_output_on() -> None:
    problem, line, knees = posed(0, "folds")
    signs = sign_patterns(problem.blocks, 0)
    for tolerance, matters in ((0.1, True), (1.0, False)):
        held = replace(problem, tolerance=np.array([tolerance, 2.0, 2.0]))
        found = against_bends(held, Bends(line, knees), signs)
        assert found.smallest == pytest.approx(POSES * OUTPUTS * tolerance**2)
        assert (found.left.bought > found.smallest) is matters


@pytest.mark.parametrize("hidden", ["bends", "bends about another zero"])
@pytest.mark.parametrize("seed", range(6))
def test_a_parabola_leaves_nothing_to_knees_of_its_axis(seed: int, hidden: str) -> None:
    assert not judged(seed, hidden).spoils(REMOVED, RULES)


@pytest.mark.parametrize("seed", range(6))
def test_a_fold_that_was_taken_for_a_parabola_shows(seed: int) -> None:
    found = judged(seed, "folds")
    assert found.left.p < RULES.alpha_form
    assert found.spoils(REMOVED, RULES)


@pytest.mark.slow
def test_the_f_test_of_knees_keeps_its_level() -> None:
    p = []
    for seed in range(200):
        problem, line, knees = posed(seed, "bends")
        problem = problem.holding(line)
        grams, _ = whitened_grams(problem, knees)
        p.append(explained_p(grams, grams.calibration, grams.features, problem.residual.size))
    # 10 of 200 expected below 0.05
    assert np.sum(np.array(p) < 0.05) <= stats.binom.ppf(0.999, 200, 0.05)
    assert np.sum(np.array(p) < 0.5) > 60


@pytest.mark.parametrize(
    "share",
    [pytest.param(0.0, marks=pytest.mark.slow), 0.1, pytest.param(1.0, marks=pytest.mark.slow)],
)
def test_a_bend_is_seldom_larger_than_its_bound(share: float) -> None:
    """Of 200 parabolas beside a gain at most as many exceed it as 95 % allow; known noise."""
    beyond, bounds = 0, []
    for seed in range(200):
        problem, line, _ = posed(seed, "bends")
        bend = problem.accepted[:, 0] / np.std(problem.accepted[:, 0])  # type: ignore[index]
        rng = np.random.default_rng([32, seed])
        seen = replace(problem, residual=rng.normal(size=bend.size) + share * bend, accepted=line)
        bounds.append(largest(seen, bend))
        beyond += bounds[-1] < share
    assert beyond <= stats.binom.ppf(0.999, 200, 0.05)
    assert np.median(bounds) < share + 0.4
    assert largest(replace(problem, accepted=bend[:, None]), bend) == np.inf


def named(effect: str, owner: str) -> Cause:
    signature = Signature(effect, "size", owner, "", owners=((owner, (owner,)),))
    one = Interval(1.0, 0.9, 1.1)
    return Cause(signature, one, 0.001, one, 9, 0.0, (), ())


@pytest.mark.parametrize(
    ("effect", "owners"),
    [("offset_drift", ()), ("axis_flip", (("fl", ("fl",)),)), ("scale_matrix", (("all", LEGS),))],
)
def test_no_curve_is_a_rival_of_what_is_no_gain_of_one_transducer(
    effect: str, owners: tuple[tuple[str, tuple[str, ...]], ...]
) -> None:
    cause = named(effect, "fl")
    cause = replace(cause, signature=replace(cause.signature, owners=owners))
    best, subject = SimpleNamespace(cause=cause), SimpleNamespace(table=TABLE)
    assert open_curves(subject, best, None, RULES) == []  # type: ignore[arg-type]


def posing() -> Case:
    return pose_case(3, *distorting("", "", {}))


def test_only_a_named_curve_of_a_transducer_is_asked() -> None:
    case = posing()
    assert bent_axes(case, [named("nonlinearity", "fl.fy"), named("case_strain", "mr")]) == (
        "fl.fy",
    )
    assert bent_axes(case, [named("case_strain", "mr")]) == ()
    log = case.logs[0]
    cells = replace(log, channels=tuple(f"left_{i}" for i in range(len(log.channels))))
    assert bent_axes(replace(case, logs=(cells,)), [named("nonlinearity", "left_1")]) == ()


def test_knees_of_an_axis_are_felt_where_its_leg_pushes() -> None:
    case = posing()
    bends = bends_of(case, rows_of(case), ("fl.fy",))
    np.testing.assert_allclose(np.sqrt(np.mean(bends.bent**2, axis=0)), 1.0)
    both = np.hstack([bends.straight, bends.bent])
    assert np.linalg.matrix_rank(both) == 2 + len(KNEES)


@pytest.mark.parametrize(
    ("named_for", "p", "size", "bent"),
    [
        (["fl"], 0.0005, 0.3, True), (["fl"], 0.02, 0.3, False), (["mr"], 0.0005, 0.3, False),
        ([], 0.0005, 0.3, False), (["fl"], 0.0005, 0.2, False), (["fl", "mr"], 0.0005, 0.3, False),
    ],
)  # fmt: skip
def test_a_gain_beside_which_its_transducer_surely_bends_is_no_gain(
    named_for: list[str], p: float, size: float, bent: bool
) -> None:
    """A curve of ``fl.fz`` by a quarter of the gain and more; several legs do not bend alike."""
    curve = named("nonlinearity", "fl.fz").signature
    column = np.ones((4, 1))
    library = SimpleNamespace(
        problem=SimpleNamespace(signatures=(curve,), columns=column), causes=(curve.cause,),
        columns=(np.array([7]),), index=lambda column: column - 7,
    )  # fmt: skip
    found = SimpleNamespace(
        p=np.array([p]), best=np.array([7]), interval=lambda _: Interval(size, 0.0, 1.0)
    )
    last = SimpleNamespace(library=library, search=SimpleNamespace(first=found), rules=RULES)
    cause = named("scale_matrix" if named_for else "offset_change", "fl")
    owners = (("all", tuple(named_for or ["fl"])),)
    cause = replace(cause, signature=replace(cause.signature, parameter="gain_fz", owners=owners))
    model = SimpleNamespace(
        names=("all.gain_fz",), columns=column, intervals=(Interval(1.0, 0.9, 1.1),)
    )
    assert bend_left(last, [cause], model) is bent  # type: ignore[arg-type]
    assert not bend_left(last, [cause], None)  # type: ignore[arg-type]
