"""``footcal apply`` on load cells: everything offline-fit writes can be used."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.parameters import FloatArray
from tests.conftest import Run

ROOT = Path(__file__).resolve().parent.parent.parent
RECIPE = ROOT / "recipes/bench_foot.toml"
HELD_OUT = ("H05", "H11", "H16")


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The simulated foot, calibrated."""
    from footcal_cli.app import main

    out = tmp_path_factory.mktemp("apply") / "bench"
    with pytest.raises(SystemExit) as end:
        main(["offline-fit", "--recipe", str(RECIPE), "--out", str(out), "--quiet"])
    assert end.value.code == 0
    return out


@pytest.fixture(scope="module")
def placed() -> pd.DataFrame:
    """Placements that no fit has seen."""
    rows = pd.read_csv(ROOT / "sample_data/bench_foot/placements.csv")
    return rows[rows["placement"].isin(HELD_OUT)].reset_index(drop=True)


@pytest.fixture
def log(placed: pd.DataFrame, tmp_path: Path) -> Path:
    """Their counts as a stream of the foot."""
    counts = placed[[c for c in placed if str(c).endswith("_counts")]].add_prefix("left_")
    counts.insert(0, "time_s", 0.05 * np.arange(len(counts)))
    path = tmp_path / "stream.csv"
    counts.to_csv(path, index=False)
    return path


def cop_error_mm(out: Path, placed: pd.DataFrame) -> float:
    frame = pd.read_parquet(out / "calibrated.parquet")
    error = frame[["left_cop_x_m", "left_cop_y_m"]].to_numpy()
    error = error - placed[["hole_x_m", "hole_y_m"]].to_numpy()
    heavy = placed["load_n"].to_numpy() > 10
    return 1000 * float(np.sqrt(np.nanmean(np.sum(error[heavy] ** 2, axis=1))))


def without_corrections(bench: Path, path: Path) -> Path:
    """The same calibration with scales and biases only."""
    content = json.loads((bench / "parameters.json").read_text())
    content["effects"] = []
    path.write_text(json.dumps(content))
    return path


def test_corrections_of_cells_and_of_the_cop_are_undone(
    bench: Path, placed: pd.DataFrame, log: Path, tmp_path: Path, run: Run
) -> None:
    bare = without_corrections(bench, tmp_path / "bare.json")
    polynomial = bench / "cop_correction.json"
    asked: dict[str, tuple[object, ...]] = {
        "bare": ("--parameters", bare),
        "physical": ("--parameters", bench / "parameters.json"),
        "polynomial": ("--parameters", bare, "--cop-correction", polynomial),
    }
    error = {}
    for name, options in asked.items():
        out = tmp_path / name
        answer = run("apply", log, "--recipe", RECIPE, *options, "--out", out)
        assert answer.exit_code == 0, answer.err
        error[name] = cop_error_mm(out, placed)
    # the cells stand 4 mm from where they are believed, readings scatter by some hundredths of a N
    assert error["bare"] > 3.0
    assert error["physical"] < 1.0
    assert error["polynomial"] < 1.5
    said = " ".join(answer.out.split())
    assert "no mass_kg to compare it with" in said
    assert "Add mass_kg to [robot]" in said


def test_the_sum_of_the_forces_stands_beside_the_weight(
    bench: Path, placed: pd.DataFrame, log: Path, tmp_path: Path, run: Run
) -> None:
    mass = float(placed["load_n"].median()) / 9.80665
    recipe = RECIPE.read_text("utf-8").replace("[robot]", f"[robot]\nmass_kg = {mass}", 1)
    (tmp_path / "heavy.toml").write_text(recipe, "utf-8")
    bare = without_corrections(bench, tmp_path / "bare.json")
    answer = run("apply", log, "--recipe", tmp_path / "heavy.toml", "--parameters", bare,
                 "--out", tmp_path / "out")  # fmt: skip
    assert f"the robot weighs {placed['load_n'].median():.4g} N" in " ".join(answer.out.split())
    assert "mass_kg" not in answer.out


def test_a_cop_is_not_corrected_twice(bench: Path, log: Path, tmp_path: Path, run: Run) -> None:
    answer = run(
        "apply", log, "--recipe", RECIPE, "--parameters", bench / "parameters.json",
        "--cop-correction", bench / "cop_correction.json", "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 2
    assert "moves the cells of foot 'left'" in answer.err
    assert not (tmp_path / "out").exists()


def test_a_full_matrix_gives_the_loads_back(tmp_path: Path, run: Run) -> None:
    rng = np.random.default_rng(3)
    scale, bias = np.array([-3.4e-5, -3.1e-5]), np.array([280.0, 250.0])
    mixing = np.array([[1.0, 0.03], [0.02, 1.0]])

    def counts_of(loads: FloatArray) -> FloatArray:
        return np.asarray((loads @ mixing.T - bias) / scale)

    loads = rng.uniform(0, 40, (60, 2))
    frame = pd.DataFrame(counts_of(loads + 0.01 * rng.normal(size=loads.shape)))
    frame.columns = pd.Index(["a_counts", "b_counts"])
    frame[["a_load_n", "b_load_n"]] = loads
    frame.to_csv(tmp_path / "bench.csv", index=False)
    recipe = tmp_path / "r.toml"
    recipe.write_text('[robot]\nchannels = ["a", "b"]\n')
    fitted = tmp_path / "fitted"
    answer = run("offline-fit", tmp_path / "bench.csv", "--recipe", recipe, "--out", fitted)
    assert answer.exit_code == 0, answer.err
    fresh = rng.uniform(0, 40, (20, 2))
    stream = pd.DataFrame(counts_of(fresh), columns=["a_counts", "b_counts"])
    stream.insert(0, "time_s", 0.05 * np.arange(20))
    stream.to_csv(tmp_path / "stream.csv", index=False)
    answer = run(
        "apply", tmp_path / "stream.csv", "--recipe", recipe,
        "--parameters", fitted / "parameters.json", "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    found = pd.read_parquet(tmp_path / "out/calibrated.parquet")[["a_n", "b_n"]].to_numpy()
    # crosstalk left in would show as 0.03 x 40 N
    assert np.abs(found - fresh).max() < 0.05


def test_a_long_log_is_calibrated_piece_by_piece_as_at_once(
    run: Run, bench: Path, log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from footcal_cli.tables import longfiles

    parquet = tmp_path / "stream.parquet"
    pd.read_csv(log).to_parquet(parquet, index=False)
    frames = []
    for name in ("whole", "pieces"):
        answer = run("apply", parquet, "--recipe", RECIPE, "--parameters", bench /
                     "parameters.json", "--out", tmp_path / name, "--quiet")  # fmt: skip
        assert answer.exit_code == 0, answer.err
        frames.append(pd.read_parquet(tmp_path / name / "calibrated.parquet"))
        runs = json.loads((tmp_path / name / "run.json").read_text())
        assert runs["rows"] == {str(parquet): len(frames[0])}
        monkeypatch.setattr(longfiles, "LONG_BYTES", 0)
        monkeypatch.setattr(longfiles, "PIECE_ROWS", 5)
    pd.testing.assert_frame_equal(frames[0], frames[1])
