"""Rebuild the sample logs that a physics engine's motions are turned into: `make samples`.

The engine (MuJoCo, extra ``physics``) makes the motions, footcal's chain and the hexapod's sensors
turn them into logs; the same versions give the same bytes. With ``--motions`` the engine's output
is kept there, or taken from there where it exists.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ENGINE = {"biped": "motion_stand.parquet", "hexapod": "motion_hang.parquet"}
"""Generator -> a file by which its output is known."""


def main() -> None:
    """Run the engine where needed, then the makers of the sample folders."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--motions", type=Path, help="where the engine's motions are kept")
    parser.add_argument(
        "--engine-python", default=sys.executable, help="a Python that has MuJoCo installed"
    )
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        motions: Path = options.motions or Path(scratch)
        for robot, mark in ENGINE.items():
            if not (motions / mark).exists():
                run(options.engine_python, HERE / "physics" / f"{robot}.py", "--out", motions)
        for robot in ENGINE:
            run(sys.executable, HERE / robot / "make.py", motions)


def run(python: str, script: Path, *arguments: str | Path) -> None:
    """Run a script; its failure ends this one."""
    print(f"{script.relative_to(HERE.parent)} {' '.join(map(str, arguments))}", flush=True)
    subprocess.run([python, str(script), *map(str, arguments)], check=True)


if __name__ == "__main__":
    main()
