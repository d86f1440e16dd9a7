"""``hang-calib``, ``pose-calib`` and ``apply`` on the engine's hexapod, as the shell runs them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.app import main
from footcal_cli.core.parameters import Status
from footcal_cli.records.files import read_record, write_record
from footcal_cli.records.results import EffectRecord, ParameterRecord, RmseRecord, RunRecord
from footcal_cli.tables.table import write_parquet
from tests.cli.six_axis import AXES, LEGS, calibration, stored_mounting, true_mounting, truth_of
from tests.conftest import REPOSITORY, Run, drawing

RECIPE = REPOSITORY / "recipes/hexapod.toml"
GAIN = 0.08


def run_once(*arguments: str | Path) -> None:
    with pytest.raises(SystemExit) as end:
        main([str(a) for a in arguments] + ["--quiet"])
    assert end.value.code == 0


@pytest.fixture(scope="module")
def hung(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("hung") / "out"
    with drawing():
        run_once("hang-calib", "--recipe", RECIPE, "--out", folder)
    return folder


@pytest.fixture(scope="module")
def stood(hung: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("stood") / "out"
    given = ("--recipe", RECIPE, "--parameters", hung / "parameters.json")
    with drawing():
        run_once("pose-calib", *given, "--out", folder)
    return folder


@pytest.fixture(scope="module")
def gained(hung: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Poses with a gain error of one leg, and in ``out`` what pose-calib makes of them."""
    folder = tmp_path_factory.mktemp("gained")
    table = pd.read_parquet(REPOSITORY / "sample_data/hexapod/poses.parquet")
    bad = table["leg"] == "mr"
    offset = truth_of(REPOSITORY)["legs"]["mr"]["offset"][2]
    table.loc[bad, "fz_n"] = offset + (1.0 + GAIN) * (table.loc[bad, "fz_n"] - offset)
    log = folder / "gain.parquet"
    write_parquet(table, log)
    given = ("--recipe", RECIPE, "--parameters", hung / "parameters.json")
    with pytest.raises(SystemExit):
        main([str(word) for word in ("pose-calib", log, *given, "--out", folder / "out")])
    return folder


def rmse(folder: Path, quantity: str, stage: str, split: str = "all") -> float:
    rows = read_record(RmseRecord, folder / "rmse.json").rows
    return next(r.rmse for r in rows if (r.quantity, r.stage, r.split) == (quantity, stage, split))


def test_hang_calib_finds_the_engines_truth_within_its_intervals(hung: Path) -> None:
    record, truth = calibration(hung), truth_of(REPOSITORY)
    standard = []
    for leg in LEGS:
        true = truth["legs"][leg]
        for name, value in [
            (f"{leg}.weight", true["weight_n"]),
            *((f"{leg}.offset_{a}", v) for a, v in zip(AXES, true["offset"], strict=True)),
        ]:
            found = record.parameters[name]
            assert found.sd is not None
            standard.append((found.value - value) / found.sd)
        for axis, term in true["com_t"].items():
            sine = term["amplitude_m"] * np.cos(term["lead_rad"])
            cosine = term["amplitude_m"] * np.sin(term["lead_rad"])
            found_com = [record.value(f"{leg}.com_{axis}_{t}") for t in ("mean", "sin", "cos")]
            np.testing.assert_allclose(found_com, [term["centre_m"], sine, cosine], atol=3e-4)
    assert np.mean(np.abs(standard) < 1.96) > 0.85
    assert np.abs(standard).max() < 4.5


def test_hang_calib_beats_the_naive_method_and_writes_everything(hung: Path) -> None:
    for leg in LEGS:
        assert rmse(hung, f"{leg} force", "after") < 0.5 * rmse(hung, f"{leg} force", "before")
    figures = {path.stem for path in (hung / "figures").iterdir()}
    assert figures == {"residuals", "leg_com", "orientations"}
    html = (hung / "report.html").read_text(encoding="utf-8")
    assert "Methods side by side" in html
    run = read_record(RunRecord, hung / "run.json")
    assert run.exit_code == 0
    assert run.verdict.level == "good"


