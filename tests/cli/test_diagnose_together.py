"""``check`` and ``diagnose`` of cells loaded together, and of known wrenches on a sensor."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.parameters import FloatArray
from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord, RunRecord
from tests.conftest import Run

CELLS = ("foot_a", "foot_b")
AXES = ("fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm")
BRIDGES = tuple(f"g{i}" for i in range(6))


def loaded_together(folder: Path, crosstalk: float) -> Path:
    """Two cells of a foot in thirty load cases, three repeats each."""
    rng = np.random.default_rng(1)
    loads = np.repeat(rng.uniform(0, 40, (30, 2)), 3, axis=0)
    shown = loads + crosstalk * loads[:, ::-1] + 0.03 * rng.normal(size=loads.shape)
    frame = pd.DataFrame(np.rint((shown - 280.0) / -3.4e-5), columns=[f"{c}_counts" for c in CELLS])
    frame[[f"{c}_load_n" for c in CELLS]] = loads
    frame["case"] = [f"case {i // 3}" for i in range(90)]
    frame.to_csv(folder / "together.csv", index=False)
    (folder / "together.toml").write_text(f"[robot]\nchannels = {list(CELLS)}\n")
    return folder / "together.csv"


def under_wrenches(folder: Path, curve_per_n: float = 0.0) -> tuple[Path, FloatArray]:
    """A sensor of six bridges under eighty known wrenches; ``fz + curve · fz²`` acts on it."""
    rng = np.random.default_rng(2)
    matrix = np.diag([0.01] * 6) + 0.002 * rng.normal(size=(6, 6))
    wrench = rng.uniform(-1, 1, (80, 6)) * [40, 40, 80, 4, 4, 4]
    felt = wrench.copy()
    felt[:, 2] += curve_per_n * felt[:, 2] ** 2
    counts = felt @ np.linalg.inv(matrix).T + 2.0 * rng.normal(size=(80, 6))
    frame = pd.DataFrame(counts, columns=[f"{b}_counts" for b in BRIDGES])
    frame[[f"known_{axis}" for axis in AXES]] = wrench
    frame.to_csv(folder / "wrenches.csv", index=False)
    text = f"[robot]\nchannels = {list(BRIDGES)}\n[offline_fit]\nknown_wrench = true\n"
    (folder / "wrenches.toml").write_text(text)
    return folder / "wrenches.csv", matrix


def diagnosed(run: Run, log: Path, *more: str | Path) -> DiagnosisRecord:
    out = log.parent / "diagnosis"
    answer = run(
        "diagnose", log, "--recipe", log.with_suffix(".toml"), "--experiment", "weights",
        "--out", out, *more,
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    return read_record(DiagnosisRecord, out / "diagnosis.json")


@pytest.mark.parametrize("crosstalk", [0.02, 0.0])
def test_crosstalk_of_cells_loaded_together_is_named(
    run: Run, tmp_path: Path, crosstalk: float
) -> None:
    record = diagnosed(run, loaded_together(tmp_path, crosstalk))
    if not crosstalk:
        assert (record.verdict, record.causes) == ("none", ())
        return
    (cause,) = record.causes
    assert (cause.effect, cause.where) == ("crosstalk", "all cells")
    assert cause.ci95 is not None
    low, high = cause.ci95
    assert low < crosstalk < high
    assert high - low < 0.05 * crosstalk
    found = read_record(ParametersRecord, tmp_path / "diagnosis/parameters_extended.json")
    assert found.parameters["foot_a.scale"].value == pytest.approx(-3.4e-5, rel=1e-3)
    assert [e.effect for e in found.effects] == ["crosstalk"]


@pytest.mark.parametrize("curve_per_n", [2e-4, 0.0])
def test_a_curve_under_known_wrenches_is_named(
    run: Run, tmp_path: Path, curve_per_n: float
) -> None:
    """Behind the matrix that the rows give; a straight sensor has no cause."""
    log, matrix = under_wrenches(tmp_path, curve_per_n)
    record = diagnosed(run, log)
    if not curve_per_n:
        assert (record.verdict, record.causes) == ("none", ())
        return
    (cause,) = record.causes
    assert (cause.effect, cause.where) == ("nonlinearity", "sensor.fz")
    assert cause.ci95 is not None
    assert cause.ci95[0] < curve_per_n < cause.ci95[1]
    path = tmp_path / "diagnosis/parameters_extended.json"
    extended = read_record(ParametersRecord, path)
    assert [(e.effect, dict(e.owners)) for e in extended.effects] == [
        ("nonlinearity", {"sensor.fz": ("sensor.fz",)})
    ]
    scales = [[extended.value(f"{axis.split('_')[0]}.scale_from_{b}") for b in BRIDGES]
              for axis in AXES]  # fmt: skip
    np.testing.assert_allclose(scales, matrix, atol=2e-4)
    # the next diagnosis starts from it, and nothing is left to name
    next_start = path.rename(tmp_path / "extended.json")
    again = diagnosed(run, log, "--parameters", next_start, "--overwrite")
    assert (again.verdict, again.causes) == ("none", ())


def test_known_wrenches_are_checked(run: Run, tmp_path: Path) -> None:
    log, _ = under_wrenches(tmp_path)
    recipe = log.with_suffix(".toml")
    answer = run("check", log, "--recipe", recipe, "--out", tmp_path / "sound")
    assert answer.exit_code == 0, answer.err
    assert "Nothing wrong found in 80 rows" in answer.out
    table = pd.read_csv(log)
    table["g3_counts"] = table["g3_counts"].iloc[0]
    table.to_csv(log, index=False)
    run("check", log, "--recipe", recipe, "--out", tmp_path / "stuck")
    findings = read_record(RunRecord, tmp_path / "stuck/run.json").findings
    assert ("g3" in "".join(f.where for f in findings), len(findings)) == (True, 1)
