"""How long the shell waits before footcal does anything, against starting Python itself."""

from __future__ import annotations

import subprocess
import sys

import pytest
from pytest_benchmark.fixture import BenchmarkFixture


@pytest.mark.parametrize(
    "arguments", [["-c", "pass"], ["-m", "footcal_cli", "--help"]], ids=["python", "footcal-help"]
)
def test_start(benchmark: BenchmarkFixture, arguments: list[str]) -> None:
    benchmark(subprocess.run, [sys.executable, *arguments], check=True, capture_output=True)
