"""Take the pictures that README and documents show from ``make demo`` and a few runs more.

``make pictures`` makes the runs: a walk with a tilted IMU, which five causes explain alike, and one
with a stuck cell.
"""

from __future__ import annotations

import sys
from pathlib import Path

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
    main(Path(sys.argv[1]))
