"""What a recipe states is compared with what the log says."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest

from tests.cli.test_run_folder import LOG
from tests.conftest import REPOSITORY, Run

BIPED = REPOSITORY / "sample_data/biped"
RECIPE = REPOSITORY / "recipes/nao_walk.toml"


def findings(out: Path) -> set[tuple[str, str]]:
    run = json.loads((out / "run.json").read_text())
    return {(f["code"], f["where"]) for f in run["findings"]}


def level(out: Path) -> str:
    return str(json.loads((out / "run.json").read_text())["verdict"]["level"])


@pytest.mark.parametrize(
    ("scale", "words"),
    [(1.0 / 9.80665, "noted in kg"), (1e3 / 9.80665, "noted in g"), (-1.0, "sign")],
)
def test_a_scale_that_the_nameplate_contradicts(
    run: Run, tmp_path: Path, scale: float, words: str
) -> None:
    rows = [line.split(",") for line in LOG.splitlines()[1:]]
    log = tmp_path / "weights.csv"
    log.write_text(
        "channel,load_n,counts\n" + "".join(f"{c},{float(n) * scale},{s}\n" for c, n, s in rows)
    )
    recipe = tmp_path / "r.toml"
    recipe.write_text("[robot.nameplate]\nscale_n_per_count = -3.4e-5\n")
    out = tmp_path / "out"
    answer = run("offline-fit", log, "--recipe", recipe, "--out", out)
    assert ("scale_off_nameplate", "left_fl") in findings(out)
    assert words in answer.out
    assert level(out) == "bad"
    log.write_text(LOG)
    run("offline-fit", log, "--recipe", recipe, "--out", out, "--overwrite")
    assert ("scale_off_nameplate", "left_fl") not in findings(out)


@pytest.fixture(scope="module")
def belief(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from footcal_cli.app import main

    out = tmp_path_factory.mktemp("belief") / "cells"
    with pytest.raises(SystemExit) as end:
        main(["offline-fit", "--recipe", str(RECIPE), "--models", "affine", "--out", str(out)])
    assert end.value.code == 0
    return out / "parameters.json"


@pytest.mark.parametrize("factor", [-1.0, 6.0, 1e13])
def test_apply_compares_the_forces_with_the_weight(
    run: Run, tmp_path: Path, belief: Path, factor: float
) -> None:
    record = json.loads(belief.read_text())
    for name, parameter in record["parameters"].items():
        if name.endswith((".scale", ".bias")):
            parameter["value"] *= factor
    wrong = tmp_path / "parameters.json"
    wrong.write_text(json.dumps(record))
    log = BIPED / "walk_004_cells.parquet"
    out = tmp_path / "out"
    run("apply", log, "--recipe", RECIPE, "--parameters", wrong, "--out", out)
    assert level(out) == "bad"
    strict = ("apply", log, "--recipe", RECIPE, "--out", tmp_path / "b", "--strict-findings")
    assert run(*strict, "--parameters", wrong).exit_code == 1
    good = tmp_path / "good"
    assert (
        run("apply", log, "--recipe", RECIPE, "--parameters", belief, "--out", good).exit_code == 0
    )
    assert level(good) == "good"


@pytest.mark.parametrize(("fault", "code"), [("dead", "dead_cell"), ("turned", "turned_sign")])
def test_a_cell_that_cannot_be_right_is_bad_data_everywhere(
    run: Run, tmp_path: Path, belief: Path, fault: str, code: str
) -> None:
    cells = pd.read_parquet(BIPED / "walk_004_cells.parquet")
    counts = cells["left_rr_counts"].astype(float)
    zero = counts.max()  # the scale is negative: an unloaded cell reads the largest
    cells["left_rr_counts"] = zero if fault == "dead" else 2 * zero - counts
    log = tmp_path / "walk.parquet"
    cells.to_parquet(log)
    given = (log, BIPED / "walk_004_body.parquet", "--recipe", RECIPE, "--parameters", belief)
    out = tmp_path / "diagnosis"
    answer = run("diagnose", *given, "--experiment", "walk", "--no-pictures", "--out", out)
    assert answer.exit_code == 3, answer.err
    assert json.loads((out / "diagnosis.json").read_text())["verdict"] == "bad-data"
    assert (code, "left_rr") in findings(out)


def test_a_clean_walk_raises_nothing(run: Run, tmp_path: Path, belief: Path) -> None:
    out = tmp_path / "out"
    run(
        "apply", BIPED / "walk_010_cells.parquet", "--recipe", RECIPE, "--parameters", belief,
        "--out", out,
    )  # fmt: skip
    assert not findings(out)
