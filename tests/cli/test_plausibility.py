"""What a recipe states is compared with what the log says."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.plausibility import check_leg_weights, check_supported
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
    [
        (1.0 / 9.80665, "noted in kg"),
        (1e3 / 9.80665, "noted in g"),
        (-1.0, "sign"),
        (0.004, "gain"),
    ],
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


def test_a_cell_whose_calibration_falls_with_the_load_is_not_turned(
    run: Run, tmp_path: Path, belief: Path
) -> None:
    """A bridge wired the other way round from the start, which its weights have shown."""
    cells = pd.read_parquet(BIPED / "walk_004_cells.parquet")
    counts = cells["left_rr_counts"].astype(float)
    cells["left_rr_counts"] = 2 * counts.max() - counts
    log = tmp_path / "walk.parquet"
    cells.to_parquet(log)
    record = json.loads(belief.read_text())
    scale, bias = (record["parameters"][f"left_rr.{name}"] for name in ("scale", "bias"))
    bias["value"] += 2 * counts.max() * scale["value"]
    scale["value"] *= -1.0
    known = tmp_path / "parameters.json"
    known.write_text(json.dumps(record))
    out = tmp_path / "out"
    run("apply", log, "--recipe", RECIPE, "--parameters", known, "--out", out)
    assert "turned_sign" not in {code for code, _ in findings(out)}
    other = tmp_path / "other"
    run("apply", log, "--recipe", RECIPE, "--parameters", belief, "--out", other)
    assert ("turned_sign", "left_rr") in findings(other)


def test_a_clean_walk_raises_nothing(run: Run, tmp_path: Path, belief: Path) -> None:
    out = tmp_path / "out"
    run(
        "apply", BIPED / "walk_010_cells.parquet", "--recipe", RECIPE, "--parameters", belief,
        "--out", out,
    )  # fmt: skip
    assert not findings(out)


@pytest.mark.parametrize(
    ("newtons", "stated", "codes"),
    [
        (1.0, None, []),
        (1.0 / 4.448222, None, ["legs_very_light"]),
        (1.0 / 9.80665, None, ["legs_very_light"]),
        (1e3 / 9.80665, None, ["legs_heavier_than_robot"]),
        (1.0, 6.0, []),
        (1.0 / 4.448222, 6.0, ["leg_weight_off_recipe"] * 2),
        (1.0 / 9.80665, 6.0, ["leg_weight_off_recipe"] * 2),
    ],
)
def test_legs_against_the_robot_and_against_their_stated_weights(
    newtons: float, stated: float | None, codes: list[str]
) -> None:
    """Two legs of 6.2 N below a robot of 30 N; their forces in other units under ``_n``."""
    known = None if stated is None else {"fl": stated, "fr": stated}
    found = check_leg_weights({"fl": 6.2 * newtons, "fr": 6.2 * newtons}, 30.0, known)
    assert [f.code for f in found] == codes


@pytest.mark.parametrize(("factor", "found"), [(1.0, 0), (0.9, 0), (1 / 4.448222, 1), (6.0, 1)])
def test_forces_at_the_hips_against_what_they_support(factor: float, found: int) -> None:
    rng = np.random.default_rng(0)
    carried = np.array([0.0, 0.0, 43.0])
    error = factor * (carried + rng.normal(0.0, 0.5, (50, 3))) - carried
    assert len(check_supported(error, 43.0, "all legs")) == found


def test_a_doubt_about_units_is_not_good_and_says_what_to_do(run: Run, tmp_path: Path) -> None:
    """Rows of no load tell the zero alone; whoever gave them meant loads."""
    log, out = tmp_path / "weights.csv", tmp_path / "out"
    log.write_text("channel,load_n,counts\n" + "a,0,5\na,0,6\n" * 3, "utf-8")
    run("check", log, "--out", out)
    assert level(out) == "warning"
    assert ("no_load", "load") in findings(out)


def test_a_log_of_the_empty_cell_next_to_others_is_no_doubt(run: Run, tmp_path: Path) -> None:
    rows = {0: (5, 6, 5), 10: (105, 106, 104), 20: (205, 204, 206)}
    for load, read in rows.items():
        lines = ["channel,load_n,counts", *(f"a,{load},{value}" for value in read)]
        (tmp_path / f"weights_{load}.csv").write_text("\n".join(lines) + "\n", "utf-8")
    out = tmp_path / "out"
    run("offline-fit", *sorted(tmp_path.glob("weights_*.csv")), "--out", out)
    assert "no_load" not in {code for code, _ in findings(out)}


def test_where_nothing_usable_comes_out_the_alarm_before_it_is_said(
    run: Run, tmp_path: Path, belief: Path
) -> None:
    for name in ("cells", "body"):
        table = pd.read_parquet(BIPED / f"walk_004_{name}.parquet").iloc[:300]
        if name == "body":
            table = table.assign(time_s=table["time_s"] + 86400.0)
        table.to_parquet(tmp_path / f"{name}.parquet")
    logs = (tmp_path / "cells.parquet", tmp_path / "body.parquet")
    answer = run(
        "static-init", *logs, "--recipe", RECIPE, "--parameters", belief, "--out", tmp_path / "o"
    )
    assert answer.exit_code == 3
    assert "share no moment" in answer.err
    assert answer.err.count("\n") == 1
