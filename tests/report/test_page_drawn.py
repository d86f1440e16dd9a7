"""Reports in headless Chromium: nothing overflows, is cut in print or is hard to read."""

from __future__ import annotations

from pathlib import Path

import pytest

from footcal_cli.report import FIGURE_DPI, Sheet
from tests.conftest import Run, drawing
from tests.report.browser import A4_WIDTH_PX, CHROMIUM, chromium, light_share, look
from tests.report.kinds import RUNS, words_of
from tests.report.test_page import page as page_of

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine"),
]
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
            self._run(out, words_of(name, lambda start: self.report(start).parent))
        return out / "report.html"

    @staticmethod
    def _run(out: Path, words: list[str]) -> None:
        from footcal_cli.app import main

        with drawing(FIGURE_DPI), pytest.raises(SystemExit) as end:
            main([*words, "--out", str(out), "--quiet"])
        assert end.value.code in (0, 1, 3, None), words


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


def test_the_next_sheet_of_paper_begins_with_the_head_of_the_table(tmp_path: Path) -> None:
    rows = [(f"left_{i}", f"{i}.5", "fitted") for i in range(150)]
    sheet = Sheet("Long", ("channel", "residual of the force", "how"), rows)
    pdf = pytest.importorskip("pypdfium2", reason="extra dev")
    page, paper = tmp_path / "page.html", tmp_path / "page.pdf"
    page.write_text(page_of(sheets=(sheet,)), encoding="utf-8")
    chromium(str(tmp_path), f"--print-to-pdf={paper}", page.as_uri())
    sheets = [one.get_textpage().get_text_bounded() for one in pdf.PdfDocument(paper)]
    with_rows = [one for one in sheets if "fitted" in one]
    assert len(with_rows) > 1
    assert all("residual of the force" in one for one in with_rows)
