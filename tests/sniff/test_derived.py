"""Columns that are worked out of others, and cells of a text column that are empty."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.clocks import nearly_increases
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.loads import loads_and_cells


def _cells(path: Path, text: str) -> list[str]:
    path.write_text(text)
    return [c.column for c in loads_and_cells(guess_file(path))[1]]


def test_a_quotient_is_no_cell_and_two_cells_are_no_quotient(tmp_path: Path) -> None:
    kg, counts, other = (1, 2, 3, 5), (1210, 2195, 3220, 5190), (905, 1480, 2120, 3290)
    rows = "\n".join(f"{m},{c},{o},{c / m:.1f}" for m, c, o in zip(kg, counts, other, strict=True))
    found = _cells(tmp_path / "a.csv", f"load_kg,a_counts,b_counts,counts_per_kg\n{rows}\n")
    assert found == ["a_counts", "b_counts"]


def test_extremes_without_a_mean_are_readings(tmp_path: Path) -> None:
    rows = "\n".join(f"{m},{1000 * m + 7 * m % 5},{1100 * m + 9}" for m in (0, 1, 2, 5, 9))
    assert len(_cells(tmp_path / "a.csv", f"load_kg,adc_min,adc_max\n{rows}\n")) >= 1


@pytest.mark.parametrize("empty", ["", "---"])
def test_parts_of_full_scale_with_a_cell_that_is_empty(tmp_path: Path, empty: str) -> None:
    path = tmp_path / "a.csv"
    rows = [f"{m},{300 + 50 * m}/4095" for m in (0, 0, 1, 1, 2, 2, 5)]
    path.write_text("\n".join(["load_kg,ADC", *rows[:3], *([",", ] if not empty else [empty]),
                               *rows[3:]]) + "\n")  # fmt: skip
    adc = guess_file(path).columns[1].values
    assert adc is not None
    assert np.nansum(adc) == pytest.approx(sum(300 + 50 * m for m in (0, 0, 1, 1, 2, 2, 5)))


def test_stamps_out_of_order_and_a_ramp_of_loads() -> None:
    stamps = np.arange(40.0)
    stamps[[5, 6]] = stamps[[6, 5]]
    assert nearly_increases(stamps)
    assert not nearly_increases(np.array([*range(30), 0.0]))
    assert not nearly_increases(np.arange(40.0))


@pytest.mark.parametrize(
    ("header", "first"),
    [("gain_dB", "{0}"), ("Humidity [%]", "{0}"), ("moisture_ppm", "{0}"), ("angle", "{0}°")],
)
def test_levels_shares_and_angles_are_no_load_no_time_and_no_reading(
    tmp_path: Path, header: str, first: str
) -> None:
    path = tmp_path / "a.csv"
    rows = [f"{first.format(10 * i)},{8200 + 37 * i * i}" for i in range(12)]
    path.write_text("\n".join([f"{header},counts", *rows]) + "\n")
    guess = guess_file(path)
    assert guess.columns[0].quantity in ("other", "angle")
    loads, cells = loads_and_cells(guess)
    assert not loads
    assert [c.column for c in cells] == ["counts"]
