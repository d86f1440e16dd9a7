"""Columns that a recipe names and no log has, where the quantity is one that logs may lack."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.recipe_text import recipe_text
from footcal_cli.sniff.several import parts_of
from tests.conftest import Run
from tests.sniff.hung_robots import DOWN, legs_in_one_file, yawed

LEGS = {"LF": yawed(0.0), "RF": yawed(0.0), "LH": yawed(0.0), "RH": yawed(0.0)}


@pytest.fixture
def recipe(tmp_path: Path) -> Path:
    """A recipe of four legs in one file for each orientation, as init writes it."""
    paths = legs_in_one_file(tmp_path, {k: f"hang_{k}.csv" for k in DOWN}, LEGS, "Phi_{leg} [°]")
    (part,), _ = parts_of([guess_file(path) for path in paths])
    path = tmp_path / "r.toml"
    path.write_text(recipe_text([part], path, "--recipe r.toml"), encoding="utf-8")
    return path


def _refused(run: Run, recipe: Path) -> str:
    answer = run("hang-calib", "--recipe", recipe, "--out", recipe.parent / "o", "--no-pictures")
    assert answer.exit_code == 2, answer.out
    return answer.err


@pytest.mark.parametrize(("wrong", "key"), [("Phx_LF [°]", "fl"), ("Phi_RFF [°]", "fr")])
def test_a_mistyped_shaft_angle_is_named(run: Run, recipe: Path, wrong: str, key: str) -> None:
    leg = {"fl": "LF", "fr": "RF"}[key]
    text = recipe.read_text(encoding="utf-8").replace(f"Phi_{leg} [°]", wrong)
    recipe.write_text(text, encoding="utf-8")
    said = _refused(run, recipe)
    assert f"r.toml: [files.wide.{key}] phase_rad = '{wrong}': no log has that column" in said
    assert f"did you mean 'Phi_{leg} [°]'?" in said


def test_a_mistyped_temperature_is_named(run: Run, recipe: Path) -> None:
    text = recipe.read_text(encoding="utf-8")
    recipe.write_text(text.replace("[columns]\n", '[columns]\ntemperature_degc = "temp_C"\n'),
                      encoding="utf-8")  # fmt: skip
    assert "[columns] temperature_degc = 'temp_C': no log has that column" in _refused(run, recipe)


def test_a_column_that_one_of_several_logs_has_is_read_there(run: Run, recipe: Path) -> None:
    log = recipe.parent / "hang_xu.csv"
    pd.read_csv(log).assign(temp_C=21.0).to_csv(log, index=False)
    text = recipe.read_text(encoding="utf-8")
    recipe.write_text(text.replace("[columns]\n", '[columns]\ntemperature_degc = "temp_C"\n'),
                      encoding="utf-8")  # fmt: skip
    answer = run("hang-calib", "--recipe", recipe, "--out", recipe.parent / "o", "--no-pictures")
    assert answer.exit_code == 0, answer.err
