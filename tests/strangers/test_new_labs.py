"""What `init` says of logs of new labs, and what it takes their columns for."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.conftest import Run
from tests.strangers.thirty_eighth import boards_and_tracker
from tests.strangers.thirty_seventh import daq_channels_of_feet, row_for_each_stance
from tests.strangers.thirty_sixth import kilograms_in_notes, long_poses_and_hanging


def test_forces_without_a_unit_are_asked_for(tmp_path: Path, run: Run) -> None:
    made = kilograms_in_notes(tmp_path, np.random.default_rng(0))
    log, notes = made.paths
    alone = run("init", log, "-o", tmp_path / "alone.toml")
    assert "check: no unit is stated: N and N cm are taken" in alone.out
    both = run("init", log, notes, "-o", tmp_path / "both.toml")
    assert "no unit" not in both.out
    assert "FX -> fx_n in kgf" in both.out
    assert "MX -> tx_nm in kgf*cm" in both.out


def test_poses_of_a_row_for_each_leg_are_no_hanging(tmp_path: Path, run: Run) -> None:
    made = long_poses_and_hanging(tmp_path, np.random.default_rng(0))
    done = run("init", *made.paths, "-o", tmp_path / "r.toml")
    assert "pozycja -> pose   likely" in done.out
    assert done.out.count("udo -> phase_rad in rad") == 2, "what moves in the hanging"
    assert "odw -> not used" in done.out
    assert "hang-calib" in done.out
    assert "after it pose-calib" in done.out


def test_channels_of_a_walk_under_the_names_of_its_bench(tmp_path: Path, run: Run) -> None:
    made = daq_channels_of_feet(tmp_path, np.random.default_rng(0))
    done = run("init", *made.paths, "-o", tmp_path / "r.toml")
    assert "X24 -> right_4_counts" in done.out
    assert "acom_x (ft/s^2) -> com_acc_x_mps2 in ft/s^2" in done.out
    assert "next: footcal offline-fit" in done.out
    assert "online-replay" in done.out
    recipe = (tmp_path / "r.toml").read_text(encoding="utf-8")
    assert "mass_kg = 5.2    # likely: 'Biped, 5.2 kg with battery.'" in recipe
    assert "4 = { x_m = -0.06, y_m = -0.035 }    # likely: notes.md" in recipe
    assert "TO FILL IN" not in recipe


def test_rows_of_stances_stand_for_seconds(tmp_path: Path, run: Run) -> None:
    made = row_for_each_stance(tmp_path, np.random.default_rng(0))
    done = run("init", *made.paths, "-o", tmp_path / "r.toml")
    assert "Lfootx_mm -> left_foot_x_m in mm" in done.out
    recipe = (tmp_path / "r.toml").read_text(encoding="utf-8")
    assert "row_lasts = 300    # likely: each row is a stance" in recipe
    assert 'zeros_where = { remark = "robot lifted" }' in recipe
    assert 'zeros = ["stances.csv"]' in recipe


def test_a_column_called_after_a_bridge_is_no_voltage(tmp_path: Path, run: Run) -> None:
    made = boards_and_tracker(tmp_path, np.random.default_rng(0))
    done = run("init", *made.paths, "-o", tmp_path / "r.toml")
    assert "mV/V -> counts in mV/V" in done.out
    assert "ch3 -> left_ch3_counts in mV/V" in done.out


def test_a_bench_that_no_name_ties_is_said(tmp_path: Path, run: Run) -> None:
    made = daq_channels_of_feet(tmp_path, np.random.default_rng(0))
    bench = next(path for path in made.paths if path.name == "bench.csv")
    for side, word in (("left", "anna"), ("right", "bertha")):
        bench.write_text(bench.read_text().replace(f"{side}_", f"{word} "))
    done = run("init", *made.paths, "-o", tmp_path / "r.toml")
    assert "no name says which of the cells left_" in done.out