def test_wrong_orientation_frame_is_noticed(run: Run, tmp_path: Path) -> None:
    """The right legs are turned by pi: taken as transducer axes, +x is −x for them."""
    table = pd.read_parquet(REPOSITORY / "sample_data/hexapod/hang.parquet")
    log = tmp_path / "one_of_each_side.parquet"
    turned = table[table["leg"].isin(["fl", "fr"])].iloc[::3]
    write_parquet(turned.reset_index(drop=True), log)
    text = RECIPE.read_text(encoding="utf-8").replace('"body"', '"transducer"')
    recipe = tmp_path / "wrong.toml"
    text = text.replace("[hang_calib]", "[hang_calib]\ncompare = false")
    recipe.write_text(text.replace("../sample_data", str(REPOSITORY / "sample_data")))
    answer = run("hang-calib", log, "--recipe", recipe, "--out", tmp_path / "out")
    assert "away from the named axis" in answer.out
    assert "leg fr" in answer.out


def test_one_pair_of_orientations_says_what_is_unknown(run: Run, tmp_path: Path) -> None:
    table = pd.read_parquet(REPOSITORY / "sample_data/hexapod/hang.parquet")
    pair = table[table["orientation"].isin(["+x", "-x"]) & (table["leg"] == "ml")]
    log = tmp_path / "pair.parquet"
    write_parquet(pair.reset_index(drop=True), log)
    answer = run("hang-calib", log, "--recipe", RECIPE, "--out", tmp_path / "out")
    assert "CoM along x makes no torque and is unknown" in answer.out
    assert answer.exit_code == 0
    missing = run(
        "hang-calib", log, "--recipe", RECIPE, "--out", tmp_path / "o2", "--method", "stepwise"
    )
    assert missing.exit_code == 3
    assert "two pairs" in missing.err


def test_stepwise_method_writes_values_without_intervals(run: Run, tmp_path: Path) -> None:
    table = pd.read_parquet(REPOSITORY / "sample_data/hexapod/hang.parquet")
    log = tmp_path / "one.parquet"
    write_parquet(table[table["leg"] == "hl"].reset_index(drop=True), log)
    answer = run(
        "hang-calib", log, "--recipe", RECIPE, "--out", tmp_path / "out", "--method", "stepwise"
    )
    assert answer.exit_code == 0, answer.err
    found = calibration(tmp_path / "out").parameters["hl.weight"]
    assert found.sd is None
    assert found.value == pytest.approx(6.2, abs=0.05)


def test_unknown_orientation_and_option_are_refused(run: Run, tmp_path: Path) -> None:
    table = pd.read_parquet(REPOSITORY / "sample_data/hexapod/hang.parquet").head(600)
    table["orientation"] = "up"
    log = tmp_path / "odd.parquet"
    write_parquet(table, log)
    answer = run("hang-calib", log, "--recipe", RECIPE, "--out", tmp_path / "out")
    assert answer.exit_code == 3
    assert "'up' is none of" in answer.err
    wrong = run("hang-calib", "--recipe", RECIPE, "--method", "guess", "--out", tmp_path / "o2")
    assert wrong.exit_code == 2


