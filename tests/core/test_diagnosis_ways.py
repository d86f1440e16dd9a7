"""Two patterns of one mixture, and a second cause in what a name leaves that does not matter."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from footcal_cli.core.chain import Chain, link
from footcal_cli.core.diagnosis import ways
from footcal_cli.core.diagnosis.answer import Cause, Compared, Verdict
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.contenders import places_of, refitted_with
from footcal_cli.core.diagnosis.path import Path, as_one_mixture, beginning, continued
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects import TABLE
from footcal_cli.core.experiments import placements
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.parameters import ParameterSet
from footcal_cli.core.simulation.bench_logs import PlacementsPlan, placements_log
from tests.core.test_diagnosis_bridge import ROBOT, Hidden, affine, calibrated, distorted

RULES = Rules()
CELLS = tuple(c for c in ROBOT.channels if c.startswith("left"))


def placed(seed: int, *hidden: Hidden) -> Case:
    """Weights on the holes of the left foot."""
    values = {n: v for n, v in calibrated(seed).items() if n.startswith("left")}
    chain = Chain((link(TABLE["scale_bias"], CELLS),))
    plan = PlacementsPlan(loads_n=(4.9, 19.6, 40.0), repeats=3)
    log = placements_log(ROBOT, "left", plan, *distorted(chain, values, *hidden), seed=seed).log
    free = tuple(p for p in affine(calibrated(seed)) if p.name.startswith("left"))
    return Case(
        placements.EXPERIMENT, (log,), chain, values, ParameterSet(free),
        tolerance_n=0.02, tolerance_nm=0.001, groups=dict.fromkeys(CELLS, "left"),
    )  # fmt: skip


def named_both(case: Case, *effects: str) -> tuple[Subject, Path]:
    """The path with two causes, each where it explains most."""
    table = {name: TABLE[name] for name in effects}
    problem = problem_from(case, rows_of(case), table.values(), describe)
    subject = Subject(case, problem, table, describe)
    path = beginning(problem, RULES, 0)
    evidence, library = path.rounds[0].search.first, path.rounds[0].library
    gain, nothing = evidence.gain.sum(axis=0), Interval(0.0, 0.0, 0.0)
    causes = []
    for effect in effects:
        mine = [c for c, (name, *_) in enumerate(library.causes) if name == effect]
        best = max(mine, key=lambda c: float(gain[c]))
        signature = problem.signatures[library.index(int(evidence.best[best]))]
        size = evidence.interval(best)
        causes.append(Cause(signature, size, 1.0, nothing, 0, 0.0, rivals=(), places=()))
    model = refitted_with(subject, causes, refitted_with(subject, causes[:1], None))
    begun = replace(path, causes=tuple(causes), answers=path.rounds * 2)
    return subject, continued(subject, begun, model, 0)


def each_elsewhere() -> tuple[Subject, Path]:
    """Two patterns of mixtures where every cell is elsewhere by a shift of its own."""
    rng = np.random.default_rng(3)
    shifts = {
        f"{c}.cell_correction_{axis}": float(by)
        for c in CELLS
        for axis, by in zip("xy", 1e-3 * rng.normal(size=2), strict=True)
    }
    case = placed(3, ("cell_position", {c: (c,) for c in CELLS}, shifts))
    return named_both(case, "cell_position", "crosstalk")


def test_two_patterns_of_a_mixture_are_one_cause_and_neither_is_certain() -> None:
    subject, path = each_elsewhere()
    one = as_one_mixture(subject, path, 0)
    assert len(one.causes) == 1
    (cause,) = one.causes
    named = {cause.signature.effect, *(s.effect for s in cause.rivals)}
    assert named == {"cell_position", "crosstalk"}
    assert one.removed >= 0.9 * path.removed  # both patterns are in the model still


@pytest.mark.parametrize(
    ("seeds", "least"), [((6, 14), 2), pytest.param((6, 12, 14), 2, marks=pytest.mark.slow)]
)
def test_two_patterns_that_leave_nothing_to_other_mixtures_stay_two(
    seeds: tuple[int, ...], least: int
) -> None:
    """A cell elsewhere and one that hears another, but for chance (`Rules.alpha_form`)."""
    hears, moved = CELLS[0], CELLS[2]
    stays = 0
    for seed in seeds:
        case = placed(
            seed,
            ("cell_position", {moved: (moved,)},
             {f"{moved}.cell_correction_x": 3e-3, f"{moved}.cell_correction_y": -2e-3}),
            ("crosstalk", {hears: (hears,)},
             {f"{hears}.crosstalk": 0.03, f"{hears}.crosstalk_from": 1.0}),
        )  # fmt: skip
        subject, path = named_both(case, "cell_position", "crosstalk")
        assert [cause.signature.where for cause in path.causes] == [moved, hears]
        both = replace(path, pair=True)
        stays += as_one_mixture(subject, both, 0) is both
    assert stays >= least


def test_each_cell_elsewhere_is_no_pair_of_patterns() -> None:
    """Looked for together too: what two patterns leave, further mixtures explain."""
    subject, path = each_elsewhere()
    assert len(as_one_mixture(subject, replace(path, pair=True), 0).causes) == 1


@pytest.mark.parametrize(
    "seed", [8, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (9, 10, 11))]
)
def test_a_contender_stands_where_all_its_sizes_explain_most(seed: int) -> None:
    """Where a cell is elsewhere along both axes, though one axis may do more next to it."""
    moved = CELLS[seed % 4]
    shifts = {f"{moved}.cell_correction_x": 1.8e-3, f"{moved}.cell_correction_y": -1.3e-3}
    case = placed(seed, ("cell_position", {moved: (moved,)}, shifts))
    table = {name: TABLE[name] for name in ("cell_position", "crosstalk")}
    problem = problem_from(case, rows_of(case), table.values(), describe)
    first = beginning(problem, RULES, 0).rounds[0]
    assert places_of(first.library, table, first.search.first.best) == {"cell_position": moved}


def test_a_curve_and_a_mixture_stay_two_causes() -> None:
    case = placed(
        4, ("nonlinearity", {"all": CELLS}, {"all.quadratic": -0.0013}),
        ("crosstalk", {"all": CELLS}, {"all.crosstalk": 0.0064, "all.crosstalk_from": 0.0}),
    )  # fmt: skip
    subject, path = named_both(case, "nonlinearity", "crosstalk")
    assert as_one_mixture(subject, path, 0) is path


@pytest.mark.parametrize(
    ("known", "left", "apart", "taken"),
    [("load_n", True, True, True), ("com_m", True, True, False), ("load_n", False, True, False),
     ("load_n", True, False, False)],
)  # fmt: skip
def test_a_second_cause_is_looked_for_in_what_is_surely_left_beside_known_loads(
    monkeypatch: pytest.MonkeyPatch, known: str, *, left: bool, apart: bool, taken: bool
) -> None:
    pair = SimpleNamespace(causes=(), model=None)
    monkeypatch.setattr(ways, "leftover", lambda *_: left)
    monkeypatch.setattr(ways, "another_way", lambda *_: (pair, Verdict.NAMED, 1.0))
    monkeypatch.setattr(ways, "are_distinct", lambda *_: apart)
    log = SimpleNamespace(known={known: None})
    subject = cast(Any, SimpleNamespace(case=SimpleNamespace(logs=(log,)), table={}))
    path = cast(Any, SimpleNamespace(rounds=(SimpleNamespace(before=None),)))
    found = ways.second_cause(subject, path, RULES, 0)
    assert (found is not None) is taken


@pytest.mark.parametrize(
    ("leaves", "named", "apart", "taken"),
    [(1e-4, ("creep", "hysteresis"), True, True),
     (1e-4, ("creep", "hysteresis"), False, False),  # one is the form of the other
     (1e-4, ("cell_position", "crosstalk"), False, True),  # of mixtures another test says so
     (1e-4, ("creep", "hanging_plate"), True, False),  # no rival: it stands in for a form
     (0.1, ("creep", "hysteresis"), True, False)],
)  # fmt: skip
def test_what_no_rival_explains_alone_is_two_of_them(
    monkeypatch: pytest.MonkeyPatch, leaves: float, named: tuple[str, str], *, apart: bool,
    taken: bool,
) -> None:  # fmt: skip
    def signature(effect: str) -> Signature:
        return Signature(effect, effect, "all cells", "N")

    first, other = (named[0], "hysteresis" if named[0] == "creep" else named[1])
    nothing = Interval(0.0, 0.0, 0.0)
    alone = Cause(
        signature(first), nothing, 1.0, nothing, 0, 0.0, rivals=(signature(other),), places=(),
        compared={other: Compared(nothing, leaves, leaves)},
    )  # fmt: skip
    causes = tuple(replace(alone, signature=signature(effect), rivals=()) for effect in named)
    pair = SimpleNamespace(causes=causes, effects=list(named), model=None)
    monkeypatch.setattr(ways, "another_way", lambda *_: (pair, Verdict.NAMED, 1.0))
    monkeypatch.setattr(ways, "are_distinct", lambda *_: apart)
    path = cast(Any, SimpleNamespace(causes=(alone,)))
    assert (ways.two_of_a_set(cast(Any, None), path, RULES, 0) is not None) is taken
    assert ways.two_of_a_set(cast(Any, None), cast(Any, pair), RULES, 0) is None  # two already


@pytest.mark.parametrize(
    ("verdict", "share", "apart", "taken"),
    [(Verdict.NAMED, 0.98, False, True),  # nothing is left beside both
     (Verdict.AMBIGUOUS, 0.98, False, False),  # the second may mend the form of a set
     (Verdict.AMBIGUOUS, 0.995, False, True),
     (Verdict.NAMED_UNKNOWN, 0.995, False, False),
     (Verdict.NAMED_UNKNOWN, 0.9, True, True),  # what is left is the form of one of them
     (Verdict.UNKNOWN, 1.0, True, False)],
)  # fmt: skip
def test_a_pair_explains_all_but_the_form_of_one_of_them(
    monkeypatch: pytest.MonkeyPatch, verdict: Verdict, share: float, *, apart: bool, taken: bool
) -> None:
    pair = cast(Any, SimpleNamespace(causes=(1, 2), effects=["a", "b"], model=None, removed=1.0))
    monkeypatch.setattr(ways, "found_both_ways", lambda *_: pair)
    monkeypatch.setattr(ways, "at_its_size", lambda _subject, path: path)
    monkeypatch.setattr(ways, "judged", lambda *_: (verdict, share))
    monkeypatch.setattr(ways, "are_distinct", lambda *_: apart)
    monkeypatch.setattr(ways, "_pairs_of", lambda *_: iter(()))
    found = ways.another_way(cast(Any, None), pair, RULES, 0)
    assert (found is not None) is taken
