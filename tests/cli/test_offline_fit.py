"""``footcal offline-fit`` on the published weights and on faulty input, as the shell runs it."""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord, RmseRecord, RunRecord
from footcal_cli.tables.table import write_parquet
from tests.conftest import Run, drawing

G = 9.80665


@pytest.fixture
def recipe(repository: Path) -> Path:
    return repository / "recipes/nao_table2.toml"


def test_table_2_reproduces_the_paper_in_newtons(run: Run, recipe: Path, tmp_path: Path) -> None:
    answer = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    record = read_record(ParametersRecord, tmp_path / "out/parameters.json")
    printed = recipe.parent.parent / "sample_data/nao_table2/printed_coefficients.csv"
    with printed.open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 8
    for row in rows:
        scale = record.parameters[f"{row['channel']}.scale"]
        bias = record.parameters[f"{row['channel']}.bias"]
        assert (scale.unit, bias.unit) == ("N/count", "N")
        assert scale.value / G == pytest.approx(float(row["scale_kg_per_count"]), rel=1e-8)
        assert bias.value / G == pytest.approx(float(row["bias_kg"]), rel=1e-8)


def test_table_2_is_not_believed_blindly(run: Run, recipe: Path, tmp_path: Path) -> None:
    answer = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out")
    assert "does not fit 7 of the 8 channels" in answer.out
    assert "31 % of the load" in answer.out
    assert "same sign in all 8 channels" in answer.out
    assert "exactly the same raw reading" in answer.out
    assert "→ Run next: a ladder" in answer.out
    codes = {f.code for f in read_record(RunRecord, tmp_path / "out/run.json").findings}
    assert codes == {"readings_repeat_across_channels", "offset_binary", "extrapolation"}


