"""Two causes at once: the linear screening against brute force, the path against one by one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest

from footcal_cli.core.diagnosis import investigation, material, ways
from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.investigation import investigate
from footcal_cli.core.diagnosis.library import Library, library
from footcal_cli.core.diagnosis.pairs import likely_pairs
from footcal_cli.core.diagnosis.path import Path, beginning
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.diagnosis.two_at_once import together
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import rows_of
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray
from tests.core.diagnosis_world import (
    library_effects,
    make_world,
    noise_of,
    problem_of,
    sized,
)
from tests.core.test_diagnosis_bridge import BENCH, ROBOT, names, walk_case, weights_case

RULES = Rules()


def world_with(seed: int, *effects: str, rho: float = 0.6) -> tuple[Problem, Library]:
    """A world with effects of the library hidden in white noise, and its candidates."""
    rng = np.random.default_rng(seed)
    world = make_world(rng)
    hidden = sum(sized(world, library_effects(world)[name][0][1], rho) for name in effects)
    problem = problem_of(world, noise_of(world, "white", rng) + hidden)
    grams, _ = whitened_grams(problem, problem.columns[:, :0])
    nothing = np.zeros(len(problem.signatures))
    return problem, library(problem, grams, problem.visible(problem.left()), nothing, RULES)


def explained(lib: Library, candidates: tuple[int, ...]) -> float:
    """Squared residual that candidates explain beside the calibration, by normal equations."""
    inner = lib.grams.inner.summed(np.arange(lib.grams.inner.size))
    last = inner.shape[0] - 1

    def left(base: list[int]) -> float:
        own = inner[np.ix_(base, base)]
        fitted = np.linalg.lstsq(own, inner[base, last], rcond=1e-12)[0]
        return float(inner[last, last] - inner[base, last] @ fitted)

    base = [int(c) for c in lib.grams.calibration]
    return left(base) - left([*base, *(int(lib.grams.candidates[c]) for c in candidates)])


@pytest.mark.parametrize("seed", [31, 32])
def test_the_likeliest_pair_is_that_of_a_search_through_all(seed: int) -> None:
    """Least squares with every two candidates of different effects, one pair after the other."""
    _, lib = world_with(seed, "hysteresis", "shear")
    signatures = lib.problem.signatures
    first, second = likely_pairs(lib, RULES)[0]
    best = explained(lib, (first, second))
    power = np.sqrt(np.diag(lib.products))
    cos = np.abs(lib.products) / np.outer(power, power)
    for pair in combinations(np.flatnonzero(lib.testable).tolist(), 2):
        alike = cos[pair] >= RULES.alike_together
        if not alike and signatures[pair[0]].effect != signatures[pair[1]].effect:
            assert explained(lib, pair) <= best * (1 + 1e-9)


def test_pairs_are_the_hidden_ones_and_resemble_each_other_in_one_at_most() -> None:
    hit = 0
    for seed in range(40, 46):
        _, lib = world_with(seed, "hysteresis", "shear")
        pairs = likely_pairs(lib, RULES)
        named = [{lib.problem.signatures[i].effect for i in pair} for pair in pairs]
        hit += named[0] == {"hysteresis", "shear"}
        power = np.sqrt(np.diag(lib.products))
        cos: FloatArray = np.abs(lib.products) / np.outer(power, power)
        assert len(pairs) == RULES.most_pairs
        (a, b), (c, d) = pairs
        for one, other in ((c, d), (d, c)):
            assert min(cos[a, one], cos[b, other]) <= RULES.look_alike
    assert hit == 6


@pytest.mark.parametrize("first", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_whichever_of_two_it_begins_with_both_are_named(first: int) -> None:
    everyone = {"all": BENCH.channels}
    case = weights_case(
        21,
        ("nonlinearity", everyone, {"all.quadratic": 1e-3}),
        ("hysteresis", everyone, {"all.hysteresis_width": 0.2}),
    )
    table = {name: TABLE[name] for name in ("nonlinearity", "hysteresis", "creep")}
    rows = rows_of(case)
    problem = problem_from(case, rows, table.values(), describe)
    subject = Subject(case, problem, table, describe)
    path = beginning(problem, RULES, 0)
    pair = likely_pairs(path.rounds[0].library, RULES)[0]
    both = together(subject, path, pair[first], 0)
    assert both is not None
    assert both.model is not None
    assert {c.signature.effect for c in both.causes} == {"nonlinearity", "hysteresis"}
    for cause, answer in zip(both.causes, both.answers, strict=True):
        assert answer.causes[0].signature.effect == cause.signature.effect
    sizes = dict(zip(both.model.names, both.model.intervals, strict=True))
    for name, true in (("all.quadratic", 1e-3), ("all.hysteresis_width", 0.2)):
        assert sizes[name].low <= true <= sizes[name].high


@pytest.mark.slow
def test_what_one_at_a_time_cannot_explain_two_at_once_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hinge resembles both and takes the first step; beside it the rest fits nothing."""
    cell = ROBOT.channels[0]
    case = walk_case(
        1,
        ("hysteresis", {"all": ROBOT.channels},
         {"all.hysteresis_width": 0.5, "all.hysteresis_reach": 3.0}),
        ("crosstalk", {cell: (cell,)}, {f"{cell}.crosstalk": 0.1, f"{cell}.crosstalk_from": 0.0}),
    )  # fmt: skip
    table = {n: TABLE[n] for n in ("hysteresis", "crosstalk", "nonlinearity", "dead_zone", "hinge")}
    found = investigate(case, table, describe)
    assert found.verdict == "named"
    assert names(found) == {"hysteresis", "crosstalk"}
    monkeypatch.setattr("footcal_cli.core.diagnosis.ways.likely_pairs", lambda *_: [])
    assert investigate(case, table, describe).verdict == "unknown"


