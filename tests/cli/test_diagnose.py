"""``footcal diagnose`` as the shell runs it, on data with an effect hidden by foreign code."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from footcal_cli.app import main
from footcal_cli.records.diagnosis import DiagnosisRecord, PlanRecord
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord
from tests.cli.few_effects import without_all_but
from tests.conftest import Run, drawing

CELLS = ("left_fl", "left_fr", "left_rl")
STEPS = np.array([0.0, 1.0, 3.0, 6.0, 10.0, 15.0, 20.0, 15.0, 10.0, 6.0, 3.0, 1.0, 0.0])


def lagging(load: np.ndarray, width: float) -> np.ndarray:
    """A cell that stays behind by half a width, more so after turning (play with friction)."""
    state, shown = 0.0, np.empty_like(load)
    for i, x in enumerate(load):
        state = min(max(state, x - 4.0), x + 4.0)
        shown[i] = x + width / 8.0 * (state - x)
    return shown


def write_weights(
    path: Path, seed: int, width: float, sessions: int = 6, knee: float = 0.0
) -> None:
    """Ladders up and down on three cells and several days, with noise and a gain of each day.

    `knee`: the cells answer more steeply by this share above 4 N.
    """
    rng = np.random.default_rng(seed)
    load = np.repeat(STEPS, 6)
    rows = []
    for cell in CELLS:
        scale = -3.4e-5 * (1 + 0.02 * rng.standard_normal())
        for day in range(sessions):
            force = (lagging(load, width) + knee * np.maximum(load - 4.0, 0.0)) * (
                1 + 0.001 * rng.standard_normal()
            )
            force = force + 0.01 * rng.standard_normal() + 0.03 * rng.standard_normal(load.size)
            rows.append(
                pd.DataFrame(
                    {
                        "channel": cell,
                        "load_n": load,
                        "counts": np.rint(8.3e6 + force / scale),
                        "time_s": 3.0 * np.arange(load.size),
                        "session": f"day {day + 1}",
                    }
                )
            )
    pd.concat(rows).to_csv(path, index=False)


def diagnosed(run: Run, log: Path, out: Path, *more: object) -> DiagnosisRecord:
    answer = run(
        "diagnose", log, "--experiment", "weights", "--tolerance-n", "0.02", "--out", out, *more
    )
    assert answer.exit_code == 0, answer.err
    return read_record(DiagnosisRecord, out / "diagnosis.json")


@pytest.fixture(scope="module")
def lagged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Weights with a hidden hysteresis, and in ``out`` their diagnosis."""
    folder = tmp_path_factory.mktemp("lagged")
    write_weights(folder / "weights.csv", 1, width=0.5)
    words = ("--experiment", "weights", "--tolerance-n", "0.02", "--out", str(folder / "out"))
    with drawing(), pytest.raises(SystemExit) as ended:
        main(["diagnose", str(folder / "weights.csv"), *words, "--quiet"])
    assert ended.value.code == 0
    return folder


def test_hidden_hysteresis_is_named_sized_and_worth_something(lagged: Path) -> None:
    record = read_record(DiagnosisRecord, lagged / "out/diagnosis.json")
    assert record.verdict == "named"
    (cause,) = record.causes
    assert (cause.effect, cause.where) == ("hysteresis", "all cells")
    assert cause.ci95 is not None
    assert cause.ci95[0] <= 0.5 <= cause.ci95[1]
    assert cause.ci95[1] - cause.ci95[0] < 0.2
    assert record.effects[0].effect == "hysteresis"  # what was named leads the table
    assert 0.0 < (record.effects[0].gain or 0.0) < 1.0
    assert cause.held_out_gain is not None
    assert cause.held_out_gain.ci95 is not None
    assert cause.held_out_gain.ci95[0] > 0
    status = {row.effect: row.status for row in record.effects}
    assert status["hysteresis"] == "present"
    assert status["temperature_bias"] == "not_testable"
    report = (lagged / "out/report.html").read_text("utf-8")
    assert report.index("Evidence") < report.index("data:image/png")
    assert "hysteresis" in record.sentence
    assert record.sentence.endswith("No other effect passes the tests.")
    page = report[report.index('id="result"') :]
    assert page.index("Approach every load from the same side") < page.index("<ul>")
    assert str(lagged) not in page[: page.index("</section>")]
    assert "To reproduce: footcal diagnose" in report
    assert "--tolerance-n 0.02" in report


