"""A sample of the corpus, and that the judge can find fault."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.faults.bases import BASES
from tests.faults.corpus import drawn, possible, prepared
from tests.faults.judging import Case, attempt
from tests.faults.mutations import ANY, Mutation

QUICK = ("check_weights", "check_walk", "check_hang", "apply", "together", "export", "convert")
SAMPLE = [case for case in drawn(len(possible()), seed=25) if case.base.name in QUICK][:60]


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return prepared(tmp_path_factory.mktemp("faults") / "inputs", [BASES[name] for name in QUICK])


def test_a_drawn_corpus_holds_every_pair_once_before_any_comes_again() -> None:
    pairs = possible()
    cases = drawn(len(pairs) + 5, seed=3)
    first = {(c.base.name, c.file, c.mutation.name) for c in cases[: len(pairs)]}
    assert len(first) == len(pairs)
    assert drawn(40, seed=3) == cases[:40]


def test_what_a_refusal_should_be_is_demanded_of_the_command(inputs: Path, tmp_path: Path) -> None:
    untouched = Mutation("none", "nothing is wrong", lambda path, rng: None, codes=frozenset({3}))
    outcome = attempt(
        Case(BASES["check_weights"], "weights.csv", untouched, 0), inputs, tmp_path / "case"
    )
    assert outcome.violations == ("exit code 0, acceptable [3]",)


def test_wrong_data_called_good_are_found_out(inputs: Path, tmp_path: Path) -> None:
    wrong = Mutation("none", "nothing is wrong", lambda path, rng: None, wrong=True)
    outcome = attempt(Case(BASES["together"], "together.csv", wrong, 0), inputs, tmp_path / "c")
    assert outcome.violations == ("wrong data are called good",)


def test_numbers_that_move_in_silence_are_found_out(inputs: Path, tmp_path: Path) -> None:
    def half(path: Path, rng: object) -> None:
        head, *rows = path.read_text("utf-8").splitlines()
        at = head.split(",").index("left_fl_counts")
        cells = [row.split(",") for row in rows]
        for row in cells:
            row[at] = str(float(row[at]) + 5000)
        path.write_text("\n".join([head, *(",".join(row) for row in cells)]) + "\n", "utf-8")

    moved = Mutation("none", "zero of a cell moved", half)
    outcome = attempt(Case(BASES["together"], "together.csv", moved, 0), inputs, tmp_path / "c")
    assert [v.split(" by ")[0] for v in outcome.violations] == ["moved in silence: left_fl.bias"]


@pytest.mark.parametrize("case", SAMPLE, ids=lambda case: case.words)
def test_a_sample_of_the_corpus_breaks_no_promise(case: Case, inputs: Path, tmp_path: Path) -> None:
    assert case.mutation.codes <= ANY
    assert attempt(case, inputs, tmp_path / "case").violations == ()
