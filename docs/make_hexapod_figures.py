"""Figures of [Wu] on simulated logs: naive taring (Figs. 2, 6), hanging residuals (Fig. 5).

Run ``python docs/make_hexapod_figures.py``; it simulates, calibrates and copies two figures.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from footcal_cli.app import main as footcal

HERE = Path(__file__).resolve().parent
RECIPE = HERE.parent / "recipes" / "hexapod_simulated.toml"


def run(*arguments: str | Path) -> None:
    """Run a command; exit code 1 (a gate or a finding) still leaves its figures."""
    try:
        footcal([str(argument) for argument in arguments])
    except SystemExit as end:
        if end.code not in (0, 1, None):
            raise


def main() -> None:
    """Simulate hanging and standing, calibrate both, keep the violins."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for experiment in ("hang", "pose"):
            run("simulate", "--recipe", RECIPE, "--experiment", experiment, "--out",
                folder / experiment, "--quiet")  # fmt: skip
        run("hang-calib", folder / "hang/hang.parquet", "--recipe", RECIPE, "--out",
            folder / "hung", "--quiet")  # fmt: skip
        run("pose-calib", folder / "pose/poses.parquet", "--recipe", RECIPE, "--parameters",
            folder / "hung/parameters.json", "--out", folder / "stood", "--quiet")  # fmt: skip
        figures = HERE / "figures"
        figures.mkdir(exist_ok=True)
        shutil.copyfile(folder / "hung/figures/residuals.png", figures / "hanging_residuals.png")
        shutil.copyfile(folder / "stood/figures/balance.png", figures / "naive_taring.png")


if __name__ == "__main__":
    main()