def test_the_extended_model_is_read_and_leaves_nothing(
    run: Run, lagged: Path, tmp_path: Path
) -> None:
    extended = lagged / "out/parameters_extended.json"
    parameters = read_record(ParametersRecord, extended)
    assert [e.effect for e in parameters.effects] == ["hysteresis"]
    assert parameters.parameters["all.hysteresis_width"].value == pytest.approx(0.5, abs=0.06)
    again = diagnosed(run, lagged / "weights.csv", tmp_path / "second", "--parameters", extended)
    assert again.verdict == "none"


def test_clean_weights_name_nothing_and_say_what_would_have_shown(run: Run, tmp_path: Path) -> None:
    write_weights(tmp_path / "weights.csv", 3, width=0.0)
    record = diagnosed(run, tmp_path / "weights.csv", tmp_path / "out")
    assert record.verdict == "none"
    assert not record.causes
    hysteresis = next(row for row in record.effects if row.effect == "hysteresis")
    assert hysteresis.detectable is not None
    assert hysteresis.detectable < 0.2
    verdict = json.loads((tmp_path / "out/run.json").read_text("utf-8"))["verdict"]
    assert any("Not found does not mean absent" in line for line in verdict["details"])
    assert any("could not be tested" in line for line in verdict["details"])


@pytest.mark.slow
def test_an_effect_left_out_of_the_table_gets_no_confident_other_name(
    run: Run, tmp_path: Path
) -> None:
    write_weights(tmp_path / "weights.csv", 4, width=0.5)
    record = diagnosed(run, tmp_path / "weights.csv", tmp_path / "out", "--without", "hysteresis")
    assert record.verdict in ("unknown", "ambiguous", "named+unknown")
    assert all(row.effect != "hysteresis" for row in record.effects)


def test_too_few_sessions_are_called_so_and_an_effect_left_out_is_in_no_table(
    run: Run, tmp_path: Path
) -> None:
    write_weights(tmp_path / "weights.csv", 5, width=0.0, sessions=2)
    record = diagnosed(
        run, tmp_path / "weights.csv", tmp_path / "out", *without_all_but("hysteresis")
    )
    assert record.verdict == "underpowered"
    assert {row.effect for row in record.effects} == {"hysteresis"}
    assert "Record at least 4 more" in record.sentence


