"""Pictures of every report at three widths, dark and on paper; of an older checkout, too.

``python -m tests.report.gallery --out DIR [--before CHECKOUT]`` writes
``DIR/<now|before>/<kind>_<400|800|1280|dark>.png``, ``<kind>_print.pdf`` and its pages. Imported by
nobody: ``make gallery`` runs it. It needs Chromium.
"""

from __future__ import annotations

import argparse
import html
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pypdfium2
from matplotlib.image import imread, imsave

from tests.report.browser import CHROMIUM, chromium, resolved
from tests.report.kinds import ROOT, RUNS, words_of

WIDTHS_PX = (400, 800, 1280)
_PAPER_DPI = 80
HEIGHT_PX = 6000
"""How much of a page is drawn; what lies below is on paper."""
OLDER_NAMES = {"nao_table2.toml": "seed1_table2.toml"}
"""Recipes under the names that they had before."""
NEWER_WORDS = ("--compare",)
"""Options that an older checkout need not know."""


def run(name: str, checkout: Path, folder: Path) -> Path | None:
    """The report of a kind, made by the source of a checkout; None where it has no such report."""
    out = folder / name.replace(" ", "_")

    def earlier(start: str) -> Path:
        made = run(start, checkout, folder)
        assert made is not None, f"{name} starts from {start}, which failed"
        return made.parent

    if not out.exists():
        words = words_of(name, earlier)
        if checkout != ROOT:
            words = [_older(word, checkout) for word in words if word not in NEWER_WORDS]
        subprocess.run(
            [sys.executable, "-m", "footcal_cli", *words, "--out", str(out), "--quiet"],
            cwd=checkout, env=os.environ | {"PYTHONPATH": str(checkout)}, check=False,
        )  # fmt: skip
    report = out / "report.html"
    return report if report.is_file() else None


def _older(word: str, checkout: Path) -> str:
    """A path of this checkout in the older one."""
    for new, old in OLDER_NAMES.items():
        word = word.replace(new, old)
    return word.replace(f"{ROOT}/", f"{checkout}/")


def shoot(page: Path, to: Path, width_px: int, *, dark: bool = False) -> None:
    """Draw a page at a width, cut where it ends."""
    source = resolved(page, dark=dark, printed=False)
    with tempfile.TemporaryDirectory() as scratch:
        inner, outer = Path(scratch) / "page.html", Path(scratch) / "outer.html"
        inner.write_text(source, encoding="utf-8")
        outer.write_text(
            "<!DOCTYPE html><meta charset='utf-8'><body style='margin:0;background:#fff'>"
            f"<iframe style='border:0;width:{width_px}px;height:{HEIGHT_PX}px' "
            f'srcdoc="{html.escape(source)}"></iframe>', encoding="utf-8",
        )  # fmt: skip
        shot = Path(scratch) / "shot.png"
        chromium(
            scratch, f"--window-size={max(width_px, 600)},{HEIGHT_PX}", "--hide-scrollbars",
            f"--screenshot={shot}", "--virtual-time-budget=4000", outer.as_uri(),
        )  # fmt: skip
        pixels = imread(shot)[:, :width_px, :3]
    ground = pixels[-1, 0]
    used = np.flatnonzero(np.any(np.abs(pixels - ground) > 0.02, axis=(1, 2)))
    imsave(to, pixels[: int(used[-1]) + 24 if used.size else 1])


def paper(page: Path, to: Path) -> None:
    """Print a page, and draw the sheets of paper next to it."""
    with tempfile.TemporaryDirectory() as scratch:
        chromium(
            scratch, f"--print-to-pdf={to}", "--no-pdf-header-footer",
            "--virtual-time-budget=4000", page.resolve().as_uri(),
        )  # fmt: skip
    for number, sheet in enumerate(pypdfium2.PdfDocument(to), start=1):
        picture = to.with_name(f"{to.stem}-{number}.png")
        sheet.render(scale=_PAPER_DPI / 72.0).to_pil().save(picture)


def draw(name: str, checkout: Path, folder: Path) -> None:
    """All pictures of one kind, in a folder beside the run."""
    page = run(name, checkout, folder / "runs")
    if page is None:
        sys.stdout.write(f"{name}: no such report in {checkout}\n")
        return
    stem = name.replace(" ", "_")
    jobs: dict[Path, Callable[[Path], None]] = {
        folder / f"{stem}_{width}.png": partial(shoot, page, width_px=width) for width in WIDTHS_PX
    }
    jobs[folder / f"{stem}_dark.png"] = partial(shoot, page, width_px=1280, dark=True)
    jobs[folder / f"{stem}_print.pdf"] = partial(paper, page)
    for to, job in jobs.items():
        if not to.exists():
            job(to)
    sys.stdout.write(f"{name}: {folder}/{stem}_*\n")


def small(folder: Path, to: Path) -> None:
    """The few pictures of `docs/reports.md`: older and newer pages side by side, 64 colours."""
    from PIL import Image

    def save(name: str, *cuts: tuple[str, int, int]) -> None:
        """Pictures beside each other, each scaled to a width and cut at a height."""
        tiles = []
        for file, width, height in cuts:
            tile = Image.open(folder / file).convert("RGB")
            scaled = tile.resize((width, round(tile.height * width / tile.width)))
            tiles.append(scaled.crop((0, 0, width, min(height, scaled.height))))
        size = (sum(t.width + 8 for t in tiles) - 8, max(t.height for t in tiles))
        joined = Image.new("RGB", size, (128, 128, 128))
        left = 0
        for tile in tiles:
            joined.paste(tile, (left, 0))
            left += tile.width + 8
        joined.quantize(64).save(to / f"{name}.png", optimize=True)

    to.mkdir(parents=True, exist_ok=True)
    for kind in ("cells", "stand", "diagnose_a_walk", "diagnose_none"):
        both = (f"before/{kind}_1280.png", f"now/{kind}_1280.png")
        save(kind, *((file, 620, 760) for file in both))
    save(
        "hang", ("now/hang_400.png", 290, 560), ("now/hang_dark.png", 520, 560),
        ("now/hang_print-1.png", 400, 560),
    )  # fmt: skip


def main() -> None:
    """Draw the reports of this checkout, and those of an older one where it is named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--before", type=Path)
    parser.add_argument("--small", type=Path, help="write the pictures of docs/reports.md here")
    parser.add_argument("--kind", action="append", choices=sorted(RUNS))
    given = parser.parse_args()
    assert CHROMIUM is not None, "no Chromium on this machine"
    for word, checkout in (("now", ROOT), ("before", given.before)):
        if checkout is not None:
            folder = given.out.resolve() / word
            (folder / "runs").mkdir(parents=True, exist_ok=True)
            for name in given.kind or RUNS:
                draw(name, Path(checkout).resolve(), folder)

    if given.small is not None:
        small(given.out, given.small)


if __name__ == "__main__":
    main()
