"""What all tests share: where the repository, the recipes and the real data lie."""

from __future__ import annotations

import os
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from footcal_cli.app import main
from footcal_cli.report import Drawn, Picture
from footcal_cli.report.text import WIDTH
from tests import thorough

REPOSITORY = Path(__file__).resolve().parent.parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that `make test` leaves to `make test-thorough`."""
    listed = thorough.listed()
    for item in items:
        if item.nodeid.partition("[")[0] in listed:
            item.add_marker("thorough")


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


@pytest.fixture(scope="session", autouse=True)
def _no_terminal() -> Iterator[None]:
    """The tests read a pipe: one line per sentence, however wide the terminal they started from."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv(WIDTH, raising=False)
        yield


def _one_pixel() -> bytes:
    """The smallest PNG: a grey pixel."""
    chunks = (
        (b"IHDR", b"\0\0\0\1\0\0\0\1\x08\0\0\0\0"),
        (b"IDAT", zlib.compress(b"\0\x7f")),
        (b"IEND", b""),
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        len(data).to_bytes(4, "big") + kind + data + zlib.crc32(kind + data).to_bytes(4, "big")
        for kind, data in chunks
    )


@pytest.fixture(scope="session", autouse=True)
def _pictures_of_one_pixel() -> Iterator[None]:
    """Figures take longer than most of what they show: they are drawn where they are asked for."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Picture, "drawn", lambda picture: Drawn(_one_pixel()))
        yield


_DRAWN = Picture.drawn
_COARSE_DPI = 40
"""Every artist of a figure is drawn, on a tenth of the pixels."""


@contextmanager
def drawing(dpi: int = _COARSE_DPI) -> Iterator[None]:
    """Figures are really drawn, coarsely unless asked: for the runs whose figures are looked at."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Picture, "drawn", _DRAWN)
        patch.setattr("footcal_cli.report.FIGURE_DPI", dpi)
        yield


@pytest.fixture
def drawn() -> Iterator[None]:
    """Figures are really drawn in the test that uses this."""
    with drawing():
        yield


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


__all__ = ["REPOSITORY", "Answer", "Run", "drawing"]
