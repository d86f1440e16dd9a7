"""Run both papers: ``python -m tests.papers``; what is in ``--out`` is not run again."""

from __future__ import annotations

import argparse
from pathlib import Path

from tests.papers import bench, hips, modes, walks
from tests.papers.page import copy_pictures, page
from tests.papers.systems import Found

ROOT = Path(__file__).resolve().parents[2]


def run(arguments: list[str] | None = None) -> None:
    """Calibrate, walk, compare, write the page."""
    parser = argparse.ArgumentParser(prog="python -m tests.papers", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/papers"), help="kept between runs")
    parser.add_argument("--page", type=Path, default=ROOT / "docs" / "papers.md")
    given = parser.parse_args(arguments)
    out: Path = given.out
    table_3, bench_folder = bench.table_3(out)
    hung, folders = {}, {"bench": bench_folder}
    for method in hips.HANGING:
        hung[method], folders[method] = hips.hung(out, method)
    stood, more = hips.stood(out, folders["joint"])
    folders |= more
    walked = walks.run_walks(out)
    found = Found(
        bench.table_2(), table_3, walked, hung, stood, hips.walking_error(folders["walk"]),
        modes.run_modes(out),
    )  # fmt: skip
    copy_pictures(folders, out / "pictures", given.page.parent / "pictures" / "papers")
    given.page.write_text(page(found), encoding="utf-8")


if __name__ == "__main__":
    run()
