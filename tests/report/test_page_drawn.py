"""Reports in headless Chromium: nothing overflows, is cut in print or is hard to read."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import Run, drawing
from tests.report.browser import A4_WIDTH_PX, CHROMIUM, light_share, look

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine"),
]
ROOT = Path(__file__).resolve().parents[2]
BIPED, HEXAPOD = ROOT / "sample_data/biped", ROOT / "sample_data/hexapod"
NAO = ("--recipe", ROOT / "recipes/nao_walk.toml", "--parameters", "@cells")
SIX = ("--recipe", ROOT / "recipes/hexapod.toml", "--parameters", "@hang")
RUNS: dict[str, tuple[str | Path, ...]] = {
    "check": ("check", "--recipe", ROOT / "recipes/nao_table2.toml"),
    "cells": ("offline-fit", "--recipe", ROOT / "recipes/nao_walk.toml"),
    "foot": ("offline-fit", "--recipe", ROOT / "recipes/bench_foot.toml"),
    "stand": ("static-init", BIPED / "stand_cells.parquet", BIPED / "stand_body.parquet", *NAO),
    "walk": ("online-replay", "--compare", *NAO),
    "hang": ("hang-calib", "--recipe", ROOT / "recipes/hexapod.toml"),
    "pose": ("pose-calib", *SIX),
    "apply": ("apply", BIPED / "walk_002_cells.parquet", *NAO),
    "apply to legs": ("apply", HEXAPOD / "walk.parquet", *SIX[:2], "--parameters", "@pose"),
    "batch": (
        "batch", BIPED / "walk_002_cells.parquet", BIPED / "walk_010_cells.parquet",
        "--command", "apply", *NAO,
    ),
    "simulate": ("simulate", "--recipe", ROOT / "recipes/nao_simulated.toml"),
    "diagnose weights": (
        "diagnose", ROOT / "sample_data/bench_foot/weights.csv",
        "--experiment", "weights", "--recipe", ROOT / "recipes/bench_foot.toml",
    ),
    "diagnose a walk": (
        "diagnose", BIPED / "walk_004_faulty_cells.parquet", BIPED / "walk_004_faulty_body.parquet",
        "--experiment", "walk", *NAO,
    ),
}  # fmt: skip
"""A report of every kind; ``@name`` is the calibration of the run of that name."""
LIGHT = 0.25
"""Share of light pixels that a dark page may have: letters and curves."""


class Runs:
    """Run folders made on demand, each once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def report(self, name: str) -> Path:
        """The report of a run, with its figures."""
        out = self.folder / name.replace(" ", "_")
        if not out.exists():
            self._run(out, [self._word(word) for word in RUNS[name]])
        return out / "report.html"

    def _word(self, word: str | Path) -> str:
        text = str(word)
        if not text.startswith("@"):
            return text
        return str(self.report(text[1:]).with_name("parameters.json"))

    @staticmethod
    def _run(out: Path, words: list[str]) -> None:
        from footcal_cli.app import main

        with drawing(), pytest.raises(SystemExit) as end:
            main([*words, "--out", str(out), "--quiet"])
        assert end.value.code in (0, 1, None), words


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    return Runs(tmp_path_factory.mktemp("runs"))


@pytest.fixture(scope="module", params=sorted(RUNS))
def page(request: pytest.FixtureRequest, runs: Runs) -> Path:
    return runs.report(request.param)


@pytest.mark.parametrize("width_px", [400, 800, 1280])
def test_no_page_is_wider_than_its_window(page: Path, width_px: int) -> None:
    found = look(page, width_px)
    assert found.cells > 0
    assert found.overflow == ()


@pytest.mark.parametrize("dark", [False, True])
def test_every_text_stands_out_from_its_ground(page: Path, dark: bool) -> None:
    assert look(page, 1280, dark=dark).contrast == ()


def test_a_dark_page_is_dark_with_its_figures(page: Path) -> None:
    assert light_share(page, 1280, dark=True) < LIGHT < light_share(page, 1280, dark=False)


def test_paper_loses_no_column(page: Path) -> None:
    found = look(page, A4_WIDTH_PX, printed=True)
    assert found.cut == ()
    assert found.overflow == ()
    assert found.contrast == ()


def test_the_probe_sees_planted_faults(tmp_path: Path, run: Run) -> None:
    page = tmp_path / "bad.html"
    page.write_text(
        "<!DOCTYPE html><html><body><p style='width:2000px;color:#aaa'>pale and wide</p>"
        "<div class='scroll' style='overflow:auto;width:100px'><table><tr>"
        "<td style='min-width:300px'>cut</td></tr></table></div></body></html>"
    )
    found = look(page, 800)
    assert len(found.overflow) == len(found.contrast) == len(found.cut) == 1
