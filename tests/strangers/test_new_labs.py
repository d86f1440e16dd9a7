"""What `init` says of logs of new labs, and what it takes their columns for."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.conftest import Run
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
