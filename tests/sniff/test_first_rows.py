"""The first row below the names: data with a word in it, or units."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.rows import fields_of

RNG = np.random.default_rng(5)


def plate(first: str, last: str) -> list[str]:
    """A table of holes, the rows of the empty plate called by a word."""
    read = RNG.uniform(2, 20, (12, 3))
    rows = [f"{i + 2},{i + 1},{','.join(f'{v:.3f}' for v in r)}" for i, r in enumerate(read)]
    return ["Row,Hole,A_lbf,B_lbf,C_lbf", first, *rows, last]


def stances(first: str) -> list[str]:
    """A table of stances, decimal commas; the feet in the air are far from where they stand."""
    read = RNG.uniform(30, 90, (10, 4))
    rows = [
        f"{i + 1};" + ";".join(f"{v:.2f}" for v in r) + f";0.00{i % 3}"
        for i, r in enumerate(read)
    ]  # fmt: skip
    rows = [first, *rows, "luft_2;0.10;0.55;-0.31;1.20;0.412"]
    return ["Stand;va_N;vi_N;ha_N;hi_N;sohle_z", *(row.replace(".", ",") for row in rows)]


@pytest.mark.parametrize(
    ("lines", "rows"),
    [
        (plate("1,Tare,0.301,0.362,-0.690", "14,Tare,0.28,0.31,-0.70"), 14),
        (plate("1,leer,0.301,0.362,-0.690", "14,13,4.280,3.310,7.700"), 14),
        (stances("luft_1;0.15;0.45;-0.21;1.10;0.410"), 12),
        (plate("-,-,lbf,lbf,lbf", "14,13,4.280,3.310,7.700"), 13),
        (plate("1,1,lbf,lbf,lbf", "14,13,4.280,3.310,7.700"), 13),
        (plate("-,S/N,10231,10232,10233", "14,13,4.280,3.310,7.700"), 13),
        (plate("1,no,1,1,1", "14,13,4.280,3.310,7.700"), 13),
    ],
)
def test_a_first_row_with_a_word(lines: list[str], rows: int, tmp_path: Path) -> None:
    path = tmp_path / "sheet.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    file = guess_file(path)
    assert file.rows == rows
    assert file.text.layout.skip_below == (rows == 13)


@pytest.mark.parametrize(
    "line", ["1, 2.5 ,,x", '"a, b",2', "", " ", ",", "7", '3,"4 ""in"" 5"', "1;2"]
)
def test_fields_are_those_of_the_csv_module(line: str) -> None:
    read = next(csv.reader([line]), [])
    assert fields_of(line + "\n", ",") == [field.strip() for field in read]
