"""A stream in two files is the stream: standing and walking cut in time, nothing moves."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.conftest import REPOSITORY, Run

BIPED = REPOSITORY / "sample_data" / "biped"
RECIPE = REPOSITORY / "recipes" / "nao_walk.toml"


def _halves(folder: Path, log: str) -> list[str]:
    whole = pd.read_parquet(BIPED / f"{log}.parquet")
    early = whole["time_s"] < whole["time_s"].median()
    paths = []
    for i, part in enumerate((whole[early], whole[~early])):
        paths.append(str(folder / f"{log}_{i}.parquet"))
        part.to_parquet(paths[-1])
    return paths


@pytest.mark.parametrize(
    ("command", "log"),
    [("static-init", "stand"), pytest.param("online-replay", "walk_004", marks=pytest.mark.slow)],
)
def test_a_stream_in_two_files_moves_nothing(
    run: Run, command: str, log: str, tmp_path: Path
) -> None:
    whole = [str(BIPED / f"{log}_{kind}.parquet") for kind in ("cells", "body")]
    cut = [path for kind in ("cells", "body") for path in _halves(tmp_path, f"{log}_{kind}")]
    found = []
    for i, logs in enumerate((whole, cut)):
        out = tmp_path / str(i)
        assert run(command, *logs, "--recipe", RECIPE, "--quiet", "--out", out).exit_code == 0
        numbers = json.loads(Path(out, "parameters.json").read_text("utf-8"))["parameters"]
        found.append(np.array([[p["value"], p["sd"]] for p in numbers.values()]))
    np.testing.assert_array_equal(found[0], found[1])


@pytest.mark.parametrize("pair", [("left_fl", "left_fr"), ("right_rl", "right_rr"),
                                  ("left_rr", "right_fl")])  # fmt: skip
def test_two_exchanged_cells_of_a_walk_are_seen(
    run: Run, pair: tuple[str, str], tmp_path: Path
) -> None:
    one, other = (f"{name}_counts" for name in pair)
    cells = pd.read_parquet(BIPED / "walk_002_cells.parquet")
    log = tmp_path / "cells.parquet"
    cells.assign(**{one: cells[other], other: cells[one]}).to_parquet(log)
    words = ("check", log, BIPED / "walk_002_body.parquet", "--recipe", RECIPE, "--quiet")
    run(*words, "--out", tmp_path / "out")
    findings = json.loads((tmp_path / "out" / "run.json").read_text("utf-8"))["findings"]
    codes = {f["where"] for f in findings if f["code"] == "exchanged_channels"}
    assert codes == {", ".join(pair)}
