"""Measured six-axis data of others: iCub, four transducers, one structure, no orientation."""

from __future__ import annotations

from pathlib import Path

import pytest

from footcal_cli.records.files import read_record
from footcal_cli.records.results import RmseRecord, RunRecord
from tests.conftest import REPOSITORY, Run

RECIPE = REPOSITORY / "recipes/icub_four_ft.toml"


@pytest.fixture
def log(real_data: Path) -> Path:
    return real_data / "icub-four-ft/trial3_four_ft.csv"


@pytest.mark.usefixtures("drawn")
def test_icub_says_what_can_be_known_of_its_offsets_and_what_cannot(
    run: Run, log: Path, tmp_path: Path
) -> None:
    answer = run("pose-calib", log, "--recipe", RECIPE, "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    assert "12 of 24 offsets' directions are seen" in answer.out
    assert "no offset and no weight can be calibrated" in answer.out
    assert "without the body's orientation" in answer.out
    assert not (tmp_path / "out/parameters.json").exists()
    rows = read_record(RmseRecord, tmp_path / "out/rmse.json").rows
    left = {row.quantity: row.rmse for row in rows if row.stage == "after"}
    noise_n = 0.16
    assert all(rmse > 5 * noise_n for rmse in left.values()), "far from explained: say so"
    assert read_record(RunRecord, tmp_path / "out/run.json").verdict.level == "warning"


def test_icub_cannot_be_given_a_mounting(run: Run, log: Path, tmp_path: Path) -> None:
    answer = run(
        "pose-calib", log, "--recipe", RECIPE, "--fit", "mounting", "--out", tmp_path / "out"
    )
    assert answer.exit_code == 2
    assert "hang-calib" in answer.err