def test_table_2_of_seed_1(run: Run, repository: Path, tmp_path: Path) -> None:
    answer = run(
        "diagnose", "--recipe", repository / "recipes/nao_table2.toml",
        "--experiment", "weights", "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 3, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    assert record.verdict == "bad-data"
    assert not record.causes
    details: list[str] = json.loads((tmp_path / "out/run.json").read_text("utf-8"))["verdict"][
        "details"
    ]
    said = " ".join(details)
    assert "Affine inadequate" in said
    assert "Shared compressive curve: 8 of 8" in said
    assert "cannot distinguish nonlinearity from creep or the order of loading" in said
    assert "four unrepeated points" in said
    assert "up and down" in record.experiment
    assert {"readings_repeat_across_channels"} <= {f.code for f in record.findings}


@pytest.mark.slow
def test_a_walk_of_the_physics_engine_with_a_faulty_cell(
    run: Run, repository: Path, tmp_path: Path
) -> None:
    samples = repository / "sample_data/biped"
    recipe = tmp_path / "nao.toml"
    text = (repository / "recipes/nao_simulated.toml").read_text("utf-8")
    if "zero_counts" not in text:
        text = text.replace("[robot.nameplate]", "[robot.nameplate]\nzero_counts = 8320000.0")
    recipe.write_text(text, "utf-8")

    def verdict(name: str) -> DiagnosisRecord:
        answer = run(
            "diagnose", samples / f"{name}_cells.parquet", samples / f"{name}_body.parquet",
            "--recipe", recipe, "--experiment", "walk", "--out", tmp_path / name,
        )  # fmt: skip
        assert answer.exit_code == 0, answer.err
        return read_record(DiagnosisRecord, tmp_path / name / "diagnosis.json")

    faulty = verdict("walk_004_faulty")
    named = {c.effect for c in faulty.causes} | {n for group in faulty.rivals for n in group}
    assert faulty.effects[0].effect in named
    assert (faulty.effects[0].gain or 0.0) > 0.05
    assert "hysteresis" in named
    assert faulty.verdict in ("named", "ambiguous")
    assert verdict("walk_004").verdict == "none"


def test_a_plan_needs_no_log(run: Run, tmp_path: Path) -> None:
    """A dead zone and a hinge are one curve until the cell is pulled: docs/effects.md."""
    asked = ("--between", "dead_zone", "--between", "hinge")
    answer = run("diagnose", "--plan", *asked, "--out", tmp_path / "plan")
    assert answer.exit_code == 0, answer.err
    plan = read_record(PlanRecord, tmp_path / "plan/plan.json")
    assert plan.between == ("dead_zone", "hinge")
    assert plan.next_experiment == plan.menu[0]
    assert plan.next_experiment.words in answer.out
    alone = run("diagnose", "--plan", "--between", "delay", "--out", tmp_path / "one")
    assert alone.exit_code == 2
    assert "two effects" in alone.err
    misspelt = run(
        "diagnose",
        "--plan",
        "--between",
        "delay",
        "--between",
        "hysteresys",
        "--out",
        tmp_path / "two",
    )
    assert misspelt.exit_code == 2
    assert "'hysteresis'" in misspelt.err


def test_an_ambiguous_diagnosis_proposes_and_its_plan_is_read_again(
    run: Run, tmp_path: Path
) -> None:
    """A knee: a dead zone, a hinge or a curve."""
    write_weights(tmp_path / "weights.csv", 7, width=0.0, knee=0.06)
    log, out = tmp_path / "weights.csv", tmp_path / "out"
    record = diagnosed(run, log, out, "--no-pictures")
    assert record.verdict == "ambiguous"
    proposed = record.next_experiment
    assert proposed is not None
    assert proposed.id
    assert proposed.kind == "weights"
    assert proposed.cosine_after is not None
    assert "Run next" in (out / "report.html").read_text("utf-8")
    assert "data:image/png" not in (out / "report.html").read_text("utf-8")
    again = run("diagnose", "--plan", out / "diagnosis.json", "--out", tmp_path / "plan")
    assert again.exit_code == 0, again.err
    plan = read_record(PlanRecord, tmp_path / "plan/plan.json")
    assert set(plan.between) == set(record.rivals[0])
    # cells without the knee, diagnosed after it: nothing of any rival is there
    assert {s.effect for s in record.suspects} == set(record.rivals[0])
    write_weights(tmp_path / "straight.csv", 8, width=0.0)
    before = ("--after", out / "diagnosis.json", "--no-pictures")
    then = diagnosed(run, tmp_path / "straight.csv", tmp_path / "then", *before)
    assert {f.effect for f in then.after} == set(record.rivals[0])
    assert "rivals in the log before" in (tmp_path / "then/report.html").read_text("utf-8")


def test_explain_and_refusals(run: Run, tmp_path: Path) -> None:
    told = run("diagnose", "--explain", "hysteresis")
    assert told.exit_code == 0
    assert "mimics" in told.out
    misspelt = run("diagnose", "--explain", "hysteresys")
    assert misspelt.exit_code == 2
    assert "hysteresis" in misspelt.err
    write_weights(tmp_path / "weights.csv", 6, width=0.0, sessions=1)
    unknown: Any = run(
        "diagnose", tmp_path / "weights.csv", "--without", "gremlins", "--out", tmp_path / "out"
    )
    assert unknown.exit_code == 2
    assert "gremlins" in unknown.err


def test_a_log_of_another_experiment_says_which_option_names_it(
    run: Run, repository: Path, tmp_path: Path
) -> None:
    logs = repository / "sample_data/biped"
    walk = (logs / "walk_004_faulty_cells.parquet", logs / "walk_004_faulty_body.parquet")
    answer = run("diagnose", *walk, "--out", tmp_path / "out")
    assert answer.exit_code == 3
    assert "read as weights; say what it is by --experiment (placements, stand, walk" in answer.err
