"""Feet that stand still and that no column places: where the CoM lies above what they carry."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.sniff.several import parts_of
from tests.foreign.plates import PLACES_M, plate_stand


def planned(path: Path) -> LogPlan:
    plan = plan_of(guess_file(path))
    assert plan is not None
    return plan


def places_of(plan: LogPlan, feet: tuple[str, ...]) -> list[list[float]]:
    values = [[plan.entries[f"{foot}_foot_{axis}_m"].value for axis in "xy"] for foot in feet]
    return [[float(v) for v in row if v is not None] for row in values]


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_plates_stand_where_the_com_says(seed: int, tmp_path: Path) -> None:
    plan = planned(plate_stand(seed).written(tmp_path / "stand.csv"))
    assert (plan.command, plan.feet) == ("static-init", ("fp_1", "fp_2"))
    assert places_of(plan, plan.feet) == pytest.approx(PLACES_M, abs=0.006)


def test_a_cop_in_the_frame_of_the_com_needs_no_place(tmp_path: Path) -> None:
    plan = planned(plate_stand(3).written_as_cop(tmp_path / "stand.csv"))
    assert plan.command == "static-init"
    assert {"com_x_m", "com_z_m"} <= set(plan.entries)
    assert places_of(plan, ("left", "right")) == [[0.0, 0.0], [0.0, 0.0]]


def test_plates_that_always_share_alike_are_asked_for(tmp_path: Path) -> None:
    plan = planned(plate_stand(4, shifts=False).written(tmp_path / "stand.csv"))
    asked = [line for blank in plan.blanks if blank.needed for line in blank.lines]
    assert "# fp_2_foot_y_m = { value =  }" in asked


def test_the_motion_in_a_file_of_its_own(tmp_path: Path) -> None:
    stand = plate_stand(5)
    forces = stand.written(tmp_path / "forces.csv", body=False)
    every = slice(None, None, 2)
    np.savetxt(
        tmp_path / "mocap.csv", np.column_stack([stand.time_s, stand.com_m])[every], fmt="%.6g",
        delimiter=",", header="Time,COM_x,COM_y,COM_z", comments="",
    )  # fmt: skip
    guesses = [guess_file(forces), guess_file(tmp_path / "mocap.csv")]
    sensors, body = (part.plan for part in parts_of(guesses)[0])
    assert sensors.feet == ("fp_1", "fp_2")
    assert sensors.command == "static-init"
    assert places_of(body, sensors.feet) == pytest.approx(PLACES_M, abs=0.006)


def test_forces_that_press_the_plates_down(tmp_path: Path) -> None:
    stand = plate_stand(6)
    pressed = type(stand)(stand.time_s, stand.com_m, -stand.wrench, stand.cop_m)
    plan = planned(pressed.written(tmp_path / "stand.csv"))
    assert any("reversed sign" in warning for warning in plan.warnings)
    assert places_of(plan, plan.feet) == pytest.approx(PLACES_M, abs=0.006)


def test_two_plates_without_a_header_are_no_pose(tmp_path: Path) -> None:
    stand = plate_stand(8)
    for order in ([0, 1, 2, 3, 4, 5], [3, 4, 5, 0, 1, 2]):  # forces or moments first
        log = tmp_path / "netforce.txt"
        np.savetxt(log, stand.wrench[:, :, order].reshape(-1, 12), fmt="%.4f", delimiter=",")
        plan = planned(log)
        read = {n: e.column.column for n, e in plan.entries.items() if e.column is not None}
        assert plan.kind == "2 six-axis plates under one weight"
        assert [read[f"plate_{k}_plate_counts"] for k in (1, 2)] == [
            f"column_{order.index(2) + 1}", f"column_{order.index(2) + 7}"
        ]  # fmt: skip
