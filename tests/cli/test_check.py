"""``footcal check`` on any kind of log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from footcal_cli.records.files import read_record
from footcal_cli.records.results import RunRecord
from tests.conftest import Run

ROOT = Path(__file__).resolve().parents[2]


def walk_log(path: Path) -> pd.DataFrame:
    rng = np.random.default_rng(0)
    columns = {"time_s": np.arange(800) / 80}
    for cell in ("left_fl", "left_fr", "right_fl", "right_fr"):
        columns[f"{cell}_counts"] = np.round(8.3e6 + 1e3 * rng.standard_normal(800))
    data = pd.DataFrame(columns)
    data.to_csv(path, index=False)
    return data


def codes(out: Path) -> set[tuple[str, str]]:
    return {(f.code, f.where) for f in read_record(RunRecord, out / "run.json").findings}


def test_a_sound_walk_log_passes_without_a_recipe(run: Run, tmp_path: Path) -> None:
    walk_log(tmp_path / "walk.csv")
    answer = run("check", tmp_path / "walk.csv", "--out", tmp_path / "out", "--strict-findings")
    assert answer.exit_code == 0, answer.err
    assert "Nothing wrong found in 800 rows" in answer.out
    assert not codes(tmp_path / "out")


def test_faults_of_a_walk_log_are_named(run: Run, tmp_path: Path) -> None:
    log = tmp_path / "walk.csv"
    data = walk_log(log)
    data["left_fr_counts"] = data["left_fl_counts"]
    data.loc[400:600, "right_fl_counts"] = 8300000
    data.loc[5, "right_fr_counts"] = 2**24 - 1
    data.drop(index=range(100, 140)).to_csv(log, index=False)
    answer = run("check", log, "--out", tmp_path / "out", "--strict-findings")
    assert answer.exit_code == 1
    assert codes(tmp_path / "out") == {
        ("gaps", "walk.csv"),
        ("duplicate_channel", "left_fl_counts, left_fr_counts"),
        ("stuck_channel", "right_fl_counts"),
        ("saturated_codes", "right_fr_counts"),
    }


def test_a_dead_cell_of_a_walk_exchanges_no_others(run: Run, tmp_path: Path) -> None:
    recipe = ROOT / "recipes/nao_simulated.toml"
    run("simulate", "--experiment", "walk", "--effect", "right_fl.channel_stuck=1",
        "--recipe", recipe, "--out", tmp_path / "log")  # fmt: skip
    logs = [tmp_path / "log" / f"{name}.parquet" for name in ("cells", "body")]
    answer = run("check", *logs, "--recipe", recipe, "--out", tmp_path / "out")
    found = {code for code, _ in codes(tmp_path / "out")}
    assert {"stuck_channel", "dead_cell"} <= found, answer.err
    assert "exchanged_channels" not in found


def test_real_logs_of_others_are_read_through_columns(
    run: Run, tmp_path: Path, real_data: Path
) -> None:
    recipe = tmp_path / "loadsol.toml"
    cells = ("heel", "medial", "lateral")
    channels = [f"{foot}_{cell}" for foot in ("left", "right") for cell in cells]
    lines = [f"{c}_counts = '{c.replace('left', 'l').replace('right', 'r')}_N'" for c in channels]
    log = real_data / "loadsol-insoles/test_poids_loadsol.csv"
    recipe.write_text(
        f"[robot]\nchannels = {channels}\n[columns]\ntime_s = 't_s'\n" + "\n".join(lines)
    )
    answer = run("check", log, "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    assert "cells" in answer.out


def test_transducers_in_series_are_checked_as_pose_calib_reads_them(
    run: Run, tmp_path: Path, repository: Path, real_data: Path
) -> None:
    log, recipe = (
        real_data / "icub-four-ft/trial3_four_ft.csv",
        repository / "recipes/icub_four_ft.toml",
    )
    answer = run("check", log, "--recipe", recipe, "--strict-findings", "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.out
    assert "six_axis_feet" in answer.out


def test_a_log_of_no_known_kind_says_so(run: Run, tmp_path: Path) -> None:
    log = tmp_path / "x.csv"
    log.write_text("a,b\n1,2\n")
    answer = run("check", log, "--out", tmp_path / "out")
    assert answer.exit_code == 3
    assert "no known kind of log" in answer.err
    assert run("check", tmp_path / "none.csv", "--out", tmp_path / "o").exit_code == 2
    assert run("check", "--out", tmp_path / "o").exit_code == 2
