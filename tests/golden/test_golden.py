"""Every shipped recipe and sample gives what it gave; ``make golden`` after an explained change."""

from __future__ import annotations

import os

import pytest

from tests.golden.comparing import OUTPUTS, differences, golden
from tests.golden.runs import RUNS, Cabinet


@pytest.fixture(scope="module")
def cabinet(tmp_path_factory: pytest.TempPathFactory) -> Cabinet:
    return Cabinet(tmp_path_factory.mktemp("golden"))


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=() if run.quick else pytest.mark.slow) for n, run in RUNS.items()],
)
def test_the_output_is_what_it_was(name: str, cabinet: Cabinet) -> None:
    if RUNS[name].measured and not os.environ.get("FOOTCAL_DATA"):
        pytest.skip("FOOTCAL_DATA is not set: no measured data at hand")
    before = golden(name)
    assert before is not None, "no golden output: make golden WHY='a new run'"
    moved = differences(before, cabinet.kept(name))
    assert not moved, "\n".join([*moved, "explain it: make golden WHY='...'"])


def test_every_recipe_has_a_run_and_every_output_one_too() -> None:
    used = {word for run in RUNS.values() for word in run.words if word.startswith("recipes/")}
    shipped = {f"recipes/{p.name}" for p in (OUTPUTS.parents[2] / "recipes").glob("*.toml")}
    # the insole's two recordings are cut by tests.real.test_bench_data
    assert shipped - used == {"recipes/insole_plenum.toml"}
    assert {path.stem for path in OUTPUTS.glob("*.json")} == set(RUNS)


def test_a_difference_is_seen_and_named() -> None:
    before = {"parameters": {"a.scale": [2.0, 0.1, "estimated"]}, "verdict": "named"}
    assert differences(before, before) == []
    moved = {"parameters": {"a.scale": [2.001, 0.1, "estimated"]}, "verdict": "none"}
    assert differences(before, moved) == [
        "parameters, a.scale: moved by 0.01 sd (2 -> 2.001)", "verdict: named -> none",
    ]  # fmt: skip
    within = {"parameters": {"a.scale": [2.0 + 5e-8, 0.1, "estimated"]}, "verdict": "named"}
    assert differences(before, within) == []
    gone = {"parameters": {"a.scale": [2.0, 0.1, "fixed"]}, "verdict": "named"}
    assert differences(before, gone) == ["parameters, a.scale: estimated -> fixed"]
