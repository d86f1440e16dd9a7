"""A gate that failed stays failed: for make, for scripts, and for the next command."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.test_run_folder import LOG
from tests.conftest import REPOSITORY, Run


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "weights.csv"
    path.write_text(LOG)
    return path


GATE = ("--max-rmse-n", "1e-9")


def test_a_rejected_calibration_has_another_name_and_says_why(
    run: Run, log: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert run("offline-fit", log, "--out", out).exit_code == 0
    assert run("offline-fit", log, "--out", out, "--overwrite", *GATE).exit_code == 1
    assert not (out / "parameters.json").exists()
    rejected = json.loads((out / "parameters_rejected.json").read_text())
    assert "RMSE" in rejected["rejected_because"][0]


def test_no_command_starts_from_a_rejected_calibration(run: Run, log: Path, tmp_path: Path) -> None:
    assert run("offline-fit", log, "--out", tmp_path / "out", *GATE).exit_code == 1
    renamed = (tmp_path / "out/parameters_rejected.json").rename(tmp_path / "parameters.json")
    answer = run("offline-fit", log, "--parameters", renamed, "--out", tmp_path / "next")
    assert answer.exit_code == 2
    assert "rejected" in answer.err
    assert "RMSE" in answer.err


def test_make_fails_again_until_the_gate_is_met(log: Path, tmp_path: Path) -> None:
    (tmp_path / "Makefile").write_text(
        "out/parameters.json: weights.csv\n"
        f"\t{sys.executable} -m footcal_cli offline-fit $< --out out --overwrite $(GATE) --quiet\n"
    )

    def make(*words: str) -> int:
        return subprocess.run(
            ["make", "-s", *words], cwd=tmp_path, capture_output=True, check=False,
            env={"PYTHONPATH": str(REPOSITORY), "PATH": "/usr/bin:/bin"},
        ).returncode  # fmt: skip

    tight = f"GATE={' '.join(GATE)}"
    assert [make(tight), make(tight)] == [2, 2]
    assert make() == 0
    assert make("-q") == 0


def test_strict_findings_on_a_command_that_never_had_it(
    run: Run, repository: Path, tmp_path: Path
) -> None:
    answer = run(
        "diagnose", repository / "sample_data/seed1_table2/weights.csv", "--experiment", "weights",
        "--no-pictures", "--strict-findings", "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code in {1, 3}
    assert not (tmp_path / "out/parameters.json").exists()
