"""``footcal offline-fit`` beyond the straight line: staircases, recordings, placements, changes."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lfilter

from footcal_cli.records.files import read_record
from footcal_cli.records.results import (
    CopCorrectionsRecord,
    ParametersRecord,
    RmseRecord,
    RunRecord,
    TruthRecord,
)
from footcal_cli.sheets import bench
from tests.cli.test_diagnose_together import BRIDGES, loaded_together, under_wrenches
from tests.conftest import Run, drawing
from tests.core.bench_data import Staircase


@pytest.fixture(scope="module")
def bench_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One run on the simulated foot, shared by the tests that read it."""
    from footcal_cli.app import main

    root = Path(__file__).resolve().parent.parent.parent
    out = tmp_path_factory.mktemp("bench") / "out"
    recipe = str(root / "recipes/bench_foot.toml")
    with drawing(), pytest.raises(SystemExit) as end:
        main(["offline-fit", "--recipe", recipe, "--out", str(out), "--quiet"])
    assert end.value.code == 0
    return out


def rmse_of(out: Path, quantity: str, stage: str, reference: str) -> float:
    rows = read_record(RmseRecord, out / "rmse.json").rows
    found = [r for r in rows if (r.quantity, r.stage, r.reference) == (quantity, stage, reference)]
    assert len(found) == 1, [(r.quantity, r.stage, r.reference) for r in rows]
    return found[0].rmse


def test_hidden_physics_is_recovered(bench_run: Path, repository: Path) -> None:
    found = read_record(ParametersRecord, bench_run / "parameters.json")
    truth = read_record(TruthRecord, repository / "sample_data/bench_foot/truth.json")
    scores = []
    for name, parameter in found.parameters.items():
        if parameter.sd and name in truth.parameters and not name.endswith(".bias"):
            scores.append((parameter.value - truth.parameters[name]) / parameter.sd)
    assert len(scores) >= 4 + 12 + 1
    assert np.sqrt(np.mean(np.square(scores))) < 1.8
    width = found.parameters["left_rr.hysteresis_width"]
    assert width.value == pytest.approx(0.18, rel=0.2)
    effects = {record.effect for record in found.effects}
    assert effects == {"hysteresis", "cell_position", "crosstalk"}


def test_errors_before_and_after_stand_beside_each_other(bench_run: Path) -> None:
    never = "hole, placement never used"
    before = rmse_of(bench_run, "cop left", "before", "hole")
    after = rmse_of(bench_run, "cop left", "after", never)
    polynomial = rmse_of(bench_run, "cop left", "full", never)
    assert before > 0.02
    assert after < 8e-4 < 1.1 * polynomial
    force = rmse_of(bench_run, "vgrf left", "after", "known load, placement never used")
    assert force < 0.09
    affine = [rmse_of(bench_run, "force left_rr", s, "known load") for s in ("before",)]
    assert affine[0] > 0.2
    html = (bench_run / "report.html").read_text(encoding="utf-8")
    assert "beats the polynomial" in html
    assert "the affine scale is off by" in html


def test_every_prediction_carries_its_sd_and_split(bench_run: Path) -> None:
    weights = pd.read_parquet(bench_run / "predictions.parquet")
    assert set(weights.channel) == {"left_fl", "left_fr", "left_rl", "left_rr"}
    score = (weights.predicted_n - weights.load_n) / weights.sd_n
    assert 0.75 < score.std() < 1.25
    inside = (weights.predicted_n - weights.load_n).abs() < weights.ci95_half_width_n
    assert 0.92 < inside.mean() <= 1.0
    assert set(weights[weights.channel == "left_rr"].model) == {"hysteresis"}
    placed = pd.read_parquet(bench_run / "placements.parquet")
    assert (placed.split == "held_out").sum() == 90
    error = placed.cop_x_m - placed.hole_x_m
    assert 0.7 < (error / placed.cop_x_sd_m).std() < 1.3
    assert placed.valid.all()


