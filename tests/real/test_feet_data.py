"""Measured feet of others: a walking humanoid on six-axis ankles, a person on insoles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord, RmseRecord, RunRecord
from tests.conftest import Run

TRIALS = ("14_1", "14_2", "14_3", "14_4", "16_1", "16_2", "16_3", "16_4")


def rmse(path: Path, quantity: str, stage: str) -> float:
    rows = read_record(RmseRecord, path / "rmse.json").rows
    return next(r.rmse for r in rows if (r.quantity, r.stage) == (quantity, stage))


@pytest.mark.parametrize(
    "trials", [TRIALS[::4], pytest.param(TRIALS, marks=pytest.mark.slow)], ids=["two", "eight"]
)
def test_walks_of_a_humanoid_agree_on_its_ankles(
    run: Run, real_data: Path, repository: Path, tmp_path: Path, trials: tuple[str, ...]
) -> None:
    recipe = repository / "recipes/reemc_walking.toml"
    offsets, masses = [], []
    for trial in trials:
        out, log = tmp_path / trial, real_data / f"reemc-walking/{trial}.csv"
        answer = run("online-replay", log, "--recipe", recipe, "--out", out)
        assert answer.exit_code == 0, answer.err
        record = read_record(ParametersRecord, out / "parameters.json")
        names = [
            f"{foot}.offset_{axis}" for foot in ("left", "right") for axis in ("fx", "fy", "fz")
        ]
        assert all(record.parameters[name].status == "estimated" for name in names)
        offsets.append([record.parameters[name].value for name in names])
        masses.append(record.parameters["robot.mass_correction"].value)
        assert rmse(out, "vgrf", "memory") < rmse(out, "vgrf", "before")
        for foot in ("left", "right"):
            found = record.parameters[f"{foot}.offset_fz"]
            assert found.sd is not None
            assert 1.0 < found.sd < 6.0
            assert abs(found.value - swinging(log, foot)) < 2.0 * found.sd
            assert rmse(out, f"{foot}.fz", "memory") < 0.3 * rmse(out, f"{foot}.fz", "before")
        findings = {f.code for f in read_record(RunRecord, out / "run.json").findings}
        # the publishers' model: 68.6 kg, and a motion whose totals ask for no common delay
        assert {
            "mass_differs", "scales_left_alone", "model_wrong", "delay_not_found",
        } <= findings  # fmt: skip
        assert "offset_jump" not in findings
    # two sessions within minutes: the offsets of both ankles repeat to a few newtons
    assert np.std(offsets, axis=0).max() < 4.0
    # 77.7 kg by weight, 68.6 kg in the model
    assert np.array(masses) + 68.6 == pytest.approx(np.full(len(masses), 77.7), abs=1.0)


def swinging(log: Path, foot: str) -> float:
    """What a foot's vertical force reads in the air beyond the weight below it, by hand."""
    raw = pd.read_csv(log)[f"ft{foot[0]}_fz"]
    in_air = raw[raw < raw.quantile(0.1) + 15.0]
    return float(in_air.median() + 19.7)


def test_a_second_of_standing_tells_sums_of_the_ankles_only(
    run: Run, real_data: Path, repository: Path, tmp_path: Path
) -> None:
    answer = run(
        "static-init", real_data / "reemc-walking/14_1.csv", "--recipe",
        repository / "recipes/reemc_walking.toml", "--until-s", "1.0", "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    text = answer.out.replace("\n", " ")
    assert "1 stance shows 5 of 17 unknowns" in text
    assert "lift each foot once" in text
    record = read_record(ParametersRecord, tmp_path / "out/parameters.json")
    assert record.parameters["left.offset_fz"].status == "prior kept: not observable"


def test_three_zones_per_foot_are_what_the_recipe_says(
    run: Run, real_data: Path, repository: Path, tmp_path: Path
) -> None:
    log = real_data / "loadsol-insoles/test_poids_loadsol.csv"
    answer = run(
        "static-init", log, "--recipe", repository / "recipes/loadsol_insoles.toml",
        "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    assert "1 stance shows 1 of 12 directions" in answer.out.replace("\n", " ")
    assert rmse(tmp_path / "out", "vgrf", "before") < 5.0
    lost = read_record(RmseRecord, tmp_path / "out/rmse.json").rejected["dropout"]
    data = pd.read_csv(log)
    zones = [c for c in map(str, data) if c.endswith("_N") and "total" not in c]
    expected = int((data[zones] == -1).any(axis=1).sum())
    assert lost == pytest.approx(expected, abs=20)


def swings(log: Path, foot: str, fewest: int = 15) -> list[int]:
    """Middle rows of all times in which a foot is in the air."""
    raw = pd.read_csv(log)[f"ft{foot[0]}_fz"].to_numpy(dtype=np.float64)
    air = (raw < np.quantile(raw, 0.1) + 15.0).astype(int)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], air, [0]])))
    spans = zip(edges[::2], edges[1::2], strict=True)
    return [int(a + b) // 2 for a, b in spans if b - a > fewest]


@pytest.mark.slow
@pytest.mark.parametrize("foot", ["left", "right"])
def test_one_broken_sample_of_any_swing_moves_nothing(
    run: Run, real_data: Path, repository: Path, tmp_path: Path, foot: str
) -> None:
    log, recipe = real_data / "reemc-walking/14_1.csv", repository / "recipes/reemc_walking.toml"
    raw, whole, column = pd.read_csv(log), tmp_path / "whole", f"ft{foot[0]}_fz"
    assert run("online-replay", log, "--recipe", recipe, "--out", whole).exit_code == 0
    clean = read_record(ParametersRecord, whole / "parameters.json").parameters
    rows = swings(log, foot)
    assert len(rows) > 3
    for row in rows:
        out, values = tmp_path / f"{row}", raw[column].to_numpy(dtype=np.float64, copy=True)
        values[row] += 876.0
        raw.assign(**{column: values}).to_csv(tmp_path / "broken.csv", index=False)
        done = run("online-replay", tmp_path / "broken.csv", "--recipe", recipe, "--out", out)
        assert done.exit_code == 0
        found = read_record(ParametersRecord, out / "parameters.json").parameters
        mass = "robot.mass_correction"
        assert abs(found[mass].value - clean[mass].value) < 0.1, row
        for name, one in clean.items():
            if "offset" in name:
                assert one.sd is not None
                assert abs(found[name].value - one.value) < 0.5 * one.sd, (row, name)
