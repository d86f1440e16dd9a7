"""Evidence is not copied: rows given twice count once, whatever the file is called."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.tables.copies import without_copies
from footcal_cli.tables.table import Table
from tests.conftest import Run

SCALE, ZERO = -3.4e-5, 8.3e6


def weights(rows: int = 60, seed: int = 0, step: float = 1.0) -> pd.DataFrame:
    rng = np.random.default_rng(seed)
    load_n = np.tile([0.0, 5.0, 10.0, 20.0], rows // 4)
    counts = ZERO + load_n / SCALE + 300 * rng.standard_normal(load_n.size)
    return pd.DataFrame(
        {"channel": "left_fl", "load_n": load_n, "counts": step * np.round(counts / step)}
    )


def stream(rows: int = 200, seed: int = 0) -> pd.DataFrame:
    rng = np.random.default_rng(seed)
    noise = rng.integers(-3, 4, rows)
    return pd.DataFrame({"time_s": 0.1 * np.arange(rows), "left_fl_counts": 8_300_000 + noise})


def kept_rows(*logs: pd.DataFrame) -> list[int]:
    tables = [Table(log, Path(f"{i}.csv"), str(i)) for i, log in enumerate(logs)]
    kept, findings = without_copies(tables)
    changed = [t.path.name for t, k in zip(tables, kept, strict=True) if k is not t]
    assert sorted(f.where for f in findings) == changed
    return [0 if table is None else len(table) for table in kept]


def test_a_copy_counts_once_in_any_order_of_rows_columns_and_labels() -> None:
    log = weights()
    shuffled = log.sample(frac=1, random_state=1)[["counts", "load_n", "channel"]]
    relabelled = log.assign(repeat=2)
    assert kept_rows(log, shuffled, relabelled) == [60, 0, 0]
    assert kept_rows(log, log.assign(load_n=log["load_n"] * (1 + 1e-13))) == [60, 0]


def test_of_a_part_and_the_whole_the_whole_counts() -> None:
    log = weights()
    assert kept_rows(log.iloc[::3], log) == [0, 60]
    assert kept_rows(pd.concat([log.iloc[:30], weights(seed=5)]), log) == [90, 60]
    assert kept_rows(pd.concat([log, weights(seed=5)]), log) == [120, 0]


def test_recordings_that_overlap_count_once() -> None:
    log = stream()
    assert kept_rows(log.iloc[:120], log.iloc[100:]) == [120, 80]
    assert kept_rows(log, log.assign(left_fl_counts=log["left_fl_counts"] + 1)) == [200, 200]


def test_rows_written_twice_into_one_log_count_once() -> None:
    log = weights(40)
    timed = log.assign(time_s=7.0 * np.arange(40.0))
    twice = pd.concat([timed, timed.iloc[10:30]], ignore_index=True)
    relabelled = pd.concat([timed.assign(session="a"), timed.assign(session="b")])
    for table, rows in ((twice, 40), (relabelled, 40), (timed, 40)):
        read = Table(table.reset_index(drop=True), Path("a.csv"), "a")
        (kept,), findings = without_copies([read], within=True)
        assert kept is not None
        assert len(kept) == rows
        assert len(findings) == (len(table) > rows)


@pytest.mark.parametrize("label", [{}, {"repeat": 2}])
def test_a_block_written_twice_is_found_without_stamps_and_no_more_than_it(
    label: dict[str, int],
) -> None:
    log = weights(80, seed=4)
    again = pd.concat([log.iloc[:40], log.iloc[25:].assign(**label)], ignore_index=True)
    (kept,), (finding,) = without_copies([Table(again, Path("a.csv"), "a")], within=True)
    assert kept is not None
    assert kept.number("counts").tolist() == log["counts"].tolist()
    assert finding.sentence.startswith("a.csv: 15 of 95 rows are a copy")


def test_equal_readings_are_no_copies_where_the_converter_is_coarse_or_repeats_are_few() -> None:
    rng = np.random.default_rng(1)
    for _ in range(200):
        load = np.repeat(np.array([0, 5, 10, 20, 10, 5, 0.0])[: rng.integers(4, 8)],
                         rng.integers(2, 12))  # fmt: skip
        counts = 8.3e6 - 3e4 * load + rng.choice([0.4, 3.0, 40.0]) * rng.normal(size=load.size)
        counts = np.round(counts / rng.choice([1, 3000]))
        log = pd.DataFrame({"channel": "left_fl", "load_n": load, "counts": counts})
        assert without_copies([Table(log, Path("a.csv"), "a")], within=True)[1] == []


def test_measurements_of_their_own_are_no_copies() -> None:
    assert kept_rows(weights(seed=1), weights(seed=2)) == [60, 60]
    # one seventh of the readings agree by chance where the noise is a few counts
    assert kept_rows(stream(seed=1), stream(seed=2)) == [200, 200]
    # a coarse converter shows each load as one of three readings
    assert kept_rows(weights(seed=1, step=300), weights(seed=2, step=300)) == [60, 60]


@pytest.mark.parametrize("kind", ["csv", "csv.gz", "parquet"])
def test_a_log_given_twice_moves_nothing(run: Run, tmp_path: Path, kind: str) -> None:
    log = weights()
    log.to_csv(tmp_path / "a.csv", index=False)
    copy = tmp_path / f"b.{kind}"
    if kind == "parquet":
        log.to_parquet(copy)
    else:
        log.to_csv(copy, index=False)
    found = {}
    for name, logs in {"once": ["a.csv"], "twice": ["a.csv", copy.name]}.items():
        out = tmp_path / name
        paths = [tmp_path / log_name for log_name in logs]
        assert run("offline-fit", *paths, "--out", out, "--quiet").exit_code == 0
        found[name] = json.loads((out / "parameters.json").read_text("utf-8"))["parameters"]
        codes = [f["code"] for f in json.loads((out / "run.json").read_text("utf-8"))["findings"]]
        assert ("rows_given_twice" in codes) is (name == "twice")
    assert found["twice"] == found["once"]


def test_a_held_out_log_is_no_copy_of_what_was_fitted(run: Run, tmp_path: Path) -> None:
    weights().to_csv(tmp_path / "a.csv", index=False)
    weights().to_csv(tmp_path / "b.csv", index=False)
    recipe = tmp_path / "recipe.toml"
    recipe.write_text('[data]\nweights = "a.csv"\nweights_held_out = "b.csv"\n', "utf-8")
    out = tmp_path / "out"
    assert run("offline-fit", "--recipe", recipe, "--out", out, "--quiet").exit_code == 0
    rows = json.loads((out / "rmse.json").read_text("utf-8"))["rows"]
    assert not [row for row in rows if "b.csv" in row["reference"]]
    assert "rows_given_twice" in (out / "run.json").read_text("utf-8")