def test_no_pair_has_a_size_that_cannot_be() -> None:
    """Half a swap of two channels explains much, and is no swap."""
    _, lib = world_with(40, "hysteresis", "shear")
    impossible = tuple(
        replace(s, lower=1e6, upper=2e6) if s.effect == "hysteresis" else s
        for s in lib.problem.signatures
    )
    limited = replace(lib, problem=replace(lib.problem, signatures=impossible))
    assert "hysteresis" in {impossible[i].effect for i in likely_pairs(lib, RULES)[0]}
    for pair in likely_pairs(limited, RULES):
        assert "hysteresis" not in {impossible[i].effect for i in pair}


CLEAR, LEFT = Verdict.NAMED, Verdict.UNKNOWN


@pytest.mark.parametrize(
    ("first", "second", "taken"),
    [
        ((90.0, CLEAR), (95.0, CLEAR), 90.0),
        ((40.0, LEFT), (60.0, CLEAR), 60.0),
        ((90.0, LEFT), (60.0, CLEAR), None),
        ((45.0, CLEAR), (48.0, CLEAR), None),
    ],
)
def test_a_pair_removes_as_much_as_any_path_that_left_something(
    monkeypatch: pytest.MonkeyPatch,
    first: tuple[float, Verdict],
    second: tuple[float, Verdict],
    taken: float | None,
) -> None:
    """One cause at a time removes 50 and leaves something; what a pair removes, and its verdict."""
    library = SimpleNamespace(
        problem=SimpleNamespace(
            signatures=[SimpleNamespace(effect=str(i), where="") for i in range(5)]
        )
    )
    nothing = Path((), None, (), (SimpleNamespace(library=library),), None, removed=50.0)  # type: ignore[arg-type]
    tried = {0: first, 2: second}
    verdicts = dict(tried.values())
    pairs = [(0, 1), (0, 4), (2, 3)]
    monkeypatch.setattr(ways, "likely_pairs", lambda *_: pairs)
    monkeypatch.setattr(
        ways,
        "together",
        lambda _subject, path, stronger, _seed: replace(path, removed=tried[stronger][0]),
    )
    monkeypatch.setattr(ways, "as_proposed", lambda *_: None)
    monkeypatch.setattr(ways, "grown", lambda _subject, path, *_: path)
    monkeypatch.setattr(ways, "as_one_mixture", lambda _subject, path, _seed: path)
    monkeypatch.setattr(ways, "at_its_size", lambda _subject, path: path)
    monkeypatch.setattr(ways, "judged", lambda _subject, path, *_: (verdicts[path.removed], 1.0))
    found = ways.another_way(None, nothing, RULES, 0)  # type: ignore[arg-type]
    assert (None if found is None else found[0].removed) == taken


