"""``footcal diagnose`` of weights: what each cell has of its own, wrong labels, copied rows."""

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
from tests.conftest import Run

CELLS = ("left_fl", "left_fr", "left_rl")
LADDER = (0.0, 1.3, 3.1, 6.2, 9.7, 13.0, 16.4, 20.0)


def weights(seed: int, curves: Sequence[float], mislabelled_n: float = 0.0) -> pd.DataFrame:
    """Ladders up and down on three cells, ten days: x + q x², q of each cell."""
    rng = np.random.default_rng(seed)
    load = np.repeat([*LADDER, *LADDER[-2::-1]], 6)
    rows = []
    for cell, curve in zip(CELLS, curves, strict=True):
        scale = -3.4e-5 * (1 + 0.02 * rng.standard_normal())
        for day in range(10):
            force = (load + curve * load**2) * (1 + 0.001 * rng.standard_normal())
            force = force + 0.01 * rng.standard_normal() + 0.02 * rng.standard_normal(load.size)
            written = np.where(load == LADDER[4], load - mislabelled_n, load)
            rows.append(
                pd.DataFrame(
                    {
                        "channel": cell,
                        "load_n": written,
                        "counts": np.rint(8.3e6 + force / scale),
                        "time_s": 3.0 * np.arange(load.size),
                        "session": f"day {day + 1}",
                    }
                )
            )
    return pd.concat(rows)


CURVES = few_or_all("nonlinearity", "nonlinearity_cubic", "hinge", "hysteresis", "wrong_weight")


