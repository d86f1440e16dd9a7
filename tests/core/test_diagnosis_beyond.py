"""A further cause beside every form that the other one may have."""

from __future__ import annotations

from dataclasses import replace

import pytest

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.beyond import Beyond, are_distinct, beyond, is_beyond
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.investigation import investigate
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.refit import Refit
from tests.core.test_diagnosis_bridge import BENCH, Hidden, weights_case, with_rivals
from tests.core.test_diagnosis_ways import CELLS, named_both, placed

RULES = Rules()
EVERYONE = {"all": BENCH.channels}
BENT: Hidden = ("nonlinearity", EVERYONE, {"all.quadratic": 1e-3})
KNEED: Hidden = ("hinge", EVERYONE, {"all.hinge": 0.05, "all.hinge_load": 15.0})
START = {"all.quadratic": 1e-3, "all.hysteresis_width": 0.05, "all.hysteresis_reach": 4.0}
LOOPED: Hidden = ("hysteresis", EVERYONE, {"all.hysteresis_width": 0.08})


def fitted_both(case: Case, *effects: str) -> tuple[Subject, list[Cause], Refit]:
    """Causes of all cells with one size each, refitted together."""
    table = {name: TABLE[name] for name in effects}
    problem = problem_from(case, rows_of(case), table.values(), describe)
    subject = Subject(case, problem, table, describe)
    nothing, causes = Interval(0.0, 0.0, 0.0), list[Cause]()
    for effect in effects:
        first = next(s for s in problem.signatures if (s.effect, s.where) == (effect, "all cells"))
        causes.append(Cause(first, nothing, 1.0, nothing, 0, 0.0, rivals=(), places=()))
    return subject, causes, subject.refitted(causes, START)


@pytest.mark.parametrize(
    ("agreement", "p", "no_form"),
    [(0.9, 1e-4, True), (0.7, 1e-4, False), (0.9, 0.01, False),
     # of the other sign, or of several times the size, once every form is there
     (-0.9, 1e-4, False), (2.5, 1e-4, False)],
)  # fmt: skip
def test_what_no_form_copies_asks_for_about_the_same_size(
    agreement: float, p: float, *, no_form: bool
) -> None:
    assert Beyond(agreement, p).is_no_form(RULES) is no_form


@pytest.mark.parametrize("seed", [21, pytest.param(22, marks=pytest.mark.slow)])
def test_a_loop_beside_a_curve_is_more_than_its_form(seed: int) -> None:
    subject, causes, model = fitted_both(
        weights_case(seed, BENT, LOOPED), "nonlinearity", "hysteresis"
    )
    assert is_beyond(subject, model, causes, 1, [0], RULES, 0)
    loop = beyond(subject, model, causes, 1, [0], 0)
    curve = beyond(subject, model, causes, 0, [1], 0)
    # no curve follows a load up and down on two ways; plays from zero on bend as they load
    assert abs(loop.agreement - 1.0) < 0.2
    assert abs(curve.agreement - 1.0) < 0.2
    assert are_distinct(subject, model, causes, [], RULES, 0)


@pytest.mark.parametrize("seed", [23, pytest.param(24, marks=pytest.mark.slow)])
def test_what_a_loop_takes_of_a_knee_beside_a_parabola_is_the_curves_form(seed: int) -> None:
    subject, causes, model = fitted_both(weights_case(seed, KNEED), "nonlinearity", "hysteresis")
    assert not is_beyond(subject, model, causes, 1, [0], RULES, 0)


def test_only_kinds_whose_forms_are_all_known_are_asked() -> None:
    subject, causes, model = fitted_both(
        weights_case(25, BENT, LOOPED), "nonlinearity", "hysteresis"
    )
    assert not is_beyond(subject, model, [causes[0], causes[0]], 1, [0], RULES, 0)
    warm = replace(causes[0], signature=replace(causes[0].signature, effect="temperature_bias"))
    assert not is_beyond(subject, model, [warm, causes[1]], 1, [0], RULES, 0)


@pytest.mark.parametrize(
    "table",
    [
        {name: TABLE[name] for name in ("nonlinearity", "hysteresis", "creep")},
        pytest.param(TABLE, marks=pytest.mark.slow),
    ],
    ids=["few", "all"],
)
def test_a_small_loop_next_to_a_large_curve_is_named(table: dict[str, Effect]) -> None:
    found = investigate(weights_case(26, BENT, LOOPED), table, describe)
    assert {"nonlinearity", "hysteresis"} <= with_rivals(found)


BYPASS: Hidden = (
    "load_bypass", {"left": ("left",)}, {"left.load_bypass": 0.1, "left.bypass_load": 15.0}
)  # fmt: skip
HEARD: Hidden = ("crosstalk", {"all": CELLS}, {"all.crosstalk": 0.02})


@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.slow)])
def test_what_a_cell_hears_is_no_form_of_a_bypass_and_the_other_way_round(seed: int) -> None:
    subject, path = named_both(placed(seed, BYPASS, HEARD), "load_bypass", "crosstalk")
    assert are_distinct(subject, path.model, path.causes, [(0, 1)], RULES, 0)
    assert path.model is not None
    for which in (0, 1):
        found = beyond(subject, path.model, path.causes, which, [1 - which], 0)
        assert abs(found.agreement - 1.0) < 0.3


@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.slow)])
def test_beside_a_bypass_alone_no_cell_hears_another(seed: int) -> None:
    subject, path = named_both(placed(seed, BYPASS), "load_bypass", "crosstalk")
    assert not are_distinct(subject, path.model, path.causes, [(0, 1)], RULES, 0)


def test_nothing_usual_is_more_than_a_form() -> None:
    subject, path = named_both(placed(3, BYPASS, HEARD), "load_bypass", "crosstalk")
    bypass, heard = path.causes
    assert path.model is not None
    late = replace(heard, signature=replace(heard.signature, effect="sensor_lag"))
    table = {**subject.table, "sensor_lag": TABLE["sensor_lag"]}
    usual = replace(subject, table=table)
    assert not is_beyond(usual, path.model, [bypass, late], 1, [0], RULES, 0)
