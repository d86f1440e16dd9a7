"""What issues said of commit 6403e2b, turned round: each test fails there.

Only the command line is used (`footcal_cli.app.main`, which is there too), so that the same file
runs on an old version: with its interpreter,
``python -m pytest -c /dev/null --rootdir . -p no:cacheprovider test_turned_round.py``.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

CELLS = [f"{foot}_{cell}" for foot in ("left", "right") for cell in ("fl", "fr", "rl", "rr")]
SCALE, ZERO = -3.41e-5, 8.32e6
BIPED = (
    '[robot]\nname = "biped"\nmass_kg = 5.3\n[robot.nameplate]\nscale_n_per_count = -3.41e-5\n'
    "zero_counts = 8.32e6\nscale_relative_sd = 0.02\nbias_sd_n = 0.3\n"
    + "".join(
        f"[robot.feet.{foot}.cells]\n"
        "fl = { x_m = 0.07, y_m = 0.03 }\nfr = { x_m = 0.07, y_m = -0.03 }\n"
        "rl = { x_m = -0.05, y_m = 0.03 }\nrr = { x_m = -0.05, y_m = -0.03 }\n"
        for foot in ("left", "right")
    )
)
HOOKED = """
import os, runpy, signal, sys
event, match, number, deed = sys.argv[1:5]
seen = 0
def hook(name, arguments):
    global seen
    if name == event and match in str(arguments[0] if arguments else ""):
        seen += 1
        if seen == int(number):
            if deed == "memory":
                raise MemoryError
            os.kill(os.getpid(), getattr(signal, deed))
