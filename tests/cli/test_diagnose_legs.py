"""``footcal diagnose`` on hanging legs and standing poses, as the shell runs it."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.intake.cases.pose import _model
from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from footcal_cli.records.results import EffectRecord, ParametersRecord
from tests.cli.few_effects import few_or_all
from tests.conftest import Run

DOWN = {
    "+x": (1.0, 0.0, 0.0),
    "-x": (-1.0, 0.0, 0.0),
    "+z": (0.0, 0.0, 1.0),
    "-z": (0.0, 0.0, -1.0),
}
AXES = ("fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm")
TURNS, ROWS, STEP_S = 4, 24, 0.5
RECIPE = """
[robot]
name = "two legs"
mass_kg = 8.0

[diagnose]
tolerance_n = 0.02
tolerance_mm = 0.2
"""


def write_hang(
    path: Path, seed: int, drag_n: float = 0.0, turned: bool = False, loose: bool = False
) -> None:
    """Two legs hung in four orientations, each askew, each with offsets of its own.

    A cable pulls at the first leg, or its x wires are swapped, or its z wire loses contact for
    four samples now and then.
    """
    rng = np.random.default_rng(seed)
    frames = []
    for leg in ("fl", "fr"):
        offset = rng.normal(size=6) * [3, 3, 3, 0.2, 0.2, 0.2]
        clock = 0.0
        for name, nominal in DOWN.items():
            phase = np.arange(TURNS * ROWS) * 2 * np.pi / ROWS + rng.uniform(0, 6)
            down = np.array(nominal) + np.cross(rng.normal(0, 0.02, 3), nominal)
            force = 6.2 * down / np.linalg.norm(down)
            arm = np.stack([0.03 * np.cos(phase), 0 * phase + 0.06, 0.03 * np.sin(phase)], -1)
            speed = 2 * np.pi / (ROWS * STEP_S)  # the leg's CoM goes round: r̈ = −ω² (r − r̄)
            pulled = force + 6.2 / 9.80665 * speed**2 * arm * [1, 0, 1]
            wrench = np.hstack([pulled, np.cross(arm, pulled)])
            wrench += rng.normal(0, 0.004, 6) * [1, 1, 1, 0.06, 0.06, 0.06]
            wrench += rng.normal(0, 0.03, wrench.shape) * [1, 1, 1, 0.06, 0.06, 0.06]
            if leg == "fl":
                wrench[:, 0] += drag_n * np.cos(phase - 0.3)
                wrench[:, 0] *= 1 - 2 * turned
                away = np.isin(np.arange(phase.size) % 40, (17, 18, 19, 20))
                wrench[away & loose, 2] = 1.5
            time_s = clock + np.arange(phase.size) * STEP_S
            clock = time_s[-1] + 60.0
            frames.append(
                pd.DataFrame(
                    {"orientation": name, "time_s": time_s, "leg": leg, "phase_rad": phase}
                    | dict(zip(AXES, (wrench + offset).T, strict=True))
                )
            )
    pd.concat(frames).to_csv(path, index=False)


def diagnosed(
    run: Run,
    log: Path,
    recipe: Path,
    parameters: Path | None,
    out: Path,
    kind: str,
    *more: str,
) -> DiagnosisRecord:
    given = () if parameters is None else ("--parameters", parameters)
    asked = ("--experiment", kind, "--recipe", recipe, *given, *more, "--out", out)
    answer = run("diagnose", log, *asked)
    record = read_record(DiagnosisRecord, out / "diagnosis.json")
    assert answer.exit_code == (3 if record.verdict == "bad-data" else 0), answer.err
    return record


@pytest.fixture
def recipe(tmp_path: Path) -> Path:
    path = tmp_path / "recipe.toml"
    path.write_text(RECIPE, encoding="utf-8")
    return path


@few_or_all("cable_drag", "offset_drift", "cross_coupling", "scale_matrix")
def test_a_dragging_cable_is_named_and_the_extended_model_leaves_nothing(
    run: Run, tmp_path: Path, recipe: Path, few: tuple[str, ...]
) -> None:
    log, first, again = tmp_path / "hang.csv", tmp_path / "first", tmp_path / "again"
    write_hang(log, 11, drag_n=0.1)
    assert run("hang-calib", log, "--recipe", recipe, "--out", first).exit_code == 0
    out = tmp_path / "out"
    record = diagnosed(run, log, recipe, first / "parameters.json", out, "hang", *few)
    assert record.verdict == "named", record.sentence
    (cause,) = record.causes
    assert (cause.effect, cause.where) == ("cable_drag", "fl")
    extended = read_record(ParametersRecord, out / "parameters_extended.json")
    pull = np.array([extended.value(f"fl.cable_fx_{part}") for part in ("sin", "cos")])
    sd = np.array([extended.parameters[f"fl.cable_fx_{part}"].sd for part in ("sin", "cos")])
    truth = 0.1 * np.array([np.sin(0.3), np.cos(0.3)])
    assert np.all(np.abs(pull - truth) < 4 * sd)
    assert [e.effect for e in extended.effects] == ["cable_drag"]

    answer = run("hang-calib", log, "--recipe", recipe, "--out", again,
                 "--parameters", out / "parameters_extended.json")  # fmt: skip
    assert answer.exit_code == 0, answer.err
    if few:
        return
    second = diagnosed(run, log, recipe, again / "parameters.json", tmp_path / "out2", "hang")
    assert second.verdict == "none", second.sentence


def test_a_loose_contact_is_left_out_of_the_fit_and_ends_the_diagnosis(
    run: Run, tmp_path: Path, recipe: Path
) -> None:
    found = {}
    for loose in (False, True):
        log, out = tmp_path / f"{loose}.csv", tmp_path / str(loose)
        write_hang(log, 13, loose=loose)
        assert run("hang-calib", log, "--recipe", recipe, "--out", out).exit_code == 0
        found[loose] = read_record(ParametersRecord, out / "parameters.json")
    for name in ("fl.weight", "fl.offset_fz", "fl.offset_tx"):
        sd = found[False].parameters[name].sd
        assert sd is not None
        assert abs(found[True].value(name) - found[False].value(name)) < sd
    record = diagnosed(run, log, recipe, out / "parameters.json", tmp_path / "answer", "hang")
    assert record.verdict == "bad-data"
    assert not record.causes
    (finding,) = [f for f in record.findings if f.code == "intermittent_contact"]
    assert finding.where == "fl"
    assert finding.sentence.startswith("fz: 8 times")


@pytest.mark.slow
def test_swapped_wires_stop_the_diagnosis(run: Run, tmp_path: Path, recipe: Path) -> None:
    log = tmp_path / "hang.csv"
    write_hang(log, 12, turned=True)
    answer = run("hang-calib", log, "--recipe", recipe, "--out", tmp_path / "first")
    assert answer.exit_code == 3
    assert "fx of leg fl reads with the sign reversed" in answer.out + answer.err
    record = diagnosed(run, log, recipe, None, tmp_path / "out", "hang")
    assert record.verdict == "bad-data"
    assert "fx of leg fl" in record.sentence
    # no other cause is made of wrong readings, and no model starts from them
    assert not record.causes
    assert {row.status for row in record.effects} <= {"undecided", "not_testable"}
    assert not (tmp_path / "out/parameters_extended.json").exists()


@pytest.mark.parametrize(("place_m", "started_m"), [(0.1, 0.1), (-0.215, 0.0)])
def test_a_hip_beyond_all_mounting_errors_is_an_alarm_and_no_value_to_start_from(
    place_m: float, started_m: float
) -> None:
    values = {"fl.mount_pos_x": place_m}
    known = SimpleNamespace(effects=(), command="pose-calib", values=values)
    channels = tuple(f"fl.{axis}" for axis in ("fx", "fy", "fz", "tx", "ty", "tz"))
    session = SimpleNamespace(parameters=known)
    _, started, free, beyond = _model(cast(Any, session), channels)
    placed = next(p for p in free if p.name == "fl.mount_pos_x")
    assert placed.value == started.get(placed.name, placed.value) == started_m
    found = [(f.severity, f.where, "plug" in f.remedy) for f in beyond]
    assert found == ([] if place_m == started_m else [("alarm", placed.name, True)])


@pytest.mark.slow
def test_an_offset_that_jumps_in_one_hanging_is_no_drift(run: Run, tmp_path: Path) -> None:
    """Of 24 orientations of a wrist sensor all from the fifteenth on are 3 N off along y."""
    rng = np.random.default_rng(33)
    com, rows = np.array([0.02, -0.01, 0.11]), []
    offset = np.array([4.0, -7.0, 12.0, 0.3, -0.2, 0.1])
    for pose in range(24):
        axis, angle = rng.normal(size=3), rng.uniform(-1.2, 1.2)
        turn = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
        force = 2.3 * turn.inv().apply([0.0, 0.0, -9.80665])
        wrench = offset + np.concatenate([force, np.cross(com, force)])
        wrench[1] += 3.0 * (pose >= 14)
        x, y, z, w = turn.as_quat()
        for row in range(10):
            noise = rng.normal(size=6) * np.repeat([0.08, 0.004], 3)
            rows.append([4.0 * pose + 0.04 * row, *(wrench + noise), w, x, y, z])
    names = "time_s,Fx,Fy,Fz,Tx,Ty,Tz,qw,qx,qy,qz"
    lines = [",".join(f"{value:.6g}" for value in row) for row in rows]
    log, recipe = tmp_path / "wrist.csv", tmp_path / "r.toml"
    log.write_text("\n".join([names, *lines]) + "\n")
    assert run("init", log, "-o", recipe).exit_code == 0
    out = tmp_path / "out"
    asked = ("--experiment", "hang", "--recipe", recipe, "--out", out, "--no-pictures")
    assert run("diagnose", *asked).exit_code == 0
    record = read_record(DiagnosisRecord, out / "diagnosis.json")
    assert record.verdict not in ("none", "underpowered")
    assert {cause.effect for cause in record.causes} <= {"offset_change"}


def test_a_diagnosis_of_poses_calibrates_what_pose_calib_fits_and_no_effect_beside() -> None:
    channels = tuple(
        f"{leg}.{axis}" for leg in ("fl", "fr") for axis in ("fx", "fy", "fz", "tx", "ty", "tz")
    )
    drift = EffectRecord(effect="offset_drift", owners={leg: (leg,) for leg in ("fl", "fr")})
    known = SimpleNamespace(effects=(drift,), command="pose-calib", values={})
    session = SimpleNamespace(parameters=known)
    chain, _, free, _ = _model(cast(Any, session), channels)
    assert any(item.effect.name == "offset_drift" for item in chain.links)
    stems = {parameter.name.split(".")[1].rpartition("_")[0] for parameter in free}
    assert stems == {"offset", "mount_rot", "mount_pos"}
