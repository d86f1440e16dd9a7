"""What a command imports before it does its work: no help and no refusal waits for a library."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import REPOSITORY

HEAVY = (
    "matplotlib", "pandas", "pint", "pyarrow", "scipy.ndimage", "scipy.optimize", "scipy.signal",
    "scipy.spatial", "scipy.special", "scipy.stats",
)  # fmt: skip
_COUNTED = """
import json, sys
from footcal_cli.app import main
brought = {}
for words in json.load(sys.stdin):
    before = set(sys.modules)
    try:
        main(words)
    except SystemExit as end:
        code = end.code
    heavy = [n for n in HEAVY if n in sys.modules and n not in before]
    brought[" ".join(words)] = [code, heavy]
sys.stderr.write("\\n" + json.dumps(brought))
"""


def brought(asked: list[list[str]], folder: Path) -> dict[str, tuple[int, list[str]]]:
    """Command lines, run one after the other in one fresh Python -> exit code, heavy imports."""
    done = subprocess.run(
        [sys.executable, "-c", f"HEAVY = {HEAVY!r}\n{_COUNTED}"],
        input=json.dumps(asked), capture_output=True, text=True, check=True, cwd=folder,
        env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
    )  # fmt: skip
    return {k: (v[0], v[1]) for k, v in json.loads(done.stderr.splitlines()[-1]).items()}


RUNS = (
    "offline-fit", "apply", "check", "diagnose", "static-init", "hang-calib", "pose-calib",
    "simulate", "kinematics", "online-replay", "convert",
)  # fmt: skip


def test_help_and_refusals_import_nothing_heavy(tmp_path: Path) -> None:
    (tmp_path / "r.toml").write_text("no_such_option_zz = 1\n")
    (tmp_path / "used").mkdir()
    (tmp_path / "used" / "notes.txt").write_text("mine")
    asked = [["--help"], ["--version"], ["no-such-command"], ["schema", "no_such_record"]]
    for name in RUNS:
        asked += [
            [name, "--help"],
            [name, "--out", "used"],
            [name, "--out", "new", "--recipe", "nope.toml"],
            [name, "--out", "new", "--recipe", "r.toml"],
            [name, "--out", "new", "nope.csv"],
            [name, "--out", "new"],
        ]
    answers = brought(asked, tmp_path)
    assert {words: heavy for words, (_, heavy) in answers.items() if heavy} == {}
    codes = {words: code for words, (code, _) in answers.items()}
    wrong = {w: c for w, c in codes.items() if c != (0 if "--help" in w or "--version" in w else 2)}
    assert wrong == {}


@pytest.mark.parametrize(
    ("head", "code"), [("channel,load_kg,counts", 0), ("channel,laod_lb,counts", 3)]
)
def test_the_check_of_a_small_log_and_its_refusal_bring_little(
    head: str, code: int, tmp_path: Path
) -> None:
    rows = [head, *(f"left_fl,{load},{8347750 - 293000 * load}" for load in (0, 1, 2, 5, 10))]
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n")
    words = ["check", "log.csv", "--out", "run", "--quiet", "--no-pictures"]
    ended, heavy = brought([words], tmp_path)[" ".join(words)]
    assert ended == code
    assert set(heavy) <= {"pandas", "pyarrow"}


@pytest.mark.parametrize("log", ["sample_data/bench_foot/weights.csv"])
def test_the_check_of_a_small_log_reads_and_writes_without_the_rest(
    log: str, tmp_path: Path, repository: Path
) -> None:
    words = ["check", str(repository / log), "--out", "run", "--quiet", "--no-pictures"]
    code, heavy = brought([words], tmp_path)[" ".join(words)]
    assert code == 0
    assert set(heavy) <= {"pandas", "pyarrow"}


@pytest.mark.parametrize(
    "log",
    [pytest.param("nao_table2/weights.csv", marks=pytest.mark.slow), "bench_foot/weights.csv"],
)
def test_a_run_without_figures_loads_neither_drawing_nor_all_of_statistics(
    log: str, tmp_path: Path, repository: Path
) -> None:
    words = [
        "offline-fit", str(repository / "sample_data" / log), "--out", "run", "--no-pictures",
        "--quiet",
    ]  # fmt: skip
    code, heavy = brought([words], tmp_path)[" ".join(words)]
    assert code == 0
    assert not {"matplotlib", "scipy.stats", "scipy.signal"} & set(heavy)
    assert not list((tmp_path / "run/figures").iterdir())
    assert "<img" not in (tmp_path / "run/report.html").read_text(encoding="utf-8")