def test_strict_findings_and_gates_end_with_1(run: Run, recipe: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    strict = run("offline-fit", "--recipe", recipe, "--out", out, "--strict-findings")
    assert strict.exit_code == 1
    assert "affine_inadequate" in strict.err
    assert (out / "report.html").exists(), "a missed gate still leaves the whole run folder"
    gate = ["offline-fit", "--recipe", recipe, "--out", out, "--overwrite", "--max-rmse-n"]
    assert run(*gate, "0.01").exit_code == 1
    assert run(*gate, "1").exit_code == 0


def test_the_run_folder_is_complete(run: Run, recipe: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with drawing():
        run("offline-fit", "--recipe", recipe, "--out", out, "--quiet")
    names = {p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file()}
    assert names == {
        "run.json", "parameters.json", "predictions.parquet", "rmse.json", "rmse.csv",
        "report.html",
        "figures/residuals.png", "figures/loads_against_counts.png", "figures/scales.png",
    }  # fmt: skip
    rmse = read_record(RmseRecord, out / "rmse.json")
    after = {row.quantity: row.rmse for row in rmse.rows if row.stage == "after"}
    # METHODS: residuals 9.6, 0.2, 15.5, 5.7 g of left_rl
    expected = G * 1e-3 * ((9.6**2 + 0.2**2 + 15.5**2 + 5.7**2) / 4) ** 0.5
    assert after["force left_rl"] == pytest.approx(expected, rel=0.01)
    html = (out / "report.html").read_text(encoding="utf-8")
    assert html.count("data:image/png;base64,") == 3
    assert not re.search(r"<link|src=\"http", html), "the report is one self-contained file"
    assert html.index("does not fit") < html.index("Table 1. Calibration") < html.index("<figure")
    run_record = read_record(RunRecord, out / "run.json")
    assert run_record.rows == {next(iter(run_record.inputs)): 32}


def test_hostile_names_do_not_break_the_report(run: Run, tmp_path: Path) -> None:
    log = tmp_path / "w.csv"
    log.write_text("channel,load_n,counts\n<b>[x],0,1\n<b>[x],1,90\n<b>[x],2,200\n")
    answer = run("offline-fit", log, "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    html = (tmp_path / "out/report.html").read_text(encoding="utf-8")
    assert "<b>[x]" not in html
    assert "&lt;b&gt;[x]" in html


GOOD = "channel,load_kg,counts\na,0,100\na,1,200\na,2,300\n"


def faulty(folder: Path, name: str) -> tuple[list[str], int, tuple[str, ...]]:
    """Arguments, exit code and words of the error line for each kind of bad input."""
    log = folder / "w.csv"
    log.write_text(GOOD)
    recipe = folder / "r.toml"
    out = ["--out", str(folder / "out")]

    def text(content: str) -> list[str]:
        log.write_text(content)
        return ["offline-fit", str(log), *out]

    def with_recipe(content: str) -> list[str]:
        recipe.write_text(content)
        return ["offline-fit", str(log), "--recipe", str(recipe), *out]

    if name == "missing file":
        return ["offline-fit", str(folder / "no.csv"), *out], 2, ("no.csv", "no such file")
    if name == "no log at all":
        return ["offline-fit", *out], 2, ("no weights log",)
    if name == "empty file":
        return text(""), 3, ("w.csv", "empty")
    if name == "text cell":
        return text(GOOD + "a,3,4oo\n"), 3, ("w.csv", "counts", "line 5", "'4oo'")
    if name == "NaN":
        return text(GOOD + "a,NaN,400\n"), 3, ("w.csv", "load_kg", "line 5", "kg")
    if name == "missing column":
        return text("channel,load_kg,reading\na,0,1\n"), 3, ("w.csv", "'counts'", "[columns]")
    if name == "unknown unit":
        return (
            with_recipe("[columns]\nload_n={column='load_kg', unit='stone_f'}\n"),
            2,
            ("stone_f",),
        )
    if name == "one load":
        return text("channel,load_kg,counts\na,1,5\na,1,6\n"), 3, ("a", "two distinct loads")
    if name == "constant channel":
        return text("channel,load_kg,counts\na,0,5\na,1,5\n"), 3, ("a", "never changes")
    if name == "duplicate channels":
        return with_recipe("[robot]\nchannels=['a','a']\n"), 2, ("r.toml", "'a' is named twice")
    if name == "misspelt key":
        return with_recipe("[offline_fit]\nmetod='robust'\n"), 2, ("metod", "'method'")
    if name == "misspelt value":
        return with_recipe("[offline_fit]\nmethod='robst'\n"), 2, ("method", "robst")
    if name == "output folder in use":
        (folder / "out").mkdir()
        (folder / "out/thesis.txt").write_text("keep me")
        return ["offline-fit", str(log), *out], 2, ("not empty", "--overwrite")
    assert name == "truncated Parquet"
    whole = folder / "w.parquet"
    write_parquet(pd.DataFrame({"channel": ["a"] * 99, "load_n": 1.0, "counts": 1}), whole)
    whole.write_bytes(whole.read_bytes()[:-30])
    return ["offline-fit", str(whole), *out], 3, ("w.parquet", "truncated")


@pytest.mark.parametrize(
    "name",
    [
        "missing file", "no log at all", "empty file", "text cell", "NaN", "missing column",
        "unknown unit", "one load", "constant channel", "duplicate channels", "misspelt key",
        "misspelt value", "output folder in use", "truncated Parquet",
    ],
)  # fmt: skip
def test_bad_input_is_one_line_and_leaves_nothing(run: Run, tmp_path: Path, name: str) -> None:
    arguments, exit_code, words = faulty(tmp_path, name)
    before = {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()}
    answer = run(*arguments)
    assert answer.exit_code == exit_code, answer.err
    line, _, _example = answer.err.partition("for example:\n")
    assert line.count("\n") == 1
    assert answer.err.startswith("footcal: error: ")
    for word in words:
        assert word in answer.err, answer.err
    assert {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()} == before


def test_an_internal_error_is_70_without_a_traceback(
    run: Run, recipe: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise RuntimeError("no such luck")

    monkeypatch.setattr("footcal_cli.sheets.bench.pooled_curvature", broken)
    arguments = ["offline-fit", "--recipe", recipe, "--out", tmp_path / "out"]
    answer = run(*arguments)
    assert answer.exit_code == 70
    assert "no such luck" in answer.err
    assert "Traceback" not in answer.err
    assert not (tmp_path / "out").exists()
    with pytest.raises(RuntimeError):
        run(*arguments, "--debug")


def test_an_interrupted_overwrite_keeps_the_old_run(
    run: Run, recipe: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    run("offline-fit", "--recipe", recipe, "--out", out)
    old = (out / "parameters.json").read_bytes()

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("footcal_cli.session.run_files.render_html", interrupted)
    answer = run("offline-fit", "--recipe", recipe, "--out", out, "--overwrite")
    assert answer.exit_code == 130
    assert (out / "parameters.json").read_bytes() == old
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_check_gives_the_findings_alone(run: Run, recipe: Path, tmp_path: Path) -> None:
    answer = run("check", "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 0
    assert "exactly the same raw reading" in answer.out
    assert not (tmp_path / "out/parameters.json").exists()
    strict = run("check", "--recipe", recipe, "--out", tmp_path / "b", "--strict-findings")
    assert strict.exit_code == 1


def test_schema_prints_a_json_schema(run: Run) -> None:
    assert "parameters" in run("schema").out.split()
    assert json.loads(run("schema", "parameters").out)["title"] == "ParametersRecord"
    assert run("schema", "paramters").exit_code == 2


def test_module_and_script_answer_alike_and_start_light() -> None:
    """Help must not import the heavy libraries: that is what keeps it under a second."""
    code = (
        "import sys; sys.argv=['footcal','--help']\n"
        "import runpy\n"
        "try: runpy.run_module('footcal_cli', run_name='__main__')\n"
        "except SystemExit as end: assert not end.code\n"
        "heavy = {'numpy','scipy','pandas','pyarrow','matplotlib','pint','jinja2'}\n"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "offline-fit" in done.stdout


def test_an_unknown_command_is_a_usage_error(run: Run) -> None:
    assert run("offlin-fit").exit_code == 2


def weighed(path: Path, seed: int) -> Path:
    """A cell under known weights, as a converter of 24 bits reads it."""
    rng = np.random.default_rng(seed)
    load = np.tile([0.0, 1.0, 2.0, 3.0, 4.0], 4)
    counts = 8_400_000.0 - 290_000.0 * load + 900.0 * rng.normal(size=load.size)
    table = {"channel": "left_fl", "load_kg": load, "counts": np.round(counts)}
    pd.DataFrame(table).to_csv(path, index=False)
    return path


def test_an_earlier_calibration_counts_as_prior_once(
    run: Run, recipe: Path, tmp_path: Path
) -> None:
    logs = [weighed(tmp_path / f"weights_{seed}.csv", seed) for seed in (1, 2)]
    fit = ("offline-fit", "--recipe", recipe, "--models", "affine", "--no-pictures")
    first, second, both = (tmp_path / name for name in ("first", "second", "both"))
    for log, out in zip(logs, (first, second), strict=True):
        assert run(*fit, log, "--out", out).exit_code == 0
    earlier = ("--parameters", first / "parameters.json", "--prior")
    answer = run(*fit, logs[1], *earlier, "--out", both)
    assert answer.exit_code == 0, answer.err
    found = [
        read_record(ParametersRecord, out / "parameters.json").parameters["left_fl.scale"]
        for out in (first, second, both)
    ]
    values, sds = [f.value for f in found], [f.sd or 0.0 for f in found]
    assert min(values[:2]) < values[2] < max(values[:2])
    # the precisions of independent recordings add up
    assert sds[2] ** -2 == pytest.approx(sds[0] ** -2 + sds[1] ** -2, rel=0.02)

    again = run(*fit, logs[0], *earlier, "--out", tmp_path / "again")
    assert "would count twice" in again.out
    kept = read_record(ParametersRecord, tmp_path / "again/parameters.json")
    assert kept.parameters["left_fl.scale"].sd == pytest.approx(sds[0])
    missing = run(*fit, logs[0], "--prior", "--out", tmp_path / "missing")
    assert missing.exit_code == 2
    assert "--parameters" in missing.err
