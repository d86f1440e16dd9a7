"""`make samples` gives what is committed: engine and chain run anew, every number the same."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest


@pytest.mark.slow
def test_the_biped_logs_can_be_made_again(repository: Path, tmp_path: Path) -> None:
    pytest.importorskip("mujoco", reason="the physics engine is a development dependency")
    folder = repository / "sample_data"
    motions, made = tmp_path / "motions", tmp_path / "made"
    for script, arguments in (
        (folder / "physics/biped.py", ("--out", motions)),
        (folder / "biped/make.py", (motions, "--out", made)),
    ):
        subprocess.run([sys.executable, script, *map(str, arguments)], check=True, cwd=repository)
    committed = sorted((folder / "biped").glob("*.parquet"))
    assert len(committed) == 16
    for path in committed:
        pd.testing.assert_frame_equal(pd.read_parquet(path), pd.read_parquet(made / path.name))
