"""A person on two six-axis plates with motion capture: a calibration, and a cause."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord
from tests.cli.few_effects import few_or_all
from tests.conftest import Run
from tests.foreign.plates import MASS_KG, PlateStand, plate_stand

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")


def calibrated(stand: PlateStand, folder: Path, run: Run) -> tuple[object, ...]:
    """`init`, the mass filled in, `static-init`: how the next command is to be called."""
    log, recipe, stood = stand.written(folder / "stand.csv"), folder / "my.toml", folder / "stood"
    assert run("init", log, "-o", recipe).exit_code == 0
    text = recipe.read_text(encoding="utf-8")
    recipe.write_text(text.replace("# mass_kg =", f"mass_kg = {MASS_KG}  #"), encoding="utf-8")
    run("static-init", "--recipe", recipe, "--out", stood)
    made = stood / "parameters.json"  # a plate far off leaves none
    return ("--recipe", recipe, *(("--parameters", made) if made.exists() else ()))


KINDS = few_or_all("scale_matrix", "nonlinearity", "offset_change", "com_offset", "cross_coupling")


def diagnosed(
    stand: PlateStand, folder: Path, run: Run, few: tuple[str, ...] = ()
) -> DiagnosisRecord:
    given = calibrated(stand, folder, run)
    asked = ("--experiment", "stand", "--no-pictures", "--out", folder / "why")
    assert run("diagnose", *given, *asked, *few).exit_code == 0
    return read_record(DiagnosisRecord, folder / "why" / "diagnosis.json")


def test_offsets_and_nothing_to_name(tmp_path: Path, run: Run) -> None:
    stand = plate_stand(11)
    found = diagnosed(stand, tmp_path, run)
    assert (found.verdict, found.causes) == ("none", ())
    record = read_record(ParametersRecord, tmp_path / "stood" / "parameters.json").parameters
    names = [[f"fp_{k}.offset_{axis}" for axis in AXES] for k in (1, 2)]
    off, sd = (
        np.array([[getattr(record[name], what) for name in of_plate] for of_plate in names])
        for what in ("value", "sd")
    )
    assert np.all(np.abs(off - stand.offset) < 3.0 * sd)
    assert np.all(sd < [2.0, 2.0, 2.0, 0.2, 0.2, 0.2])


@KINDS
def test_a_gain_beyond_the_data_sheet_is_named(
    tmp_path: Path, run: Run, few: tuple[str, ...]
) -> None:
    found = diagnosed(plate_stand(19, gain=np.array([1, 1, 0.95, 1, 1, 1])), tmp_path, run, few)
    named = {cause.effect for cause in found.causes}.union(*found.rivals)
    assert "scale_matrix" in named
    gains = [one.owners for one in found.suspects if one.effect == "scale_matrix"]
    assert [list(owners) for owners in gains] == [["fp_1"]]


@KINDS
def test_a_curve_is_named(tmp_path: Path, run: Run, few: tuple[str, ...]) -> None:
    stand = plate_stand(18)
    wrench = stand.wrench.copy()
    wrench[:, 0, 2] += 0.03 * wrench[:, 0, 2] ** 2 / 700.0
    bent = PlateStand(stand.time_s, stand.com_m, wrench, stand.cop_m, stand.offset)
    found = diagnosed(bent, tmp_path, run, few)
    assert [(c.effect, c.where) for c in found.causes] == [("nonlinearity", "fp_1.fz")]


@KINDS
def test_a_jump_of_an_offset_is_named_though_no_stance_repeats_it(
    tmp_path: Path, run: Run, few: tuple[str, ...]
) -> None:
    stand = plate_stand(20)
    wrench, when = stand.wrench.copy(), 0.45 * stand.time_s[-1]
    wrench[stand.time_s > when, 0, 2] += 15.0
    jumped = PlateStand(stand.time_s, stand.com_m, wrench, stand.cop_m, stand.offset)
    (cause,) = diagnosed(jumped, tmp_path, run, few).causes
    assert (cause.effect, cause.where) == ("offset_change", "fp_1")
    assert cause.ci95 is not None
    low, high = cause.ci95
    assert low < 15.0 < high


def test_what_the_calibration_corrected_is_no_finding(tmp_path: Path, run: Run) -> None:
    """A CoM 20 mm off above plates whose places are known: `static-init` finds it."""
    stand, stood = plate_stand(11), tmp_path / "again"
    given = calibrated(stand, tmp_path, run)[:2]
    off = stand.com_m + np.array([0.02, 0.0, 0.0])
    moved = PlateStand(stand.time_s, off, stand.wrench, stand.cop_m, stand.offset)
    moved.written(tmp_path / "stand.csv")
    assert run("static-init", *given, "--out", stood).exit_code == 0
    found = read_record(ParametersRecord, stood / "parameters.json").parameters
    assert abs(found["robot.com_correction_x"].value + 0.02) < 0.003
    asked = ("--experiment", "stand", "--no-pictures", "--out", tmp_path / "why")
    start = ("--parameters", stood / "parameters.json")
    assert run("diagnose", *given, *start, *asked).exit_code == 0
    assert read_record(DiagnosisRecord, tmp_path / "why" / "diagnosis.json").verdict == "none"
