"""The distribution: what the wheel and the sdist hold, and that a fresh environment runs them."""

from __future__ import annotations

import subprocess
import sys
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

from tests.conftest import REPOSITORY

PROJECT = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_version_changelog_and_citation_agree() -> None:
    from footcal_cli import __version__

    assert f"## {__version__} – " in (REPOSITORY / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"version: {__version__}" in (REPOSITORY / "CITATION.cff").read_text(encoding="utf-8")
    assert "Typing :: Typed" in PROJECT["classifiers"]
    assert (REPOSITORY / "footcal_cli" / "py.typed").is_file()


def test_a_changelog_entry_is_one_short_line() -> None:
    lines = (REPOSITORY / "CHANGELOG.md").read_text(encoding="utf-8").splitlines()
    assert {line for line in lines if line.startswith("### ")} <= {
        "### Recalibrate", "### Added", "### Changed", "### Fixed",
    }  # fmt: skip
    assert not [line for line in lines if len(line) > 180]


@pytest.mark.slow
def test_the_wheel_runs_in_an_empty_environment(tmp_path: Path) -> None:
    """Build, install with what it asks for from the package index, calibrate a sample."""
    _run(sys.executable, "-m", "pip", "wheel", "--no-deps", "-w", str(tmp_path), str(REPOSITORY))
    (wheel,) = tmp_path.glob("footcal-*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert "footcal_cli/py.typed" in names
    assert "footcal_cli/report/templates/report.html.j2" in names
    assert not [name for name in names if name.startswith(("tests", "sample_data"))]
    venv.create(tmp_path / "empty", with_pip=True)
    bin_folder = tmp_path / "empty" / ("Scripts" if sys.platform == "win32" else "bin")
    _run(str(bin_folder / "python"), "-m", "pip", "install", "-q", str(wheel))
    recipe = str(REPOSITORY / "recipes/bench_foot.toml")
    _run(str(bin_folder / "footcal"), "offline-fit", "--recipe", recipe, "--out", "out",
         folder=tmp_path)  # fmt: skip
    assert "<figure" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def _run(*command: str, folder: Path | None = None) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