@pytest.mark.parametrize("samples", [20, 1])
def test_a_wrist_sensor_with_known_directions_of_gravity(
    run: Run, tmp_path: Path, samples: int
) -> None:
    rng = np.random.default_rng(5)
    rows = []
    arm, weight, offset = (
        np.array([0.01, -0.02, 0.08]),
        4.0,
        np.array([3.0, -2.0, 5.0, 0.1, 0, 0.2]),
    )
    for pose in range(16 if samples > 1 else 60):
        down = rng.normal(size=3)
        down /= np.linalg.norm(down)
        wrench = np.concatenate([weight * down, np.cross(arm, weight * down)]) + offset
        for sample in range(samples):
            noise = rng.normal(size=6) * np.array([0.05] * 3 + [0.005] * 3)
            rows.append((f"pose {pose}", 0.01 * sample, "wrist", *down, *(wrench + noise)))
    columns = ["orientation", "time_s", "leg", "gravity_x", "gravity_y", "gravity_z",
               "fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm"]  # fmt: skip
    log = tmp_path / "wrist.csv"
    pd.DataFrame(rows, columns=columns).to_csv(log, index=False)
    answer = run("hang-calib", log, "--tilt", "mount", "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    record = calibration(tmp_path / "out")
    assert record.value("wrist.weight") == pytest.approx(4.0, abs=0.02)
    assert record.value("wrist.com_z_mean") == pytest.approx(0.08, abs=5e-4)
    assert record.value("wrist.mount_rot_x") == pytest.approx(0.0, abs=0.01)
    assert ("from sample to sample" in answer.out) == (samples > 1)
    assert ("each attitude has one row" in answer.out) == (samples == 1)


def test_pose_calib_finds_the_engines_mounting(stood: Path) -> None:
    record, truth = calibration(stood), truth_of(REPOSITORY)
    com = np.array(truth["robot"]["chassis_com_b_m"])
    angles, hips = [], []
    for name in LEGS:
        leg = truth["legs"][name]
        rot, hip = stored_mounting(record, leg, name)
        true_rot, true_hip = true_mounting(leg)
        angles.append(np.degrees(np.arccos(np.clip((np.trace(true_rot.T @ rot) - 1) / 2, -1, 1))))
        hips.append(np.linalg.norm(hip - (true_hip - com)))
    assert np.sqrt(np.mean(np.square(angles))) < 0.25
    assert np.sqrt(np.mean(np.square(hips))) < 1.5e-3
    assert rmse(stood, "sum of forces", "after", "held_out") < 0.06
    assert rmse(stood, "sum of forces", "before") > 1.0
    assert record.parameters["fl.com_x_sin"].sd is not None, "hanging parameters are handed on"
    table = pd.read_parquet(stood / "wrenches.parquet")
    total = table.groupby("pose")["fz_w_n"].sum()
    assert abs(total.mean() - 8.18 * 9.80665) < 0.1
    figures = {path.stem for path in (stood / "figures").iterdir()}
    assert figures == {"balance", "mounting", "legs_and_poses", "coverage"}


def test_pose_calib_cuts_poses_from_a_stand_still_log(run: Run, hung: Path, tmp_path: Path) -> None:
    log = REPOSITORY / "sample_data/hexapod/still.parquet"
    answer = run(
        "pose-calib", log, "--recipe", RECIPE, "--parameters", hung / "parameters.json",
        "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    rejected = read_record(RmseRecord, tmp_path / "out/rmse.json").rejected
    assert rejected["stretch discarded: moving"] >= 11
    assert rmse(tmp_path / "out", "sum of forces", "after") < 0.1


@pytest.mark.usefixtures("drawn")
def test_offsets_again_from_tripods_and_not_from_all_feet(
    run: Run, stood: Path, tmp_path: Path
) -> None:
    parameters = stood / "parameters.json"
    answer = run(
        "pose-calib", "--recipe", RECIPE, "--parameters", parameters, "--fit", "offsets",
        "--out", tmp_path / "tripod",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    record, truth = calibration(tmp_path / "tripod"), truth_of(REPOSITORY)
    for leg in LEGS:
        for axis, value in zip(AXES, truth["legs"][leg]["offset"], strict=True):
            assert record.value(f"{leg}.offset_{axis}") == pytest.approx(value, abs=0.015)
    assert record.value("fl.mount_rot_z") == calibration(stood).value("fl.mount_rot_z")
    poses = pd.read_parquet(REPOSITORY / "sample_data/hexapod/poses.parquet")
    down = poses[poses.groupby("pose")["contact"].transform("min") == 1].reset_index(drop=True)
    log = tmp_path / "down.parquet"
    write_parquet(down, log)
    refused = run(
        "pose-calib", log, "--recipe", RECIPE, "--parameters", parameters, "--fit", "offsets",
        "--out", tmp_path / "feet",
    )  # fmt: skip
    assert refused.exit_code == 3
    assert "6 of 36" in refused.out
    assert "tripod" in refused.out
    assert not (tmp_path / "feet/parameters.json").exists()


def test_a_leg_with_a_wrong_gain_is_named(gained: Path) -> None:
    findings = read_record(RunRecord, gained / "out/run.json").findings
    said = [f"{finding.where}: {finding.sentence}" for finding in findings]
    assert any("leg mr" in one and "own readings predict" in one for one in said), said


def test_alternating_as_printed_is_worse_and_printed_needs_it(
    run: Run, hung: Path, tmp_path: Path
) -> None:
    shared = ("--recipe", RECIPE, "--parameters", hung / "parameters.json", "--balance", "printed")
    answer = run("pose-calib", *shared, "--method", "alternating", "--out", tmp_path / "out")
    assert answer.exit_code in (0, 1), answer.err
    out = tmp_path / "out"
    assert rmse(out, "sum of moments", "after") > 3 * rmse(out, "sum of moments", "joint")
    assert run("pose-calib", *shared, "--out", tmp_path / "o2").exit_code == 2


def test_pose_calib_needs_a_hanging_calibration(run: Run, tmp_path: Path) -> None:
    answer = run("pose-calib", "--recipe", RECIPE, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    assert "hang-calib" in answer.err


@pytest.mark.usefixtures("drawn")
def test_apply_gives_the_engines_ground_wrenches(run: Run, stood: Path, tmp_path: Path) -> None:
    answer = run(
        "apply", "--recipe", RECIPE, "--parameters", stood / "parameters.json",
        "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    found = pd.read_parquet(tmp_path / "out/calibrated.parquet")
    truth = pd.read_parquet(REPOSITORY / "sample_data/hexapod/walk.parquet")
    both = found.merge(truth, on=["time_s", "leg"], suffixes=("", "_raw"))
    assert len(both) == len(truth)
    force = [f"f{a}_w_n" for a in "xyz"]
    error = both[force].to_numpy() - both[[f"ground_{n}" for n in force]].to_numpy()
    tared = both[[f"tared_{n}" for n in force]].to_numpy()
    tared_error = tared - both[[f"ground_{n}" for n in force]].to_numpy()
    assert np.sqrt(np.median(error**2)) < 0.05
    assert np.sqrt(np.mean(error**2)) < 0.3 * np.sqrt(np.mean(tared_error**2))
    torque = [f"t{a}_w_nm" for a in "xyz"]
    moment = both[torque].to_numpy() - both[[f"ground_{n}" for n in torque]].to_numpy()
    assert np.sqrt(np.median(moment**2)) < 0.02
    lifted = rmse(tmp_path / "out", "force on lifted feet", "after")
    assert lifted < rmse(tmp_path / "out", "force on lifted feet", "before")


def test_effects_of_an_extended_calibration_are_undone(
    run: Run, hung: Path, gained: Path, tmp_path: Path
) -> None:
    """A gain error of one leg, known to the calibration, must not show in the mounting."""
    record = calibration(hung)
    extended = record.model_copy(
        update={
            "effects": (EffectRecord(effect="scale_matrix", owners={"mr": ("mr",)}),),
            "parameters": {
                **record.parameters,
                "mr.gain_fz": ParameterRecord(
                    value=GAIN, sd=0.001, unit="-", status=Status.ESTIMATED
                ),
            },
        }
    )
    path = tmp_path / "extended.json"
    write_record(extended, path)
    run("pose-calib", gained / "gain.parquet", "--recipe", RECIPE, "--parameters", path,
        "--out", tmp_path / "extended")  # fmt: skip
    plain = rmse(gained / "out", "sum of forces", "after", "held_out")
    assert rmse(tmp_path / "extended", "sum of forces", "after", "held_out") < 0.2 * plain
    assert calibration(tmp_path / "extended").effects == extended.effects


def test_apply_on_load_cells(run: Run, tmp_path: Path) -> None:
    recipe = REPOSITORY / "recipes/nao_table2.toml"
    fitted = tmp_path / "fitted"
    assert run("offline-fit", "--recipe", recipe, "--out", fitted).exit_code == 0
    record = calibration(fitted)
    cells = [f"{foot}_{cell}" for foot in ("left", "right") for cell in ("fl", "fr", "rl", "rr")]
    scale = np.array([record.value(f"{c}.scale") for c in cells])
    bias = np.array([record.value(f"{c}.bias") for c in cells])
    counts = np.round((np.array([[6.0] * 8, [3.0] * 8]) - bias) / scale)
    log = tmp_path / "stand.csv"
    frame = pd.DataFrame(counts, columns=[f"{c}_counts" for c in cells])
    frame.insert(0, "time_s", [0.0, 0.01])
    frame.to_csv(log, index=False)
    answer = run(
        "apply", log, "--recipe", recipe, "--parameters", fitted / "parameters.json",
        "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    found = pd.read_parquet(tmp_path / "out/calibrated.parquet")
    np.testing.assert_allclose(found["left_fl_n"], [6.0, 3.0], atol=1e-3)


def test_apply_without_a_calibration_is_a_usage_error(run: Run, tmp_path: Path) -> None:
    answer = run("apply", "--recipe", RECIPE, "--out", tmp_path / "out")
    assert answer.exit_code == 2
