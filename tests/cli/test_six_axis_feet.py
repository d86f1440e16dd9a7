"""Robots on ankle transducers through the commands: walks whose truth is known."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest

from footcal_cli.core.parameters import Status
from footcal_cli.records.files import read_record, write_record
from footcal_cli.records.results import EffectRecord, ParameterRecord, ParametersRecord, RmseRecord
from tests.conftest import Run
from tests.core.ankle_simulation import six_axis_feet_columns
from tests.core.ankle_walks import ANKLES, CHANNELS, ROBOT, ankle_walk

FOOT = """
transducer_position_m = [0.0, 0.0, 0.1]
weight_below_n = 19.7
com_below_m = [0.02, 0.0, -0.06]
"""
RECIPE = f"""
name = "humanoid"
[robot]
name = "humanoid"
mass_kg = 68.6
[robot.feet.left]{FOOT}
[robot.feet.right]{FOOT}
[online_replay]
delay_s = 0.0
update_hz = 25.0
[diagnose]
experiment = "walk"
delay_s = 0.0
"""


def write_walk(folder: Path, seed: int, seconds: float, **effects: dict[str, float]) -> Path:
    """A walk with offsets and effects as a logger would write it; the recipe beside it."""
    offsets = {name: 8.0 if name.split(".")[1][0] == "f" else 0.5 for name in CHANNELS}
    done, _ = ankle_walk(seed, seconds, offsets, effects)
    columns = six_axis_feet_columns(done, list(ROBOT.feet), ANKLES)
    pd.DataFrame(dict(columns)).to_parquet(folder / "walk.parquet")
    (folder / "recipe.toml").write_text(RECIPE, encoding="utf-8")
    return folder / "walk.parquet"


def extended(folder: Path, effect: str, owner: str, name: str, size: float) -> Path:
    """`parameters_extended.json` with one effect in it."""
    path = folder / "extended.json"
    record = ParametersRecord(
        command="diagnose", created="2026-01-01T00:00:00+00:00", robot="humanoid",
        gravity_mps2=9.80665, sign_convention="reading = applied wrench + offset",
        frame="transducer", expressed_at="the transducer",
        parameters={
            f"{owner}.{name}": ParameterRecord(
                value=size, sd=None, unit="-", status=Status.FIXED
            )
        },
        effects=(EffectRecord(effect=effect, owners={owner: (owner,)}),),
    )  # fmt: skip
    write_record(record, path)
    return path


def test_a_body_stream_in_the_log_of_the_feet_need_not_be_named_twice(
    run: Run, tmp_path: Path
) -> None:
    log, recipe = write_walk(tmp_path, 4, 8.0), tmp_path / "recipe.toml"
    with recipe.open("a") as file:
        file.write('[data]\ncells = ["walk.parquet"]\n')
    both = run("online-replay", "--recipe", recipe, "--out", tmp_path / "both", "--no-pictures")
    assert both.exit_code == 0, both.err
    # without a CoM the stream is not whole: the column is named
    columns = pd.read_parquet(log)
    columns.drop(columns=[c for c in columns if str(c).startswith("com_")]).to_parquet(log)
    cut = run("online-replay", "--recipe", recipe, "--out", tmp_path / "cut")
    assert cut.exit_code == 3
    assert "com_x_m" in cut.err


def test_a_log_without_the_acceleration_of_the_com_is_calibrated_from_its_place(
    run: Run, tmp_path: Path
) -> None:
    log, recipe = write_walk(tmp_path, 4, 12.0), tmp_path / "recipe.toml"
    columns = pd.read_parquet(log)
    columns.drop(columns=[c for c in columns if str(c).startswith("com_acc")]).to_parquet(log)
    done = run("online-replay", log, "--recipe", recipe, "--out", tmp_path / "out", "--no-pictures")
    assert done.exit_code == 0, done.err
    assert "second derivative" in done.out
    found = read_record(ParametersRecord, tmp_path / "out" / "parameters.json").parameters
    forces = {name: one for name, one in found.items() if "offset_f" in name}
    assert len(forces) == 6
    for name, one in forces.items():
        assert one.sd is not None
        assert one.sd < 2.5
        assert abs(one.value - 8.0) < 4.0 * one.sd, name
    # part of it says nothing
    columns.drop(columns=["com_acc_z_mps2"]).to_parquet(log)
    cut = run("online-replay", log, "--recipe", recipe, "--out", tmp_path / "cut")
    assert cut.exit_code == 3
    assert "com_acc_z_mps2" in cut.err


def test_transducers_mounted_upside_down_carry_as_others_do(run: Run, tmp_path: Path) -> None:
    """Which foot carries is seen in the world; of exchanged ones it still is an alarm."""
    log, recipe = write_walk(tmp_path, 4, 8.0), tmp_path / "recipe.toml"
    turned = "transducer_rotation_rpy_rad = [3.14159265, 0.0, 0.0]\n"
    said = recipe.read_text().replace("com_below_m = [0.02, 0.0, -0.06]", "")
    recipe.write_text(
        said.replace(FOOT.splitlines()[1], f"{turned}{FOOT.splitlines()[1]}").replace(
            "weight_below_n", "com_below_m = [0.02, 0.0, 0.06]\nweight_below_n"
        )
    )
    columns = pd.read_parquet(log)
    axes = [str(c) for c in columns if str(c).endswith(("_fy_n", "_fz_n", "_ty_nm", "_tz_nm"))]
    columns[axes] *= -1.0
    columns.to_parquet(log)
    done = run("online-replay", log, "--recipe", recipe, "--out", tmp_path / "out", "--no-pictures")
    assert done.exit_code == 0, done.err
    assert "exchanged" not in done.out
    other = {"left": "right", "right": "left"}
    names = {
        str(c): str(c).replace(side, other[side], 1)
        for c in columns for side in other
        if str(c).startswith(side) and str(c).split("_")[1][0] in "ft" and "foot" not in str(c)
    }  # fmt: skip
    columns.rename(columns=names).to_parquet(log)
    swapped = run("online-replay", log, "--recipe", recipe, "--out", tmp_path / "swapped")
    assert swapped.exit_code == 3
    assert "their readings look exchanged" in swapped.out


def test_effects_of_a_calibration_are_undone_before_a_walk_is_judged(
    run: Run, tmp_path: Path
) -> None:
    (tmp_path / "clean").mkdir()
    clean = write_walk(tmp_path / "clean", 3, 8.0)
    log = write_walk(tmp_path, 3, 8.0, scale_matrix={"left.gain_fz": 0.05})
    recipe = tmp_path / "recipe.toml"
    known = extended(tmp_path, "scale_matrix", "left", "gain_fz", 0.05)
    errors = {}
    for name, read, more in (
        ("clean", clean, ()),
        ("without", log, ()),
        ("with", log, ("--parameters", known)),
    ):
        out = tmp_path / f"out_{name}"
        answer = run("online-replay", read, "--recipe", recipe, "--out", out, *more)
        assert answer.exit_code == 0, answer.err
        rows = read_record(RmseRecord, out / "rmse.json").rows
        errors[name] = next(r.rmse for r in rows if (r.quantity, r.stage) == ("vgrf", "memory"))
    assert errors["with"] == pytest.approx(errors["clean"], rel=0.02)
    assert errors["without"] > 1.2 * errors["clean"]


@pytest.mark.usefixtures("drawn")
def test_an_offset_that_jumps_while_walking_is_an_alarm_in_the_report(
    run: Run, tmp_path: Path
) -> None:
    jump = {"right.offset_change_fz": -25.0, "right.change_time": 8.0}
    log = write_walk(tmp_path, 4, 16.0, offset_change=jump)
    out = tmp_path / "out"
    answer = run("online-replay", log, "--recipe", tmp_path / "recipe.toml", "--out", out)
    assert answer.exit_code == 0, answer.err
    assert "right.offset_fz" in answer.out
    findings = json.loads((out / "run.json").read_text(encoding="utf-8"))["findings"]
    (alarm,) = [f for f in findings if f["code"] == "offset_jump"]
    assert alarm["severity"] == "alarm"
    assert "at 8." in alarm["sentence"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effects", "verdict", "names"),
    [
        ({}, "none", set()),
        ({"scale_matrix": {"left.gain_fz": 0.04}}, "named", {"scale_matrix"}),
        ({"delay": {"robot.delay": 0.04}}, "named", {"delay"}),
        ({"mass": {"robot.mass_correction": 3.0}}, "ambiguous", {"mass", "scale_matrix"}),
        (
            {"com_offset": {"robot.com_correction_x": 0.02}},
            "ambiguous",
            {"com_offset", "mount_translation"},
        ),
    ],
    ids=["clean", "left_gain", "delay", "mass", "com"],
)
def test_diagnose_names_what_a_walk_on_ankles_hides(
    run: Run, tmp_path: Path, effects: dict[str, dict[str, float]], verdict: str, names: set[str]
) -> None:
    log = write_walk(tmp_path, 71, 90.0, **effects)
    out = tmp_path / "out"
    answer = run("diagnose", log, "--recipe", tmp_path / "recipe.toml", "--out", out)
    assert answer.exit_code == 0, answer.err
    found = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    assert found["verdict"] == verdict
    if verdict == "named":
        assert [cause["effect"] for cause in found["causes"]] == list(names)
    if verdict == "ambiguous":
        assert any(names <= set(group) for group in found["rivals"])


@pytest.mark.parametrize("command", ["online-replay", "diagnose"])
def test_transducers_of_three_axes_are_refused(command: str, tmp_path: Path, run: Run) -> None:
    """Torques written as zero ended `diagnose` in an internal error."""
    log = write_walk(tmp_path, 5, 20.0)
    table = pd.read_parquet(log)
    for name in (f"{foot}_t{axis}_nm" for foot in ("left", "right") for axis in "xyz"):
        table[name] = 0.0
    table.to_parquet(log)
    done = run(command, log, "--recipe", tmp_path / "recipe.toml", "--out", tmp_path / "o")
    assert done.exit_code == 3
    assert "the torques of left never change" in done.err
    assert "left_foot_counts" in done.err
    assert not (tmp_path / "o").exists()