def test_the_parameters_written_remove_the_errors_in_any_chain(
    bench_run: Path, repository: Path
) -> None:
    """parameters.json and its effects, taken as a chain, give the CoP that the report promises."""
    from footcal_cli.core.chain import Chain, link
    from footcal_cli.core.effects import TABLE
    from footcal_cli.core.experiments.placements import balance
    from footcal_cli.core.log import Log

    record = read_record(ParametersRecord, bench_run / "parameters.json")
    data = pd.read_csv(repository / "sample_data/bench_foot/placements.csv")
    cells = ("left_fl", "left_fr", "left_rl", "left_rr")
    believed = np.array([[0.07, 0.04], [0.07, -0.04], [-0.05, 0.04], [-0.05, -0.04]])
    counts = data[[f"{cell.removeprefix('left_')}_counts" for cell in cells]].to_numpy(float)
    log = Log(
        "placements", cells, np.arange(len(data), dtype=float), counts,
        {
            "load_n": data.load_n.to_numpy(),
            "hole_m": data[["hole_x_m", "hole_y_m"]].to_numpy(),
            "cell_pos_m": np.tile(believed, (len(data), 1, 1)),
        },
        np.zeros(len(data), dtype=np.int64),
    )  # fmt: skip
    chain = Chain((link(TABLE["scale_bias"], cells),))
    for effect in record.effects:
        if effect.effect != "hysteresis":  # under single weights only: see truth.json
            chain = chain.with_link(link(TABLE[effect.effect], cells))
    values = {name: parameter.value for name, parameter in record.parameters.items()}
    error = balance(chain.remove(log, values)[0]).error
    force = data.load_n.to_numpy()
    assert np.sqrt(np.mean((error[:, 1:] / force[:, None]) ** 2) * 2) < 8e-4
    assert np.sqrt(np.mean(error[:, 0] ** 2)) < 0.09


def test_the_papers_polynomial_is_written_as_coefficients(bench_run: Path) -> None:
    record = read_record(CopCorrectionsRecord, bench_run / "cop_correction.json").feet["left"]
    assert not record.chosen
    placed = pd.read_parquet(bench_run / "placements.parquet")
    assert record.model == "full"
    assert record.terms[:6] == ("1", "x", "y", "x²", "xy", "y²")
    assert len(record.coefficients_x) == 10
    assert placed.raw_cop_x_m.notna().all()


def test_a_second_calibration_says_what_changed(
    run: Run, bench_run: Path, repository: Path, tmp_path: Path
) -> None:
    log = tmp_path / "weights.csv"
    data = pd.read_csv(repository / "sample_data/bench_foot/weights.csv")
    moved = data.channel == "left_fl"
    data["counts"] = data.counts.where(~moved, (data.counts - 8.45e6) / 1.002 + 8.45e6)
    data.to_csv(log, index=False)
    answer = run(
        "offline-fit", log, "--parameters", bench_run / "parameters.json", "--out", tmp_path / "o",
        "--models", "affine",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    changed = next(line for line in answer.out.splitlines() if "Changed:" in line)
    assert "left_fl scale" in changed
    assert "left_fr scale" not in changed


def test_every_error_of_the_cop_says_which_one_it_is(bench_run: Path) -> None:
    verdict = read_record(RunRecord, bench_run / "run.json").verdict
    foot = next(line for line in verdict.details if line.startswith("left:"))
    assert " mm without a correction, " in verdict.sentence
    assert " mm before the cells were calibrated" in foot
    assert "→" not in foot
    page = (bench_run / "report.html").read_text("utf-8")
    table = page.partition("CoP corrections of left</span></caption>")[2]
    heads = re.search(r"<thead>(.*?)</thead>", table, re.DOTALL)
    assert heads is not None
    assert heads.group(1).index("left out") < heads.group(1).index("rank")


def test_placements_alone_need_a_calibration(
    run: Run, bench_run: Path, repository: Path, tmp_path: Path
) -> None:
    log = repository / "sample_data/bench_foot/placements.csv"
    recipe = repository / "recipes/bench_foot.toml"
    refused = run("offline-fit", log, "--recipe", recipe, "--out", tmp_path / "a")
    assert refused.exit_code == 2
    assert "--parameters" in refused.err
    given = ("--parameters", bench_run / "parameters.json")
    answer = run("offline-fit", log, "--recipe", recipe, *given, "--out", tmp_path / "b")
    assert answer.exit_code == 0, answer.err
    record = read_record(ParametersRecord, tmp_path / "b/parameters.json")
    assert "left_fl.scale" in record.parameters
    gate = ("--max-cop-rmse-mm", "0.1", "--overwrite")
    missed = run("offline-fit", log, "--recipe", recipe, *given, "--out", tmp_path / "b", *gate)
    assert missed.exit_code == 1
    assert "cop left" in missed.err


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ('held_out_placements = ["H99"]', ("H99", "held_out_placements")),
        ("[offline_fit.plateaus]\nmin_hold = 3", ("min_hold", "'min_hold_s'")),
        ("most_degree = 9", ("most_degree", "9")),
    ],
)
def test_settings_that_make_no_sense_are_refused(
    run: Run, repository: Path, tmp_path: Path, change: str, words: tuple[str, ...]
) -> None:
    text = (repository / "recipes/bench_foot.toml").read_text()
    text = text.replace("../sample_data", str(repository / "sample_data"))
    old = 'held_out_placements = ["H05", "H11", "H16"] # kept apart from every fit'
    recipe = tmp_path / "r.toml"
    recipe.write_text(text.replace(old, "") + change + "\n")
    answer = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    for word in words:
        assert word in answer.err
    assert not (tmp_path / "out").exists()


