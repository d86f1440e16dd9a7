"""A report in headless Chromium: what of a page overflows, is cut or is hard to read."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

_NAMES = ("chromium", "chromium-browser", "google-chrome")
CHROMIUM = next((path for name in _NAMES if (path := shutil.which(name))), None)
A4_WIDTH_PX = 703
"""Width of a page of 210 mm less margins of 12 mm each, at 96 pixels per inch."""

_PROBE = Path(__file__).with_name("probe.js").read_text(encoding="utf-8")


@dataclass(frozen=True)
class Look:
    """What a page looks like: offending elements of each kind, and how many cells were seen."""

    overflow: tuple[str, ...]
    cut: tuple[str, ...]
    contrast: tuple[str, ...]
    cells: int


def look(page: Path, width_px: int, *, dark: bool = False, printed: bool = False) -> Look:
    """Draw a page at a width and return what is wrong with it.

    The page's media queries are resolved in a copy, since a command line cannot set them, and its
    Content-Security-Policy is taken out for the probe.
    """
    source = resolved(page, dark=dark, printed=printed).replace(
        "</body>", f"<script>{_PROBE}</script></body>"
    )
    frame = (
        f'<iframe id="f" style="border:0;width:{width_px}px;height:4000px" '
        f'srcdoc="{html.escape(source)}"></iframe><pre id="answer"></pre>'
        "<script>addEventListener('message', (e) => "
        "{ document.getElementById('answer').textContent = 'FOUND' + e.data + 'END'; });</script>"
    )
    with tempfile.TemporaryDirectory() as folder:
        outer = Path(folder) / "outer.html"
        outer.write_text(f"<!DOCTYPE html><meta charset='utf-8'><body>{frame}", encoding="utf-8")
        dom = chromium(folder, "--dump-dom", "--virtual-time-budget=4000", outer.as_uri())
    answer = re.search(r"FOUND(\{.*?\})END</pre>", dom, re.DOTALL)
    assert answer is not None, "the probe gave no answer"
    found = json.loads(html.unescape(answer.group(1)))
    return Look(
        tuple(found["overflow"]), tuple(found["cut"]), tuple(found["contrast"]), found["text"]
    )


def light_share(page: Path, width_px: int, *, dark: bool) -> float:
    """Share of pixels lighter than mid-grey in the first 4000 pixels of a page."""
    import numpy as np
    from matplotlib.image import imread

    with tempfile.TemporaryDirectory() as folder:
        copy, shot = Path(folder) / "page.html", Path(folder) / "page.png"
        copy.write_text(resolved(page, dark=dark, printed=False), encoding="utf-8")
        chromium(
            folder, f"--window-size={width_px},4000", f"--screenshot={shot}",
            "--virtual-time-budget=4000", copy.as_uri(),
        )  # fmt: skip
        return float(np.mean(imread(shot)[..., :3].mean(axis=-1) > 0.5))


def resolved(page: Path, *, dark: bool, printed: bool) -> str:
    """The page with its media queries resolved and without its Content-Security-Policy."""
    source = page.read_text(encoding="utf-8")
    source = re.sub(r"<meta http-equiv=\"Content-Security-Policy\"[^>]*>", "", source)
    source = source.replace("(prefers-color-scheme: dark)", "all" if dark else "not all")
    source = source.replace("@media print", "@media all" if printed else "@media not all")
    return source.replace("@page", "@media not all")


def chromium(folder: str, *arguments: str) -> str:
    assert CHROMIUM is not None
    done = subprocess.run(
        [
            CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic",
            "--no-first-run", "--disable-background-networking", "--disable-component-update",
            "--disable-sync", "--window-size=1400,1000", f"--user-data-dir={folder}/profile",
            *arguments,
        ],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    return done.stdout
