"""``footcal diagnose`` of several experiments at once."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord
from tests.cli.few_effects import few_or_all
from tests.conftest import Answer, Run

CELLS = ("left_fl", "left_fr", "left_rl")
FEW = (0.0, 10.0, 20.0)
MANY = (0.0, 1.3, 3.1, 6.2, 9.7, 13.0, 16.4, 20.0)
QUADRATIC = 4e-4


def ladders(
    folder: Path, seed: int, loads: Sequence[float], quadratic: float, days: int = 8
) -> Path:
    """Ladders up and down on three cells, eight days: x + q x²; scale and zero of each day."""
    rng = np.random.default_rng(seed)
    load = np.repeat([*loads, *loads[-2::-1]], 5)
    rows = []
    for cell in CELLS:
        scale = -3.4e-5 * (1 + 0.02 * rng.standard_normal())
        for day in range(days):
            force = (load + quadratic * load**2) * (1 + 0.0005 * rng.standard_normal())
            force += 0.01 * rng.standard_normal() + 0.02 * rng.standard_normal(load.size)
            rows.append(
                pd.DataFrame(
                    {
                        "channel": cell, "load_n": load, "time_s": 3.0 * np.arange(load.size),
                        "counts": np.rint(8.3e6 + force / scale), "session": f"day {day + 1}",
                    }
                )
            )  # fmt: skip
    folder.mkdir(parents=True)
    pd.concat(rows).to_csv(folder / "weights.csv", index=False)
    return folder


CURVES = few_or_all("nonlinearity", "nonlinearity_cubic", "hinge", "dead_zone", "hysteresis")


def together(run: Run, folder: Path, *logs: str | Path) -> Answer:
    return run("diagnose", *logs, "--tolerance-n", "0.01", "--out", folder / "out", "--no-pictures")


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Weights of the same cells on two benches, and of others that are straight."""
    folder = tmp_path_factory.mktemp("bench")
    ladders(folder / "few weights", 1, FEW, QUADRATIC)
    ladders(folder / "many weights", 2, MANY, QUADRATIC)
    ladders(folder / "straight weights", 3, MANY, 0.0)
    ladders(folder / "one day's weights", 4, MANY, 0.0, days=1)
    return folder


@CURVES
def test_one_experiment_closes_what_another_leaves_open(
    run: Run, bench: Path, tmp_path: Path, few: tuple[str, ...]
) -> None:
    answer = together(run, tmp_path, bench / "few weights", bench / "many weights", *few)
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    three, many = record.experiments
    assert (three.name, many.name) == ("few weights", "many weights")
    # three loads are a parabola through any curve
    assert "nonlinearity" in three.names[0]
    assert len(three.names[0]) > 1
    (cause,) = record.causes
    assert (record.verdict, cause.effect, cause.where) == ("named", "nonlinearity", "all cells")
    assert cause.sd is not None
    assert abs(cause.size - QUADRATIC) < 3 * cause.sd
    assert cause.probability["nonlinearity"] > 0.95
    assert cause.agreement_p is not None
    assert cause.agreement_p > 0.003
    extended = read_record(ParametersRecord, tmp_path / "out/parameters_extended.json")
    assert extended.parameters["left.quadratic"].value == pytest.approx(cause.size)
    assert "few weights alone cannot distinguish nonlinearity from" in answer.out


@CURVES
def test_sizes_that_exclude_each_other_name_nothing(
    run: Run, bench: Path, tmp_path: Path, few: tuple[str, ...]
) -> None:
    answer = together(run, tmp_path, bench / "many weights", bench / "straight weights", *few)
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    assert record.verdict == "unknown"
    assert record.causes == ()
    assert "one size excludes the other" in record.sentence
    assert "in straight weights" in record.sentence


def test_an_experiment_too_short_to_be_tested_is_no_good_one(
    run: Run, bench: Path, tmp_path: Path
) -> None:
    answer = together(run, tmp_path, bench / "straight weights", bench / "one day's weights")
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    assert [one.verdict for one in record.experiments] == ["none", "underpowered"]
    assert (record.verdict, record.causes) == ("underpowered", ())
    assert (
        "No unmodelled effect found in straight weights; not tested: one day's" in record.sentence
    )
    assert "one day's weights by itself: Too few blocks" in answer.out


def test_a_folder_alone_is_its_logs(run: Run, bench: Path, tmp_path: Path) -> None:
    answer = together(run, tmp_path, bench / "straight weights")
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    assert (record.verdict, record.experiment_kind, record.experiments) == ("none", "weights", ())


def test_a_kind_may_stand_before_the_log(run: Run, bench: Path, tmp_path: Path) -> None:
    log = bench / "straight weights" / "weights.csv"
    unclear = together(run, tmp_path, bench / "many weights", log)
    assert unclear.exit_code == 2
    assert "KIND=FILE" in unclear.err
    empty = tmp_path / "weights"
    empty.mkdir()
    nothing = together(run, tmp_path, bench / "many weights", empty)
    assert nothing.exit_code == 2
    assert "no log in this folder" in nothing.err
    nameless = tmp_path / "monday"
    nameless.mkdir()
    (nameless / "a.csv").write_text("x\n1\n")
    assert "which experiment" in together(run, tmp_path, bench / "many weights", nameless).err
