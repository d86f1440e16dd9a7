"""Offsets that moved between hanging and standing: named with their leg, or nothing."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.chain import Chain
from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.departure import of_calibration
from footcal_cli.core.diagnosis.gain import main_gain
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import refit
from footcal_cli.core.parameters import FloatArray
from footcal_cli.intake.cases.pose import with_known_offsets
from tests.core.leg_cases import ROBOT, distorting, investigated, pose_case

MATTERS_N = 0.1
HUNG_SD = np.array([0.01] * 3 + [0.001] * 3)
LEGS = tuple(ROBOT.legs)
AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
USUAL = np.repeat([MATTERS_N, 0.1 * MATTERS_N], 3) / np.sqrt(len(LEGS))
"""Sd of what an offset moves by between hanging and standing, N and Nm."""


def stood(seed: int, moved: FloatArray, poses: int = 60) -> Case:
    """Poses of a robot whose offsets moved since it hung, shape (legs, 6)."""
    return standing(seed, *distorting("", "", {}), moved, poses)


def standing(
    seed: int, chain: Chain, values: dict[str, float], moved: FloatArray, poses: int = 60
) -> Case:
    """`stood`, of a robot with something wrong too."""
    for leg, by in zip(LEGS, moved, strict=True):
        for axis, size in zip(AXES, by, strict=True):
            values[f"{leg}.offset_{axis}"] += float(size)
    case = pose_case(seed, chain, values, poses=poses, tolerance_n=MATTERS_N)
    return with_known_offsets(case, dict.fromkeys(LEGS, np.diag(HUNG_SD) ** 2))


def usual(rng: np.random.Generator) -> FloatArray:
    """What offsets move by between hanging and standing, and hanging's own error."""
    return np.asarray(np.hypot(USUAL, HUNG_SD) * rng.standard_normal((len(LEGS), 6)))


@pytest.mark.parametrize("seed", [1, pytest.param(5, marks=pytest.mark.slow)])
def test_an_offset_that_moved_is_named_with_its_leg(seed: int) -> None:
    rng = np.random.default_rng([61, seed])
    leg, axis = int(rng.integers(6)), int(rng.integers(3))
    size = float(rng.choice([-1.0, 1.0]) * rng.uniform(8.0, 15.0) * MATTERS_N)
    moved = 0.3 * usual(rng)
    moved[leg, axis] += size
    found = investigated(stood(seed, moved, poses=40))
    assert found.verdict is Verdict.NAMED
    cause = found.found[0].cause
    assert cause.signature.effect == "zero_shift"
    # legs at one height share what a force along the floor does: such are named together
    alike = {s.where: s.parameter for s in (cause.signature, *cause.places)}
    assert alike[LEGS[leg]] == f"zero_shift_{AXES[axis]}"
    assert len(alike) < len(LEGS)
    if cause.signature.where == LEGS[leg]:
        assert cause.size.low < size < cause.size.high
    # no block tells it, as all share it: the gain is that over the offsets as they hung
    best = main_gain(found.gains, found.problem)
    assert best is not None
    assert best.change.low > 0.0
    if AXES[axis] == "fz":  # what the mountings, of which nothing is known, cannot take up
        assert best.before == pytest.approx(abs(size), rel=0.3)


@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.slow)])
def test_offsets_that_move_as_usual_are_nothing_that_matters(seed: int) -> None:
    moved = 0.3 * usual(np.random.default_rng([62, seed]))
    assert investigated(stood(seed, moved)).verdict is Verdict.NONE


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_cable_that_pulls_steadily_too_is_one_cause(seed: int) -> None:
    """Since the legs hung it pulls at one of them: an even pull is no offset of its own."""
    pull = {"cable_fx_cos": 0.4, "cable_fz_sin": -0.5, "cable_fz_mean": 0.7}
    moved = 0.3 * usual(np.random.default_rng([64, seed]))
    found = investigated(standing(seed, *distorting("cable_drag", "mr", pull), moved, poses=40))
    assert found.verdict is Verdict.NAMED
    (cable,) = found.found
    assert (cable.cause.signature.effect, cable.cause.signature.where) == ("cable_drag", "mr")
    intervals = dict(zip(cable.parameter_names, cable.intervals, strict=True))
    for name, size in pull.items():
        sd = (intervals[f"mr.{name}"].high - intervals[f"mr.{name}"].low) / 4.0
        assert abs(intervals[f"mr.{name}"].value - size) < 3.0 * sd


def shifted_axis(problem: Problem, leg: str, axis: str) -> Signature:
    """The signature of one offset's move."""
    wanted = (leg, f"zero_shift_{axis}")
    return next(s for s in problem.signatures if (s.where, s.parameter) == wanted)


def test_the_interval_allows_for_what_hanging_knows_and_all_poses_share() -> None:
    errors = []
    for seed in range(16):
        rng = np.random.default_rng([63, seed])
        moved, size = usual(rng), float(rng.uniform(0.5, 1.5))
        leg, axis = LEGS[seed % 6], seed % 3
        moved[seed % 6, axis] += size
        case = stood(seed, moved, poses=40)
        rows, effect = rows_of(case), TABLE["zero_shift"]
        problem = problem_from(case, rows, [effect], describe)
        signature = shifted_axis(problem, leg, AXES[axis])
        assert of_calibration(problem, [signature])
        start = {f"{leg}.{p.name}": 0.0 for p in effect.parameters}
        model = refit(case, problem, [(effect, signature)], start)
        at = model.names.index(f"{leg}.zero_shift_{AXES[axis]}")
        sd = (model.intervals[at].high - model.intervals[at].low) / 4.0
        errors.append((model.values[model.names[at]] - size) / sd)
    # χ² of 16: 95 % of root mean squares lie between 0.66 and 1.34
    assert 0.66 < np.sqrt(np.mean(np.square(errors))) < 1.34
