"""``--json``: one JSON on stdout, whatever happens, in agreement with exit code and run folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.conftest import Answer, Run


def read(answer: Answer) -> dict[str, Any]:
    """The only thing on stdout."""
    found: dict[str, Any] = json.loads(answer.out)
    assert found["schema"] == "footcal.answer"
    assert found["exit_code"] == answer.exit_code
    return found


@pytest.fixture
def weights(tmp_path: Path) -> Path:
    rng = np.random.default_rng(1)
    load = np.repeat([0.0, 5.0, 10.0, 20.0], 5)
    lines = [f"fl,{k:g},{8.3e6 - 3e4 * k + 40 * rng.normal():.0f}" for k in load]
    path = tmp_path / "weights.csv"
    path.write_text("\n".join(["channel,load_n,counts", *lines]) + "\n", encoding="utf-8")
    return path


def test_an_accepted_calibration_a_missed_gate_and_a_refusal(
    weights: Path, tmp_path: Path, run: Run
) -> None:
    accepted = read(run("--json", "offline-fit", weights, "--out", tmp_path / "good"))
    assert accepted["verdict"]["level"] == "good"
    assert Path(accepted["parameters"]).is_file()
    assert Path(accepted["report"]).is_file()
    assert sorted(accepted["files"]) == sorted(
        str(p) for p in (tmp_path / "good").rglob("*") if p.is_file()
    )
    held_out = [r for r in accepted["rmse"] if r["split"] == "held_out" and r["stage"] == "after"]
    assert held_out[0]["rmse"] < 0.01

    missed = read(run("offline-fit", weights, "--out", tmp_path / "gate", "--max-rmse-n", "1e-9",
                      "--json"))  # fmt: skip
    assert missed["exit_code"] == 1
    assert missed["parameters"] is None
    assert missed["gates_missed"]

    refused = read(run("offline-fit", tmp_path / "none.csv", "--json"))
    assert refused["exit_code"] == 2
    assert "no such file" in refused["error"]
    assert refused["verdict"] is None


def test_a_misspelt_option_and_a_command_without_an_answer_are_json_too(
    weights: Path, tmp_path: Path, run: Run
) -> None:
    assert read(run("check", weights, "--otu", "x", "--json"))["exit_code"] == 2
    assert "no JSON answer" in read(run("--json", "effects"))["error"]


def test_init_answers_with_its_recipe_and_the_next_command(
    weights: Path, tmp_path: Path, run: Run
) -> None:
    recipe = tmp_path / "guess.toml"
    answer = read(run("init", weights, "-o", recipe, "--json"))
    assert answer["recipe"] == str(recipe)
    assert answer["next_step"] == f"footcal offline-fit --recipe {recipe}"