def recording(folder: Path, seed: int = 0) -> Path:
    """A running recording of one cell, 10 Hz, with glitches and lost samples, no load column."""
    rng = np.random.default_rng(seed)
    holds = [0.0, 20.0, 40.0, 60.0, 40.0, 20.0, 0.0]
    load = np.repeat(holds, 400)
    ramp = np.repeat(holds, 400).astype(float)
    for k in range(1, len(holds)):
        at = slice(400 * k, 400 * k + 25)
        ramp[at] = np.linspace(holds[k - 1], holds[k], 25) + 2.0 * rng.normal(size=25)
    counts = (ramp + 0.02 * rng.normal(size=load.size) - 280.0) / -3.4e-5
    counts[rng.choice(load.size, 12, replace=False)] += 5e5
    frame = pd.DataFrame({"time_s": np.arange(load.size) / 10.0, "cell_counts": np.rint(counts)})
    frame.loc[[333, 1444], "cell_counts"] = np.nan
    path = folder / "stream.csv"
    frame.to_csv(path, index=False)
    return path


@pytest.mark.usefixtures("drawn")
def test_a_recording_is_cut_into_holds_with_reasons(run: Run, tmp_path: Path) -> None:
    recipe = tmp_path / "r.toml"
    recipe.write_text(
        '[robot]\nchannels = ["cell"]\n[offline_fit.plateaus]\n'
        "loads_n = [0, 20, 40, 60, 40, 20, 0]\n"
    )
    out = tmp_path / "out"
    answer = run("offline-fit", recording(tmp_path), "--recipe", recipe, "--out", out)
    assert answer.exit_code == 0, answer.err
    record = read_record(ParametersRecord, out / "parameters.json")
    assert record.parameters["cell.scale"].value == pytest.approx(-3.4e-5, rel=2e-4)
    rejected = read_record(RmseRecord, out / "rmse.json").rejected
    assert rejected["dropout: no reading, or a converter's rail or zero code"] == 2
    assert rejected["glitch: far from its neighbours"] >= 11
    assert rejected["still moving"] > 6 * 20
    predictions = pd.read_parquet(out / "predictions.parquet")
    assert len(predictions) == 2800
    settled = predictions[predictions.state == "settled"]
    assert (settled.predicted_n - settled.load_n).abs().max() < 0.3
    assert (out / "figures/recordings.png").exists()
    # diagnose cuts the same recording by the same settings; one session shows too little
    again = tmp_path / "diagnosis"
    log = tmp_path / "stream.csv"
    answer = run(
        "diagnose", log, "--experiment", "weights", "--recipe", recipe, "--out", again,
        "--no-pictures",
    )  # fmt: skip
    assert answer.exit_code in (0, 3), answer.err
    assert "footcal: internal error" not in answer.err


