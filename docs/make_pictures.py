"""Take the pictures that README and documents show from ``make demo`` and a few runs more.

``make pictures`` makes the runs: a walk with a tilted IMU, which five causes explain alike, a walk
with a stuck cell, and ten months of weights on one cell (``--sessions FOLDER`` writes those).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

PICTURES = {
    "check": "stuck_check/figures/log_1_cells.png",
    "offline_fit": "bench_foot/figures/cop_errors_left.png",
    "static_init": "stand/figures/curve.png",
    "online_replay": "walk/figures/cop.png",
    "online_cycles": "walk/figures/cycles.png",
    "hang_calib": "hang/figures/residuals.png",
    "pose_calib": "pose/figures/mounting.png",
    "apply": "applied/figures/forces.png",
    "batch": "fleet/figures/over_time_bias.png",
    "simulate": "simulated/figures/shown_and_true.png",
    "diagnose": "diagnosis/figures/residual_against_driver.png",
    "likeness": "rivals/figures/isolability.png",
}
"""Picture -> figure of the demo's run folders."""
TERMINALS = {
    "init": {
        "footcal init scale.csv --output scale.toml": "init.txt",
        "cat scale.toml": "scale.toml",
    }
}
"""Picture -> command lines of a terminal, each with the file that holds what it printed."""
MOST_BYTES = 150_000
_COLOURS = 128
_LOADS_N = np.array([0, 2, 5, 10, 20, 30, 20, 10, 5, 2, 0.0])


def monthly_sessions(folder: Path) -> None:
    """Weights on one cell in ten months; in June its zero moves by 0.6 N."""
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(3)
    table = ["session,robot,date,logs"]
    for month in range(1, 11):
        zero = 8_312_000 + (17_600 if month >= 6 else 0) + 1_500 * random.standard_normal()
        scale = -33.4e-6 * (1 + 1e-4 * random.standard_normal())
        rows = ["channel,load_n,counts,repeat"]
        for repeat in range(1, 4):
            counts = zero + _LOADS_N / scale + 400 * random.standard_normal(_LOADS_N.size)
            rows += [
                f"left_fl,{load:g},{count:.0f},{repeat}"
                for load, count in zip(_LOADS_N, counts, strict=True)
            ]
        log = folder / f"2026-{month:02d}.csv"
        log.write_text("\n".join(rows) + "\n", encoding="utf-8")
        table.append(f"{log.stem},robot 1,{log.stem}-02,{log.resolve()}")
    (folder / "sessions.csv").write_text("\n".join(table) + "\n", encoding="utf-8")


def draw_terminal(text: str, to: Path) -> None:
    """What a command printed, as a terminal shows it."""
    from footcal_cli.plots.style import new_figure

    lines = text.rstrip().splitlines()
    figure = new_figure(0.145 * len(lines) + 0.2)
    figure.set_facecolor("#101418")
    figure.text(0.015, 0.5, "\n".join(lines), family="monospace", fontsize=8, color="#e6e9ee",
                va="center", linespacing=1.35, parse_math=False)  # fmt: skip
    figure.savefig(to, dpi=130)


def shrink(picture: Path) -> None:
    """The same with few colours; a picture that stays too large is an error."""
    from PIL import Image

    Image.open(picture).convert("RGB").quantize(_COLOURS).save(picture, optimize=True)
    size = picture.stat().st_size
    assert size < MOST_BYTES, f"{picture.name} has {size} bytes, more than {MOST_BYTES}"


def main(out: Path) -> None:
    """Make every picture; a figure that the runs no longer draw is an error."""
    pictures = Path(__file__).with_name("pictures")
    for name, figure in PICTURES.items():
        (pictures / f"{name}.png").write_bytes((out / figure).read_bytes())
    for name, printed in TERMINALS.items():
        texts = [
            f"$ {command}\n{(out / file).read_text(encoding='utf-8').rstrip()}"
            for command, file in printed.items()
        ]
        draw_terminal("\n\n".join(texts), pictures / f"{name}.png")
    for name in (*PICTURES, *TERMINALS):
        shrink(pictures / f"{name}.png")


if __name__ == "__main__":
    if sys.argv[1] == "--sessions":
        monthly_sessions(Path(sys.argv[2]))
    else:
        main(Path(sys.argv[1]))
