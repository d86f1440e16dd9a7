"""Loads that stand in several columns: what a larger unit leaves over, or two that disagree."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of, why_not
from tests.conftest import Run

SCALE, BIAS = 2e-4, -1700.0
NEWTONS = {
    "lb,oz": (0.45359237 * 9.80665, 16),
    "st,lb": (6.35029318 * 9.80665, 14),
    "kg,g": (9.80665, 1000),
}


def written(path: Path, units: str, parts: Sequence[tuple[float, float]]) -> Path:
    """A table of loads in two units, and counts of a cell of known scale and bias."""
    newtons, share = NEWTONS[units]
    rows = [
        f"{whole:g},{part:g},{round((newtons * (whole + part / share) - BIAS) / SCALE)}"
        for whole, part in parts
    ]
    path.write_text("\n".join([f"{units},counts", *rows]) + "\n")
    return path


@pytest.mark.parametrize("units", NEWTONS)
def test_what_a_larger_unit_leaves_over_comes_on_top(run: Run, units: str, tmp_path: Path) -> None:
    whole, part = units.split(",")
    share = NEWTONS[units][1]
    parts = [(w, round(share * p)) for w in (0.0, 1.0, 2.0, 3.0) for p in (0.0, 0.25, 0.75)]
    log = written(tmp_path / "log.csv", units, parts)
    recipe = tmp_path / "my.toml"
    answer = run("init", log, "-o", recipe)
    assert answer.exit_code == 0
    assert f"{part} -> on top of {whole} in {part}" in answer.out
    out = tmp_path / "out"
    answer = run("offline-fit", "--recipe", recipe, "--out", out)
    assert answer.exit_code == 0
    assert f"'{whole} + {part}' read as " in answer.out
    fitted = json.loads((out / "parameters.json").read_text())["parameters"]
    assert fitted["cell.scale"]["value"] == pytest.approx(SCALE, rel=1e-5)


def test_ounces_that_make_pounds_and_pounds_beside_them_are_asked_about(tmp_path: Path) -> None:
    """16 oz and more next to pounds: neither column alone is surely the load."""
    parts = [
        (float(w), 3.0 * o) for w, o in zip(range(9), (9, 0, 4, 7, 1, 8, 2, 6, 3), strict=True)
    ]
    log = written(tmp_path / "log.csv", "lb,oz", parts)
    refusal = why_not(guess_file(log))
    assert plan_of(guess_file(log)) is None
    assert refusal is not None
    assert refusal[0] == "two columns of loads, lb and oz, that do not agree"


def test_the_same_load_in_two_units_is_one(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    rows = [
        f"{m / 2},{m / 2 * 9.80665:.3f},{round((m / 2 * 9.80665 - BIAS) / SCALE)}" for m in range(9)
    ]
    log.write_text("\n".join(["load_kg,load_N,counts", *rows]) + "\n")
    plan = plan_of(guess_file(log))
    assert plan is not None
    load = plan.entries["load_n"].column
    assert load is not None
    assert not load.plus


def test_one_row_with_two_units_in_one_value_is_refused(run: Run, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("load,counts\n0 lb,100\n1 lb,200\n1 lb 8 oz,250\n2 lb,300\n3 lb,400\n")
    answer = run("init", log)
    assert answer.exit_code == 3
    assert "'1 lb 8 oz': two units in one value" in answer.err
