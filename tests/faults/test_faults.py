"""A sample of the corpus, and that the judge can find fault."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from footcal_cli.errors import UsageError
from footcal_cli.tables.units import parse_unit
from tests.conftest import REPOSITORY
from tests.faults.bases import BASES
from tests.faults.corpus import drawn, possible, prepared
from tests.faults.injected import kills, machine_faults, races
from tests.faults.judging import Case, attempt
from tests.faults.log_relations import log_relations
from tests.faults.mutations import ANY, Mutation
from tests.faults.promises import PROMISES, TURNED_ROUND
from tests.faults.relations import relation_jobs
from tests.faults.running import Job, outcomes
from tests.faults.world_relations import world_relations

QUICK = ("check_weights", "check_walk", "check_hang", "apply", "together", "export", "convert")
SAMPLE = [case for case in drawn(len(possible()), seed=25) if case.base.name in QUICK][:40]


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


@pytest.mark.parametrize(("base", "file", "name"), [
    ("stand", "stand_cells.csv", "one row"), ("stand", "stand_cells.csv", "reversed"),
    ("stand", "stand_cells.csv", "a cell is '1e308'"), ("stand", "stand_body.csv", "two rows"),
    ("stand", "stand_body.csv", "all the same"), ("stand", "biped.toml", "folder in its place"),
    ("stand", "biped.toml", "pipe in its place"), ("stand", "biped.toml", "empty"),
    ("stand", "biped.toml", "power tower as unit"), ("stand", "cells.json", "negative sd"),
    ("stand", "cells.json", "covariance of another shape"),
    ("stand", "cells.json", "nested 100000 deep"), ("walk", "walk_cells.csv", "two rows"),
    ("hang", "hang.csv", "two rows"), ("hang", "hang.csv", "non-UTF-8 byte late in the file"),
    ("together", "biped.toml", "unit of another quantity"),
    ("check_hang", "hexapod.toml", "misspelt canonical name"),
])  # fmt: skip
def test_ordinary_causes_are_no_internal_error(
    base: str, file: str, name: str, inputs: Path, tmp_path: Path
) -> None:
    (mutation,) = [m for b, f, m in possible() if (b, f, m.name) == (base, file, name)]
    outcome = attempt(Case(BASES[base], file, mutation, 4), inputs, tmp_path / "case")
    assert outcome.violations == ()
    assert outcome.exit_code in {2, 3}


def test_kg_under_the_name_of_newtons_is_bad_for_cells_loaded_together(
    inputs: Path, tmp_path: Path
) -> None:
    (mutation,) = [m for b, _, m in possible() if b == "together" and m.name.startswith("kg under")]
    outcome = attempt(Case(BASES["together"], "together.csv", mutation, 4), inputs, tmp_path / "c")
    assert (outcome.level, outcome.violations) == ("bad", ())


@pytest.mark.parametrize("name", [
    "every log given twice", "counts times -1 plus 0", "rows in another order",
    *(pytest.param(of_a_file, marks=pytest.mark.slow) for of_a_file in (
        "CSV packed by gzip", "columns in the opposite order", "cells in another order",
    )),
])  # fmt: skip
def test_relations_of_cells_loaded_together_hold(name: str, inputs: Path, tmp_path: Path) -> None:
    every = relation_jobs((*log_relations(), *world_relations()), inputs)
    (job,) = [job for job in every if job.key == f"together | {name}"]
    assert job.run(tmp_path / "case").violations == ()


@pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")  # that of pytest-xdist
@pytest.mark.parametrize("part", [kills, machine_faults, races])
def test_an_injected_fault_of_each_kind_breaks_no_promise(
    part: Callable[[Path, int], list[Job]], inputs: Path, tmp_path: Path
) -> None:
    jobs = [job for job in part(inputs, 1) if job.key.startswith("check_weights")]
    for job in {job.family: job for job in jobs}.values():
        outcomes_ = list(outcomes([job], tmp_path, 1))
        assert [o.violations for o in outcomes_] == [()]


def test_the_corpus_is_large() -> None:
    relations = (*log_relations(), *world_relations())
    assert len(possible()) >= 1000
    assert len({relation.key for relation in relations}) >= 90


def test_every_promise_of_the_page_is_guarded_by_a_test() -> None:
    for test in (*(test for _, _, test in PROMISES), *(test for _, test in TURNED_ROUND)):
        file, _, name = test.partition("::")
        assert f"def {name}(" in (REPOSITORY / file).read_text(encoding="utf-8"), test


def test_a_tower_of_powers_is_no_unit() -> None:
    with pytest.raises(UsageError, match="is not the spelling of a unit"):
        parse_unit("s**9**9**9")