sys.addaudithook(hook)
sys.argv = ["footcal", *sys.argv[5:]]
runpy.run_module("footcal_cli", run_name="__main__", alter_sys=True)
"""


def footcal(*words: object) -> subprocess.CompletedProcess[str]:
    """A command line, in this process: what a process of its own imports is not the subject."""
    from footcal_cli.app import main

    line, code = [str(word) for word in words], 0
    with (
        contextlib.redirect_stdout(io.StringIO()) as out,
        contextlib.redirect_stderr(io.StringIO()) as err,
    ):
        try:
            main(line)
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else int(end.code is not None)
    return subprocess.CompletedProcess(line, code, out.getvalue(), err.getvalue())


def forked(words: Sequence[object], hook: Sequence[object] = ("", "", 0, "")) -> int:
    """A command line in a process of its own, which need not import all again; its number."""
    child = os.fork()
    if child:
        return child
    code = 70
    try:
        sys.argv = ["-c", *map(str, hook), *map(str, words)]
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            exec(HOOKED, {})
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    finally:
        os._exit(code)


def ended(child: int, within_s: float = 120.0) -> int:
    """The exit code of a process that may not hang; negative: the signal that killed it."""
    until = time.monotonic() + within_s
    while time.monotonic() < until:
        number, status = os.waitpid(child, os.WNOHANG)
        if number:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.02)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    raise AssertionError(f"no end within {within_s} s")


def interrupted(event: str, match: str, words: Sequence[object]) -> tuple[int, str]:
    """Exit code and message of a fresh interpreter with an interrupt at the first such event."""
    line = [sys.executable, "-c", HOOKED, event, match, "1", "SIGINT", *map(str, words)]
    done = subprocess.run(line, capture_output=True, text=True, timeout=120, check=False)
    return done.returncode, done.stderr


def level(out: Path) -> str:
    found: dict[str, Any] = json.loads((out / "run.json").read_text("utf-8"))
    return str(found["verdict"]["level"])


def bench(
    path: Path, channels: Sequence[str] = ("left_fl",), gain: float = 1.0, seed: int = 1
) -> Path:
    """Weights on single cells, up and down twice; loads are written times `gain`."""
    rng = np.random.default_rng(seed)
    load = np.tile([0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.0], 4)
    rows = [
        pd.DataFrame(
            {"channel": name, "load_n": gain * load,
             "counts": np.rint(ZERO + (load + 0.02 * rng.standard_normal(load.size)) / SCALE)}
        )
        for name in channels
    ]  # fmt: skip
    pd.concat(rows).astype({"counts": int}).to_csv(path, index=False)
    return path


@pytest.fixture(scope="module")
def biped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recipe, a calibration of its bench, and a simulated stand and walk."""
    folder = tmp_path_factory.mktemp("biped")
    recipe = folder / "biped.toml"
    recipe.write_text(BIPED, "utf-8")
    asked = ("--recipe", recipe, "--quiet", "--out")
    log = bench(folder / "weights.csv", CELLS)
    assert footcal("offline-fit", log, *asked, folder / "fit").returncode == 0
    done = footcal("simulate", "--experiment", "stand", *asked, folder / "stand")
    assert done.returncode == 0, done.stderr
    done = footcal("simulate", "--experiment", "walk", "--duration-s", 20, *asked, folder / "walk")
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def hanging(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulated hexapod that hangs four ways, and its recipe."""
    folder = tmp_path_factory.mktemp("hexapod")
    legs = {"fl": (0.22, 0.14), "ml": (0.0, 0.16), "hl": (-0.22, 0.14)}
    text = '[robot]\nname = "hexapod"\nmass_kg = 8.18\n'
    for name, (x, y) in legs.items():
        other = name[0] + "r"
        text += f"[robot.legs.{name}]\nposition_m = [{x}, {y}, 0.0]\n"
        text += f"[robot.legs.{other}]\nposition_m = [{x}, {-y}, 0.0]\n"
        text += "rotation_rpy_rad = [0.0, 0.0, 3.141592653589793]\n"
    (folder / "hexapod.toml").write_text(text + "[simulate]\ncycles = 2\n", "utf-8")
    asked = ("--recipe", folder / "hexapod.toml", "--quiet", "--out", folder / "hang")
    done = footcal("simulate", "--experiment", "hang", *asked)
    assert done.returncode == 0, done.stderr
    return folder


def test_a_log_that_no_table_takes_ends_the_command(tmp_path: Path) -> None:
    good, other = bench(tmp_path / "good.csv"), bench(tmp_path / "day4.csv", seed=2)
    other.write_text(other.read_text("utf-8").replace("counts", "cuonts"), "utf-8")
    done = footcal("offline-fit", good, other, "--quiet", "--out", tmp_path / "out")
    assert done.returncode != 0
    assert "day4.csv" in done.stderr


def test_a_canonical_name_misspelt_in_columns_ends_the_command(tmp_path: Path) -> None:
    log, recipe = bench(tmp_path / "weights.csv"), tmp_path / "cell.toml"
    recipe.write_text('[columns]\ncoutns = "ADC"\n', "utf-8")
    done = footcal("offline-fit", log, "--recipe", recipe, "--quiet", "--out", tmp_path / "out")
    assert done.returncode == 2


def test_stamps_of_a_parquet_file_are_seconds_or_refused(biped: Path, tmp_path: Path) -> None:
    cells = pd.read_parquet(biped / "walk" / "cells.parquet")
    cells["time_s"] = pd.to_datetime("2026-01-05") + pd.to_timedelta(cells["time_s"], unit="s")
    cells.to_parquet(tmp_path / "cells.parquet")
    done = footcal(
        "apply", tmp_path / "cells.parquet", "--recipe", biped / "biped.toml", "--parameters",
        biped / "fit" / "parameters.json", "--quiet", "--out", tmp_path / "out",
    )  # fmt: skip
    if done.returncode:
        return
    made = [pd.read_parquet(path) for path in (tmp_path / "out").glob("*.parquet")]
    spans = [float(np.ptp(frame["time_s"])) for frame in made if "time_s" in frame]
    assert spans
    assert all(abs(span - 20.0) < 0.1 for span in spans)


@pytest.mark.parametrize("gain", [1 / 9.80665, 1e3 / 9.80665, -1.0])
def test_loads_in_another_unit_or_turned_are_no_good_calibration(
    tmp_path: Path, gain: float
) -> None:
    log, recipe = bench(tmp_path / "weights.csv", CELLS, gain), tmp_path / "biped.toml"
    recipe.write_text(BIPED, "utf-8")
    footcal("offline-fit", log, "--recipe", recipe, "--quiet", "--out", tmp_path / "out")
    assert level(tmp_path / "out") != "good"


def test_apply_compares_forces_with_the_weight(biped: Path, tmp_path: Path) -> None:
    turned = (biped / "fit" / "parameters.json").read_text("utf-8")
    record = json.loads(turned)
    for name, one in record["parameters"].items():
        if name.endswith((".scale", ".bias")):
            one["value"] *= -1.0
    (tmp_path / "turned.json").write_text(json.dumps(record), "utf-8")
    done = footcal(
        "apply", biped / "walk" / "cells.parquet", "--recipe", biped / "biped.toml",
        "--parameters", tmp_path / "turned.json", "--quiet", "--out", tmp_path / "out",
    )  # fmt: skip
    assert done.returncode or level(tmp_path / "out") == "bad"


@pytest.mark.parametrize("factor", [-1.0, 1 / 9.80665])
def test_a_turned_wrench_and_kilograms_force_are_no_good_hanging(
    hanging: Path, tmp_path: Path, factor: float
) -> None:
    log = pd.read_parquet(hanging / "hang" / "hang.parquet")
    log = log[log["leg"].isin(["fl", "fr"])]  # one of each side
    for name in ("fx_n", "fy_n", "fz_n"):
        log[name] *= factor
    log.to_parquet(tmp_path / "hang.parquet")
    asked = ("--recipe", hanging / "hexapod.toml", "--quiet", "--out", tmp_path / "out")
    done = footcal("hang-calib", tmp_path / "hang.parquet", *asked)
    assert done.returncode == 3 or level(tmp_path / "out") != "good"


def test_check_sees_eight_end_codes(biped: Path, tmp_path: Path) -> None:
    cells = pd.read_parquet(biped / "walk" / "cells.parquet")
    cells.loc[[200, 300, 400, 500, 600, 700, 800, 900], "left_fr_counts"] = -8388608
    cells.to_parquet(tmp_path / "cells.parquet")
    asked = ("--recipe", biped / "biped.toml", "--quiet", "--out", tmp_path / "out")
    footcal("check", tmp_path / "cells.parquet", *asked)
    assert level(tmp_path / "out") != "good"


def test_a_dead_cell_is_bad_data(biped: Path, tmp_path: Path) -> None:
    cells = pd.read_parquet(biped / "walk" / "cells.parquet")
    cells["left_fl_counts"] = 8_320_000
    cells.to_parquet(tmp_path / "cells.parquet")
    footcal(
        "diagnose", tmp_path / "cells.parquet", biped / "walk" / "body.parquet",
        "--experiment", "walk", "--recipe", biped / "biped.toml", "--quiet",
        "--parameters", biped / "fit" / "parameters.json", "--out", tmp_path / "out",
    )  # fmt: skip
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text("utf-8"))
    assert found["verdict"] == "bad-data"


def test_overwrite_deletes_no_input(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert footcal("offline-fit", bench(tmp_path / "w.csv"), "--out", out).returncode == 0
    log = bench(out / "day2.csv", seed=2)
    footcal("offline-fit", log, "--out", out, "--overwrite")
    assert log.is_file()


@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_kill_at_a_rename_leaves_a_result_under_its_name(tmp_path: Path, number: int) -> None:
    log, out = bench(tmp_path / "w.csv"), tmp_path / "runs" / "out"
    out.parent.mkdir()
    assert footcal("offline-fit", log, "--out", out).returncode == 0
    killed = ("os.rename", str(out.parent), number, "SIGKILL")
    ended(forked(["offline-fit", log, "--out", out, "--overwrite"], killed))
    assert (out / "run.json").is_file()


def test_two_writers_do_not_both_succeed(tmp_path: Path) -> None:
    log = bench(tmp_path / "w.csv")
    for race in range(3):
        out = tmp_path / f"out{race}"
        both = [forked(["offline-fit", log, "--out", out]) for _ in range(2)]
        assert [ended(one) for one in both] != [0, 0]


@pytest.mark.parametrize(("event", "match"), [("import", "numpy"), ("open", "weights_of_a_cell")])
def test_an_interrupt_is_130_and_one_sentence(tmp_path: Path, event: str, match: str) -> None:
    log = bench(tmp_path / "weights_of_a_cell.csv")
    code, told = interrupted(event, match, ["offline-fit", log, "--out", tmp_path / "out"])
    assert code == 130
    assert len(told.strip().splitlines()) == 1


def test_no_memory_is_no_missed_gate(tmp_path: Path) -> None:
    log = bench(tmp_path / "weights_of_a_cell.csv")
    words = ["offline-fit", log, "--out", tmp_path / "out"]
    assert ended(forked(words, ("open", log.name, 1, "memory"))) == 74


@pytest.mark.slow
def test_a_calibration_that_missed_its_gate_is_not_up_to_date(tmp_path: Path) -> None:
    log, out = bench(tmp_path / "w.csv"), tmp_path / "out"
    (tmp_path / "Makefile").write_text(
        f"{out}/parameters.json: {log}\n\t{sys.executable} -m footcal_cli offline-fit $< "
        f"--out {out} --overwrite --quiet --max-rmse-n 1e-6\n", "utf-8",
    )  # fmt: skip
    make = shutil.which("make")
    if make is None:
        pytest.skip("no make here")
    for _ in range(2):
        done = subprocess.run([make], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode != 0


def _late_byte(folder: Path) -> list[object]:
    log = bench(folder / "w.csv", CELLS * 40)
    log.write_bytes(log.read_bytes() + b"left_fl,1,\xff\n")
    return ["offline-fit", log]


def _huge(folder: Path) -> list[object]:
    log = bench(folder / "w.csv")
    log.write_text(log.read_text("utf-8").replace("20.0", "1e308"), "utf-8")
    return ["offline-fit", log]


def _folder_as_recipe(folder: Path) -> list[object]:
    return ["offline-fit", bench(folder / "w.csv"), "--recipe", folder]


def _deep(folder: Path) -> list[object]:
    (folder / "p.json").write_text("[" * 100_000 + "]" * 100_000, "utf-8")
    return ["offline-fit", bench(folder / "w.csv"), "--parameters", folder / "p.json"]


@pytest.mark.parametrize("cause", [_late_byte, _huge, _folder_as_recipe, _deep])
def test_an_ordinary_cause_is_no_internal_error(tmp_path: Path, cause: Any) -> None:
    done = footcal(*cause(tmp_path), "--quiet", "--out", tmp_path / "out")
    assert done.returncode in (0, 1, 2, 3)


def test_a_tower_of_powers_ends(tmp_path: Path) -> None:
    log, recipe = bench(tmp_path / "w.csv"), tmp_path / "r.toml"
    recipe.write_text('[columns]\ntime_s = { column = "counts", unit = "s**9**9**9" }\n', "utf-8")
    asked = ("--recipe", recipe, "--quiet", "--out", tmp_path / "out")
    assert ended(forked(["offline-fit", log, *asked]), within_s=30) == 2


def test_shuffled_rows_of_a_hanging_end(hanging: Path, tmp_path: Path) -> None:
    log = pd.read_parquet(hanging / "hang" / "hang.parquet").sample(frac=1.0, random_state=1)
    log.to_parquet(tmp_path / "hang.parquet", index=False)
    asked = ("--recipe", hanging / "hexapod.toml", "--quiet", "--out", tmp_path / "out")
    assert ended(forked(["hang-calib", tmp_path / "hang.parquet", *asked]), within_s=90) == 3


def test_the_same_rows_under_another_name_are_counted_once(tmp_path: Path) -> None:
    log = bench(tmp_path / "w.csv")
    shutil.copy(log, tmp_path / "copy.csv")
    sds = []
    for logs in ([log], [log, tmp_path / "copy.csv"]):
        out = tmp_path / f"out{len(logs)}"
        assert footcal("offline-fit", *logs, "--quiet", "--out", out).returncode == 0
        found = json.loads((out / "parameters.json").read_text("utf-8"))["parameters"]
        sds.append(found["left_fl.scale"]["sd"])
    assert sds[1] == pytest.approx(sds[0], rel=1e-3)


def test_two_rows_are_no_good_calibration(tmp_path: Path) -> None:
    (tmp_path / "w.csv").write_text("channel,load_n,counts\na,0,8320000\na,10,8026745\n", "utf-8")
    done = footcal("offline-fit", tmp_path / "w.csv", "--quiet", "--out", tmp_path / "out")
    assert done.returncode or level(tmp_path / "out") != "good"


@pytest.mark.slow
def test_the_calibration_of_a_clean_bench_serves_the_next_command(
    biped: Path, tmp_path: Path
) -> None:
    asked = ("--recipe", biped / "biped.toml", "--quiet", "--out")
    done = footcal("simulate", "--experiment", "weights", *asked, tmp_path / "bench")
    assert done.returncode == 0, done.stderr
    log = tmp_path / "bench" / "weights.parquet"
    assert footcal("offline-fit", log, *asked, tmp_path / "fit").returncode == 0
    logs = [biped / "stand" / f"{name}.parquet" for name in ("cells", "body")]
    given = ("--parameters", tmp_path / "fit" / "parameters.json")
    assert footcal("static-init", *logs, *given, *asked, tmp_path / "out").returncode == 0
