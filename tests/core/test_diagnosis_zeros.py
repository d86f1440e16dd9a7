"""Zeros that hanging knew before a leg's transducer changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.diagnosis.answer import Cause, Verdict
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.engine import diagnose
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.zeros import changed, is_zero, known_zeros, with_their_zeros
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.evidence import Interval, sign_patterns
from footcal_cli.core.inference.problem import Signature
from footcal_cli.intake.cases.pose import with_known_offsets
from tests.core.leg_cases import ROBOT, distorting, investigated, pose_case

LEG = "mr"
LEGS = tuple(dict.fromkeys(c.split(".")[0] for c in ROBOT.channels))
HUNG = {leg: np.diag([1e-4] * 3 + [1e-7] * 3) for leg in LEGS}


def posed(coupling: float, zero_n: float, poses: int = 60) -> Case:
    """Poses on a leg whose z force shows in x, and whose zero along x has moved; offsets known."""
    chain, values = distorting("cross_coupling", LEG, {"coupling_fx_fz": coupling})
    values[f"{LEG}.offset_fx"] += zero_n
    return with_known_offsets(pose_case(5, chain, values, poses=poses), HUNG)


def cause_of(effect: str, *owners: str) -> Cause:
    none = Interval(0.0, 0.0, 0.0)
    groups = tuple((owner, (owner,)) for owner in owners)
    signature = Signature(effect, TABLE[effect].size.name, " ".join(owners), "-", owners=groups)
    return Cause(signature, none, 0.0, none, 0, 0.0, (), ())


def test_who_has_a_matrix_of_its_own_has_another_zero() -> None:
    assert changed(TABLE, [cause_of("cross_coupling", LEG), cause_of("cable_drag", "fl")]) == [LEG]
    assert changed(TABLE, [cause_of("scale_matrix", *LEGS)]) == []
    assert known_zeros(posed(0.0, 0.0)) == list(LEGS)


@pytest.mark.parametrize(("coupling", "zero_n"), [(0.05, 0.6), (0.0, 0.6)])
def test_only_what_explains_something_beside_a_free_zero_comes_with_it(
    coupling: float, zero_n: float
) -> None:
    case = posed(coupling, zero_n)
    table = {name: TABLE[name] for name in ("cross_coupling", "scale_matrix", "zero_shift")}
    problem = problem_from(case, rows_of(case), table.values(), describe)
    subject = Subject(case, problem, table, describe)
    zeros = {leg: subject.zero(leg) for leg in LEGS}
    assert all(zero.shape[1] == 6 for zero in zeros.values())
    at_leg = {s.effect: s for s in problem.signatures if [n for n, _ in s.owners] == [LEG]}
    alone = [is_zero(problem, zeros[LEG], s) for s in at_leg.values()]
    assert dict(zip(at_leg, alone, strict=True)) == {n: n == "zero_shift" for n in table}
    # six zeros of one leg are all that six sums know of the zeros of any: also of all legs at once
    shifts = [s for s in problem.signatures if s.effect == "zero_shift"]
    assert {len(group) for s in shifts for _, group in s.owners} == {1, len(LEGS)}
    for shift in shifts:
        second = replace(cause_of("zero_shift"), signature=shift)
        assert subject.zero_is_named([cause_of("cross_coupling", LEG), second])
    assert not subject.zero_is_named([cause_of("scale_matrix", *LEGS), second])
    signs, level = sign_patterns(problem.blocks, 0), Rules().alpha_name
    lib = diagnose(problem, Rules(), 0).library
    found = list(with_their_zeros(lib, zeros, table, signs, level))
    mine = [s for s, _, _ in found if s.owners[0][0] == LEG]
    assert ("cross_coupling" in {s.effect for s in mine}) == (coupling > 0.0)
    if coupling:
        best = max(found, key=lambda item: item[2])
        assert best[0].parameter == "coupling_fx_fz"
        assert best[1].value == pytest.approx(coupling, rel=0.2)


def pulled(pull_n: float, mean_n: float, poses: int = 60) -> Case:
    """Poses on a leg that a cable pulls up as its shaft turns; offsets known as it hung free."""
    sizes = {"cable_fz_sin": pull_n, "cable_fz_mean": mean_n}
    chain, values = distorting("cable_drag", LEG, sizes)
    return with_known_offsets(pose_case(6, chain, values, poses=poses), HUNG)


@pytest.mark.parametrize(("pull_n", "mean_n"), [(0.8, -1.2), (0.0, -1.2)])
def test_a_pull_is_sought_next_to_its_own_constant_part(pull_n: float, mean_n: float) -> None:
    case = pulled(pull_n, mean_n)
    table = {name: TABLE[name] for name in ("cable_drag", "zero_shift")}
    problem = problem_from(case, rows_of(case), table.values(), describe)
    subject = Subject(case, problem, table, describe)
    zeros = {leg: subject.zero(leg) for leg in LEGS}
    lib = diagnose(problem, Rules(), 0).library
    signs, level = sign_patterns(problem.blocks, 0), Rules().alpha_name
    found = list(with_their_zeros(lib, zeros, table, signs, level))
    sizes = {s.owners[0][0]: size.value for s, size, _ in found if s.parameter == "cable_fz_sin"}
    assert (LEG in sizes) == (pull_n > 0.0)
    if pull_n:
        assert sizes[LEG] == pytest.approx(pull_n, rel=0.2)


@pytest.mark.slow
def test_a_pull_with_a_constant_part_is_one_cause() -> None:
    found = investigated(pulled(0.8, -1.2, poses=120))
    (named,) = found.found
    assert found.verdict is Verdict.NAMED
    assert named.cause.signature.effect == "cable_drag"
    sized = dict(zip(named.parameter_names, named.intervals, strict=True))
    assert sized[f"{LEG}.cable_fz_sin"].low <= 0.8 <= sized[f"{LEG}.cable_fz_sin"].high
    assert sized[f"{LEG}.cable_fz_mean"].low <= -1.2 <= sized[f"{LEG}.cable_fz_mean"].high


@pytest.mark.slow
@pytest.mark.parametrize(("coupling", "zero_n"), [(0.05, 0.6), (0.0, 0.6)])
def test_a_coupling_that_moves_its_zero_is_one_cause_and_a_zero_that_moves_is_another(
    coupling: float, zero_n: float
) -> None:
    found = investigated(posed(coupling, zero_n, poses=120))
    (named,) = found.found
    assert found.verdict in (Verdict.NAMED, Verdict.AMBIGUOUS)
    said = {named.cause.signature.effect, *(rival.effect for rival in named.cause.rivals)}
    assert ("cross_coupling" if coupling else "zero_shift") in said