def diagnosed(run: Run, table: pd.DataFrame, folder: Path, *more: str) -> DiagnosisRecord:
    table.to_csv(folder / "weights.csv", index=False)
    answer = run(
        "diagnose", folder / "weights.csv", "--experiment", "weights", "--tolerance-n", "0.01",
        "--out", folder / "out", *more,
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    return read_record(DiagnosisRecord, folder / "out/diagnosis.json")


@CURVES
def test_cells_with_a_curve_each_of_their_own(
    run: Run, tmp_path: Path, few: tuple[str, ...]
) -> None:
    curves = (6e-4, -5e-4, 2e-4)
    record = diagnosed(run, weights(1, curves), tmp_path, *few)
    (cause,) = record.causes
    assert (cause.effect, cause.where) == ("nonlinearity", "each cell of its own")
    # the sentence and the figures of the record say the same
    gain = cause.held_out_gain
    assert gain is not None
    assert f"from {gain.before:.3g} to {gain.after:.3g} {gain.unit}" in record.sentence
    assert f"better in {cause.blocks_better} of {record.blocks} blocks" in record.sentence
    extended = read_record(ParametersRecord, tmp_path / "out/parameters_extended.json")
    for cell, curve in zip(CELLS, curves, strict=True):
        found = extended.parameters[f"{cell}.quadratic"]
        drawn = record.ranges[f"{cell}.quadratic"]
        assert (drawn.mean, drawn.unit) == (found.value, found.unit)
        assert drawn.low < drawn.mean < drawn.high
        assert found.sd is not None
        assert found.sd < 8e-5
        assert abs(found.value - curve) < 3 * found.sd


@pytest.mark.slow
def test_cells_alike_are_not_distinguished(run: Run, tmp_path: Path) -> None:
    record = diagnosed(run, weights(2, (3e-4, 3e-4, 3e-4)), tmp_path)
    (cause,) = record.causes
    assert (cause.effect, cause.where) == ("nonlinearity", "all cells")


@CURVES
def test_a_weight_with_a_wrong_label(run: Run, tmp_path: Path, few: tuple[str, ...]) -> None:
    record = diagnosed(run, weights(3, (0.0, 0.0, 0.0), mislabelled_n=0.08), tmp_path, *few)
    (cause,) = record.causes
    assert cause.effect == "wrong_weight"
    assert cause.size == pytest.approx(0.08, abs=0.01)
    extended = read_record(ParametersRecord, tmp_path / "out/parameters_extended.json")
    assert extended.parameters["robot.label"].value == pytest.approx(LADDER[4] - 0.08, abs=0.02)


def test_days_that_differ_by_a_per_mille_are_no_unit_and_rows_written_twice_are_used_once(
    run: Run, tmp_path: Path
) -> None:
    table = weights(4, (0.0, 0.0, 0.0))
    (tmp_path / "once").mkdir()
    (tmp_path / "twice").mkdir()
    once = diagnosed(run, table, tmp_path / "once")
    twice = diagnosed(run, pd.concat([table, table.iloc[100:300]]), tmp_path / "twice")
    assert once.verdict == "none"
    assert twice.verdict == "none"
    assert [c.effect for c in twice.causes] == [c.effect for c in once.causes]
    assert [(r.effect, r.p) for r in twice.effects] == [(r.effect, r.p) for r in once.effects]
    assert "rows_given_twice" in {f.code for f in twice.findings}
    assert "rows_given_twice" not in {f.code for f in once.findings}


def short(seed: int, curve: float) -> pd.DataFrame:
    """Four sessions with one reading of each load on three cells, of which the second is bent."""
    rng = np.random.default_rng(seed)
    load = np.tile([*LADDER, *LADDER[-2::-1]], 4)
    rows = []
    for cell in CELLS:
        force = load + curve * load**2 * (cell == CELLS[1]) + 0.02 * rng.standard_normal(load.size)
        rows.append(
            pd.DataFrame(
                {
                    "channel": cell, "load_n": load, "counts": np.rint(8.3e6 - force / 3.4e-5),
                    "time_s": 20.0 * np.arange(load.size), "session": np.arange(load.size) // 15,
                }
            )
        )  # fmt: skip
    return pd.concat(rows)


@pytest.mark.parametrize("curve", [0.0, 6e-4])
def test_four_sessions_of_one_cell_show_its_curve(run: Run, tmp_path: Path, curve: float) -> None:
    """No signs of four blocks reach a level (2⁻³): rows and cells tell how readings scatter."""
    record = diagnosed(run, short(7, curve), tmp_path)
    if not curve:
        assert record.verdict == "none"
        return
    cause = record.causes[0]
    named = {cause.effect, *cause.rivals}
    assert record.verdict in ("named", "ambiguous")
    assert "nonlinearity" in named <= {"nonlinearity", "nonlinearity_cubic", "hinge", "dead_zone"}
    assert cause.where == CELLS[1]


def test_what_offline_fit_finds_in_one_cell_is_named(run: Run, tmp_path: Path) -> None:
    """Creep 3 % in one of three cells on three days."""
    rng = np.random.default_rng(6)
    load = np.repeat([0.0, 6.0, 12.0, 20.0, 12.0, 6.0, 0.0], 6)
    rows = []
    for cell in CELLS:
        for day in range(3):
            slow = np.zeros(load.size)
            for i in range(1, load.size):
                slow[i] = load[i - 1] + (slow[i - 1] - load[i - 1]) * np.exp(-10.0 / 60.0)
            creep = 0.03 * slow if cell == CELLS[0] else 0.0
            force = load + creep + 0.01 * rng.standard_normal() + 0.02 * rng.standard_normal(42)
            rows.append(
                pd.DataFrame(
                    {
                        "channel": cell, "load_n": load, "time_s": 10.0 * np.arange(load.size),
                        "counts": np.rint(8.3e6 - force / 3.4e-5), "session": f"day {day + 1}",
                    }
                )
            )  # fmt: skip
    record = diagnosed(run, pd.concat(rows), tmp_path)
    assert record.causes[0].effect.startswith("creep")
    assert record.causes[0].where == CELLS[0]


def test_what_offline_fit_finds_in_six_blocks_has_a_name(run: Run, tmp_path: Path) -> None:
    """A loop of 0.6 N in one of three cells, two ladders each: no signs could judge it."""
    rng = np.random.default_rng(9)
    load = np.tile([*LADDER, *LADDER[-2::-1]], 2)
    behind = np.zeros(load.size)
    for i in range(1, load.size):  # friction follows within ±0.3 N
        behind[i] = np.clip(behind[i - 1] + load[i] - load[i - 1], -0.3, 0.3)
    rows = []
    for cell in CELLS:
        force = load - behind * (cell == CELLS[1]) + 0.01 * rng.standard_normal(load.size)
        columns = {"channel": cell, "load_n": load, "counts": np.rint(8.3e6 - force / 3.4e-5)}
        rows.append(pd.DataFrame({**columns, "session": np.arange(load.size) // 15}))
    record = diagnosed(run, pd.concat(rows), tmp_path)
    said = [record.causes[0].effect, *(name for own in record.rivals for name in own)]
    assert "hysteresis" in said, record.sentence
    assert record.causes[0].where == CELLS[1]
