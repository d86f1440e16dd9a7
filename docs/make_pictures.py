"""Copy the figures that README and documents show from ``make demo`` and one walk more.

``make pictures`` runs both; the walk has a tilted IMU, which five causes explain alike.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

PICTURES = {
    "offline_fit": "bench_foot/figures/cop_errors_left.png",
    "static_init": "stand/figures/curve.png",
    "online_replay": "walk/figures/cop.png",
    "online_cycles": "walk/figures/cycles.png",
    "hang_calib": "hang/figures/residuals.png",
    "pose_calib": "pose/figures/mounting.png",
    "simulate": "simulated/figures/shown_and_true.png",
    "diagnose": "diagnosis/figures/residual_against_driver.png",
    "likeness": "rivals/figures/isolability.png",
}
"""Picture -> figure of the demo's run folders."""


def main(out: str) -> None:
    """Copy every picture; a figure that the demo no longer draws is an error."""
    pictures = Path(__file__).with_name("pictures")
    for name, figure in PICTURES.items():
        shutil.copyfile(Path(out) / figure, pictures / f"{name}.png")


if __name__ == "__main__":
    main(sys.argv[1])
