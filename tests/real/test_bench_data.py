"""Measured bench data of others: creep of a load cell, an insole under pressure, a force plate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.bench.ladder import climb
from footcal_cli.core.bench.plateaus import PlateauOptions
from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.study import Asked, ChannelStudy, settled_like, study_samples
from footcal_cli.core.bench.terms import hysteresis, polynomial
from footcal_cli.records.files import read_record
from footcal_cli.records.results import RmseRecord
from tests.conftest import Run

WEIGHTS_N = (49.033, 20.960, 5.186)


@pytest.fixture(scope="module")
def creep(real_data: Path) -> ChannelStudy:
    data = pd.read_csv(real_data / "loadcell-creep/test2.csv")
    time, reading = data.t_s.to_numpy(), data.loadcell_mN.to_numpy() / 1e3
    rows = BenchRecord(
        "joint", np.full(time.size, np.nan), reading, time, np.zeros(time.size, dtype=np.int64)
    )
    return study_samples(rows, options=PlateauOptions(min_hold_s=8.0), loads_n=WEIGHTS_N)


def test_three_weights_stand_still_and_hands_do_not(creep: ChannelStudy) -> None:
    samples = creep.samples
    assert samples is not None
    time, settled = samples.record.time_s, samples.hold >= 0
    assert np.unique(samples.hold[settled]).tolist() == [0, 1, 2]
    changing = ((time > 117) & (time < 178)) | ((time > 322) & (time < 355))
    assert not settled[changing].any()
    quiet = ((time > 40) & (time < 85)) | ((time > 190) & (time < 250)) | (time > 400)
    assert settled[quiet].mean() > 0.97
    rejected = samples.rejected()
    assert rejected["glitch: far from its neighbours"] < 100
    assert rejected["still moving"] > 1000


def test_creep_has_two_time_constants_of_minutes(creep: ChannelStudy) -> None:
    found = creep.relaxation
    assert found is not None
    assert found.tau_s.size == 2
    (low_1, high_1), (low_2, high_2) = found.tau_ci95_s
    assert 30 < low_1 < found.tau_s[0] < high_1 < 250
    assert 120 < low_2 < found.tau_s[1] < high_2 < 2500
    assert np.max(np.abs(found.amplitude)) > 2.0 * found.rmse
    # loaded: the reading rises; unloaded from there: it falls
    assert found.amplitude[0].sum() < 0 < found.amplitude[2].sum()


def test_creep_moves_the_scale_by_a_percent_in_two_minutes(creep: ChannelStudy) -> None:
    waiting = creep.waiting
    assert waiting is not None
    assert waiting.loads == 3
    finite = np.isfinite(waiting.wait_s)
    assert np.all(np.diff(waiting.scale[finite]) < 0)
    assert -0.02 < waiting.change[finite][-1] < -0.005
    assert waiting.change[~finite][0] < waiting.change[finite][-1]


def test_three_loads_are_not_enough_to_choose_a_model(creep: ChannelStudy) -> None:
    assert creep.ladder is not None
    assert creep.ladder.groups == 3
    assert creep.model == "affine"


def taxel(real_data: Path, run: str, name: str) -> BenchRecord:
    data = pd.read_parquet(real_data / f"insole-plenum/{run}.parquet", columns=["t", "P0", name])
    time = (data.t - data.t.iloc[0]).to_numpy()
    return BenchRecord(
        name, data.P0.to_numpy(), data[name].to_numpy(float), time, np.zeros(time.size, np.int64)
    )


@pytest.mark.parametrize(
    ("name", "run", "rung"),
    [
        ("taxel136", "validation_dataset_1", "polynomial 3"),
        ("taxel85", "experiment_Inf_15September_steps_1", "hysteresis"),
    ],
)
def test_insole_ladder_pays_on_a_run_it_has_not_seen(
    real_data: Path, name: str, run: str, rung: str
) -> None:
    study = study_samples(
        taxel(real_data, "calibration_dataset", name),
        options=PlateauOptions(min_hold_s=2.0),
        asked=Asked(extend=False),
    )
    rungs = (polynomial(2), polynomial(3), hysteresis(study.record.full_scale_n))
    ladder = climb(study.record, rungs)
    assert rung in ladder.rungs
    scored = settled_like(study, taxel(real_data, run, name))
    errors = [
        np.sqrt(np.nanmean((fit.predict(scored).load_n - scored.load_n) ** 2))
        for fit in (ladder.affine, ladder.chosen)
    ]
    assert errors[1] < 0.8 * errors[0]


def test_insole_hysteresis_is_a_few_percent_of_full_scale(real_data: Path) -> None:
    for name in ("taxel10", "taxel85", "taxel226"):
        study = study_samples(
            taxel(real_data, "calibration_dataset", name),
            options=PlateauOptions(min_hold_s=2.0),
            asked=Asked(extend=False),
        )
        ladder = climb(study.record, (hysteresis(study.record.full_scale_n),))
        assert ladder.rungs == ("hysteresis",)
        width = ladder.chosen.estimates[f"{name}.hysteresis_width"]
        assert 0.01 < width / study.record.full_scale_n < 0.12
        assert ladder.held_out.rmse < 0.85 * ladder.rows[0].held_out_rmse_n


def test_force_plate_points_and_what_no_correction_can_do(
    run: Run, real_data: Path, repository: Path, tmp_path: Path
) -> None:
    log = real_data / "forceplate-cop-points/points_frames.csv"
    recipe = repository / "recipes/forceplate_cop_points.toml"
    answer = run("offline-fit", log, "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    rows = read_record(RmseRecord, tmp_path / "out/rmse.json").rows
    left_out = {
        row.stage: row.rmse for row in rows if "left out" in row.reference and row.unit == "m"
    }
    # twenty points, errors of 5–10 mm that follow no smooth function of the place
    assert 0.005 < left_out["after"] < 0.010
    assert left_out["quadratic"] > 0.8 * left_out["after"]
    assert "No correction of the CoP helps" in answer.out


def test_creep_recipe_end_to_end(
    run: Run, real_data: Path, repository: Path, tmp_path: Path
) -> None:
    log = real_data / "loadcell-creep/test2.csv"
    recipe = repository / "recipes/loadcell_creep.toml"
    answer = run("offline-fit", log, "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    assert "creeps within its holds" in answer.out
    assert (tmp_path / "out/figures/recordings.png").exists()


@pytest.mark.slow
def test_insole_recipe_with_the_validation_run_kept_apart(
    run: Run, real_data: Path, repository: Path, tmp_path: Path
) -> None:
    folder = real_data / "insole-plenum"
    text = (repository / "recipes/insole_plenum.toml").read_text()
    recipe = tmp_path / "insole.toml"
    recipe.write_text(
        f'{text}\n[data]\nweights_stream = "{folder}/calibration_dataset.parquet"\n'
        f'weights_stream_held_out = "{folder}/validation_dataset_1.parquet"\n'
    )
    answer = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    rows = read_record(RmseRecord, tmp_path / "out/rmse.json").rows
    apart = {
        (r.quantity, r.stage): r.rmse for r in rows if r.reference == "known load, log never used"
    }
    for name in ("taxel114", "taxel136"):
        assert apart[f"force {name}", "after"] < apart[f"force {name}", "affine"]
    assert apart["force taxel136", "after"] < 0.6 * apart["force taxel136", "affine"]
