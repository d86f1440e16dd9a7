"""Names against kinds that the table may lack: loops, memories, curves, mixtures, sums."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.contenders import refitted_with
from footcal_cli.core.diagnosis.kinds import of_another_kind
from footcal_cli.core.diagnosis.path import beginning, continued
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.parameters import FloatArray
from tests.blind import foreign
from tests.core.leg_cases import distorting, hang_case, hung_logs, stepped
from tests.core.test_diagnosis_bridge import Hidden, weights_case
from tests.core.test_diagnosis_memories import Law, distorted, first, follower
from tests.core.test_diagnosis_ways import CELLS, named_both, placed

RULES = Rules()
LARGEST_N = 30.0


def loop(x: FloatArray, _: FloatArray) -> FloatArray:
    return np.asarray(foreign.bouc_wen(x[:, None], first(len(x)), 0.6, 6.0)[:, 0] - x)


def slow(x: FloatArray, time_s: FloatArray) -> FloatArray:
    two = 0.4 * follower(x, time_s, 15.0) + 0.6 * follower(x, time_s, 120.0)
    return np.asarray(0.02 * two)


def bent(x: FloatArray, _: FloatArray) -> FloatArray:
    return np.asarray(4e-4 * x**2)


def mislabelled(by_n: float) -> Case:
    """The heaviest weight is written without its error."""
    case = weights_case(3)
    logs = []
    for log in case.logs:
        load = log.known["load_n"]
        written = np.where(load == LARGEST_N, LARGEST_N - by_n, load)
        logs.append(replace(log, known={**log.known, "load_n": written}))
    return replace(case, logs=tuple(logs))


def taken_for(case: Case, effect: str) -> bool:
    """Whether another kind is seen where one effect is the only candidate, and named."""
    table = {effect: TABLE[effect]}
    problem = problem_from(case, rows_of(case), table.values(), describe)
    subject = Subject(case, problem, table, describe)
    path = beginning(problem, RULES, 0)
    evidence = path.rounds[0].search.first
    best = int(np.argmax(evidence.gain.sum(axis=0)))
    signature = problem.signatures[path.rounds[0].library.index(int(evidence.best[best]))]
    nothing = Interval(0.0, 0.0, 0.0)
    size = evidence.interval(best)
    cause = Cause(signature, size, 1.0, nothing, 0, 0.0, rivals=(), places=())
    model = refitted_with(subject, [cause], None)
    named = continued(subject, replace(path, causes=(cause,), answers=path.rounds), model, 0)
    return of_another_kind(subject, named, RULES, 0)


@pytest.mark.parametrize(
    ("law", "effect", "another"),
    [(slow, "hysteresis", True), (loop, "hysteresis", False), (slow, "creep", False),
     (loop, "creep", True), (bent, "wrong_weight", True)],
)  # fmt: skip
def test_what_the_table_lacks_is_not_what_it_resembles(
    law: Law, effect: str, *, another: bool
) -> None:
    assert taken_for(distorted(3, law), effect) is another


def test_a_wrong_weight_is_no_curve() -> None:
    assert not taken_for(mislabelled(0.3), "wrong_weight")


ALIKE = {"all": CELLS}


def beside(case: Case, *effects: str) -> bool:
    """Whether a kind without a name is seen where these effects are named on placements."""
    return of_another_kind(*named_both(case, *effects), RULES, 0)


@pytest.mark.parametrize("seed", [2, pytest.param(5, marks=pytest.mark.slow)])
def test_a_crosstalk_that_the_table_lacks_is_no_place_of_one_cell(seed: int) -> None:
    crosstalk = ("crosstalk", ALIKE, {"all.crosstalk": 0.02})
    moved: Hidden = ("cell_position", {"left_fl": ("left_fl",)},
             {"left_fl.cell_correction_x": 2e-3, "left_fl.cell_correction_y": 1e-3})  # fmt: skip
    assert beside(placed(seed, crosstalk), "cell_position")
    assert not beside(placed(seed, moved), "cell_position")
    assert not beside(placed(seed, crosstalk), "crosstalk")


@pytest.mark.parametrize("seed", [2, pytest.param(5, marks=pytest.mark.slow)])
def test_a_bypass_that_the_table_lacks_is_no_crosstalk_and_a_curve(seed: int) -> None:
    bypass: Hidden = ("load_bypass", {"left": ("left",)},
              {"left.load_bypass": 0.08, "left.bypass_load": 15.0})  # fmt: skip
    crosstalk = ("crosstalk", ALIKE, {"all.crosstalk": 0.02})
    bent = ("nonlinearity", ALIKE, {"all.quadratic": 2e-3})
    assert beside(placed(seed, bypass), "crosstalk", "nonlinearity")
    assert not beside(placed(seed, crosstalk, bent), "crosstalk", "nonlinearity")


def test_a_weight_that_adds_nothing_beside_a_curve_is_no_wrong_weight() -> None:
    def bent_little(x: FloatArray, _: FloatArray) -> FloatArray:
        return np.asarray(2.2e-4 * x**2)

    assert taken_for(distorted(3, bent_little), "wrong_weight")
    assert not taken_for(mislabelled(0.07), "wrong_weight")


def test_a_step_that_any_matrix_of_the_transducer_explains_is_no_step() -> None:
    def hung(effect: str, by_n: float) -> Case:
        chain, values = distorting(effect, "fl", {"coupling_fx_fy": 0.08})
        logs = hung_logs(4, chain, values)
        return hang_case(stepped({"fl": logs["fl"][:2]}, "fl", axis=0, share=0.5, step_n=by_n))

    assert taken_for(hung("cross_coupling", 0.0), "offset_change")
    assert not taken_for(hung("", 0.5), "offset_change")
