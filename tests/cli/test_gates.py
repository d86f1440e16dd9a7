"""A gate that failed stays failed: for make, for scripts, and for the next command."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Literal, cast

import numpy as np
import pytest
import typer
from typer.main import get_command

from footcal_cli.app import COMMANDS, function_of
from footcal_cli.core.online.comparison import left_interval
from footcal_cli.core.online.evidence import LeftInterval
from footcal_cli.core.online.filter import Track
from footcal_cli.core.online.jumps import BiasJump
from footcal_cli.core.online.memory import sized_jumps
from footcal_cli.core.plausibility import check_gains
from footcal_cli.core.quality import Finding
from footcal_cli.recipe import CommandOptions, Gates
from footcal_cli.records.results import ParametersRecord, RmseRecord, RmseRow, VerdictRecord
from footcal_cli.report.outcome import Outcome
from footcal_cli.session.gates import DOUBTFUL, gated, merged, trusted
from tests.cli.test_run_folder import LOG
from tests.conftest import REPOSITORY, Run


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "weights.csv"
    path.write_text(LOG)
    return path


GATE = ("--max-rmse-n", "1e-9")


def test_a_rejected_calibration_has_another_name_and_says_why(
    run: Run, log: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert run("offline-fit", log, "--out", out).exit_code == 0
    assert run("offline-fit", log, "--out", out, "--overwrite", *GATE).exit_code == 1
    assert not (out / "parameters.json").exists()
    rejected = json.loads((out / "parameters_rejected.json").read_text())
    assert "RMSE" in rejected["rejected_because"][0]


def test_no_command_starts_from_a_rejected_calibration(run: Run, log: Path, tmp_path: Path) -> None:
    assert run("offline-fit", log, "--out", tmp_path / "out", *GATE).exit_code == 1
    renamed = (tmp_path / "out/parameters_rejected.json").rename(tmp_path / "parameters.json")
    answer = run("offline-fit", log, "--parameters", renamed, "--out", tmp_path / "next")
    assert answer.exit_code == 2
    assert "rejected" in answer.err
    assert "RMSE" in answer.err


def test_a_diagnosis_starts_from_a_rejected_calibration_and_leaves_one(
    run: Run, log: Path, tmp_path: Path
) -> None:
    assert run("offline-fit", log, "--out", tmp_path / "out", *GATE).exit_code == 1
    rejected = tmp_path / "out/parameters_rejected.json"
    # who gives the calibration that is not there learns why, and what to ask
    answer = run("offline-fit", log, "--parameters", tmp_path / "out/parameters.json",
                 "--out", tmp_path / "next")  # fmt: skip
    assert answer.exit_code == 2
    assert "RMSE" in answer.err
    assert f"diagnose --parameters {rejected.as_posix()}" in " ".join(answer.err.split())
    out = tmp_path / "diagnosis"
    answer = run("diagnose", log, "--parameters", rejected, "--out", out)
    assert answer.exit_code in (0, 3)
    found = json.loads((out / "diagnosis.json").read_text())["findings"]
    assert "calibration_rejected" in {finding["code"] for finding in found}
    extended = out / "parameters_extended.json"
    answer = run("offline-fit", log, "--parameters", extended, "--out", tmp_path / "next")
    assert answer.exit_code == 2
    assert "rejected" in answer.err


def test_make_fails_again_until_the_gate_is_met(log: Path, tmp_path: Path) -> None:
    (tmp_path / "Makefile").write_text(
        "out/parameters.json: weights.csv\n"
        f"\t{sys.executable} -m footcal_cli offline-fit $< --out out --overwrite $(GATE) "
        "--no-pictures --quiet\n"
    )

    def make(*words: str) -> int:
        return subprocess.run(
            ["make", "-s", *words], cwd=tmp_path, capture_output=True, check=False,
            env={"PYTHONPATH": str(REPOSITORY), "PATH": "/usr/bin:/bin"},
        ).returncode  # fmt: skip

    tight = f"GATE={' '.join(GATE)}"
    assert [make(tight), make(tight)] == [2, 2]
    assert make() == 0
    assert make("-q") == 0


def test_strict_findings_on_a_command_that_never_had_it(
    run: Run, repository: Path, tmp_path: Path
) -> None:
    answer = run(
        "diagnose", repository / "sample_data/nao_table2/weights.csv", "--experiment", "weights",
        "--no-pictures", "--strict-findings", "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code in {1, 3}
    assert not (tmp_path / "out/parameters.json").exists()


def recipe_of(folder: Path, text: str) -> Path:
    path = folder / "recipe.toml"
    path.write_text(text)
    return path


Split = Literal["all", "train", "held_out"]


def outcome(*rows: RmseRow) -> Outcome:
    verdict = VerdictRecord(level="good", sentence="Fine.")
    return Outcome("Test", verdict, rmse=RmseRecord(rows=rows))


def row(quantity: str, rmse: float, split: Split = "all", against: str = "motion") -> RmseRow:
    return RmseRow(
        quantity=quantity, unit="N", stage="after", reference=against, split=split, rmse=rmse, n=9
    )  # fmt: skip


@pytest.mark.parametrize(
    ("gates", "missed"),
    [
        ({"max_rmse": {"force *": 0.9}}, ""),
        ({"max_rmse": {"force *": 0.4}}, "force a: RMSE"),
        ({"max_rmse": {"forces *": 9.0}}, "judges nothing here"),
        ({"max_rmse": {"vgrf": 9.0}}, "vgrf: RMSE"),
        ({"verdicts": ["bad"]}, "verdict good; allowed: bad"),
        ({"verdicts": ["good", "warning"]}, ""),
    ],
)
def test_gates_judge_the_worst_of_a_quantity(gates: dict[str, object], missed: str) -> None:
    # held-out errors count where there are some
    rows = (row("force a", 0.1), row("force a", 0.5, "held_out"), row("vgrf", 9.5))
    options = CommandOptions(gates=Gates.model_validate_json(json.dumps(gates)))
    found = gated(outcome(*rows), options, {}, None)
    assert bool(found.gates_missed) == bool(missed)
    assert missed in "".join(found.gates_missed)


def test_gates_judge_what_the_verdict_quotes() -> None:
    rows = (row("vgrf", 9.0), row("vgrf", 0.1, against="baseline"))
    options = CommandOptions(gates=Gates(max_rmse={"vgrf": 1.0}))
    quoted = replace(outcome(*rows), reference="baseline")
    assert not gated(quoted, options, {}, None).gates_missed
    assert gated(replace(quoted, reference="motion"), options, {}, None).gates_missed


def test_gates_of_the_recipe_hold_where_there_is_such_a_quantity() -> None:
    shared = {"max_rmse": {"force *": 0.4, "cop": 1.0}}
    options = CommandOptions(gates=Gates.model_validate(merged(shared, {})))
    assert not gated(outcome(), options, shared, None).gates_missed
    missed = gated(outcome(row("force a", 0.5)), options, shared, None).gates_missed
    assert [line.split(":")[0] for line in missed] == ["force a"]
    own = Gates.model_validate(merged(shared, {"max_rmse": {"force *": 0.6}}))
    found = gated(outcome(row("force a", 0.5)), CommandOptions(gates=own), shared, None)
    assert not found.gates_missed


@pytest.mark.parametrize(
    ("line", "code", "words"),
    [
        ('max_rmse = { "force *" = 1e-9 }', 1, "force left_fl: RMSE"),
        ("max_change = { bias = 0.1 }", 1, "--reference"),
        ('max_rsme = { "force *" = 1.0 }', 2, "max_rmse"),
        ('verdicts = ["fine"]', 2, "verdicts"),
    ],
)
def test_gates_in_a_recipe(
    run: Run, log: Path, tmp_path: Path, line: str, code: int, words: str
) -> None:
    recipe = recipe_of(tmp_path, f"[offline_fit.gates]\n{line}\n")
    answer = run("offline-fit", log, "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == code, answer.err
    assert words in answer.err


def test_the_largest_change_against_a_reference(run: Run, log: Path, tmp_path: Path) -> None:
    assert run("offline-fit", log, "--out", tmp_path / "ref").exit_code == 0
    reference = tmp_path / "ref/parameters.json"
    again = ("offline-fit", log, "--reference", reference)
    assert run(*again, "--out", tmp_path / "same").exit_code == 0
    record = json.loads(reference.read_text())
    record["parameters"]["left_fl.bias"]["value"] += 0.5
    moved = tmp_path / "moved.json"
    moved.write_text(json.dumps(record))
    answer = run("offline-fit", log, "--reference", moved, "--out", tmp_path / "sd")
    assert answer.exit_code == 1
    assert "left_fl.bias: change against the reference" in answer.err
    for limit, code in ((0.6, 0), (0.4, 1)):
        recipe = recipe_of(
            tmp_path,
            f'[offline_fit.gates]\nmax_change = {{ bias = {limit} }}\nreference = "moved.json"\n',
        )
        out = tmp_path / f"units{limit}"
        answer = run("offline-fit", log, "--recipe", recipe, "--out", out)
        assert answer.exit_code == code, answer.err
        assert (out / "parameters_rejected.json").exists() == bool(code)
    rejected = tmp_path / "units0.4/parameters_rejected.json"
    assert run("offline-fit", log, "--reference", rejected, "--out", tmp_path / "r").exit_code == 2


def test_a_diagnosis_can_be_gated(run: Run, log: Path, tmp_path: Path) -> None:
    for allowed, code in (("underpowered", 0), ("none", 1)):
        recipe = recipe_of(tmp_path, f'[diagnose.gates]\ndiagnoses = ["{allowed}"]\n')
        answer = run(
            "diagnose", log, "--recipe", recipe, "--experiment", "weights", "--no-pictures",
            "--out", tmp_path / allowed,
        )  # fmt: skip
        assert answer.exit_code == code, answer.err + answer.out


def test_columns_are_read_aloud(run: Run, log: Path, tmp_path: Path) -> None:
    rows = [line.split(",") for line in LOG.splitlines()[1:]]
    foreign = tmp_path / "grams.csv"
    foreign.write_text(
        "channel,m,raw\n" + "".join(f"{c},{1000 * float(n) / 9.80665},{s}\n" for c, n, s in rows)
    )
    unit = '[columns]\ncounts = "raw"\nload_n = { column = "m", unit = "%s" }\n'
    recipe = recipe_of(tmp_path, unit % "g")
    out = tmp_path / "out"
    answer = run("offline-fit", foreign, "--recipe", recipe, "--out", out)
    assert answer.exit_code == 0, answer.err
    assert "'m' read as gram" in answer.out
    assert "N (load_n)" in answer.out
    (columns,) = json.loads((out / "run.json").read_text())["read_as"].values()
    (load,) = [c for c in columns if c["name"] == "load_n"]
    largest_n = max(float(n) for _, n, _ in rows)
    assert load["as_written"][1] == pytest.approx(1000 * largest_n / 9.80665)
    assert load["as_read"][1] == pytest.approx(largest_n)
    assert "Columns as read" in (out / "report.html").read_text("utf-8")
    recipe = recipe_of(tmp_path, unit % "gr")
    grain = run("offline-fit", foreign, "--recipe", recipe, "--out", tmp_path / "grain")
    assert grain.exit_code == 2
    assert "gram" in grain.err


def calibration() -> ParametersRecord:
    return ParametersRecord(
        command="online-replay", created="", robot="A", gravity_mps2=9.81, sign_convention="",
        frame="", expressed_at="", parameters={},
    )  # fmt: skip


@pytest.mark.parametrize(
    ("before", "after", "good"),
    [
        ((50.0, 10.0), (5.0, 24.0), False),  # the total gained, the swinging feet did not
        ((50.0, 10.0), (5.0, 11.0), True),
        ((0.001, 0.001), (0.002, 0.002), True),  # too small to matter
        ((5.0, 5.0), (4.0, 1.0), True),
    ],
)
def test_what_got_worse_on_any_quantity_is_no_good_fit(
    before: tuple[float, float], after: tuple[float, float], good: bool
) -> None:
    names = ("vgrf", "left.fx")
    was = [row(n, e) for n, e in zip(names, before, strict=True)]
    rows = [one.model_copy(update={"stage": "before"}) for one in was]
    rows += [row(n, e) for n, e in zip(names, after, strict=True)]
    found = trusted(replace(outcome(*rows), parameters=calibration()))
    assert (found.verdict.level == "good") is found.usable is good
    assert [f.where for f in found.findings] == ([] if good else ["left.fx"])
    # a diagnosis and a command without a calibration have nothing to reject
    assert trusted(outcome(*rows)).usable


def test_a_fit_that_did_not_converge_is_not_good() -> None:
    found = trusted(replace(outcome(), parameters=calibration(), usable=False))
    assert found.verdict.level == "bad"


@pytest.mark.parametrize("code", ["stuck_channel", "leg_elsewhere"])
def test_no_command_starts_from_a_fit_to_a_frozen_channel_or_a_leg_elsewhere(code: str) -> None:
    wrong = Finding(code, "alarm", "fl", "the readings cannot be right", "look")
    found = trusted(replace(outcome(), parameters=calibration(), findings=(wrong,)))
    assert not found.usable
    assert found.verdict.sentence == "fl: the readings cannot be right."


def test_what_is_wrong_with_the_wiring_stands_before_what_follows_from_it() -> None:
    follows = Finding("negative_leg_weight", "alarm", "fl", "the leg weighs -1 N", "look")
    wrong = Finding("axis_turned", "alarm", "fl.fx", "fx reads with the sign reversed", "turn it")
    given = replace(outcome(), parameters=calibration(), findings=(follows, wrong), usable=False)
    found = trusted(given).verdict
    assert found.sentence == "fl.fx: fx reads with the sign reversed."
    assert found.actions == ("Turn it.",)
    assert found.details[0] == given.verdict.sentence


def test_a_jump_without_a_sure_size_is_no_alarm() -> None:
    assert BiasJump("left_fl.bias", 1.0, 1.5, 2.0, 0.3, 40.0).sure
    assert not BiasJump("left_fl.bias", 1.0, 1.5, -2.0, 0.9, 40.0).sure


def test_a_jump_that_the_whole_walk_refutes_is_none() -> None:
    """The proof saw 0.6 N; before and after it the smoother has 0.02 N between, or 0.55 N."""
    jump = BiasJump("left_fl.bias", 5.0, 5.1, 0.6, 0.05, 40.0, least=0.5)
    time_s = np.arange(200) / 20.0
    for step, kept in ((0.02, 0), (0.55, 1)):
        values = np.where(time_s < 5.0, 0.0, step)[:, None]
        smoothed = SimpleNamespace(
            names=("left_fl.bias",), time_s=time_s, values=values, sd=np.full((200, 1), 0.01)
        )
        assert len(sized_jumps([jump], cast(Track, smoothed))) == kept


@pytest.mark.parametrize(("name", "doubted"), [("robot.smoothing", True), ("left_fl.gain", False)])
def test_a_motion_beyond_what_was_thought_possible_is_not_good(name: str, doubted: bool) -> None:
    found = left_interval(LeftInterval(name, "s²", 3.0, 4e-3, -1.5e-3, 1.5e-3))
    assert found.severity == "warning"
    assert (found.code in DOUBTFUL) == doubted
    assert ("hysteresis" in found.remedy) != doubted, "a cell with a loop has no scale in a walk"


def test_every_command_that_judges_data_has_strict_findings() -> None:
    """`docs/ci.md` says which have not, and why."""
    without = {"convert", "export", "init", "effects", "schema"}
    for name in COMMANDS:
        options = {option for p in get_command(_one(name)).params for option in p.opts}
        assert ("--strict-findings" in options) == (name not in without), name


def _one(name: str) -> typer.Typer:
    one = typer.Typer(add_completion=False)
    one.command(name)(function_of(name))
    return one


def test_a_walk_that_turns_a_scale_over_is_bad() -> None:
    gain = np.array([0.2, -0.4, -2.0, 1.5, np.nan])
    found = tuple(check_gains(("a", "b", "c", "d", "e"), gain))
    assert [(f.where, f.severity) for f in found] == [(c, "alarm") for c in "cde"]
    judged = trusted(replace(outcome(), parameters=calibration(), findings=found))
    assert (judged.verdict.level, judged.usable) == ("bad", False)
