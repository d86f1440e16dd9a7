"""Every log and every column accounted for: nothing is dropped or misread in silence."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd
import pytest

from footcal_cli.errors import DataError
from footcal_cli.tables.columns import weights_table
from footcal_cli.tables.table import read_table
from tests.cli.test_run_folder import LOG
from tests.conftest import Run

GRAVITY = 9.80665


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "weights.csv"
    path.write_text(LOG)
    return path


def test_a_log_that_no_table_takes_ends_the_command(run: Run, log: Path, tmp_path: Path) -> None:
    other = tmp_path / "day4.csv"
    other.write_text(LOG.replace("counts", "cuonts"))
    answer = run("offline-fit", log, other, "--out", tmp_path / "out")
    assert answer.exit_code == 3
    assert "day4.csv" in answer.err
    assert "did you mean 'cuonts'" in answer.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ["laod_n", "time", "left_lf_counts"])
def test_a_canonical_name_misspelt_in_columns_is_named(
    run: Run, log: Path, tmp_path: Path, name: str
) -> None:
    recipe = tmp_path / "r.toml"
    recipe.write_text(f'[robot]\nchannels = ["left_fl"]\n[columns]\n{name} = "mass"\n')
    answer = run("offline-fit", log, "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    assert name in answer.err


@pytest.mark.parametrize("unit", ["ns", "us", "ms", "s"])
@pytest.mark.parametrize("zone", [None, "Europe/Berlin"])
def test_parquet_stamps_are_seconds(
    tmp_path: Path, unit: Literal["ns", "us", "ms", "s"], zone: str | None
) -> None:
    seconds = np.array([1_700_000_000.0, 1_700_000_007.0, 1_700_000_100.0])
    stamps = pd.Series(pd.to_datetime(seconds, unit="s", utc=True).as_unit(unit))
    stamps = stamps.dt.tz_convert(zone) if zone else stamps.dt.tz_localize(None)
    path = tmp_path / "log.parquet"
    frame = {"channel": "a", "load_n": [0.0, 1, 2], "counts": [1, 2, 3], "time_s": stamps}
    pd.DataFrame(frame).to_parquet(path)
    read = read_table(path, weights_table(), gravity_mps2=GRAVITY)
    np.testing.assert_array_equal(read.number("time_s"), seconds)


def test_durations_and_iso_stamps_are_seconds(tmp_path: Path) -> None:
    frame = pd.DataFrame({"channel": "a", "load_n": [0.0, 1], "counts": [1, 2]})
    path = tmp_path / "log.parquet"
    frame.assign(time_s=pd.to_timedelta([250, 1500], unit="ms")).to_parquet(path)
    read = read_table(path, weights_table(), gravity_mps2=GRAVITY)
    np.testing.assert_allclose(read.number("time_s"), [0.25, 1.5], atol=1e-12)
    text = tmp_path / "log.csv"
    text.write_text(
        "channel,load_n,counts,time_s\na,0,1,2023-11-14T22:13:20.5Z\na,1,2,2023-11-14 22:13:21Z\n"
    )
    read = read_table(text, weights_table(), gravity_mps2=GRAVITY)
    np.testing.assert_allclose(read.number("time_s"), [1_700_000_000.5, 1_700_000_001], atol=1e-6)


@pytest.mark.parametrize(
    "values",
    [
        [True, False], ["1.0", "2.0"], pd.to_datetime([0, 1]), [0.0, 1e308], [0, 2**53 + 1],
        pd.to_timedelta([0, 1]),
    ],
    ids=["booleans", "texts", "dates", "huge", "inexact", "durations"],
)  # fmt: skip
def test_what_is_no_number_is_no_reading(tmp_path: Path, values: object) -> None:
    path = tmp_path / "log.parquet"
    pd.DataFrame({"channel": "a", "load_n": [0.0, 1], "counts": values}).to_parquet(path)
    with pytest.raises(DataError, match="counts"):
        read_table(path, weights_table(), gravity_mps2=GRAVITY)


@pytest.mark.parametrize("load", [9007199254740993.0, 10**13, -2e12])
def test_a_load_of_a_mountain_is_no_load(tmp_path: Path, load: float) -> None:
    path = tmp_path / "log.parquet"
    pd.DataFrame({"channel": "a", "load_n": [0, load], "counts": [1, 2]}).to_parquet(path)
    with pytest.raises(DataError, match="load_n, row 2: too large to be a reading"):
        read_table(path, weights_table(), gravity_mps2=GRAVITY)


@pytest.mark.parametrize("value", ['"5.3"', "true", "[5.3]"])
def test_a_text_or_a_boolean_is_no_number_in_a_recipe(
    run: Run, log: Path, tmp_path: Path, value: str
) -> None:
    recipe = tmp_path / "r.toml"
    recipe.write_text(f"[robot]\nmass_kg = {value}\n")
    answer = run("offline-fit", log, "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    assert "robot.mass_kg" in answer.err


@pytest.mark.parametrize("value", ['"-3e-5"', "true", "NaN", "1e999"])
def test_a_text_or_a_boolean_is_no_number_in_a_calibration(
    run: Run, log: Path, tmp_path: Path, value: str
) -> None:
    assert run("offline-fit", log, "--out", tmp_path / "cells").exit_code == 0
    good = (tmp_path / "cells/parameters.json").read_text()
    start = good.index('"value": ') + len('"value": ')
    bad = good[:start] + value + good[good.index(",", start) :]
    broken = tmp_path / "parameters.json"
    broken.write_text(bad)
    answer = run("offline-fit", log, "--parameters", broken, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    assert answer.err.count("\n") == 1
    assert "parameters.json" in answer.err


@pytest.mark.parametrize(
    ("name", "text"),
    [("deep.json", '{"schema":' + "[" * 100_000), ("deep.toml", "a = " + "[" * 100_000)],
)
def test_what_is_nested_too_deeply_is_the_user_s_fault(
    run: Run, log: Path, tmp_path: Path, name: str, text: str
) -> None:
    path = tmp_path / name
    path.write_text(text)
    option = "--recipe" if name.endswith("toml") else "--parameters"
    answer = run("offline-fit", log, option, path, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    assert answer.err.count("\n") == 1


def test_a_late_byte_that_is_no_text_is_a_fault_of_the_log(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "weights.csv"
    path.write_bytes(LOG.encode() * 1 + b"left_fl,10,\xff\xfe\n")
    answer = run("offline-fit", path, "--out", tmp_path / "out")
    assert answer.exit_code == 3
    assert "weights.csv" in answer.err


def test_a_recipe_of_others_reads_nothing_outside_its_folder(
    run: Run, log: Path, tmp_path: Path
) -> None:
    inner = tmp_path / "theirs"
    inner.mkdir()
    recipe = inner / "r.toml"
    recipe.write_text('[data]\nweights = "../weights.csv"\n')
    answer = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    assert "data_root" in answer.err
    (inner / "link.csv").symlink_to(log)
    recipe.write_text('[data]\nweights = "link.csv"\n')
    assert run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out").exit_code == 2
    recipe.write_text('data_root = ".."\n[data]\nweights = "../weights.csv"\n')
    assert run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out").exit_code == 0
    recipe.write_text(f'[data]\nweights = "{log}"\n')
    assert run("offline-fit", "--recipe", recipe, "--out", tmp_path / "b").exit_code == 0