def test_a_pair_is_refitted_as_proposed_where_none_grows_from_its_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Paths that left something before it are kept, for what single blocks say of both."""
    library = SimpleNamespace(
        problem=SimpleNamespace(
            signatures=[SimpleNamespace(effect=str(i), where="") for i in range(3)]
        )
    )
    nothing = Path((), None, (), (SimpleNamespace(library=library),), None, removed=50.0)  # type: ignore[arg-type]
    monkeypatch.setattr(ways, "likely_pairs", lambda *_: [(0, 1), (0, 2)])
    monkeypatch.setattr(ways, "together", lambda _subject, path, *_: replace(path, removed=60.0))
    monkeypatch.setattr(
        ways, "as_proposed",
        lambda _subject, path, pair, *_: replace(path, removed=90.0 + pair[1]),
    )  # fmt: skip
    monkeypatch.setattr(ways, "grown", lambda _subject, path, *_: path)
    monkeypatch.setattr(ways, "as_one_mixture", lambda _subject, path, _seed: path)
    monkeypatch.setattr(ways, "at_its_size", lambda _subject, path: path)
    monkeypatch.setattr(
        ways, "judged",
        lambda _subject, path, *_: (CLEAR if path.removed == 92.0 else LEFT, 1.0),
    )  # fmt: skip
    found = ways.another_way(None, nothing, RULES, 0)  # type: ignore[arg-type]
    assert found is not None
    assert found[0].removed == 92.0
    assert [path.removed for path in found[0].instead] == [60.0, 91.0]


@pytest.mark.parametrize(
    ("holds", "verdict", "names"),
    [
        ((True, True), Verdict.NAMED, 2),
        ((False, True), Verdict.AMBIGUOUS, 1),
        # neither: the first one is what came nearest
        ((False, False), Verdict.UNKNOWN, 2),
    ],
)
def test_a_pair_that_does_not_hold_without_blocks_leaves_the_word_to_one_cause(
    monkeypatch: pytest.MonkeyPatch, holds: tuple[bool, bool], verdict: Verdict, names: int
) -> None:
    case = walk_case(seed=0)
    pair, single = (SimpleNamespace(causes=range(n), once=False) for n in (2, 1))
    answers = [(pair, Verdict.NAMED, 0.99), (single, Verdict.AMBIGUOUS, 0.9)]
    kept = dict(zip((2, 1), holds, strict=True))
    monkeypatch.setattr(investigation, "problem_from", lambda *_: None)
    monkeypatch.setattr(investigation, "beginning", lambda *_: None)
    monkeypatch.setattr(investigation, "is_large", lambda *_: True)
    monkeypatch.setattr(investigation, "odd_spell", lambda *_: None)
    monkeypatch.setattr(investigation, "by_the_likeliest", lambda _, stands, *__: stands)
    monkeypatch.setattr(investigation, "_searched", lambda *_, **__: iter(answers))
    monkeypatch.setattr(
        investigation,
        "standing",
        lambda _subject, path, said, *_: SimpleNamespace(
            path=path, verdict=said, stable=0.0, holds=kept[len(path.causes)]
        ),
    )

    @dataclass(frozen=True)
    class Said:
        verdict: Verdict
        path: SimpleNamespace
        found: tuple[()] = ()
        odd: None = None

    monkeypatch.setattr(investigation, "named", lambda _, stands: Said(stands.verdict, stands.path))
    monkeypatch.setattr(investigation, "_sized", lambda *_: True)
    monkeypatch.setattr(investigation, "_confirmed", lambda *_: True)
    monkeypatch.setattr(
        investigation, "_without_name", lambda _subject, path, said, _share: Nameless(said, path)
    )
    found = investigate(case, TABLE, describe, RULES)
    assert (found.verdict, len(found.path.causes)) == (verdict, names)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("causes", "single_rows", "left", "taken"),
    [
        (2, True, CLEAR, True),
        (2, True, LEFT, False),
        (1, True, CLEAR, False),
        (2, False, CLEAR, False),
    ],
)
def test_a_stand_is_searched_once_more_without_the_first_of_several_causes(
    monkeypatch: pytest.MonkeyPatch, causes: int, single_rows: bool, left: Verdict, taken: bool
) -> None:
    """The first is tried no more; what then leaves something is no answer, as in a series."""
    named = tuple(SimpleNamespace(signature=SimpleNamespace(effect=n)) for n in ("slip", "mass"))
    begun: list[set[str]] = []

    def begin(_problem: None, _rules: Rules, _seed: int, without: set[str]) -> SimpleNamespace:
        begun.append(without)
        return SimpleNamespace()

    monkeypatch.setattr(ways, "has_single_rows", lambda _: single_rows)
    monkeypatch.setattr(ways, "beginning", begin)
    monkeypatch.setattr(ways, "grown", lambda _subject, path, *_: path)
    monkeypatch.setattr(ways, "at_its_size", lambda _subject, path: path)
    monkeypatch.setattr(ways, "judged", lambda *_: (left, 0.9))
    path, subject = SimpleNamespace(causes=named[:causes]), SimpleNamespace(problem=None)
    found = ways.without_first(subject, path, RULES, 0)  # type: ignore[arg-type]
    assert (found is not None) is taken
    assert begun == ([{"slip"}] if causes > 1 and single_rows else [])


@pytest.mark.parametrize(
    ("removed", "large", "verdict"),
    [
        (0.99, True, Verdict.AMBIGUOUS),
        (0.99, False, Verdict.AMBIGUOUS),
        (0.5, False, Verdict.NONE),
        (0.5, True, Verdict.UNKNOWN),
    ],
)
def test_what_leaves_next_to_nothing_is_an_answer_and_a_large_residual_is_never_none(
    monkeypatch: pytest.MonkeyPatch, removed: float, large: bool, verdict: Verdict
) -> None:
    """A set of rivals of which no test but the share that is asked for stands in the way."""
    signature = SimpleNamespace(effect="crosstalk")
    cause = SimpleNamespace(p=0.0, signature=signature, rivals=())
    path = SimpleNamespace(causes=(cause,), share=removed, shorter=None)

    def judge(_subject: None, _path: None, rules: Rules, _seed: int) -> tuple[Verdict, float]:
        return Verdict.AMBIGUOUS if rules.share_set <= 0.8 else Verdict.UNKNOWN, 0.8

    for name, value in {
        "jumped": None, "grown": path, "as_one_mixture": path, "at_its_size": path,
        "matters_of": False, "second_cause": None, "another_way": None, "without_first": None,
        "form_matters": False,
    }.items():  # fmt: skip
        monkeypatch.setattr(investigation, name, lambda *_, value=value, **__: value)
    monkeypatch.setattr(investigation, "judged", judge)
    subject = SimpleNamespace(
        problem=SimpleNamespace(pieces=True), case=SimpleNamespace(finding_nm=0.0)
    )
    answers = investigation._searched(subject, None, RULES, 0, large=large)  # type: ignore[arg-type]
    assert next(answers)[1] is verdict


@pytest.mark.parametrize(
    ("rms", "p", "verdict"),
    [(2.0, 1e-3, Verdict.UNKNOWN), (0.5, 1e-3, Verdict.NONE), (2.0, 0.3, Verdict.NONE)],
)
def test_what_surely_repeats_by_as_much_as_matters_is_not_nothing(
    monkeypatch: pytest.MonkeyPatch, rms: float, p: float, verdict: Verdict
) -> None:
    part = material.Nameless("fz", "N", rms=rms, whole=9.0, white=9.0, smallest=1.0)
    for name, value in {"nameless_beside": (part,), "gains_of": (), "_found": ()}.items():
        monkeypatch.setattr(investigation, name, lambda *_, value=value, **__: value)
    last = SimpleNamespace(before=SimpleNamespace(p=p), rules=RULES)
    problem = SimpleNamespace(law=None)
    path, subject = SimpleNamespace(rounds=(last,)), SimpleNamespace(problem=problem, case=None)
    answer = investigation._without_name(subject, path, Verdict.NONE, 0.0)  # type: ignore[arg-type]
    assert answer.verdict is verdict


@dataclass(frozen=True)
class Nameless:
    """An answer that names nothing."""

    verdict: Verdict
    path: SimpleNamespace
    stable: float = 1.0
    found: tuple[()] = ()
    odd: None = None