def test_a_long_recording_that_remembers_is_predicted_at_every_so_many_th_sample(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(3)
    load = np.repeat(np.tile([0.0, 20, 40, 60, 40, 20], 3), 1200)
    crept = lfilter([1 / 401], [1, -400 / 401], load)  # 40 s at 10 Hz
    force = load + 0.02 * crept + 0.02 * rng.normal(size=load.size)
    log = tmp_path / "stream.parquet"
    stamps = np.arange(load.size) / 10.0
    counts = np.rint((force - 280.0) / -3.4e-5)
    pd.DataFrame({"time_s": stamps, "load_n": load, "cell_counts": counts}).to_parquet(log)
    recipe = tmp_path / "r.toml"
    recipe.write_text('[robot]\nchannels = ["cell"]\n')
    found = []
    for most in (bench._MOST_AT_ONCE, 1000):
        monkeypatch.setattr(bench, "_MOST_AT_ONCE", most)
        out = tmp_path / str(most)
        assert run("offline-fit", log, "--recipe", recipe, "--out", out).exit_code == 0
        found.append(pd.read_parquet(out / "predictions.parquet"))
    whole, thin = found
    assert "creep" in whole.model.iloc[0]
    assert len(whole) == load.size
    assert len(thin) == 982  # every 22nd
    there = whole.iloc[::22].reset_index(drop=True)
    pd.testing.assert_frame_equal(
        thin[["time_s", "counts", "state"]], there[["time_s", "counts", "state"]]
    )
    # from its own sample on a model forgets a step by 2.2 s of 40: 5 % of a creep of 1.2 N
    assert (thin.predicted_n - there.predicted_n).abs().max() < 0.06
    assert (thin.predicted_n - there.predicted_n).std() < 0.005


def test_loads_that_do_not_match_the_holds_are_refused(run: Run, tmp_path: Path) -> None:
    recipe = tmp_path / "r.toml"
    recipe.write_text(
        '[robot]\nchannels = ["cell"]\n[offline_fit.plateaus]\nloads_n = [0, 20, 40]\n'
    )
    answer = run("offline-fit", recording(tmp_path), "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 3
    assert "7 loads stand still" in answer.err
    assert "3 are given" in answer.err


def test_a_staircase_without_a_clock_is_ordered_by_its_direction(run: Run, tmp_path: Path) -> None:
    rows = Staircase(hysteresis_width=0.4, sessions=3).record(np.random.default_rng(0))
    load = rows["load_n"]
    down = np.concatenate([[False], np.diff(load) < 0])
    frame = pd.DataFrame(
        {
            "channel": "cell",
            "session": rows["session"].astype(int),
            "load_n": load,
            "counts": rows["counts"],
            "direction": np.where(down, -1, 1),
        }
    )
    log = tmp_path / "w.csv"
    frame.sample(frac=1.0, random_state=1).to_csv(log, index=False)
    answer = run("offline-fit", log, "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    record = read_record(ParametersRecord, tmp_path / "out/parameters.json")
    assert record.parameters["cell.hysteresis_width"].value == pytest.approx(0.4, rel=0.15)
    assert record.parameters["cell.hysteresis_reach"].unit == "N"


def test_what_the_run_was_asked_stands_in_the_run_record(bench_run: Path) -> None:
    options = json.loads((bench_run / "run.json").read_text())["options"]
    assert options["held_out_placements"] == ["H05", "H11", "H16"]
    assert options["plateaus"]["min_hold_s"] == 3.0


@pytest.mark.usefixtures("drawn")
@pytest.mark.parametrize(("crosstalk", "words"), [(0.02, "cells are coupled"), (0.0, "No crosst")])
def test_cells_loaded_together_give_a_matrix_only_where_it_pays(
    run: Run, tmp_path: Path, crosstalk: float, words: str
) -> None:
    log, out = loaded_together(tmp_path, crosstalk), tmp_path / "out"
    answer = run("offline-fit", log, "--recipe", tmp_path / "together.toml", "--out", out)
    assert answer.exit_code == 0, answer.err
    assert words in answer.out
    found = read_record(ParametersRecord, out / "parameters.json").parameters[
        "foot_a.scale_from_foot_b"
    ]
    if crosstalk:
        truth = -3.4e-5 * -crosstalk / (1 - crosstalk**2)
        assert found.sd is not None
        assert abs(found.value - truth) < 4 * found.sd
        assert found.sd < 0.05 * truth
    else:
        assert (found.value, found.sd) == (0.0, None)


def test_a_six_axis_sensor_against_known_wrenches(run: Run, tmp_path: Path) -> None:
    log, truth = under_wrenches(tmp_path)
    recipe = log.with_suffix(".toml")
    answer = run("offline-fit", log, "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    record = read_record(ParametersRecord, tmp_path / "out/parameters.json")
    matrix = [
        [record.parameters[f"{axis}.scale_from_{bridge}"].value for bridge in BRIDGES]
        for axis in ("fx", "fy", "fz", "tx", "ty", "tz")
    ]
    np.testing.assert_allclose(matrix, truth, atol=2e-4)
    assert record.parameters["tz.scale_from_g3"].unit == "Nm/count"
    assert len(record.covariance[0].names) == 42
