"""What all tests share: where the repository, the recipes and the real data lie."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from footcal_cli.app import main

REPOSITORY = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def repository() -> Path:
    return REPOSITORY


@pytest.fixture(scope="session")
def real_data() -> Path:
    """The folder of measurements by others; tests that need it skip without it."""
    folder = os.environ.get("FOOTCAL_DATA")
    if not folder:
        pytest.skip("FOOTCAL_DATA is not set: no measured data at hand")
    return Path(folder)


@dataclass(frozen=True)
class Answer:
    """What a command printed and how it ended."""

    exit_code: int
    out: str
    err: str


Run = Callable[..., Answer]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run footcal as the shell does, errors and exit codes included."""

    def call(*arguments: str | Path) -> Answer:
        try:
            main([str(argument) for argument in arguments])
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 1
        else:
            code = 0
        captured = capsys.readouterr()
        return Answer(code, captured.out, captured.err)

    return call


__all__ = ["REPOSITORY", "Answer", "Run"]
