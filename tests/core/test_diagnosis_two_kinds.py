"""A bypass against a curve of the cells, each in every form of its kind."""

from __future__ import annotations

import pytest

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.contenders import fit
from footcal_cli.core.diagnosis.field import white_loss
from footcal_cli.core.diagnosis.rivals import Tried
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.two_kinds import surer
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import rows_of
from footcal_cli.core.inference.evidence import Interval, sign_patterns
from footcal_cli.core.inference.problem import Signature
from tests.core.test_diagnosis_bridge import Hidden
from tests.core.test_diagnosis_ways import CELLS, placed

BYPASS: Hidden = (
    "load_bypass", {"left": ("left",)}, {"left.load_bypass": 0.1, "left.bypass_load": 12.0}
)  # fmt: skip
KNEED: Hidden = ("hinge", {"all": CELLS}, {"all.hinge": 0.08, "all.hinge_load": 6.0})
BENT: Hidden = ("nonlinearity", {"all": CELLS}, {"all.quadratic": 4e-3})


def surer_is(seed: int, hidden: Hidden, *, one: str, other: str) -> bool:
    """Whether one effect is surer than another, both refitted to placements with a hidden one."""
    case, names = placed(seed, hidden), ("load_bypass", "hinge", "nonlinearity")
    table = {name: TABLE[name] for name in names}
    problem = problem_from(case, rows_of(case), table.values(), describe)
    subject, nothing = Subject(case, problem, table, describe), Interval(0.0, 0.0, 0.0)
    tried = []
    for name in (one, other):
        mine = next(s for s in problem.signatures if s.effect == name and len(_members(s)) != 1)
        cause = Cause(mine, nothing, 1.0, nothing, 0, 0.0, rivals=(), places=())
        cause, fitted, bare = fit(subject, (), None, cause)
        tried.append(Tried(cause, fitted, white_loss(bare, problem.law), bare, 1.0, 0.0))
    first, second = tried
    signs = sign_patterns(problem.blocks, 0)
    return surer(subject, first, second, problem.law, signs, Rules())


def _members(signature: Signature) -> set[str]:
    """Cells that a cause acts on; the foot itself where it acts on the sum."""
    return {unit for _, own in signature.owners for unit in own} - {"left"}


@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.slow)])
def test_a_bypass_is_surer_than_a_curve_where_it_is_one_and_never_the_other_way_round(
    seed: int,
) -> None:
    for curve in ("hinge", "nonlinearity"):
        assert surer_is(seed, BYPASS, one="load_bypass", other=curve)
        assert not surer_is(seed, BYPASS, one=curve, other="load_bypass")


@pytest.mark.parametrize("hidden", [KNEED, BENT])
def test_a_curve_is_surer_than_a_bypass_where_it_is_one(hidden: Hidden) -> None:
    assert surer_is(3, hidden, one=hidden[0], other="load_bypass")
    assert not surer_is(3, hidden, one="load_bypass", other=hidden[0])


def test_two_curves_are_of_one_kind() -> None:
    assert not surer_is(3, KNEED, one="hinge", other="nonlinearity")
