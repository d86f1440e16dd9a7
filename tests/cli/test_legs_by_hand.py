"""``footcal pose-calib`` on robots that were simulated independently of footcal."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.app import main
from footcal_cli.core.parameters import Status
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord, RunRecord
from tests.cli.legs_by_hand import LEGS, Robot
from tests.conftest import Run

ASKEW_RAD = np.array([[0.0, 0.3, 0.1], [3.1416, -0.25, 1.4], [1.5708, 0.2, 0.15], [0.0, 0.1, 3.0]])
"""Transducers whose axes lie up to 18° beside the nearest of the body."""


@pytest.fixture(scope="module")
def hung(tmp_path_factory: pytest.TempPathFactory) -> tuple[Robot, list[str | Path]]:
    """A robot, and the arguments that say what hanging found of it."""
    robot, folder = Robot.drawn(3, ASKEW_RAD), tmp_path_factory.mktemp("hung")
    recipe, out = robot.recipe(folder / "robot.toml"), folder / "hang"
    words = ("hang-calib", robot.hanging(folder / "hang.csv"), "--recipe", recipe, "--out", out)
    with pytest.raises(SystemExit) as ended:
        main([*(str(word) for word in words), "--no-pictures", "--quiet"])
    assert ended.value.code == 0
    return robot, ["--recipe", recipe, "--parameters", out / "parameters.json", "--no-pictures"]


def off_by_sd(record: ParametersRecord, truth: dict[str, float]) -> np.ndarray:
    """Errors of what was estimated, in sd."""
    found = {n: record.parameters[n] for n in truth}
    known = {n: p for n, p in found.items() if p.status is Status.ESTIMATED and p.sd}
    return np.array([(p.value - truth[n]) / (p.sd or np.nan) for n, p in known.items()])


def test_hangings_named_after_the_body_serve_transducers_mounted_askew(
    run: Run, tmp_path: Path, hung: tuple[Robot, list[str | Path]]
) -> None:
    robot, known = hung
    answer = run("pose-calib", robot.standing(tmp_path / "poses.csv", 24), *known,
                 "--out", tmp_path / "pose")  # fmt: skip
    assert answer.exit_code == 0, answer.err
    off = off_by_sd(
        read_record(ParametersRecord, tmp_path / "pose" / "parameters.json"), robot.truth
    )
    assert off.size > 30
    assert np.abs(off).max() < 4.0
    assert np.sqrt(np.mean(off**2)) < 1.4
    assert read_record(RunRecord, tmp_path / "pose" / "run.json").verdict.level == "good"


def test_poses_too_few_to_check_a_fit_are_said_to_be_and_blame_no_leg(
    run: Run, tmp_path: Path, hung: tuple[Robot, list[str | Path]]
) -> None:
    """Four poses of four legs leave no equation beside the 24 errors of the mounting."""
    robot, known = hung
    answer = run("pose-calib", robot.standing(tmp_path / "poses.csv", 4), *known,
                 "--out", tmp_path / "pose")  # fmt: skip
    assert answer.exit_code == 0, answer.err
    done = read_record(RunRecord, tmp_path / "pose" / "run.json")
    assert done.verdict.level == "warning"
    assert done.verdict.actions[0].startswith("Record at least 5 poses")
    assert "leg_predicts_residual" not in {f.code for f in done.findings}
    assert not any(f"Leg {leg} does not fit" in done.verdict.sentence for leg in LEGS)
    off = off_by_sd(
        read_record(ParametersRecord, tmp_path / "pose" / "parameters.json"), robot.truth
    )
    assert np.abs(off).max() < 4.0
