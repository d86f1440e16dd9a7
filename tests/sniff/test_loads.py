"""Loads that stand in several columns: what a larger unit leaves over, or two that disagree."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
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
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert plan.blanks[0].why == "two columns of loads, lb and oz, that do not agree"


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


def test_a_fraction_is_refused(run: Run, tmp_path: Path) -> None:
    """Of `1/2 lb` the 2 was read."""
    log = tmp_path / "log.csv"
    log.write_text("load,counts\n0 lb,100\n1/2 lb,150\n1 lb,200\n2 lb,300\n3 lb,400\n")
    answer = run("init", log)
    assert answer.exit_code == 3
    assert "'1/2 lb': a fraction is no number here" in answer.err


def straight(newtons: Sequence[float]) -> list[int]:
    return [round((n - BIAS) / SCALE) for n in newtons]


@pytest.mark.parametrize(
    ("header", "factor"), [("load_kg,load_g", 1000.0), ("lb,oz", 16.0), ("load_N,load_g", 0.0)]
)
def test_a_small_load_in_two_units_is_not_added_to_itself(
    run: Run, header: str, factor: float, tmp_path: Path
) -> None:
    """Below one of the larger unit the same load twice looks like pounds and ounces."""
    unit_n = {"load_kg,load_g": 9.80665, "lb,oz": NEWTONS["lb,oz"][0], "load_N,load_g": 1.0}[header]
    loads = [0.0, 0.125, 0.25, 0.5, 0.75]
    other = [x * (factor or 1000.0 / 9.80665) for x in loads]
    counts = straight([x * unit_n for x in loads])
    rows = zip(loads, other, counts, strict=True)
    log = tmp_path / "log.csv"
    log.write_text("\n".join([f"{header},counts", *(f"{a},{b:.6g},{c}" for a, b, c in rows)]))
    recipe = tmp_path / "my.toml"
    answer = run("init", log, "-o", recipe)
    assert "once more, not added to it" in answer.out
    assert run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out").exit_code == 0
    fitted = json.loads((tmp_path / "out/parameters.json").read_text())["parameters"]
    step = 1.0 / (counts[-1] - counts[0])  # a count of the converter
    assert fitted["cell.scale"]["value"] == pytest.approx(SCALE, rel=step)


@pytest.mark.parametrize("header", ["load1_kg,load2_kg", "load1,load2", "load_kg,load2"])
@pytest.mark.parametrize("cells", [1, 3])
def test_two_loads_that_disagree_are_asked_about(header: str, cells: int, tmp_path: Path) -> None:
    one, two = [0.0, 0.0, 1.0, 2.0, 4.0], [0.0, 3.0, 0.0, 1.0, 3.0]
    counts = straight([9.80665 * (a + b) for a, b in zip(one, two, strict=True)])
    names = ",".join(f"{c}_counts" for c in ("fl", "fr", "rl")[:cells])
    lines = [
        f"{a},{b}," + ",".join([str(c)] * cells)
        for a, b, c in zip(one, two, counts, strict=True)
    ]  # fmt: skip
    log = tmp_path / "log.csv"
    log.write_text("\n".join([f"{header},{names}", *lines]))
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert "do not agree" in plan.blanks[0].why
    assert plan.entries["load_n"].unit == "?"


def test_the_load_that_the_readings_follow_alone_is_meant(run: Run, tmp_path: Path) -> None:
    """A weight of the day before next to the load: the recipe is written, and says what it took."""
    loads, other = [0.0, 1.0, 2.0, 4.0, 6.0, 3.0, 1.0, 0.0], [5.0, 3, 5, 2, 5, 1, 4, 2]
    counts = straight([9.80665 * x for x in loads])
    lines = [f"{b},{a},{c}" for a, b, c in zip(loads, other, counts, strict=True)]
    log = tmp_path / "log.csv"
    log.write_text("\n".join(["weight2_kg,weight1_kg,counts", *lines]))
    recipe = tmp_path / "my.toml"
    answer = run("init", log, "-o", recipe)
    assert "check: weight2_kg: left out, the readings follow weight1_kg alone" in answer.out
    assert run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out").exit_code == 0


def test_pounds_and_ounces_in_words(tmp_path: Path) -> None:
    log = written(tmp_path / "log.csv", "lb,oz", [(0, 0), (0, 8), (1, 0), (2, 4), (4, 12)])
    log.write_text(log.read_text().replace("lb,oz", "Pounds,Ounces"))
    plan = plan_of(guess_file(log))
    assert plan is not None
    load = plan.entries["load_n"].column
    assert load is not None
    assert dict(load.plus) == {"Ounces": "oz"}


@pytest.mark.parametrize("bits", [10, 12, 14, 18, 20])
def test_a_load_shows_the_sign_that_codes_lost(run: Run, bits: int, tmp_path: Path) -> None:
    """Over nine tenths of the range, which no gap between codes shows."""
    newtons = [0.0, 5.0, 10.0, 20.0, 30.0, 40.0]
    scale = 40.0 / (0.9 * 2**bits)
    codes = [round((n - 18.0) / scale) % 2**bits for n in newtons]
    log = tmp_path / "log.csv"
    log.write_text(
        "\n".join(["load_N,adc", *(f"{n},{c}" for n, c in zip(newtons, codes, strict=True))])
    )
    recipe = tmp_path / "my.toml"
    assert run("init", log, "-o", recipe).exit_code == 0
    assert f"wraps_at = {2**bits}" in recipe.read_text()
    assert run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out").exit_code == 0
    fitted = json.loads((tmp_path / "out/parameters.json").read_text())["parameters"]
    assert fitted["cell.scale"]["value"] == pytest.approx(scale, rel=2 / 2**bits)


def test_a_load_shows_that_no_sign_was_lost(tmp_path: Path) -> None:
    """Three small weights and two large ones reach both ends of a converter, too."""
    kg = [0.0, 0.4, 0.8, 9.0, 9.4]
    rows = [f"{k},{round(200 + k * 1.7e6)}" for k in kg for _ in range(3)]
    log = tmp_path / "log.csv"
    log.write_text("\n".join(["load_kg,raw", *rows]))
    (reading,) = guess_file(log).of("reading")
    assert reading.wraps_at is None


def test_a_table_whose_numbers_all_have_their_unit_behind_them(run: Run, tmp_path: Path) -> None:
    grams = [0, 500, 1000, 2000, 500, 0]
    rows = [f"{g} g;{round((g * 9.80665e-3 - BIAS) / SCALE)} counts" for g in grams]
    log, out = tmp_path / "typed.csv", tmp_path / "out"
    log.write_text("\n".join(["weight;display", *rows]) + "\n")
    assert run("init", log, "-o", tmp_path / "my.toml").exit_code == 0
    assert run("offline-fit", "--recipe", tmp_path / "my.toml", "--out", out).exit_code == 0
    fitted = json.loads((out / "parameters.json").read_text())["parameters"]
    assert fitted["cell.scale"]["value"] == pytest.approx(SCALE, rel=1e-5)
