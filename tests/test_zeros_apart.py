"""Rows of a stand in which the robot hung: zeros alone, named by one text or by several."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.commands import option_tables
from footcal_cli.errors import DataError
from footcal_cli.recipe import read_recipe
from footcal_cli.tables.columns import zeros_table
from footcal_cli.tables.table import Table, read_table

STANCES = ("air_start", "1", "2", "3", "air_end")


def zeros(folder: Path, said: str) -> Table:
    """The rows of a stand that a recipe takes for zeros."""
    log = folder / "stand.csv"
    rows = [f"{stance},{i},{10 + i}" for i, stance in enumerate(STANCES)]
    log.write_text("\n".join(["stance,toe_N,heel_N", *rows]) + "\n", encoding="utf-8")
    path = folder / "r.toml"
    path.write_text(
        f'[[files]]\nmatch = "stand.csv"\nrate_hz = 1\nzeros_where = {{ stance = {said} }}\n'
        '[columns]\ntoe_counts = "toe_N"\nheel_counts = "heel_N"\n', encoding="utf-8",
    )  # fmt: skip
    recipe = read_recipe(path, option_tables())
    return read_table(log, zeros_table(["toe", "heel"]), recipe.reading(log), gravity_mps2=9.8)


@pytest.mark.parametrize(
    ("said", "rows"),
    [('"air_end"', [4]), ('["air_start", "air_end"]', [0, 4]), ('["2", "air_end"]', [2, 4])],
)
def test_rows_of_one_text_or_of_several(said: str, rows: list[int], tmp_path: Path) -> None:
    np.testing.assert_array_equal(zeros(tmp_path, said).number("toe_counts"), rows)


def test_a_text_that_no_row_has(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r'no row has stance = "air_ende" .*\'air_end\''):
        zeros(tmp_path, '["air_start", "air_ende"]')
