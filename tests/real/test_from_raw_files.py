"""Raw files of others to a calibration: `init` or `convert`, blanks filled in, one command."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.conftest import Run

CELLS = {
    "heel": "{ x_m = -0.08, y_m = 0.0 }", "medial": "{ x_m = 0.06, y_m = 0.03 }",
    "lateral": "{ x_m = 0.05, y_m = -0.03 }",
}  # fmt: skip


def guessed(run: Run, logs: list[Path], recipe: Path, filled: dict[str, str]) -> str:
    """The recipe that `init` writes, blanks filled in as a person would, and what it said."""
    answer = run("init", *logs, "-o", recipe)
    assert answer.exit_code == 0, answer.err
    text = recipe.read_text(encoding="utf-8")
    for blank, value in filled.items():
        assert blank in text
        text = text.replace(blank, value)
    recipe.write_text(text, encoding="utf-8")
    return answer.out


def standing(**places: str) -> dict[str, str]:
    """Blanks of a stance: the person's mass by the plate of the same trial, and the cells."""
    feet = {f"# [robot.feet.{foot}.cells]": f"[robot.feet.{foot}.cells]" for foot in places}
    cells = {f"# {name} = {{ x_m = , y_m =  }}": f"{name} = {at}" for name, at in CELLS.items()}
    return {"# mass_kg = ": "mass_kg = 57.18", **(feet | cells if places else {})}


def test_insoles_that_stand(real_data: Path, run: Run, tmp_path: Path) -> None:
    """Lost packets are written as -1 N: they are none."""
    log = real_data / "loadsol-insoles/test_poids_loadsol.csv"
    guessed(run, [log], tmp_path / "my.toml", standing(left="", right=""))
    answer = run("static-init", "--recipe", tmp_path / "my.toml", "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    rows = json.loads((tmp_path / "out/rmse.json").read_text())["rows"]
    before = next(r["rmse"] for r in rows if r["stage"] == "before" and r["unit"] == "N")
    assert before < 0.02 * 560.8  # the plate's reading of the same stance, N


def test_a_weight_on_an_empty_insole_is_no_stance(
    real_data: Path, run: Run, tmp_path: Path
) -> None:
    log = real_data / "loadsol-insoles/poids_par_zone_loadsol.csv"
    guessed(run, [log], tmp_path / "my.toml", standing(left="", right=""))
    answer = run("static-init", "--recipe", tmp_path / "my.toml", "--out", tmp_path / "out")
    assert answer.exit_code == 3
    assert "nothing carries the weight of 561 N" in answer.err


def test_a_plate_in_c3d(real_data: Path, run: Run, tmp_path: Path) -> None:
    pytest.importorskip("ezc3d")
    log = real_data / "loadsol-insoles/test_poids.c3d"
    assert run("convert", log, "--out", tmp_path / "c3d", "--quiet").exit_code == 0
    plates = sorted((tmp_path / "c3d").glob("plate_*.parquet"))
    said = guessed(run, plates, tmp_path / "my.toml", standing())
    assert "left out, nothing stands on them" in said
    answer = run("static-init", "--recipe", tmp_path / "my.toml", "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err


def test_hung_weights_in_order_of_time(real_data: Path, run: Run, tmp_path: Path) -> None:
    log = real_data / "loadcell-creep/test2.csv"
    said = guessed(run, [log], tmp_path / "my.toml", {
        "# [offline_fit.plateaus]": "[offline_fit.plateaus]",
        '# loads = " ,  ,  ,   kg"': 'loads = "5, 0, 2.1374, 0.5288 kg"',
    })  # fmt: skip
    assert "loads were put on" in said
    answer = run("offline-fit", "--recipe", tmp_path / "my.toml", "--out", tmp_path / "out",
                 "--no-pictures")  # fmt: skip
    assert answer.exit_code == 0, answer.err
    assert "creeps within its holds, time constant 101 s" in answer.out


@pytest.mark.slow
def test_taxels_under_a_pressure(real_data: Path, run: Run, tmp_path: Path) -> None:
    log = real_data / "insole-plenum/calibration_dataset.parquet"
    guessed(run, [log], tmp_path / "my.toml", {'unit = "?"': 'unit = "N"'})
    answer = run("offline-fit", "--recipe", tmp_path / "my.toml", "--out", tmp_path / "out",
                 "--no-pictures")  # fmt: skip
    assert answer.exit_code == 0, answer.err
    assert "channels need more than a scale and a bias" in answer.out
