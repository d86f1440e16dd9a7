"""What lines above a table say, and scales that no reading determines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.core.plausibility import check_determined
from footcal_cli.formats.messages import flat
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.several import parts_of
from footcal_cli.sniff.silent import no_reading

_FEET = "t,left_fz_N,left_cop_x_m,left_cop_y_m,right_fz_N,right_cop_x_m,right_cop_y_m"


def _standing(to: Path, line: str) -> tuple[str, ...]:
    """Robot lines of the plan for 50 kg on two feet under a line."""
    force = 50 * 9.80665 / 2
    rows = [f"{i / 50},{force},0,{0.001 * (i % 7)},{force},0,{0.001 * (i % 5)}" for i in range(200)]
    path = to / "feet.csv"
    path.write_text("\n".join([line, _FEET, *rows]) + "\n", encoding="utf-8")
    [part] = parts_of([guess_file(path)])[0]
    return tuple(x for x in part.plan.robot if x.startswith("mass_kg"))


@pytest.mark.parametrize(
    ("line", "mass"),
    [
        ("# mass: 50 kg", "50"),
        ("# Körpergewicht: 50,2 kg", "50.2"),
        ("# Weight [lb]: 110", "49.8952"),
        ("# tool mass: 50 kg", ""),
        ("# mass: 50", ""),
        ("# mass: 500 kg", ""),
    ],
)
def test_a_mass_above_the_table(line: str, mass: str, tmp_path: Path) -> None:
    found = _standing(tmp_path, line)
    assert [x.split()[2] for x in found] == ([mass] if mass else [])


@pytest.mark.parametrize(
    ("line", "asked"),
    [
        ("# weights: 0, 500 g, 1 kg, 5 kg", True),
        ("# cell capacity 10 kg", True),
        ("# resolution of the loads 1 g", False),
        ("# loads up to 5000 kg", False),
    ],
)
def test_loads_that_a_line_contradicts(line: str, asked: bool, tmp_path: Path) -> None:
    path = tmp_path / "bench.csv"
    rows = [f"{kg},{8_000_000 - 290 * kg}" for kg in (0, 500, 1000, 5000) for _ in range(3)]
    path.write_text("\n".join([line, "load_kg,counts", *rows]) + "\n", encoding="utf-8")
    [part] = parts_of([guess_file(path)])[0]
    assert (not part.plan.ready) is asked


def test_a_scale_without_a_sign() -> None:
    assert [f.code for f in check_determined("a", 0.01, 0.008)] == ["scale_undetermined"]
    assert check_determined("a", -0.01, 0.004) == []
    assert check_determined("a", 0.01, float("nan")) == []


def test_nines_with_decimals_are_no_readings() -> None:
    assert no_reading(np.array([0.1, 0.2, 0.3, 0.4, 9999.99])) == ("9999.99",)
    assert no_reading(np.array([0.1, 0.2, 0.3, 0.4, 0.99])) == ()


def test_objects_in_a_list_are_columns_by_what_they_are_called() -> None:
    values, _ = flat({"legs": [{"name": "LF", "f": 1.0}, {"name": "RF", "f": 2.0}]})
    assert values == {"legs.LF.f": 1.0, "legs.RF.f": 2.0}
    assert flat({"legs": [{"f": 1.0}, {"f": 2.0}]})[0] == {"legs.0.f": 1.0, "legs.1.f": 2.0}
