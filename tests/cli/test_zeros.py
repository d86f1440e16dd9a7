"""Zeros of a robot in the air (``[data] zeros``), and a body stream that lacks a column."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord
from tests.cli.walk_files import write_belief, write_stand
from tests.conftest import Run
from tests.core.walk_data import CHANNELS, Standing, make_standing

OPTIONS = "[static_init]\ndelay_s = 0.0\nwarm_s = 0.25"
SOLE_N, AGAIN_N = 2.0, 0.05
"""What a sole moved the zeros by since the bench, and what moves them from lift to lift (sd)."""


def zeros_of(made: Standing) -> np.ndarray:
    """Counts of cells that carry nothing: ``(1 + γ)(c⁰ r + d⁰) + β = 0``, shape (8,)."""
    return (-made.true_bias / (1 + made.true_gain) - made.bias0) / made.scale0


def written(folder: Path, *, lifts: int) -> tuple[Standing, Path, Path]:
    """A stand, its recipe with zeros, and a bench calibration made before the soles came on."""
    made = make_standing(8, 5, replace=True, bias_sd=SOLE_N)
    rng = np.random.default_rng(7)
    scatter = rng.normal(0, AGAIN_N, (lifts, len(CHANNELS))) / made.scale0
    table = pd.DataFrame(zeros_of(made) + scatter, columns=[f"{c}_counts" for c in CHANNELS])
    table.to_csv(folder / "lifted.csv", index=False)
    recipe = write_stand(folder, made, f'zeros = "lifted.csv"\n{OPTIONS}')
    return made, recipe, write_belief(folder, made)


def biases_off(made: Standing, out: Path) -> np.ndarray:
    """How far each cell's zero is off in N, shape (8,)."""
    record = read_record(ParametersRecord, out / "parameters.json")
    scale, bias = (np.array([record.value(f"{c}.{n}") for c in CHANNELS])
                   for n in ("scale", "bias"))  # fmt: skip
    return np.asarray(scale * zeros_of(made) + bias)


@pytest.mark.parametrize("lifts", [3, 400])
def test_zeros_of_lifts_replace_those_of_the_bench(run: Run, tmp_path: Path, lifts: int) -> None:
    made, recipe, belief = written(tmp_path, lifts=lifts)
    out = tmp_path / "out"
    answer = run("static-init", "--recipe", recipe, "--parameters", belief, "--out", out)
    assert answer.exit_code == 0, answer.err
    assert "the zeros of 8 cells are those of this log" in answer.out.replace("\n", " ")
    assert np.abs(biases_off(made, out)).max() < 4 * AGAIN_N
    text = recipe.read_text(encoding="utf-8").replace('zeros = "lifted.csv"', "")
    recipe.write_text(text, encoding="utf-8")
    run("static-init", "--recipe", recipe, "--parameters", belief, "--out", tmp_path / "without")
    assert np.abs(biases_off(made, tmp_path / "without")).max() > 10 * AGAIN_N


def test_a_calibration_that_has_seen_the_zeros_keeps_its_own(run: Run, tmp_path: Path) -> None:
    _, recipe, belief = written(tmp_path, lifts=3)
    first = run("static-init", "--recipe", recipe, "--parameters", belief,
                "--out", tmp_path / "a")  # fmt: skip
    again = run("static-init", "--recipe", recipe, "--parameters",
                tmp_path / "a" / "parameters.json", "--out", tmp_path / "b")  # fmt: skip
    before = run("diagnose", "--recipe", recipe, "--experiment", "stand", "--parameters",
                 tmp_path / "a" / "parameters.json", "--out", tmp_path / "c")  # fmt: skip
    assert "zeros of 8 cells" in first.out.replace("\n", " ")
    assert again.exit_code == 0, again.err
    assert "zeros of 8 cells" not in again.out.replace("\n", " ")
    # `diagnose` begins with the calibration before these logs, which had not seen them
    assert before.exit_code == 0, before.err
    assert "zeros of 8 cells" in before.out.replace("\n", " ")


def test_zeros_without_a_cell_are_refused(run: Run, tmp_path: Path) -> None:
    _, recipe, belief = written(tmp_path, lifts=3)
    table = pd.read_csv(tmp_path / "lifted.csv").drop(columns=f"{CHANNELS[2]}_counts")
    table.to_csv(tmp_path / "lifted.csv", index=False)
    answer = run("static-init", "--recipe", recipe, "--parameters", belief, "--out", tmp_path / "o")
    assert answer.exit_code != 0
    assert f"missing column '{CHANNELS[2]}_counts'" in answer.err


def test_a_motion_that_is_left_out_says_what_it_lacks(run: Run, tmp_path: Path) -> None:
    _, recipe, belief = written(tmp_path, lifts=3)
    cells, body = (pd.read_parquet(tmp_path / f"{n}.parquet") for n in ("cells", "body"))
    heights = ["left_foot_z_m", "right_foot_z_m"]
    both = cells.join(body.drop(columns=["time_s", *heights]))
    both.to_parquet(tmp_path / "cells.parquet", index=False)
    text = recipe.read_text(encoding="utf-8").replace('body = "body.parquet"', "")
    recipe.write_text(text, encoding="utf-8")
    answer = run("static-init", "--recipe", recipe, "--parameters", belief, "--out", tmp_path / "o")
    said = answer.out.replace("\n", " ")
    assert "left_foot_z_m, right_foot_z_m are missing" in said
    assert "left_foot_z_m = { value = 0.0 }" in said
    text += "[columns]\n" + "".join(f"{name} = {{ value = 0.0 }}\n" for name in heights)
    recipe.write_text(text, encoding="utf-8")
    answer = run("static-init", "--recipe", recipe, "--parameters", belief, "--out", tmp_path / "p")
    assert "missing" not in answer.out
    assert "CoP error" in answer.out.replace("\n", " ")
