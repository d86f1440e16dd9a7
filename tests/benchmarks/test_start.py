"""How long the shell waits before footcal does anything, against starting Python itself."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

CHECKED = Path(__file__).resolve().parent.parent.parent / "sample_data/bench_foot/weights.csv"
FOOTCAL = ["-m", "footcal_cli"]


@pytest.mark.parametrize(
    ("arguments", "exit_code"),
    [
        pytest.param(["-c", "pass"], 0, id="python"),
        pytest.param(["-c", "import numpy"], 0, id="numpy"),
        pytest.param([*FOOTCAL, "--help"], 0, id="help"),
        pytest.param([*FOOTCAL, "offline-fit", "--recipe", "nope.toml"], 2, id="refusal"),
        pytest.param([*FOOTCAL, "check", str(CHECKED), "--overwrite"], 0, id="check"),
    ],
)
def test_start(
    benchmark: BenchmarkFixture, arguments: list[str], exit_code: int, tmp_path: Path
) -> None:
    done = benchmark(
        subprocess.run, [sys.executable, *arguments], capture_output=True, cwd=tmp_path, check=False
    )
    assert done.returncode == exit_code
