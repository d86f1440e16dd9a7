"""Reports in headless Chromium: nothing overflows, is cut in print or is hard to read."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import Run, drawing
from tests.report.browser import A4_WIDTH_PX, CHROMIUM, look

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine"),
]
ROOT = Path(__file__).resolve().parents[2]
RUNS = {
    "check": ("check", "--recipe", ROOT / "recipes/nao_table2.toml"),
    "offline-fit": ("offline-fit", "--recipe", ROOT / "recipes/bench_foot.toml"),
    "hang-calib": ("hang-calib", "--recipe", ROOT / "recipes/hexapod.toml"),
    "simulate": ("simulate", "--recipe", ROOT / "recipes/nao_simulated.toml"),
    "diagnose": (
        "diagnose", ROOT / "sample_data/bench_foot/weights.csv",
        "--experiment", "weights", "--recipe", ROOT / "recipes/bench_foot.toml",
    ),
}  # fmt: skip


@pytest.fixture(scope="module", params=sorted(RUNS))
def page(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    from footcal_cli.app import main

    out = tmp_path_factory.mktemp("run") / "out"
    with drawing(), pytest.raises(SystemExit) as end:
        main([*map(str, RUNS[request.param]), "--out", str(out), "--quiet"])
    assert end.value.code in (0, None)
    return out / "report.html"


@pytest.mark.parametrize("width_px", [400, 800, 1280])
def test_no_page_is_wider_than_its_window(page: Path, width_px: int) -> None:
    found = look(page, width_px)
    assert found.cells > 0
    assert found.overflow == ()


@pytest.mark.parametrize("dark", [False, True])
def test_every_text_stands_out_from_its_ground(page: Path, dark: bool) -> None:
    assert look(page, 1280, dark=dark).contrast == ()


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
